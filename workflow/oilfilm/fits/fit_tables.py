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
from oilfilm.fits.conditions import FixedCondition, fixed_conditions_from_json
from oilfilm.fits.global_search import Optimum
from oilfilm.fits.problem import Problem
from oilfilm.fits.robust_fit import RobustFit, curve_agreement
from oilfilm.fits.uncertainty import SENSORS, Estimates, Profiles
from oilfilm.settings.config import FitSettings
from oilfilm.surface.interval import normal_half_width
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.table_needs import FIT_TABLES
from oilfilm.traction.law import CONDITIONS, Law, Observations

# Residuals of an exact fit are rounding: their SSE over the sum of mu^2 is below this.
_ROUNDING_SSE = 1e-20
# A standard error is not below this where constants are compared in standard errors.
_LEAST_ERROR = 1e-9
# Number of levels of each condition, and number of slips, at which mu is evaluated over the tested
# box.
_GRID_LEVELS = 9
_GRID_SLIPS = 61


@dataclass(frozen=True)
class Solution:
    """One law fitted to one oil.

    Attributes:
        problem: What was fitted; constants that ran into a bound are held there.
        optimum: The optimum with the smallest SSE.
        certificate: Columns of `fit_quality`, as `certificate_columns` returns them.
        estimates: The free constants in the form of the law's equation, with their errors.
        profiles: Profile of each free constant.
        robust_fit: The fit with a robust loss; None where the SSE is 0.
        left_out_errors: Fitted minus measured mu of each point, by a fit without the point's curve,
            shape (points,); NaN where there is no such fit.
        refits_at_bounds_count: Number of refits in which a constant ended at a bound. They are not
            among the refits of `estimates`.
    """

    problem: Problem
    optimum: Optimum
    certificate: Mapping[str, Any]
    estimates: Estimates
    profiles: Profiles
    robust_fit: RobustFit | None
    left_out_errors: FloatArray
    refits_at_bounds_count: int


def tables_of_fit(
    solution: Solution, points: pd.DataFrame, quality_row: Mapping[str, Any], settings: FitSettings
) -> CampaignTables:
    """The tables of a fit.

    Args:
        solution: The fit.
        points: The oil's rows of the table of points, without those of incomplete curves.
        quality_row: Oil, law, counts and tested box: the first columns of the row of `fit_quality`.
        settings: Limits of config's fit for signs, and for curves that pull or are odd.
    """
    return _with_oil_and_law(
        {**quality_row, **_quality_columns(solution)},
        coefficients=_coefficient_rows(solution, settings, quality_row["fixed_conditions"]),
        refits=_refit_rows(solution),
        correlations=_correlation_rows(solution),
        profiles=_profile_rows(solution),
        curve_residuals=_curve_residual_rows(solution, settings),
        law_points=_law_point_rows(solution, points),
    )


def tables_without_fit(
    constant_names: Sequence[str], quality_row: Mapping[str, Any]
) -> CampaignTables:
    """The tables of data that cannot be fitted: no values, and the reason.

    Args:
        constant_names: Names of the constants that the law would have fitted.
        quality_row: As in `tables_of_fit`, with the reason as `no_fit`.
    """
    rows = pd.DataFrame({"constant": constant_names}).assign(verdict="not identifiable")
    return _with_oil_and_law(quality_row, coefficients=rows)


def _with_oil_and_law(quality_row: Mapping[str, Any], **frames: pd.DataFrame) -> CampaignTables:
    """The tables of a fit, with oil and law in every row; tables without rows are empty.

    Args:
        quality_row: The row of `fit_quality`.
        frames: The other tables by name.
    """
    frames["fit_quality"] = pd.DataFrame([quality_row])
    oil = quality_row["oil"]
    finished = {name: tables.empty_table(name) for name in FIT_TABLES}
    for name, frame in frames.items():
        if len(frame):
            rows = frame.assign(oil=oil, law=quality_row["law"])
            finished[name] = tables.filled_table(rows, name, f"fit of {oil}")
    return CampaignTables.from_frames(**finished)


def _coefficient_rows(
    solution: Solution, settings: FitSettings, fixed_conditions: str
) -> pd.DataFrame:
    """One row per constant, in the order of the law."""
    law = solution.problem.law
    values_at_bounds = solution.problem.values_at_bounds
    estimate_rows = _estimate_rows(solution, settings.sign_confidence)
    # the level of a condition that did not vary is inside X0, and the row is then that of X
    has_value = set(estimate_rows.index) | set(values_at_bounds)
    coefficients_at_level = [
        constant_name for constant_name in law.coefficient_names if constant_name in has_value
    ]
    rows = estimate_rows.reindex(fitted_constant_names(law) + coefficients_at_level)
    rows["identifiable"] = rows.index.isin(estimate_rows.index)
    rows["verdict"] = rows["verdict"].fillna("not identifiable")
    for constant_name, value in values_at_bounds.items():
        rows.loc[constant_name, ["value", "verdict"]] = value, "at a bound"
    names_in_step = _exponents_in_step(law, fixed_conditions_from_json(fixed_conditions))
    rows.loc[rows.index.isin(names_in_step) & rows["identifiable"], "verdict"] = "in step"
    return rows.rename_axis("constant").reset_index()


def _exponents_in_step(law: Law, fixed_conditions: Sequence[FixedCondition]) -> list[str]:
    """Names of the exponents that hold along a line of conditions in step, not for one alone."""
    on_lines = set()
    for fixed in fixed_conditions:
        for partner in fixed.in_step:
            on_lines.add(partner.condition)
    is_line_unknown = any(fixed.line_reaches_zero for fixed in fixed_conditions)
    if not on_lines and not is_line_unknown:
        return []
    if law.groups == law.conditions and not is_line_unknown:
        groups_on_lines = on_lines
    else:
        # each group may contain a condition of the line, or be one of an unknown line
        groups_on_lines = set(law.groups)
    return [constant.name for constant in law.constants if constant.group in groups_on_lines]


def fitted_constant_names(law: Law) -> list[str]:
    """Names of the constants of a law that are not prescribed."""
    return [constant.name for constant in law.constants if constant.prescribed is None]


def _estimate_rows(solution: Solution, sign_confidence: float) -> pd.DataFrame:
    """One row per free constant, by its name, with its errors and intervals."""
    estimates = solution.estimates
    # errors from the calibration of the sensors
    systematic = np.sqrt(((estimates.shifted_refits - estimates.values) ** 2).sum(axis=0))
    rows = pd.DataFrame(
        {
            "value": estimates.values,
            "standard_error": np.nan,
            "lower": np.nan,
            "upper": np.nan,
            "naive_standard_error": np.sqrt(np.diag(estimates.naive_covariance)),
            "systematic_standard_error": systematic if len(estimates.shifted_refits) else np.nan,
            "verdict": "no interval",
        },
        index=solution.problem.free_names,
    )
    # one refit has no spread
    if len(estimates.refits) > 1:
        rows["standard_error"] = [
            refitted_values.std(ddof=1) for refitted_values in estimates.refits.T
        ]
        lower_quantile, upper_quantile = np.quantile(estimates.refits, [0.025, 0.975], axis=0)
        error = np.hypot(rows["standard_error"], rows["systematic_standard_error"].fillna(0.0))
        # A fit gives the signs of all its constants at once. With intervals of 95 % each, one of
        # twelve constants without effect would get a sign in every second fit. Bonferroni's limit
        # is for all of them together.
        half_width = normal_half_width(1 - (1 - sign_confidence) / len(rows)) * error
        # the distribution of the refits may be skew
        rows["lower"] = np.minimum(rows["value"] - half_width, lower_quantile)
        rows["upper"] = np.maximum(rows["value"] + half_width, upper_quantile)
        # in an exact fit the sign of a zero is rounding; exponents are of the size of 1
        is_positive = exceeds(rows["lower"], 0.0, term_size=1.0)
        is_negative = exceeds(0.0, rows["upper"], term_size=1.0)
        rows["verdict"] = np.where(is_positive | is_negative, "known", "sign unknown")
    return rows


def _quality_columns(solution: Solution) -> dict[str, Any]:
    """Columns of `fit_quality` that come from the solution."""
    problem = solution.problem
    optimum = solution.optimum
    residual = problem.residual(optimum.constants)
    rmse = float(np.sqrt(np.mean(residual**2)))
    constant_count = len(optimum.constants) + len(problem.values_at_bounds)
    design_rows, slips = tested_grid(problem)
    mu_at_zero_slip = traction_on_grid(problem, optimum, design_rows, slips)[:, 0]
    return {
        "n_constants": constant_count,
        "sse": optimum.sse,
        "rmse": rmse,
        "relative_rms": rmse / float(np.sqrt(np.mean(problem.mu**2))),
        "max_error": float(np.abs(residual).max()),
        "bic": bayesian_criterion(optimum.sse, len(residual), constant_count),
        "zero_slip_traction": float(mu_at_zero_slip[first_largest(np.abs(mu_at_zero_slip))]),
        "left_out_rmse": float(np.sqrt(np.mean(solution.left_out_errors**2))),
        "refits_at_bounds": solution.refits_at_bounds_count,
        **solution.certificate,
    }


def bayesian_criterion(sse: float, n_points: int, n_constants: int) -> float:
    """The Bayesian information criterion of a least-squares fit; NaN where the SSE is 0.

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


def _refit_rows(solution: Solution) -> pd.DataFrame:
    """Rows of the table `refits`: refits to resampled curves, then those with a sensor off."""
    constant_names = solution.problem.free_names
    resampled = solution.estimates.refits
    shifted = solution.estimates.shifted_refits
    values = np.vstack([resampled, shifted])
    causes = ["resampled curves"] * len(resampled)
    causes += [f"calibration of {sensor}" for sensor in SENSORS[: len(shifted)]]
    refit_numbers = list(range(len(resampled))) + [0] * len(shifted)
    return pd.DataFrame(
        {
            "cause": np.repeat(causes, len(constant_names)),
            "refit": np.repeat(refit_numbers, len(constant_names)),
            "constant": constant_names * len(values),
            "value": values.ravel(),
        }
    )


def _correlation_rows(solution: Solution) -> pd.DataFrame:
    """Rows of the table `correlations`: the correlation of each pair of constants."""
    constant_names = np.array(solution.problem.free_names)
    first_index, second_index = np.triu_indices(len(constant_names), k=1)
    values = solution.estimates.correlation[first_index, second_index]
    return pd.DataFrame(
        {
            "constant": constant_names[first_index],
            "other": constant_names[second_index],
            "correlation": values,
        }
    )


def _profile_rows(solution: Solution) -> pd.DataFrame:
    """Rows of the table `profiles`: values of each constant, and the root of the SSE's rise."""
    problem = solution.problem
    held_values, signed_root = solution.profiles
    # a constant below zero falls where its logarithm rises
    direction = np.where(problem.signs < 0, -1, 1)[:, np.newaxis]
    return pd.DataFrame(
        {
            "constant": np.repeat(problem.free_names, held_values.shape[1]),
            "value": problem.in_equation_form(held_values.T).T.ravel(),
            "signed_root": (direction * signed_root).ravel(),
        }
    )


def _law_point_rows(solution: Solution, points: pd.DataFrame) -> pd.DataFrame:
    """Rows of the table `law_points`: mu of the law, also by the fit without the point's curve."""
    data = solution.problem.data
    # the order of `curve_data`, whose traction is that of positive slip
    accepted = points[points["accepted"]].sort_values(["run_id", "first_row"])
    accepted = accepted.reset_index(drop=True)
    slip_sign = np.where(accepted["slide_roll_ratio"] < 0, -1.0, 1.0)
    residual = solution.problem.residual(solution.optimum.constants)
    return accepted[["run_id", "first_row", "slide_roll_ratio"]].assign(
        traction_coefficient=slip_sign * (data.mu + residual),
        left_out_traction_coefficient=slip_sign * (data.mu + solution.left_out_errors),
    )


def _curve_residual_rows(solution: Solution, settings: FitSettings) -> pd.DataFrame:
    """Rows of the table `curve_residuals`: mean conditions, misfit and agreement of each curve."""
    problem = solution.problem
    data = problem.data
    residual = problem.residual(solution.optimum.constants)
    points_of_curve = np.bincount(data.curve_of_point, minlength=problem.curve_count)
    sse_of_curve = np.bincount(data.curve_of_point, residual**2, minlength=problem.curve_count)
    rows = pd.DataFrame({"run_id": data.run_ids, "n_points": points_of_curve})
    for name in (*CONDITIONS, "load_n"):
        rows[f"mean_{name}"] = np.nan
    for name, values in zip(problem.law.conditions, data.conditions.T, strict=True):
        rows[f"mean_{name}"] = values
    rows["rmse"] = np.sqrt(sse_of_curve / points_of_curve)
    return rows.assign(**curve_agreement(problem, solution.robust_fit, settings))


# ---------------------------------------------------------------- the certificate


def certificate_columns(
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
    best_optimum = min(optima, key=lambda optimum: optimum.sse)
    # the residuals of an exact fit of exact points are rounding, on which searches do not agree
    rounding = _ROUNDING_SSE * float(np.sum(problem.mu**2))
    constant_errors = np.maximum(naive_errors, _LEAST_ERROR)
    sse = np.array([optimum.sse for optimum in optima])
    constants = np.array([optimum.constants for optimum in optima])
    sse_spread = (sse - best_optimum.sse) / max(best_optimum.sse, rounding)
    constant_spread = np.max(np.abs(constants - best_optimum.constants) / constant_errors, axis=1)
    agrees_in_sse = sse_spread <= settings.agreement_sse
    # where standard errors are not known (NaN), the SSE alone says whether searches agree
    agrees_in_constants = ~(constant_spread > settings.agreement_constants)
    design_rows, slips = tested_grid(problem)
    mu = traction_on_grid(problem, best_optimum, design_rows, slips)
    hessian_smallest, hessian_largest, condition_number = hessian_spectrum(problem, best_optimum)
    columns = {
        "searches": len(optima),
        "searches_agreeing": int(np.sum(agrees_in_sse & agrees_in_constants)),
        "sse_spread": float(sse_spread.max()),
        "constant_spread": float(constant_spread.max()),
        "gradient_cosine": gradient_cosine(problem, best_optimum)
        if best_optimum.sse > rounding
        else 0.0,
        "min_traction": float(mu.min()),
        "condition_number": condition_number,
        "hessian_smallest": hessian_smallest,
        "hessian_largest": hessian_largest,
        "active_bounds": tuple(problem.values_at_bounds),
    }
    doubts = _doubt_codes(columns, float(np.abs(mu).max()), settings)
    return {**columns, "certified": not doubts, "doubts": tuple(doubts)}


def _doubt_codes(columns: Mapping[str, Any], largest_mu: float, settings: FitSettings) -> list[str]:
    """Codes of the checks of a certificate that fail.

    Args:
        columns: Columns of `fit_quality`, as `certificate_columns` computes them.
        largest_mu: Largest |mu| over the tested box.
        settings: Limits of config's fit.
    """
    # without standard errors the data leave a direction of the constants open
    is_singular = np.isnan(columns["condition_number"]) or np.isnan(columns["constant_spread"])
    fails_by_doubt = {
        "searches disagree": columns["searches_agreeing"] != columns["searches"],
        "errors differ": not columns["sse_spread"] <= settings.agreement_sse,
        "constants differ": columns["constant_spread"] > settings.agreement_constants,
        "gradient": not columns["gradient_cosine"] <= settings.gradient_cosine_max,
        "negative traction": not reaches(columns["min_traction"], 0.0, term_size=largest_mu),
        "flat": is_singular or not columns["hessian_smallest"] > 0,
        "at bounds": len(columns["active_bounds"]) > 0,
    }
    return [doubt for doubt, is_failing in fails_by_doubt.items() if is_failing]


def gradient_cosine(problem: Problem, optimum: Optimum) -> float:
    """Largest |cos| of the angle between the residual and a column of the Jacobian.

    It is zero at a stationary point, for every scale of data and constants (the orthogonality test
    of MINPACK's lmder).
    """
    residual = problem.residual(optimum.constants)
    jacobian = problem.jacobian(optimum.constants)
    lengths = np.linalg.norm(residual) * np.linalg.norm(jacobian, axis=0)
    cosines = np.abs(residual @ jacobian) / np.where(lengths > 0, lengths, 1.0)
    return float(np.max(cosines))


def hessian_spectrum(problem: Problem, optimum: Optimum) -> tuple[float, float, float]:
    """Smallest and largest eigenvalue of J^T J, and the condition number of J.

    J^T J is the Gauss-Newton part of the Hessian of half the SSE by the free internal constants: it
    is never negative, and 0 in a direction that the data leave open. The condition number is that
    of J with columns of length 1, so that it does not depend on units. It is NaN where J is
    singular to rounding.
    """
    jacobian = problem.jacobian(optimum.constants)
    lengths = np.linalg.norm(jacobian, axis=0)
    unit_columns = jacobian / np.where(lengths > 0, lengths, 1.0)
    singular_values = np.linalg.svd(jacobian, compute_uv=False)
    scaled_values = np.linalg.svd(unit_columns, compute_uv=False)
    rounding = scaled_values[0] * max(jacobian.shape) * np.finfo(float).eps
    is_singular = scaled_values[-1] <= rounding
    condition_number = float("nan") if is_singular else float(scaled_values[0] / scaled_values[-1])
    return float(singular_values[-1] ** 2), float(singular_values[0] ** 2), condition_number


def tested_grid(problem: Problem) -> tuple[FloatArray, FloatArray]:
    """Rows of the design on a grid over the tested conditions, and slips from 0 to the largest one.

    Returns:
        Shapes (rows, terms) and (slips,).
    """
    data = problem.data
    lowest = data.conditions.min(axis=0)
    highest = data.conditions.max(axis=0)
    mesh = np.meshgrid(*np.linspace(lowest, highest, _GRID_LEVELS, axis=1), indexing="ij")
    conditions = np.stack(mesh, axis=-1).reshape(-1, len(lowest))
    design_rows = np.unique(problem.law.design(conditions, problem.group_has_exponent), axis=0)
    largest_slip = float(np.max(np.abs(data.slip)))
    return design_rows, np.linspace(0, largest_slip, _GRID_SLIPS)


def traction_on_grid(
    problem: Problem, optimum: Optimum, design_rows: FloatArray, slips: FloatArray
) -> FloatArray:
    """mu at each row of the design and each slip, shape (rows, slips).

    Args:
        problem: What was fitted.
        optimum: The free constants.
        design_rows: Rows of the design, shape (rows, terms).
        slips: Slide-roll ratios, shape (slips,).
    """
    row_of_point = np.repeat(np.arange(len(design_rows)), len(slips))
    slip_of_point = np.tile(slips, len(design_rows))
    observations = Observations(design_rows, row_of_point, slip_of_point)
    mu = problem.law.traction(problem.expand(optimum.constants), observations)
    return mu.reshape(len(design_rows), len(slips))
