"""Compare all sign sets of the printed exponents with the paper's text."""

from pathlib import Path

from oilfilm.paper.printed.signs import study_signs
from oilfilm.paper.reference import falling_viscosity, printed_constants
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as (settings, provenance):
    printed = Path(snakemake.input.printed)
    signs, verdicts = study_signs(
        printed_constants(printed),
        falling_viscosity(printed),
        CampaignTables.of_job(snakemake.input).points,
        snakemake.params.oils,
        settings.printed,
        snakemake.params.traction_max,
    )
    write_tables({"signs": signs, "sign_verdicts": verdicts}, snakemake.output, provenance)
