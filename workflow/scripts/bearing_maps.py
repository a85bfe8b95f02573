"""Ask the bearing for cage slip, the size effect and a published power loss."""

from pathlib import Path

from oilfilm import tables
from oilfilm.run.job import job
from oilfilm.settings.messages import load
from oilfilm.settings.reference import PublishedPowerLoss
from oilfilm.settings.resolved import Settings
from oilfilm.studies.bearing_torque import cage_slip_table, power_loss_table, size_effect_table
from oilfilm.studies.slip_advice import advise

with job(snakemake) as provenance:
    inputs, settings = snakemake.input, Settings.of(snakemake.params.config)
    coefficients = tables.read("coefficients", Path(inputs.coefficients))
    quality = tables.read("fit_quality", Path(inputs.quality))
    others = (
        tables.read("law_coefficients", Path(inputs.law_coefficients)),
        tables.read("law_fit_quality", Path(inputs.law_quality)),
    )
    published = load(Path(inputs.published), PublishedPowerLoss)
    cage_slip = cage_slip_table(coefficients, quality, settings)
    for table, frame in (
        ("cage_slip", cage_slip),
        ("slip_advice", advise(cage_slip, settings.selection, settings.gates.lambda_limit)),
        ("size_effect", size_effect_table(coefficients, quality, settings, others)),
        ("power_loss", power_loss_table(published, coefficients, quality, settings)),
    ):
        tables.write(frame, table, Path(snakemake.output[table]), provenance)
