"""Simulate the logs of a demonstration campaign."""

from pathlib import Path

import oilfilm.run.job as run
from oilfilm.paper.reference import printed_constants
from oilfilm.rig_twin.simulate import simulate_campaign

with run.job(snakemake) as job:
    constants = printed_constants(Path(snakemake.input.printed))
    simulated = simulate_campaign(job.settings, constants)
    job.write_simulated(((log.name, content, [row]) for log, content, row in simulated), "truth")
