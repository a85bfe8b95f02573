"""Hold fitted laws against the truth of a simulated campaign."""

from pathlib import Path

from oilfilm import tables
from oilfilm.extrapolation import extrapolate, extrapolation_errors
from oilfilm.fitting.compare import laws_of
from oilfilm.job import job

with job(snakemake) as provenance:
    found, made = snakemake.input, snakemake.output
    compared = extrapolate(
        tables.read("truth_grid", Path(found.truth)),
        tables.read("law_coefficients", Path(found.coefficients)),
        tables.read("law_refits", Path(found.refits)),
        tables.read("law_fit_quality", Path(found.quality)),
        {oil: laws_of(oil, snakemake.params.config) for oil in snakemake.params.config["oils"]},
    )
    tables.write(compared, "extrapolation", Path(made.compared), provenance)
    errors = extrapolation_errors(compared)
    tables.write(errors, "extrapolation_errors", Path(made.errors), provenance)
