"""Calculate cage slip over speed and load, and the size effect."""

import oilfilm.run.job as run
from oilfilm.torque.bearing_torque import cage_slip_table, oils_with_uncertainty, size_effect_table

with run.job(snakemake) as job:
    oils = oils_with_uncertainty(job.input_tables, job.settings)
    job.write(
        {
            "cage_slip": cage_slip_table(oils, job.settings),
            "size_effect": size_effect_table(oils, job.settings),
        }
    )
