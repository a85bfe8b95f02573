"""Count what a campaign covers and what each gate refused."""

from pathlib import Path

from oilfilm import tables
from oilfilm.curation.coverage import coverage, gate_counts
from oilfilm.run.job import job
from oilfilm.settings.resolved import Settings

with job(snakemake) as provenance:
    inputs, outputs = snakemake.input, snakemake.output
    points = tables.read("points", Path(inputs.points))
    runs = tables.read("runs", Path(inputs.runs))
    quarantine = tables.read("quarantine", Path(inputs.quarantine))
    covered = coverage(runs, Settings.of(snakemake.params.config))
    tables.write(covered, "coverage", Path(outputs.coverage), provenance)
    counts = gate_counts(runs, points, quarantine)
    tables.write(counts, "gate_counts", Path(outputs.gates), provenance)
