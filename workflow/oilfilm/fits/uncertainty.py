"""Errors of the constants: by the Jacobian, a bootstrap over curves, calibration, and profiles.

Decides: the standard errors of constants, by bootstrap or, below 20 curves, cluster-robust; their
errors from the calibration of the rig.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.fits.descent import descend
from oilfilm.fits.engine import Optimum, polish
from oilfilm.fits.problem import Problem, build_problem, curve_data

# A refit is one draw of a spread: digits beyond these are never seen.
_REFIT_TOLERANCE = 1e-8
# Draws checked at once.
_DRAWS = 100
# A curve that alone decides a direction has no residual there: its leverage is cut off here.
_LARGEST_LEVERAGE = 1 - 1e-6
# Where a profile holds each constant, in naive standard errors from its optimum.
_AT = np.array([-4.0, -3.0, -2.0, -1.5, -1.0, -0.5, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0])
# Sensors in the order of the refits by their calibration.
SENSORS = ("load", "traction force", "entrainment speed", "inlet temperature")


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
        slopes = np.where(problem.signs, values, 1.0)
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
    draws = draw_curves(problem.observations.design, refits, random)
    starts, weights = np.tile(optimum.values, (refits, 1)), draws.astype(float)
    return descend(problem, starts, weights=weights, tolerance=_REFIT_TOLERANCE, near=True)[0]


def robust_covariance(problem: Problem, optimum: Optimum) -> FloatArray:
    """Covariance of the free internal constants by the residuals of whole curves, for few curves.

        V = (J^T J)^-1 [sum J_i^T A_i r_i r_i^T A_i J_i] (J^T J)^-1,  A_i = (I - H_ii)^(-1/2)

    r_i are the residuals of curve i and H_ii its block of J (J^T J)^-1 J^T. A_i makes up for what
    the fit takes from the residuals of a curve with much leverage. Resampling few curves leaves
    conditions out, so that refits run away; this does not.

    Reference: R. M. Bell, D. F. McCaffrey, Survey Methodology 28 (2002) 169 (CR2).
    """
    root = _root_of_covariance(problem, optimum)
    return np.asarray(root @ root.T)


def _root_of_covariance(problem: Problem, optimum: Optimum) -> FloatArray:
    """What each curve adds to the root of `robust_covariance`, shape (free, curves)."""
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
    return np.asarray(np.linalg.solve(upper, np.array(scores).T))


def robust_draws(
    problem: Problem, optimum: Optimum, count: int, random: np.random.Generator
) -> FloatArray:
    """Constants drawn about the optimum from `robust_covariance`, within the law's bounds."""
    # not along eigenvectors, whose signs are the kernel's choice
    root = _root_of_covariance(problem, optimum)
    draws = optimum.values + random.standard_normal((count, problem.curves)) @ root.T
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


# ---------------------------------------------------------------- calibration


def calibration_refits(problem: Problem, optimum: Optimum, points: pd.DataFrame) -> FloatArray:
    """The free constants refitted with each sensor off by its standard uncertainty.

    All points of a rig share such an error, so the sensors are shifted one at a time, everywhere;
    the root of the summed squares of the constants' changes is their systematic standard error.

    Args:
        problem: What was fitted.
        optimum: Where it ended.
        points: The oil's rows of the table of points.

    Returns:
        One row per sensor, in the order of SENSORS; no rows where the calibration of one is not
        stated.
    """
    accepted = points[points["accepted"]]
    refits = []
    for shifted in _shifted(accepted):
        data = curve_data(shifted, problem.law.conditions)
        followed = data.conditions[:, problem.varied]
        if not (np.isfinite(data.mu).all() and np.isfinite(followed).all()):
            return np.empty((0, len(optimum.values)))
        moved = build_problem(problem.law, data, problem.varied)
        moved = replace(problem, observations=moved.observations, mu=moved.mu)
        refits.append(polish(moved, optimum.values).values)
    return np.array(refits)


def _shifted(points: pd.DataFrame) -> list[pd.DataFrame]:
    """The points as they would read with one sensor each off by its standard uncertainty.

    A load of (1 + e) W makes mu = F/W smaller by 1/(1 + e) and the pressure, which goes with the
    cube root of the load, larger.
    """
    load = 1 + points["load_systematic_n"] / points["load_n"]
    force = points["traction_force_systematic_n"] / points["traction_force_n"].abs()
    # at no force at all there is nothing to be a share of
    gain = 1 + force.where(points["traction_force_n"] != 0, 0.0)
    mu, pressure = points["traction_coefficient"], points["max_hertz_pressure_gpa"]
    speed, temperature = points["entrainment_speed_m_s"], points["inlet_temperature_c"]
    return [
        points.assign(
            traction_coefficient=mu / load,
            max_hertz_pressure_gpa=pressure * np.cbrt(load),
            load_n=points["load_n"] * load,
        ),
        points.assign(traction_coefficient=mu * gain),
        # an error of speed that both bodies share leaves the slide-roll ratio as it is
        points.assign(entrainment_speed_m_s=speed + points["entrainment_speed_systematic_m_s"]),
        points.assign(inlet_temperature_c=temperature + points["inlet_temperature_systematic_c"]),
    ]


# ---------------------------------------------------------------- profiles


def profiles(
    problem: Problem, optimum: Optimum, naive: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Values of each free internal constant and the signed root of the SSE's rise there.

        z = sign(x - x_best) sqrt((SSE(x) - SSE_best) / s^2),  s^2 = SSE_best / (points - constants)

    For a linear law z is the distance in naive standard errors; how far it bends from that is how
    far those errors mislead. Like them it takes every point's error for its own.

    Args:
        problem: What was fitted.
        optimum: Where it ended.
        naive: Naive covariance of the free internal constants. The others start where it expects
            them.

    Returns:
        Two arrays of shape (free, levels), ascending, the optimum itself in the middle.

    Reference: D. M. Bates, D. G. Watts, Nonlinear Regression Analysis and Its Applications (1988),
    chapter 6.
    """
    count, levels = len(optimum.values), len(_AT)
    degrees = len(problem.mu) - count
    held = np.repeat(np.eye(count, dtype=bool), levels, axis=0)
    towards = (naive / np.sqrt(np.diag(naive))).T[:, np.newaxis] * _AT[:, np.newaxis]
    # beyond the bounds a constant has no meaning
    starts = np.clip(optimum.values + towards.reshape(-1, count), *problem.limits.T)
    sse = np.full(len(starts), np.nan)
    if np.isfinite(naive).all():
        _, sse = descend(problem, starts, held=held, tolerance=1e-7, near=True)
    rise = np.maximum(sse - optimum.sse, 0) * degrees / max(optimum.sse, np.finfo(float).tiny)
    z = np.sign(np.tile(_AT, count)) * np.sqrt(rise)
    middle = levels // 2
    values = np.insert(starts[held].reshape(count, levels), middle, optimum.values, axis=1)
    return values, np.insert(z.reshape(count, levels), middle, 0.0, axis=1)
