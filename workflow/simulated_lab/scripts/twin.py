"""Simulate the raw logs of a campaign whose truth is known."""

from pathlib import Path

import oilfilm.run.job as run
from simulated_lab.printed import read_printed_constants
from simulated_lab.simulate import simulate_campaign, write_logs

with run.job(snakemake) as job:
    constants_by_oil = read_printed_constants(Path(snakemake.input.printed))
    logs = simulate_campaign(job.settings, constants_by_oil)
    write_logs(logs, "truth", snakemake.output, job.provenance)
