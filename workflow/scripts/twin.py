"""Simulate the raw logs of a campaign whose truth is known."""

from pathlib import Path

import oilfilm.run.job as run
from oilfilm.paper.reference import printed_constants
from oilfilm.rig_twin.simulate import simulate_campaign, write_logs

with run.job(snakemake) as job:
    constants = printed_constants(Path(snakemake.input.printed))
    logs = simulate_campaign(job.settings, constants)
    write_logs(logs, "truth", snakemake.output, job.provenance)
