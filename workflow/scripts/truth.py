"""The noise-free truth of a simulated campaign, beyond what was tested."""

from pathlib import Path

from oilfilm import tables
from oilfilm.paper.reference import printed_constants
from oilfilm.rig_twin.truth import truth_grid
from oilfilm.run.job import job

with job(snakemake) as (settings, provenance):
    constants = printed_constants(Path(snakemake.input.printed))
    grid = truth_grid(settings, constants)
    tables.write(grid, "truth_grid", Path(snakemake.output.truth_grid), provenance)
