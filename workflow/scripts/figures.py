"""Draw a family of figures, and write exactly what each shows as a table."""

from pathlib import Path

import oilfilm.run.job as run
from oilfilm.base import studies
from oilfilm.report.figures.sheet import draw_figures

# the tables of a study are known when its package is imported
studies.declare_tables(studies.available())

with run.job(snakemake) as job:
    inputs, outputs = snakemake.input, snakemake.output
    loaded = studies.load(studies.available()) if inputs.references else []
    references = {
        path.stem: study.read_reference(path)
        for path in map(Path, inputs.references)
        for study in loaded
    }
    draw_figures(
        zip(outputs.png, outputs.svg, outputs.drawn, strict=True),
        job.tables,
        job.settings,
        references,
        job.provenance,
    )
