"""Read one share of the raw logs into samples, runs and quarantine."""

import json
from dataclasses import asdict
from pathlib import Path

from oilfilm import tables
from oilfilm.atomic_write import write_text
from oilfilm.logs.ingest import ingest_logs, sample_files
from oilfilm.logs.raw_files import expected_states, unchanged_logs
from oilfilm.logs.run_sheet import RunSheet
from oilfilm.run.job import job
from oilfilm.tables.table_file import table_file

with job(snakemake) as (settings, provenance):
    folder = Path(snakemake.input.get("logs", f"data/raw/{settings.campaign.name}"))
    listing = snakemake.input.get("listing")
    states = expected_states(snakemake.params.files, listing)
    sheet = RunSheet.of_plain(snakemake.params.sheet)
    inputs = None if listing else provenance["inputs"]
    logs = unchanged_logs(folder, states, inputs)
    paths = dict(zip(settings.oils, map(Path, snakemake.output.samples), strict=True))
    with sample_files(paths, provenance) as keep:
        ingested = ingest_logs(logs, settings, sheet=sheet, keep=keep, verified=states)
    files = [asdict(table_file(path, path.parents[2])) for path in paths.values()]
    write_text(json.dumps(files, indent=2) + "\n", Path(snakemake.output.files))
    tables.write(ingested.runs, "runs", Path(snakemake.output.runs), provenance)
    tables.write(ingested.quarantine, "quarantine", Path(snakemake.output.quarantine), provenance)
