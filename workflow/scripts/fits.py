"""Bring the fits of all oils together."""

from pathlib import Path

from oilfilm import tables
from oilfilm.job import job

with job(snakemake) as provenance:
    for table, parts, whole in (
        ("coefficients", snakemake.input.coefficients, snakemake.output.coefficients),
        ("fit_quality", snakemake.input.quality, snakemake.output.quality),
    ):
        together = tables.read(table, *map(Path, parts))
        tables.write(together, table, Path(whole), provenance)
