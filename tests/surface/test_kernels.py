"""Covariance of the departure from a law, and its slopes."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.special

from oilfilm.surface.kernels import (
    ConditionBox,
    ConditionKernel,
    DepartureSizes,
    matern,
    matern_slope,
)
from oilfilm.surface.measurements import LevelWidths

WIDTHS = LevelWidths().scaled()
RANDOM = np.random.default_rng(3)
SIZES = DepartureSizes(0.4, np.array([0.5, 0.7, 0.9]), 0.3, 1.4, np.array([0.8, 1.1, 0.6]), 0.5)
NAMES = ("kappa", "main_0", "main_1", "main_2", "interaction", "length_0", "length_1", "length_2")


NO_CHANGE = np.zeros(8)


def kernel(logarithms=NO_CHANGE, level_counts=(3, 2, 4)):
    factors = np.exp(logarithms)
    box = ConditionBox(np.zeros(3), np.array([0.7, 0.3, 1.3]), np.array(level_counts), WIDTHS)
    sizes = DepartureSizes(
        SIZES.kappa * factors[0],
        SIZES.main * factors[1:4],
        SIZES.interaction * factors[4],
        SIZES.slip_length,
        SIZES.lengths * factors[5:],
        SIZES.slip_trend,
    )
    return ConditionKernel(box, sizes)


def test_matern_is_the_bessel_function_of_order_five_halves():
    distance = np.array([0.1, 0.7, 2.3])
    scaled = np.sqrt(5) * distance
    general = 2**-1.5 / scipy.special.gamma(2.5) * scaled**2.5 * scipy.special.kv(2.5, scaled)
    np.testing.assert_allclose(matern(distance), general, rtol=1e-12)


def test_slope_of_matern_is_that_of_differences():
    distance, step = np.array([0.1, 0.7, 2.3]), 1e-6
    # a longer length is a shorter scaled distance
    rise = matern(distance * np.exp(-step)) - matern(distance * np.exp(step))
    np.testing.assert_allclose(matern_slope(distance), rise / (2 * step), rtol=1e-8)


def test_slopes_by_each_size_are_those_of_differences():
    rows, step = RANDOM.uniform(-0.5, 0.5, (5, 3)), 1e-6
    slopes = kernel().slopes(rows)
    for number, name in enumerate(NAMES):
        change = step * np.eye(8)[number]
        higher, lower = kernel(change).factors(rows, rows), kernel(-change).factors(rows, rows)
        for slope, above, below in zip(slopes[name], higher, lower, strict=True):
            np.testing.assert_allclose(slope, (above - below) / (2 * step), atol=1e-9)


def test_variance_is_the_sum_of_both_factors_of_a_row_with_itself():
    rows = RANDOM.uniform(-0.5, 0.5, (5, 3))
    level, slip = kernel().factors(rows, rows)
    np.testing.assert_allclose(kernel().variances(rows), np.diag(level + slip), rtol=1e-12)


def test_the_whole_departure_is_two_to_four_times_kappa():
    """By the formula at the head of the kernels, with the medians of the priors 0.5 and 0.3."""
    box = ConditionBox(-np.ones(3), np.ones(3), np.array([3, 3, 3]), WIDTHS)
    sizes = replace(SIZES, kappa=1.0, main=np.full(3, 0.5), interaction=0.3)
    middle_and_corner = np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])
    size = np.sqrt(ConditionKernel(box, sizes).variances(middle_and_corner))
    curved = 3 * 0.5**2 + 0.3**2
    # 4, and 3 linear and 3 bilinear terms
    expected = np.sqrt([1.5 * 4 + curved, 1.5 * (4 + 3 + 3) + curved])
    np.testing.assert_allclose(size, expected, rtol=1e-12)
    # as `DepartureSizes` says
    np.testing.assert_allclose(expected, [2.6, 4.0], atol=0.05)


def test_a_condition_with_two_levels_keeps_its_bend_where_the_law_is_exact():
    exact = replace(SIZES, kappa=1e-9)
    box = kernel().box
    two_levels = ConditionKernel(box, exact)
    middle, level = np.zeros((1, 3)), np.array([[0.0, 0.15, 0.0]])
    # 3 % of mu between two levels of U, nothing at the levels
    assert np.sqrt(two_levels.variances(middle)) == pytest.approx(0.03)
    assert np.sqrt(two_levels.variances(level)) == pytest.approx(0.0, abs=1e-8)
    three_levels = ConditionBox(box.lowest, box.highest, np.array([3, 3, 4]), WIDTHS)
    assert np.sqrt(ConditionKernel(three_levels, exact).variances(middle)) < 1e-8
