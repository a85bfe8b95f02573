"""Simulate the logs of the torque rig and the truth behind them."""

from pathlib import Path

import oilfilm.run.job as run
from oilfilm.paper.reference import printed_constants
from oilfilm.rig_twin.simulate import write_logs
from oilfilm.rig_twin.torque_logs import simulate_torque

with run.job(snakemake) as job:
    constants = printed_constants(Path(snakemake.input.printed))
    logs = simulate_torque(job.settings, constants)
    write_logs(logs, "torque_truth", snakemake.output, job.provenance)
