"""Simulate the torque logs of a demonstration campaign."""

from pathlib import Path

from oilfilm.paper.reference import printed_constants
from oilfilm.rig_twin.simulate import write_logs
from oilfilm.rig_twin.torque_logs import simulate_torque
from oilfilm.run.job import job

with job(snakemake) as (settings, provenance):
    constants = printed_constants(Path(snakemake.input.printed))
    write_logs(simulate_torque(settings, constants), "torque_truth", snakemake.output, provenance)
