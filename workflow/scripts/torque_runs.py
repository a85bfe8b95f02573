"""Measure the steady plateaus of the torque logs."""

from pathlib import Path

import oilfilm.run.job as run
from oilfilm.base.atomic_write import write_text
from oilfilm.curation.curate import curate_logs
from oilfilm.curation.torque_rig import TorqueRig
from oilfilm.logs.first_seen import FirstSeenDigests
from oilfilm.logs.raw_files import listing_text
from oilfilm.logs.run_sheet import RunSheet

with run.job(snakemake) as job:
    folder = f"{job.settings.campaign.name}-torque"
    logs = job.raw_logs(folder)
    curated = curate_logs(
        logs, job.settings, TorqueRig, RunSheet.from_params(snakemake.params.sheet)
    )
    digests = logs.digest_of_path()
    if not logs.is_simulated:
        first_seen = FirstSeenDigests(
            job.settings.campaign.name, folder, folder=Path(snakemake.params.first_seen)
        )
        first_seen.check_and_add(digests, snakemake.params.acknowledged)
        removed_logs = first_seen.sentence_on_missing(digests)
        if removed_logs:
            run.print_line(removed_logs)
    job.provenance["inputs"] = run.digests_by_folder(job.provenance["inputs"])
    job.write({"torque_runs": curated.points, "torque_quarantine": curated.quarantine})
    write_text(listing_text(digests), Path(snakemake.output.logs))
