"""Errors that a whole curve shares: what each does to mu, and how large they were."""

from dataclasses import replace

import numpy as np
import pytest

from fit_points import LAW, problem_of
from oilfilm.base.randomness import generator
from oilfilm.fits.measured_curves import (
    CURVE_ERRORS,
    ErrorVariances,
    curve_error_slopes,
    error_variances,
    precision_by_curve,
)
from oilfilm.traction import LAWS
from planned_tests import SMALL_PLAN, TRUE_CONSTANTS, Errors, curves_at, run_tests

NONE = Errors(0, 0, 0, 0, 0, 0)
FIELDS = ("load", "force", "speed", "temperature_c", "zero_n")
LARGE = [(p, u, t) for p in (1.0, 1.25, 1.5) for u in (25.0, 32.0, 40.0) for t in (25.0, 60, 110)]


@pytest.mark.parametrize("number", range(len(CURVE_ERRORS)), ids=CURVE_ERRORS)
def test_effect_is_what_a_rig_with_that_error_would_read(number: int) -> None:
    """The simulated rig runs at the true conditions; `curve_error_slopes` has slopes of the law."""
    curves = curves_at(SMALL_PLAN)
    size = 1e-4
    random = generator(3, "effect", number)
    points = run_tests(SMALL_PLAN, random, replace(NONE, **{FIELDS[number]: size}))
    drawn = generator(3, "effect", number).standard_normal((len(SMALL_PLAN), 5))[:, number]
    difference = points["traction_coefficient"] - LAW.traction(
        TRUE_CONSTANTS, curves.observations(LAW)
    )
    expected = (
        size
        * drawn[curves.curve_of_point]
        * curve_error_slopes(LAW, TRUE_CONSTANTS, curves)[:, number]
    )
    np.testing.assert_allclose(difference, expected, atol=2e-3 * np.abs(expected).max())


def test_an_error_of_the_temperature_counts_at_0_degc_as_near_it() -> None:
    law = LAWS["deng-exponential"]
    slopes = []
    for temperature_c in (0.0, 0.1):
        curves = curves_at([(1.25, 30.0, temperature_c)])
        slopes_by_error = curve_error_slopes(law, TRUE_CONSTANTS, curves).T
        slopes.append(slopes_by_error[CURVE_ERRORS.index("inlet temperature")])
    at_zero, near_zero = slopes
    assert np.abs(at_zero).max() > 0
    np.testing.assert_allclose(at_zero, near_zero, atol=0.01 * np.abs(near_zero).max())


@pytest.mark.slow
def test_planted_sizes_of_errors_are_found_from_residuals() -> None:
    """Mean variances over 24 simulated campaigns: as planted, within four standard errors."""
    planted = replace(Errors(), force=0.0, speed=0.0)
    found = []
    for number in range(24):
        problem = problem_of(run_tests(LARGE, generator(number, "sizes"), planted))
        slopes = problem.jacobian(TRUE_CONSTANTS)
        fitted = TRUE_CONSTANTS - np.linalg.lstsq(slopes, problem.residual(TRUE_CONSTANTS))[0]
        effect = curve_error_slopes(LAW, fitted, curves_at(LARGE))
        residual = -problem.residual(fitted)
        sizes = error_variances(
            problem.jacobian(fitted), effect, residual, problem.observations.curve_of_point
        )
        found.append([*sizes.curve_variances, sizes.point_variance])
    error = np.std(found, axis=0, ddof=1) / np.sqrt(len(found))
    truth = np.array([*planted.of_curve, planted.point]) ** 2
    assert (np.abs(np.mean(found, axis=0) - truth) <= 4 * error).all()
    # four standard errors are no more than a third of the variances that were planted
    assert (4 * error[truth > 0] < truth[truth > 0] / 3).all()


def test_a_curve_of_many_points_is_one_draw_of_its_errors() -> None:
    """1/(v + s^2/sum d^2) of a parameter that acts as the run's error: s^2 shrinks, v stays."""
    curves = curves_at(SMALL_PLAN[:1])
    effect = curve_error_slopes(LAW, TRUE_CONSTANTS, curves)
    effect[:, 1:] = 0.0
    sizes = ErrorVariances(np.array([1e-6, 0, 0, 0, 0]), 1e-10)
    for times in (1, 2, 100):
        d = np.repeat(effect, times, axis=0)
        told = precision_by_curve(d[:, :1], d, sizes, np.zeros(len(d), dtype=int))[0, 0, 0]
        assert told == pytest.approx(1 / (1e-6 + 1e-10 / np.sum(d**2)), rel=1e-9)
    assert told == pytest.approx(1e6, rel=1e-3)
