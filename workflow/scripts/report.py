"""Write the report of a campaign."""

from pathlib import Path

from oilfilm import studies
from oilfilm.atomic_write import write_text
from oilfilm.report.page import page
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables

with job(snakemake) as (settings, provenance):
    studies.declare_tables(studies.available())
    inputs = snakemake.input
    text = page(
        CampaignTables.of_job(inputs),
        [Path(png) for png in inputs.png],
        Path(inputs.refused_pages),
        settings,
        provenance,
    )
    write_text(text, Path(snakemake.output.page))
