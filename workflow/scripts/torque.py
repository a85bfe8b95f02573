"""Compare measured torque with the fitted law for each load variable."""

from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables
from oilfilm.torque.bearing_torque import oils_in_bearings, torque_table

with job(snakemake) as (settings, provenance):
    results = CampaignTables.of_job(snakemake.input)
    other_fits = results.law_coefficients, results.law_fit_quality, results.law_refits
    coefficients, refits = results.coefficients, results.refits
    oils = oils_in_bearings(coefficients, results.fit_quality, settings, other_fits, refits)
    torque, inversion = torque_table(results.torque_runs, oils, settings)
    write_tables({"torque": torque, "torque_inversion": inversion}, snakemake.output, provenance)
