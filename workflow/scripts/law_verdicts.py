"""Set the configured law beside the best of those compared, and its misfit beside the noise."""

from oilfilm.fits.best_law import best_laws
from oilfilm.fits.noise import noise_and_misfit
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as (settings, provenance):
    results = CampaignTables.of_job(snakemake.input)
    judged = {
        "law_verdicts": best_laws(
            results.fit_quality, results.comparison, results.law_points, results.points
        ),
        "lack_of_fit": noise_and_misfit(results, settings),
    }
    write_tables(judged, snakemake.output, provenance)
