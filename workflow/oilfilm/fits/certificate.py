"""The proof that a fit is the best one: independent searches agree at a flat, physical spot.

Decides: when a fit is certified.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from oilfilm.fits.engine import Optimum
from oilfilm.fits.problem import Problem
from oilfilm.settings.config import FitSettings
from oilfilm.traction.law import Observations
from oilfilm.units import FloatArray


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
    smallest = float(traction_on(problem, best, *tested_grid(problem)).min())
    low, high, condition = spectrum(problem, best)
    active = ", ".join(problem.at_bounds)
    checks = {
        f"{agreeing} of {len(optima)} searches agree": agreeing == len(optima),
        f"their SSE differ by {spread:.1e}": spread <= settings.agreement_sse,
        f"their constants by {distance:.1e} standard errors": (
            distance <= settings.agreement_constants
        ),
        f"gradient cosine {cosine:.1e}": cosine <= settings.gradient_cosine_max,
        f"mu >= {smallest:.1e} over the tested box": smallest >= 0,
        f"curved in every direction (smallest eigenvalue {low:.1e})": low > 0,
        f"bounds reached: {active or 'none'}": not active,
    }
    failing = [what for what, holds in checks.items() if not holds]
    sentence = f"{'not certified' if failing else 'certified'}: {'; '.join(failing or checks)}"
    return {
        "searches": len(optima),
        "searches_agreeing": agreeing,
        "sse_spread": spread,
        "constant_spread": distance,
        "gradient_cosine": cosine,
        "min_traction": smallest,
        "condition_number": condition,
        "hessian_smallest": low,
        "hessian_largest": high,
        "active_bounds": active,
        "certified": not failing,
        "certificate": sentence,
    }


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
