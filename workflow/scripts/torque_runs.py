"""Measure the steady plateaus of the torque logs."""

from pathlib import Path

from oilfilm import tables
from oilfilm.curation.torque_runs import measure_torque
from oilfilm.readers.raw_files import expected_digests, unchanged_logs
from oilfilm.run.job import job

with job(snakemake) as provenance:
    config = snakemake.params.config
    folder = Path("data/raw", f"{config['campaign']['name']}-torque")
    digests = expected_digests(snakemake.params.files, snakemake.input.get("listing"))
    runs, quarantine = measure_torque(unchanged_logs(folder, digests), config)
    tables.write(runs, "torque_runs", Path(snakemake.output.runs), provenance)
    tables.write(quarantine, "quarantine", Path(snakemake.output.quarantine), provenance)
