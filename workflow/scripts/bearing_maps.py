"""Ask the bearing for cage slip, the size effect and a published power loss."""

from pathlib import Path

from oilfilm import tables
from oilfilm.run.job import job
from oilfilm.settings.load import load_checked
from oilfilm.studies.bearing_torque import cage_slip_table, power_loss_table, size_effect_table
from oilfilm.studies.slip_advice import advise

with job(snakemake) as provenance:
    found, config = snakemake.input, snakemake.params.config
    coefficients = tables.read("coefficients", Path(found.coefficients))
    quality = tables.read("fit_quality", Path(found.quality))
    others = (
        tables.read("law_coefficients", Path(found.law_coefficients)),
        tables.read("law_fit_quality", Path(found.law_quality)),
    )
    published = load_checked(Path(found.published), "power_loss")
    cage_slip = cage_slip_table(coefficients, quality, config)
    for table, frame in (
        ("cage_slip", cage_slip),
        ("slip_advice", advise(cage_slip, config["selection"], config["gates"]["lambda_limit"])),
        ("size_effect", size_effect_table(coefficients, quality, config, others)),
        ("power_loss", power_loss_table(published, coefficients, quality, config)),
    ):
        tables.write(frame, table, Path(snakemake.output[table]), provenance)
