"""Judge the paper's constants, signs and claims; compare fits with a simulated truth."""

from pathlib import Path

import oilfilm.run.job as run
from deng2026_study.audit.audit import audit_campaign
from deng2026_study.extrapolation import extrapolate, extrapolation_errors, truth_grid
from deng2026_study.printed_constants import compare_printed_with_fit, judge_signs
from deng2026_study.settings import study_settings
from oilfilm.fits.fit import laws_of_oil
from oilfilm.fits.fitted import read_surface
from oilfilm.tables import empty_table
from simulated_lab.printed import read_printed_constants

with run.job(snakemake) as job:
    printed_file, claims_file = Path(snakemake.input.printed), Path(snakemake.input.claims)
    constants_by_oil, oils = read_printed_constants(printed_file), list(job.settings.oils)
    study = study_settings(job.settings)
    judged = compare_printed_with_fit(
        job.input_tables.configured_fits, constants_by_oil, oils, study.printed
    )
    traction_max = job.settings.gates.traction_max
    signs, verdicts = judge_signs(constants_by_oil, oils, study.printed, traction_max)
    table_by_name = {"printed_judged": judged, "signs": signs, "sign_verdicts": verdicts}
    if job.settings.campaign.twin:
        truth = truth_grid(job.settings, constants_by_oil)
        extrapolated = extrapolate(
            truth,
            job.input_tables.coefficients,
            job.input_tables.refits,
            job.input_tables.fit_quality,
            job.settings.same_set_point.relative,
            {oil: laws_of_oil(oil, job.settings) for oil in oils},
            {oil: read_surface(job.input_tables, oil) for oil in oils},
        )
        table_by_name |= {"truth_grid": truth, "extrapolation": extrapolated}
        table_by_name["extrapolation_errors"] = extrapolation_errors(extrapolated)
    extrapolation = table_by_name.get("extrapolation", empty_table("extrapolation"))
    with_truth = job.input_tables.replace(extrapolation=extrapolation)
    table_by_name |= audit_campaign(with_truth, printed_file, claims_file, job.settings)
    job.write(table_by_name)
