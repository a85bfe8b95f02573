"""Describe the tables of a campaign for other programs."""

import json
from pathlib import Path

from oilfilm import tables
from oilfilm.atomic_write import write_text
from oilfilm.outputs.metadata import data_package
from oilfilm.run.job import job
from oilfilm.tables.table_file import TableFile, table_file

with job(snakemake) as (settings, _):
    package = Path(snakemake.output.package)
    files = []
    for path in map(Path, snakemake.input.tables):
        tables.refuse_damaged(path)
        files.append(table_file(path, package.parent))
    for path in map(Path, snakemake.input.listings):
        files += [TableFile(**each) for each in json.loads(path.read_text(encoding="utf-8"))]
    write_text(data_package(settings, files), package)
