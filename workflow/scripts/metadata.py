"""Describe the tables of a campaign: a data package."""

from pathlib import Path

import oilfilm.run.job as run
from oilfilm import studies
from oilfilm.atomic_write import write_text
from oilfilm.report.metadata import data_package

with run.job(snakemake) as job:
    studies.declare_tables(job.settings.campaign.studies)
    package = Path(snakemake.output.package)
    written = map(Path, (*snakemake.input.tables, *snakemake.input.samples))
    write_text(data_package(job.settings, package.parent, written), package)
