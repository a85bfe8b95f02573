"""Draw the figures of one family, as `data` or `law`, and write what each shows as a table."""

from pathlib import Path

import oilfilm.run.job as run
from oilfilm.base import studies
from oilfilm.report.figures.sheet import draw_figures

# importing the package of a study declares its tables
studies.declare_tables(studies.available())

with run.job(snakemake) as job:
    inputs, outputs = snakemake.input, snakemake.output
    # a study is imported only where a figure has a reference file
    loaded_studies = studies.load_studies(studies.available()) if inputs.references else []
    reference_by_name = {}
    for file in inputs.references:
        for study in loaded_studies:
            reference_by_name[Path(file).stem] = study.read_reference(Path(file))
    draw_figures(
        zip(outputs.png, outputs.svg, outputs.drawn, strict=True),
        job.input_tables,
        job.settings,
        reference_by_name,
        job.provenance,
    )
