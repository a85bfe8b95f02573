"""Fit the laws of one file to one oil."""

from pathlib import Path

import pandas as pd

import oilfilm.run.job as run
from oilfilm.fits.certificate_sentences import certificate_sentence
from oilfilm.fits.fit import fit_law
from oilfilm.tables import rows
from oilfilm.tables.campaign_tables import FIT_POINT_COLUMNS
from oilfilm.tables.table_needs import FIT_TABLES

with run.job(snakemake) as job:
    oil, law_names = snakemake.wildcards.oil, snakemake.params.laws
    points = job.input_tables.table("points", FIT_POINT_COLUMNS)
    fits = [fit_law(points, oil, law_name, job.settings) for law_name in law_names]
    job.write({name: pd.concat([fit.table(name) for fit in fits]) for name in FIT_TABLES})
    with Path(snakemake.log[0]).open("a", encoding="utf-8") as log:
        for law_name, fit in zip(law_names, fits, strict=True):
            (quality,) = rows(fit.fit_quality)
            log.write(f"{oil}, {law_name}: {certificate_sentence(quality)}\n")
