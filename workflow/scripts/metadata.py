"""Describe the tables of a campaign: a data package."""

from pathlib import Path

import oilfilm.run.job as run
from oilfilm import studies
from oilfilm.atomic_write import write_text
from oilfilm.report.metadata import data_package
from oilfilm.tables.table_file import table_file

with run.job(snakemake) as job:
    studies.declare_tables(job.settings.campaign.studies)
    package = Path(snakemake.output.package)
    written = map(Path, (*snakemake.input.tables, *snakemake.input.samples))
    files = [table_file(path, package.parent) for path in written]
    write_text(data_package(job.settings, files), package)
