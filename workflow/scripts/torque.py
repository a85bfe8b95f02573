"""Compare measured torque with the fitted law; answer at the points that the campaign names."""

import oilfilm.run.job as run
from oilfilm.base import studies
from oilfilm.torque.answers import campaign_answers
from oilfilm.torque.bearing_torque import oils_in_bearings, oils_with_uncertainty, torque_table
from oilfilm.torque.heat_balance import heat_balance_table
from oilfilm.torque.torque_control import torque_control_table

# Declare the simulator's tables, if there is a simulator: simulated logs have a truth table.
studies.declare_tables([studies.simulator()])

with run.job(snakemake) as job:
    coefficients, quality = job.input_tables.coefficients, job.input_tables.fit_quality
    settings = job.settings
    oils = oils_with_uncertainty(job.input_tables, settings)
    torque, inversion = torque_table(job.input_tables.torque_runs, oils, settings)
    # Without refits the calculation is faster; the heat balance states no uncertainty.
    oils_without_draws = oils_in_bearings(coefficients, quality, settings)
    job.write(
        {
            "torque": torque,
            "torque_inversion": inversion,
            **campaign_answers(oils, settings),
            "torque_control": torque_control_table(job.input_tables, settings),
            "heat_balance": heat_balance_table(
                oils_without_draws, job.input_tables.cage_slip, torque, settings
            ),
        }
    )
