"""Draw one figure of the bearing and keep exactly what it draws."""

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
    draw, table = FIGURES[snakemake.wildcards.bearing_figure]
    figure, drawn = draw(results, snakemake.params.config)
    tables.write(drawn, table, Path(snakemake.output.drawn), provenance)
    style.save(figure, Path(snakemake.output.png), Path(snakemake.output.svg))
