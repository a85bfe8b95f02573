"""Calculate how the oil's own heating changes torque, cage slip and the best oil."""

from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables
from oilfilm.torque.bearing_torque import oils_in_bearings
from oilfilm.torque.heat_balance import heat_balance_table

with job(snakemake) as (settings, provenance):
    results = CampaignTables.of_job(snakemake.input)
    oils = oils_in_bearings(results.coefficients, results.fit_quality, settings)
    table = heat_balance_table(oils, results.cage_slip, results.torque, settings)
    write_tables({"heat_balance": table}, snakemake.output, provenance)
