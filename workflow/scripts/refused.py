"""Draw one page per refused run, and list which page shows which run."""

from pathlib import Path

import pandas as pd

import oilfilm.run.job as run
from oilfilm import tables
from oilfilm.base.atomic_write import atomic_folder
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.logs.run_sheet import RunSheet
from oilfilm.report.figures.refused_runs import (
    MARKED_POINT_COLUMNS,
    JudgedLogs,
    draw_pages,
    judged_torque_logs,
)
from oilfilm.tables.samples_content import reader_of_samples

with run.job(snakemake) as job:
    inputs = snakemake.input
    samples_of_run = reader_of_samples([Path(path) for path in inputs.samples])
    quarantine = job.input_tables.quarantine
    blocks_of_points = job.input_tables.blocks("points", MARKED_POINT_COLUMNS)
    # pages show plateaus of refused runs alone
    points = pd.concat(
        block[block["run_id"].isin(quarantine["run_id"])] for block in blocks_of_points
    )
    judged_traction_logs = JudgedLogs(
        TractionRig, job.input_tables.runs, points, quarantine, samples_of_run
    )
    judged_logs_of_rigs = [judged_traction_logs]
    if job.settings.campaign.torque is not None:
        torque_quarantine = job.input_tables.torque_quarantine
        logs = job.raw_logs(f"{job.settings.campaign.name}-torque")
        sheet = RunSheet.from_params(snakemake.params.sheet)
        judged_logs_of_rigs.append(
            judged_torque_logs(
                logs.select(torque_quarantine["file"]), torque_quarantine, job.settings, sheet
            )
        )
    with atomic_folder(Path(snakemake.output.refused_pages)) as folder:
        pages = draw_pages(judged_logs_of_rigs, job.settings, snakemake.params.pages_max, folder)
        tables.write(pages, "refused_pages", folder / "index.parquet", job.provenance)
