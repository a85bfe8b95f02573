"""Compare measured torque with the fitted law on each basis."""

from pathlib import Path

from oilfilm import tables
from oilfilm.run.job import job
from oilfilm.settings.resolved import Settings
from oilfilm.studies.bearing_torque import torque_table

with job(snakemake) as provenance:
    inputs = snakemake.input
    torque, inversion = torque_table(
        tables.read("torque_runs", Path(inputs.runs)),
        tables.read("coefficients", Path(inputs.coefficients)),
        tables.read("fit_quality", Path(inputs.quality)),
        Settings.of(snakemake.params.config),
        (
            tables.read("law_coefficients", Path(inputs.law_coefficients)),
            tables.read("law_fit_quality", Path(inputs.law_quality)),
        ),
    )
    tables.write(torque, "torque", Path(snakemake.output.torque), provenance)
    tables.write(inversion, "torque_inversion", Path(snakemake.output.inversion), provenance)
