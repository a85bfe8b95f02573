"""Join all shares of a campaign, compare its runs with each other, and count the coverage."""

from pathlib import Path

import pandas as pd

import oilfilm.run.job as run
from oilfilm import tables
from oilfilm.base.digests import mapping_digest
from oilfilm.curation.coverage import coverage, gate_counts
from oilfilm.curation.curate import compare_runs
from oilfilm.logs.first_seen import FirstSeen
from oilfilm.logs.raw_files import read_listings
from oilfilm.report.spreadsheet import write_csv
from oilfilm.tables.sorted_rows import sorted_rows

with run.job(snakemake) as job:
    inputs, outputs, params = snakemake.input, snakemake.output, snakemake.params
    if params.measured:
        digests = read_listings(*map(Path, inputs.digests))
        first_seen = FirstSeen(job.settings.campaign.name, folder=Path(params.first_seen))
        first_seen.check_and_add(digests, params.acknowledged)
        removed_logs = first_seen.sentence_on_missing(digests)
        if removed_logs:
            run.print_line(removed_logs)
    job.provenance["inputs"] |= params.run_sheet
    compared = compare_runs(job.input_tables, job.settings)
    runs, quarantine = compared.runs, compared.quarantine
    points_path = Path(outputs.points)
    counts = runs.set_index("run_id")["plateaus"]
    parts = sorted_rows("points", list(map(Path, inputs.points)), counts, points_path.parent)
    failed = [tables.empty_table("points")[["run_id", "failed_gates"]]]
    with tables.writing("points", points_path, job.provenance, tables.ROWS_PER_GROUP) as add:
        for part in parts:
            points = compared.judged(part)
            add(points)
            failed.append(points.loc[~points["accepted"], ["run_id", "failed_gates"]])
    counted = gate_counts(runs, pd.concat(failed), quarantine)
    covered = coverage(runs, job.settings)
    job.write({"runs": runs, "quarantine": quarantine, "coverage": covered, "gate_counts": counted})
    write_csv(quarantine, Path(outputs.spreadsheet))
    paths_of_oil = zip(outputs.of_oil, outputs.runs_of_oil, strict=True)
    for oil, (path, runs_path) in zip(params.oils, paths_of_oil, strict=True):
        # the footer names only the logs of this oil: the log of another oil changes no byte
        runs_of_oil = runs[runs["oil"] == oil]
        log_digests = dict(zip(runs_of_oil["file"], runs_of_oil["sha256"], strict=True))
        inputs_of_oil = {f"logs of {oil}": mapping_digest(log_digests)[:16]}
        provenance = {**job.provenance, "inputs": inputs_of_oil}
        with tables.writing("points", Path(path), provenance, tables.ROWS_PER_GROUP) as add:
            for part in tables.read_parts("points", points_path):
                add(part[part["oil"] == oil])
        tables.write(runs_of_oil, "runs", Path(runs_path), provenance)
