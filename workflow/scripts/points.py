"""Read one share of the raw logs into samples, then find and judge the plateaus of its runs.

A share has at most `split.runs` logs on average, by the settings. `quarantine` lists what is
refused, and `logs` the sha256 of each log.
"""

from pathlib import Path

import oilfilm.run.job as run
from oilfilm.base.atomic_write import write_text
from oilfilm.curation.curate import curate_share
from oilfilm.logs.raw_files import listing_text
from oilfilm.logs.run_sheet import RunSheet

with run.job(snakemake) as job:
    outputs = snakemake.output
    logs = job.raw_logs(job.settings.campaign.name)
    samples_path_by_oil = dict(zip(job.settings.oils, map(Path, outputs.samples), strict=True))
    sheet = RunSheet.from_params(snakemake.params.sheet)
    curated = curate_share(logs, job.settings, sheet, samples_path_by_oil, job.provenance)
    job.write({"points": curated.points, "runs": curated.runs, "quarantine": curated.quarantine})
    write_text(listing_text(logs.digest_of_path()), Path(outputs.logs))
