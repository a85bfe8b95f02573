"""The tables of one fit: constants, quality, refits, correlations, profiles, residuals by curve.

Here is also the certificate of a fit: independent searches agree, and the gradient of the SSE is
zero at a physical optimum.

Decides: when a fit is certified; the verdict on each constant (known, sign unknown, ...).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.base.ties import exceeds, first_largest, reaches
from oilfilm.base.units import FloatArray
from oilfilm.fits.conditions import FixedCondition, fixed_from_text
from oilfilm.fits.engine import Optimum
from oilfilm.fits.interval import normal_quantile
from oilfilm.fits.objectives import RobustFit, curve_agreement
from oilfilm.fits.problem import Problem
from oilfilm.fits.uncertainty import SENSORS, Estimates, Profiles
from oilfilm.settings.config import FitSettings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.table_needs import FIT_TABLES
from oilfilm.traction.law import CONDITIONS, Law, Observations

# Residuals of an exact fit are rounding: their SSE over the sum of mu^2 is below this.
_ROUNDING = 1e-20
# A standard error is not below this where constants are compared in standard errors.
_LEAST_ERROR = 1e-9
# Levels of each condition, and slips, at which mu is evaluated over the tested box.
_GRID_LEVELS = 9
_GRID_SLIPS = 61


@dataclass(frozen=True)
class Solution:
    """One law fitted to one oil.

    Attributes:
        problem: What was fitted; constants that ran into a bound are held there.
        best: The optimum with the smallest SSE.
        certificate: Columns of `fit_quality`, as `certify` returns them.
        estimates: The free constants in the form of the law's equation, with their errors.
        profiles: Profile of each free constant.
        robust: The fit with a robust loss; None for an exact fit.
        left_out: Fitted minus measured mu of each point by a fit without its curve, shape
            (points,); NaN where there is no such fit.
        refits_at_bounds: Number of refits in which a constant ended at a bound. They are not among
            the refits of `estimates`.
    """

    problem: Problem
    best: Optimum
    certificate: Mapping[str, Any]
    estimates: Estimates
    profiles: Profiles
    robust: RobustFit | None
    left_out: FloatArray
    refits_at_bounds: int


def tables_of_fit(
    solution: Solution, points: pd.DataFrame, quality: Mapping[str, Any], settings: FitSettings
) -> CampaignTables:
    """The tables of a fit.

    Args:
        solution: The fit.
        points: The oil's rows of the table of points, without those of incomplete curves.
        quality: Oil, law, counts and tested box: the first columns of the row of `fit_quality`.
        settings: `sign_confidence` and `pulling_weight` of config's fit.
    """
    return _with_oil_and_law(
        {**quality, **_quality(solution)},
        coefficients=_coefficients(solution, settings, quality["fixed_conditions"]),
        refits=_refits(solution),
        correlations=_correlations(solution),
        profiles=_profiles(solution),
        curve_residuals=_curve_residuals(solution, settings),
        law_points=_law_points(solution, points),
    )


def tables_without_fit(constants: Sequence[str], quality: Mapping[str, Any]) -> CampaignTables:
    """The tables of data that cannot be fitted: no values, and the reason.

    Args:
        constants: Names of the constants of the law that are fitted.
        quality: As in `tables_of_fit`, with the reason as `no_fit`.
    """
    rows = pd.DataFrame({"constant": constants}).assign(verdict="not identifiable")
    return _with_oil_and_law(quality, coefficients=rows)


def _with_oil_and_law(quality: Mapping[str, Any], **frames: pd.DataFrame) -> CampaignTables:
    """The tables of a fit, with oil and law in every row; tables without rows are empty.

    Args:
        quality: The row of `fit_quality`.
        frames: The other tables by name.
    """
    frames["fit_quality"] = pd.DataFrame([quality])
    oil = quality["oil"]
    finished = {name: tables.empty(name) for name in FIT_TABLES}
    for name, frame in frames.items():
        if len(frame):
            rows = frame.assign(oil=oil, law=quality["law"])
            finished[name] = tables.filled(rows, name, f"fit of {oil}")
    return CampaignTables.in_memory(**finished)


def _coefficients(solution: Solution, settings: FitSettings, fixed_conditions: str) -> pd.DataFrame:
    """One row per constant, in the order of the law."""
    law = solution.problem.law
    at_bounds = solution.problem.at_bounds
    estimated = _estimated(solution, settings.sign_confidence)
    # the level of a condition that did not vary is inside X0, and the row is then that of X
    has_value = set(estimated.index) | set(at_bounds)
    coefficients_at_level = [name for name in law.coefficient_names if name in has_value]
    rows = estimated.reindex(fitted_names(law) + coefficients_at_level)
    rows["identifiable"] = rows.index.isin(estimated.index)
    rows["verdict"] = rows["verdict"].fillna("not identifiable")
    for name, value in at_bounds.items():
        rows.loc[name, ["value", "verdict"]] = value, "at a bound"
    in_step = _exponents_in_step(law, fixed_from_text(fixed_conditions))
    rows.loc[rows.index.isin(in_step) & rows["identifiable"], "verdict"] = "in step"
    return rows.rename_axis("constant").reset_index()


def _exponents_in_step(law: Law, fixed_conditions: Sequence[FixedCondition]) -> list[str]:
    """Names of the exponents that hold along a line of several conditions, not for one alone."""
    on_lines = set()
    for fixed in fixed_conditions:
        for other in fixed.in_step:
            on_lines.add(other.condition)
    if not on_lines:
        return []
    if law.groups == law.conditions:
        groups = on_lines
    else:
        # each group may contain a condition of the line
        groups = set(law.groups)
    return [constant.name for constant in law.constants if constant.condition in groups]


def fitted_names(law: Law) -> list[str]:
    """Names of the constants of a law that are fitted."""
    return [constant.name for constant in law.constants if constant.prescribed is None]


def _estimated(solution: Solution, sign_confidence: float) -> pd.DataFrame:
    """One row per free constant, by its name, with its errors and intervals."""
    estimates = solution.estimates
    # errors from the calibration of the sensors
    systematic = np.sqrt(((estimates.shifted - estimates.values) ** 2).sum(axis=0))
    rows = pd.DataFrame(
        {
            "value": estimates.values,
            "standard_error": np.nan,
            "lower": np.nan,
            "upper": np.nan,
            "naive_standard_error": np.sqrt(np.diag(estimates.naive)),
            "systematic_standard_error": systematic if len(estimates.shifted) else np.nan,
            "verdict": "no interval",
        },
        index=solution.problem.names,
    )
    if len(estimates.refits):
        rows["standard_error"] = [constant.std(ddof=1) for constant in estimates.refits.T]
        low, high = np.quantile(estimates.refits, [0.025, 0.975], axis=0)
        error = np.hypot(rows["standard_error"], rows["systematic_standard_error"].fillna(0.0))
        # A fit gives the signs of all its constants at once. With intervals of 95 % each, one of
        # twelve constants without effect would get a sign in every second fit. Bonferroni's limit
        # is for all of them together.
        half_width = normal_quantile(1 - (1 - sign_confidence) / len(rows)) * error
        # the distribution of the refits may be skew
        rows["lower"] = np.minimum(rows["value"] - half_width, low)
        rows["upper"] = np.maximum(rows["value"] + half_width, high)
        # in an exact fit the sign of a zero is rounding; exponents are of the size of 1
        is_positive = exceeds(rows["lower"], 0.0, size=1.0)
        is_negative = exceeds(0.0, rows["upper"], size=1.0)
        rows["verdict"] = np.where(is_positive | is_negative, "known", "sign unknown")
    return rows


def _quality(solution: Solution) -> dict[str, Any]:
    """Columns of `fit_quality` that come from the solution."""
    problem = solution.problem
    best = solution.best
    residual = problem.residual(best.values)
    rmse = float(np.sqrt(np.mean(residual**2)))
    constants = len(best.values) + len(problem.at_bounds)
    rows, slips = tested_grid(problem)
    at_zero_slip = traction_on(problem, best, rows, slips)[:, 0]
    return {
        "n_constants": constants,
        "sse": best.sse,
        "rmse": rmse,
        "relative_rms": rmse / float(np.sqrt(np.mean(problem.mu**2))),
        "max_error": float(np.abs(residual).max()),
        "bic": bayesian_criterion(best.sse, len(residual), constants),
        "zero_slip_traction": float(at_zero_slip[first_largest(np.abs(at_zero_slip))]),
        "left_out_rmse": float(np.sqrt(np.mean(solution.left_out**2))),
        "refits_at_bounds": solution.refits_at_bounds,
        **solution.certificate,
    }


def bayesian_criterion(sse: float, n_points: int, n_constants: int) -> float:
    """The Bayesian information criterion of a least-squares fit; NaN for an exact one.

        BIC = n ln(SSE/n) + k ln n

    k counts the constants and the variance of the errors. Terms that all laws share are left out.
    The criterion assumes independent points, but points of a run share errors. Differences between
    laws therefore seem more certain than they are.

    Args:
        sse: Sum of squared errors.
        n_points: n.
        n_constants: Constants fitted.

    Reference: K. P. Burnham, D. R. Anderson, Model Selection and Multimodel Inference, 2nd ed.
        (2002), sections 2.2 and 6.4.

    Examples:
        By hand, 100 ln(1e-4/100) = -1381.55, k = 3:

        >>> print(f"{bayesian_criterion(1e-4, 100, 2):.2f}")
        -1367.74
    """
    if sse <= 0:
        return float("nan")
    return float(n_points * np.log(sse / n_points) + (n_constants + 1) * np.log(n_points))


def _refits(solution: Solution) -> pd.DataFrame:
    """Constants of each refit: first those to resampled curves, then those with a sensor off."""
    names = solution.problem.names
    resampled = solution.estimates.refits
    shifted = solution.estimates.shifted
    values = np.vstack([resampled, shifted])
    causes = ["resampled curves"] * len(resampled)
    causes += [f"calibration of {sensor}" for sensor in SENSORS[: len(shifted)]]
    refit_numbers = list(range(len(resampled))) + [0] * len(shifted)
    return pd.DataFrame(
        {
            "cause": np.repeat(causes, len(names)),
            "refit": np.repeat(refit_numbers, len(names)),
            "constant": names * len(values),
            "value": values.ravel(),
        }
    )


def _correlations(solution: Solution) -> pd.DataFrame:
    """Correlation of each pair of constants."""
    names = np.array(solution.problem.names)
    first, second = np.triu_indices(len(names), k=1)
    values = solution.estimates.correlation[first, second]
    return pd.DataFrame({"constant": names[first], "other": names[second], "correlation": values})


def _profiles(solution: Solution) -> pd.DataFrame:
    """Profile of each constant: its values and the signed root of the SSE's rise there."""
    problem = solution.problem
    values, signed_root = solution.profiles
    # a constant below zero falls where its logarithm rises
    direction = np.where(problem.signs < 0, -1, 1)[:, np.newaxis]
    return pd.DataFrame(
        {
            "constant": np.repeat(problem.names, values.shape[1]),
            "value": problem.reported(values.T).T.ravel(),
            "signed_root": (direction * signed_root).ravel(),
        }
    )


def _law_points(solution: Solution, points: pd.DataFrame) -> pd.DataFrame:
    """mu of the law at each accepted point, and by the fit without the point's curve."""
    data = solution.problem.data
    # the order of `curve_data`, whose traction is that of positive slip
    accepted = points[points["accepted"]].sort_values(["run_id", "first_row"])
    accepted = accepted.reset_index(drop=True)
    slip_sign = np.where(accepted["slide_roll_ratio"] < 0, -1.0, 1.0)
    residual = solution.problem.residual(solution.best.values)
    return accepted[["run_id", "first_row", "slide_roll_ratio"]].assign(
        traction_coefficient=slip_sign * (data.mu + residual),
        left_out_traction_coefficient=slip_sign * (data.mu + solution.left_out),
    )


def _curve_residuals(solution: Solution, settings: FitSettings) -> pd.DataFrame:
    """Mean conditions, misfit and agreement of each curve."""
    problem = solution.problem
    data = problem.data
    residual = problem.residual(solution.best.values)
    points_of_curve = np.bincount(data.curve, minlength=problem.curves)
    sse_of_curve = np.bincount(data.curve, residual**2, minlength=problem.curves)
    rows = pd.DataFrame({"run_id": data.runs, "n_points": points_of_curve})
    for name in (*CONDITIONS, "load_n"):
        rows[f"mean_{name}"] = np.nan
    for name, values in zip(problem.law.conditions, data.conditions.T, strict=True):
        rows[f"mean_{name}"] = values
    rows["rmse"] = np.sqrt(sse_of_curve / points_of_curve)
    return rows.assign(**curve_agreement(problem, solution.robust, settings))


# ---------------------------------------------------------------- the certificate


def certify(
    problem: Problem, optima: Sequence[Optimum], naive_errors: FloatArray, settings: FitSettings
) -> dict[str, Any]:
    """Columns of `fit_quality` that show whether the best optimum is certified.

    It is `certified` where all checks hold: the searches agree, the gradient is zero, mu is not
    negative, the Hessian is regular, and no bound is reached.

    Args:
        problem: What was fitted; constants that ran into a bound are held there.
        optima: Optimum of each independent search, in the free constants.
        naive_errors: Naive standard errors of the free constants.
        settings: Limits of config's fit.
    """
    best = min(optima, key=lambda optimum: optimum.sse)
    # the residuals of an exact fit of exact points are rounding, on which searches do not agree
    rounding = _ROUNDING * float(np.sum(problem.mu**2))
    errors = np.maximum(naive_errors, _LEAST_ERROR)
    sse = np.array([optimum.sse for optimum in optima])
    values = np.array([optimum.values for optimum in optima])
    sse_spread = (sse - best.sse) / max(best.sse, rounding)
    constant_spread = np.max(np.abs(values - best.values) / errors, axis=1)
    agrees_in_sse = sse_spread <= settings.agreement_sse
    agrees_in_constants = constant_spread <= settings.agreement_constants
    rows, slips = tested_grid(problem)
    mu = traction_on(problem, best, rows, slips)
    hessian_smallest, hessian_largest, condition_number = spectrum(problem, best)
    numbers = {
        "searches": len(optima),
        "searches_agreeing": int(np.sum(agrees_in_sse & agrees_in_constants)),
        "sse_spread": float(sse_spread.max()),
        "constant_spread": float(constant_spread.max()),
        "gradient_cosine": gradient_cosine(problem, best) if best.sse > rounding else 0.0,
        "min_traction": float(mu.min()),
        "condition_number": condition_number,
        "hessian_smallest": hessian_smallest,
        "hessian_largest": hessian_largest,
        "active_bounds": tuple(problem.at_bounds),
    }
    doubts = _doubts(numbers, float(np.abs(mu).max()), settings)
    return {**numbers, "certified": not doubts, "doubts": tuple(doubts)}


def _doubts(numbers: Mapping[str, Any], largest: float, settings: FitSettings) -> list[str]:
    """Codes of the checks of a certificate that fail.

    Args:
        numbers: Columns of `fit_quality`.
        largest: Largest |mu| over the tested box.
        settings: Limits of config's fit.
    """
    is_singular = np.isnan(numbers["condition_number"])
    fails = {
        "searches disagree": numbers["searches_agreeing"] != numbers["searches"],
        "errors differ": not numbers["sse_spread"] <= settings.agreement_sse,
        "constants differ": not numbers["constant_spread"] <= settings.agreement_constants,
        "gradient": not numbers["gradient_cosine"] <= settings.gradient_cosine_max,
        "negative traction": not reaches(numbers["min_traction"], 0.0, size=largest),
        "flat": is_singular or not numbers["hessian_smallest"] > 0,
        "at bounds": len(numbers["active_bounds"]) > 0,
    }
    return [doubt for doubt, is_failing in fails.items() if is_failing]


def gradient_cosine(problem: Problem, optimum: Optimum) -> float:
    """Largest |cos| of the angle between the residual and a column of the Jacobian.

    It is zero at a stationary point, for every scale of data and constants (the orthogonality test
    of MINPACK's lmder).
    """
    residual = problem.residual(optimum.values)
    jacobian = problem.jacobian(optimum.values)
    lengths = np.linalg.norm(residual) * np.linalg.norm(jacobian, axis=0)
    cosines = np.abs(residual @ jacobian) / np.where(lengths > 0, lengths, 1.0)
    return float(np.max(cosines))


def spectrum(problem: Problem, optimum: Optimum) -> tuple[float, float, float]:
    """Smallest and largest eigenvalue of the Hessian J^T J, and the condition number of J.

    The Hessian is that of half the SSE by the free internal constants. The condition number is that
    of J with columns of length 1, so that it does not depend on units. It is NaN where J is
    singular to rounding.
    """
    jacobian = problem.jacobian(optimum.values)
    lengths = np.linalg.norm(jacobian, axis=0)
    unit_columns = jacobian / np.where(lengths > 0, lengths, 1.0)
    singular_values = np.linalg.svd(jacobian, compute_uv=False)
    scaled_values = np.linalg.svd(unit_columns, compute_uv=False)
    rounding = scaled_values[0] * max(jacobian.shape) * np.finfo(float).eps
    is_singular = scaled_values[-1] <= rounding
    condition_number = float("nan") if is_singular else float(scaled_values[0] / scaled_values[-1])
    return float(singular_values[-1] ** 2), float(singular_values[0] ** 2), condition_number


def tested_grid(problem: Problem) -> tuple[FloatArray, FloatArray]:
    """Rows of the design over the box of tested conditions, and slips from 0 to the largest."""
    data = problem.data
    low = data.conditions.min(axis=0)
    high = data.conditions.max(axis=0)
    mesh = np.meshgrid(*np.linspace(low, high, _GRID_LEVELS, axis=1), indexing="ij")
    conditions = np.stack(mesh, axis=-1).reshape(-1, len(low))
    rows = np.unique(problem.law.design(conditions, problem.followed), axis=0)
    largest_slip = float(np.max(np.abs(data.slip)))
    return rows, np.linspace(0, largest_slip, _GRID_SLIPS)


def traction_on(
    problem: Problem, optimum: Optimum, rows: FloatArray, slips: FloatArray
) -> FloatArray:
    """mu at each row of the design and each slip: shape (rows, slips)."""
    row_of_point = np.repeat(np.arange(len(rows)), len(slips))
    slip_of_point = np.tile(slips, len(rows))
    observations = Observations(rows, row_of_point, slip_of_point)
    mu = problem.law.traction(problem.expand(optimum.values), observations)
    return mu.reshape(len(rows), len(slips))
