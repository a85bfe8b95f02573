"""Draw a family of figures, and write exactly what each shows as a table."""

from pathlib import Path

import oilfilm.run.job as run
from oilfilm.paper.reference import read_reference
from oilfilm.report.figures.sheet import draw_figures

with run.job(snakemake) as job:
    inputs, outputs = snakemake.input, snakemake.output
    references = {path.stem: read_reference(path) for path in map(Path, inputs.references)}
    draw_figures(
        zip(outputs.png, outputs.svg, outputs.drawn, strict=True),
        job.tables,
        job.settings,
        references,
        job.provenance,
    )
