"""The fit beside the plain one: weighted by standard errors, and with a robust loss.

The paper's plain sum of squares (Eq. 10) is the reference. What others make of the same points
says whether a few curves decide the constants.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from oilfilm.curation.plateaus import MAD_TO_SIGMA
from oilfilm.fitting.engine import Optimum, polish
from oilfilm.fitting.problem import CurveData, Problem
from oilfilm.settings.config import FitSettings
from oilfilm.traction.law import FloatArray

# Cauchy loss at this many standard deviations keeps 95 % of the efficiency on normal errors.
_CAUCHY_TUNING = 2.3849
_ROUNDS = 10


@dataclass(frozen=True)
class Alternative:
    """Another objective's end: constants, and the weight it gave to each point (at most 1)."""

    values: FloatArray
    weight: FloatArray


def weighted_fit(problem: Problem, data: CurveData, plain: Optimum) -> Alternative | None:
    """Least squares weighted by 1/(se^2 + s0^2); None where no standard error is known.

    s0^2 is what the plain fit's residuals have beyond the points' standard errors: errors that a
    run's points share, and what the law cannot follow. Without it the quietest points alone would
    decide. A point without a standard error of its own counts with the median one.
    """
    known = np.isfinite(data.mu_se)
    if not known.any():
        return None
    variance = np.where(known, data.mu_se, np.median(data.mu_se[known])) ** 2
    residual = problem.residual(plain.values)
    excess = max(float(np.mean(residual**2 - variance)), 0.0)
    if not np.any(variance + excess):
        return None
    # an exact fit of exact points leaves no variance at some of them: they count alike
    weight = 1 / np.maximum(variance + excess, 1e-6 * float(np.mean(variance + excess)))
    weight = weight / weight.max()
    return Alternative(polish(problem, plain.values, weight).values, weight)


def robust_fit(problem: Problem, plain: Optimum) -> Alternative | None:
    """Cauchy loss, its scale from the median size of the residuals; None for an exact fit.

        minimise sum of ln(1 + (r/c)^2),  c = 2.3849 * 1.4826 median |r|

    The scale is taken again from each end until both stand.

    Reference: P. J. Huber, E. M. Ronchetti, Robust Statistics, 2nd ed. (2009), chapters 4 and 7.
    """
    values, scale = plain.values, 0.0
    for _ in range(_ROUNDS):
        median = float(np.median(np.abs(problem.residual(values))))
        new_scale = _CAUCHY_TUNING * MAD_TO_SIGMA * median
        if new_scale == 0 or not np.isfinite(new_scale):
            return None
        if abs(new_scale - scale) <= 1e-3 * new_scale:
            break
        scale = new_scale
        values = _cauchy(problem, values, scale)
    return Alternative(values, 1 / (1 + (problem.residual(values) / scale) ** 2))


def _cauchy(problem: Problem, start: FloatArray, scale: float) -> FloatArray:
    # in units of the scale: the solver's tolerances are absolute in the gradient
    def residual(values: FloatArray) -> FloatArray:
        return problem.residual(values) / scale

    def jacobian(values: FloatArray) -> FloatArray:
        return problem.jacobian(values) / scale

    with np.errstate(over="ignore", invalid="ignore"):
        result = least_squares(
            residual,
            start,
            jacobian,
            bounds=tuple(problem.limits.T),
            method="trf",
            x_scale="jac",
            loss="cauchy",
            ftol=1e-12,
            xtol=1e-10,
            gtol=1e-10,
            max_nfev=200,
        )
    return np.asarray(result.x)


def difference(problem: Problem, plain: Optimum, other: Alternative | None) -> float:
    """Relative RMS difference of mu between two fits, over the fitted points."""
    if other is None:
        return float("nan")
    mu = problem.residual(plain.values) + problem.mu
    change = problem.residual(other.values) + problem.mu - mu
    return float(np.sqrt(np.mean(change**2) / np.mean(mu**2)))


def curve_weights(problem: Problem, robust: Alternative | None) -> FloatArray:
    """Mean robust weight of each curve's points: near 1 where it agrees with the others."""
    if robust is None:
        return np.ones(problem.curves)
    counts = np.bincount(problem.at.curve, minlength=problem.curves)
    return np.bincount(problem.at.curve, robust.weight, minlength=problem.curves) / counts


def pulling_curves(data: CurveData, weights: FloatArray, settings: FitSettings) -> list[str]:
    """Runs that the robust fit all but ignores, worst first: they pull the plain fit away."""
    order = np.argsort(weights)
    return [data.runs[curve] for curve in order if weights[curve] < settings.pulling_weight]
