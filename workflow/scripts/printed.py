"""Judge the printed constants beside the campaign's fit."""

from pathlib import Path

from oilfilm.paper.printed.judge import judge_printed
from oilfilm.paper.reference import printed_constants
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as (settings, provenance):
    results = CampaignTables.of_job(snakemake.input)
    judged = judge_printed(
        results.points,
        results.coefficients,
        results.fit_quality,
        printed_constants(Path(snakemake.input.printed)),
        snakemake.params.oils,
        settings.printed,
        results.refits,
    )
    write_tables({"printed_judged": judged}, snakemake.output, provenance)
