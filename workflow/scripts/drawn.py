"""Compute a part of one law's fit to one oil: its searches, some refits or some curves left out."""

from pathlib import Path

from oilfilm.fits.drawn import read_block, write_block
from oilfilm.fits.fit_parts import Part, compute_part
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables

with job(snakemake) as (settings, _):
    wildcards, size = snakemake.wildcards, snakemake.params.size
    first = int(wildcards.block) * size
    block = slice(first, first + size)
    part = Part(wildcards.of, wildcards.oil, wildcards.law, wildcards.what, block)
    given = snakemake.input.get("ends")
    ends = read_block(Path(given)) if given else None
    points = CampaignTables.of_job(snakemake.input).points
    write_block(compute_part(part, points, settings, ends), Path(snakemake.output.part))
