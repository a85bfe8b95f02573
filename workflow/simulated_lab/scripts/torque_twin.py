"""Simulate the logs of the torque rig and the truth behind them."""

from pathlib import Path

import oilfilm.run.job as run
from simulated_lab.printed import read_printed_constants
from simulated_lab.simulate import write_logs
from simulated_lab.torque_logs import simulate_torque

with run.job(snakemake) as job:
    constants_by_oil = read_printed_constants(Path(snakemake.input.printed))
    logs = simulate_torque(job.settings, constants_by_oil)
    write_logs(logs, "torque_truth", snakemake.output, job.provenance)
