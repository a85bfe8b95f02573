"""Bring all shares of a campaign together, compare its runs with each other, count the coverage."""

from pathlib import Path

import oilfilm.run.job as run
from oilfilm import tables
from oilfilm.curation.coverage import coverage, gate_counts
from oilfilm.curation.curate import Curated, collect
from oilfilm.digests import settings_digest
from oilfilm.logs.first_seen import FirstSeen
from oilfilm.logs.raw_files import read_listings
from oilfilm.report.spreadsheet import write_csv

with run.job(snakemake) as job:
    inputs, outputs, params = snakemake.input, snakemake.output, snakemake.params
    if params.measured:
        digests = read_listings(*map(Path, inputs.digests))
        seen = FirstSeen(job.settings.campaign.name)
        seen.check_and_add(digests, params.acknowledged)
        if gone := seen.gone(digests):
            run.say(gone)
    job.provenance["inputs"] |= params.run_sheet
    shares = Curated(job.tables.points, job.tables.runs, job.tables.quarantine)
    campaign = collect(shares, job.settings)
    runs, points, quarantine = campaign.runs, campaign.points, campaign.quarantine
    counted = {
        "coverage": coverage(runs, job.settings),
        "gate_counts": gate_counts(runs, points, quarantine),
    }
    job.write({**vars(campaign), **counted})
    write_csv(quarantine, Path(outputs.spreadsheet))
    for oil, path in zip(params.oils, outputs.of_oil, strict=True):
        # the logs of this oil alone, so that another oil's log changes no byte and no fit
        of_oil = runs[runs["oil"] == oil]
        logs = settings_digest(dict(zip(of_oil["file"], of_oil["sha256"], strict=True)))
        of_this = {**job.provenance, "inputs": {f"logs of {oil}": logs[:16]}}
        tables.write(points[points["oil"] == oil], "points", Path(path), of_this)
