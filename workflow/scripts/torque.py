"""Compare measured torque with the fitted law; calculate what the oil's own heating changes."""

import oilfilm.run.job as run
from oilfilm.torque.bearing_torque import oils_in_bearings, torque_table
from oilfilm.torque.heat_balance import heat_balance_table
from oilfilm.torque.torque_control import torque_control

with run.job(snakemake) as job:
    fits, settings = (job.tables.coefficients, job.tables.fit_quality), job.settings
    oils = oils_in_bearings(*fits, settings, job.tables.refits)
    torque, inversion = torque_table(job.tables.torque_runs, oils, settings)
    control = torque_control(job.tables, settings)
    # without draws: the balance has no uncertainty
    fitted = oils_in_bearings(*fits, settings)
    heat = heat_balance_table(fitted, job.tables.cage_slip, torque, settings)
    frames = {"torque": torque, "torque_inversion": inversion, "torque_control": control}
    job.write({**frames, "heat_balance": heat})
