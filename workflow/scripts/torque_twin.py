"""Simulate the torque logs of a demonstration campaign."""

from pathlib import Path

from oilfilm import tables
from oilfilm.atomic_write import atomic_folder, write_text
from oilfilm.logs.raw_files import listing
from oilfilm.paper.reference import printed_constants
from oilfilm.rig_twin.torque_logs import simulate_torque
from oilfilm.run.job import job

with job(snakemake) as (settings, provenance):
    constants = printed_constants(Path(snakemake.input.printed))
    truth = []
    with atomic_folder(Path(snakemake.output.logs)) as folder:
        for run, content, rows in simulate_torque(settings, constants):
            (folder / run.name).write_bytes(content)
            truth += rows
    write_text(listing(Path(snakemake.output.logs)), Path(snakemake.output.listing))
    frame = tables.from_rows(truth, "torque_truth")
    tables.write(frame, "torque_truth", Path(snakemake.output.truth), provenance)
