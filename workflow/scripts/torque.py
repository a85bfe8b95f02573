"""Compare measured torque with the fitted law on each basis."""

from pathlib import Path

from oilfilm import tables
from oilfilm.run.job import job
from oilfilm.studies.bearing_torque import torque_table

with job(snakemake) as provenance:
    found = snakemake.input
    torque, inversion = torque_table(
        tables.read("torque_runs", Path(found.runs)),
        tables.read("coefficients", Path(found.coefficients)),
        tables.read("fit_quality", Path(found.quality)),
        snakemake.params.config,
        (
            tables.read("law_coefficients", Path(found.law_coefficients)),
            tables.read("law_fit_quality", Path(found.law_quality)),
        ),
    )
    tables.write(torque, "torque", Path(snakemake.output.torque), provenance)
    tables.write(inversion, "torque_inversion", Path(snakemake.output.inversion), provenance)
