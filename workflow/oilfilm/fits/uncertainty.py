"""Errors of the constants: by the Jacobian, a bootstrap over curves, calibration, and profiles.

Decides: the standard errors of constants, by bootstrap or, below 20 curves, cluster-robust; their
errors from the calibration of the rig.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pandas as pd

from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.fits.descent import descend
from oilfilm.fits.engine import Optimum, polish
from oilfilm.fits.problem import Problem, build_problem, curve_data

# Relative decrease of the SSE at which a refit ends: a refit is one draw of a spread, and further
# digits are never seen.
_REFIT_TOLERANCE = 1e-8
# The same of a descent with one constant held, for a profile.
_PROFILE_TOLERANCE = 1e-7
_DRAWS_PER_BATCH = 100
# A curve that alone decides a direction has no residual there: its leverage is cut off here.
_LARGEST_LEVERAGE = 1 - 1e-6
# Values at which a profile holds each constant, in naive standard errors from its optimum.
_PROFILE_LEVELS = np.array([-4.0, -3.0, -2.0, -1.5, -1.0, -0.5, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0])
# Sensors in the order of the refits by their calibration.
SENSORS = ("load", "traction force", "entrainment speed", "inlet temperature")


@dataclass(frozen=True)
class Estimates:
    """Fitted quantities with their uncertainties.

    Attributes:
        values: The quantities at the optimum, shape (n,).
        naive: Their covariance if all points had independent errors, shape (n, n).
        refits: The quantities in each refit of the bootstrap over curves, or drawn from the
            cluster-robust covariance; shape (refits, n).
        shifted: The quantities refitted with one sensor off by its calibration's standard
            uncertainty, one row per sensor, shape (sensors, n); no rows where the uncertainty is
            not known.
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
        variances = np.diag(covariance)
        errors = np.sqrt(np.where(variances > 0, variances, np.nan))
        return np.asarray(covariance / np.outer(errors, errors))

    def reported(self, problem: Problem) -> "Estimates":
        """The same for constants in the form of the law's equation, from internal constants."""
        values = problem.reported(self.values)
        # d X0 / d ln|X0| = X0
        slopes = np.where(problem.signs, values, 1.0)
        return Estimates(
            values=values,
            naive=self.naive * np.outer(slopes, slopes),
            refits=problem.reported(self.refits),
            shifted=problem.reported(self.shifted),
        )


def naive_covariance(problem: Problem, optimum: Optimum) -> FloatArray:
    """Covariance of the free internal constants if all points had independent errors.

        s^2 (J^T J)^-1,  s^2 = SSE / (points - constants)

    It is too small where a run's points share an error (load, temperature).

    Returns:
        Shape (free, free). NaN where the data leave no degree of freedom or the Jacobian is
        singular.
    """
    jacobian = problem.jacobian(optimum.values)
    points, constants = jacobian.shape
    residual_freedom = points - constants
    if residual_freedom <= 0 or np.linalg.matrix_rank(jacobian) < constants:
        return np.full((constants, constants), np.nan)
    _, upper = np.linalg.qr(jacobian)
    inverse = np.linalg.inv(upper)
    return np.asarray(optimum.sse / residual_freedom * inverse @ inverse.T)


def curve_bootstrap(
    problem: Problem, optimum: Optimum, refits: int, random: np.random.Generator
) -> FloatArray:
    """Refits of the bootstrap over curves: whole curves are resampled with replacement.

    Points of a run share its calibration and control errors. Resampling runs instead of points
    keeps these errors together. A sample whose curves do not determine all exponents is replaced.

    Args:
        problem: What was fitted.
        optimum: Where it ended.
        refits: Number of refits.
        random: Draws the curves.

    Returns:
        Free internal constants, shape (refits, free).

    Reference: B. Efron, R. J. Tibshirani, An Introduction to the Bootstrap (1993), chapter 8.
    """
    draws = draw_curves(problem.observations.design, refits, random)
    weights = draws.astype(float)
    starts = np.tile(optimum.values, (refits, 1))
    ends, _ = descend(
        problem, starts, weights=weights, tolerance=_REFIT_TOLERANCE, starts_near_ends=True
    )
    return ends


def robust_covariance(problem: Problem, optimum: Optimum) -> FloatArray:
    """Covariance of the free internal constants by the residuals of whole curves, for few curves.

        V = (J^T J)^-1 [sum J_i^T A_i r_i r_i^T A_i J_i] (J^T J)^-1,  A_i = (I - H_ii)^(-1/2)

    r_i are the residuals of curve i and H_ii its block of J (J^T J)^-1 J^T. The fit makes the
    residuals of a curve with much leverage smaller, and A_i corrects for that. A bootstrap over
    few curves leaves conditions out, so that refits run away; this covariance has no such error.

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
    """Constants drawn about the optimum from `robust_covariance`, within the law's bounds.

    Args:
        problem: What was fitted.
        optimum: Where it ended.
        count: Number of draws.
        random: Source of the draws.

    Returns:
        Free internal constants, shape (count, free).
    """
    # not along eigenvectors, whose signs depend on the BLAS kernel
    root = _root_of_covariance(problem, optimum)
    draws = optimum.values + random.standard_normal((count, problem.curves)) @ root.T
    low, high = problem.limits.T
    return np.clip(draws, low, high)


def draw_curves(design: FloatArray, count: int, random: np.random.Generator) -> IndexArray:
    """How often each curve is in each resample; a resample determines as many terms as all curves.

    Args:
        design: Shape (curves, terms).
        count: Number of resamples.
        random: Source of the draws.

    Returns:
        Shape (count, curves).
    """
    curves = len(design)
    probability = np.full(curves, 1 / curves)
    rank = np.linalg.matrix_rank(design)
    accepted = np.empty((0, curves), dtype=np.int64)
    while len(accepted) < count:
        batch = min(count - len(accepted), _DRAWS_PER_BATCH)
        draws = random.multinomial(curves, probability, batch)
        drawn_designs = np.where(draws[:, :, np.newaxis] > 0, design, 0.0)
        has_full_rank = np.linalg.matrix_rank(drawn_designs) == rank
        accepted = np.concatenate([accepted, draws[has_full_rank]])
    return accepted


# ---------------------------------------------------------------- calibration


def calibration_refits(problem: Problem, optimum: Optimum, points: pd.DataFrame) -> FloatArray:
    """The free constants refitted with each sensor off by its standard uncertainty.

    All points of a rig share such an error, so one sensor at a time is shifted at all points. The
    root of the summed squares of the constants' changes is their systematic standard error.

    Args:
        problem: What was fitted.
        optimum: Where it ended.
        points: The oil's rows of the table of points.

    Returns:
        Free internal constants, one row per sensor in the order of SENSORS; no rows where the
        calibration of a sensor is not stated.
    """
    accepted = points[points["accepted"]]
    refits = []
    for shifted_points in _points_with_shifted_sensors(accepted):
        data = curve_data(shifted_points, problem.law.conditions)
        varied_conditions = data.conditions[:, problem.varied]
        if not (np.isfinite(data.mu).all() and np.isfinite(varied_conditions).all()):
            return np.empty((0, len(optimum.values)))
        shifted = build_problem(problem.law, data, problem.varied)
        # the same constants are free and held
        shifted_problem = replace(problem, observations=shifted.observations, mu=shifted.mu)
        refits.append(polish(shifted_problem, optimum.values).values)
    return np.array(refits)


def _points_with_shifted_sensors(points: pd.DataFrame) -> list[pd.DataFrame]:
    """The points as measured with one sensor off by its standard uncertainty, for each sensor.

    A load of (1 + e) W makes mu = F/W smaller by 1/(1 + e). It makes the pressure, which goes with
    the cube root of the load, larger.
    """
    load_factor = 1 + points["load_systematic_n"] / points["load_n"]
    force_error = points["traction_force_systematic_n"] / points["traction_force_n"].abs()
    # a force of zero has no relative error
    force_factor = 1 + force_error.where(points["traction_force_n"] != 0, 0.0)
    mu = points["traction_coefficient"]
    pressure = points["max_hertz_pressure_gpa"]
    speed = points["entrainment_speed_m_s"]
    temperature = points["inlet_temperature_c"]
    return [
        points.assign(
            traction_coefficient=mu / load_factor,
            max_hertz_pressure_gpa=pressure * np.cbrt(load_factor),
            load_n=points["load_n"] * load_factor,
        ),
        points.assign(traction_coefficient=mu * force_factor),
        # an error of speed that both bodies share leaves the slide-roll ratio as it is
        points.assign(entrainment_speed_m_s=speed + points["entrainment_speed_systematic_m_s"]),
        points.assign(inlet_temperature_c=temperature + points["inlet_temperature_systematic_c"]),
    ]


# ---------------------------------------------------------------- profiles


class Profiles(NamedTuple):
    """Profile of each free constant; shapes (free, levels), ascending, the optimum in the middle.

    Attributes:
        values: Internal values at which the constant is held.
        signed_root: z of `profiles` at these values.
    """

    values: FloatArray
    signed_root: FloatArray


def profiles(problem: Problem, optimum: Optimum, naive: FloatArray) -> Profiles:
    """Values of each free internal constant and the signed root of the SSE's rise there.

        z = sign(x - x_best) sqrt((SSE(x) - SSE_best) / s^2),  s^2 = SSE_best / (points - constants)

    For a linear law z is the distance in naive standard errors. Where z bends away from that, naive
    standard errors mislead. Like them, z assumes that all points have independent errors.

    Args:
        problem: What was fitted.
        optimum: Where it ended.
        naive: Naive covariance of the free internal constants. It gives the start of the constants
            that are not held.

    Reference: D. M. Bates, D. G. Watts, Nonlinear Regression Analysis and Its Applications (1988),
    chapter 6.
    """
    count = len(optimum.values)
    level_count = len(_PROFILE_LEVELS)
    residual_freedom = len(problem.mu) - count
    held = np.repeat(np.eye(count, dtype=bool), level_count, axis=0)
    # change of all constants per naive standard error of the one that is held
    directions = (naive / np.sqrt(np.diag(naive))).T
    changes = directions[:, np.newaxis] * _PROFILE_LEVELS[:, np.newaxis]
    # beyond the bounds a constant has no meaning
    low, high = problem.limits.T
    starts = np.clip(optimum.values + changes.reshape(-1, count), low, high)
    sse = np.full(len(starts), np.nan)
    if np.isfinite(naive).all():
        _, sse = descend(
            problem, starts, held=held, tolerance=_PROFILE_TOLERANCE, starts_near_ends=True
        )
    rise = (
        np.maximum(sse - optimum.sse, 0) * residual_freedom / max(optimum.sse, np.finfo(float).tiny)
    )
    z = np.sign(np.tile(_PROFILE_LEVELS, count)) * np.sqrt(rise)
    middle = level_count // 2
    values = np.insert(starts[held].reshape(count, level_count), middle, optimum.values, axis=1)
    signed_root = np.insert(z.reshape(count, level_count), middle, 0.0, axis=1)
    return Profiles(values, signed_root)
