"""Join the fits of all oils and laws, and judge the configured law beside the others."""

import oilfilm.run.job as run
from oilfilm.fits.soundness import finished_fits

with run.job(snakemake) as job:
    job.write(finished_fits(job.tables, job.settings))
