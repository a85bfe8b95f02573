"""One law fitted to one oil: searches, certificate, errors, cross-validation.

Decides: the errors of curves left out.
"""

import itertools
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.base.randomness import generator
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.fits.conditions import (
    fixed_conditions,
    fixed_conditions_to_json,
    followed_condition_mask,
    incomplete_curve_mask,
    level_numbers_by_gap,
    varied_condition_mask,
)
from oilfilm.fits.descent import descend
from oilfilm.fits.fit_tables import (
    Solution,
    certificate_columns,
    fitted_constant_names,
    tables_of_fit,
    tables_without_fit,
)
from oilfilm.fits.global_search import Optimum, converge, is_at_bound, search
from oilfilm.fits.problem import CurveData, Problem, build_problem, curve_data
from oilfilm.fits.robust_fit import fit_robustly
from oilfilm.fits.uncertainty import (
    Estimates,
    calibration_refits,
    cluster_robust_draws,
    curve_bootstrap,
    naive_covariance,
    profiles,
)
from oilfilm.settings.config import FitSettings
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS, laws_for
from oilfilm.traction.law import CONDITIONS, Law, NoValueError

# Relative decrease of the SSE at which a fit without some curves ends. It is small because the
# errors of single points, which are reported, change more with the constants than the SSE does.
_LEFT_OUT_TOLERANCE = 1e-8
# Columns of the points that span the tested box.
TESTED_BOX_COLUMNS = (*CONDITIONS, "load_n", "slide_roll_ratio")


def laws_of_oil(oil: str, settings: Settings) -> dict[str, Law]:
    """The laws, by name, for which all needed properties of the oil and the rigs are known."""
    return laws_for(settings.properties_of(oil), settings.common_contact())


def fit_law(points: pd.DataFrame, oil: str, law_name: str, settings: Settings) -> CampaignTables:
    """Fit one law to one oil's accepted points, and evaluate it at curves left out of the fit.

    Points, settings, seeds and the curves that are left out are the same for every law.

    Args:
        points: Table of points.
        oil: Oil to fit.
        law_name: Name of the law.
        settings: `fit` and `seed`; for a law that needs properties of the oil and the
            contact, `oils` and `rigs` as well.

    Returns:
        As `fit_oil`. A law that needs unknown properties gives no values, with the reason.
    """
    law = LAWS.get(law_name)
    if law is None:
        # a law that needs properties of the oil
        law = laws_of_oil(oil, settings).get(law_name)
    if law is None:
        quality_row = {
            "oil": oil,
            "law": law_name,
            "configured": True,
            "no_fit": "properties unknown",
        }
        return tables_without_fit([], quality_row)
    return fit_oil(points, oil, settings.fit, settings.seed, law)


def fit_oil(
    points: pd.DataFrame, oil: str, settings: FitSettings, seed: int, law: Law | None = None
) -> CampaignTables:
    """Fit a law to one oil's accepted points.

    Args:
        points: Table of points of the campaign.
        oil: Oil to fit.
        settings: Config's `fit`.
        seed: Seed of all random numbers.
        law: Law to fit; the configured law if not given.

    Returns:
        The oil's rows of the tables of a fit. Data that cannot be fitted give rows without values
        and a verdict that says why.
    """
    if law is None:
        law = LAWS[settings.law]
    is_of_oil = points["oil"] == oil
    if not is_of_oil.all():
        # the table of one oil, as a job has it, is not copied
        points = points[is_of_oil]
    data = curve_data(points, law.conditions)
    is_incomplete = incomplete_curve_mask(law.conditions, data.conditions, settings)
    incomplete_runs = list(itertools.compress(data.run_ids, is_incomplete))
    if incomplete_runs:
        points = points[~points["run_id"].isin(incomplete_runs)]
        data = curve_data(points, law.conditions)
    is_followed = followed_condition_mask(law.conditions, data.conditions, settings)
    fixed = fixed_conditions(law.conditions, data.conditions, is_followed, settings)
    quality_row: dict[str, Any] = {
        "oil": oil,
        "law": law.name,
        "configured": True,
        "n_points": len(data.mu),
        "n_curves": len(data.run_ids),
        "incomplete_curves": tuple(incomplete_runs),
        "fixed_conditions": fixed_conditions_to_json(fixed),
    }
    accepted = points.loc[points["accepted"], list(TESTED_BOX_COLUMNS)]
    # a temperature may be below zero; the law is odd in slip
    accepted = accepted.assign(slide_roll_ratio=accepted["slide_roll_ratio"].abs())
    smallest = accepted.min()
    largest = accepted.max()
    for name in TESTED_BOX_COLUMNS:
        quality_row[f"tested_min_{name}"] = float(smallest[name])
        quality_row[f"tested_max_{name}"] = float(largest[name])
    no_fit_columns = _no_fit_columns(law, data, is_followed)
    if no_fit_columns:
        return tables_without_fit(fitted_constant_names(law), {**quality_row, **no_fit_columns})
    problem = build_problem(law, data, is_followed)
    solution = _solve(problem, oil, points, settings, seed)
    if solution is None:
        quality_row["no_fit"] = "all constants at bounds"
        return tables_without_fit(fitted_constant_names(law), quality_row)
    quality_row.update(_errors_at_end_levels(solution, points, settings))
    return tables_of_fit(solution, points, quality_row, settings)


def _no_fit_columns(law: Law, data: CurveData, is_followed: BoolArray) -> dict[str, Any]:
    """Why a law cannot be fitted to data, as columns of `fit_quality`; empty where it can.

    Args:
        law: The law.
        data: The accepted points.
        is_followed: Whether the fit follows each condition of the law, shape (conditions,).
    """
    if not len(data.mu):
        return {"no_fit": "no points"}
    try:
        law.varied_groups(is_followed)
    except ValueError:
        return {"no_fit": "conditions did not vary"}
    try:
        problem = build_problem(law, data, is_followed)
    except NoValueError:
        return {"no_fit": "no value"}
    unusable_count = int(np.sum(~np.isfinite(data.mu + data.slip)))
    if unusable_count:
        return {"no_fit": "unknown traction", "unusable_points": unusable_count}
    if not np.any(data.slip):
        return {"no_fit": "no slip"}
    if not np.any(data.mu > 0):
        return {"no_fit": "no traction"}
    point_rows = np.column_stack([data.conditions[data.curve_of_point], data.slip, data.mu])
    distinct_count = len(np.unique(point_rows, axis=0))
    needed_count = int(problem.is_free.sum()) + 1
    if distinct_count < needed_count:
        return {
            "no_fit": "too few points",
            "distinct_points": distinct_count,
            "points_needed": needed_count,
        }
    if np.ptp(data.mu) == 0:
        return {"no_fit": "constant traction"}
    return {}


def _solve(
    problem: Problem, oil: str, points: pd.DataFrame, settings: FitSettings, seed: int
) -> Solution | None:
    """The optimum of all searches, with its certificate and its errors.

    None where every constant ended at a bound: the law cannot describe such points.

    Args:
        problem: What to fit.
        oil: The oil, for the random numbers.
        points: The oil's rows of the table of points.
        settings: Config's `fit`.
        seed: Seed of all random numbers.
    """
    randoms = [generator(seed, "search", oil, number) for number in range(settings.searches)]
    optima = search(problem, settings, randoms)
    if problem.law.nested_law is not None:
        random = generator(seed, "nested", oil)
        optima.append(_optimum_from_nested_law(problem, problem.law.nested_law, settings, random))
    problem, optima = _with_bounds_held(problem, optima)
    if not problem.is_free.any():
        return None
    optimum = min(optima, key=lambda optimum: optimum.sse)
    optimum_covariance = naive_covariance(problem, optimum)
    all_refits = _refits(problem, optimum, settings, generator(seed, "bootstrap", oil))
    # a refit at a bound ended where the search stopped, and its constants mean nothing
    refits = all_refits[~is_at_bound(problem, all_refits).any(axis=1)]
    shifted_refits = calibration_refits(problem, optimum, points)
    estimates = Estimates(optimum.constants, optimum_covariance, refits, shifted_refits)
    # the seed does not contain the law: the same groups are left out for every law
    random = generator(seed, "left out", oil)
    left_out_errors = errors_at_curves_left_out(problem, optimum, settings, random)
    return Solution(
        problem=problem,
        optimum=optimum,
        certificate=certificate_columns(
            problem, optima, np.sqrt(np.diag(optimum_covariance)), settings
        ),
        estimates=estimates.in_equation_form(problem),
        profiles=profiles(problem, optimum, optimum_covariance),
        robust_fit=fit_robustly(problem, optimum),
        left_out_errors=left_out_errors,
        refits_at_bounds_count=len(all_refits) - len(refits),
    )


def _optimum_from_nested_law(
    problem: Problem, nested_law: Law, settings: FitSettings, random: np.random.Generator
) -> Optimum:
    """One more search, from the optimum of a law that is a special case of the problem's law."""
    nested_problem = build_problem(nested_law, problem.data, problem.is_followed_condition)
    (nested_optimum,) = search(nested_problem, settings, [random])
    nested_constants = nested_problem.expand(nested_optimum.constants)
    value_by_name = {
        constant.name: value
        for constant, value in zip(nested_law.constants, nested_constants, strict=True)
    }
    start = [value_by_name.get(constant.name, constant.lower) for constant in problem.law.constants]
    return converge(problem, np.array(start)[problem.is_free])


def _refits(
    problem: Problem, optimum: Optimum, settings: FitSettings, random: np.random.Generator
) -> FloatArray:
    """Constants as other campaigns of such runs would give them, shape (refits, free).

    They come from the bootstrap over curves. Where the curves are too few for it, they are drawn
    from the cluster-robust covariance. There are none where the curves are too few for both, and
    where few curves do not determine all constants.
    """
    if problem.curve_count < settings.min_curves_for_errors:
        return np.empty((0, len(optimum.constants)))
    if problem.curve_count < settings.min_curves_to_resample:
        return cluster_robust_draws(problem, optimum, settings.bootstrap, random)
    return curve_bootstrap(problem, optimum, settings.bootstrap, random)


def _with_bounds_held(problem: Problem, optima: list[Optimum]) -> tuple[Problem, list[Optimum]]:
    """The problem with those constants held that are at a bound in the lowest optimum.

    Returns:
        The problem, and all optima without these constants.
    """
    lowest = min(optima, key=lambda optimum: optimum.sse)
    is_held = is_at_bound(problem, lowest.constants)
    reduced_optima = [Optimum(optimum.constants[~is_held], optimum.sse) for optimum in optima]
    return problem.holding(lowest.constants, is_held), reduced_optima


def _errors_at_end_levels(
    solution: Solution, points: pd.DataFrame, settings: FitSettings
) -> dict[str, float]:
    """Relative errors at the lowest and highest level of each condition, left out of the fit.

    Returns:
        Columns of `fit_quality`.
    """
    problem = solution.problem
    # not the conditions of this law: every law is evaluated at the same levels
    conditions = curve_data(points).conditions
    # a condition that did not vary only scatters: it has no lowest and highest level
    conditions = np.where(
        varied_condition_mask(CONDITIONS, conditions, settings), conditions, np.nan
    )
    columns = {}
    for name, values_of_condition in zip(
        ("pressure", "speed", "temperature"), conditions.T, strict=True
    ):
        level_of_curve = level_numbers_by_gap(values_of_condition, settings.level_gap)
        errors = errors_at_ends_left_out(problem, solution.optimum, level_of_curve, settings)
        sum_of_mu_squared = np.sum(problem.mu[np.isfinite(errors)] ** 2)
        relative_rms = np.nan
        if sum_of_mu_squared:
            relative_rms = float(np.sqrt(np.nansum(errors**2) / sum_of_mu_squared))
        columns[f"{name}_end_out_relative_rms"] = relative_rms
    return columns


# ---------------------------------------------------------------- curves left out


def errors_at_curves_left_out(
    problem: Problem, optimum: Optimum, settings: FitSettings, random: np.random.Generator
) -> FloatArray:
    """Error of each point's mu in a fit without the point's curve (cross-validation).

    Each such fit descends from the optimum of all curves; other valleys are not searched. Up to
    `left_out_groups` curves are left out one at a time. More curves are left out in that many
    random groups, so that the cost grows with the number of curves and not with its square.

    Args:
        problem: What was fitted.
        optimum: Where it ended.
        settings: `left_out_groups`, and those of `followed_condition_mask`.
        random: Draws the groups.

    Returns:
        Fitted minus measured mu, shape (points,); NaN where the other curves do not determine a
        constant.

    Reference: T. Hastie, R. Tibshirani, J. Friedman, The Elements of Statistical Learning, 2nd ed.
        (2009), section 7.10.1.
    """
    group_of_curve = np.arange(problem.curve_count)
    if problem.curve_count > settings.left_out_groups:
        group_of_curve = random.permutation(group_of_curve) % settings.left_out_groups
    groups = np.unique(group_of_curve)
    is_left_out = groups[:, np.newaxis] == group_of_curve
    return _errors_by_fits_without(problem, optimum, is_left_out, settings)


def errors_at_ends_left_out(
    problem: Problem, optimum: Optimum, level_of_curve: IndexArray, settings: FitSettings
) -> FloatArray:
    """Error of each point's mu at the lowest and highest level, by fits without that level.

    Each fit is extrapolated to the level that was left out.

    Args:
        problem: What was fitted.
        optimum: Where it ended.
        level_of_curve: Index of the level of each curve, as `level_numbers_by_gap` returns it.
        settings: Those of `followed_condition_mask`.

    Returns:
        Fitted minus measured mu, shape (points,). NaN at all levels between, and at all points
        where there are fewer than two levels or the other levels do not determine a constant.
    """
    if level_of_curve.max(initial=0) == 0:
        return np.full(len(problem.mu), np.nan)
    is_left_out = np.stack([level_of_curve == 0, level_of_curve == level_of_curve.max()])
    return _errors_by_fits_without(problem, optimum, is_left_out, settings)


def _errors_by_fits_without(
    problem: Problem, optimum: Optimum, is_left_out: BoolArray, settings: FitSettings
) -> FloatArray:
    """Errors at curves left out, by fits to the other curves.

    Args:
        problem: What was fitted.
        optimum: Where it ended.
        is_left_out: Whether each fit leaves out each curve, shape (fits, curves).
        settings: Those of `followed_condition_mask`.

    Returns:
        Fitted minus measured mu, shape (points,); NaN where no fit left the point out, or where
        the other curves do not determine a constant.
    """
    # not by the rank: a condition with one level left still scatters
    conditions = problem.data.conditions[:, problem.is_followed_condition]
    condition_names = list(
        itertools.compress(problem.law.conditions, problem.is_followed_condition)
    )
    is_possible = []
    for is_out_of_fit in is_left_out:
        followed = followed_condition_mask(condition_names, conditions[~is_out_of_fit], settings)
        is_possible.append(bool(followed.all()) and not is_out_of_fit.all())
    is_left_out = is_left_out[is_possible]
    starts = np.tile(optimum.constants, (len(is_left_out), 1))
    weights = (~is_left_out).astype(float)
    constants_of_fits, _ = descend(
        problem, starts, weights=weights, tolerance=_LEFT_OUT_TOLERANCE, use_newton=True
    )
    errors = np.full(len(problem.mu), np.nan)
    for constants, is_out_of_fit in zip(constants_of_fits, is_left_out, strict=True):
        is_point_out = is_out_of_fit[problem.observations.curve_of_point]
        errors[is_point_out] = problem.residual(constants)[is_point_out]
    return errors
