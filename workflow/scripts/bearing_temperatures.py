"""Calculate cage slip over speed and load at further oil temperatures."""

import oilfilm.run.job as run
from oilfilm.torque.bearing_torque import cage_slip_by_temperature_table, oils_with_uncertainty

with run.job(snakemake) as job:
    oils = oils_with_uncertainty(job.input_tables, job.settings)
    by_temperature = cage_slip_by_temperature_table(oils, job.settings)
    job.write({"cage_slip_by_temperature": by_temperature})
