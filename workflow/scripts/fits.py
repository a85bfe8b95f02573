"""Join the fits of all oils and laws, and judge the configured law beside the others."""

import oilfilm.run.job as run
from oilfilm.fits.soundness import finished_fit_tables
from oilfilm.tables.table_needs import FIT_TABLES, SURFACE_TABLES

with run.job(snakemake) as job:
    finished_tables = finished_fit_tables(job.input_tables, job.settings)
    job.write(finished_tables)
    job.write_stacked({*FIT_TABLES, *SURFACE_TABLES} - finished_tables.keys())
