"""Levels and factors of intervals, from left-out conditions."""

import numpy as np
import pytest

from oilfilm.surface.interval import allowed_level, conformal_quantile, normal_factor


def test_few_conditions_allow_a_lower_level():
    # n / (n + 1): the rank of a new condition among n others
    assert allowed_level(0.95, 8) == pytest.approx(8 / 9)
    assert allowed_level(0.95, 12) == pytest.approx(12 / 13)
    assert allowed_level(0.95, 19) == allowed_level(0.95, 72) == 0.95
    assert allowed_level(0.8, 8) == 0.8


@pytest.mark.parametrize(("level", "factor"), [(0.8, 1.2816), (0.9, 1.6449), (0.99, 2.5758)])
def test_factor_of_a_level_is_that_of_the_tables_of_the_normal_distribution(level, factor):
    assert normal_factor(level) == pytest.approx(factor, abs=1e-4)


def test_largest_score_counts_where_conditions_are_few():
    scores = np.array([0.3, 2.0, 1.1, 0.2])
    assert conformal_quantile(scores, np.ones(4), 4, 4 / 5) == 2.0


def test_quantile_of_many_conditions_is_that_of_their_ranks():
    # 0.95 (n + 1) = 95.95 of 100: the 96th score
    scores = np.random.default_rng(1).permutation(np.arange(1.0, 101.0))
    assert conformal_quantile(scores, np.ones(100), 100, 0.95) == 96.0


def test_a_condition_with_many_points_counts_as_one_condition():
    # 39 conditions with one low score each, and one with 1000 high scores
    scores = np.concatenate([np.ones(39), np.full(1000, 9.0)])
    weights = np.concatenate([np.ones(39), np.full(1000, 1e-3)])
    assert conformal_quantile(scores, weights, 40, 0.95) == 1.0


def test_a_new_condition_is_below_the_quantile_as_often_as_promised():
    random = np.random.default_rng(2)
    held = []
    for _ in range(2000):
        scores = np.abs(random.standard_t(3, 13))
        held.append(scores[0] <= conformal_quantile(scores[1:], np.ones(12), 12, 12 / 13))
    # standard error 0.6 %
    assert np.mean(held) == pytest.approx(12 / 13, abs=0.02)
