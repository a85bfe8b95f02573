"""Hold fitted laws against the truth of a simulated campaign."""

from pathlib import Path

from oilfilm import tables
from oilfilm.run.job import job
from oilfilm.settings.resolved import Settings
from oilfilm.studies.extrapolation import extrapolate, extrapolation_errors
from oilfilm.studies.law_comparison import laws_of

with job(snakemake) as provenance:
    inputs, outputs = snakemake.input, snakemake.output
    settings = Settings.of(snakemake.params.config)
    compared = extrapolate(
        tables.read("truth_grid", Path(inputs.truth)),
        tables.read("law_coefficients", Path(inputs.coefficients)),
        tables.read("law_refits", Path(inputs.refits)),
        tables.read("law_fit_quality", Path(inputs.quality)),
        settings.same_set_point.relative,
        {oil: laws_of(oil, settings) for oil in settings.oils},
    )
    tables.write(compared, "extrapolation", Path(outputs.compared), provenance)
    errors = extrapolation_errors(compared)
    tables.write(errors, "extrapolation_errors", Path(outputs.errors), provenance)
