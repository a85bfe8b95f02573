"""The tables of one fit: constants, quality, refits, correlations, profiles, residuals by curve."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.fits.certificate import tested_grid, traction_on
from oilfilm.fits.conditions import from_text
from oilfilm.fits.engine import Optimum
from oilfilm.fits.interval import Unseen, normal_quantile
from oilfilm.fits.objectives import Alternative, curve_agreement, difference, odd_curves
from oilfilm.fits.problem import Problem
from oilfilm.fits.uncertainty import SENSORS, Estimates, profile_interval
from oilfilm.settings.config import FitSettings
from oilfilm.table_needs import OF_FIT
from oilfilm.traction.law import CONDITIONS, Law
from oilfilm.units import FloatArray

# Traction this small beside the largest is rounding: no dip below zero, no second rise.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Solution:
    """One law fitted to one oil.

    Attributes:
        problem: What was fitted; constants that ran into a bound are held there.
        best: The best end of the searches.
        certificate: Whether the searches agree, and at what kind of optimum.
        estimates: The free constants with their errors.
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
    robust: Alternative | None
    left_out: FloatArray
    unseen: Unseen
    refits_at_bounds: int


def tables_of_fit(
    solution: Solution,
    points: pd.DataFrame,
    quality: Mapping[str, Any],
    settings: FitSettings,
) -> dict[str, pd.DataFrame]:
    """Each table of a fit, by its name.

    Args:
        solution: The fit.
        points: The oil's rows of the table of points, without those of incomplete curves.
        quality: Oil, law, counts and tested box: the row of `fit_quality` so far.
        settings: `sign_confidence` and `pulling_weight` of config's fit.
    """
    frames = {
        "coefficients": _judged(_coefficients(solution, settings), solution, quality),
        "fit_quality": pd.DataFrame([{**quality, **_quality(solution)}]),
        "refits": _refits(solution),
        "correlations": _correlations(solution),
        "profiles": _profiles(solution),
        "curve_residuals": _curve_residuals(solution, settings),
        "law_points": _law_points(solution, points),
    }
    return _of_fit(quality, frames)


def tables_without_fit(
    constants: Sequence[str],
    quality: Mapping[str, Any],
    reason: str,
) -> dict[str, pd.DataFrame]:
    """The same of data that could not be fitted: no values, and the reason as the certificate.

    Args:
        constants: Names of the constants that were to be fitted.
        quality: As of `tables_of_fit`.
        reason: Why there is no fit.
    """
    rows = pd.DataFrame({"constant": constants}).assign(verdict="not identifiable")
    row = {**quality, "certificate": f"not fitted: {reason}"}
    known = {"coefficients": rows, "fit_quality": pd.DataFrame([row])}
    return _of_fit(quality, {**dict.fromkeys(OF_FIT, pd.DataFrame()), **known})


def _of_fit(
    quality: Mapping[str, Any], frames: Mapping[str, pd.DataFrame]
) -> dict[str, pd.DataFrame]:
    """Each table with oil and law in every row."""
    of = {name: quality[name] for name in ("oil", "law")}
    return {
        name: tables.filled(frame.assign(**of), name, f"fit of {of['oil']}")
        if len(frame)
        else tables.empty(name)
        for name, frame in frames.items()
    }


def _coefficients(solution: Solution, settings: FitSettings) -> pd.DataFrame:
    """One row per constant, in the order of the law."""
    law, at_bounds = solution.problem.law, solution.problem.at_bounds
    estimated = _estimated(solution, settings.sign_confidence)
    # the level of a condition that did not vary is inside X0: neither can be told apart
    local = [name for name in law.local_constants if name in {*estimated.index, *at_bounds}]
    rows = estimated.reindex([*fitted_names(law), *local])
    rows["identifiable"] = rows.index.isin(estimated.index)
    rows["verdict"] = rows["verdict"].fillna("not identifiable")
    for name, value in at_bounds.items():
        rows.loc[name, "value"] = value
        rows.loc[name, "verdict"] = "at a bound"
    return rows.rename_axis("constant").reset_index()


def fitted_names(law: Law) -> list[str]:
    """Names of the constants of a law that are fitted."""
    return [constant.name for constant in law.constants if constant.known is None]


def _estimated(solution: Solution, sign_confidence: float) -> pd.DataFrame:
    """One row per free constant, by its name, with its errors and intervals."""
    problem, estimates = solution.problem, solution.estimates.reported(solution.problem)
    degrees = len(problem.mu) - len(solution.best.values)
    profiles = zip(*solution.profile, strict=True)
    ends = np.array([profile_interval(*profile, degrees) for profile in profiles])
    lower, upper = problem.reported(ends.T)
    # a constant below zero falls where its logarithm rises
    turned = problem.signs < 0
    rows = pd.DataFrame(
        {
            "value": estimates.values,
            "standard_error": np.nan,
            "lower": np.nan,
            "upper": np.nan,
            "naive_standard_error": estimates.naive_errors,
            "profile_lower": np.where(turned, upper, lower),
            "profile_upper": np.where(turned, lower, upper),
            "systematic_standard_error": estimates.systematic_errors,
            "verdict": "no interval",
        },
        index=problem.names,
    )
    if len(estimates.refits):
        rows["standard_error"] = [constant.std(ddof=1) for constant in estimates.refits.T]
        low, high = np.quantile(estimates.refits, [0.025, 0.975], axis=0)
        error = np.hypot(rows["standard_error"], rows["systematic_standard_error"].fillna(0.0))
        reach = sign_reach(len(rows), sign_confidence) * error
        # the refits may be skew
        rows["lower"] = np.minimum(rows["value"] - reach, low)
        rows["upper"] = np.maximum(rows["value"] + reach, high)
        known = rows["lower"] * rows["upper"] > 0
        rows["verdict"] = np.where(known, "known", "sign unknown")
    return rows


def sign_reach(constants: int, confidence: float) -> float:
    """Standard errors that a constant must lie from zero for its sign to be called known.

    A fit calls the signs of all its constants at once: by an interval of 95 % each, of twelve
    constants without effect one would be called wrongly every second time. Hence Bonferroni's
    limit, for all of them together.

    Args:
        constants: Constants that are judged.
        confidence: That no sign is called wrongly, as a share.
    """
    return normal_quantile(1 - (1 - confidence) / constants)


def _judged(rows: pd.DataFrame, solution: Solution, quality: Mapping[str, Any]) -> pd.DataFrame:
    """The constants, with exponents along a line called so: they are of no condition alone."""
    law = solution.problem.law
    along = {
        other.condition
        for fixed in from_text(quality["fixed_conditions"])
        for other in fixed.in_step
    }
    # every group that a law makes of conditions may hold one of them
    groups = along if law.groups == law.conditions else set(law.groups if along else ())
    names = {constant.name for constant in law.constants if constant.condition in groups}
    in_step = rows["constant"].isin(names) & rows["identifiable"]
    rows.loc[in_step, "verdict"] = "in step"
    return rows


def _quality(solution: Solution) -> dict[str, Any]:
    problem, best = solution.problem, solution.best
    residual = problem.residual(best.values)
    rmse = float(np.sqrt(np.mean(residual**2)))
    constants = len(best.values) + len(problem.at_bounds)
    aic, bic = information_criteria(best.sse, len(residual), constants)
    on_grid = traction_on(problem, best, *tested_grid(problem))
    starts = on_grid[:, 0]
    negative, second_rise = curve_shapes(on_grid)
    return {
        "n_constants": constants,
        "sse": best.sse,
        "rmse": rmse,
        "relative_rms": rmse / float(np.sqrt(np.mean(problem.mu**2))),
        "max_error": float(np.abs(residual).max()),
        "aic": aic,
        "bic": bic,
        "zero_slip_traction": float(starts[np.argmax(np.abs(starts))]),
        "negative_share": negative,
        "second_rise_share": second_rise,
        "robust_difference": difference(problem, best, solution.robust),
        "left_out_rmse": float(np.sqrt(np.mean(solution.left_out**2))),
        "refits_at_bounds": solution.refits_at_bounds,
        **solution.unseen.columns(),
        **solution.certificate,
    }


def information_criteria(sse: float, n_points: int, n_constants: int) -> tuple[float, float]:
    """Akaike's and the Bayesian information criterion of a least-squares fit.

        AIC = n ln(SSE/n) + 2 k,   BIC = n ln(SSE/n) + k ln n

    k counts the constants and the variance of the errors; terms that all laws share are left out.
    Both take every point for independent, which points of a run are not: differences between laws
    look surer than they are.

    Args:
        sse: Sum of squared errors.
        n_points: n.
        n_constants: Constants fitted.

    Returns:
        AIC and BIC; NaN for an exact fit.

    Reference: K. P. Burnham, D. R. Anderson, Model Selection and Multimodel Inference, 2nd ed.
        (2002), sections 2.2 and 6.4.

    Examples:
        By hand, 100 ln(1e-4/100) = -1381.55, k = 3:

        >>> aic, bic = information_criteria(1e-4, 100, 2)
        >>> print(f"{aic:.2f} {bic:.2f}")
        -1375.55 -1367.74
    """
    if sse <= 0:
        return float("nan"), float("nan")
    fit, k = n_points * np.log(sse / n_points), n_constants + 1
    return float(fit + 2 * k), float(fit + k * np.log(n_points))


def curve_shapes(mu: FloatArray) -> tuple[float, float]:
    """Where curves of mu against slip are not as the paper says: shares of the given grid.

    Args:
        mu: Shape (conditions, slips), slips rising.

    Returns:
        Share of all points where mu is below zero, and share of conditions at which mu rises again
        after a fall: more than the paper's one peak.
    """
    rounding = _ROUNDING * float(np.abs(mu).max(initial=0.0))
    steps = np.diff(mu, axis=1)
    fallen = np.logical_or.accumulate(steps < -rounding, axis=1)
    again = np.any(fallen & (steps > rounding), axis=1)
    return float(np.mean(mu < -rounding)), float(np.mean(again))


def _refits(solution: Solution) -> pd.DataFrame:
    estimates = solution.estimates.reported(solution.problem)
    causes = [("resampled curves", estimates.refits)]
    causes += [
        (f"calibration of {sensor}", row[np.newaxis])
        for sensor, row in zip(SENSORS, estimates.shifted, strict=False)
    ]
    names = solution.problem.names
    frames = [
        pd.DataFrame(
            {
                "cause": cause,
                "refit": np.repeat(np.arange(len(values)), len(names)),
                "constant": names * len(values),
                "value": values.ravel(),
            }
        )
        for cause, values in causes
        if len(values)
    ]
    return pd.concat(frames, ignore_index=True) if frames else pd.DataFrame()


def _correlations(solution: Solution) -> pd.DataFrame:
    first, second = np.triu_indices(len(solution.problem.names), k=1)
    names = np.array(solution.problem.names)
    values = solution.estimates.reported(solution.problem).correlation[first, second]
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
    agreement = curve_agreement(problem, solution.robust)
    return pd.DataFrame(
        {
            "run_id": data.runs,
            "n_points": counts,
            **_mean_conditions(solution),
            "rmse": np.sqrt(squares / counts),
            "gain": agreement.gain,
            "robust_weight": agreement.weight,
            "odd": odd_curves(agreement, settings),
        }
    )


def _mean_conditions(solution: Solution) -> dict[str, FloatArray]:
    """Mean conditions of each curve; NaN for those that the law does not take."""
    law, data = solution.problem.law, solution.problem.data
    known = dict(zip(law.conditions, data.conditions.T, strict=True))
    unknown = np.full(len(data.runs), np.nan)
    return {f"mean_{name}": known.get(name, unknown) for name in (*CONDITIONS, "load_n")}
