"""The sections of a campaign's report, in their order.

The answer comes first. Then: data, refusals, fits, constants, comparison of laws, bearing. A
function builds one section; the templates beside this module have its sentences.

Decides: which sections a report has, and what they tell.
"""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple
from urllib.parse import quote

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.base import studies
from oilfilm.curation.coverage import planned_states
from oilfilm.fits.best_law import FEWEST_CURVES
from oilfilm.fits.certificate_sentences import certificate_sentence
from oilfilm.fits.conditions import fixed_conditions_from_json
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.interval import CONFIDENCE
from oilfilm.fits.soundness_sentences import soundness_warnings
from oilfilm.fits.surface_sentences import spin_sentence, surface_sentences
from oilfilm.logs.run_sheet import REMARK_RULES
from oilfilm.report.accepted_runs import lost_runs, names_of_unread_logs, shortfall_sentences
from oilfilm.report.document import (
    Fact,
    Section,
    ShownTable,
    facts_from_template,
    format_by_error,
    number_formatter,
    show_table,
)
from oilfilm.report.explorer import Axis, as_json, explored_fits, load_at_1_gpa, sliders
from oilfilm.report.names import CONDITION_TEXTS, gate_in_words, law_title
from oilfilm.settings.resolved import Settings
from oilfilm.surface.interval import normal_half_width
from oilfilm.tables import failed_gates
from oilfilm.tables.campaign_tables import CURVE_COLUMNS, CampaignTables
from oilfilm.tables.set_points import NOMINAL_COLUMNS
from oilfilm.torque.answers import CAUSE_BY_NAME, interval_text, range_text, what_to_measure
from oilfilm.torque.best_oil import NOT_KNOWN
from oilfilm.torque.operating_grid import AXIS_NAMES
from oilfilm.torque.torque_control import (
    bistable_points_text,
    drop_bistable_plateaus,
    is_bistable,
    undecided_plateau_count,
)
from oilfilm.traction import LAWS

# These constants choose words and what is counted. Verdicts are in the tables.
# An odd curve whose mean ratio to the fit differs from 1 by less than this has another shape.
_GAIN_OF_OTHER_SHAPE = 0.03
# Share of the points whose uncertainty is below the one in the table of fits.
_POINT_QUANTILE = 0.95
# Smallest mu whose relative uncertainty means something, as a share of the largest mu.
_SMALLEST_RELATIVE_MU = 0.01
# Smallest share of variance at which a cause is listed.
_SMALLEST_SHARE = 0.005
# Why a comparison with Wang-Deng shows nothing where the law `deng2026` made the points.
_TIE_BY_CONSTRUCTION = (
    "the same law by construction: Eq. 7 made the SIMULATED points, and for one ball size "
    "load-based Wang-Deng with D = -A is Eq. 7. Dimensionless Wang-Deng is another law. It is at a "
    "disadvantage, because Eq. 7 made the points"
)


def fits_section(results: CampaignTables) -> Section:
    """Misfit, certificate and uncertainty of each fit, noise and lack of fit."""
    quality = results.configured_fits.fit_quality
    lack_of_fit = results.lack_of_fit
    verdict_by_oil = {str(row["oil"]): row for row in tables.rows(results.soundness)}
    facts_on_fits = facts_from_template(
        "report/sections/fits.jinja",
        fitted=tables.rows(quality[quality["rmse"].notna()]),
        warnings={oil: soundness_warnings(row) for oil, row in verdict_by_oil.items()},
        surface_sentences={
            oil: _surface_sentences(results, oil, row) for oil, row in verdict_by_oil.items()
        },
        unfitted=[
            {"oil": row["oil"], "certificate": certificate_sentence(row)}
            for row in tables.rows(quality[quality["rmse"].isna()])
        ],
        odd_curves=_odd_curves(results.configured_fits.curve_residuals),
        same_gain=_GAIN_OF_OTHER_SHAPE,
        misfits=tables.rows(lack_of_fit),
        # no run is repeated, or repeats do not tell noise and lack of fit apart
        without_pure_error=tables.rows(lack_of_fit[lack_of_fit["verdict"] == "no repeats"]),
    )
    shown_tables = [
        show_table(quality.join(relative_uncertainty(results), on="oil"), "fit_quality"),
        show_table(lack_of_fit, "lack_of_fit"),
    ]
    return Section("fits", "Fits", facts_on_fits, shown_tables)


def _surface_sentences(results: CampaignTables, oil: str, verdict: Mapping[str, Any]) -> list[str]:
    """Sentences on what the surface of an oil says, and on what its interval leaves out."""
    sentences = surface_sentences(results, oil, verdict)
    runs = results.table("runs", ["oil", "rig", "verdict", "warning"])
    spin_text = spin_sentence(runs, oil)
    return [*sentences, spin_text] if sentences and spin_text else sentences


def curve_facts(quality: pd.DataFrame, residuals: pd.DataFrame) -> list[Fact]:
    """Curves that are left out of fits, and curves that pull them away.

    Args:
        quality: Rows of the table of fit quality.
        residuals: Table of curve residuals, of the same fits.
    """
    fitted = tables.rows(quality)
    return facts_from_template(
        "report/sections/curves.jinja",
        fitted=fitted,
        odd_curves=_odd_curves(residuals),
        same_gain=_GAIN_OF_OTHER_SHAPE,
    )


def _odd_curves(residuals: pd.DataFrame) -> dict[str, list[dict[str, Any]]]:
    """Rows of the curves that pull a fit away, by oil; the strongest ones first."""
    odd_curves = residuals[residuals["odd"]].sort_values("robust_weight", kind="stable")
    return {str(oil): tables.rows(rows) for oil, rows in odd_curves.groupby("oil")}


def relative_uncertainty(results: CampaignTables) -> pd.DataFrame:
    """Half of the interval of the next run's mu, over mu, at the accepted points of each oil.

    The level is 95 %, or the largest one that the surface has. Columns `median` and `largest` by
    oil; `largest` is the 95 % quantile over the points. Null where the fit has no interval. Points
    near pure rolling are left out, because their mu is nearly zero. So are those of curves that the
    fit leaves out, because a condition is not known.
    """
    quantiles_by_oil = {}
    for oil in results.configured_fits.fit_quality["oil"]:
        fit = FittedLaw.from_results(results, oil)
        columns = ["accepted", *fit.law.conditions, "slide_roll_ratio"]
        accepted_points = results.table("points", columns, oil=oil)
        accepted_points = accepted_points[accepted_points["accepted"]]
        conditions = accepted_points[list(fit.law.conditions)].to_numpy(float)
        slip = accepted_points["slide_roll_ratio"].to_numpy(float)
        mu_sizes, widths = [], []
        for prediction in fit.predictions(conditions, slip):
            mu_sizes.append(np.abs(prediction.traction_coefficient))
            widths.append(prediction.obs_ci_upper - prediction.obs_ci_lower)
        mu_size, width = np.concatenate(mu_sizes), np.concatenate(widths)
        # NaN, where a condition is not known, is no largest mu
        largest_mu = np.fmax.reduce(mu_size, initial=0.0)
        is_large_enough = mu_size > _SMALLEST_RELATIVE_MU * largest_mu
        relative_half_width = pd.Series(width[is_large_enough] / 2 / mu_size[is_large_enough])
        quantiles_by_oil[oil] = (
            relative_half_width.median(),
            relative_half_width.quantile(_POINT_QUANTILE),
        )
    index = pd.Index(quantiles_by_oil, dtype=str)
    return pd.DataFrame(list(quantiles_by_oil.values()), index, columns=["median", "largest"])


_COMPARISON_IN_WORDS = {"best": "best of those compared", "tie": "ties with others"}


class _PredictedMu(NamedTuple):
    """mu at one operating point, and its interval as text."""

    mu: float
    interval: str


def answer_section(results: CampaignTables, settings: Settings) -> Section:
    """One row per oil: mu at one operating point with its interval, the law, runs, soundness."""
    load_n_at_1_gpa = load_at_1_gpa(settings)
    fit_by_oil = explored_fits(results, load_n_at_1_gpa)
    axes = sliders(fit_by_oil, results, settings)
    operating_point = [np.nan if axis.idle else axis.start for axis in axes]
    predicted_by_oil = {}
    for oil in list(fit_by_oil):
        # a fit keeps its surface: it goes before the next one
        fit = fit_by_oil.pop(oil)
        predicted_by_oil[oil] = _predicted_mu(fit, operating_point, load_n_at_1_gpa)
    comparison_by_oil = {
        row["oil"]: _comparison_in_words(row) for row in tables.rows(results.law_verdicts)
    }
    soundness_by_oil = {
        row["oil"]: _soundness_in_words(row) for row in tables.rows(results.soundness)
    }
    runs = results.table("runs", ["oil", "verdict"])
    is_accepted = runs["verdict"] == "accepted"
    accepted_text_by_oil = {
        oil: f"{accepted_of_oil.sum()} of {len(accepted_of_oil)}"
        for oil, accepted_of_oil in is_accepted.groupby(runs["oil"])
    }
    oils = results.configured_fits.fit_quality["oil"]
    unknown_mu = _PredictedMu(np.nan, "not known")
    answers = results.configured_fits.fit_quality.assign(
        mu=[predicted_by_oil.get(oil, unknown_mu).mu for oil in oils],
        interval=[predicted_by_oil.get(oil, unknown_mu).interval for oil in oils],
        beside=[comparison_by_oil.get(oil, "not compared") for oil in oils],
        fit=[soundness_by_oil.get(oil, "not sound") for oil in oils],
        runs=[accepted_text_by_oil.get(oil, "none") for oil in oils],
    )
    table = show_table(answers, "answers", f"At {_point_in_words(axes)}")
    return Section("answer", "Answer", tables=[table])


def _point_in_words(axes: Sequence[Axis]) -> str:
    """The start of each slider that is not idle, as `P 1.25 GPa, U 25 m/s`."""
    texts = []
    for axis in axes:
        if not axis.idle:
            symbol, _, unit = CONDITION_TEXTS[axis.name]
            texts.append(f"{symbol} {axis.start:.{axis.digits}f} {unit}".rstrip())
    return ", ".join(texts)


def _predicted_mu(
    fit: FittedLaw, operating_point: Sequence[float], load_n_at_1_gpa: float | None
) -> _PredictedMu:
    """mu of a fit with its interval.

    Args:
        fit: The fit.
        operating_point: P, U, T and S.
        load_n_at_1_gpa: Load (N) of the rig's contact at 1 GPa.
    """
    conditions = np.array([operating_point[:3]])
    slip = np.array(operating_point[3:])
    if load_n_at_1_gpa is not None and "load_n" in fit.law.conditions:
        conditions[0, 0] = load_n_at_1_gpa * operating_point[0] ** 3
    prediction = fit.predict(conditions, slip)
    lower = prediction.obs_ci_lower[0]
    upper = prediction.obs_ci_upper[0]
    mu_interval = "not known"
    if not np.isnan(lower) and not np.isnan(upper):
        level = fit.interval_level(CONFIDENCE)
        mu_interval = f"{lower:#.3g} to {upper:#.3g} ({100 * level:.2g} %)"
    if prediction.outside[0]:
        mu_interval += ", not tested there"
    if prediction.over_limit[0]:
        mu_interval += ", above the limiting shear stress"
    return _PredictedMu(prediction.traction_coefficient[0], mu_interval)


def _soundness_in_words(row: Mapping[str, Any]) -> str:
    """Whether a fit is sound; if not, which verdicts are against it. Trouble has the sentences."""
    if row["sound"]:
        return "sound"
    defects = []
    if not row["optimum_confirmed"]:
        defects.append("optimum not confirmed")
    if row["law_verdict"] != "adequate":
        defects.append(f"law: {row['law_verdict']}")
    if row["campaign_verdict"] != "steady":
        defects.append(f"campaign: {row['campaign_verdict']}")
    return f"not sound ({'; '.join(defects)})"


def _comparison_in_words(row: Mapping[str, Any]) -> str:
    """The configured law compared with the others, in words."""
    verdict = row["verdict"]
    if verdict == "another law is better":
        return f"worse than {law_title(row['better_law'])}"
    return _COMPARISON_IN_WORDS.get(verdict, f"not decided: {verdict}")


def constants_section(results: CampaignTables) -> Section:
    """One table per oil, and a sentence for each constant that the data do not determine."""
    coefficients = results.configured_fits.coefficients
    quality = results.configured_fits.fit_quality.set_index("oil")
    rows_of_template = []
    shown_tables: list[ShownTable] = []
    for oil, coefficients_of_oil in coefficients.groupby("oil", sort=False):
        shown_tables.append(_constants_table(coefficients_of_oil, f"constants{len(shown_tables)}"))
        if coefficients_of_oil["value"].notna().any():
            fixed_conditions = fixed_conditions_from_json(quality["fixed_conditions"][oil])
            rows_of_template.append(
                {
                    "oil": str(oil),
                    "curves": quality["n_curves"][oil],
                    "constants": tables.rows(coefficients_of_oil),
                    "fixed": [fixed.sentence() for fixed in fixed_conditions],
                }
            )
    facts_on_constants = facts_from_template(
        "report/sections/constants.jinja", fits=rows_of_template
    )
    return Section("constants", "Constants", facts_on_constants, shown_tables)


def _constants_table(coefficients: pd.DataFrame, name: str) -> ShownTable:
    """Constants of one oil with their errors; a value has the digits that its error allows."""
    numeric_columns = ["value", "standard_error", "systematic_standard_error", "lower", "upper"]
    texts = coefficients.astype(object)
    for index, row in coefficients.iterrows():
        error = row["standard_error"]
        if np.isnan(error):
            error = row["naive_standard_error"]
        form = number_formatter(format_by_error(error))
        texts.loc[index, numeric_columns] = [form(row[column]) for column in numeric_columns]
    interval = texts["lower"] + " \N{HORIZONTAL ELLIPSIS} " + texts["upper"]
    texts["lower"] = texts["lower"].where(coefficients["lower"].isna(), interval)
    return show_table(texts, "constants", coefficients["oil"].iloc[0], name)


def laws_section(results: CampaignTables, settings: Settings) -> Section:
    """The best law of each oil, what to do, and the errors of all laws side by side."""
    # beside Wang-Deng, simulated data of such a truth always need this sentence
    compares_wang_deng = results.fit_quality["law"].str.startswith("wang-deng").any()
    is_tied = settings.campaign.truth_is_law and compares_wang_deng
    tie = f"Wang-Deng here: {_TIE_BY_CONSTRUCTION}" if is_tied else ""
    facts_on_laws = law_facts(results.law_verdicts, results.fit_quality, tie)
    verdict_table = show_table(results.law_verdicts, "law_verdicts")
    error_table = show_table(results.fit_quality, "comparison")
    return Section("laws", "Laws", facts_on_laws, [verdict_table, error_table])


def law_facts(verdicts: pd.DataFrame, quality: pd.DataFrame, tie: str = "") -> list[Fact]:
    """The configured law of each oil compared with the others, and what to do.

    Oils with the same comparison share one sentence.

    Args:
        verdicts: Table `law_verdicts`.
        quality: Table `fit_quality`, with every law.
        tie: A sentence on laws that are the same by construction; none if empty.
    """
    comparisons: list[dict[str, Any]] = []
    oils_of_comparison: list[list[str]] = []
    for row in tables.rows(verdicts):
        comparison = _law_comparison(row, quality[quality["oil"] == row["oil"]])
        if comparison not in comparisons:
            comparisons.append(comparison)
            oils_of_comparison.append([])
        oils_of_comparison[comparisons.index(comparison)].append(row["oil"])
    rows_of_template = [
        comparison | {"oils": oils}
        for comparison, oils in zip(comparisons, oils_of_comparison, strict=True)
    ]
    return facts_from_template(
        "report/sections/laws.jinja",
        rows=rows_of_template,
        tie=tie,
        fewest_curves=FEWEST_CURVES,
        can_be_set=list(LAWS),
    )


def _law_comparison(row: Mapping[str, Any], quality: pd.DataFrame) -> dict[str, Any]:
    """The comparison of laws for one oil, as the template needs it.

    Args:
        row: Row of the table `law_verdicts`.
        quality: Rows of the table `fit_quality` of the oil.
    """
    fit_by_law = {fit["law"]: fit for fit in tables.rows(quality)}
    better_law = row["better_law"]
    bic_ties = row["bic_ties"] or ()
    tied_laws = [law for law in row["left_out_ties"] or () if law in bic_ties]
    return {
        "verdict": row["verdict"],
        "law": row["law"],
        "better_law": better_law,
        "same_laws": [law_title(law) for law in row["same_laws"] or ()],
        "same_laws_as_better": [law_title(law) for law in row["same_as_better_law"] or ()],
        "tied_with": sorted(law_title(law) for law in tied_laws if law != row["law"]),
        "simplest_tied_law": min(
            tied_laws, key=lambda law: fit_by_law[law]["n_constants"], default=""
        ),
        "best_usable_law": _best_usable_law(row["law"], fit_by_law),
        "is_better_unconfirmed": better_law in fit_by_law
        and not fit_by_law[better_law]["certified"],
    }


def _best_usable_law(configured_law: str, fit_by_law: Mapping[str, Mapping[str, Any]]) -> str:
    """The law of least error at curves left out, of those that `fit.law` takes.

    Empty if it is the configured law.

    Args:
        configured_law: The configured law.
        fit_by_law: Row of the table `fit_quality` of each law.
    """
    error_by_law = {name: fit["left_out_rmse"] for name, fit in fit_by_law.items() if name in LAWS}
    known_error_by_law = {name: error for name, error in error_by_law.items() if np.isfinite(error)}
    best_law = min(
        known_error_by_law, key=lambda name: known_error_by_law[name], default=configured_law
    )
    return "" if best_law == configured_law else best_law


_CONDITION_STATES = ("accepted", "refused", "missing")


def data_section(results: CampaignTables, settings: Settings) -> Section:
    """Accepted runs and points, coverage of the test matrix, and whether the film was judged."""
    point_counts = Counter[str]()
    unjudged_count_by_oil = Counter[str]()
    for part in results.blocks("points", ["oil", "accepted", "film_judgement"]):
        point_counts.update(all=len(part), accepted=int(part["accepted"].sum()))
        is_unjudged = part["accepted"] & (part["film_judgement"] == "cannot be judged")
        unjudged_count_by_oil.update(part.loc[is_unjudged, "oil"])
    has_matrix = results.coverage["planned"].any()
    conditions = planned_states(results.coverage) if has_matrix else results.coverage
    facts_on_data = facts_from_template(
        "report/sections/data.jinja",
        results=results,
        runs=results.table("runs", ["verdict", "file", "samples"]),
        points=point_counts,
        settings=settings,
        unread_log_count=len(names_of_unread_logs(results)),
        shortfalls=shortfall_sentences(results, settings.campaign),
        has_matrix=has_matrix,
        conditions=conditions["state"].value_counts().reindex(_CONDITION_STATES, fill_value=0),
        unjudged=unjudged_count_by_oil,
        stand_ins=[name for name, oil in settings.oils.items() if oil and oil.stand_in],
    )
    return Section("data", "Data", facts_on_data, [run_list(results, settings.report.rows_max)])


def refused_section(results: CampaignTables, settings: Settings) -> Section:
    """What was refused: counts by gate, and the first case of each gate in words."""
    runs = results.table("runs", ["run_id", "file", "verdict", "rule"])
    rules = runs.loc[runs["verdict"] == "refused", "rule"]
    lost = lost_runs(results.quarantine, runs)
    rules_of_lost_runs = lost.loc[lost["file"].isin(runs["file"]), "rule"]
    counts = results.gate_counts
    counts = counts[~counts["gate"].isin(REMARK_RULES)]
    facts_on_refusals = facts_from_template(
        "report/sections/refused.jinja",
        refused_runs_by_gate=_count_by_gate(pd.concat([rules, rules_of_lost_runs]).value_counts()),
        unread_logs_by_gate=_count_by_gate(_rules_of_unread_logs(results).value_counts()),
        refused_point_count=(~results.table("points", ["accepted"])["accepted"]).sum(),
        cases=first_cases(results.quarantine),
        other_gates=counts[~counts["gate"].isin(results.quarantine["rule"])].to_dict("records"),
    )
    refusals = refusal_table(results.quarantine, "quarantine", settings.report.rows_max)
    return Section(
        "refused", "Refused", facts_on_refusals, [show_table(counts, "gate_counts"), refusals]
    )


def refusal_table(
    quarantine: pd.DataFrame, name: str, rows_max: int, caption: str = ""
) -> ShownTable:
    """Logs, runs and plateaus that were refused, with reason and advice.

    Args:
        quarantine: Table of refusals; a remark on the run sheet is none.
        name: Of the table in the page.
        rows_max: Largest number of rows that are shown.
        caption: Its caption, if not the declared one.
    """
    quarantine = quarantine[~quarantine["rule"].isin(REMARK_RULES)]
    return show_table(quarantine, "quarantine", caption, name, rows_max)


def first_cases(quarantine: pd.DataFrame) -> list[dict[str, object]]:
    """The first case of each gate with the number of cases; most cases first."""
    quarantine = quarantine[~quarantine["rule"].isin(REMARK_RULES)]
    count_by_rule = quarantine["rule"].value_counts()
    first_rows = quarantine.drop_duplicates("rule").set_index("rule").loc[count_by_rule.index]
    names = np.where(first_rows["run_id"] != "", first_rows["run_id"], first_rows["file"])
    gates_in_words = first_rows.index.map(gate_in_words)
    cases = first_rows.assign(gate=gates_in_words, name=names, count=count_by_rule)
    return tables.rows(cases.reset_index())


def _rules_of_unread_logs(results: CampaignTables) -> "pd.Series[str]":
    """The rule that refused each log of which no run could be read."""
    refusals = results.quarantine[~results.quarantine["rule"].isin(REMARK_RULES)]
    is_unread = refusals["file"].isin(names_of_unread_logs(results))
    return refusals[is_unread].drop_duplicates("file")["rule"]


def _count_by_gate(counts: "pd.Series[int]") -> dict[str, int]:
    """Counts by the names of gates in words."""
    return {gate_in_words(str(gate)): int(count) for gate, count in counts.items()}


def bearing_section(results: CampaignTables, settings: Settings) -> Section:
    """Torque logs, errors of the torque, share of traction, heat; empty without torque logs."""
    # a run has one row per plateau in this table, a refused run none
    plateaus = results.torque_runs
    refusals = results.torque_quarantine
    torque = results.torque
    if plateaus.empty and refusals.empty:
        return Section("bearing", "Bearing")
    kept_logs = set(plateaus["file"])
    read_logs = kept_logs | set(refusals.loc[refusals["stage"] == "curate", "file"])
    all_logs = read_logs | set(refusals.loc[~refusals["rule"].isin(REMARK_RULES), "file"])
    without_torque = plateaus[plateaus["accepted"] & ~plateaus["oil"].isin(torque["oil"])]
    converged = torque[torque["converged"]]
    with_one_motion = drop_bistable_plateaus(converged)
    plateau_key = ["run_id", "first_row"]
    facts_on_bearing = facts_from_template(
        "report/sections/bearing.jinja",
        kept=len(kept_logs),
        read=len(read_logs),
        logs=len(all_logs),
        plateaus=plateaus,
        limits_gpa=settings.bearing.pressure_limits_gpa,
        refused_plateaus=_count_by_gate(failed_gates.refusal_counts(plateaus)),
        cases=first_cases(refusals),
        not_calculated=without_torque["oil"].value_counts().to_dict(),
        torque=torque,
        converged=converged,
        plateaus_calculated=len(converged.drop_duplicates(plateau_key)),
        bistable=len(converged[is_bistable(converged)].drop_duplicates(plateau_key)),
        undecided=undecided_plateau_count(converged),
        bistable_points=bistable_points_text(converged),
        why_lost=_reasons_lost(torque[~torque["converged"]]),
        lacks_refits=_lacks_refits(with_one_motion, results.configured_fits.coefficients),
        lacks_momentum=converged["momentum_torque_n_m"].isna().any(),
        control=_truths_by_verdict(results.torque_control),
        pressure_based=converged[converged["load_variable"] == "stress"],
        inversion=results.torque_inversion["verdict"].tolist(),
        next_measurements=_next_measurements(results.variance_shares),
        **_heat_variables(results.heat_balance),
    )
    caption = "Refused torque logs, runs and plateaus"
    rows_max = settings.report.rows_max
    refusals_table = refusal_table(refusals, "torque_quarantine", rows_max, caption)
    answers = show_table(_answers_in_words(results.bearing_answers), "bearing_answers")
    shares = show_table(_shares_in_words(results.variance_shares), "variance_shares")
    shown_tables = [answers, shares, _error_table(with_one_motion), refusals_table]
    return Section("bearing", "Bearing", facts_on_bearing, shown_tables)


def _lacks_refits(torque: pd.DataFrame, coefficients: pd.DataFrame) -> bool:
    """Whether no torque has an uncertainty because the laws of its oils have no refits.

    Args:
        torque: Rows of the table `torque`.
        coefficients: Constants of the configured laws; without refits they have no errors.
    """
    errors = coefficients.loc[coefficients["oil"].isin(torque["oil"]), "standard_error"]
    is_known = torque["verdict"] != "not known"
    return len(torque) > 0 and not is_known.any() and bool(errors.isna().all())


def _answers_in_words(answers: pd.DataFrame) -> pd.DataFrame:
    """Torque, power loss and cage slip with their intervals, and the best oil, as texts.

    Args:
        answers: Table of bearing answers.
    """
    texts_by_column = {}
    for text_column, column, factor in (
        ("torque", "torque_n_m", 1.0),
        ("power", "power_w", 1.0),
        ("slip", "cage_slip", 100.0),
    ):
        values_and_ends = (
            factor * answers[[column, f"{column}_lower", f"{column}_upper"]]
        ).to_numpy()
        texts_by_column[text_column] = [interval_text(*row) for row in values_and_ends]
    point_columns = ["axial_load_n", "inner_speed_rpm", "inlet_temperature_c"]
    share_of_best_oil = answers.loc[
        answers["oil"] == answers["best_oil"], [*point_columns, "best_share"]
    ]
    best_shares = (
        answers[point_columns]
        .merge(share_of_best_oil, on=point_columns, how="left")["best_share"]
        .to_numpy()
    )
    texts_by_column["best"] = [
        f"{oil} ({best_share:.0%})" if np.isfinite(best_share) else oil or "none has a full film"
        for oil, best_share in zip(answers["best_oil"], best_shares, strict=True)
    ]
    return answers.assign(**texts_by_column)


def _median_shares(shares: pd.DataFrame) -> pd.DataFrame:
    """Medians of the shares and ranges of each cause, over oils and points; largest share first."""
    range_columns = ["range_low", "range_high", "standard_uncertainty"]
    medians = shares.groupby("variance_cause", sort=False)[
        ["torque_share", "slip_share", *range_columns]
    ].median()
    return medians.sort_values("torque_share", ascending=False, kind="stable").reset_index()


def _shares_in_words(shares: pd.DataFrame) -> pd.DataFrame:
    """Causes of the variance in words, without those that make none of it.

    A cause of unknown share is among them, unless no share is known.

    Args:
        shares: Table of variance shares.
    """
    medians = _median_shares(shares)
    larger_share = medians[["torque_share", "slip_share"]].max(axis=1)
    is_unknown = larger_share.isna() & bool(larger_share.notna().any())
    shown_causes = medians[(larger_share >= _SMALLEST_SHARE) | is_unknown]
    return shown_causes.assign(
        meaning=[CAUSE_BY_NAME[cause].meaning for cause in shown_causes["variance_cause"]],
        drawn_from=[range_text(row) for _, row in shown_causes.iterrows()],
    )


def _next_measurements(shares: pd.DataFrame) -> list[dict[str, Any]]:
    """What to measure so that torque and cage slip become more certain, the largest cause first."""
    measurements = []
    for column, answer_name in (("torque_share", "friction torque"), ("slip_share", "cage slip")):
        causes = what_to_measure(shares, column) if len(shares) else []
        if causes:
            measures = [measure for _, measure in causes]
            measurements.append({"answer": answer_name, "measures": measures})
    return measurements


def _reasons_lost(torque: pd.DataFrame) -> list[str]:
    """Why friction equilibria were not found, a sentence per reason.

    Args:
        torque: Rows of the table `torque` without an equilibrium.
    """
    sentences = []
    too_wide = torque[torque["no_equilibrium"] == "contacts too wide"]
    if len(too_wide):
        widest = too_wide["widest_contact"].max()
        sentences.append(
            f"at {len(too_wide)} the contacts would be up to {widest:.2g} times as wide as the "
            "balls; check the axial load and its unit"
        )
    unbalanced = torque[torque["no_equilibrium"] == "out of balance"]
    if len(unbalanced):
        largest = unbalanced["residual"].max(skipna=False)
        size = "" if np.isnan(largest) else f" by up to {largest:.2g} of a ball's load"
        sentences.append(
            f"at {len(unbalanced)} forces stay out of balance{size}; no steady motion was found"
        )
    return sentences


def _truths_by_verdict(control: pd.DataFrame) -> list[dict[str, Any]]:
    """For each verdict on the simulated truths of the two rigs: their misfit, and its oils."""
    return [
        {"verdict": verdict, "misfit": rows["law_misfit"].max(), "oils": rows["oil"].tolist()}
        for verdict, rows in control.groupby("verdict", sort=False)
    ]


def _heat_variables(balance: pd.DataFrame) -> dict[str, Any]:
    """Variables of the template: effect of friction heat on temperatures, torque and best oils."""
    # rows with a run are those of torque logs
    map_rows = balance[balance["run_id"] == ""]
    balanced = map_rows[map_rows["balanced"].fillna(False)]
    points = map_rows.drop_duplicates(["inner_speed_rpm", "axial_load_n"])
    has_best_oils = (points[["best_oil", "heated_best_oil"]] != NOT_KNOWN).all(axis=1)
    with_best_oils = points[has_best_oils]
    relative_change = balanced["heated_torque_n_m"] / balanced["torque_n_m"] - 1
    is_other_oil = with_best_oils["best_oil"] != with_best_oils["heated_best_oil"]
    return {
        "heat_cases": map_rows["balanced"].notna().sum(),
        "balanced": len(balanced),
        "outlet": balanced["outlet_temperature_c"],
        # adding 0.0 turns a rounded -0.0 into 0.0
        "change": relative_change.round(2) + 0.0,
        "other_best_oil": is_other_oil.sum(),
        "both_known": len(with_best_oils),
        "map_points": len(points),
    }


def _error_table(torque: pd.DataFrame) -> ShownTable:
    """Error of the calculated torque against the measured one, by oil and load variable.

    Args:
        torque: Converged rows of the table `torque`, without those of a bistable cage.
    """
    with_error = torque.dropna(subset=["relative_error"])
    with_error = with_error.assign(
        error_size=with_error["relative_error"].abs(),
        share=with_error["traction_torque_n_m"] / with_error["torque_n_m"],
        agrees=with_error["verdict"] == "compatible",
        is_judged=with_error["verdict"] != "not known",
    )
    errors = with_error.groupby(["oil", "load_variable"], sort=False, as_index=False).agg(
        points=("error_size", "size"),
        median=("error_size", "median"),
        largest=("error_size", "max"),
        agrees=("agrees", "sum"),
        judged=("is_judged", "sum"),
        share=("share", "median"),
    )
    errors["agreeing"] = [
        f"{row['agrees']} of {row['judged']}" if row["judged"] else "not known"
        for row in tables.rows(errors)
    ]
    return show_table(errors, "torque")


# Columns of the table of runs that the list of runs shows.
_RUN_LIST_COLUMNS = ("run_id", "oil", "rig", *NOMINAL_COLUMNS, "verdict", "rule", "warning")


def run_list(results: CampaignTables, rows_max: int) -> ShownTable:
    """One row per run with its conditions and verdict, refused ones first.

    The first cell is a link to the signals of a refused run, or to the run's operating point in the
    chart. A run that has neither has no link.

    Args:
        results: Tables `runs`, `points` and `refused_pages`.
        rows_max: Largest number of rows that are shown.
    """
    runs = results.table("runs", [*_RUN_LIST_COLUMNS, "file"])
    runs = runs.assign(refused=runs["verdict"] != "accepted")
    runs = runs.sort_values("refused", ascending=False, kind="stable")
    points_of_run = pd.concat(
        part.groupby("run_id")["accepted"].agg(["sum", "size"])
        for part in results.blocks_of_runs("points", ["run_id", "accepted"])
    )
    counts = points_of_run.reindex(runs["run_id"], fill_value=0).astype(int)
    passed_texts = [f"{accepted} of {points}" for accepted, points in counts.to_numpy()]
    rows = runs.assign(passed=passed_texts, why=runs["rule"]).dropna(axis="columns", how="all")
    table = show_table(rows, "run-list", rows_max=rows_max)
    with_page = results.refused_pages[results.refused_pages["page"] != ""]
    # a torque run may have the same name
    file_and_run = ["file", "run_id"]
    page_by_run = with_page.drop_duplicates(file_and_run).set_index(file_and_run)["page"].to_dict()
    links = []
    shown_runs = runs.assign(accepted_points=counts["sum"].to_numpy())[:rows_max]
    for file, run_id, accepted_points in shown_runs[[*file_and_run, "accepted_points"]].to_numpy():
        page = page_by_run.get((file, run_id))
        if page is not None:
            links.append(f"#refused-{page.removesuffix('.png')}")
        else:
            links.append(f"#run?name={quote(run_id)}" if accepted_points else "")
    return replace(table, links=links)


_DIGITS = 6  # significant digits of a drawn value
_ERROR_DIGITS = 2


def drawn_points(results: CampaignTables, points_max: int) -> dict[str, Any]:
    """The accepted points that the page draws, as columns of numbers.

    Args:
        results: Table `points`.
        points_max: Largest number of points that are drawn; they are evenly chosen.
    """
    accepted_count = sum(
        int(part["accepted"].sum()) for part in results.blocks("points", ["accepted"])
    )
    step = max(math.ceil(accepted_count / points_max), 1)
    drawn_parts = []
    count_before = 0
    for part in results.blocks("points", CURVE_COLUMNS):
        accepted_points = part[part["accepted"]]
        # each point whose number, counted over all parts, is a multiple of the step
        first_index = -count_before % step
        drawn_parts.append(accepted_points.iloc[first_index::step])
        count_before += len(accepted_points)
    drawn_rows = pd.concat(drawn_parts, ignore_index=True)
    run_index, run_names = pd.factorize(drawn_rows["run_id"])
    half_width = normal_half_width(CONFIDENCE) * drawn_rows["traction_coefficient_se"]
    return {
        "names": run_names.tolist(),
        "run": run_index.tolist(),
        "oil": drawn_rows["oil"].tolist(),
        "axes": [as_json(drawn_rows[name], _DIGITS) for name in AXIS_NAMES],
        "mu": as_json(drawn_rows["traction_coefficient"], _DIGITS),
        "half": as_json(half_width.fillna(0), _ERROR_DIGITS),
        "left_out": accepted_count - len(drawn_rows),
    }


def campaign_sections(results: CampaignTables, settings: Settings) -> list[Section]:
    """All sections of a campaign that have any content; those of its studies come last.

    Args:
        results: The finished tables.
        settings: All settings of the campaign.
    """
    all_sections = [
        answer_section(results, settings),
        data_section(results, settings),
        refused_section(results, settings),
        fits_section(results),
        constants_section(results),
        laws_section(results, settings),
        bearing_section(results, settings),
    ]
    for study in studies.load_studies(settings.campaign.studies):
        all_sections += study.sections(results, settings)
    return [section for section in all_sections if section]
