"""Set the paper's advice beside the best oil by cage slip, and published tests of bearings."""

from pathlib import Path

from oilfilm.paper.advice import advice_in_band
from oilfilm.paper.published_tests import published_tests_table
from oilfilm.paper.reference import PublishedBearingTests
from oilfilm.run.job import job
from oilfilm.settings.messages import load
from oilfilm.tables.campaign_tables import CampaignTables, write_tables
from oilfilm.torque.bearing_torque import oils_in_bearings

with job(snakemake) as (settings, provenance):
    results = CampaignTables.of_job(snakemake.input)
    published = load(Path(snakemake.input.published), PublishedBearingTests)
    fits = results.coefficients, results.fit_quality
    oils = oils_in_bearings(*fits, settings, results.refits)
    frames = advice_in_band(oils, results, settings)
    frames["published_tests"] = published_tests_table(published, oils, settings)
    write_tables(frames, snakemake.output, provenance)
