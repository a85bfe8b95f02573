"""Fit the laws of one file to one oil."""

from pathlib import Path

import pandas as pd

import oilfilm.run.job as run
from oilfilm.fits.certificate_words import certificate
from oilfilm.fits.fit import fit_law
from oilfilm.tables import rows
from oilfilm.tables.campaign_tables import FITTED_POINTS
from oilfilm.tables.table_needs import OF_FIT

with run.job(snakemake) as job:
    oil, laws = snakemake.wildcards.oil, snakemake.params.laws
    points = job.tables.table("points", FITTED_POINTS)
    fits = [fit_law(points, oil, law, job.settings) for law in laws]
    job.write({name: pd.concat([fit.table(name) for fit in fits]) for name in OF_FIT})
    with Path(snakemake.log[0]).open("a", encoding="utf-8") as log:
        for law, fit in zip(laws, fits, strict=True):
            (quality,) = rows(fit.fit_quality)
            log.write(f"{oil}, {law}: {certificate(quality)}\n")
