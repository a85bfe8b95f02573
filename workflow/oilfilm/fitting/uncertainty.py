"""How sure the constants are: the Jacobian's errors, and those of whole curves drawn again."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from oilfilm.fitting.engine import Optimum, polish
from oilfilm.fitting.problem import Problem
from oilfilm.traction.law import FloatArray, IndexArray

# A refit is one draw of a spread: digits beyond these are never seen.
_REFIT_TOLERANCE = 1e-9
# Central difference: exact to about 1e-10 for quantities and constants of order one.
_STEP = 1e-5


@dataclass(frozen=True)
class Estimates:
    """Fitted quantities with all that says how sure they are.

    Attributes:
        values: The quantities at the optimum, shape (n,).
        naive: Their covariance as if every point had an error of its own, shape (n, n).
        refits: The quantities refitted to curves drawn again, shape (refits, n).
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

    def through(self, function: Callable[[FloatArray], FloatArray]) -> "Estimates":
        """The same of quantities that are a function of these."""
        values = function(self.values)
        slopes = np.column_stack(
            [
                (function(self.values + step) - function(self.values - step)) / (2 * _STEP)
                for step in _STEP * np.eye(len(self.values))
            ]
        )

        def each(rows: FloatArray) -> FloatArray:
            return np.array([function(row) for row in rows]).reshape(-1, len(values))

        return Estimates(
            values, slopes @ self.naive @ slopes.T, each(self.refits), each(self.shifted)
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
    those errors together. A draw whose curves cannot tell the exponents apart is drawn again.

    Reference: B. Efron, R. J. Tibshirani, An Introduction to the Bootstrap (1993), chapter 8.
    """
    draws = _draws(problem.at.design, refits, random)
    weights = (np.sqrt(draw)[problem.at.curve] for draw in draws)
    return np.array(
        [polish(problem, optimum.values, weight, _REFIT_TOLERANCE).values for weight in weights]
    )


def _draws(design: FloatArray, count: int, random: np.random.Generator) -> IndexArray:
    """How often each curve is drawn, shape (count, curves); every draw identifies what all do."""
    curves, rank = len(design), np.linalg.matrix_rank(design)
    draws: list[IndexArray] = []
    while len(draws) < count:
        draw = random.multinomial(curves, np.full(curves, 1 / curves))
        if np.linalg.matrix_rank(design[draw > 0]) == rank:
            draws.append(draw)
    return np.array(draws)
