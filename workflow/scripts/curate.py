"""Find and judge the plateaus of one share of the runs."""

from functools import partial
from pathlib import Path

from oilfilm import tables
from oilfilm.curation.curate import curate_parts
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as (settings, provenance):
    ingested = CampaignTables.of_job(snakemake.input)
    samples = partial(tables.read_parts, "samples", *map(Path, snakemake.input.samples))
    curated = curate_parts(samples, ingested.runs, settings)
    write_tables(vars(curated), snakemake.output, provenance)
