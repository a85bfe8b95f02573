"""Fit one law to one oil."""

from pathlib import Path

import oilfilm.run.job as run
from oilfilm.fits.fit import fit_law
from oilfilm.table_needs import OF_FIT

with run.job(snakemake) as job:
    oil, law = snakemake.wildcards.oil, snakemake.wildcards.law
    fit = fit_law(job.tables.points, oil, law, job.settings)
    job.write({table: fit.table(table) for table in OF_FIT})
    with Path(snakemake.log[0]).open("a", encoding="utf-8") as log:
        log.write(f"{oil}, {law}: {fit.fit_quality['certificate'].item()}\n")
