"""Write the certificates down; end the run where a fit has none."""

from pathlib import Path

from oilfilm.atomic_write import write_text
from oilfilm.fits.certificate import certificates
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables

with job(snakemake) as (settings, _):
    quality = CampaignTables.of_job(snakemake.input).configured.fit_quality
    text = certificates(quality, settings.fit.allow_uncertified)
    write_text(text, Path(snakemake.output[0]))
