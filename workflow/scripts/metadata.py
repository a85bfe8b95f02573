"""Describe the tables of a campaign for other programs."""

from pathlib import Path

from oilfilm.atomic_write import write_text
from oilfilm.outputs.metadata import (
    data_package,
    describe,
    linked_data,
    read_vocabulary,
    table_file,
)
from oilfilm.run.job import job

with job(snakemake) as provenance:
    output = snakemake.output
    folder = Path(output.package).parent
    files = [table_file(Path(path), folder) for path in snakemake.input.tables]
    vocabulary = read_vocabulary(Path(snakemake.input.vocabulary))
    dataset = describe(snakemake.params.config, files, vocabulary)
    write_text(data_package(dataset), Path(output.package))
    write_text(linked_data(dataset), Path(output.description))
    write_text(Path(snakemake.input.vocabulary).read_text("utf-8"), Path(output.vocabulary))
