"""Judge the printed constants beside the campaign's fit."""

from pathlib import Path

from oilfilm import tables
from oilfilm.fitting.fitted import covariances
from oilfilm.job import job
from oilfilm.printed.judge import judge_printed
from oilfilm.reference import printed_constants

with job(snakemake) as provenance:
    found = snakemake.input
    coefficients = tables.read("coefficients", Path(found.coefficients))
    judged = judge_printed(
        points=tables.read("points", Path(found.points)),
        coefficients=coefficients,
        quality=tables.read("fit_quality", Path(found.quality)),
        printed=printed_constants(Path(found.printed)),
        config=snakemake.params.config,
        covariances=covariances(coefficients, tables.read("refits", Path(found.refits))),
    )
    tables.write(judged, "printed_judged", Path(snakemake.output.judged), provenance)
