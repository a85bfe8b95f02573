"""Write the report of a campaign, as a page and as text."""

from pathlib import Path

from oilfilm import studies
from oilfilm.atomic_write import write_text
from oilfilm.report.html import html
from oilfilm.report.sections.build import sections
from oilfilm.report.text import text
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables

with job(snakemake) as (settings, provenance):
    studies.declare_tables(settings.campaign.studies)
    inputs, outputs = snakemake.input, snakemake.output
    results = CampaignTables.of_job(inputs)
    made = sections(results, settings)
    write_text(text(made, settings.campaign), Path(outputs.summary))
    pngs = [Path(png) for png in inputs.png]
    page = html(made, results, pngs, Path(inputs.refused_pages), settings, provenance)
    write_text(page, Path(outputs.page))
