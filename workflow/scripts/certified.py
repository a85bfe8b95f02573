"""Write the certificates down; end the run where a fit has none."""

from pathlib import Path

from oilfilm import tables
from oilfilm.fitting.remarks import certificates
from oilfilm.job import job

with job(snakemake):
    quality = tables.read("fit_quality", Path(snakemake.input.quality))
    text = certificates(quality, snakemake.params.config["fit"]["allow_uncertified"])
    Path(snakemake.output[0]).write_text(text, encoding="utf-8")
