"""Find and judge the plateaus of one share of the runs."""

from oilfilm.curation.curate import curate
from oilfilm.run.job import job
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as provenance:
    ingested = CampaignTables.of_job(snakemake.input)
    settings = Settings.of(snakemake.params.config)
    curated = curate(ingested.samples, ingested.runs, settings)
    write_tables(vars(curated), snakemake.output, provenance)
