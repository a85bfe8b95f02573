"""Simulate the torque logs of a demonstration campaign."""

from pathlib import Path

from oilfilm import tables
from oilfilm.job import job
from oilfilm.reference import printed_constants
from oilfilm.rig_twin.torque_logs import simulate_torque

with job(snakemake) as provenance:
    constants = printed_constants(Path(snakemake.input.printed))
    folder = Path(snakemake.output.logs)
    folder.mkdir(parents=True)
    truth = []
    for run, content, rows in simulate_torque(snakemake.params.config, constants):
        (folder / run.name).write_bytes(content)
        truth += rows
    frame = tables.from_rows(truth, "torque_truth")
    tables.write(frame, "torque_truth", Path(snakemake.output.truth), provenance)
