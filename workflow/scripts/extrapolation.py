"""Hold fitted laws against the truth of a simulated campaign."""

from pathlib import Path

from oilfilm import tables
from oilfilm.run.job import job
from oilfilm.studies.extrapolation import extrapolate, extrapolation_errors
from oilfilm.studies.law_comparison import laws_of

with job(snakemake) as provenance:
    found, made, config = snakemake.input, snakemake.output, snakemake.params.config
    compared = extrapolate(
        tables.read("truth_grid", Path(found.truth)),
        tables.read("law_coefficients", Path(found.coefficients)),
        tables.read("law_refits", Path(found.refits)),
        tables.read("law_fit_quality", Path(found.quality)),
        config["same_set_point"]["relative"],
        {oil: laws_of(oil, config) for oil in config["oils"]},
    )
    tables.write(compared, "extrapolation", Path(made.compared), provenance)
    errors = extrapolation_errors(compared)
    tables.write(errors, "extrapolation_errors", Path(made.errors), provenance)
