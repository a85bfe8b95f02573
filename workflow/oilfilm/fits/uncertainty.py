"""Errors of the constants: by the Jacobian, by a bootstrap over whole curves, and for few curves.

Decides: the standard errors of constants, by bootstrap or, below 20 curves, cluster-robust.
"""

from dataclasses import dataclass

import numpy as np

from oilfilm.fits.descent import descend
from oilfilm.fits.engine import Optimum, at_bounds
from oilfilm.fits.problem import Problem
from oilfilm.units import FloatArray, IndexArray

# A refit is one draw of a spread: digits beyond these are never seen.
_REFIT_TOLERANCE = 1e-8
# Draws checked at once.
_DRAWS = 100
# A curve that alone decides a direction has no residual there: its leverage is cut off here.
_LARGEST_LEVERAGE = 1 - 1e-6


@dataclass(frozen=True)
class Estimates:
    """Fitted quantities with all that says how sure they are.

    Attributes:
        values: The quantities at the optimum, shape (n,).
        naive: Their covariance as if every point had an error of its own, shape (n, n).
        refits: The quantities in each refit of the bootstrap over curves, or drawn from the
            cluster-robust covariance; shape (refits, n).
        shifted: Refitted with one sensor each off by its calibration's standard uncertainty,
            shape (sensors, n); no rows where that is not known.
    """

    values: FloatArray
    naive: FloatArray
    refits: FloatArray
    shifted: FloatArray

    @property
    def naive_errors(self) -> FloatArray:
        """Standard errors by `naive`."""
        return np.sqrt(np.diag(self.naive))

    @property
    def systematic_errors(self) -> FloatArray:
        """Standard errors from calibration; NaN where it is not known."""
        if len(self.shifted) == 0:
            return np.full(len(self.values), np.nan)
        return np.sqrt(((self.shifted - self.values) ** 2).sum(axis=0))

    @property
    def random_covariance(self) -> FloatArray:
        """Covariance of the refits, shape (n, n); NaN where there are none."""
        if not len(self.refits):
            return np.full_like(self.naive, np.nan)
        return np.atleast_2d(np.cov(self.refits, rowvar=False))

    @property
    def correlation(self) -> FloatArray:
        """Correlation matrix of the refits; of `naive` where there are none, NaN without spread."""
        covariance = self.random_covariance if len(self.refits) else self.naive
        errors = np.sqrt(np.where(np.diag(covariance) > 0, np.diag(covariance), np.nan))
        return np.asarray(covariance / np.outer(errors, errors))

    def reported(self, problem: Problem) -> "Estimates":
        """The same of the constants in the form of the law's equation, from internal ones."""
        values = problem.reported(self.values)
        # d X0 / d ln|X0| = X0
        slopes = np.where(problem.logarithmic, values, 1.0)
        return Estimates(
            values,
            self.naive * np.outer(slopes, slopes),
            problem.reported(self.refits),
            problem.reported(self.shifted),
        )


def naive_covariance(problem: Problem, optimum: Optimum) -> FloatArray:
    """Covariance of the free internal constants as if every point had an error of its own.

        s^2 (J^T J)^-1,  s^2 = SSE / (points - constants)

    It is too small wherever a run's points share an error (load, temperature). NaN where the data
    leave no degree of freedom or the Jacobian is singular.
    """
    jacobian = problem.jacobian(optimum.values)
    degrees = len(problem.mu) - jacobian.shape[1]
    if degrees <= 0 or np.linalg.matrix_rank(jacobian) < jacobian.shape[1]:
        return np.full((jacobian.shape[1],) * 2, np.nan)
    _, upper = np.linalg.qr(jacobian)
    inverse = np.linalg.inv(upper)
    return np.asarray(optimum.sse / degrees * inverse @ inverse.T)


def curve_bootstrap(
    problem: Problem, optimum: Optimum, refits: int, random: np.random.Generator
) -> FloatArray:
    """Refits to as many whole curves drawn with replacement: shape (refits, free constants).

    Points of a run share its calibration and control errors; drawing runs, not points, keeps
    those errors together. A sample whose curves cannot tell the exponents apart is replaced.

    Reference: B. Efron, R. J. Tibshirani, An Introduction to the Bootstrap (1993), chapter 8.
    """
    draws = draw_curves(problem.at.design, refits, random)
    starts, weights = np.tile(optimum.values, (refits, 1)), draws.astype(float)
    return descend(problem, starts, weights=weights, tolerance=_REFIT_TOLERANCE, near=True)[0]


def without_bounds(problem: Problem, refits: FloatArray) -> FloatArray:
    """The refits of which no constant ended at a bound of the search.

    A bound is where the search stopped, not what the curves say: its value means nothing.
    """
    return refits[~at_bounds(problem, refits).any(axis=1)]


def robust_covariance(problem: Problem, optimum: Optimum) -> FloatArray:
    """Covariance of the free internal constants by the residuals of whole curves, for few curves.

        V = (J^T J)^-1 [sum J_i^T A_i r_i r_i^T A_i J_i] (J^T J)^-1,  A_i = (I - H_ii)^(-1/2)

    r_i are the residuals of curve i and H_ii its block of J (J^T J)^-1 J^T. A_i makes up for what
    the fit takes from the residuals of a curve with much leverage. Resampling few curves leaves
    conditions out, so that refits run away; this does not.

    Reference: R. M. Bell, D. F. McCaffrey, Survey Methodology 28 (2002) 169 (CR2).
    """
    orthonormal, upper = np.linalg.qr(problem.jacobian(optimum.values))
    residual = problem.residual(optimum.values)
    scores = []
    for first, length in zip(problem.starts, problem.lengths, strict=True):
        points = slice(first, first + length)
        leverage, directions = np.linalg.eigh(orthonormal[points].T @ orthonormal[points])
        # Q_i^T (I - Q_i Q_i^T)^(-1/2) r_i, along the eigenvectors of Q_i^T Q_i
        factor = 1 / np.sqrt(1 - np.clip(leverage, 0, _LARGEST_LEVERAGE))
        along = directions.T @ (orthonormal[points].T @ residual[points])
        scores.append(directions @ (factor * along))
    root = np.linalg.solve(upper, np.array(scores).T)
    return np.asarray(root @ root.T)


def robust_draws(
    problem: Problem, optimum: Optimum, count: int, random: np.random.Generator
) -> FloatArray:
    """Constants drawn about the optimum from `robust_covariance`, within the law's bounds."""
    size, directions = np.linalg.eigh(robust_covariance(problem, optimum))
    normal = random.standard_normal((count, len(size)))
    draws = optimum.values + normal @ (directions * np.sqrt(np.maximum(size, 0))).T
    return np.clip(draws, *problem.limits.T)


def draw_curves(design: FloatArray, count: int, random: np.random.Generator) -> IndexArray:
    """How often each curve is drawn, shape (count, curves); every draw identifies what all do."""
    curves, rank = len(design), np.linalg.matrix_rank(design)
    draws = np.empty((0, curves), dtype=np.int64)
    while len(draws) < count:
        some = min(count - len(draws), _DRAWS)
        more = random.multinomial(curves, np.full(curves, 1 / curves), some)
        drawn = np.where(more[:, :, np.newaxis] > 0, design, 0.0)
        draws = np.concatenate([draws, more[np.linalg.matrix_rank(drawn) == rank]])
    return draws
