"""Fit all laws of the comparison to one oil."""

from pathlib import Path

from oilfilm import tables
from oilfilm.run.job import job
from oilfilm.settings.resolved import Settings
from oilfilm.studies.law_comparison import compare_laws

with job(snakemake) as provenance:
    points = tables.read("points", Path(snakemake.input.points))
    compared = compare_laws(points, snakemake.wildcards.oil, Settings.of(snakemake.params.config))
    for table, rows in compared.tables().items():
        tables.write(rows, table, Path(snakemake.output[table]), provenance)
    with Path(snakemake.log[0]).open("a", encoding="utf-8") as log:
        log.writelines(f"{line}\n" for line in compared.remarks())
