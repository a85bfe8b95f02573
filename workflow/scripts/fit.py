"""Fit the configured law to one oil."""

from pathlib import Path

from oilfilm.fits.drawn import NOTHING, read_drawn
from oilfilm.fits.fit import fit_oil
from oilfilm.paper.reference import printed_values
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables
from oilfilm.traction import LAWS

with job(snakemake) as (settings, provenance):
    oil = snakemake.wildcards.oil
    points = CampaignTables.of_job(snakemake.input).points
    law = LAWS[settings.fit.law]
    printed = printed_values(Path(snakemake.input.printed), law, oil)
    drawn = read_drawn(map(Path, snakemake.input.drawn)).get(law.name, NOTHING)
    fit = fit_oil(points, oil, settings.fit, settings.seed, printed, drawn=drawn)
    write_tables(fit.tables, snakemake.output, provenance)
    with Path(snakemake.log[0]).open("a", encoding="utf-8") as log:
        log.writelines(f"{line}\n" for line in fit.remarks())
