"""Whether a fit is sound: its optimum confirmed, its law adequate, its campaign steady.

Decides: when a fit is called sound.
"""

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.fits.best_law import best_laws
from oilfilm.fits.conditions import from_text
from oilfilm.fits.engine import polish
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.noise import noise_and_misfit
from oilfilm.fits.patterns import FEWEST_CURVES, Leftover, Pattern, find_patterns, natural_key
from oilfilm.fits.problem import build_problem, curve_data
from oilfilm.settings.config import FitSettings
from oilfilm.settings.resolved import Settings
from oilfilm.table_needs import OF_FIT
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import to_internal

# What runs may have in common: columns of the table of runs.
_GROUPS = ("rig", "log_kind", "reader", "encoding", "delimiter", "decimal_mark")
_NONE = Pattern("", "", ())
_NOMINAL = re.compile(r"nominal_(.+)_(?:gpa|n|m_s|c)$")


def finished_fits(results: CampaignTables, settings: Settings) -> dict[str, pd.DataFrame]:
    """The tables of the fits, `law_verdicts`, `lack_of_fit` and `soundness`, by name.

    Args:
        results: The tables of every fit, `points` and `runs`.
        settings: `fit`, and those of `noise_and_misfit`.
    """
    quality = results.fit_quality
    known = {oil: settings.properties_of(oil) for oil in quality["oil"].unique()}
    limits = {oil: each.limiting_stress_ratio for oil, each in known.items() if each is not None}
    quality = quality.assign(
        configured=quality["law"] == settings.fit.law,
        limiting_stress_ratio=quality["oil"].map(limits).astype(float),
    )
    results = results.replace(fit_quality=quality)
    lack_of_fit = noise_and_misfit(results, settings)
    return {
        **{name: results.table(name) for name in OF_FIT},
        "law_verdicts": best_laws(quality, results.law_points, results.points),
        "lack_of_fit": lack_of_fit,
        "soundness": judged_fits(results, lack_of_fit, settings.fit),
    }


def judged_fits(
    results: CampaignTables, lack_of_fit: pd.DataFrame, settings: FitSettings
) -> pd.DataFrame:
    """Table `soundness`: the verdict on the configured law's fit to each oil, in three parts."""
    fits, points = results.configured, results.points
    quality = {row["oil"]: row for row in tables.rows(fits.fit_quality)}
    fitted = {
        oil: FittedLaw.of(fits.coefficients, oil, quality=fits.fit_quality)
        for oil, row in quality.items()
        if np.isfinite(row["rmse"])
    }
    lack = lack_of_fit.set_index("oil")["verdict"]
    rows = []
    for oil, row in quality.items():
        used = points[points["accepted"] & (points["oil"] == oil)]
        of_campaign = (results.runs, fitted, lack.get(oil) == "shown")
        verdict = verdict_of_fit(row, fitted.get(oil), used, settings, *of_campaign)
        rows.append({**verdict, "oil": oil, "law": row["law"]})
    return tables.from_rows(rows, "soundness")


def verdict_of_fit(
    quality: Mapping[str, Any],
    fitted: FittedLaw | None,
    points: pd.DataFrame,
    settings: FitSettings,
    runs: pd.DataFrame | None = None,
    others: Mapping[str, FittedLaw] | None = None,
    lack_shown: bool = False,
) -> dict[str, Any]:
    """The row of the table `soundness` of one fit.

    Args:
        quality: The fit's row of `fit_quality`.
        fitted: The fit; None where there is none.
        points: Its accepted points.
        settings: `odd_scatter`.
        runs: Table of runs; without it no groups of runs are known.
        others: The fits of all oils.
        lack_shown: Whether repeated runs show a lack of fit.
    """
    left = None
    no_fit = fitted is None or np.isnan(quality["rmse"])
    if fitted is not None and not no_fit:
        # a condition of these runs is unknown
        left_out = str(quality.get("incomplete_curves") or "").split("; ")
        used = points[~points["run_id"].isin(left_out)]
        groups = {} if runs is None else runs_in_common(runs, used)
        left = leftover(fitted, used, groups, others or {})
    found = find_patterns(left) if left is not None else []
    bend = next((each for each in found if each.when == "law"), _NONE)
    change = next((each for each in found if each.when != "law"), _NONE)
    few = left is not None and not left.can_show
    fixed = from_text(quality["fixed_conditions"])
    # the first that holds
    of_law = {
        "no fit": no_fit,
        "condition missing": any(each.level is None for each in fixed),
        "misfit": quality["relative_rms"] > settings.odd_scatter,
        "bend": bend is not _NONE,
        "lack of fit": lack_shown,
        "too few curves": left is None or few,
        "two levels": quality["two_level_conditions"],
    }
    law = next((name for name, holds in of_law.items() if holds), "adequate")
    of_campaign = {
        "changed": change is not _NONE,
        "too few curves": no_fit or few,
        "condition missing": left is None,
        "hidden by the law": law in ("misfit", "bend"),
    }
    steady = next((name for name, holds in of_campaign.items() if holds), "steady")
    optimum = bool(quality["certified"])
    return {
        "optimum_confirmed": optimum,
        "law_verdict": law,
        "bend": bend.what,
        "bend_relative_rms": bend.mu_share,
        "campaign_verdict": steady,
        "change": change.what,
        "change_course": change.when,
        "change_group": change.group,
        "changed_runs": ", ".join(change.runs) if change.when != "trend" else "",
        "change_size": change.size,
        "change_relative_rms": change.mu_share,
        "sound": optimum and law == "adequate" and steady == "steady",
    }


def leftover(
    fitted: FittedLaw,
    points: pd.DataFrame,
    groups: Mapping[str, set[str]],
    others: Mapping[str, FittedLaw],
) -> Leftover | None:
    """What a fit leaves over of its points; None where a condition is not known.

    Args:
        fitted: The fit.
        points: The oil's accepted points.
        groups: Runs that have something in common, by what it is.
        others: The fits of all oils.
    """
    law = fitted.law
    # in the order in which people count
    data = curve_data(points, law.conditions, natural_key)
    if not np.isfinite(data.conditions).all():
        return None
    problem = build_problem(law, data, fitted.coefficients.known)
    start = to_internal(law, fitted.coefficients.constants)[problem.free]
    optimum = polish(problem, start)
    at = data.conditions[data.curve]
    mixed = {
        oil: other.predict(at, data.slip).traction_coefficient
        for oil, other in others.items()
        if other is not fitted and other.law.conditions == law.conditions
    }
    known = {oil: mu for oil, mu in mixed.items() if np.isfinite(mu).all()}
    members = {name: np.isin(data.runs, list(runs)) for name, runs in groups.items()}
    # what the same runs have in common is one cause
    of_runs = {each.tobytes(): (name, each) for name, each in reversed(members.items())}
    return Leftover(problem, optimum, dict(reversed(of_runs.values())), known)


def runs_in_common(runs: pd.DataFrame, points: pd.DataFrame) -> dict[str, set[str]]:
    """Runs that have something in common.

    That is the rig, the kind and form of the log, its columns and their units, what header and run
    sheet say (a set point at all, any other key with its value), the sign of the slip.
    """
    groups = {
        f"{column} {value}": set(of_value["run_id"])
        for column in _GROUPS
        for value, of_value in runs.groupby(column)
    }
    for column, label, mark in (("columns", "the column ", ", "), ("stated", "", "; ")):
        parts = runs.set_index("run_id")[column].str.split(mark).explode().dropna()
        groups |= {
            f"{label}{part}": set(of.index)
            for part, of in parts.groupby(parts)
            if part and FEWEST_CURVES <= len(of) < len(runs)
        }
    groups |= {
        f"set point of {match[1].replace('_', ' ')} stated": set(runs.loc[at.notna(), "run_id"])
        for column, at in runs.items()
        if (match := _NOMINAL.match(str(column)))
    }
    highest = points.groupby("run_id")["slide_roll_ratio"].max()
    groups["slip below zero"] = set(highest.index[highest <= 0])
    return groups
