"""Draw the figures and keep exactly what each draws."""

from pathlib import Path

from oilfilm import tables
from oilfilm.figures import FIGURES, Results, style
from oilfilm.job import job

with job(snakemake) as provenance:
    found = snakemake.input
    results = Results(
        tables.read("points", Path(found.points)),
        tables.read("runs", Path(found.runs)),
        tables.read("coefficients", Path(found.coefficients)),
        tables.read("coverage", Path(found.coverage)),
        tables.read("extrapolation", *map(Path, found.extrapolation)),
        tables.read("signs", Path(found.signs)),
        tables.read("sign_verdicts", Path(found.sign_verdicts)),
        tables.read("claims", Path(found.claims)),
        tables.read("selection", Path(found.selection)),
        tables.read("comparison", Path(found.comparison)),
        tables.read("law_coefficients", Path(found.law_coefficients)),
    )
    made = snakemake.output
    for name, png, svg, kept in zip(
        snakemake.params.figures, made.png, made.svg, made.drawn, strict=True
    ):
        drawing = FIGURES[name]
        figure, drawn = drawing.draw(results, snakemake.params.config)
        tables.write(drawn, drawing.table, Path(kept), provenance)
        style.save(figure, Path(png), Path(svg))
