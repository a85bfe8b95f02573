"""Errors of the constants: by the Jacobian, a bootstrap over curves, calibration, and profiles.

Decides: the standard errors of constants, by bootstrap or, with few curves, cluster-robust; their
errors from the calibration of the rig.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pandas as pd

from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.fits.descent import descend
from oilfilm.fits.global_search import Optimum, converge
from oilfilm.fits.problem import Problem, build_problem, curve_data

# Relative decrease of the SSE at which a refit ends. A refit is one draw from a distribution:
# further digits would not show.
_REFIT_TOLERANCE = 1e-8
# Relative decrease of the SSE at which a descent for a profile ends, with one constant held.
_PROFILE_TOLERANCE = 1e-7
_DRAWS_PER_BATCH = 100
# Largest leverage of a curve that is taken. A curve that alone decides a direction of the constants
# has the leverage 1 and no residual there.
_LARGEST_LEVERAGE = 1 - 1e-6
# Values at which a profile holds each constant, in naive standard errors from its optimum.
_PROFILE_LEVELS = np.array([-4.0, -3.0, -2.0, -1.5, -1.0, -0.5, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0])
# Names of the sensors, in the order of the refits by their calibration.
SENSORS = ("load", "traction force", "entrainment speed", "inlet temperature")


@dataclass(frozen=True)
class Estimates:
    """Fitted quantities, as the free constants, with their uncertainties.

    Attributes:
        values: The quantities at the optimum, shape (n,).
        naive_covariance: Covariance of the quantities if all points had independent errors, shape
            (n, n).
        refits: The quantities in each refit of the bootstrap over curves, or drawn from the
            cluster-robust covariance; shape (refits, n).
        shifted_refits: The quantities refitted with one sensor off by its calibration's standard
            uncertainty, one row per sensor, shape (sensors, n); no rows where the uncertainty is
            not known.
    """

    values: FloatArray
    naive_covariance: FloatArray
    refits: FloatArray
    shifted_refits: FloatArray

    @property
    def refit_covariance(self) -> FloatArray:
        """Covariance of the refits, shape (n, n); NaN where there are none."""
        if not len(self.refits):
            return np.full_like(self.naive_covariance, np.nan)
        return np.atleast_2d(np.cov(self.refits, rowvar=False))

    @property
    def correlation(self) -> FloatArray:
        """Correlation matrix of the refits, or that of `naive_covariance` where there are none.

        NaN for a quantity without spread.
        """
        covariance = self.refit_covariance if len(self.refits) else self.naive_covariance
        variances = np.diag(covariance)
        errors = np.sqrt(np.where(variances > 0, variances, np.nan))
        return np.asarray(covariance / np.outer(errors, errors))

    def in_equation_form(self, problem: Problem) -> "Estimates":
        """The same for constants in the form of the law's equation, from internal constants."""
        values = problem.in_equation_form(self.values)
        # d X0 / d ln|X0| = X0
        slopes = np.where(problem.signs, values, 1.0)
        return Estimates(
            values=values,
            naive_covariance=self.naive_covariance * np.outer(slopes, slopes),
            refits=problem.in_equation_form(self.refits),
            shifted_refits=problem.in_equation_form(self.shifted_refits),
        )


def naive_covariance(problem: Problem, optimum: Optimum) -> FloatArray:
    """Covariance of the free internal constants if all points had independent errors.

        s^2 (J^T J)^-1,  s^2 = SSE / (points - constants)

    It is too small where a run's points share an error (load, temperature).

    Returns:
        Shape (free, free). NaN where the data leave no degree of freedom or the Jacobian is
        singular.
    """
    jacobian = problem.jacobian(optimum.constants)
    point_count, constant_count = jacobian.shape
    residual_freedom = point_count - constant_count
    if residual_freedom <= 0 or _is_singular(jacobian):
        return np.full((constant_count, constant_count), np.nan)
    _, triangle = np.linalg.qr(jacobian)
    inverse_triangle = np.linalg.inv(triangle)
    return np.asarray(optimum.sse / residual_freedom * inverse_triangle @ inverse_triangle.T)


def _is_singular(jacobian: FloatArray) -> bool:
    """Whether the points do not determine all constants; the shape is (points, free)."""
    return bool(np.linalg.matrix_rank(jacobian) < jacobian.shape[1])


def curve_bootstrap(
    problem: Problem, optimum: Optimum, refit_count: int, random: np.random.Generator
) -> FloatArray:
    """Refits of the bootstrap over curves: whole curves are resampled with replacement.

    Points of a run share its calibration and control errors. Resampling runs instead of points
    keeps these errors together. A sample whose curves do not determine all exponents is replaced.

    Args:
        problem: What was fitted.
        optimum: Where it ended.
        refit_count: Number of refits.
        random: Draws the curves.

    Returns:
        Free internal constants, shape (refits, free).

    Reference: B. Efron, R. J. Tibshirani, An Introduction to the Bootstrap (1993), chapter 8.
    """
    curve_counts = draw_curves(problem.observations.design, refit_count, random)
    weights = curve_counts.astype(float)
    starts = np.tile(optimum.constants, (refit_count, 1))
    ends, _ = descend(problem, starts, weights=weights, tolerance=_REFIT_TOLERANCE, use_newton=True)
    return ends


def cluster_robust_covariance(problem: Problem, optimum: Optimum) -> FloatArray:
    """Covariance of the free internal constants by the residuals of whole curves, for few curves.

        V = (J^T J)^-1 [sum J_i^T A_i r_i r_i^T A_i J_i] (J^T J)^-1,  A_i = (I - H_ii)^(-1/2)

    r_i are the residuals of curve i and H_ii its block of J (J^T J)^-1 J^T. The fit makes the
    residuals of a curve with much leverage smaller, and A_i corrects for that. A bootstrap over
    few curves leaves conditions out, so that refits run away; this covariance has no such error.

    Returns:
        Shape (free, free). NaN where the Jacobian is singular.

    Reference: R. M. Bell, D. F. McCaffrey, Survey Methodology 28 (2002) 169 (CR2).
    """
    root = _covariance_root(problem, optimum)
    return np.asarray(root @ root.T)


def _covariance_root(problem: Problem, optimum: Optimum) -> FloatArray:
    """R with R R^T = `cluster_robust_covariance`, one column per curve, shape (free, curves)."""
    jacobian = problem.jacobian(optimum.constants)
    if _is_singular(jacobian):
        return np.full((jacobian.shape[1], problem.curve_count), np.nan)
    orthonormal, triangle = np.linalg.qr(jacobian)
    residual = problem.residual(optimum.constants)
    scores = []
    for first_point, point_count in zip(
        problem.first_point_of_curve, problem.point_counts, strict=True
    ):
        points = slice(first_point, first_point + point_count)
        leverage, directions = np.linalg.eigh(orthonormal[points].T @ orthonormal[points])
        # Q_i^T (I - Q_i Q_i^T)^(-1/2) r_i, along the eigenvectors of Q_i^T Q_i
        factors = 1 / np.sqrt(1 - np.clip(leverage, 0, _LARGEST_LEVERAGE))
        projections = directions.T @ (orthonormal[points].T @ residual[points])
        scores.append(directions @ (factors * projections))
    return np.asarray(np.linalg.solve(triangle, np.array(scores).T))


def cluster_robust_draws(
    problem: Problem, optimum: Optimum, draw_count: int, random: np.random.Generator
) -> FloatArray:
    """Constants drawn about the optimum from `cluster_robust_covariance`, within the law's bounds.

    Args:
        problem: What was fitted.
        optimum: Where it ended.
        draw_count: Number of draws.
        random: Source of the draws.

    Returns:
        Free internal constants, shape (draws, free). No rows where the Jacobian is singular: some
        constants could have any value.
    """
    # not along eigenvectors, whose signs depend on the BLAS kernel
    root = _covariance_root(problem, optimum)
    if np.isnan(root).any():
        return np.empty((0, len(optimum.constants)))
    draws = optimum.constants + random.standard_normal((draw_count, problem.curve_count)) @ root.T
    low, high = problem.free_bounds.T
    return np.clip(draws, low, high)


def draw_curves(design: FloatArray, resample_count: int, random: np.random.Generator) -> IndexArray:
    """How often each curve is in each resample of the bootstrap.

    A resample must determine as many terms of the power laws as all curves do.

    Args:
        design: Shape (curves, terms).
        resample_count: Number of resamples.
        random: Source of the draws.

    Returns:
        Shape (resamples, curves).
    """
    curve_count = len(design)
    probabilities = np.full(curve_count, 1 / curve_count)
    rank = np.linalg.matrix_rank(design)
    accepted_draws = np.empty((0, curve_count), dtype=np.int64)
    while len(accepted_draws) < resample_count:
        batch_size = min(resample_count - len(accepted_draws), _DRAWS_PER_BATCH)
        draws = random.multinomial(curve_count, probabilities, batch_size)
        drawn_designs = np.where(draws[:, :, np.newaxis] > 0, design, 0.0)
        has_full_rank = np.linalg.matrix_rank(drawn_designs) == rank
        accepted_draws = np.concatenate([accepted_draws, draws[has_full_rank]])
    return accepted_draws


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
        followed_conditions = data.conditions[:, problem.is_followed_condition]
        if not (np.isfinite(data.mu).all() and np.isfinite(followed_conditions).all()):
            return np.empty((0, len(optimum.constants)))
        problem_of_shifted_points = build_problem(problem.law, data, problem.is_followed_condition)
        # the same constants are free and held
        shifted_problem = replace(
            problem,
            observations=problem_of_shifted_points.observations,
            mu=problem_of_shifted_points.mu,
        )
        refits.append(converge(shifted_problem, optimum.constants).constants)
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
    """Profile of each free constant; shapes (free, values), the optimum in the middle.

    Values do not fall along a profile. Those at a bound are repeated.

    Attributes:
        held_values: Internal values at which the constant is held.
        signed_root: z of the function `profiles` at these values.
    """

    held_values: FloatArray
    signed_root: FloatArray


def profiles(problem: Problem, optimum: Optimum, naive_covariance: FloatArray) -> Profiles:
    """Values of each free internal constant and the signed root of the SSE's rise there.

        z = sign(x - x_best) sqrt((SSE(x) - SSE_best) / s^2),  s^2 = SSE_best / (points - constants)

    For a linear law z is the distance in naive standard errors. Where z bends away from that, naive
    standard errors mislead. Like them, z assumes that all points have independent errors.

    Args:
        problem: What was fitted.
        optimum: Where it ended.
        naive_covariance: Naive covariance of the free internal constants. It gives the start of the
            constants that are not held.

    Returns:
        The profiles, NaN beside the optimum where naive standard errors are not known or zero.

    Reference: D. M. Bates, D. G. Watts, Nonlinear Regression Analysis and Its Applications (1988),
    chapter 6.
    """
    constant_count = len(optimum.constants)
    level_count = len(_PROFILE_LEVELS)
    residual_freedom = len(problem.mu) - constant_count
    is_held = np.repeat(np.eye(constant_count, dtype=bool), level_count, axis=0)
    naive_errors = np.sqrt(np.diag(naive_covariance))
    # an exact fit has no errors, and so no levels at which a constant is held
    naive_errors = np.where(naive_errors > 0, naive_errors, np.nan)
    # change of all constants per naive standard error of the one that is held
    directions = (naive_covariance / naive_errors).T
    changes = directions[:, np.newaxis] * _PROFILE_LEVELS[:, np.newaxis]
    # beyond the bounds a constant has no meaning
    low, high = problem.free_bounds.T
    starts = np.clip(optimum.constants + changes.reshape(-1, constant_count), low, high)
    sse = np.full(len(starts), np.nan)
    if np.isfinite(directions).all():
        _, sse = descend(
            problem, starts, is_held=is_held, tolerance=_PROFILE_TOLERANCE, use_newton=True
        )
    rise = (
        np.maximum(sse - optimum.sse, 0) * residual_freedom / max(optimum.sse, np.finfo(float).tiny)
    )
    signed_roots = np.sign(np.tile(_PROFILE_LEVELS, constant_count)) * np.sqrt(rise)
    middle = level_count // 2
    held_values = np.insert(
        starts[is_held].reshape(constant_count, level_count), middle, optimum.constants, axis=1
    )
    signed_root = np.insert(signed_roots.reshape(constant_count, level_count), middle, 0.0, axis=1)
    return Profiles(held_values, signed_root)
