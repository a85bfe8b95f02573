"""Runs whose speed or slip is read twice or half as large."""

import functools
from dataclasses import replace

import numpy as np
import pytest
import scipy.stats

from lawless_truths import TRUTHS
from nights import nightly, quick_ones
from oilfilm.surface.effects import ErrorPriors
from oilfilm.surface.fitted_readings import FittedReadings
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.misreading import likeliest_misreading
from oilfilm.surface.surface import fit_surface
from surface_campaigns import fitted_law, latin, simulated

SLIPS = np.geomspace(0.002, 0.3, 9)
FEW = np.isin(np.arange(24), [0, 4, 5, 9, 13, 15, 18, 23])


@functools.cache
def surface_of(truth, speed_factor=1.0, slip_factor=1.0, seed=51):
    """A surface of points of which some runs read speed or slip wrong, and which these runs are."""
    measured = simulated(TRUTHS[truth], latin(), np.random.default_rng(seed), slips=SLIPS)
    conditions = measured.conditions.copy()
    conditions[FEW, 1] *= speed_factor
    slip = measured.slip * np.where(FEW, slip_factor, 1.0)[measured.curve_of_point]
    measured = replace(measured, conditions=conditions, slip=slip)
    curves, _ = measured.canonical_order()
    return fit_surface(measured, fitted_law(measured)), FEW[curves]


@pytest.mark.slow
@pytest.mark.parametrize("truth", quick_ones(["own", "jt"], ["jt"]))
@pytest.mark.parametrize(
    ("quantity", "factor"), [("speed", 2.0), nightly("slip", 2.0), ("slip", 0.5)]
)
def test_a_reading_that_is_wrong_by_two_is_named(truth, quantity, factor):
    surface, few = surface_of(truth, **{f"{quantity}_factor": factor})
    day = np.arange(24) < 12
    misreading = likeliest_misreading(surface, {"day=1": day, "form=B": few})
    assert misreading is not None
    assert misreading.is_alarm
    assert (misreading.quantity, misreading.factor) == (quantity, factor)
    np.testing.assert_array_equal(misreading.is_misread, few)


@pytest.mark.parametrize("truth", ["own", nightly("jt")])
def test_right_readings_stay(truth):
    surface, few = surface_of(truth)
    misreading = likeliest_misreading(surface, {"form=B": few})
    assert misreading is None or not misreading.is_alarm


@pytest.mark.slow
def test_runs_put_right_have_the_true_readings():
    surface, few = surface_of("own", speed_factor=2.0)
    misreading = likeliest_misreading(surface, {"form=B": few})
    right = misreading.corrected(surface.measurements)
    assert set(np.round(right.conditions[:, 1])) == {25.0, 30.0, 35.0, 40.0}


def test_likelihood_of_other_readings_is_that_of_the_normal_distribution():
    surface, few = surface_of("own")
    measured = surface.measurements
    as_read = FittedReadings.as_read(surface, ErrorPriors())
    conditions = measured.conditions.copy()
    conditions[few, 1] *= 1.3
    other = as_read.fit_to(replace(measured, conditions=conditions))
    difference = other.negative_ln_likelihood_of(measured) - other.negative_ln_likelihood_of(
        other.measurements
    )

    def log_density(of):
        covariance = replace(of.covariance, sizes=other.covariance.sizes)
        curves = covariance.curves
        noise = scipy.stats.norm(0, covariance.sizes.noise).logpdf(curves.remainder).sum()
        total = scipy.stats.multivariate_normal(cov=covariance.matrix())
        return noise + total.logpdf(curves.departure)

    assert difference == pytest.approx(log_density(other) - log_density(as_read), rel=1e-6)


def test_readings_at_which_the_law_has_no_traction_are_no_candidates(monkeypatch):
    surface, few = surface_of("own", speed_factor=2.0)

    def has_traction(law, conditions, slip):
        return conditions[:, 1] > 24.0

    monkeypatch.setattr(FreeLaw, "has_traction", has_traction)
    # with the speeds of the other runs halved there is none
    misreading = likeliest_misreading(surface, {"form=A": ~few, "form=B": few})
    np.testing.assert_array_equal(misreading.is_misread, few)
    as_read = FittedReadings.as_read(surface, ErrorPriors())
    halved = replace(misreading, is_misread=~few).corrected(surface.measurements)
    assert as_read.negative_ln_likelihood_of(halved) == np.inf
