"""Measure the steady plateaus of the torque logs."""

from pathlib import Path

from oilfilm.atomic_write import write_text
from oilfilm.curation.curate import check_logs
from oilfilm.curation.torque_rig import TORQUE_RIG
from oilfilm.logs.first_seen import FirstSeen
from oilfilm.logs.raw_files import listing
from oilfilm.logs.run_sheet import RunSheet
from oilfilm.run.job import by_folder, job, raw_logs, say
from oilfilm.tables.campaign_tables import write_tables

with job(snakemake) as (settings, provenance):
    folder = f"{settings.campaign.name}-torque"
    logs = raw_logs(snakemake, folder, provenance)
    curated = check_logs(logs, settings, TORQUE_RIG, RunSheet.of_plain(snakemake.params.sheet))
    digests = logs.by_path()
    if not logs.written:
        first_seen = FirstSeen(settings.campaign.name, folder)
        first_seen.check_and_add(digests, snakemake.params.acknowledged)
        if gone := first_seen.gone(digests):
            say(gone)
    provenance["inputs"] = by_folder(provenance["inputs"])
    frames = {"torque_runs": curated.points, "torque_quarantine": curated.quarantine}
    write_tables(frames, snakemake.output, provenance)
    write_text(listing(digests), Path(snakemake.output.logs))
