"""Write the certificates down; end the run where a fit has none."""

from pathlib import Path

from oilfilm import tables
from oilfilm.atomic_write import write_text
from oilfilm.fitting.remarks import certificates
from oilfilm.run.job import job
from oilfilm.settings.resolved import Settings

with job(snakemake):
    quality = tables.read("fit_quality", Path(snakemake.input.quality))
    text = certificates(quality, Settings.of(snakemake.params.config).fit.allow_uncertified)
    write_text(text, Path(snakemake.output[0]))
