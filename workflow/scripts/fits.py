"""Join the tables of all oils."""

from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as (_, provenance):
    results = CampaignTables.of_job(snakemake.input)
    frames = {name: results.table(name) for name, _ in snakemake.output.items()}
    write_tables(frames, snakemake.output, provenance)
