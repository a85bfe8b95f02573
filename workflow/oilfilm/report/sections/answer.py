"""The answer to the first question: how large is mu, how sure, and can the fit be trusted."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from oilfilm import tables
from oilfilm.fits.fitted import FittedLaw
from oilfilm.report.document import Section
from oilfilm.report.explorer import LEVEL, explored_fits, load_at_1_gpa, sliders
from oilfilm.report.shown_table import show_declared
from oilfilm.report.words import CONDITIONS, law_name
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

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
    table = show_declared(rows, "answers", f"At {point}")
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
