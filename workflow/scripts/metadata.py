"""Describe the tables of a campaign for other programs."""

import shutil
from pathlib import Path

from oilfilm.job import job
from oilfilm.metadata import data_package, describe, linked_data, read_vocabulary, table_file

with job(snakemake) as provenance:
    output = snakemake.output
    folder = Path(output.package).parent
    files = [table_file(Path(path), folder) for path in snakemake.input.tables]
    vocabulary = read_vocabulary(Path(snakemake.input.vocabulary))
    dataset = describe(snakemake.params.config, files, vocabulary)
    Path(output.package).write_text(data_package(dataset), encoding="utf-8")
    Path(output.description).write_text(linked_data(dataset), encoding="utf-8")
    shutil.copyfile(snakemake.input.vocabulary, output.vocabulary)
