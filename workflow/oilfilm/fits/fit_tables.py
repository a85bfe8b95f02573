"""The tables of one fit: constants, quality, refits, correlations, profiles, residuals by curve.

With the proof that a fit is the best one: independent searches agree at a flat, physical spot.

Decides: when a fit is certified.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.base.ties import exceeds, first_largest, reaches
from oilfilm.base.units import FloatArray
from oilfilm.fits.conditions import from_text
from oilfilm.fits.engine import Optimum
from oilfilm.fits.interval import Unseen, normal_quantile
from oilfilm.fits.objectives import Robust, curve_agreement
from oilfilm.fits.problem import Problem
from oilfilm.fits.uncertainty import SENSORS, Estimates
from oilfilm.settings.config import FitSettings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.table_needs import OF_FIT
from oilfilm.traction.law import CONDITIONS, Law, Observations


@dataclass(frozen=True)
class Solution:
    """One law fitted to one oil.

    Attributes:
        problem: What was fitted; constants that ran into a bound are held there.
        best: The best end of the searches.
        certificate: Whether the searches agree, and at what kind of optimum.
        estimates: The free constants in the form of the law's equation, with their errors.
        profile: As `profiles`.
        robust: The fit with a robust loss; None for an exact fit.
        left_out: Error of each point's mu by a fit that has not seen its curve, NaN where there is
            none.
        unseen: What these errors say of a further run.
        refits_at_bounds: Refits of which a constant ended at a bound; they are not among the
            estimates' refits.
    """

    problem: Problem
    best: Optimum
    certificate: Mapping[str, Any]
    estimates: Estimates
    profile: tuple[FloatArray, FloatArray]
    robust: Robust | None
    left_out: FloatArray
    unseen: Unseen
    refits_at_bounds: int


def tables_of_fit(
    solution: Solution, points: pd.DataFrame, quality: Mapping[str, Any], settings: FitSettings
) -> CampaignTables:
    """The tables of a fit.

    Args:
        solution: The fit.
        points: The oil's rows of the table of points, without those of incomplete curves.
        quality: Oil, law, counts and tested box: the row of `fit_quality` so far.
        settings: `sign_confidence` and `pulling_weight` of config's fit.
    """
    return _of_fit(
        {**quality, **_quality(solution)},
        coefficients=_coefficients(solution, settings, quality["fixed_conditions"]),
        refits=_refits(solution),
        correlations=_correlations(solution),
        profiles=_profiles(solution),
        curve_residuals=_curve_residuals(solution, settings),
        law_points=_law_points(solution, points),
    )


def tables_without_fit(constants: Sequence[str], quality: Mapping[str, Any]) -> CampaignTables:
    """The same of data that could not be fitted: no values, and the reason.

    Args:
        constants: Names of the constants that were to be fitted.
        quality: As of `tables_of_fit`, with the reason as `no_fit`.
    """
    rows = pd.DataFrame({"constant": constants}).assign(verdict="not identifiable")
    return _of_fit(quality, coefficients=rows)


def _of_fit(quality: Mapping[str, Any], **frames: pd.DataFrame) -> CampaignTables:
    """Each table with oil and law in every row."""
    frames["fit_quality"] = pd.DataFrame([quality])
    of = {name: quality[name] for name in ("oil", "law")}
    made = {name: tables.empty(name) for name in OF_FIT} | {
        name: tables.filled(frame.assign(**of), name, f"fit of {of['oil']}")
        for name, frame in frames.items()
        if len(frame)
    }
    return CampaignTables.in_memory(**made)


def _coefficients(solution: Solution, settings: FitSettings, fixed_conditions: str) -> pd.DataFrame:
    """One row per constant, in the order of the law."""
    law, at_bounds = solution.problem.law, solution.problem.at_bounds
    estimated = _estimated(solution, settings.sign_confidence)
    # the level of a condition that did not vary is inside X0: neither can be told apart
    local = [name for name in law.local_constants if name in {*estimated.index, *at_bounds}]
    rows = estimated.reindex([*fitted_names(law), *local])
    rows["identifiable"] = rows.index.isin(estimated.index)
    rows["verdict"] = rows["verdict"].fillna("not identifiable")
    for name, value in at_bounds.items():
        rows.loc[name, ["value", "verdict"]] = value, "at a bound"
    along = {other.condition for each in from_text(fixed_conditions) for other in each.in_step}
    # every group that a law makes of conditions may hold one of them
    groups = along if law.groups == law.conditions else set(law.groups if along else ())
    # an exponent along a line is one of no condition alone
    in_step = [each.name for each in law.constants if each.condition in groups]
    rows.loc[rows.index.isin(in_step) & rows["identifiable"], "verdict"] = "in step"
    return rows.rename_axis("constant").reset_index()


def fitted_names(law: Law) -> list[str]:
    """Names of the constants of a law that are fitted."""
    return [constant.name for constant in law.constants if constant.known is None]


def _estimated(solution: Solution, sign_confidence: float) -> pd.DataFrame:
    """One row per free constant, by its name, with its errors and intervals."""
    estimates, values = solution.estimates, solution.estimates.values
    systematic = np.sqrt(((estimates.shifted - values) ** 2).sum(axis=0))
    rows = pd.DataFrame(
        {
            "value": values,
            **dict.fromkeys(("standard_error", "lower", "upper"), np.nan),
            "naive_standard_error": np.sqrt(np.diag(estimates.naive)),
            # from calibration
            "systematic_standard_error": systematic if len(estimates.shifted) else np.nan,
            "verdict": "no interval",
        },
        index=solution.problem.names,
    )
    if len(estimates.refits):
        rows["standard_error"] = [constant.std(ddof=1) for constant in estimates.refits.T]
        low, high = np.quantile(estimates.refits, [0.025, 0.975], axis=0)
        error = np.hypot(rows["standard_error"], rows["systematic_standard_error"].fillna(0.0))
        # A fit calls the signs of all its constants at once: by an interval of 95 % each, of twelve
        # constants without effect one would be called wrongly every second time. Hence
        # Bonferroni's limit, for all of them together.
        reach = normal_quantile(1 - (1 - sign_confidence) / len(rows)) * error
        # the refits may be skew
        rows["lower"] = np.minimum(rows["value"] - reach, low)
        rows["upper"] = np.maximum(rows["value"] + reach, high)
        # the signs of an exact fit's zeros are those of rounding; exponents are of the size of 1
        known = exceeds(rows["lower"], 0.0, size=1.0) | exceeds(0.0, rows["upper"], size=1.0)
        rows["verdict"] = np.where(known, "known", "sign unknown")
    return rows


def _quality(solution: Solution) -> dict[str, Any]:
    problem, best = solution.problem, solution.best
    residual = problem.residual(best.values)
    rmse = float(np.sqrt(np.mean(residual**2)))
    constants = len(best.values) + len(problem.at_bounds)
    starts = traction_on(problem, best, *tested_grid(problem))[:, 0]
    return {
        "n_constants": constants,
        "sse": best.sse,
        "rmse": rmse,
        "relative_rms": rmse / float(np.sqrt(np.mean(problem.mu**2))),
        "max_error": float(np.abs(residual).max()),
        "bic": bayesian_criterion(best.sse, len(residual), constants),
        "zero_slip_traction": float(starts[first_largest(np.abs(starts))]),
        "left_out_rmse": float(np.sqrt(np.mean(solution.left_out**2))),
        "refits_at_bounds": solution.refits_at_bounds,
        **solution.unseen.columns(),
        **solution.certificate,
    }


def bayesian_criterion(sse: float, n_points: int, n_constants: int) -> float:
    """The Bayesian information criterion of a least-squares fit; NaN for an exact one.

        BIC = n ln(SSE/n) + k ln n

    k counts the constants and the variance of the errors; terms that all laws share are left out.
    It takes every point for independent, which points of a run are not: differences between laws
    look surer than they are.

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
    names, estimates = solution.problem.names, solution.estimates
    spread, shifted = estimates.refits, estimates.shifted
    values = np.vstack([spread, shifted])
    calibration = [f"calibration of {sensor}" for sensor in SENSORS[: len(shifted)]]
    causes = ["resampled curves"] * len(spread) + calibration
    numbers = [*range(len(spread)), *[0] * len(shifted)]
    return pd.DataFrame(
        {
            "cause": np.repeat(causes, len(names)),
            "refit": np.repeat(numbers, len(names)),
            "constant": names * len(values),
            "value": values.ravel(),
        }
    )


def _correlations(solution: Solution) -> pd.DataFrame:
    first, second = np.triu_indices(len(solution.problem.names), k=1)
    names = np.array(solution.problem.names)
    values = solution.estimates.correlation[first, second]
    return pd.DataFrame({"constant": names[first], "other": names[second], "correlation": values})


def _profiles(solution: Solution) -> pd.DataFrame:
    problem = solution.problem
    levels, z = solution.profile
    # a constant below zero falls where its logarithm rises
    turned = np.where(problem.signs < 0, -1, 1)[:, np.newaxis]
    return pd.DataFrame(
        {
            "constant": np.repeat(problem.names, levels.shape[1]),
            "value": problem.reported(levels.T).T.ravel(),
            "signed_root": (turned * z).ravel(),
        }
    )


def _law_points(solution: Solution, points: pd.DataFrame) -> pd.DataFrame:
    data = solution.problem.data
    # the order of `curve_data`, whose traction is that of positive slip
    at = points[points["accepted"]].sort_values(["run_id", "first_row"]).reset_index(drop=True)
    side = np.where(at["slide_roll_ratio"] < 0, -1.0, 1.0)
    residual = solution.problem.residual(solution.best.values)
    return at[["run_id", "first_row", "slide_roll_ratio"]].assign(
        traction_coefficient=side * (data.mu + residual),
        left_out_traction_coefficient=side * (data.mu + solution.left_out),
    )


def _curve_residuals(solution: Solution, settings: FitSettings) -> pd.DataFrame:
    problem, data = solution.problem, solution.problem.data
    residual = problem.residual(solution.best.values)
    counts = np.bincount(problem.at.curve, minlength=problem.curves)
    squares = np.bincount(problem.at.curve, residual**2, minlength=problem.curves)
    levels = {f"mean_{name}": np.nan for name in (*CONDITIONS, "load_n")}
    known = [f"mean_{name}" for name in problem.law.conditions]
    levels |= dict(zip(known, data.conditions.T, strict=True))
    return pd.DataFrame(
        {
            "run_id": data.runs,
            "n_points": counts,
            **levels,
            "rmse": np.sqrt(squares / counts),
            **curve_agreement(problem, solution.robust, settings),
        }
    )


# ---------------------------------------------------------------- the certificate


def certify(
    problem: Problem, optima: Sequence[Optimum], naive_errors: FloatArray, settings: FitSettings
) -> dict[str, Any]:
    """What the searches and the optimum say, as columns of `fit_quality`.

    The best optimum is `certified` where all of it holds.

    Args:
        problem: What was fitted; constants that ran into a bound are held there.
        optima: End of each independent search, in the free constants.
        naive_errors: Naive standard errors of the free constants.
        settings: Limits of config's fit.
    """
    best = min(optima, key=lambda optimum: optimum.sse)
    # an exact fit of exact points leaves rounding only, which agrees with nothing
    rounding = 1e-20 * float(np.sum(problem.mu**2))
    errors = np.maximum(naive_errors, 1e-9)
    spreads = np.array([(each.sse - best.sse) / max(best.sse, rounding) for each in optima])
    distances = np.array([np.max(np.abs(each.values - best.values) / errors) for each in optima])
    spread, distance = float(spreads.max()), float(distances.max())
    near = (spreads <= settings.agreement_sse) & (distances <= settings.agreement_constants)
    agreeing = int(near.sum())
    cosine = gradient_cosine(problem, best) if best.sse > rounding else 0.0
    mu = traction_on(problem, best, *tested_grid(problem))
    smallest, largest = float(mu.min()), float(np.abs(mu).max())
    low, high, condition = spectrum(problem, best)
    numbers = {
        "searches": len(optima),
        "searches_agreeing": agreeing,
        "sse_spread": spread,
        "constant_spread": distance,
        "gradient_cosine": cosine,
        "min_traction": smallest,
        "condition_number": condition,
        "hessian_smallest": low,
        "hessian_largest": high,
        "active_bounds": tuple(problem.at_bounds),
    }
    doubts = _doubts(numbers, largest, settings)
    return {**numbers, "certified": not doubts, "doubts": tuple(doubts)}


def _doubts(numbers: Mapping[str, Any], largest: float, settings: FitSettings) -> list[str]:
    """The parts of a certificate that do not hold.

    Args:
        numbers: Columns of `fit_quality`.
        largest: Largest mu over the tested box.
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

    It is zero at a stationary point whatever the scale of data and constants (the orthogonality
    test of MINPACK's lmder).
    """
    residual, jacobian = problem.residual(optimum.values), problem.jacobian(optimum.values)
    length = np.linalg.norm(residual) * np.linalg.norm(jacobian, axis=0)
    return float(np.max(np.abs(residual @ jacobian) / np.where(length > 0, length, 1.0)))


def spectrum(problem: Problem, optimum: Optimum) -> tuple[float, float, float]:
    """Smallest and largest eigenvalue of the Hessian J^T J, and the condition number of J.

    The eigenvalues are those of half the SSE by the free internal constants; the condition number
    is that of J with columns of length 1, which no choice of units changes. It is NaN where J is
    singular to rounding.
    """
    jacobian = problem.jacobian(optimum.values)
    length = np.linalg.norm(jacobian, axis=0)
    sizes = np.linalg.svd(jacobian, compute_uv=False)
    scaled = np.linalg.svd(jacobian / np.where(length > 0, length, 1.0), compute_uv=False)
    singular = scaled[-1] <= scaled[0] * max(jacobian.shape) * np.finfo(float).eps
    condition = float("nan") if singular else float(scaled[0] / scaled[-1])
    return float(sizes[-1] ** 2), float(sizes[0] ** 2), condition


def tested_grid(problem: Problem) -> tuple[FloatArray, FloatArray]:
    """Rows of the design over the box of tested conditions, and slips from 0 to the largest."""
    data = problem.data
    low, high = data.conditions.min(axis=0), data.conditions.max(axis=0)
    levels = np.meshgrid(*np.linspace(low, high, 9, axis=1), indexing="ij")
    conditions = np.stack(levels, axis=-1).reshape(-1, len(low))
    rows = np.unique(problem.law.design(conditions, problem.followed), axis=0)
    return rows, np.linspace(0, float(np.max(np.abs(data.slip))), 61)


def traction_on(
    problem: Problem, optimum: Optimum, rows: FloatArray, slips: FloatArray
) -> FloatArray:
    """mu at each row of the design and each slip: shape (rows, slips)."""
    at = Observations(rows, np.repeat(np.arange(len(rows)), len(slips)), np.tile(slips, len(rows)))
    mu = problem.law.traction(problem.expand(optimum.values), at)
    return mu.reshape(len(rows), len(slips))
