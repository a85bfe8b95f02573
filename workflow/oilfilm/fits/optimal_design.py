"""Which curve to measure next: the covariance by generalised least squares, and the best additions.

What a curve adds to the precision of the constants is known before it is measured: its slopes and
the expected errors of its points. Precisions add, so that no measurement can make anything less
certain. Choosing the curves that make the variance of a wanted quantity least is c-optimality, the
mean over several quantities is A-optimality (linear or L-optimality): A. C. Atkinson, A. N. Donev,
R. D. Tobias, Optimum Experimental Designs, with SAS (2007), chapters 10 and 17. The law is not
linear in its constants, so the design is optimal at the constants known so far (locally optimal),
and a plan of several curves is made one after the other.

Decides: how much a further curve would tell.
"""

from dataclasses import dataclass

import numpy as np

from oilfilm.units import FloatArray


def covariance(precision: FloatArray) -> FloatArray:
    """The inverse of precisions, shape (..., n, n), whose parameters may differ much in size."""
    size = np.sqrt(np.diagonal(precision, axis1=-2, axis2=-1))
    scale = size[..., :, np.newaxis] * size[..., np.newaxis, :]
    return np.asarray(np.linalg.inv(precision / scale) / scale)


def uncertainties(precision: FloatArray, gradients: FloatArray) -> FloatArray:
    """Standard uncertainty of each quantity, shape (..., quantities).

    Args:
        precision: Of the parameters, shape (..., n, n).
        gradients: Of the quantities by the parameters, shape (quantities, n).
    """
    variance = (gradients @ covariance(precision) * gradients).sum(axis=-1)
    return np.sqrt(np.maximum(variance, 0.0))


def uncertainty(precision: FloatArray, gradients: FloatArray) -> FloatArray:
    """Root mean square of `uncertainties`, shape (...,)."""
    return np.asarray(np.sqrt(np.square(uncertainties(precision, gradients)).mean(axis=-1)))


@dataclass(frozen=True)
class Design:
    """Curves chosen one after the other.

    Attributes:
        chosen: Candidates in the order of the plan.
        before: Uncertainty with the curves that there are.
        alone: Uncertainty with one candidate added, shape (candidates,).
        after: Uncertainty after each chosen curve, shape (chosen,).
        end: Precision of all curves.
    """

    chosen: list[int]
    before: float
    alone: FloatArray
    after: FloatArray
    end: FloatArray


def choose(
    known: FloatArray,
    candidates: FloatArray,
    gradients: FloatArray,
    count: int,
    smallest_gain: float = 0.0,
) -> Design:
    """Choose curves one after the other, each the best given those before.

    Args:
        known: Precision of the parameters by the curves that there are, shape (n, n).
        candidates: What each curve that could be measured adds, shape (candidates, n, n); each is
            chosen once at most.
        gradients: Of the wanted quantities by the parameters, shape (quantities, n).
        count: Number of curves; fewer where there are fewer candidates.
        smallest_gain: Relative fall of the uncertainty below which a curve is not worth measuring.

    Examples:
        A straight line through 4 points with mean 0 is wanted at x = 0.5. Every new point at x
        gives the variance 1/5 at the mean of all five, so the best one is x = 5 * 0.5
        (the mean moves to where the line is wanted):

        >>> x = np.linspace(-3, 3, 61)
        >>> rows = np.stack([np.ones_like(x), x], axis=-1)[:, np.newaxis]
        >>> new = np.swapaxes(rows, 1, 2) @ rows
        >>> best = choose(np.diag([4.0, 10.0]), new, np.array([[1.0, 0.5]]), 1)
        >>> print(f"{x[best.chosen[0]]:.1f} {best.after[0] ** 2:.3f}")
        2.5 0.200
    """
    alone = uncertainty(known + candidates, gradients)
    before = float(uncertainty(known, gradients))
    left = np.ones(len(alone), dtype=bool)
    chosen: list[int] = []
    after = [before]
    state = known
    for _ in range(min(count, len(alone))):
        new = np.where(left, uncertainty(state + candidates, gradients), np.inf)
        best = int(np.argmin(new))
        if new[best] > (1 - smallest_gain) * after[-1]:
            break
        chosen.append(best)
        after.append(float(new[best]))
        left[best] = False
        state = state + candidates[best]
    return Design(chosen, before, alone, np.array(after[1:]), state)
