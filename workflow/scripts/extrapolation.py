"""Hold fitted laws against the truth of a simulated campaign."""

from pathlib import Path

from oilfilm import tables
from oilfilm.extrapolation import extrapolate, extrapolation_errors
from oilfilm.job import job

with job(snakemake) as provenance:
    found, made = snakemake.input, snakemake.output
    compared = extrapolate(
        tables.read("truth_grid", Path(found.truth)),
        tables.read("coefficients", Path(found.coefficients)),
        tables.read("refits", Path(found.refits)),
        tables.read("fit_quality", Path(found.quality)),
    )
    tables.write(compared, "extrapolation", Path(made.compared), provenance)
    errors = extrapolation_errors(compared)
    tables.write(errors, "extrapolation_errors", Path(made.errors), provenance)
