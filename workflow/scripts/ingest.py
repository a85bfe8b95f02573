"""Read one share of the raw logs into samples, runs and quarantine."""

from pathlib import Path

from oilfilm import tables
from oilfilm.readers.ingest import ingest_logs
from oilfilm.readers.raw_files import expected_digests, unchanged_logs
from oilfilm.readers.run_sheet import RunSheet
from oilfilm.run.job import job

with job(snakemake) as (settings, provenance):
    folder = Path("data/raw", settings.campaign.name)
    digests = expected_digests(snakemake.params.files, snakemake.input.get("listing"))
    sheet = RunSheet.of_plain(snakemake.params.sheet)
    logs = unchanged_logs(folder, digests, snakemake.params.place, provenance["inputs"])
    ingested = ingest_logs(logs, settings, sheet=sheet)
    for frame, path in zip(ingested.samples.values(), snakemake.output.samples, strict=True):
        tables.write(frame, "samples", Path(path), provenance)
    tables.write(ingested.runs, "runs", Path(snakemake.output.runs), provenance)
    tables.write(ingested.quarantine, "quarantine", Path(snakemake.output.quarantine), provenance)
