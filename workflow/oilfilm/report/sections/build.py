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
from oilfilm.fits.certificate_sentences import certificate
from oilfilm.fits.conditions import fixed_from_text
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.interval import CONFIDENCE, normal_quantile
from oilfilm.fits.soundness_sentences import soundness_warnings
from oilfilm.fits.surface_sentences import spin_sentence, surface_sentences
from oilfilm.logs.run_sheet import REMARKS
from oilfilm.report.document import (
    Fact,
    Section,
    ShownTable,
    facts,
    number,
    show_table,
    significant,
)
from oilfilm.report.enough import shortfalls, unread_logs
from oilfilm.report.explorer import Axis, as_json, explored_fits, load_at_1_gpa, sliders
from oilfilm.report.names import CONDITIONS, gate_name, law_name
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from oilfilm.tables.campaign_tables import CURVE_POINTS, CampaignTables
from oilfilm.torque.answers import CAUSES, range_text, what_to_measure, with_interval
from oilfilm.torque.best_oil import NOT_KNOWN
from oilfilm.torque.operating_grid import AXES
from oilfilm.torque.torque_control import (
    bistable_points_text,
    is_bistable,
    undecided_plateaus,
    without_bistable,
)
from oilfilm.traction import LAWS

# These constants choose words and what is counted. Verdicts are in the tables.
# A curve whose mean ratio to the fit is nearer to 1 than this has another shape.
_SAME_GAIN = 0.03
# The table of fits has the uncertainty below which this share of the points is.
_SHARE_OF_POINTS = 0.95
# Share of the largest mu: a relative uncertainty of a smaller mu means nothing.
_SMALLEST_RELATIVE_MU = 0.01
# Share of variance below which a cause is not listed.
_SMALLEST_SHARE = 0.005
# Why a comparison with Wang-Deng shows nothing where the law `deng2026` made the points.
_TIE = (
    "the same law by construction: Eq. 7 made the SIMULATED points, and for one ball size "
    "load-based Wang-Deng with D = -A is Eq. 7. Dimensionless Wang-Deng is another law. It is at a "
    "disadvantage, because Eq. 7 made the points"
)


def fits(results: CampaignTables) -> Section:
    """Misfit, certificate and uncertainty of each fit, noise and lack of fit."""
    quality = results.configured.fit_quality
    lack_of_fit = results.lack_of_fit
    verdicts = {str(row["oil"]): row for row in tables.rows(results.soundness)}
    sentences = facts(
        "report/sections/fits.jinja",
        fitted=tables.rows(quality[quality["rmse"].notna()]),
        warnings={oil: soundness_warnings(row) for oil, row in verdicts.items()},
        surface_sentences={oil: _surface_facts(results, oil, row) for oil, row in verdicts.items()},
        lost=[
            {"oil": row["oil"], "certificate": certificate(row)}
            for row in tables.rows(quality[quality["rmse"].isna()])
        ],
        odd_curves=_odd_curves(results.configured.curve_residuals),
        same_gain=_SAME_GAIN,
        misfits=tables.rows(lack_of_fit),
        unrepeated=tables.rows(lack_of_fit[lack_of_fit["verdict"] == "no repeats"]),
    )
    shown_tables = [
        show_table(quality.join(relative_uncertainty(results), on="oil"), "fit_quality"),
        show_table(lack_of_fit, "lack_of_fit"),
    ]
    return Section("fits", "Fits", sentences, shown_tables)


def _surface_facts(results: CampaignTables, oil: str, verdict: Mapping[str, Any]) -> list[str]:
    """What the surface of an oil says, and what its interval does not know."""
    sentences = surface_sentences(results, oil, verdict)
    spin_text = spin_sentence(results.runs, oil)
    return [*sentences, spin_text] if sentences and spin_text else sentences


def curve_facts(quality: pd.DataFrame, residuals: pd.DataFrame) -> list[Fact]:
    """Curves that are left out of fits, and curves that pull them away.

    Args:
        quality: Rows of the table of fit quality.
        residuals: Table of curve residuals, of the same fits.
    """
    fitted = tables.rows(quality)
    return facts(
        "report/sections/curves.jinja",
        fitted=fitted,
        odd_curves=_odd_curves(residuals),
        same_gain=_SAME_GAIN,
    )


def _odd_curves(residuals: pd.DataFrame) -> dict[str, list[dict[str, Any]]]:
    """Rows of the curves that pull a fit away, by oil; the strongest ones first."""
    odd = residuals[residuals["odd"]].sort_values("robust_weight", kind="stable")
    return {str(oil): tables.rows(rows) for oil, rows in odd.groupby("oil")}


def relative_uncertainty(results: CampaignTables) -> pd.DataFrame:
    """Half of the 95 % interval of the next run's mu, over mu, at the accepted points of each oil.

    Columns `median` and `largest` by oil; `largest` is the 95 % quantile over the points. Null
    where the fit has no interval. Points near pure rolling are left out, because their mu is nearly
    zero.
    """
    rows = {}
    for oil in results.configured.fit_quality["oil"]:
        fit = FittedLaw.from_results(results, oil)
        columns = ["accepted", *fit.law.conditions, "slide_roll_ratio"]
        points = results.table("points", columns, oil=oil)
        points = points[points["accepted"]]
        conditions = points[list(fit.law.conditions)].to_numpy(float)
        slip = points["slide_roll_ratio"].to_numpy(float)
        mu_sizes, widths = [], []
        for prediction in fit.predictions(conditions, slip):
            mu_sizes.append(np.abs(prediction.traction_coefficient))
            widths.append(prediction.obs_ci_upper - prediction.obs_ci_lower)
        mu_size, width = np.concatenate(mu_sizes), np.concatenate(widths)
        is_large_enough = mu_size > _SMALLEST_RELATIVE_MU * mu_size.max(initial=0.0)
        relative = pd.Series(width[is_large_enough] / 2 / mu_size[is_large_enough])
        rows[oil] = (relative.median(), relative.quantile(_SHARE_OF_POINTS))
    index = pd.Index(rows, dtype=str)
    return pd.DataFrame(list(rows.values()), index, columns=["median", "largest"])


_COMPARISON_WORDS = {"best": "best of those compared", "tie": "ties with others"}


class _Predicted(NamedTuple):
    """mu at one operating point, and its interval in words."""

    mu: float
    interval: str


def answer(results: CampaignTables, settings: Settings) -> Section:
    """One row per oil: mu at one operating point with its interval, the law, runs, soundness."""
    load_n_at_1_gpa = load_at_1_gpa(settings)
    fit_of_oil = explored_fits(results, load_n_at_1_gpa)
    axes = sliders(fit_of_oil, results, settings)
    operating_point = [np.nan if axis.idle else axis.start for axis in axes]
    predictions = {}
    for oil in list(fit_of_oil):
        # a fit keeps its surface: it goes before the next one
        fit = fit_of_oil.pop(oil)
        predictions[oil] = _predicted(fit, operating_point, load_n_at_1_gpa)
    comparisons = {row["oil"]: _comparison(row) for row in tables.rows(results.law_verdicts)}
    soundness = {row["oil"]: _soundness(row) for row in tables.rows(results.soundness)}
    is_accepted = results.runs["verdict"] == "accepted"
    runs = {
        oil: f"{accepted_of_oil.sum()} of {len(accepted_of_oil)}"
        for oil, accepted_of_oil in is_accepted.groupby(results.runs["oil"])
    }
    oils = results.configured.fit_quality["oil"]
    not_predicted = _Predicted(np.nan, "not known")
    answers = results.configured.fit_quality.assign(
        mu=[predictions.get(oil, not_predicted).mu for oil in oils],
        interval=[predictions.get(oil, not_predicted).interval for oil in oils],
        beside=[comparisons.get(oil, "not compared") for oil in oils],
        fit=[soundness.get(oil, "not sound") for oil in oils],
        runs=[runs.get(oil, "none") for oil in oils],
    )
    table = show_table(answers, "answers", f"At {_point_in_words(axes)}")
    return Section("answer", "Answer", tables=[table])


def _point_in_words(axes: Sequence[Axis]) -> str:
    """The first values of sliders, as `P 1.25 GPa, U 25 m/s`; without idle ones."""
    texts = []
    for axis in axes:
        if not axis.idle:
            symbol, _, unit = CONDITIONS[axis.name]
            texts.append(f"{symbol} {axis.start:.{axis.digits}f} {unit}".rstrip())
    return ", ".join(texts)


def _predicted(
    fit: FittedLaw, operating_point: Sequence[float], load_at_1_gpa: float | None
) -> _Predicted:
    """mu of a fit with its interval.

    Args:
        fit: The fit.
        operating_point: P, U, T and S.
        load_at_1_gpa: Load (N) of the rig's contact at 1 GPa.
    """
    conditions = np.array([operating_point[:3]])
    slip = np.array(operating_point[3:])
    if load_at_1_gpa is not None and "load_n" in fit.law.conditions:
        conditions[0, 0] = load_at_1_gpa * operating_point[0] ** 3
    prediction = fit.predict(conditions, slip)
    lower = prediction.obs_ci_lower[0]
    upper = prediction.obs_ci_upper[0]
    interval = "not known"
    if not np.isnan(lower) and not np.isnan(upper):
        level = fit.interval_level(CONFIDENCE)
        interval = f"{lower:#.3g} to {upper:#.3g} ({100 * level:.2g} %)"
    if prediction.outside[0]:
        interval += ", not tested there"
    if prediction.over_limit[0]:
        interval += ", above the limiting shear stress"
    return _Predicted(prediction.traction_coefficient[0], interval)


def _soundness(row: Mapping[str, Any]) -> str:
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


def _comparison(row: Mapping[str, Any]) -> str:
    """The configured law compared with the others, in words."""
    verdict = row["verdict"]
    if verdict == "another law is better":
        return f"worse than {law_name(row['better_law'])}"
    return _COMPARISON_WORDS.get(verdict, f"not decided: {verdict}")


def constants(results: CampaignTables) -> Section:
    """One table per oil, and a sentence for each constant that the data do not determine."""
    coefficients = results.configured.coefficients
    quality = results.configured.fit_quality.set_index("oil")
    fits = []
    shown_tables: list[ShownTable] = []
    for oil, rows in coefficients.groupby("oil", sort=False):
        shown_tables.append(_constants_table(rows, f"constants{len(shown_tables)}"))
        if rows["value"].notna().any():
            fixed_conditions = fixed_from_text(quality["fixed_conditions"][oil])
            fits.append(
                {
                    "oil": str(oil),
                    "curves": quality["n_curves"][oil],
                    "constants": tables.rows(rows),
                    "fixed": [fixed.sentence() for fixed in fixed_conditions],
                }
            )
    sentences = facts("report/sections/constants.jinja", fits=fits)
    return Section("constants", "Constants", sentences, shown_tables)


def _constants_table(rows: pd.DataFrame, name: str) -> ShownTable:
    """Constants of one oil with their errors; a value has the digits that its error allows."""
    numbers = ["value", "standard_error", "systematic_standard_error", "lower", "upper"]
    texts = rows.astype(object)
    for index, row in rows.iterrows():
        error = row["standard_error"]
        if np.isnan(error):
            error = row["naive_standard_error"]
        form = number(significant(error))
        texts.loc[index, numbers] = [form(row[column]) for column in numbers]
    interval = texts["lower"] + " \N{HORIZONTAL ELLIPSIS} " + texts["upper"]
    texts["lower"] = texts["lower"].where(rows["lower"].isna(), interval)
    return show_table(texts, "constants", rows["oil"].iloc[0], name)


def laws(results: CampaignTables, settings: Settings) -> Section:
    """The best law of each oil, what to do, and the errors of all laws side by side."""
    # the comparison of laws on simulated data of such a truth always needs this sentence
    tie = f"Wang-Deng here: {_TIE}" if settings.campaign.truth_is_law else ""
    sentences = law_facts(results.law_verdicts, results.fit_quality, tie)
    verdicts = show_table(results.law_verdicts, "law_verdicts")
    errors = show_table(results.fit_quality, "comparison")
    return Section("laws", "Laws", sentences, [verdicts, errors])


def law_facts(verdicts: pd.DataFrame, quality: pd.DataFrame, tie: str = "") -> list[Fact]:
    """The configured law of each oil compared with the others, and what to do.

    Oils with the same comparison share one sentence.

    Args:
        verdicts: Table `law_verdicts`.
        quality: Table `fit_quality`, with every law.
        tie: A sentence on the laws of this campaign; none if empty.
    """
    comparisons: list[dict[str, Any]] = []
    oils_of_comparison: list[list[str]] = []
    for row in tables.rows(verdicts):
        comparison = _law_comparison(row, quality[quality["oil"] == row["oil"]])
        if comparison not in comparisons:
            comparisons.append(comparison)
            oils_of_comparison.append([])
        oils_of_comparison[comparisons.index(comparison)].append(row["oil"])
    rows = [
        comparison | {"oils": oils}
        for comparison, oils in zip(comparisons, oils_of_comparison, strict=True)
    ]
    return facts(
        "report/sections/laws.jinja",
        rows=rows,
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
    fits = {fit["law"]: fit for fit in tables.rows(quality)}
    better_law = row["better_law"]
    bic_ties = row["bic_ties"] or ()
    ties = [law for law in row["left_out_ties"] or () if law in bic_ties]
    return {
        "verdict": row["verdict"],
        "law": row["law"],
        "better_law": better_law,
        "same": [law_name(law) for law in row["same_laws"] or ()],
        "same_as_better": [law_name(law) for law in row["same_as_better_law"] or ()],
        "shared": sorted(law_name(law) for law in ties if law != row["law"]),
        "fewest": min(ties, key=lambda law: fits[law]["n_constants"], default=""),
        "usable": _best_usable_law(row["law"], fits),
        "unconfirmed": better_law in fits and not fits[better_law]["certified"],
    }


def _best_usable_law(configured_law: str, fits: Mapping[str, Mapping[str, Any]]) -> str:
    """The law of least error at curves left out that `fit.law` takes; empty for the configured one.

    Args:
        configured_law: The configured law.
        fits: Row of the table `fit_quality` of each law.
    """
    errors = {name: fit["left_out_rmse"] for name, fit in fits.items() if name in LAWS}
    known = {name: error for name, error in errors.items() if np.isfinite(error)}
    best = min(known, key=lambda name: known[name], default=configured_law)
    return "" if best == configured_law else best


_STATES = ("accepted", "refused", "missing")


def data(results: CampaignTables, settings: Settings) -> Section:
    """Accepted runs and points, coverage of the test matrix, and whether the film was judged."""
    points = Counter[str]()
    unjudged = Counter[str]()
    for part in results.parts("points", ["oil", "accepted", "film_judgement"]):
        points.update(all=len(part), accepted=int(part["accepted"].sum()))
        is_unjudged = part["accepted"] & (part["film_judgement"] == "cannot be judged")
        unjudged.update(part.loc[is_unjudged, "oil"])
    has_matrix = results.coverage["planned"].any()
    conditions = planned_states(results.coverage) if has_matrix else results.coverage
    sentences = facts(
        "report/sections/data.jinja",
        results=results,
        points=points,
        settings=settings,
        unread=len(unread_logs(results)),
        shortfalls=shortfalls(results, settings.campaign),
        has_matrix=has_matrix,
        conditions=conditions["state"].value_counts().reindex(_STATES, fill_value=0),
        unjudged=unjudged,
        stand_ins=[name for name, oil in settings.oils.items() if oil and oil.stand_in],
    )
    return Section("data", "Data", sentences, [run_list(results, settings.report.rows_max)])


def refused(results: CampaignTables, settings: Settings) -> Section:
    """Everything that was refused, the first case of each gate in words."""
    runs = results.runs
    counts = results.gate_counts
    counts = counts[~counts["gate"].isin(REMARKS)]
    sentences = facts(
        "report/sections/refused.jinja",
        verdicts=_by_gate_name(runs[runs["verdict"] == "refused"]["rule"].value_counts()),
        unread=_by_gate_name(_rules_of_unread_logs(results).value_counts()),
        points=(~results.table("points", ["accepted"])["accepted"]).sum(),
        cases=first_cases(results.quarantine),
        other_gates=counts[~counts["gate"].isin(results.quarantine["rule"])].to_dict("records"),
    )
    refusals = refusal_table(results.quarantine, "quarantine", settings.report.rows_max)
    return Section("refused", "Refused", sentences, [show_table(counts, "gate_counts"), refusals])


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
    quarantine = quarantine[~quarantine["rule"].isin(REMARKS)]
    return show_table(quarantine, "quarantine", caption, name, rows_max)


def first_cases(quarantine: pd.DataFrame) -> list[dict[str, object]]:
    """The first case of each gate with the number of cases; most cases first."""
    quarantine = quarantine[~quarantine["rule"].isin(REMARKS)]
    cases_of_rule = quarantine["rule"].value_counts()
    first = quarantine.drop_duplicates("rule").set_index("rule").loc[cases_of_rule.index]
    names = np.where(first["run_id"] != "", first["run_id"], first["file"])
    gates = first.index.map(gate_name)
    cases = first.assign(gate=gates, name=names, count=cases_of_rule)
    return tables.rows(cases.reset_index())


def _rules_of_unread_logs(results: CampaignTables) -> "pd.Series[str]":
    """The rule that refused each log of which no run could be read."""
    is_unread = results.quarantine["file"].isin(unread_logs(results))
    return results.quarantine[is_unread].drop_duplicates("file")["rule"]


def _by_gate_name(counts: "pd.Series[int]") -> dict[str, int]:
    """Counts by the names of gates in words."""
    return {gate_name(str(gate)): int(count) for gate, count in counts.items()}


def bearing(results: CampaignTables, settings: Settings) -> Section:
    """Torque logs, errors of the torque, share of traction, heat; empty without torque logs."""
    runs = results.torque_runs
    refused = results.torque_quarantine
    torque = results.torque
    if runs.empty and refused.empty:
        return Section("bearing", "Bearing")
    # `LOG` or `LOG:RUN`
    kept_logs = {run_id.rpartition(":")[0] or run_id for run_id in runs["run_id"]}
    # a refused run has no row in the table of runs
    read_logs = kept_logs | set(refused.loc[refused["stage"] == "curate", "file"])
    all_logs = read_logs | set(refused.loc[~refused["rule"].isin(REMARKS), "file"])
    without_torque = runs[runs["accepted"] & ~runs["oil"].isin(torque["oil"])]
    converged = torque[torque["converged"]]
    with_one_motion = without_bistable(converged)
    plateau = ["run_id", "first_row"]
    sentences = facts(
        "report/sections/bearing.jinja",
        kept=len(kept_logs),
        read=len(read_logs),
        logs=len(all_logs),
        plateaus=runs,
        limits_gpa=settings.bearing.pressure_limits_gpa,
        refused_plateaus=_by_gate_name(failed_gates.counts(runs)),
        cases=first_cases(refused),
        not_calculated=without_torque["oil"].value_counts().to_dict(),
        torque=torque,
        sound=converged,
        plateaus_calculated=len(converged.drop_duplicates(plateau)),
        bistable=len(converged[is_bistable(converged)].drop_duplicates(plateau)),
        undecided=undecided_plateaus(converged),
        bistable_points=bistable_points_text(converged),
        why_lost=_why_lost(torque[~torque["converged"]]),
        has_uncertainty=converged.empty or (with_one_motion["verdict"] != "not known").any(),
        control=_control(results.torque_control),
        by_stress=converged[converged["load_variable"] == "stress"],
        inversion=results.torque_inversion["verdict"].tolist(),
        next_measurements=_next_measurements(results.variance_shares),
        **_heat(results.heat_balance),
    )
    caption = "Refused torque logs, runs and plateaus"
    rows_max = settings.report.rows_max
    refusals = refusal_table(refused, "torque_quarantine", rows_max, caption)
    answers = show_table(_answers_in_words(results.bearing_answers), "bearing_answers")
    shares = show_table(_shares_in_words(results.variance_shares), "variance_shares")
    shown_tables = [answers, shares, _error_table(with_one_motion), refusals]
    return Section("bearing", "Bearing", sentences, shown_tables)


def _answers_in_words(answers: pd.DataFrame) -> pd.DataFrame:
    """Torque, power loss and cage slip with their intervals, and the best oil, as texts.

    Args:
        answers: Table of bearing answers.
    """
    texts = {}
    for text, column, factor in (
        ("torque", "torque_n_m", 1.0),
        ("power", "power_w", 1.0),
        ("slip", "cage_slip", 100.0),
    ):
        ends = (factor * answers[[column, f"{column}_lower", f"{column}_upper"]]).to_numpy()
        texts[text] = [with_interval(*row) for row in ends]
    point = ["axial_load_n", "inner_speed_rpm", "inlet_temperature_c"]
    best = answers.loc[answers["oil"] == answers["best_oil"], [*point, "best_share"]]
    share = answers[point].merge(best, on=point, how="left")["best_share"].to_numpy()
    texts["best"] = [
        f"{oil or 'none has a full film'} ({best_share:.0%})"
        if np.isfinite(best_share)
        else oil or "none"
        for oil, best_share in zip(answers["best_oil"], share, strict=True)
    ]
    return answers.assign(**texts)


def _median_shares(shares: pd.DataFrame) -> pd.DataFrame:
    """Median of each cause over oils and points, with its range; the largest of torque first."""
    numbers = ["range_low", "range_high", "standard_uncertainty"]
    medians = shares.groupby("variance_cause", sort=False)[
        ["torque_share", "slip_share", *numbers]
    ].median()
    return medians.sort_values("torque_share", ascending=False, kind="stable").reset_index()


def _shares_in_words(shares: pd.DataFrame) -> pd.DataFrame:
    """Causes of the variance in words, without those that make none of it.

    Args:
        shares: Table of variance shares.
    """
    medians = _median_shares(shares)
    largest = medians[["torque_share", "slip_share"]].max(axis=1)
    shown = medians[largest >= _SMALLEST_SHARE]
    return shown.assign(
        meaning=[CAUSES[cause].meaning for cause in shown["variance_cause"]],
        drawn_from=[range_text(row) for _, row in shown.iterrows()],
    )


def _next_measurements(shares: pd.DataFrame) -> list[dict[str, Any]]:
    """What to measure so that torque and cage slip become more certain, the largest cause first."""
    measurements = []
    for column, name in (("torque_share", "friction torque"), ("slip_share", "cage slip")):
        causes = what_to_measure(shares, column) if len(shares) else []
        if causes:
            measures = [measure for _, measure in causes]
            measurements.append({"answer": name, "measures": measures})
    return measurements


def _why_lost(torque: pd.DataFrame) -> list[str]:
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


def _control(control: pd.DataFrame) -> list[dict[str, Any]]:
    """Oils and misfit of the simulated truths of both rigs, by verdict."""
    return [
        {"verdict": verdict, "misfit": rows["law_misfit"].max(), "oils": rows["oil"].tolist()}
        for verdict, rows in control.groupby("verdict", sort=False)
    ]


def _heat(balance: pd.DataFrame) -> dict[str, Any]:
    """Effect of friction heat on the map of cage slip: temperatures, torque, best oils."""
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
        size=with_error["relative_error"].abs(),
        share=with_error["traction_torque_n_m"] / with_error["torque_n_m"],
        agrees=with_error["verdict"] == "compatible",
        is_judged=with_error["verdict"] != "not known",
    )
    errors = with_error.groupby(["oil", "load_variable"], sort=False, as_index=False).agg(
        points=("size", "size"),
        median=("size", "median"),
        largest=("size", "max"),
        agrees=("agrees", "sum"),
        judged=("is_judged", "sum"),
        share=("share", "median"),
    )
    errors["agreeing"] = [
        f"{row['agrees']} of {row['judged']}" if row["judged"] else "not known"
        for row in tables.rows(errors)
    ]
    return show_table(errors, "torque")


def run_list(results: CampaignTables, rows_max: int) -> ShownTable:
    """One row per run with its conditions and verdict, refused ones first.

    The first cell is a link to the run's operating point in the chart, or to its signals.

    Args:
        results: Tables `runs`, `points` and `refused_pages`.
        rows_max: Largest number of rows that are shown.
    """
    runs = results.runs.assign(refused=results.runs["verdict"] != "accepted")
    runs = runs.sort_values("refused", ascending=False, kind="stable")
    points_of_run = pd.concat(
        part.groupby("run_id")["accepted"].agg(["sum", "size"])
        for part in results.parts_of_runs("points", ["run_id", "accepted"])
    )
    counts = points_of_run.reindex(runs["run_id"], fill_value=0).astype(int)
    passed = [f"{accepted} of {points}" for accepted, points in counts.to_numpy()]
    rows = runs.assign(passed=passed, why=runs["rule"]).dropna(axis="columns", how="all")
    table = show_table(rows, "run-list", rows_max=rows_max)
    with_page = results.refused_pages[results.refused_pages["page"] != ""]
    # a torque run may have the same name: its page comes later
    pages = with_page.drop_duplicates("run_id").set_index("run_id")["page"]
    links = []
    for run_id in runs["run_id"][:rows_max]:
        if run_id in pages.index:
            links.append(f"#refused-{pages[run_id].removesuffix('.png')}")
        else:
            links.append(f"#run?name={quote(run_id)}")
    return replace(table, links=links)


_DIGITS = 6  # significant digits of a drawn value
_ERROR_DIGITS = 2


def drawn_points(results: CampaignTables, points_max: int) -> dict[str, Any]:
    """The accepted points that the page draws, as columns of numbers.

    Args:
        results: Table `points`.
        points_max: Largest number of points that are drawn; they are evenly chosen.
    """
    accepted = sum(int(part["accepted"].sum()) for part in results.parts("points", ["accepted"]))
    every_nth = max(math.ceil(accepted / points_max), 1)
    drawn_parts = []
    points_before = 0
    for part in results.parts("points", CURVE_POINTS):
        accepted_points = part[part["accepted"]]
        drawn_parts.append(accepted_points.iloc[-points_before % every_nth :: every_nth])
        points_before += len(accepted_points)
    drawn = pd.concat(drawn_parts, ignore_index=True)
    run_number, run_names = pd.factorize(drawn["run_id"])
    half_width = normal_quantile(CONFIDENCE) * drawn["traction_coefficient_se"]
    return {
        "names": run_names.tolist(),
        "run": run_number.tolist(),
        "oil": drawn["oil"].tolist(),
        "axes": [as_json(drawn[name], _DIGITS) for name in AXES],
        "mu": as_json(drawn["traction_coefficient"], _DIGITS),
        "half": as_json(half_width.fillna(0), _ERROR_DIGITS),
        "left_out": accepted - len(drawn),
    }


def sections(results: CampaignTables, settings: Settings) -> list[Section]:
    """All sections that have any content; those of the campaign's studies are the last.

    Args:
        results: The finished tables.
        settings: All settings of the campaign.
    """
    all_sections = [
        answer(results, settings),
        data(results, settings),
        refused(results, settings),
        fits(results),
        constants(results),
        laws(results, settings),
        bearing(results, settings),
    ]
    for study in studies.load(settings.campaign.studies):
        all_sections += study.sections(results, settings)
    return [section for section in all_sections if section]
