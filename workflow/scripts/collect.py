"""Bring all shares of a campaign together and compare its runs with each other."""

from pathlib import Path

from oilfilm import tables
from oilfilm.curation.curate import Curated, collect
from oilfilm.digests import settings_digest
from oilfilm.logs.raw_files import remove_others
from oilfilm.report.spreadsheet import write_csv
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as (settings, provenance):
    inputs, outputs = snakemake.input, snakemake.output
    provenance["inputs"] |= snakemake.params.run_sheet
    shares = CampaignTables.of_job(inputs)
    samples = Path(outputs.points).with_name("samples")
    remove_others(samples, snakemake.params.oils, snakemake.params.shares)
    curated = Curated(shares.points, shares.runs, shares.quarantine)
    campaign = collect([curated], [], settings)
    write_tables(vars(campaign), outputs, provenance)
    write_csv(campaign.quarantine, Path(outputs.spreadsheet))
    for oil, path in zip(snakemake.params.oils, outputs.of_oil, strict=True):
        of_oil = campaign.points[campaign.points["oil"] == oil]
        runs = campaign.runs[campaign.runs["oil"] == oil]
        # the logs of this oil alone, so that another oil's log changes no byte and no fit
        logs = settings_digest(dict(zip(runs["file"], runs["sha256"], strict=True)))
        of_this = {**provenance, "inputs": {f"logs of {oil}": logs[:16]}}
        tables.write(of_oil, "points", Path(path), of_this)
