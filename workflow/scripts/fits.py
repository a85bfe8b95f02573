"""Join the tables of all oils, and name the oil that an odd curve belongs to."""

from oilfilm.fits.odd_curves import with_likely_oils
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as (_, provenance):
    results = CampaignTables.of_job(snakemake.input)
    frames = {name: results.table(name) for name, _ in snakemake.output.items()}
    # the comparison of laws has no curves of its own
    if "curve_residuals" in frames:
        frames["curve_residuals"], frames["fit_quality"] = with_likely_oils(results, results.points)
    write_tables(frames, snakemake.output, provenance)
