"""Join all shares of a campaign, compare its runs with each other, and count the coverage."""

from pathlib import Path

import pandas as pd

import oilfilm.run.job as run
from oilfilm import tables
from oilfilm.base.digests import mapping_digest
from oilfilm.curation.coverage import coverage, gate_counts
from oilfilm.curation.curate import compare_runs
from oilfilm.logs.first_seen import FirstSeenDigests
from oilfilm.logs.raw_files import read_listings
from oilfilm.report.spreadsheet import write_csv
from oilfilm.tables.sorted_rows import sorted_rows

with run.job(snakemake) as job:
    inputs, outputs, params = snakemake.input, snakemake.output, snakemake.params
    if params.measured:
        digests = read_listings(*map(Path, inputs.digests))
        first_seen = FirstSeenDigests(job.settings.campaign.name, folder=Path(params.first_seen))
        first_seen.check_and_add(digests, params.acknowledged)
        removed_logs = first_seen.sentence_on_missing(digests)
        if removed_logs:
            run.print_line(removed_logs)
    job.provenance["inputs"] |= params.run_sheet
    compared = compare_runs(job.input_tables, job.settings)
    runs, quarantine = compared.runs, compared.quarantine
    points_path = Path(outputs.points)
    plateau_count_by_run = runs.set_index("run_id")["plateaus"]
    blocks_in_order_of_runs = sorted_rows(
        "points", list(map(Path, inputs.points)), plateau_count_by_run, points_path.parent
    )
    failed_gates = [tables.empty_table("points")[["run_id", "failed_gates"]]]
    with tables.writing(
        "points", points_path, job.provenance, tables.ROWS_PER_GROUP
    ) as write_block:
        for block in blocks_in_order_of_runs:
            points = compared.apply_refusals(block)
            write_block(points)
            failed_gates.append(points.loc[~points["accepted"], ["run_id", "failed_gates"]])
    counts_of_gates = gate_counts(runs, pd.concat(failed_gates), quarantine)
    covered_conditions = coverage(runs, job.settings)
    job.write(
        {
            "runs": runs,
            "quarantine": quarantine,
            "coverage": covered_conditions,
            "gate_counts": counts_of_gates,
        }
    )
    write_csv(quarantine, Path(outputs.spreadsheet))
    paths_by_oil = zip(outputs.points_by_oil, outputs.runs_by_oil, strict=True)
    for oil, (points_path_of_oil, runs_path_of_oil) in zip(params.oils, paths_by_oil, strict=True):
        # the footer names only the logs of this oil: the log of another oil changes no byte
        runs_of_oil = runs[runs["oil"] == oil]
        log_digests = dict(zip(runs_of_oil["file"], runs_of_oil["sha256"], strict=True))
        inputs_of_oil = {f"logs of {oil}": mapping_digest(log_digests)[:16]}
        provenance = {**job.provenance, "inputs": inputs_of_oil}
        points_of_oil = (
            block[block["oil"] == oil] for block in tables.read_blocks("points", points_path)
        )
        tables.write_blocks(points_of_oil, "points", Path(points_path_of_oil), provenance)
        tables.write(runs_of_oil, "runs", Path(runs_path_of_oil), provenance)
