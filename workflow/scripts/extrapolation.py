"""Compare fitted laws with the truth of a simulated campaign, beyond what was tested."""

from pathlib import Path

from oilfilm.fits.law_comparison import laws_of
from oilfilm.paper.extrapolation import extrapolate, extrapolation_errors
from oilfilm.paper.reference import printed_constants
from oilfilm.rig_twin.truth import truth_grid
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as (settings, provenance):
    results = CampaignTables.of_job(snakemake.input)
    truth = truth_grid(settings, printed_constants(Path(snakemake.input.printed)))
    compared = extrapolate(
        truth,
        results.coefficients,
        results.refits,
        results.fit_quality,
        settings.same_set_point.relative,
        {oil: laws_of(oil, settings) for oil in settings.oils},
    )
    frames = {
        "truth_grid": truth,
        "extrapolation": compared,
        "extrapolation_errors": extrapolation_errors(compared),
    }
    write_tables(frames, snakemake.output, provenance)
