"""Whether a fit is sound: its optimum confirmed, its law adequate, its campaign steady.

The table `lack_of_fit` compares the residuals of each fit with the noise of its data. A misfit is
the distance of a law from the surface of measured mu.

Decides: when a fit is called sound; which runs repeat a condition; what is noise, and what is lack
of fit.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
import scipy

from oilfilm import tables
from oilfilm.base.levels import level_indices
from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.fits.best_law import best_laws
from oilfilm.fits.conditions import condition_level_numbers, fixed_conditions_from_json
from oilfilm.fits.fitted import FittedLaw, read_surface
from oilfilm.fits.interval import CONFIDENCE
from oilfilm.fits.steady_campaign import (
    LABEL_COLUMNS,
    NO_CHANGE,
    MeasuredCampaign,
    change_columns,
    members_by_common_label,
)
from oilfilm.settings.config import ConfigKeys
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.set_points import NOMINAL_COLUMNS, with_matched_set_points

# Largest ratio of the sum of squares to the sum of squares between repeats. Repeats that are copies
# of each other differ by rounding only.
_LARGEST_RATIO = 1e6
# Columns of measured conditions, which replace set points that no log states; in the order of
# `NOMINAL_COLUMNS`.
_MEASURED_CONDITIONS = (
    "max_hertz_pressure_gpa",
    "load_n",
    "entrainment_speed_m_s",
    "inlet_temperature_c",
)


def lack_of_fit_table(results: CampaignTables, settings: Settings) -> pd.DataFrame:
    """Table `lack_of_fit`: the residuals of each fit, split into noise and lack of fit.

    Args:
        results: Tables `coefficients`, `fit_quality`, `points` and `runs`.
        settings: `same_condition`, `rigs`, `oils`, `same_set_point`, and the campaign's `rigs` and
            `matrix`.
    """
    condition_of_run = _condition_of_run(results, settings)
    rows = []
    for quality_row in tables.rows(results.configured_fits.fit_quality):
        row = {"oil": quality_row["oil"], "law": quality_row["law"], "verdict": "no fit"}
        if not np.isnan(quality_row["rmse"]):
            row.update(
                _lack_of_fit_columns(
                    quality_row, results.configured_fits, condition_of_run, settings
                )
            )
        rows.append(row)
    # a row without a fit lacks most columns: they become null, 0 or empty
    return tables.filled_table(pd.DataFrame(rows), "lack_of_fit")


def _lack_of_fit_columns(
    quality_row: dict[str, Any],
    results: CampaignTables,
    condition_of_run: "pd.Series[int]",
    settings: Settings,
) -> dict[str, Any]:
    """The columns of `lack_of_fit` of one fit.

    Args:
        quality_row: The fit's row of `fit_quality`.
        results: Tables of the configured law.
        condition_of_run: As `_condition_of_run` returns it.
        settings: `same_condition`.
    """
    oil = quality_row["oil"]
    fit = FittedLaw.from_tables(results.coefficients, oil, quality=results.fit_quality)
    columns = ["run_id", "accepted", *fit.law.conditions, "slide_roll_ratio"]
    columns += ["traction_coefficient", "traction_coefficient_se"]
    points = results.table("points", columns, oil=oil)
    points_of_fit = points[points["accepted"]]
    # the conditions of a point are the mean conditions of its run, as in the fit
    mean_conditions = (
        points_of_fit.groupby("run_id")[list(fit.law.conditions)].transform("mean").to_numpy(float)
    )
    slip = points_of_fit["slide_roll_ratio"].to_numpy(float)
    mu = points_of_fit["traction_coefficient"].to_numpy(float)
    slip_sign = np.where(slip < 0, -1.0, 1.0)
    # predictions come for blocks of points
    fitted_mu_of_blocks = [
        prediction.traction_coefficient for prediction in fit.predictions(mean_conditions, slip)
    ]
    residual = slip_sign * (np.concatenate(fitted_mu_of_blocks) - mu)
    has_residual = np.isfinite(residual)
    points_of_fit = points_of_fit[has_residual]
    residual = residual[has_residual]
    slip = slip[has_residual]
    mu = mu[has_residual]
    condition_of_point = points_of_fit["run_id"].map(condition_of_run).to_numpy(np.int64)
    run_of_point, _ = pd.factorize(points_of_fit["run_id"])
    slip_level_of_point = _level_numbers_within(
        condition_of_point, np.abs(slip), settings.same_condition.slide_roll_ratio
    )
    is_of_oil = results.coefficients["oil"] == oil
    # a constant at its bound counts too
    constant_count = int(results.coefficients.loc[is_of_oil, "value"].notna().sum())
    test = lack_of_fit(
        residual, run_of_point, condition_of_point, slip_level_of_point, constant_count
    )
    if np.isnan(test.noise):
        verdict = "no repeats"
    else:
        verdict = "shown" if test.is_shown else "not shown"
    rms_mu = float(np.sqrt(np.mean(mu**2)))
    # rms of the standard errors of the points
    mu_se_rms = np.sqrt((points_of_fit["traction_coefficient_se"] ** 2).mean())
    return {
        "n_repeats": test.repeat_count,
        "n_repeated_conditions": test.repeated_condition_count,
        "relative_rms": quality_row["relative_rms"],
        "repeat_relative_rms": test.noise / rms_mu,
        "lack_of_fit_relative_rms": test.form_rms / rms_mu,
        "plateau_relative_rms": mu_se_rms / rms_mu,
        "lack_of_fit_ratio": test.ratio,
        "lack_of_fit_limit": test.limit,
        "verdict": verdict,
    }


def _level_numbers_within(
    group_of_value: IndexArray, values: FloatArray, width: float
) -> IndexArray:
    """Index of the level of each value within its group, shape (values,).

    Args:
        group_of_value: Index of the group of each value, shape (values,).
        values: The values.
        width: Largest range of the values of one level.
    """
    level_of_value = np.empty(len(values), dtype=np.int64)
    values_by_group = np.argsort(group_of_value, kind="stable")
    begins = np.flatnonzero(np.diff(group_of_value[values_by_group])) + 1
    for value_indices in np.split(values_by_group, begins):
        level_of_value[value_indices] = level_indices(values[value_indices], width)
    return level_of_value


def _condition_of_run(results: CampaignTables, settings: Settings) -> "pd.Series[int]":
    """Index of the condition of each run, by `run_id`.

    Runs have the same condition where oil, rig and set points are the same. Where a set point is
    not stated, the level of the measured mean is used, by the widths of `same_condition`.
    """
    # each set point that is stated is moved to the value of its level, in its unit
    stated_set_points = results.table("runs", ["run_id", "oil", "rig", *NOMINAL_COLUMNS])
    runs = with_matched_set_points(stated_set_points, settings).set_index("run_id")
    columns = ["run_id", "accepted", *_MEASURED_CONDITIONS]
    # each part has all points of some runs
    means_of_parts = [
        points[points["accepted"]].groupby("run_id")[list(_MEASURED_CONDITIONS)].mean()
        for points in results.blocks_of_runs("points", columns)
    ]
    means = pd.concat(means_of_parts).reindex(runs.index)
    # pressure and load are one set point: where one is stated, the other is not needed
    load_set_points = NOMINAL_COLUMNS[:2]
    is_load_stated = runs[list(load_set_points)].notna().any(axis=1)
    labels = runs[["oil", "rig"]].assign(load_noted=is_load_stated)
    for name, measured in zip(NOMINAL_COLUMNS, _MEASURED_CONDITIONS, strict=True):
        is_stated = is_load_stated if name in load_set_points else runs[name].notna()
        level_number = condition_level_numbers(
            measured, means[measured].to_numpy(float), settings.same_condition
        )
        # in columns of their own: a temperature that is set may be any number, also that of a level
        labels[name] = runs[name]
        labels[measured] = np.where(is_stated, 0, level_number)
    return labels.groupby(list(labels), sort=False, dropna=False).ngroup()


# ---------------------------------------------------------------- the test


@dataclass(frozen=True)
class LackOfFit:
    """Noise and lack of fit, in the unit of the residuals.

    Attributes:
        repeat_count: Number of runs that repeat the condition of an earlier run.
        repeated_condition_count: Number of conditions with several runs.
        noise: Standard deviation of a point, with the error of its run; NaN without repeats that
            can be compared: at one level of slip, and more levels than constants.
        form_rms: Root-mean-square error of the law's form, 0 where the noise explains the
            residuals; NaN where `noise` is.
        ratio: F, mean square of the lack of fit over that of repeats; NaN where `noise` is.
        limit: 95 % limit of F where the law's form is right; NaN where `noise` is.
    """

    repeat_count: int
    repeated_condition_count: int
    noise: float
    form_rms: float
    ratio: float
    limit: float

    @property
    def is_shown(self) -> bool:
        """Whether the repeats show that the law's form is wrong."""
        return self.ratio > self.limit


def lack_of_fit(
    residual: FloatArray,
    run_of_point: IndexArray,
    condition_of_point: IndexArray,
    slip_level_of_point: IndexArray,
    constant_count: int,
) -> LackOfFit:
    """The classical test of lack of fit, for points that share the errors of their run.

    Points of different runs at one condition and one level of slip are repeats. Half the mean
    square of their differences is the variance of a point, with its run's error. Residuals are used
    instead of mu, so that small differences of condition and slip do not count. The mean squared
    residual less this variance is the mean squared error of the law's form. The test is

        F = (SSE - SSPE)/(cells - constants) / (SSPE/(n - cells))

    over the means of each run in each cell, where a cell is one level of slip at one condition. The
    values of a run are not independent, so each run counts as one value: both degrees of freedom
    are divided by the values per run. This is the most careful choice (lower bound of Greenhouse
    and Geisser). With one value per run it is the classical test.

    Args:
        residual: Fitted minus measured mu of each point, shape (points,).
        run_of_point: Index of the run of each point, from 0, shape (points,).
        condition_of_point: Index of the condition of each point, the same for all points of a run.
        slip_level_of_point: Index of the level of slip of each point.
        constant_count: Number of fitted constants.

    References: N. R. Draper, H. Smith, Applied Regression Analysis, 3rd ed. (1998), section 2.1;
        S. W. Greenhouse, S. Geisser, Psychometrika 24 (1959) 95.
    """
    condition_of_run = np.zeros(run_of_point.max() + 1, dtype=np.int64)
    condition_of_run[run_of_point] = condition_of_point
    run_count_of_condition = np.bincount(condition_of_run)
    repeat_count = int(np.sum(run_count_of_condition[run_count_of_condition > 1] - 1))
    repeated_condition_count = int(np.sum(run_count_of_condition > 1))
    _, cell_of_point = np.unique(
        np.column_stack([condition_of_point, slip_level_of_point]), axis=0, return_inverse=True
    )
    distinct_cells_and_runs, pair_of_point = np.unique(
        np.column_stack([cell_of_point, run_of_point]), axis=0, return_inverse=True
    )
    # mean of each run in each cell: a value of the test
    mean_residuals = np.bincount(pair_of_point, residual) / np.bincount(pair_of_point)
    cell_of_pair = distinct_cells_and_runs[:, 0]
    values_per_cell = np.bincount(cell_of_pair)
    pure_error_freedom = len(mean_residuals) - len(values_per_cell)
    lack_of_fit_freedom = len(values_per_cell) - constant_count
    if pure_error_freedom == 0 or lack_of_fit_freedom <= 0:
        nan = float("nan")
        return LackOfFit(
            repeat_count, repeated_condition_count, noise=nan, form_rms=nan, ratio=nan, limit=nan
        )
    sum_of_cell = np.bincount(cell_of_pair, mean_residuals)
    sse = float(np.sum(mean_residuals**2))
    # lack of fit: the part of it that the means of cells have
    sse_of_cells = float(np.sum(sum_of_cell**2 / values_per_cell))
    pure_error_sse = max(sse - sse_of_cells, sse / _LARGEST_RATIO)
    ratio = 0.0
    # an exact fit lacks nothing
    if sse > 0:
        ratio = sse_of_cells / lack_of_fit_freedom / (pure_error_sse / pure_error_freedom)
    values_per_run = len(mean_residuals) / len(condition_of_run)
    limit = scipy.special.fdtri(
        lack_of_fit_freedom / values_per_run, pure_error_freedom / values_per_run, CONFIDENCE
    )
    noise = _sd_between_runs(residual, pair_of_point, cell_of_pair, cell_of_point)
    # the constants have taken up a part of the noise
    noise_in_residuals = (1 - constant_count / len(residual)) * noise**2
    unexplained = float(np.mean(residual**2)) - noise_in_residuals
    form_rms = float(np.sqrt(max(unexplained, 0.0)))
    return LackOfFit(repeat_count, repeated_condition_count, noise, form_rms, ratio, float(limit))


def _sd_between_runs(
    residual: FloatArray,
    pair_of_point: IndexArray,
    cell_of_pair: IndexArray,
    cell_of_point: IndexArray,
) -> float:
    """Standard deviation of a point, from differences between runs in one cell.

    Args:
        residual: Fitted minus measured mu of each point.
        pair_of_point: Index of the pair of a cell and a run of each point, shape (points,).
        cell_of_pair: Index of the cell of each pair, shape (pairs,).
        cell_of_point: Index of the cell of each point, shape (points,).
    """
    squares_within_runs = np.bincount(cell_of_pair, _squared_differences(residual, pair_of_point))
    squares_between_runs = _squared_differences(residual, cell_of_point) - squares_within_runs
    # couples of points, in either order and of a point with itself
    ordered_couples_within_runs = np.bincount(cell_of_pair, np.bincount(pair_of_point) ** 2)
    couple_counts_between_runs = (np.bincount(cell_of_point) ** 2 - ordered_couples_within_runs) / 2
    run_counts = np.bincount(cell_of_pair)
    is_repeated = run_counts > 1
    variances = squares_between_runs[is_repeated] / (2 * couple_counts_between_runs[is_repeated])
    variance = np.average(variances, weights=run_counts[is_repeated] - 1)
    # copies differ by rounding, which may make it negative
    return float(np.sqrt(max(variance, 0.0)))


def _squared_differences(values: FloatArray, group_of_value: IndexArray) -> FloatArray:
    """Sum of squared differences over all pairs of values of each group, shape (groups,).

    Args:
        values: The values, shape (values,).
        group_of_value: Index of the group of each value, shape (values,).
    """
    value_counts = np.bincount(group_of_value)
    group_means = np.bincount(group_of_value, values) / value_counts
    centred = values - group_means[group_of_value]
    return np.asarray(value_counts * np.bincount(group_of_value, centred**2), dtype=float)


# ---------------------------------------------------------------- the verdict


def with_configured_fits_marked(results: CampaignTables, law_name: str) -> CampaignTables:
    """The tables of every fit, with a mark at the fits of the configured law.

    Args:
        results: Table `fit_quality`; no job of a fit knows which law is configured.
        law_name: Name of the configured law.
    """
    quality = results.fit_quality
    return results.replace(fit_quality=quality.assign(configured=quality["law"] == law_name))


def finished_fit_tables(results: CampaignTables, settings: Settings) -> dict[str, pd.DataFrame]:
    """The tables `fit_quality`, `law_verdicts`, `lack_of_fit` and `soundness`, by name.

    The other tables of the fits stay as they are.

    Args:
        results: The tables of every fit, `points` and `runs`.
        settings: `fit`, `surface`, `steadiness`, `compare`, and those of `lack_of_fit_table`.
    """
    results = with_configured_fits_marked(results, settings.fit.law)
    quality = results.fit_quality
    limiting_stress_ratios = {}
    for oil in quality["oil"].unique():
        properties = settings.properties_of(oil)
        if properties is not None:
            limiting_stress_ratios[oil] = properties.limiting_stress_ratio
    quality = quality.assign(
        limiting_stress_ratio=quality["oil"].map(limiting_stress_ratios).astype(float)
    )
    results = results.replace(fit_quality=quality)
    finished = {"fit_quality": quality}
    finished["law_verdicts"] = best_laws(results, settings.compare.bic_difference_min)
    finished["lack_of_fit"] = lack_of_fit_table(results, settings)
    finished["soundness"] = soundness_table(results, finished["lack_of_fit"], settings)
    return finished


def soundness_table(
    results: CampaignTables, lack_of_fit_rows: pd.DataFrame, settings: Settings
) -> pd.DataFrame:
    """Table `soundness`: the verdict on the configured law's fit to each oil, in three parts.

    Args:
        results: Tables of fits of which the configured ones are marked, `points` and `runs`.
        lack_of_fit_rows: Table `lack_of_fit`.
        settings: `fit`, `surface` and `steadiness`.
    """
    fits = results.configured_fits
    quality_row_by_oil = {row["oil"]: row for row in tables.rows(fits.fit_quality)}
    lack_verdict_by_oil = lack_of_fit_rows.set_index("oil")["verdict"]
    rows = []
    for oil, quality_row in quality_row_by_oil.items():
        # of one oil at a time: a fit keeps its surface
        fitted = None
        if np.isfinite(quality_row["rmse"]):
            fitted = FittedLaw.from_tables(fits.coefficients, oil, quality=fits.fit_quality)
            # the surface is read only when it is used
            fitted = replace(fitted, read_surface=partial(read_surface, results, oil))
        points = results.table("points", ["run_id", "accepted", "slide_roll_ratio"], oil=oil)
        accepted_points = points[points["accepted"]]
        largest_slips = accepted_points.groupby("run_id")[["slide_roll_ratio"]].max().reset_index()
        # the points of a large campaign take more memory than its runs
        del points, accepted_points
        tables.release_memory()
        verdict = soundness_row(
            quality_row,
            fitted,
            largest_slips,
            settings,
            runs=results.table("runs", LABEL_COLUMNS, oil=oil),
            is_lack_of_fit_shown=lack_verdict_by_oil.get(oil) == "shown",
        )
        rows.append({**verdict, "oil": oil, "law": quality_row["law"]})
    # every row has every column: nothing is to be filled
    return tables.from_rows(rows, "soundness")


def soundness_row(
    quality_row: Mapping[str, Any],
    fitted: FittedLaw | None,
    points: pd.DataFrame,
    settings: ConfigKeys,
    runs: pd.DataFrame | None = None,
    is_lack_of_fit_shown: bool = False,
) -> dict[str, Any]:
    """The row of the table `soundness` of one fit.

    Args:
        quality_row: The fit's row of `fit_quality`.
        fitted: The fit; None where there is none.
        points: Its accepted points; of each run, the point with the largest slip is enough.
        settings: `fit`, `surface` and `steadiness`; a fit on arrays has no campaign's `Settings`.
        runs: `LABEL_COLUMNS` of the table of runs; without it no groups of runs are known.
        is_lack_of_fit_shown: Whether repeated runs show a lack of fit.
    """
    no_fit = fitted is None or np.isnan(quality_row["rmse"])
    fixed_conditions = fixed_conditions_from_json(quality_row["fixed_conditions"])
    is_condition_missing = any(fixed.is_unmeasured for fixed in fixed_conditions)
    surface = None if fitted is None or no_fit else fitted.surface
    fewest_curves = settings.steadiness.curves_min
    if surface is None:
        curve_count = points["run_id"].nunique()
        fewest_curves = max(fewest_curves, settings.surface.fewest_curves)
    else:
        curve_count = len(surface.run_ids)
    too_few_curves = curve_count < fewest_curves
    # "steady", as where no change was found
    columns = dict(NO_CHANGE)
    # both relative to mu
    misfit = run_scatter = np.nan
    if fitted is not None and surface is not None:
        misfit = fitted.misfit_beside_surface
        run_scatter = surface.run_scatter
        # an unknown condition may differ between runs as a rig that changes does
        if not too_few_curves and not is_condition_missing:
            campaign = MeasuredCampaign.from_surface(surface)
            is_member_by_label = {}
            if runs is not None:
                is_member_by_label = members_by_common_label(campaign.run_ids, runs, points)
            columns = change_columns(campaign, is_member_by_label, settings.steadiness)
    # the scatter of runs may be unknown (NaN)
    largest_misfit = float(np.fmax(run_scatter, settings.surface.largest_misfit))
    law_verdict = _first_that_holds(
        {
            "no fit": no_fit,
            "condition missing": is_condition_missing,
            # what the surface explains is no scatter
            "none fits": surface is not None and surface.no_law_fits,
            # `relative_rms` is of residuals, over the rms of mu. The scatter from which a curve
            # counts as odd (`odd_scatter`) is the limit of the whole fit, too
            "misfit": quality_row["relative_rms"] > settings.fit.odd_scatter
            or misfit > largest_misfit,
            "lack of fit": is_lack_of_fit_shown,
            "too few curves": too_few_curves,
            "no surface": surface is None,
            # the next run's interval is wide between them; the law's own interval is not
            "two levels": surface is not None and surface.has_two_levels(),
        },
        otherwise="adequate",
    )
    columns["campaign_verdict"] = _first_that_holds(
        {
            "too few curves": no_fit or too_few_curves,
            "condition missing": is_condition_missing,
            "no surface": surface is None,
        },
        otherwise=columns["campaign_verdict"],
    )
    optimum_confirmed = bool(quality_row["certified"])
    is_steady = columns["campaign_verdict"] == "steady"
    return {
        "optimum_confirmed": optimum_confirmed,
        "law_verdict": law_verdict,
        "misfit": misfit,
        "run_scatter": run_scatter,
        **columns,
        "sound": optimum_confirmed and law_verdict == "adequate" and is_steady,
    }


def _first_that_holds(verdicts: Mapping[str, bool], otherwise: str) -> str:
    """The first verdict whose condition is true; `otherwise` where none is."""
    for verdict, holds in verdicts.items():
        if holds:
            return verdict
    return otherwise
