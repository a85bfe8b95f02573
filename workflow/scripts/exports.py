"""Write every oil's fit in the forms that bearing codes use."""

from pathlib import Path

import oilfilm.run.job as run
from oilfilm.base.atomic_write import atomic_folder, write_bytes
from oilfilm.exports.campaign import export_campaign

with run.job(snakemake) as job:
    files = export_campaign(job.input_tables, job.settings, job.provenance)
    with atomic_folder(Path(snakemake.output.folder)) as folder:
        for name, content in files.items():
            write_bytes(content, folder / name)
