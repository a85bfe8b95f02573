"""Judge the paper's constants, signs and claims; compare fits with a simulated truth."""

from pathlib import Path

from oilfilm.fits.law_comparison import laws_of
from oilfilm.paper.audit.audit import audit_campaign
from oilfilm.paper.extrapolation import extrapolate, extrapolation_errors
from oilfilm.paper.printed.judge import judge_printed
from oilfilm.paper.printed.signs import study_signs
from oilfilm.paper.reference import printed_constants
from oilfilm.rig_twin.truth import truth_grid
from oilfilm.run.job import job
from oilfilm.tables import empty
from oilfilm.tables.campaign_tables import CampaignTables, write_tables

with job(snakemake) as (settings, provenance):
    results = CampaignTables.of_job(snakemake.input)
    printed, claims = Path(snakemake.input.printed), Path(snakemake.input.claims)
    constants, oils = printed_constants(printed), list(settings.oils)
    judged = judge_printed(results.configured, constants, oils, settings.printed)
    limit = settings.gates.traction_max
    signs, verdicts = study_signs(constants, results.points, oils, settings.printed, limit)
    frames = {"printed_judged": judged, "signs": signs, "sign_verdicts": verdicts}
    if settings.campaign.twin:
        truth = truth_grid(settings, constants)
        compared = extrapolate(
            truth,
            results.coefficients,
            results.refits,
            results.fit_quality,
            settings.same_set_point.relative,
            {oil: laws_of(oil, settings) for oil in oils},
        )
        frames |= {"truth_grid": truth, "extrapolation": compared}
        frames["extrapolation_errors"] = extrapolation_errors(compared)
    with_truth = results.replace(extrapolation=frames.get("extrapolation", empty("extrapolation")))
    frames |= audit_campaign(with_truth, printed, claims, settings)
    write_tables(frames, snakemake.output, provenance)
