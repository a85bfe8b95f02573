"""Describe the tables of a campaign for other programs."""

from pathlib import Path

from oilfilm.atomic_write import write_text
from oilfilm.outputs.metadata import data_package, table_file
from oilfilm.run.job import job

with job(snakemake) as (settings, _):
    package = Path(snakemake.output.package)
    files = [table_file(Path(path), package.parent) for path in snakemake.input.tables]
    write_text(data_package(settings, files), package)
