"""Compare measured torque with the fitted law on each basis."""

from oilfilm.run.job import job
from oilfilm.settings.resolved import Settings
from oilfilm.studies.bearing_torque import torque_table
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as provenance:
    results = CampaignTables.of_job(snakemake.input)
    torque, inversion = torque_table(
        results.torque_runs,
        results.coefficients,
        results.fit_quality,
        Settings.of(snakemake.params.config),
        (results.law_coefficients, results.law_fit_quality),
    )
    write_tables({"torque": torque, "torque_inversion": inversion}, snakemake.output, provenance)
