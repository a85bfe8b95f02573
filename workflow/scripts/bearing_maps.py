"""Ask the bearing for cage slip, the size effect and a published power loss."""

from pathlib import Path

from oilfilm.run.job import job
from oilfilm.settings.messages import load
from oilfilm.settings.reference import PublishedPowerLoss
from oilfilm.settings.resolved import Settings
from oilfilm.studies.bearing_torque import cage_slip_table, power_loss_table, size_effect_table
from oilfilm.studies.slip_advice import advise
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as provenance:
    results = CampaignTables.of_job(snakemake.input)
    settings = Settings.of(snakemake.params.config)
    published = load(Path(snakemake.input.published), PublishedPowerLoss)
    fits = results.coefficients, results.fit_quality, settings
    others = results.law_coefficients, results.law_fit_quality
    cage_slip = cage_slip_table(*fits)
    frames = {
        "cage_slip": cage_slip,
        "slip_advice": advise(cage_slip, settings.selection, settings.gates.lambda_limit),
        "size_effect": size_effect_table(*fits, others),
        "power_loss": power_loss_table(published, *fits),
    }
    write_tables(frames, snakemake.output, provenance)
