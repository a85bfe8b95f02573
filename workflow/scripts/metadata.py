"""Describe the tables of a campaign: a data package."""

from pathlib import Path

from oilfilm import studies
from oilfilm.atomic_write import write_text
from oilfilm.report.metadata import data_package
from oilfilm.run.job import job
from oilfilm.tables.table_file import table_file

with job(snakemake) as (settings, _):
    studies.declare_tables(settings.campaign.studies)
    package = Path(snakemake.output.package)
    written = map(Path, (*snakemake.input.tables, *snakemake.input.samples))
    files = [table_file(path, package.parent) for path in written]
    write_text(data_package(settings, files), package)
