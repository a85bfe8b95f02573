"""Join all shares of a campaign, compare its runs with each other, and count the coverage."""

from pathlib import Path

import oilfilm.run.job as run
from oilfilm import tables
from oilfilm.base.digests import settings_digest
from oilfilm.curation.coverage import coverage, gate_counts
from oilfilm.curation.curate import Curated, collect
from oilfilm.logs.first_seen import FirstSeen
from oilfilm.logs.raw_files import read_listings
from oilfilm.report.spreadsheet import write_csv

with run.job(snakemake) as job:
    inputs, outputs, params = snakemake.input, snakemake.output, snakemake.params
    if params.measured:
        digests = read_listings(*map(Path, inputs.digests))
        first_seen = FirstSeen(job.settings.campaign.name, folder=Path(params.first_seen))
        first_seen.check_and_add(digests, params.acknowledged)
        removed_logs = first_seen.gone(digests)
        if removed_logs:
            run.say(removed_logs)
    job.provenance["inputs"] |= params.run_sheet
    shares = Curated(job.tables.points, job.tables.runs, job.tables.quarantine)
    campaign = collect(shares, job.settings)
    runs, points, quarantine = campaign.runs, campaign.points, campaign.quarantine
    job.write(
        {
            "runs": runs,
            "points": points,
            "quarantine": quarantine,
            "coverage": coverage(runs, job.settings),
            "gate_counts": gate_counts(runs, points, quarantine),
        }
    )
    write_csv(quarantine, Path(outputs.spreadsheet))
    paths_of_oil = zip(outputs.of_oil, outputs.runs_of_oil, strict=True)
    for oil, (points_path, runs_path) in zip(params.oils, paths_of_oil, strict=True):
        # the footer names only the logs of this oil: the log of another oil changes no byte
        runs_of_oil = runs[runs["oil"] == oil]
        log_digests = dict(zip(runs_of_oil["file"], runs_of_oil["sha256"], strict=True))
        inputs_of_oil = {f"logs of {oil}": settings_digest(log_digests)[:16]}
        provenance = {**job.provenance, "inputs": inputs_of_oil}
        tables.write(points[points["oil"] == oil], "points", Path(points_path), provenance)
        tables.write(runs_of_oil, "runs", Path(runs_path), provenance)
