"""Calculate cage slip over speed and load, and the size effect."""

import oilfilm.run.job as run
from oilfilm.torque.bearing_torque import cage_slip_table, oils_in_bearings, size_effect_table

with run.job(snakemake) as job:
    oils = oils_in_bearings(
        job.tables.coefficients,
        job.tables.fit_quality,
        job.settings,
        job.tables.refits,
        job.tables.surfaces,
    )
    job.write(
        {
            "cage_slip": cage_slip_table(oils, job.settings),
            "size_effect": size_effect_table(oils, job.settings),
        }
    )
