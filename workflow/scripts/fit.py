"""Fit one law to one oil."""

from pathlib import Path

from oilfilm.fits.law_comparison import fit_law
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as (settings, provenance):
    oil, law = snakemake.wildcards.oil, snakemake.wildcards.law
    points = CampaignTables.of_job(snakemake.input).points
    fit = fit_law(points, oil, law, settings)
    write_tables(fit.tables, snakemake.output, provenance)
    with Path(snakemake.log[0]).open("a", encoding="utf-8") as log:
        log.write(f"{oil}, {law}: {fit.certificate}\n")
