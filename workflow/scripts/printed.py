"""Judge the printed constants beside the campaign's fit, and their signs by the paper's text."""

from pathlib import Path

from oilfilm.paper.printed.judge import judge_printed
from oilfilm.paper.printed.signs import study_signs
from oilfilm.paper.reference import falling_viscosity, printed_constants
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as (settings, provenance):
    results, path = CampaignTables.of_job(snakemake.input), Path(snakemake.input.printed)
    oils, constants = snakemake.params.oils, printed_constants(path)
    judged = judge_printed(
        results.points,
        results.configured.coefficients,
        results.configured.fit_quality,
        constants,
        oils,
        settings.printed,
        results.configured.refits,
    )
    signs, verdicts = study_signs(
        constants,
        falling_viscosity(path),
        results.points,
        oils,
        settings.printed,
        snakemake.params.traction_max,
    )
    frames = {"printed_judged": judged, "signs": signs, "sign_verdicts": verdicts}
    write_tables(frames, snakemake.output, provenance)
