"""The proof that a fit is the best one: independent searches agree at a flat, physical spot."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from oilfilm.fitting.engine import Optimum
from oilfilm.fitting.problem import CurveData, Problem
from oilfilm.traction.law import FloatArray, Observations


@dataclass(frozen=True)
class Certificate:
    """What the searches and the optimum itself say; `certified` where all of it holds."""

    searches: int
    searches_agreeing: int
    sse_spread: float
    constant_spread: float
    gradient_cosine: float
    min_traction: float
    certified: bool
    verdict: str


def certify(
    problem: Problem,
    data: CurveData,
    optima: Sequence[Optimum],
    naive_errors: FloatArray,
    settings: Mapping[str, Any],
) -> Certificate:
    """Judge the best of several searches.

    Args:
        problem: What was fitted.
        data: The data it was fitted to.
        optima: End of each independent search.
        naive_errors: Naive standard errors of the free constants.
        settings: Limits of config's fit.
    """
    best = min(optima, key=lambda optimum: optimum.sse)
    spreads = [(optimum.sse - best.sse) / max(best.sse, 1e-300) for optimum in optima]
    distances = [
        float(np.max(np.abs(optimum.values - best.values) / naive_errors)) for optimum in optima
    ]
    agreeing = sum(
        spread <= settings["agreement_sse"] and distance <= settings["agreement_constants"]
        for spread, distance in zip(spreads, distances, strict=True)
    )
    cosine = gradient_cosine(problem, best)
    smallest = min_traction(problem, data, best)
    checks = {
        f"{agreeing} of {len(optima)} searches agree": agreeing == len(optima),
        f"their SSE differ by {max(spreads):.1e}": max(spreads) <= settings["agreement_sse"],
        f"their constants by {max(distances):.1e} standard errors": (
            max(distances) <= settings["agreement_constants"]
        ),
        f"gradient cosine {cosine:.1e}": cosine <= settings["gradient_cosine_max"],
        f"mu >= {smallest:.1e} over the tested box": smallest >= 0,
    }
    certified = all(checks.values())
    failing = [what for what, holds in checks.items() if not holds]
    verdict = (
        "certified: " + "; ".join(checks) if certified else "not certified: " + "; ".join(failing)
    )
    return Certificate(
        len(optima),
        agreeing,
        max(spreads),
        max(distances),
        cosine,
        smallest,
        certified,
        verdict,
    )


def gradient_cosine(problem: Problem, optimum: Optimum) -> float:
    """Largest |cos| of the angle between the residual and a column of the Jacobian.

    It is zero at a stationary point whatever the scale of data and constants (the orthogonality
    test of MINPACK's lmder).
    """
    residual, jacobian = problem.residual(optimum.values), problem.jacobian(optimum.values)
    length = np.linalg.norm(residual) * np.linalg.norm(jacobian, axis=0)
    return float(np.max(np.abs(residual @ jacobian) / np.where(length > 0, length, 1.0)))


def min_traction(problem: Problem, data: CurveData, optimum: Optimum) -> float:
    """Smallest mu on a grid over the tested conditions and slips 0 to the largest tested."""
    design = problem.at.design
    corners = [
        np.linspace(low, high, 9) for low, high in zip(design.min(0), design.max(0), strict=True)
    ]
    rows = np.stack(np.meshgrid(*corners, indexing="ij"), axis=-1).reshape(-1, design.shape[1])
    rows = np.unique(rows, axis=0)
    slips = np.linspace(0, float(np.max(np.abs(data.slip))), 61)
    at = Observations(rows, np.repeat(np.arange(len(rows)), len(slips)), np.tile(slips, len(rows)))
    return float(problem.law.traction(problem.expand(optimum.values), at).min())
