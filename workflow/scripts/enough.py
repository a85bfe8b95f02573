"""Write down the certificates and the accepted runs; end the run where there are too few."""

from pathlib import Path

from oilfilm.atomic_write import write_text
from oilfilm.fits.certificate import certificates
from oilfilm.report.enough import accepted_runs_text
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables

with job(snakemake) as (settings, _):
    results = CampaignTables.of_job(snakemake.input)
    texts = {
        "certificates": certificates(
            results.configured.fit_quality, settings.fit.allow_uncertified
        ),
        "accepted_runs": accepted_runs_text(results, settings.campaign),
    }
    for name, text in texts.items():
        write_text(text, Path(snakemake.output[name]))
