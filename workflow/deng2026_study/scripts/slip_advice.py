"""Set the paper's advice beside the best oil by cage slip, and published tests of bearings."""

from pathlib import Path

import oilfilm.run.job as run
from deng2026_study.advice import advice_by_truth, advice_tables
from deng2026_study.published_tests import published_tests_table
from deng2026_study.reference import PublishedBearingTests
from oilfilm.settings.messages import load
from oilfilm.torque.bearing_torque import oils_in_bearings
from simulated_lab.printed import read_printed_constants

with run.job(snakemake) as job:
    published_tests = load(Path(snakemake.input.published), PublishedBearingTests)
    oils = oils_in_bearings(
        job.input_tables.coefficients, job.input_tables.fit_quality, job.settings
    )
    table_by_name = advice_tables(oils, job.input_tables, job.settings)
    constants_by_oil = read_printed_constants(Path(snakemake.input.printed))
    advice, band = table_by_name["slip_advice"], table_by_name["advice_band"]
    table_by_name |= advice_by_truth(advice, band, job.input_tables, job.settings, constants_by_oil)
    table_by_name["published_tests"] = published_tests_table(published_tests, oils, job.settings)
    job.write(table_by_name)
