"""The sections of a campaign's report, in their order.

First what was read, accepted and refused, and why, and what torque logs and the bearing come to;
then what the fits are worth: the answer, errors and noise, constants, the laws side by side.

Decides: which sections a report has, and what they tell.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any
from urllib.parse import quote

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.base import studies
from oilfilm.curation.coverage import planned_states
from oilfilm.fits.best_law import FEWEST_CURVES
from oilfilm.fits.certificate_words import certificate
from oilfilm.fits.conditions import from_text
from oilfilm.fits.fit import TIE
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.interval import normal_quantile
from oilfilm.fits.soundness_words import what_is_wrong
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
from oilfilm.report.explorer import LEVEL, explored_fits, load_at_1_gpa, plain, sliders
from oilfilm.report.words import CONDITIONS, gate_name, law_name
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.best_oil import NOT_KNOWN
from oilfilm.torque.operating_grid import AXES
from oilfilm.torque.torque_control import (
    bistable_points,
    is_bistable,
    undecided_plateaus,
    without_bistable,
)
from oilfilm.traction import LAWS

# What is told and how, no verdict: the tables have those.
# A curve of which mu differs less than this as a whole is odd by its shape.
_SAME_GAIN = 0.03
# Share of the points at which mu is known at least so well.
_MOST = 0.95
# Of the largest mu of the law: below it a point has no traction to speak of.
_CLEAR = 0.01


def fits(results: CampaignTables) -> Section:
    """Misfit, certificate and certainty of each fit, noise and lack of fit."""
    quality, sure = results.configured.fit_quality, certainty(results)
    fitted = tables.rows(quality[quality["rmse"].notna()])
    made = facts(
        "report/sections/fits.jinja",
        fitted=fitted,
        wrong={str(row["oil"]): what_is_wrong(row) for row in tables.rows(results.soundness)},
        lost=[
            {"oil": row["oil"], "certificate": certificate(row)}
            for row in tables.rows(quality[quality["rmse"].isna()])
        ],
        **_odd(results.configured.curve_residuals),
        misfits=tables.rows(results.lack_of_fit),
        unrepeated=tables.rows(results.lack_of_fit.query("verdict == 'no repeats'")),
    )
    shown = [
        show_table(quality.join(sure, on="oil"), "fit_quality"),
        show_table(results.lack_of_fit, "lack_of_fit"),
    ]
    return Section("fits", "Fits", made, shown)


def curve_facts(quality: pd.DataFrame, residuals: pd.DataFrame) -> list[Fact]:
    """Curves that are left out of fits, and curves that pull them away.

    Args:
        quality: Rows of the table of fit quality.
        residuals: Table of curve residuals, of the same fits.
    """
    fitted = tables.rows(quality)
    return facts("report/sections/curves.jinja", fitted=fitted, **_odd(residuals))


def _odd(residuals: pd.DataFrame) -> dict[str, Any]:
    odd = residuals[residuals["odd"]].sort_values("robust_weight", kind="stable")
    of_oil = {str(oil): tables.rows(rows) for oil, rows in odd.groupby("oil")}
    return {"odd_curves": of_oil, "same_gain": _SAME_GAIN}


def certainty(results: CampaignTables) -> pd.DataFrame:
    """How sure mu of the next run is at the accepted points: half of its 95 % interval over mu.

    Columns median and largest (below which 95 % of the points are) by oil; null where the fit has
    no interval. Rolling without slip is left out: an interval over a mu of
    nearly zero says nothing.
    """
    certainties = {}
    accepted = results.points[results.points["accepted"]]
    for oil in results.configured.fit_quality["oil"]:
        fit = FittedLaw.of_configured(results, oil)
        points = accepted[accepted["oil"] == oil]
        conditions, slip = points[list(fit.law.conditions)], points["slide_roll_ratio"]
        prediction = fit.predict(conditions.to_numpy(float), slip.to_numpy(float))
        size = np.abs(prediction.traction_coefficient)
        width = prediction.obs_ci_upper - prediction.obs_ci_lower
        clear = size > _CLEAR * size.max(initial=0.0)
        half = pd.Series(width[clear] / 2 / size[clear])
        certainties[oil] = half.median(), half.quantile(_MOST)
    index = pd.Index(certainties, dtype=str)
    return pd.DataFrame([*certainties.values()], index, columns=["median", "largest"])


_BESIDE = {"best": "best of those compared", "tie": "ties with others"}


def answer(results: CampaignTables, settings: Settings) -> Section:
    """A row per oil: mu at one operating point with its interval, the law, runs, soundness."""
    load_n = load_at_1_gpa(settings)
    fits = explored_fits(results, load_n)
    axes = sliders(fits, results.points, settings)
    at = [np.nan if axis.idle else axis.start for axis in axes]
    oil, quality = results.configured.fit_quality["oil"], results.configured.fit_quality
    known = {name: _at_point(fit, at, load_n) for name, fit in fits.items()}
    beside = {row["oil"]: _beside_others(row) for row in tables.rows(results.law_verdicts)}
    sound = {row["oil"]: _soundness(row) for row in tables.rows(results.soundness)}
    accepted = (results.runs["verdict"] == "accepted").groupby(results.runs["oil"])
    runs = {name: f"{of_oil.sum()} of {len(of_oil)}" for name, of_oil in accepted}
    rows = quality.assign(
        mu=[known.get(name, (np.nan, ""))[0] for name in oil],
        interval=[known.get(name, (np.nan, "not known"))[1] for name in oil],
        beside=[beside.get(name, "not compared") for name in oil],
        fit=[sound.get(name, "not sound") for name in oil],
        runs=[runs.get(name, "none") for name in oil],
    )
    point = ", ".join(
        f"{symbol} {axis.start:.{axis.digits}f} {unit}".rstrip()
        for axis, (symbol, _, unit) in zip(axes, CONDITIONS.values(), strict=True)
        if not axis.idle
    )
    table = show_table(rows, "answers", f"At {point}")
    return Section("answer", "Answer", tables=[table])


def _at_point(
    fit: FittedLaw, at: Sequence[float], load_at_1_gpa: float | None
) -> tuple[float, str]:
    """mu of a fit at P, U, T and S, and its interval in words."""
    pressure, *others, slip = at
    if load_at_1_gpa is not None and "load_n" in fit.law.conditions:
        pressure = load_at_1_gpa * pressure**3
    found = fit.predict(np.array([[pressure, *others]]), np.array([slip]))
    lower, upper, interval = found.obs_ci_lower[0], found.obs_ci_upper[0], "not known"
    if not np.isnan([lower, upper]).any():
        level = fit.coefficients.bands(fit.law, LEVEL)[2]
        interval = f"{lower:#.3g} to {upper:#.3g} ({100 * level:.2g} %)"
    interval += ", not tested there" if found.outside[0] else ""
    interval += ", above the limiting shear stress" if found.over_limit[0] else ""
    return found.traction_coefficient[0], interval


def _soundness(row: Mapping[str, Any]) -> str:
    """Whether a fit is sound, and otherwise which parts are not; sentences are among trouble."""
    parts = [] if row["optimum_confirmed"] else ["optimum not confirmed"]
    parts += [f"law: {row['law_verdict']}"] if row["law_verdict"] != "adequate" else []
    parts += [f"campaign: {row['campaign_verdict']}"] if row["campaign_verdict"] != "steady" else []
    return "sound" if row["sound"] else f"not sound ({'; '.join(parts)})"


def _beside_others(row: Mapping[str, Any]) -> str:
    """How the configured law compares with the others."""
    if row["verdict"] == "another law is better":
        return f"worse than {law_name(row['better_law'])}"
    return _BESIDE.get(row["verdict"], f"not decided: {row['verdict']}")


def constants(results: CampaignTables) -> Section:
    """A table per oil, and a sentence for each constant that the data do not determine."""
    fits = results.configured
    quality = fits.fit_quality.set_index("oil")
    by_oil = [(str(oil), rows) for oil, rows in fits.coefficients.groupby("oil", sort=False)]
    made = facts(
        "report/sections/constants.jinja",
        fits=[
            {
                "oil": oil,
                "curves": quality["n_curves"][oil],
                "constants": tables.rows(rows),
                "fixed": [each.sentence() for each in from_text(quality["fixed_conditions"][oil])],
            }
            for oil, rows in by_oil
            if rows["value"].notna().any()
        ],
    )
    shown = [_of_oil(rows, place) for place, (_, rows) in enumerate(by_oil)]
    return Section("constants", "Constants", made, shown)


def _of_oil(rows: pd.DataFrame, place: int) -> ShownTable:
    """Constants of one oil with their errors. Digits beyond the second of the error say nothing."""
    names = ["value", "standard_error", "systematic_standard_error", "lower", "upper"]
    texts = rows.astype(object)
    for index, row in rows.iterrows():
        error = row["standard_error"]
        form = number(significant(row["naive_standard_error"] if np.isnan(error) else error))
        texts.loc[index, names] = [form(row[name]) for name in names]
    interval = texts["lower"] + " \N{HORIZONTAL ELLIPSIS} " + texts["upper"]
    texts["lower"] = texts["lower"].where(rows["lower"].isna(), interval)
    return show_table(texts, "constants", rows["oil"].iloc[0], f"constants{place}")


def laws(results: CampaignTables, settings: Settings) -> Section:
    """Which law describes each oil best, what to do, and every law's errors side by side."""
    # what must be said wherever the laws of a simulated campaign are compared
    tie = f"Wang-Deng here: {TIE}" if settings.campaign.truth_is_law else ""
    made = law_facts(results.law_verdicts, results.fit_quality, tie)
    errors = show_table(results.fit_quality, "comparison")
    verdicts = show_table(results.law_verdicts, "law_verdicts")
    return Section("laws", "Laws", made, [verdicts, errors])


def law_facts(verdicts: pd.DataFrame, quality: pd.DataFrame, tie: str = "") -> list[Fact]:
    """What the comparison says of the configured law of the oils, and what to do.

    Oils of which the same is true have one sentence.

    Args:
        verdicts: Table `law_verdicts`.
        quality: Table of fit quality, of every law.
        tie: What must be said of the laws of this campaign.
    """
    groups: dict[str, dict[str, Any]] = {}
    for row in tables.rows(verdicts):
        fits = {fit["law"]: fit for fit in tables.rows(quality[quality["oil"] == row["oil"]])}
        by_bic, better = row["bic_ties"] or (), row["better_law"]
        ties = [law for law in row["left_out_ties"] or () if law in by_bic]
        told = {
            "verdict": row["verdict"],
            "law": row["law"],
            "better_law": better,
            "shared": sorted(law_name(each) for each in ties if each != row["law"]),
            "fewest": min(ties, key=lambda each: fits[each]["n_constants"], default=""),
            "unconfirmed": better in fits and not fits[better]["certified"],
        }
        groups.setdefault(repr(told), {**told, "oils": []})["oils"].append(row["oil"])
    return facts(
        "report/sections/laws.jinja",
        rows=list(groups.values()),
        tie=tie,
        fewest_curves=FEWEST_CURVES,
        can_be_set=list(LAWS),
    )


_STATES = ("accepted", "refused", "missing")


def data(results: CampaignTables, settings: Settings) -> Section:
    """What was read and accepted, which conditions are covered, what is known of the film."""
    points = results.points
    has_matrix = results.coverage["planned"].any()
    conditions = planned_states(results.coverage) if has_matrix else results.coverage
    unjudged = points["accepted"] & (points["film_judgement"] == "cannot be judged")
    made = facts(
        "report/sections/data.jinja",
        results=results,
        settings=settings,
        unread=len(unread_logs(results)),
        shortfalls=shortfalls(results, settings.campaign),
        has_matrix=has_matrix,
        conditions=conditions["state"].value_counts().reindex(_STATES, fill_value=0),
        unjudged=points.loc[unjudged, "oil"],
        stand_ins=[name for name, oil in settings.oils.items() if oil and oil.stand_in],
    )
    return Section("data", "Data", made, [run_list(results, settings.report.rows_max)])


def refused(results: CampaignTables, settings: Settings) -> Section:
    """Everything that was refused, the first case of each gate in words."""
    counts = results.gate_counts
    counts = counts[~counts["gate"].isin(REMARKS)]
    made = facts(
        "report/sections/refused.jinja",
        verdicts=_named(results.runs.query("verdict == 'refused'")["rule"].value_counts()),
        unread=_named(_of_unread_logs(results).value_counts()),
        points=(~results.points["accepted"]).sum(),
        cases=first_cases(results.quarantine),
        other_gates=counts[~counts["gate"].isin(results.quarantine["rule"])].to_dict("records"),
    )
    listed = refusals(results.quarantine, "quarantine", settings.report.rows_max)
    shown = [show_table(counts, "gate_counts"), listed]
    return Section("refused", "Refused", made, shown)


def refusals(quarantine: pd.DataFrame, name: str, most: int, caption: str = "") -> ShownTable:
    """What was refused, why, and what to do; remarks on the run sheet refuse nothing."""
    quarantine = quarantine[~quarantine["rule"].isin(REMARKS)]
    return show_table(quarantine, "quarantine", caption, name, most)


def first_cases(quarantine: pd.DataFrame) -> list[dict[str, object]]:
    """The first case of each gate with the number of cases; most cases first."""
    quarantine = quarantine[~quarantine["rule"].isin(REMARKS)]
    sizes = quarantine["rule"].value_counts()
    first = quarantine.drop_duplicates("rule").set_index("rule").loc[sizes.index]
    names = np.where(first["run_id"] != "", first["run_id"], first["file"])
    return tables.rows(
        first.assign(gate=first.index.map(gate_name), name=names, count=sizes).reset_index()
    )


def refused_points(points: pd.DataFrame) -> dict[str, int]:
    """How many points each gate refused, most first."""
    return _named(failed_gates.counts(points))


def _of_unread_logs(results: CampaignTables) -> "pd.Series[str]":
    """The rule that refused each log of which no run could be read."""
    of_logs = results.quarantine[results.quarantine["file"].isin(unread_logs(results))]
    return of_logs.drop_duplicates("file")["rule"]


def _named(counts: "pd.Series[int]") -> dict[str, int]:
    return {gate_name(str(gate)): int(count) for gate, count in counts.items()}


def bearing(results: CampaignTables, settings: Settings) -> Section:
    """Logs and plateaus, errors, soundness, what traction decides, heat; empty without logs."""
    runs, refused, torque = results.torque_runs, results.torque_quarantine, results.torque
    if runs.empty and refused.empty:
        return Section("bearing", "Bearing")
    kept = {run_id.rpartition(":")[0] or run_id for run_id in runs["run_id"]}
    # of a refused run no plateau is kept
    read = kept | set(refused.loc[refused["stage"] == "curate", "file"])
    logs = read | set(refused.loc[~refused["rule"].isin(REMARKS), "file"])
    without_torque = runs[runs["accepted"] & ~runs["oil"].isin(torque["oil"])]
    sound = torque[torque["converged"]]
    sure = without_bistable(sound)
    by_stress = sound[sound["load_variable"] == "stress"]
    made = facts(
        "report/sections/bearing.jinja",
        kept=len(kept),
        read=len(read),
        logs=len(logs),
        plateaus=runs,
        limits_gpa=settings.bearing.pressure_limits_gpa,
        refused_plateaus=refused_points(runs),
        cases=first_cases(refused),
        not_calculated=without_torque["oil"].value_counts().to_dict(),
        torque=torque,
        sound=sound,
        plateaus_calculated=len(sound.drop_duplicates(["run_id", "first_row"])),
        bistable=len(sound[is_bistable(sound)].drop_duplicates(["run_id", "first_row"])),
        undecided=undecided_plateaus(sound),
        bistable_points=bistable_points(sound),
        why_lost=_why_lost(torque[~torque["converged"]]),
        has_uncertainty=not len(sound) or (sure["verdict"] != "not known").any(),
        control=_control(results.torque_control),
        by_stress=by_stress,
        inversion=results.torque_inversion["verdict"].tolist(),
        **_heat(results.heat_balance),
    )
    caption = "Refused torque logs, runs and plateaus"
    listed = refusals(refused, "torque_quarantine", settings.report.rows_max, caption)
    return Section("bearing", "Bearing", made, [_error_table(sure), listed])


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
    """What a comparison with simulated torque shows, by verdict."""
    return [
        {"verdict": verdict, "misfit": rows["law_misfit"].max(), "oils": rows["oil"].tolist()}
        for verdict, rows in control.groupby("verdict", sort=False)
    ]


def _heat(balance: pd.DataFrame) -> dict[str, Any]:
    """What the oil's own heating changes on the map of cage slip."""
    on_map = balance[balance["run_id"] == ""]
    known = on_map["balanced"].notna()
    hot = on_map[on_map["balanced"].fillna(False)]
    points = on_map.drop_duplicates(["inner_speed_rpm", "axial_load_n"])
    both = points[(points[["best_oil", "heated_best_oil"]] != NOT_KNOWN).all(axis=1)]
    return {
        "heat_cases": known.sum(),
        "balanced": len(hot),
        "outlet": hot["outlet_temperature_c"],
        # + 0.0 takes the minus sign from a rounded zero
        "change": (hot["heated_torque_n_m"] / hot["torque_n_m"] - 1).round(2) + 0.0,
        "other_best_oil": (both["best_oil"] != both["heated_best_oil"]).sum(),
        "both_known": len(both),
        "map_points": len(points),
    }


def _error_table(sure: pd.DataFrame) -> ShownTable:
    """How far the calculated torque is from the measured one, by oil and load variable."""
    known = sure.dropna(subset=["relative_error"])
    known = known.assign(
        size=known["relative_error"].abs(),
        share=known["traction_torque_n_m"] / known["torque_n_m"],
        agrees=known["verdict"] == "compatible",
        is_judged=known["verdict"] != "not known",
    )
    errors = known.groupby(["oil", "load_variable"], sort=False, as_index=False).agg(
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


_DIGITS = 6  # of a drawn value


def run_list(results: CampaignTables, most: int) -> ShownTable:
    """One row per run with its conditions and verdict, refused ones first.

    Its name leads to its operating point in the chart, or to its signals.
    """
    runs = results.runs.assign(refused=results.runs["verdict"] != "accepted")
    runs = runs.sort_values("refused", ascending=False, kind="stable")
    of_runs = results.points.groupby("run_id")["accepted"].agg(["sum", "size"])
    counts = of_runs.reindex(runs["run_id"], fill_value=0).astype(int)
    passed = [f"{good} of {size}" for good, size in counts.to_numpy()]
    shown = runs.assign(passed=passed, why=runs["rule"]).dropna(axis="columns", how="all")
    listed = show_table(shown, "run-list", most=most)
    pages = results.refused_pages.query("page != ''").set_index("run_id")["page"]
    anchors = "refused-" + pages.str.removesuffix(".png")
    links = [f"#{anchors.get(name, f'run?name={quote(name)}')}" for name in runs["run_id"]]
    return replace(listed, links=links[:most])


def drawn_points(points: pd.DataFrame, most: int) -> dict[str, Any]:
    """The accepted points that the page draws, evenly chosen, as columns of numbers.

    Args:
        points: Table of points.
        most: Points at most.
    """
    accepted = points[points["accepted"]]
    points = accepted.iloc[:: max(-(-len(accepted) // most), 1)]
    run, names = pd.factorize(points["run_id"])
    half = normal_quantile(LEVEL) * points["traction_coefficient_se"]
    return {
        "names": names.tolist(),
        "run": run.tolist(),
        "oil": points["oil"].tolist(),
        "axes": [plain(points[name], _DIGITS) for name in AXES],
        "mu": plain(points["traction_coefficient"], _DIGITS),
        "half": plain(half.fillna(0), 2),
        "left_out": len(accepted) - len(points),
    }


def sections(results: CampaignTables, settings: Settings) -> list[Section]:
    """The sections that have something to say; those of the campaign's studies are the last.

    Args:
        results: The finished tables.
        settings: All settings of the campaign.
    """
    made = [
        answer(results, settings),
        data(results, settings),
        refused(results, settings),
        fits(results),
        constants(results),
        laws(results, settings),
        bearing(results, settings),
    ]
    for study in studies.load(settings.campaign.studies):
        made += study.sections(results, settings)
    return [section for section in made if section]
