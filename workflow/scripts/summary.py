"""Write the one-screen summary of a campaign."""

from pathlib import Path

from oilfilm import tables
from oilfilm.atomic_write import write_text
from oilfilm.outputs.bearing_sentences import BearingTables
from oilfilm.outputs.summary import summarise
from oilfilm.run.job import job

with job(snakemake) as provenance:
    found = snakemake.input
    bearing = BearingTables(
        torque_runs=tables.read("torque_runs", *map(Path, found.torque_runs)),
        torque_quarantine=tables.read("quarantine", *map(Path, found.torque_quarantine)),
        torque=tables.read("torque", *map(Path, found.torque)),
        torque_inversion=tables.read("torque_inversion", *map(Path, found.torque_inversion)),
        slip_advice=tables.read("slip_advice", *map(Path, found.slip_advice)),
    )
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
        bearing=bearing if found.torque_runs else None,
    )
    write_text(text, Path(snakemake.output[0]))
