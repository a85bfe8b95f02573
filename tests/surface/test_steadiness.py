"""Changes of a rig over its runs."""

import functools
from dataclasses import replace

import numpy as np
import pytest

from lawless_truths import TRUTHS
from nights import quick_ones
from oilfilm.surface.steadiness import (
    ChangeSizes,
    SteadinessLimits,
    largest_change,
    smallest_visible_changes,
    smallest_visible_size,
)
from oilfilm.surface.surface import fit_surface
from surface_campaigns import fitted_law, latin, random_conditions, simulated

SLIPS = np.geomspace(0.002, 0.3, 9)
RUNS = 24
# 24 conditions in the order of the plan, measured in a random order of time.
TIME = np.random.default_rng(40).permutation(RUNS)


def campaign(gain_of_run, truth="jt", seed=41, conditions=None):
    """The points, with the force of each run multiplied by a gain, in canonical order."""
    conditions = latin() if conditions is None else conditions
    clean = simulated(TRUTHS[truth], conditions, np.random.default_rng(seed), slips=SLIPS)
    measured = replace(clean, mu=clean.mu * gain_of_run[clean.curve_of_point])
    curves, _ = measured.canonical_order()
    return measured.in_canonical_order(), curves


def covariance_of(measured):
    return fit_surface(measured, fitted_law(measured)).misfit_covariance


@pytest.fixture(scope="module")
def steady():
    """A campaign without a change: its points, its order and its covariance."""
    measured, curves = campaign(np.ones(RUNS))
    return measured, curves, covariance_of(measured)


@functools.cache
def with_late_step(truth):
    """5 % more force from run 14 on: the order and the covariance."""
    measured, curves = campaign(np.where(TIME >= 14, 1.05, 1.0), truth)
    return curves, covariance_of(measured)


@pytest.mark.slow
def test_a_steady_campaign_raises_no_alarm(steady):
    _, curves, covariance = steady
    change = largest_change(covariance, TIME[curves])
    assert change is not None
    assert not change.is_alarm


@pytest.mark.slow
@pytest.mark.parametrize("truth", quick_ones(["jt", "own"], ["jt"]))
def test_a_step_of_the_force_is_named_with_its_runs_whether_or_not_a_law_is_true(truth):
    curves, covariance = with_late_step(truth)
    change = largest_change(covariance, TIME[curves])
    assert change.is_alarm
    assert (change.effect_name, change.kind) == ("gain", "step")
    np.testing.assert_array_equal(change.pattern, TIME[curves] >= 14)
    # 5 % of force; the standard error of the difference of 14 and 10 runs is 0.8 %/sqrt(5.8)
    assert change.size == pytest.approx(np.log(1.05), abs=0.015)


@pytest.mark.nightly
def test_the_fewer_runs_are_suspect_when_a_step_comes_early():
    measured, curves = campaign(np.where(TIME >= 8, 1.05, 1.0))
    change = largest_change(covariance_of(measured), TIME[curves])
    assert change.is_alarm
    np.testing.assert_array_equal(change.pattern, TIME[curves] < 8)
    assert change.size == pytest.approx(-np.log(1.05), abs=0.015)


@pytest.mark.slow
def test_a_temperature_that_follows_day_and_night_is_a_season():
    clean = simulated(TRUTHS["own"], latin(), np.random.default_rng(42), slips=SLIPS)
    day = np.sin(2 * np.pi * TIME / 8)
    # the contact is warmer by day than the label says
    warm = latin() + np.outer(day, [0, 0, 6.0])
    measured = simulated(TRUTHS["own"], warm, np.random.default_rng(42), slips=SLIPS)
    measured = replace(measured, conditions=clean.conditions)
    curves, _ = measured.canonical_order()
    change = largest_change(covariance_of(measured.in_canonical_order()), TIME[curves])
    assert change.is_alarm
    assert (change.effect_name, change.kind) == ("temperature_k", "season")
    assert change.size == pytest.approx(6.0, abs=1.5)
    assert np.corrcoef(change.pattern, day[curves])[0, 1] > 0.95


@pytest.mark.slow
def test_runs_that_nothing_but_mu_tells_apart_are_named():
    some = np.isin(np.arange(RUNS), [1, 5, 7, 10, 14, 15, 20, 22])
    measured, curves = campaign(np.where(some, 0.9, 1.0), "own")
    change = largest_change(covariance_of(measured), TIME[curves])
    assert change.is_alarm
    assert (change.effect_name, change.kind) == ("gain", "group")
    np.testing.assert_array_equal(change.pattern, some[curves])
    assert change.size == pytest.approx(np.log(0.9), abs=0.02)


@pytest.mark.slow
def test_a_label_makes_a_smaller_change_visible():
    # 3 % in every third run is too little for a group without a label
    some = np.arange(RUNS) % 3 == 1
    measured, curves = campaign(np.where(some, 0.965, 1.0))
    covariance = covariance_of(measured)
    unnamed = largest_change(covariance, TIME[curves])
    labels = {"ball=B7": some[curves], "ball=B8": ~some[curves], "day=1": TIME[curves] < 12}
    named = largest_change(covariance, TIME[curves], labels)
    assert not (unnamed.is_alarm and np.array_equal(unnamed.pattern, some[curves]))
    assert named.is_alarm
    assert (named.effect_name, named.kind, named.label) == ("gain", "label", "ball=B7")
    np.testing.assert_array_equal(named.pattern, some[curves])


@pytest.mark.nightly
def test_a_label_names_its_runs_even_if_they_are_the_most():
    some = np.arange(RUNS) % 3 != 1
    measured, curves = campaign(np.where(some, 0.93, 1.0))
    change = largest_change(covariance_of(measured), TIME[curves], {"ball=B7": some[curves]})
    assert change.label == "ball=B7"
    np.testing.assert_array_equal(change.pattern, some[curves])


@pytest.mark.slow
def test_sizes_that_no_rig_has_are_no_cause():
    curves, covariance = with_late_step("jt")
    tiny = ChangeSizes(gain=0.01, zero=1e-6, slip_scale=0.001, temperature_k=0.1)
    change = largest_change(covariance, TIME[curves], limits=SteadinessLimits(largest=tiny))
    assert change is None or abs(change.size) <= tiny.size_of(change.effect_name)


def test_a_trend_in_the_order_of_a_condition_is_seen_when_it_is_large_only(steady):
    measured, curves, covariance = steady
    by_pressure = np.argsort(np.argsort(measured.conditions[:, 0]))
    at_random = smallest_visible_changes(covariance, TIME[curves])
    in_order = smallest_visible_changes(covariance, by_pressure)
    # a trial: 3 % in random order, 26 to 46 % in the order of the condition
    assert in_order.trend["gain"] > 2 * at_random.trend["gain"]


def test_a_step_of_the_smallest_size_is_seen_wherever_it_begins():
    measured, _ = campaign(np.ones(RUNS), "own")
    covariance = covariance_of(measured)
    order = np.argsort(np.argsort(measured.conditions[:, 0], kind="stable"))
    smallest = smallest_visible_changes(covariance, order).step["gain"]
    # three runs on either side at least
    by_begin = [
        smallest_visible_size(covariance, "gain", (order >= begin).astype(float))
        for begin in range(3, 22)
    ]
    assert smallest == pytest.approx(max(by_begin))
    # a step with the pressure resembles the effect of the pressure
    is_first_of_level = np.diff(np.sort(measured.conditions[:, 0]), prepend=-1.0) > 0
    assert is_first_of_level[3 + int(np.argmax(by_begin))]
    middle = RUNS // 2 - 3
    assert smallest > 1.05 * by_begin[middle]


@pytest.mark.slow
def test_a_wrong_law_in_the_order_of_a_condition_is_no_huge_trend():
    # without a size before the data: the slip reads wrong by 26 %, score 21
    measured = simulated(TRUTHS["pw"], latin(), np.random.default_rng(50), slips=SLIPS)
    change = largest_change(covariance_of(measured.in_canonical_order()), np.arange(RUNS))
    assert not change.is_alarm


@pytest.mark.nightly
def test_changes_of_the_smallest_size_are_named_and_of_half_of_it_are_not():
    measured, curves = campaign(np.ones(RUNS), "own")
    order = TIME[curves]
    size = smallest_visible_changes(covariance_of(measured), order).step["gain"]
    named = []
    for factor in (0.3, 2.0):
        gains = np.where(TIME >= 12, np.exp(factor * size), 1.0)
        changed, _ = campaign(gains, "own")
        change = largest_change(covariance_of(changed), order)
        named.append(change.is_alarm)
    assert named == [False, True]


@pytest.mark.nightly
def test_a_campaign_of_many_runs_is_judged_as_well():
    runs = 120
    time = np.random.default_rng(43).permutation(runs)
    conditions = random_conditions(runs, np.random.default_rng(44))
    measured, curves = campaign(np.where(time >= 70, 1.02, 1.0), "jt", 45, conditions)
    change = largest_change(covariance_of(measured), time[curves])
    assert change.is_alarm
    assert (change.effect_name, change.kind) == ("gain", "step")
    assert change.size == pytest.approx(0.02, abs=0.005)
    assert np.mean(change.pattern == (time[curves] >= 70)) > 0.95
