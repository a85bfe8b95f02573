"""Compare measured torque with the fitted law for each load variable; say what that can show."""

from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables
from oilfilm.torque.bearing_torque import oils_in_bearings, torque_table
from oilfilm.torque.torque_control import torque_control

with job(snakemake) as (settings, provenance):
    results = CampaignTables.of_job(snakemake.input)
    oils = oils_in_bearings(results.coefficients, results.fit_quality, settings, results.refits)
    torque, inversion = torque_table(results.torque_runs, oils, settings)
    frames = {
        "torque": torque,
        "torque_inversion": inversion,
        "torque_control": torque_control(results.replace(torque=torque), settings),
    }
    write_tables(frames, snakemake.output, provenance)
