"""Count what a campaign covers and what each gate refused."""

from pathlib import Path

from oilfilm import tables
from oilfilm.curation.coverage import coverage, gate_counts
from oilfilm.run.job import job

with job(snakemake) as provenance:
    found, made = snakemake.input, snakemake.output
    points = tables.read("points", Path(found.points))
    runs = tables.read("runs", Path(found.runs))
    quarantine = tables.read("quarantine", Path(found.quarantine))
    covered = coverage(runs, snakemake.params.config)
    tables.write(covered, "coverage", Path(made.coverage), provenance)
    counts = gate_counts(runs, points, quarantine)
    tables.write(counts, "gate_counts", Path(made.gates), provenance)
