"""Measure the steady plateaus of the torque logs."""

from pathlib import Path

from oilfilm.curation.curate import check_logs
from oilfilm.curation.torque_rig import TORQUE_RIG
from oilfilm.logs.raw_files import expected_states, unchanged_logs
from oilfilm.logs.run_sheet import RunSheet
from oilfilm.run.job import by_folder, job
from oilfilm.tables.campaign_tables import write_tables

with job(snakemake) as (settings, provenance):
    folder = Path(snakemake.input.get("logs", f"data/raw/{settings.campaign.name}-torque"))
    listing = snakemake.input.get("listing")
    states = expected_states(snakemake.params.files, listing)
    sheet = RunSheet.of_plain(snakemake.params.sheet)
    inputs = None if listing else provenance["inputs"]
    logs = unchanged_logs(folder, states, inputs)
    curated = check_logs(logs, settings, TORQUE_RIG, sheet)
    # measured logs, which are no inputs for Snakemake, have been added one by one
    provenance["inputs"] = by_folder(provenance["inputs"])
    frames = {"torque_runs": curated.points, "torque_quarantine": curated.quarantine}
    write_tables(frames, snakemake.output, provenance)
