"""Changes of a rig over its runs."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.stats

from lawless_truths import TRUTHS
from oilfilm.surface import steadiness
from oilfilm.surface.effects import EFFECTS
from oilfilm.surface.steadiness import (
    largest_change,
    patterns_of_labels,
    patterns_over_time,
    smallest_seen,
)
from oilfilm.surface.surface import fit_surface
from surface_campaigns import fitted_law, latin, simulated

SLIPS = np.geomspace(0.002, 0.3, 9)
RUNS = 24
# 24 conditions in the order of the plan, measured in a random order of time.
TIME = np.random.default_rng(40).permutation(RUNS)


def campaign(gain_of_run, truth="jt", seed=41):
    """The points, with the force of each run multiplied by a gain, in canonical order."""
    clean = simulated(TRUTHS[truth], latin(), np.random.default_rng(seed), slips=SLIPS)
    measured = replace(clean, mu=clean.mu * gain_of_run[clean.curve])
    curves, _ = measured.canonical_order()
    return measured.in_canonical_order(), curves


def covariance_of(measured):
    return fit_surface(measured, fitted_law(measured)).misfit_covariance


def test_a_steady_campaign_raises_no_alarm():
    measured, curves = campaign(np.ones(RUNS))
    assert not largest_change(covariance_of(measured), patterns_over_time(TIME[curves])).is_alarm


@pytest.mark.parametrize("truth", ["jt", "own"])
def test_a_step_of_the_force_is_named_with_its_runs_whether_or_not_a_law_is_true(truth):
    measured, curves = campaign(np.where(TIME >= 14, 1.05, 1.0), truth)
    change = largest_change(covariance_of(measured), patterns_over_time(TIME[curves]))
    assert change.is_alarm
    assert (change.effect, change.kind) == ("gain", "step")
    np.testing.assert_array_equal(change.pattern, TIME[curves] >= 14)
    # 5 % of force; the standard error of the difference of 14 and 10 runs is 0.8 %/sqrt(5.8)
    assert change.size == pytest.approx(np.log(1.05), abs=0.015)


def test_runs_of_one_label_are_named():
    labels = np.arange(RUNS) % 3
    measured, curves = campaign(np.where(labels == 1, 0.93, 1.0))
    patterns = (patterns_of_labels(labels[curves]),)
    change = largest_change(covariance_of(measured), patterns)
    assert change.is_alarm
    assert change.effect == "gain"
    np.testing.assert_array_equal(change.pattern, labels[curves] == 1)


def test_a_trend_in_the_order_of_a_condition_is_seen_when_it_is_large_only():
    measured, curves = campaign(np.ones(RUNS))
    covariance = covariance_of(measured)
    random_order, *_ = patterns_over_time(TIME[curves])
    by_pressure, *_ = patterns_over_time(np.argsort(np.argsort(measured.conditions[:, 0])))
    seen = [smallest_seen(covariance, "gain", p.columns[:, 0]) for p in (random_order, by_pressure)]
    # a trial: 3 % in random order, 26 to 46 % in the order of the condition
    assert seen[1] > 2 * seen[0]


def test_likelihood_ratio_is_that_of_the_normal_distributions():
    measured, curves = campaign(np.where(TIME >= 14, 1.05, 1.0))
    covariance = covariance_of(measured)
    profile = steadiness._Profile.of_effect(covariance, "gain")
    pattern = (TIME[curves] >= 14).astype(float)
    number = EFFECTS.index("gain")

    def log_density(variance, size):
        sizes = covariance.sizes.effects.copy()
        sizes[number] = np.sqrt(variance)
        total = replace(covariance, sizes=replace(covariance.sizes, effects=sizes)).matrix()
        column = covariance.curves.effects[:, number]
        mean = size * pattern[covariance.curves.curve] * column
        density = scipy.stats.multivariate_normal(mean, total).logpdf(covariance.curves.departure)
        scatter = np.log(variance / profile.expected_variance) / 2 / 0.6
        return density - scatter**2 / 2

    (ratio,), (size,) = profile.ratios(pattern[:, np.newaxis])
    variances = profile.expected_variance * steadiness._VARIANCES
    changed = max(log_density(variance, size) for variance in variances)
    steady = max(log_density(variance, 0.0) for variance in variances)
    assert ratio == pytest.approx(2 * (changed - steady), rel=1e-4)


def test_more_curves_than_fit_into_memory_are_refused(monkeypatch):
    measured, curves = campaign(np.ones(RUNS))
    covariance = covariance_of(measured)
    monkeypatch.setattr(steadiness, "LARGEST_DENSE", 10)
    with pytest.raises(ValueError, match=r"24 curves.* 10 at most"):
        largest_change(covariance, patterns_over_time(TIME[curves]))
