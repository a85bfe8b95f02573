"""Simulate the logs of a demonstration campaign."""

from pathlib import Path

from oilfilm.paper.reference import printed_constants
from oilfilm.rig_twin.simulate import simulate_campaign, write_logs
from oilfilm.run.job import job

with job(snakemake) as (settings, provenance):
    constants = printed_constants(Path(snakemake.input.printed))
    write_logs(simulate_campaign(settings, constants), "truth", snakemake.output, provenance)
