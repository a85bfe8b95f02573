"""Draw the figures of the bearing and keep exactly what each draws."""

from pathlib import Path

from oilfilm import tables
from oilfilm.figures import style
from oilfilm.figures.bearing import FIGURES, BearingResults
from oilfilm.job import job

with job(snakemake) as provenance:
    found = snakemake.input
    results = BearingResults(
        tables.read("torque_runs", Path(found.runs)),
        tables.read("torque", Path(found.torque)),
        tables.read("cage_slip", Path(found.cage_slip)),
        tables.read("size_effect", Path(found.size_effect)),
        tables.read("power_loss", Path(found.power_loss)),
    )
    made = snakemake.output
    for name, png, svg, kept in zip(
        snakemake.params.figures, made.png, made.svg, made.drawn, strict=True
    ):
        drawing = FIGURES[name]
        figure, drawn = drawing.draw(results, snakemake.params.config)
        tables.write(drawn, drawing.table, Path(kept), provenance)
        style.save(figure, Path(png), Path(svg))
