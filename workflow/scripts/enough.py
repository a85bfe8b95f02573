"""List the accepted runs; end the run where there are too few."""

from pathlib import Path

import oilfilm.run.job as run
from oilfilm.base.atomic_write import write_text
from oilfilm.report.accepted_runs import accepted_runs_text

with run.job(snakemake) as job:
    text = accepted_runs_text(job.input_tables, job.settings.campaign)
    write_text(text, Path(snakemake.output.accepted_runs))
