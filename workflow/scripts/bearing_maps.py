"""Calculate cage slip, the size effect and published tests."""

from pathlib import Path

from oilfilm.paper.advice_band import advice_in_band
from oilfilm.paper.published_tests import published_tests_table
from oilfilm.paper.reference import PublishedBearingTests
from oilfilm.run.job import job
from oilfilm.settings.messages import load
from oilfilm.tables.campaign_tables import CampaignTables, write_tables
from oilfilm.torque.bearing_torque import (
    cage_slip_table,
    oils_in_bearings,
    size_effect_table,
)

with job(snakemake) as (settings, provenance):
    results = CampaignTables.of_job(snakemake.input)
    published = load(Path(snakemake.input.published), PublishedBearingTests)
    other_fits = results.law_coefficients, results.law_fit_quality, results.law_refits
    coefficients, refits = results.coefficients, results.refits
    oils = oils_in_bearings(coefficients, results.fit_quality, settings, other_fits, refits)
    cage_slip = cage_slip_table(oils, settings)
    advice, band = advice_in_band(oils, coefficients, refits, cage_slip, settings)
    frames = {
        "cage_slip": cage_slip,
        "slip_advice": advice,
        "advice_band": band,
        "size_effect": size_effect_table(oils, settings),
        "published_tests": published_tests_table(published, oils, settings),
    }
    write_tables(frames, snakemake.output, provenance)
