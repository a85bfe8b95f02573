"""Judge the printed constants beside the campaign's fit."""

from pathlib import Path

from oilfilm import tables
from oilfilm.run.job import job
from oilfilm.settings.reference import printed_constants
from oilfilm.settings.resolved import Settings
from oilfilm.studies.printed.judge import judge_printed

with job(snakemake) as provenance:
    inputs = snakemake.input
    judged = judge_printed(
        points=tables.read("points", Path(inputs.points)),
        coefficients=tables.read("coefficients", Path(inputs.coefficients)),
        quality=tables.read("fit_quality", Path(inputs.quality)),
        printed=printed_constants(Path(inputs.printed)),
        oils=snakemake.params.oils,
        settings=Settings.of(snakemake.params.config).printed,
        refits=tables.read("refits", Path(inputs.refits)),
    )
    tables.write(judged, "printed_judged", Path(snakemake.output.judged), provenance)
