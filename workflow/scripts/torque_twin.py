"""Simulate the torque logs of a demonstration campaign."""

from pathlib import Path

import oilfilm.run.job as run
from oilfilm.paper.reference import printed_constants
from oilfilm.rig_twin.torque_logs import simulate_torque

with run.job(snakemake) as job:
    constants = printed_constants(Path(snakemake.input.printed))
    simulated = simulate_torque(job.settings, constants)
    job.write_simulated(
        ((log.name, content, rows) for log, content, rows in simulated), "torque_truth"
    )
