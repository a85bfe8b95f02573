"""Read one share of the raw logs into samples, then find and judge the plateaus of its runs."""

from pathlib import Path

from oilfilm.atomic_write import write_text
from oilfilm.curation.curate import curate_share
from oilfilm.logs.raw_files import listing
from oilfilm.logs.run_sheet import RunSheet
from oilfilm.run.job import job, raw_logs
from oilfilm.tables.campaign_tables import write_tables

with job(snakemake) as (settings, provenance):
    outputs = snakemake.output
    logs = raw_logs(snakemake, settings.campaign.name, provenance)
    samples = dict(zip(settings.oils, map(Path, outputs.samples), strict=True))
    sheet = RunSheet.of_plain(snakemake.params.sheet)
    curated = curate_share(logs, settings, sheet, samples, provenance)
    write_tables(vars(curated), outputs, provenance)
    write_text(listing(logs.by_path()), Path(outputs.logs))
