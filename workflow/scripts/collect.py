"""Bring all shares of a campaign together and compare its runs with each other."""

from pathlib import Path

from oilfilm import tables
from oilfilm.curation.curate import Curated, collect
from oilfilm.outputs.spreadsheet import write_csv
from oilfilm.readers.raw_files import remove_others
from oilfilm.run.job import job
from oilfilm.settings.resolved import Settings

with job(snakemake) as provenance:
    inputs = snakemake.input
    shares = [
        Curated(
            tables.read("points", Path(points)),
            tables.read("runs", Path(runs)),
            tables.read("quarantine", Path(refused)),
        )
        for points, runs, refused in zip(inputs.points, inputs.runs, inputs.quarantine, strict=True)
    ]
    unread = [tables.read("quarantine", Path(path)) for path in inputs.unread]
    remove_others(map(Path, inputs.samples))
    campaign = collect(shares, unread, Settings.of(snakemake.params.config))
    tables.write(campaign.points, "points", Path(snakemake.output.points), provenance)
    tables.write(campaign.runs, "runs", Path(snakemake.output.runs), provenance)
    tables.write(campaign.quarantine, "quarantine", Path(snakemake.output.quarantine), provenance)
    write_csv(campaign.quarantine, Path(snakemake.output.spreadsheet))
