"""Which curve to measure next: the covariance of a least-squares refit, and the best additions.

A fit by plain least squares sums over curves. What a curve adds to the constants' errors is thus
known before it is measured: its slopes and the expected errors of its points. To first order in the
errors this is the covariance that a refit of all curves will report (a sandwich with curves as
clusters: K.-Y. Liang, S. L. Zeger, Biometrika 73 (1986) 13). Choosing the curves that make the
variance of a wanted quantity least is c-optimality, the mean over several quantities is
A-optimality (linear or L-optimality): A. C. Atkinson, A. N. Donev, R. D. Tobias, Optimum
Experimental Designs, with SAS (2007), chapters 10 and 17. The law is not linear in its constants,
so the design is optimal at the constants known so far (locally optimal), and a plan of several
curves is made one after the other.

Decides: how much a further curve would tell.
"""

from dataclasses import dataclass

import numpy as np

from oilfilm.units import FloatArray


@dataclass(frozen=True)
class Information:
    """What curves tell about the constants: sums over curves, so that curves can be added.

    All arrays may have leading axes: one entry per candidate.

    Attributes:
        hessian: Sum of J^T J, J the slopes of mu by the constants; shape (..., n, n).
        scatter: Sum of J^T R J, R the covariance of a curve's errors, which no other curve shares;
            shape (..., n, n).
        shared: Sum of J^T d, d the error that one standard uncertainty of each sensor's calibration
            makes in all curves alike; shape (..., n, sensors).
    """

    hessian: FloatArray
    scatter: FloatArray
    shared: FloatArray

    def plus(self, other: "Information") -> "Information":
        """The information of both; leading axes broadcast."""
        return Information(
            self.hessian + other.hessian,
            self.scatter + other.scatter,
            self.shared + other.shared,
        )

    def at(self, index: int) -> "Information":
        """One entry along the first axis."""
        return Information(self.hessian[index], self.scatter[index], self.shared[index])

    def without_calibration(self) -> "Information":
        """The same where the sensors are exact."""
        return Information(self.hessian, self.scatter, np.zeros_like(self.shared))

    @property
    def covariance(self) -> FloatArray:
        """Covariance of the constants fitted to these curves: H^-1 (M + C C^T) H^-1."""
        # columns of length 1: constants differ in size, and H squares the condition number
        size = np.sqrt(np.diagonal(self.hessian, axis1=-2, axis2=-1))
        scale = size[..., :, np.newaxis] * size[..., np.newaxis, :]
        middle = self.scatter + self.shared @ np.swapaxes(self.shared, -1, -2)
        half = np.linalg.solve(self.hessian / scale, middle / scale)
        whole = np.linalg.solve(self.hessian / scale, np.swapaxes(half, -1, -2))
        return np.asarray(whole / scale)

    def uncertainty(self, gradients: FloatArray) -> FloatArray:
        """Root mean square of the standard uncertainties of quantities with these gradients.

        Args:
            gradients: By the constants, shape (quantities, n).

        Returns:
            Shape (...,).
        """
        return np.sqrt(np.square(self.uncertainties(gradients)).mean(axis=-1))

    def uncertainties(self, gradients: FloatArray) -> FloatArray:
        """Standard uncertainty of each quantity, shape (..., quantities)."""
        variance = np.einsum("qn,...nm,qm->...q", gradients, self.covariance, gradients)
        return np.sqrt(np.maximum(variance, 0.0))


@dataclass(frozen=True)
class Design:
    """Curves chosen one after the other.

    Attributes:
        chosen: Candidates in the order of the plan.
        before: Uncertainty with the curves that there are.
        alone: Uncertainty with one candidate added, shape (candidates,).
        after: Uncertainty after each chosen curve, shape (chosen,).
        end: Information of all curves.
    """

    chosen: list[int]
    before: float
    alone: FloatArray
    after: FloatArray
    end: Information


def choose(
    known: Information, candidates: Information, gradients: FloatArray, count: int
) -> Design:
    """Choose curves one after the other, each the best given those before.

    Args:
        known: Of the curves that there are.
        candidates: Of each curve that could be measured; each is chosen once at most.
        gradients: Of the wanted quantities by the constants, shape (quantities, n).
        count: Number of curves; fewer where there are fewer candidates.

    Examples:
        A straight line through 4 points with mean 0 is wanted at x = 0.5. Every new point at x
        gives the variance 1/5 at the mean of all five, so the best one is x = 5 * 0.5
        (the mean moves to where the line is wanted):

        >>> x = np.linspace(-3, 3, 61)
        >>> rows = np.stack([np.ones_like(x), x], axis=-1)[:, np.newaxis]
        >>> each = np.swapaxes(rows, 1, 2) @ rows
        >>> known = Information(np.diag([4.0, 10.0]), np.diag([4.0, 10.0]), np.zeros((2, 1)))
        >>> new = Information(each, each, np.zeros((61, 2, 1)))
        >>> best = choose(known, new, np.array([[1.0, 0.5]]), 1)
        >>> print(f"{x[best.chosen[0]]:.1f} {best.after[0] ** 2:.3f}")
        2.5 0.200
    """
    alone = known.plus(candidates).uncertainty(gradients)
    left = np.ones(len(alone), dtype=bool)
    chosen: list[int] = []
    after: list[float] = []
    state = known
    for _ in range(min(count, len(alone))):
        uncertainty = np.where(left, state.plus(candidates).uncertainty(gradients), np.inf)
        best = int(np.argmin(uncertainty))
        chosen.append(best)
        after.append(float(uncertainty[best]))
        left[best] = False
        state = state.plus(candidates.at(best))
    return Design(chosen, float(known.uncertainty(gradients)), alone, np.array(after), state)
