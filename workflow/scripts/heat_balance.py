"""Calculate how the oil's own heating changes torque, cage slip and the best oil."""

import oilfilm.run.job as run
from oilfilm.torque.bearing_torque import oils_in_bearings
from oilfilm.torque.heat_balance import heat_balance_table

with run.job(snakemake) as job:
    oils = oils_in_bearings(job.tables.coefficients, job.tables.fit_quality, job.settings)
    table = heat_balance_table(oils, job.tables.cage_slip, job.tables.torque, job.settings)
    job.write({"heat_balance": table})
