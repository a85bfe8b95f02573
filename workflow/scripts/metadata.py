"""Describe the tables of a campaign for other programs."""

from pathlib import Path

from oilfilm import studies, tables
from oilfilm.atomic_write import write_text
from oilfilm.report.metadata import data_package
from oilfilm.run.job import job
from oilfilm.tables.table_file import read_listing, table_file

with job(snakemake) as (settings, _):
    studies.declare_tables(settings.campaign.studies)
    package = Path(snakemake.output.package)
    files = []
    for path in map(Path, snakemake.input.tables):
        tables.refuse_damaged(path)
        files.append(table_file(path, package.parent))
    for path in map(Path, snakemake.input.listings):
        files += read_listing(path)
    write_text(data_package(settings, files), package)
