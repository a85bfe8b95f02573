"""Measure the steady plateaus of the torque logs."""

from pathlib import Path

from oilfilm import tables
from oilfilm.bearing.torque_runs import measure_torque
from oilfilm.ingest import read_bytes
from oilfilm.job import job

with job(snakemake) as provenance:
    config = snakemake.params.config
    folder = Path("data/raw", f"{config['campaign']['name']}-torque")
    logs = ((file, read_bytes(folder / file)) for file in snakemake.params.files)
    runs, quarantine = measure_torque(logs, config)
    tables.write(runs, "torque_runs", Path(snakemake.output.runs), provenance)
    tables.write(quarantine, "quarantine", Path(snakemake.output.quarantine), provenance)
