"""Draw one figure and keep exactly what it draws."""

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
    )
    drawing = FIGURES[snakemake.wildcards.figure]
    figure, drawn = drawing.draw(results, snakemake.params.config)
    tables.write(drawn, drawing.table, Path(snakemake.output.drawn), provenance)
    style.save(figure, Path(snakemake.output.png), Path(snakemake.output.svg))
