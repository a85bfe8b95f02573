"""Compare fitted laws with the truth of a simulated campaign."""

from oilfilm.fits.law_comparison import laws_of
from oilfilm.paper.extrapolation import extrapolate, extrapolation_errors
from oilfilm.run.job import job
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as (settings, provenance):
    results = CampaignTables.of_job(snakemake.input)
    compared = extrapolate(
        results.truth_grid,
        results.law_coefficients,
        results.law_refits,
        results.law_fit_quality,
        settings.same_set_point.relative,
        {oil: laws_of(oil, settings) for oil in settings.oils},
    )
    errors = extrapolation_errors(compared)
    frames = {"extrapolation": compared, "extrapolation_errors": errors}
    write_tables(frames, snakemake.output, provenance)
