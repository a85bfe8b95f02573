"""Simulate the logs of a demonstration campaign."""

from pathlib import Path

from oilfilm import tables
from oilfilm.job import job
from oilfilm.reference import printed_constants
from oilfilm.rig_twin.campaign import simulate_campaign

with job(snakemake) as provenance:
    constants = printed_constants(Path(snakemake.input.printed))
    folder = Path(snakemake.output.logs)
    folder.mkdir(parents=True)
    truth = []
    for run, content, row in simulate_campaign(snakemake.params.config, constants):
        (folder / run.name).write_bytes(content)
        truth.append(row)
    frame = tables.from_rows(truth, "truth")
    tables.write(frame, "truth", Path(snakemake.output.truth), provenance)
