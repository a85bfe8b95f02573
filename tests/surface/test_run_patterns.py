"""Patterns over the runs, and how well each explains the points."""

import itertools

import numpy as np
import pytest

from allocations import peak_bytes
from oilfilm.surface import run_patterns
from oilfilm.surface.effect_likelihood import EffectInformation
from oilfilm.surface.run_patterns import (
    likeliest_group,
    ln_group_counts,
    patterns_of_labels,
    patterns_over_time,
)

RUNS = 12


def information(seed, sign=1.0, runs=RUNS):
    random = np.random.default_rng(seed)
    root = random.standard_normal((runs, runs - 2))
    own = np.zeros(runs)
    if sign < 0:
        own = 1 + np.sum(root**2, axis=1) * runs
    return EffectInformation(random.standard_normal(runs), own, root, sign)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_ratios_of_all_kinds_are_those_of_their_columns(sign, monkeypatch):
    # the ten columns of the root are summed in three parts
    monkeypatch.setattr(run_patterns, "_COLUMNS_AT_ONCE", 4)
    known = information(1, sign)
    order = np.random.default_rng(2).permutation(RUNS)
    for patterns in patterns_over_time(order, 3, 4):
        ratios = patterns.twice_ln_likelihood_ratios(known, prior_precision=0.3)
        assert len(ratios) == patterns.count
        for number, ratio in enumerate(ratios):
            columns = patterns.pattern_columns(number)
            pull = known.vector @ columns
            power = columns.T @ known.matrix_times(columns) + 0.3 * np.eye(columns.shape[1])
            direct = pull @ np.linalg.inv(power) @ pull
            assert ratio == pytest.approx(direct, rel=1e-6), (patterns.kind, number)


def test_patterns_over_time_are_steps_blocks_runs_and_seasons():
    by_kind = {patterns.kind: patterns for patterns in patterns_over_time(np.arange(12), 3, 6)}
    assert by_kind["step"].pattern_columns(0)[:, 0].tolist() == [0] * 3 + [1] * 9
    assert by_kind["step"].count == 7
    # blocks of two to four runs, a third of twelve at most
    assert by_kind["block"].count == 11 + 10 + 9
    assert by_kind["run"].count == 12
    # the last season alternates from run to run
    alternating = by_kind["season"].pattern_columns(by_kind["season"].count - 1)[:, 1]
    np.testing.assert_allclose(alternating, np.tile([1, -1], 6))


@pytest.mark.slow
def test_the_likeliest_group_is_the_best_of_all_groups():
    for seed in range(5):
        known = information(seed)
        penalty = 2 * ln_group_counts(RUNS)

        def score(members, known=known, penalty=penalty):
            pattern = np.isin(np.arange(RUNS), members).astype(float)
            power = pattern @ known.matrix_times(pattern) + 0.3
            return (known.vector @ pattern) ** 2 / power - penalty[len(members)]

        groups = [
            members
            for count in range(2, RUNS // 2 + 1)
            for members in itertools.combinations(range(RUNS), count)
        ]
        found = tuple(np.flatnonzero(likeliest_group(known, prior_precision=0.3)).tolist())
        assert score(found) == pytest.approx(max(map(score, groups)))


@pytest.mark.parametrize("most_steps", [1, 2, 60])
def test_score_of_an_improved_group_is_its_own(most_steps, monkeypatch):
    monkeypatch.setattr(run_patterns, "_MAX_STEPS", most_steps)
    known = information(1)
    penalty = 2 * ln_group_counts(RUNS)
    score, is_member = run_patterns._improved_group(known, 0.3, penalty, np.arange(RUNS) < 2)
    pattern = is_member.astype(float)
    power = pattern @ known.matrix_times(pattern) + 0.3
    direct = (known.vector @ pattern) ** 2 / power - penalty[np.count_nonzero(is_member)]
    assert score == pytest.approx(direct)


def test_labels_of_the_same_runs_are_one_and_the_smaller_of_two_halves_stays():
    few = np.arange(RUNS) < 4
    one = np.arange(RUNS) == 0
    labels = {"rig b": ~few, "rig a": few, "day 1": few, "alone": one, "all": few | ~few}
    patterns = patterns_of_labels(labels)
    assert patterns.labels == ("rig a",)
    np.testing.assert_array_equal(patterns.pattern_columns(0)[:, 0], few)
    assert patterns_of_labels({}).count == 0


@pytest.mark.parametrize("runs", [300, 1200])
def test_patterns_of_many_runs_take_the_memory_of_two_roots_at_most(runs):
    # 360 features of a curve, as a large campaign has
    root = np.random.default_rng(3).standard_normal((runs, 360))
    known = EffectInformation(np.ones(runs), np.ones(runs), root, -1e-4)
    for patterns in patterns_over_time(np.arange(runs), 3, 6):
        with peak_bytes() as peak:
            patterns.twice_ln_likelihood_ratios(known, prior_precision=0.3)
        assert peak() < 2 * root.nbytes, patterns.kind
