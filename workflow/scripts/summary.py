"""Write the one-screen summary of a campaign."""

from pathlib import Path

from oilfilm import studies
from oilfilm.atomic_write import write_text
from oilfilm.report.summary import summarise
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables

with job(snakemake) as (settings, _):
    studies.declare_tables(studies.available())
    text = summarise(CampaignTables.of_job(snakemake.input), settings)
    write_text(text, Path(snakemake.output[0]))
