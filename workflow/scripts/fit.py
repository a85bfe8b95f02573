"""Fit one law to one oil."""

from pathlib import Path

import oilfilm.run.job as run
from oilfilm.fits.law_comparison import fit_law

with run.job(snakemake) as job:
    oil, law = snakemake.wildcards.oil, snakemake.wildcards.law
    fit = fit_law(job.tables.points, oil, law, job.settings)
    job.write(fit.tables)
    with Path(snakemake.log[0]).open("a", encoding="utf-8") as log:
        log.write(f"{oil}, {law}: {fit.certificate}\n")
