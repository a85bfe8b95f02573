"""Bring all shares of a campaign together, compare its runs with each other, count the coverage."""

from pathlib import Path

from oilfilm import tables
from oilfilm.curation.coverage import coverage, gate_counts
from oilfilm.curation.curate import Curated, collect
from oilfilm.digests import settings_digest
from oilfilm.logs.first_seen import FirstSeen
from oilfilm.logs.raw_files import read_listings, remove_others
from oilfilm.report.spreadsheet import write_csv
from oilfilm.run.job import job, say
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as (settings, provenance):
    inputs, outputs, params = snakemake.input, snakemake.output, snakemake.params
    if params.measured:
        digests = read_listings(*map(Path, inputs.digests))
        seen = FirstSeen(settings.campaign.name)
        seen.check_and_add(digests, params.acknowledged)
        if gone := seen.gone(digests):
            say(gone)
    provenance["inputs"] |= params.run_sheet
    shares = CampaignTables.of_job(inputs)
    remove_others(Path(outputs.points).with_name("samples"), params.oils, params.shares)
    campaign = collect([Curated(shares.points, shares.runs, shares.quarantine)], [], settings)
    runs, points, quarantine = campaign.runs, campaign.points, campaign.quarantine
    counted = {
        "coverage": coverage(runs, settings),
        "gate_counts": gate_counts(runs, points, quarantine),
    }
    write_tables({**vars(campaign), **counted}, outputs, provenance)
    write_csv(quarantine, Path(outputs.spreadsheet))
    for oil, path in zip(params.oils, outputs.of_oil, strict=True):
        # the logs of this oil alone, so that another oil's log changes no byte and no fit
        of_oil = runs[runs["oil"] == oil]
        logs = settings_digest(dict(zip(of_oil["file"], of_oil["sha256"], strict=True)))
        of_this = {**provenance, "inputs": {f"logs of {oil}": logs[:16]}}
        tables.write(points[points["oil"] == oil], "points", Path(path), of_this)
