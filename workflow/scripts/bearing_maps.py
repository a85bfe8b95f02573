"""Calculate cage slip over speed and load, and the size effect."""

from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables
from oilfilm.torque.bearing_torque import cage_slip_table, oils_in_bearings, size_effect_table

with job(snakemake) as (settings, provenance):
    results = CampaignTables.of_job(snakemake.input)
    oils = oils_in_bearings(results.coefficients, results.fit_quality, settings, results.refits)
    frames = {
        "cage_slip": cage_slip_table(oils, settings),
        "size_effect": size_effect_table(oils, settings),
    }
    write_tables(frames, snakemake.output, provenance)
