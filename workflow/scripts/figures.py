"""Draw a family of figures, and write exactly what each shows as a table."""

from pathlib import Path

from oilfilm.paper.reference import read_reference
from oilfilm.report.figures.registry import draw_figures
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables

with job(snakemake) as (settings, provenance):
    inputs, outputs = snakemake.input, snakemake.output
    references = {path.stem: read_reference(path) for path in map(Path, inputs.references)}
    draw_figures(
        zip(outputs.png, outputs.svg, outputs.drawn, strict=True),
        CampaignTables.of_job(inputs),
        settings,
        references,
        provenance,
    )
