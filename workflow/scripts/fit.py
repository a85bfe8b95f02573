"""Fit the configured law to one oil."""

from pathlib import Path

from oilfilm import tables
from oilfilm.fitting.fit import fit_oil
from oilfilm.job import job
from oilfilm.reference import printed_constants

with job(snakemake) as provenance:
    oil = snakemake.wildcards.oil
    points = tables.read("points", Path(snakemake.input.points))
    printed = printed_constants(Path(snakemake.input.printed)).get(oil)
    coefficients, quality = fit_oil(points, oil, printed, snakemake.params.config)
    tables.write(coefficients, "coefficients", Path(snakemake.output.coefficients), provenance)
    tables.write(quality, "fit_quality", Path(snakemake.output.quality), provenance)
