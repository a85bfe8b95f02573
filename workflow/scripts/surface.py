"""Fit a smooth surface to the measured mu of one oil."""

import oilfilm.run.job as run
from oilfilm.fits.soundness import with_configured_fits_marked
from oilfilm.fits.surface_search import surface_tables_of_oil
from oilfilm.tables.table_needs import SURFACE_TABLES

with run.job(snakemake) as job:
    results = with_configured_fits_marked(job.input_tables, job.settings.fit.law)
    settings = job.settings
    surface_tables = surface_tables_of_oil(
        results, snakemake.wildcards.oil, settings, settings.rigs
    )
    job.write({name: surface_tables.table(name) for name in SURFACE_TABLES})
