"""Hold the paper's claims and its advice on oils against both bases."""

from pathlib import Path

from oilfilm import tables
from oilfilm.run.job import job
from oilfilm.settings.reference import falling_viscosity, printed_constants
from oilfilm.studies.audit.audit import audit, printed_evidence, read_claims, refit_evidence
from oilfilm.studies.selection import select

with job(snakemake) as provenance:
    found, made, config = snakemake.input, snakemake.output, snakemake.params.config
    oils = falling_viscosity(Path(found.printed))
    # made by other rules, where they are among the inputs
    further = {
        name: tables.read(name, Path(found[name]))
        for name in ("comparison", "torque")
        if name in found.keys()
    }
    bases = [
        refit_evidence(
            tables.read("coefficients", Path(found.coefficients)),
            tables.read("points", Path(found.points)),
            tables.read("runs", Path(found.runs)),
            oils,
            config,
            **further,
        ),
        printed_evidence(printed_constants(Path(found.printed)), oils, config),
    ]
    judged = audit(read_claims(Path(found.claims)), bases, config)
    tables.write(judged, "claims", Path(made.claims), provenance)
    advice = select(bases, config["selection"], config["printed"]["boxes"]["extrapolated"])
    tables.write(advice, "selection", Path(made.selection), provenance)
