"""Hold all sign sets of the printed exponents against the paper's text."""

from pathlib import Path

from oilfilm import tables
from oilfilm.run.job import job
from oilfilm.settings.reference import falling_viscosity, printed_constants
from oilfilm.settings.resolved import Settings
from oilfilm.studies.printed.signs import study_signs

with job(snakemake) as provenance:
    inputs, outputs = snakemake.input, snakemake.output
    printed = Path(inputs.printed)
    points = tables.read("points", Path(inputs.points))
    signs, verdicts = study_signs(
        printed_constants(printed),
        falling_viscosity(printed),
        points,
        snakemake.params.oils,
        Settings.of(snakemake.params.config).printed,
        snakemake.params.traction_max,
    )
    tables.write(signs, "signs", Path(outputs.signs), provenance)
    tables.write(verdicts, "sign_verdicts", Path(outputs.verdicts), provenance)
