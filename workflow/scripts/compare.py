"""Fit the laws of the comparison, or some of them, to one oil."""

from pathlib import Path

from oilfilm.fits.drawn import read_drawn
from oilfilm.fits.law_comparison import compare_laws, remarks
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as (settings, provenance):
    points = CampaignTables.of_job(snakemake.input).points
    drawn = read_drawn(map(Path, snakemake.input.drawn))
    frames = compare_laws(points, snakemake.wildcards.oil, settings, snakemake.params.laws, drawn)
    write_tables(frames, snakemake.output, provenance)
    with Path(snakemake.log[0]).open("a", encoding="utf-8") as log:
        log.writelines(f"{line}\n" for line in remarks(frames["comparison"]))
