"""Levels and factors of intervals, from left-out conditions."""

import numpy as np
import pytest

from lawless_truths import DENG_CONSTANTS, TRUTHS
from oilfilm.surface.interval import (
    allowed_level,
    curve_quantile,
    interval_factors,
    normal_half_width,
    point_quantile,
)
from oilfilm.surface.kernels import DepartureSizes
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.posterior import LeftOutCurves
from oilfilm.surface.reduction import box_of, reduced_curves
from oilfilm.surface.reml import CurveCovariance, Sizes
from oilfilm.traction import PAPER_LAW
from surface_campaigns import grid, simulated

ONLY_NOISE = Sizes(
    effects=np.zeros(4),
    noise=0.01,
    departure_sizes=DepartureSizes(1e-4, np.ones(3), 1.0, 1.0, np.ones(3), 1.0),
)


def test_few_conditions_allow_a_lower_level():
    # n / (n + 1): the rank of a new condition among n others
    assert allowed_level(0.95, 8) == pytest.approx(8 / 9)
    assert allowed_level(0.95, 12) == pytest.approx(12 / 13)
    assert allowed_level(0.95, 19) == allowed_level(0.95, 72) == 0.95
    assert allowed_level(0.8, 8) == 0.8


@pytest.mark.parametrize(("level", "factor"), [(0.8, 1.2816), (0.9, 1.6449), (0.99, 2.5758)])
def test_factor_of_a_level_is_that_of_the_tables_of_the_normal_distribution(level, factor):
    assert normal_half_width(level) == pytest.approx(factor, abs=1e-4)


def test_largest_score_counts_where_conditions_are_few():
    scores, condition = np.array([0.3, 2.0, 1.1, 0.2]), np.arange(4)
    assert curve_quantile(scores, condition, 4 / 5) == 2.0
    assert point_quantile(scores, condition, 4 / 5) == 2.0


def test_quantile_of_many_conditions_is_that_of_their_ranks():
    # 0.95 (n + 1) = 95.95 of 100: the 96th score
    scores = np.random.default_rng(1).permutation(np.arange(1.0, 101.0))
    assert curve_quantile(scores, np.arange(100), 0.95) == 96.0
    # one point per condition: the whole condition is inside or not
    assert point_quantile(scores, np.arange(100), 0.95) == 96.0


def test_a_condition_with_many_curves_counts_as_one_condition():
    # 39 conditions with one low score each, and one with 1000 high scores
    scores = np.concatenate([np.ones(39), np.full(1000, 9.0)])
    condition = np.concatenate([np.arange(39), np.full(1000, 39)])
    assert curve_quantile(scores, condition, 0.95) == 1.0
    assert point_quantile(scores, condition, 0.95) == 1.0


def test_a_single_wild_point_does_not_set_the_width_of_all():
    # 19 conditions with scores 0.1 to 2.0, and one point of the last condition at 9
    scores = np.tile(np.linspace(0.1, 2.0, 20), 19)
    scores[-1] = 9.0
    condition = np.repeat(np.arange(19), 20)
    # 19 of the 20 scores of each condition are up to 1.9
    assert point_quantile(scores, condition, 0.95) == pytest.approx(1.9)
    assert point_quantile(scores, condition, 0.998) == 9.0


def test_a_whole_wild_condition_sets_the_width_of_all():
    scores = np.tile(np.linspace(0.1, 2.0, 20), 19)
    scores[-20:] += 7.0
    condition = np.repeat(np.arange(19), 20)
    # a new condition may be as far off: 95 % of all need 18.1 of 20 conditions
    assert point_quantile(scores, condition, 0.95) > 7.0


@pytest.mark.parametrize("quantile", [point_quantile, curve_quantile])
def test_a_new_condition_is_below_the_quantile_as_often_as_promised(quantile):
    random = np.random.default_rng(2)
    held = []
    for _ in range(2000):
        scores = np.abs(random.standard_t(3, 13))
        held.append(scores[0] <= quantile(scores[1:], np.arange(12), 12 / 13))
    # standard error 0.6 %
    assert np.mean(held) == pytest.approx(12 / 13, abs=0.02)


def test_points_of_a_new_condition_are_inside_as_often_as_promised():
    # a quarter of the variance is common to a condition, noise has heavy tails
    random = np.random.default_rng(3)
    condition, held = np.repeat(np.arange(24), 15), []
    for _ in range(400):
        common = 0.5 * random.standard_normal((25, 1))
        scores = np.abs(common + 0.5 * random.standard_t(3, (25, 15)))
        limit = point_quantile(scores[:-1].ravel(), condition, 0.95)
        held.append(np.mean(scores[-1] <= limit))
    # standard error 0.4 %; the worst condition makes it cautious
    assert 0.945 <= np.mean(held) <= 0.98


def test_band_of_independent_errors_is_that_of_their_largest():
    # four slips with errors of noise only: 0.95^(1/4) of each, 2.49 standard deviations
    random = np.random.default_rng(4)
    conditions = grid((1.0, 1.25, 1.5), (25.0, 32.0, 40.0), (25.0, 72.0, 120.0))
    slips = np.array([0.01, 0.03, 0.1, 0.3])
    measured = simulated(TRUTHS["own"], conditions, random, slips=slips).in_canonical_order()
    law = FreeLaw(PAPER_LAW, DENG_CONSTANTS, np.ones(12, dtype=bool))
    box = box_of(measured)
    covariance = CurveCovariance(
        reduced_curves(measured, law, law.log_mu, 4e-5, box), box, ONLY_NOISE
    )
    left_out = []
    for curve in range(len(conditions)):
        coordinates = np.flatnonzero(covariance.curves.curve_of_coordinate == curve)
        left_out.append(LeftOutCurves(coordinates, np.eye(4) / ONLY_NOISE.noise**2, np.zeros(4)))
    numbers = np.arange(len(conditions))
    factors = interval_factors(covariance, measured.curve_of_point, numbers, left_out, 0.95)
    assert factors.point == pytest.approx(1.96, abs=0.001)
    assert factors.curve == pytest.approx(2.49, abs=0.03)
