"""The one-screen summary that a run ends with."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.curation.coverage import describe_condition, planned_states
from oilfilm.fitting.conditions import sentences
from oilfilm.fitting.remarks import fit_remarks
from oilfilm.outputs.bearing_sentences import bearing_lines, listed, refusals
from oilfilm.outputs.constants import DETERMINED, by_certainty
from oilfilm.outputs.enough import shortfalls
from oilfilm.outputs.facts import (
    accepted_points,
    accepted_runs,
    circular,
    condition_counts,
    counted,
    film_unjudged_oils,
    stand_in_oils,
    unread_logs,
)
from oilfilm.outputs.meanings import meanings
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.config import FilmSettings
from oilfilm.settings.oil import OilFile
from oilfilm.settings.resolved import Settings
from oilfilm.studies.extrapolation import extrapolation_sentences
from oilfilm.tables import failed_gates
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import PAPER_LAW

# Missing conditions that are named; the table coverage has them all.
_NAMED = 3
# Lines of a summary that a run prints at its end.
_LINES_MAX = 75
_KEY = "  what the words mean:"


def summarise(results: CampaignTables, settings: Settings) -> str:
    """What was made, how good each fit is and where to look, as text.

    Args:
        results: The campaign's tables.
        settings: Settings `campaign`, `oils`, `film` and `gates`.
    """
    campaign = settings.campaign
    name = campaign.name
    source = ", ".join(filter(None, ["MEASURED", campaign.credit]))
    if campaign.data == "simulated":
        source = ", ".join(filter(None, ["SIMULATED data", campaign.simulator]))
    read, unread = set(results.runs["file"]), unread_logs(results)
    has_torque_logs = len(results.torque_runs) + len(results.torque_quarantine) > 0
    fits = _fits(results)
    lines = [
        f"Campaign {name} ({source}): {campaign.description}",
        *_laws(results.law_verdicts),
        f"  logs    {len(read)} read of {len(read | unread)}",
        f"  runs    {accepted_runs(results)} accepted",
        *(f"  NOT ENOUGH: {lacking}" for lacking in shortfalls(results, campaign)),
        f"  points  {accepted_points(results)} accepted",
        f"  samples {results.runs['samples'].sum()} rows; "
        f"{results.quarantine['refused_rows'].sum()} rows refused as unreadable or no sweep",
        *_covered(results),
        *_unjudged(results.points, campaign),
        *_stand_ins(settings.oils),
        f"  lambda  {_film(settings.film)}; full film above {settings.gates.lambda_limit:g}",
        *_without_set_points(results.runs),
        *_refusals(results),
        "",
        *fits,
        *_noise(results.lack_of_fit),
        *_key([*_laws(results.law_verdicts), *fits, *_noise(results.lack_of_fit)]),
        *_extrapolated(results.extrapolation),
        "",
        *_printed(results, campaign),
        *_claimed(results.claims, campaign),
        *(bearing_lines(results) if has_torque_logs else []),
        f"Report:  results/{name}/report.html (open it in a browser; it needs no network)",
        f"Tables:  results/{name}/tables (start with quarantine.csv)",
        f"Figures: results/{name}/figures",
        f"Exports: results/{name}/exports (the fits for bearing codes; start with README.md)",
        *_pages(results.quarantine, name),
    ]
    return "\n".join(lines) + "\n"


def _laws(verdicts: pd.DataFrame) -> list[str]:
    """The configured law beside the best of those compared, and what to do."""
    lines = []
    for row in tables.rows(verdicts):
        lines.append(f"  law     {row['oil']}: {row['finding']}")
        if row["advice"]:
            lines.append(f"    -> {row['advice']}.")
    return lines


def _noise(misfits: pd.DataFrame) -> list[str]:
    """What each fit misses beside the noise, and what to do."""
    lines = [f"  {row['oil']}: {row['finding']}" for row in tables.rows(misfits)]
    advised = misfits["advice"].loc[misfits["advice"] != ""].unique()
    return [*lines, *(f"    -> {advice}." for advice in advised)]


def _key(lines: Sequence[str]) -> list[str]:
    """What the words of these lines mean."""
    words = meanings(" ".join(lines))
    return [_KEY, *(f"    {word}: {meaning}" for word, meaning in words)]


def at_the_end_of_a_run(summary: str, path: str) -> str:
    """A summary as a terminal gets it: without the meanings of words, and not too long.

    Args:
        summary: The whole of it.
        path: The file that has the whole.
    """
    body, _, places = summary.rstrip().rpartition("\n\n")
    lines: list[str] = []
    in_key = False
    for line in body.split("\n"):
        in_key = line == _KEY or (in_key and line.startswith("    "))
        if not in_key:
            lines.append(line)
        elif line == _KEY:
            lines.append(f"{_KEY} {path}")
    if (left_out := len(lines) - _LINES_MAX) > 0:
        lines = [*lines[:_LINES_MAX], f"... {left_out} more lines: {path}"]
    return "\n".join([*lines, "", places])


def _covered(results: CampaignTables) -> list[str]:
    """Coverage of the matrix, or of the tested conditions where the campaign has no matrix."""
    counts, coverage = condition_counts(results), results.coverage
    line = f"  coverage {counts['accepted']} of {sum(counts.values())} conditions "
    if not coverage["planned"].any():
        return [line + "tested accepted (no matrix is given, so that none can be missing)"]
    line += (
        f"of the matrix accepted, {counts['refused']} refused; "
        f"missing: {counts['missing'] or 'none'}{_may_be_unread(counts, results)}"
    )
    conditions = planned_states(coverage)
    missing = tables.rows(conditions[conditions["state"] == "missing"])
    lines = [f"    {row['oil']}: {describe_condition(row)}" for row in missing[:_NAMED]]
    if len(missing) > _NAMED:
        lines.append(f"    and {len(missing) - _NAMED} more (coverage.parquet)")
    outside = (~coverage["planned"]).sum()
    if outside:
        line += f"; outside it: {outside} tested"
    return [line, *lines]


def _may_be_unread(counts: Mapping[str, int], results: CampaignTables) -> str:
    unread = len(unread_logs(results))
    return f" ({counted(unread, 'log')} could not be read)" if unread and counts["missing"] else ""


def _pages(quarantine: pd.DataFrame, name: str) -> list[str]:
    if not (quarantine["stage"] == "curate").any():
        return []
    return [f"Refused: results/{name}/refused (one page per run; index.parquet lists them)"]


def _unjudged(points: pd.DataFrame, campaign: Campaign) -> list[str]:
    unjudged = points["accepted"] & (points["film_judgement"] == "cannot be judged")
    if not unjudged.any():
        return []
    reason = campaign.film_unjudged.reason if campaign.film_unjudged else ""
    oils = ", ".join(film_unjudged_oils(points))
    return [f"  FILM NOT JUDGED for {unjudged.sum()} accepted points of {oils}: {reason}"]


def _film(film: FilmSettings) -> str:
    heat = "with" if film.thermal_reduction else "without"
    return f"{film.thickness} film {heat} thermal reduction over combined {film.roughness}"


def _stand_ins(oils: Mapping[str, OilFile | None]) -> list[str]:
    names = stand_in_oils(oils)
    if not names:
        return []
    return [f"  film thickness from STAND-IN properties for {', '.join(names)} (config/oils)"]


def _without_set_points(runs: pd.DataFrame) -> list[str]:
    labels = {
        "nominal_load_n": "load",
        "nominal_entrainment_speed_m_s": "speed",
        "nominal_inlet_temperature_c": "temperature",
    }
    missing = runs[list(labels)].isna().sum().rename(labels)
    missing = missing[missing > 0]
    if missing.empty:
        return []
    return [f"  not held against a set point, runs without one: {listed(missing)}"]


def _refusals(results: CampaignTables) -> list[str]:
    counts, gates = results.quarantine["rule"].value_counts(), failed_gates.counts(results.points)
    lines = refusals(results.quarantine, counts, "quarantine")
    return [*lines, f"  points refused by: {listed(gates)}"] if len(gates) else lines


def _extrapolated(compared: pd.DataFrame) -> list[str]:
    if compared.empty:
        return []
    return [
        "  against the SIMULATED truth at the conditions of Figs 7-10, which decides nothing about "
        "the real oils:",
        *(f"    {line}" for line in extrapolation_sentences(compared)),
    ]


def _fits(results: CampaignTables) -> list[str]:
    coefficients = by_certainty(results.coefficients, results.correlations)
    lines = []
    for fit in tables.rows(results.fit_quality):
        if np.isnan(fit["rmse"]):
            lines.append(f"  {fit['oil']}: {fit['certificate']}")
            continue
        lines.append(
            f"  {fit['oil']}: {fit['n_points']} points of {fit['n_curves']} curves, "
            f"rmse {fit['rmse']:.2e} ({fit['relative_rms']:.2%} of mu), {fit['certificate']}"
        )
        lines += [f"    {remark}" for remark in fit_remarks(fit)[1:]]
        rows = coefficients[coefficients["oil"] == fit["oil"]]
        lines += _determined(rows)
        if rows.loc[rows["identifiable"], "standard_error"].isna().all():
            lines.append(
                f"    no bootstrap errors: {fit['n_curves']} curves are too few to be resampled "
                "(fit.min_curves_to_resample of config.yaml)"
            )
        lost = rows.loc[~rows["identifiable"], "constant"]
        if len(lost):
            lines.append(f"    not identifiable, because {sentences(fit)}: " + ", ".join(lost))
    return lines


def _determined(rows: pd.DataFrame) -> list[str]:
    """The constants of one oil that the data determine with their values, and the others."""
    sure = rows["verdict"].isin(DETERMINED)
    # constants that no condition could give have a line of their own
    open_ones = rows[~sure & rows["identifiable"]]
    unsure = open_ones["verdict"] == "no interval"
    if unsure.any():
        values = [f"{row['constant']} {row['value']:.4g}" for row in tables.rows(open_ones[unsure])]
        lines = [f"    values without errors, because the runs are too few: {', '.join(values)}"]
    else:
        known = [
            f"{row['constant']} {row['value']:.4g} +- {(row['upper'] - row['lower']) / 2:.2g}"
            for row in tables.rows(rows[sure])
        ]
        lines = [f"    determined by these data: {', '.join(known) or 'none'}"]
    each = [
        f"{row['constant']} {row['value']:.4g} ({row['determined'].removeprefix('no, ')})"
        for row in tables.rows(open_ones[~unsure])
    ]
    return [*lines, f"    not determined: {', '.join(each)}"] if each else lines


def _claimed(claims: pd.DataFrame, campaign: Campaign) -> list[str]:
    """How many of the paper's claims hold, by basis, which fail, and what that is worth."""
    if claims.empty:
        return []
    lines = ["Claims of the paper (claims.parquet has definitions, shares and worst cases):"]
    for basis, of_basis in claims.groupby("basis", sort=False):
        counts = listed(of_basis["verdict"].value_counts(), "{1} {0}")
        failing = of_basis.loc[of_basis["verdict"] == "fails", "claim"]
        lines.append(f"  {basis}: {counts}; failing: {', '.join(failing) or 'none'}")
    given = claims.loc[claims["verdict"] == "by construction", "claim"].unique()
    if len(given):
        lines.append(f"  by construction, the law's equation makes it so: {', '.join(given)}")
    if circular(campaign):
        lines.append(f"  {circular(campaign)}")
    return [*lines, ""]


def _printed(results: CampaignTables, campaign: Campaign) -> list[str]:
    """The constants printed in the paper: distance from the fit, and how sure their signs are."""
    signs, sign_verdicts = results.signs, results.sign_verdicts
    if signs.empty:
        return []
    lines = ["Printed constants (Deng et al. 2026):"]
    for row in tables.rows(results.printed_judged.dropna(subset=["tested_difference"])):
        lines.append(
            f"  {row['oil']}: SSE {row['printed_sse']:.3e}, the fit's {row['fitted_sse']:.3e}; "
            f"mu differs by at most {abs(row['tested_difference']):.1e} as tested, "
            f"{abs(row['extrapolated_difference']):.1e} as extrapolated"
        )
    for oil, of_oil in sign_verdicts.groupby("oil", sort=False):
        used = signs[signs["in_use"] & (signs["oil"] == oil)].iloc[0]
        verdicts = [
            f"{verdict} {' '.join(of_oil.loc[of_oil['verdict'] == verdict, 'constant'])}"
            for verdict in ("settled", "probable", "open", "against", "without effect")
            if (of_oil["verdict"] == verdict).any()
        ]
        lines.append(
            f"  {oil}: signs in use rank {used['rank']} of 512 (at the slips of figs 8 and 9: "
            f"{used['rank_at_figures']}); {', '.join(verdicts)}"
        )
    return [*lines, *_signs_by_fit(results, campaign), ""]


def _signs_by_fit(results: CampaignTables, campaign: Campaign) -> list[str]:
    """What the fits of the campaign's own points say of the signs in use."""
    fits = results.coefficients[results.coefficients["law"] == PAPER_LAW.name]
    fitted = fits[["oil", "constant", "value", "verdict"]].dropna(subset="value")
    judged = fitted.merge(results.sign_verdicts[["oil", "constant", "sign"]])
    if judged.empty:
        return []
    same = (judged["value"] < 0) == (judged["sign"] == "-")
    known, names = judged["verdict"] == "known", judged["oil"] + " " + judged["constant"]
    line = f"  the fits have {(known & same).sum()} of {len(judged)} signs in use"
    for label, chosen in (("the other sign of", known & ~same), ("not sure of", ~known)):
        if chosen.any():
            line += f"; {label} {', '.join(names[chosen])}"
    if campaign.truth_is_law:
        line += "; CIRCULAR: the points were simulated with these very signs"
    elif campaign.twin is not None:
        line += "; the points were SIMULATED by other physics, which says nothing of printed signs"
    elif campaign.data == "simulated":
        line += "; the points were SIMULATED, which says nothing of the real oils"
    return [line]
