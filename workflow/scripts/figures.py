"""Draw the figures of one family, as `data` or `law`, and write what each shows as a table."""

from pathlib import Path

import oilfilm.run.job as run
from oilfilm.base import studies
from oilfilm.report.figures.sheet import draw_figures

# importing the package of a study declares its tables
studies.declare_tables(studies.available())

with run.job(snakemake) as job:
    inputs, outputs = snakemake.input, snakemake.output
    draw_figures(
        zip(outputs.png, outputs.svg, outputs.drawn, strict=True),
        job.input_tables,
        job.settings,
        studies.read_references(map(Path, inputs.references)),
        job.provenance,
    )
