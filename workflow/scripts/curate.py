"""Find and judge the plateaus of one share of the runs."""

from oilfilm.curation.curate import curate
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as (settings, provenance):
    ingested = CampaignTables.of_job(snakemake.input)
    curated = curate(ingested.samples, ingested.runs, settings)
    write_tables(vars(curated), snakemake.output, provenance)
