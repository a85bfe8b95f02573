"""Whether a fit is sound: its optimum confirmed, its law adequate, its campaign steady.

The table `lack_of_fit` has what each fit misses beside the noise of its data.

Decides: when a fit is called sound; which runs repeat a condition; what is noise, and what is lack
of fit.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import scipy

from oilfilm import tables
from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.fits.best_law import best_laws
from oilfilm.fits.conditions import clusters, from_text, levels_of
from oilfilm.fits.engine import polish
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.patterns import Leftover, Pattern, find_patterns, natural_key
from oilfilm.fits.problem import build_problem, curve_data
from oilfilm.settings.config import FitSettings, PatternSettings
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.set_points import SET_POINTS, with_levels
from oilfilm.tables.table_needs import OF_FIT
from oilfilm.traction.law import to_internal

# The level of every interval and test of the project.
_CONFIDENCE = 0.95
# Of the sum of squares over that between repeats: copies would leave rounding alone.
_LARGEST_RATIO = 1e6
# A set point that no log states is known by what was measured.
_MEASURED = ("max_hertz_pressure_gpa", "load_n", "entrainment_speed_m_s", "inlet_temperature_c")


def noise_and_misfit(results: CampaignTables, settings: Settings) -> pd.DataFrame:
    """Table `lack_of_fit`: residuals of each fit, parted into noise and lack of fit.

    Args:
        results: Tables `coefficients`, `fit_quality`, `points` and `runs`.
        settings: `same_condition`, `rigs`, `oils`, `same_set_point`, and the campaign's `rigs` and
            `matrix`.
    """
    conditions, rows = _conditions(results, settings), []
    for quality in tables.rows(results.configured.fit_quality):
        row = {"oil": quality["oil"], "law": quality["law"], "verdict": "no fit"}
        if not np.isnan(quality["rmse"]):
            row |= _of_fit(quality, results.configured, conditions, settings)
        rows.append(row)
    return tables.filled(pd.DataFrame(rows), "lack_of_fit")


def _of_fit(
    quality: dict[str, Any],
    results: CampaignTables,
    conditions: "pd.Series[int]",
    settings: Settings,
) -> dict[str, Any]:
    fit = FittedLaw.of(results.coefficients, quality["oil"], None, results.fit_quality)
    points = results.points
    used = points[points["accepted"] & (points["oil"] == quality["oil"])]
    # a fit takes each run at its mean conditions
    means = used.groupby("run_id")[list(fit.law.conditions)].transform("mean").to_numpy(float)
    slip, mu = (used[name].to_numpy(float) for name in ("slide_roll_ratio", "traction_coefficient"))
    residual = np.where(slip < 0, -1.0, 1.0) * (fit.predict(means, slip).traction_coefficient - mu)
    known = np.isfinite(residual)
    used, residual, slip, mu = used[known], residual[known], slip[known], mu[known]
    condition = used["run_id"].map(conditions).to_numpy(np.int64)
    run, _ = pd.factorize(used["run_id"])
    width = settings.same_condition.slide_roll_ratio
    of_condition = pd.Series(np.abs(slip)).groupby(condition)
    levels = of_condition.transform(lambda each: clusters(each.to_numpy(), width)).to_numpy()
    given = results.coefficients["oil"] == quality["oil"]
    constants = int(results.coefficients.loc[given, "value"].notna().sum())
    parts = lack_of_fit(residual, run, condition, levels, constants)
    size = float(np.sqrt(np.mean(mu**2)))
    verdict = "shown" if parts.shown else "not shown"
    return {
        "n_repeats": parts.repeats,
        "n_repeated_conditions": parts.conditions,
        "relative_rms": quality["relative_rms"],
        "repeat_relative_rms": parts.noise / size,
        "lack_of_fit_relative_rms": parts.lack / size,
        "plateau_relative_rms": np.sqrt((used["traction_coefficient_se"] ** 2).mean()) / size,
        "lack_of_fit_ratio": parts.ratio,
        "lack_of_fit_limit": parts.limit,
        "verdict": "no repeats" if np.isnan(parts.noise) else verdict,
    }


def _conditions(results: CampaignTables, settings: Settings) -> "pd.Series[int]":
    """Number of the condition of each run, by `run_id`.

    Runs have one condition where oil, rig and set points are the same. Of a set point that is not
    stated the measured mean counts, by the levels of `same_condition`.
    """
    runs = with_levels(results.runs, settings).set_index("run_id")
    accepted = results.points[results.points["accepted"]]
    means = accepted.groupby("run_id")[list(_MEASURED)].mean().reindex(runs.index)
    # pressure and load are one set point
    load_noted = runs[list(SET_POINTS[:2])].notna().any(axis=1)
    labels = runs[["oil", "rig"]].assign(load_noted=load_noted)
    for name, measured in zip(SET_POINTS, _MEASURED, strict=True):
        noted = runs[name].notna() | (load_noted if name in SET_POINTS[:2] else False)
        near = levels_of(measured, means[measured].to_numpy(float), settings.same_condition)
        labels[name] = runs[name].where(noted, -1.0 - near)
    return labels.groupby(list(labels), sort=False, dropna=False).ngroup()


# ---------------------------------------------------------------- the test


@dataclass(frozen=True)
class LackOfFit:
    """Noise and lack of fit, in the unit of the residuals.

    Attributes:
        repeats: Runs that repeat the condition of an earlier one.
        conditions: Conditions that several runs have.
        noise: Standard deviation of a point between repeated runs; NaN without repeats.
        lack: Root-mean-square of what the law's form misses, 0 where the noise explains all of the
            residuals; NaN without repeats.
        ratio: F, mean square of the lack of fit over that of repeats; NaN without repeats.
        limit: 95 % limit of F where the law's form is right.
    """

    repeats: int
    conditions: int
    noise: float
    lack: float
    ratio: float
    limit: float

    @property
    def shown(self) -> bool:
        """Whether the repeats show that the law's form is wrong."""
        return self.ratio > self.limit


def lack_of_fit(
    residual: FloatArray, run: IndexArray, condition: IndexArray, slip: IndexArray, constants: int
) -> LackOfFit:
    """The classical test of lack of fit, where the points of a run share its errors.

    Points of different runs at one condition and one level of slip are repeats. Half the mean
    square of their differences is the variance of a point, its run's error included. It is taken
    from residuals instead of mu, so that small differences of condition and slip do not count.
    What is left of the mean squared residual is the square of what the law misses. The test is

        F = (SSE - SSPE)/(cells - constants) / (SSPE/(n - cells))

    over the means of each run in each cell; a cell is one level of slip at one condition. Because
    the values of a run are not independent, each run counts as one: both degrees of freedom are
    divided by the values per run. That is the most careful choice (lower bound of Greenhouse and
    Geisser); with one value per run it is the classical test.

    Args:
        residual: Of each point.
        run: Run of each point, counted from 0.
        condition: Condition of each point, the same for all points of a run.
        slip: Level of slip of each point.
        constants: Fitted constants.

    References: N. R. Draper, H. Smith, Applied Regression Analysis, 3rd ed. (1998), section 2.1;
        S. W. Greenhouse, S. Geisser, Psychometrika 24 (1959) 95.
    """
    condition_of_run = np.zeros(run.max() + 1, dtype=np.int64)
    condition_of_run[run] = condition
    runs_of_condition = np.bincount(condition_of_run)
    repeats = int(np.sum(runs_of_condition[runs_of_condition > 1] - 1))
    conditions = int(np.sum(runs_of_condition > 1))
    _, cell = np.unique(np.column_stack([condition, slip]), axis=0, return_inverse=True)
    pairs, pair = np.unique(np.column_stack([cell, run]), axis=0, return_inverse=True)
    # mean of each run in each cell
    values, cell_of_value = np.bincount(pair, residual) / np.bincount(pair), pairs[:, 0]
    per_cell = np.bincount(cell_of_value)
    pure_degrees = len(values) - len(per_cell)
    fit_degrees = len(per_cell) - constants
    if pure_degrees == 0 or fit_degrees <= 0:
        return LackOfFit(repeats, conditions, *[float("nan")] * 4)
    sums = np.bincount(cell_of_value, values)
    pure = float(np.sum(values**2) - np.sum(sums**2 / per_cell))
    # repeats that are copies leave rounding only
    pure = max(pure, float(np.sum(values**2)) / _LARGEST_RATIO)
    ratio = float(np.sum(sums**2 / per_cell)) / fit_degrees / (pure / pure_degrees)
    per_run = len(values) / len(condition_of_run)
    degrees = fit_degrees / per_run, pure_degrees / per_run
    limit = float(scipy.special.fdtri(*degrees, _CONFIDENCE))
    noise = _between_runs(residual, pair, cell_of_value, cell)
    share = 1 - constants / len(residual)  # of the noise that the fit has not taken up
    unexplained = float(np.mean(residual**2)) - share * noise**2
    lack = float(np.sqrt(max(unexplained, 0.0)))
    return LackOfFit(repeats, conditions, noise, lack, ratio, limit)


def _between_runs(
    residual: FloatArray, pair: IndexArray, cell_of_pair: IndexArray, cell: IndexArray
) -> float:
    """Standard deviation of a point, from differences between runs in one cell.

    Args:
        residual: Of each point.
        pair: Pair of a cell and a run of each point.
        cell_of_pair: Cell of each pair.
        cell: Cell of each point.
    """
    in_run = np.bincount(cell_of_pair, _squared_differences(residual, pair))
    across = _squared_differences(residual, cell) - in_run
    pairs_in_run = np.bincount(cell_of_pair, np.bincount(pair) ** 2)
    number = (np.bincount(cell) ** 2 - pairs_in_run) / 2
    runs = np.bincount(cell_of_pair)
    repeated = runs > 1
    variances = across[repeated] / (2 * number[repeated])
    return float(np.sqrt(np.average(variances, weights=runs[repeated] - 1)))


def _squared_differences(values: FloatArray, group: IndexArray) -> FloatArray:
    """Sum of squared differences over the pairs of each group."""
    centred = values - (np.bincount(group, values) / np.bincount(group))[group]
    return np.asarray(np.bincount(group) * np.bincount(group, centred**2), dtype=float)


# What runs may have in common: columns of the table of runs.
_GROUPS = ("rig", "log_kind", "reader", "encoding", "delimiter", "decimal_mark")
_NONE = Pattern("", "", ())
_NOMINAL = re.compile(r"nominal_(.+)_(?:gpa|n|m_s|c)$")


def finished_fits(results: CampaignTables, settings: Settings) -> dict[str, pd.DataFrame]:
    """The tables of the fits, `law_verdicts`, `lack_of_fit` and `soundness`, by name.

    Args:
        results: The tables of every fit, `points` and `runs`.
        settings: `fit`, `patterns`, `compare`, and those of `noise_and_misfit`.
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
    least = settings.compare.bic_difference_min
    return {
        **{name: results.table(name) for name in OF_FIT},
        "law_verdicts": best_laws(quality, results.law_points, results.points, least),
        "lack_of_fit": lack_of_fit,
        "soundness": judged_fits(results, lack_of_fit, settings),
    }


def judged_fits(
    results: CampaignTables, lack_of_fit: pd.DataFrame, settings: Settings
) -> pd.DataFrame:
    """Table `soundness`: the verdict on the configured law's fit to each oil, in three parts.

    Args:
        results: As of `finished_fits`.
        lack_of_fit: The table.
        settings: `fit` and `patterns`.
    """
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
        verdict = verdict_of_fit(
            row,
            fitted.get(oil),
            used,
            settings.fit,
            settings.patterns,
            runs=results.runs,
            others=fitted,
            lack_shown=lack.get(oil) == "shown",
        )
        rows.append({**verdict, "oil": oil, "law": row["law"]})
    return tables.from_rows(rows, "soundness")


def verdict_of_fit(
    quality: Mapping[str, Any],
    fitted: FittedLaw | None,
    points: pd.DataFrame,
    settings: FitSettings,
    patterns: PatternSettings,
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
        patterns: When a pattern is called found.
        runs: Table of runs; without it no groups of runs are known.
        others: The fits of all oils.
        lack_shown: Whether repeated runs show a lack of fit.
    """
    left = None
    no_fit = fitted is None or np.isnan(quality["rmse"])
    if fitted is not None and not no_fit:
        # a condition of these runs is unknown
        used = points[~points["run_id"].isin(quality["incomplete_curves"])]
        groups = {} if runs is None else runs_in_common(runs, used, patterns.curves_min)
        left = leftover(fitted, used, groups, others or {}, patterns)
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
        "two levels": len(quality["two_level_conditions"]) > 0,
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
    other_oil = change.what.removeprefix("oil ") if change.what.startswith("oil ") else ""
    return {
        "optimum_confirmed": optimum,
        "law_verdict": law,
        "bend": tuple(bend.what.split()),
        "bend_relative_rms": bend.mu_share,
        "campaign_verdict": steady,
        "change": "oil" if other_oil else change.what,
        "change_oil": other_oil,
        "change_course": change.when,
        "change_group": change.group,
        "changed_runs": () if change.when == "trend" else tuple(map(str, change.runs)),
        "change_size": change.size,
        "change_relative_rms": change.mu_share,
        "sound": optimum and law == "adequate" and steady == "steady",
    }


def leftover(
    fitted: FittedLaw,
    points: pd.DataFrame,
    groups: Mapping[str, set[str]],
    others: Mapping[str, FittedLaw],
    limits: PatternSettings,
) -> Leftover | None:
    """What a fit leaves over of its points; None where a condition is not known.

    Args:
        fitted: The fit.
        points: The oil's accepted points.
        groups: Runs that have something in common, by what it is.
        others: The fits of all oils.
        limits: When a pattern is called found.
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
    return Leftover(problem, optimum, dict(reversed(of_runs.values())), known, limits)


def runs_in_common(
    runs: pd.DataFrame, points: pd.DataFrame, curves_min: int
) -> dict[str, set[str]]:
    """Runs that have something in common.

    That is the rig, the kind and form of the log, its columns and their units, what header and run
    sheet say (a set point at all, any other key with its value), the sign of the slip.

    Args:
        runs: Table of runs.
        points: Accepted points of an oil.
        curves_min: Fewest runs with a column or a line of the header.
    """
    groups = {
        f"{column} {value}": set(of_value["run_id"])
        for column in _GROUPS
        for value, of_value in runs.groupby(column)
    }
    for column, label in (("columns", "the column "), ("stated", "")):
        parts = runs.set_index("run_id")[column].explode().dropna()
        groups |= {
            f"{label}{part}": set(of.index)
            for part, of in parts.groupby(parts)
            if part and curves_min <= len(of) < len(runs)
        }
    groups |= {
        f"set point of {match[1].replace('_', ' ')} stated": set(runs.loc[at.notna(), "run_id"])
        for column, at in runs.items()
        if (match := _NOMINAL.match(str(column)))
    }
    highest = points.groupby("run_id")["slide_roll_ratio"].max()
    groups["slip below zero"] = set(highest.index[highest <= 0])
    return groups
