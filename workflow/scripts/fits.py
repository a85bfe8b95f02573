"""Join the fits of all oils and laws, and judge the configured law beside the others."""

from oilfilm.fits.finished import finished_fits
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as (settings, provenance):
    results = CampaignTables.of_job(snakemake.input)
    write_tables(finished_fits(results, settings), snakemake.output, provenance)
