"""Write the one-screen summary of a campaign."""

from pathlib import Path

from oilfilm import tables
from oilfilm.job import job
from oilfilm.summary import summarise
from oilfilm.whole import write_text

with job(snakemake) as provenance:
    found = snakemake.input
    text = summarise(
        runs=tables.read("runs", Path(found.runs)),
        points=tables.read("points", Path(found.points)),
        quarantine=tables.read("quarantine", Path(found.quarantine)),
        coverage=tables.read("coverage", Path(found.coverage)),
        extrapolation=tables.read("extrapolation", *map(Path, found.extrapolation)),
        coefficients=tables.read("coefficients", Path(found.coefficients)),
        quality=tables.read("fit_quality", Path(found.quality)),
        judged=tables.read("printed_judged", Path(found.judged)),
        signs=tables.read("signs", Path(found.signs)),
        sign_verdicts=tables.read("sign_verdicts", Path(found.sign_verdicts)),
        claims=tables.read("claims", Path(found.claims)),
        campaign=snakemake.params.config["campaign"],
        oils=snakemake.params.config["oils"],
        film=snakemake.params.config["film"],
        gates=snakemake.params.config["gates"],
    )
    write_text(text, Path(snakemake.output[0]))
