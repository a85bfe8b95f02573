"""Compare measured torque with the fitted law for each load variable; say what that can show."""

import oilfilm.run.job as run
from oilfilm.torque.bearing_torque import oils_in_bearings, torque_table
from oilfilm.torque.torque_control import torque_control

with run.job(snakemake) as job:
    oils = oils_in_bearings(
        job.tables.coefficients, job.tables.fit_quality, job.settings, job.tables.refits
    )
    torque, inversion = torque_table(job.tables.torque_runs, oils, job.settings)
    control = torque_control(job.tables, job.settings)
    job.write({"torque": torque, "torque_inversion": inversion, "torque_control": control})
