"""Write the certificates down; end the run where a fit has none."""

from pathlib import Path

from oilfilm import tables
from oilfilm.fitting.remarks import certificates
from oilfilm.job import job
from oilfilm.whole import write_text

with job(snakemake):
    quality = tables.read("fit_quality", Path(snakemake.input.quality))
    text = certificates(quality, snakemake.params.config["fit"]["allow_uncertified"])
    write_text(text, Path(snakemake.output[0]))
