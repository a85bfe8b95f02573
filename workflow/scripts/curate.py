"""Find and judge the plateaus of one share of the runs."""

from pathlib import Path

from oilfilm import tables
from oilfilm.curation.curate import curate
from oilfilm.run.job import job
from oilfilm.settings.resolved import Settings

with job(snakemake) as provenance:
    samples = tables.read("samples", *map(Path, snakemake.input.samples))
    runs = tables.read("runs", Path(snakemake.input.runs))
    curated = curate(samples, runs, Settings.of(snakemake.params.config))
    tables.write(curated.points, "points", Path(snakemake.output.points), provenance)
    tables.write(curated.runs, "runs", Path(snakemake.output.runs), provenance)
    tables.write(curated.quarantine, "quarantine", Path(snakemake.output.quarantine), provenance)
