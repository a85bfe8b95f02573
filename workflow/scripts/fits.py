"""Bring the fits of all oils together."""

from pathlib import Path

from oilfilm import tables
from oilfilm.run.job import job

with job(snakemake) as provenance:
    for table, whole in snakemake.output.items():
        together = tables.read(table, *map(Path, snakemake.input[table]))
        tables.write(together, table, Path(whole), provenance)
