"""What the fits are worth: the answer, errors and noise, constants, and the laws side by side."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.fits.best_law import FEWEST_CURVES
from oilfilm.fits.conditions import from_text
from oilfilm.fits.fit import TIE
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.soundness_words import what_is_wrong
from oilfilm.report.document import (
    Fact,
    Section,
    ShownTable,
    facts,
    number,
    show_table,
    significant,
)
from oilfilm.report.explorer import LEVEL, explored_fits, load_at_1_gpa, sliders
from oilfilm.report.words import CONDITIONS, law_name
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS

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
        lost=tables.rows(quality[quality["rmse"].isna()]),
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
        by_bic, better = row["bic_ties"].split(", "), row["better_law"]
        ties = [each for each in row["left_out_ties"].split(", ") if each and each in by_bic]
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
