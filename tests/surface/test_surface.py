"""Surfaces of whole campaigns: error, interval, verdict, independence of order and threads."""

from dataclasses import replace

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from lawless_truths import DENG_CONSTANTS, TRUTHS, rounded
from oilfilm.surface import surface as surface_module
from oilfilm.surface.label_swap import likeliest_swap
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.limits import SurfaceLimits
from oilfilm.surface.measurements import Measurements
from oilfilm.surface.reml import INTERVAL_KAPPA_PRIOR, MISFIT_KAPPA_PRIOR, FoundSizes
from oilfilm.surface.support import Support
from oilfilm.surface.surface import fit_surface
from oilfilm.traction import PAPER_LAW
from surface_campaigns import PlantedErrors, fitted_law, grid, latin, simulated

SLIPS = np.geomspace(0.002, 0.3, 8)
NEW = np.array([[1.1, 30.0, 50.0], [1.4, 38.0, 100.0]])
NEW_SLIP = np.array([0.01, 0.12])
ALL_FREE = np.ones(12, dtype=bool)
CORNERS = grid((1.0, 1.5), (25.0, 40.0), (25.0, 120.0))


@pytest.fixture(scope="module")
def measured():
    return simulated(TRUTHS["jt"], latin(), np.random.default_rng(21), slips=SLIPS)


@pytest.fixture(scope="module")
def law(measured):
    return fitted_law(measured)


@pytest.fixture(scope="module")
def fitted(measured, law):
    return fit_surface(measured, law)


def numbers(surface):
    prediction, factors = surface.predict(NEW, NEW_SLIP), surface.interval_factors
    return np.concatenate(
        [
            *(prediction.mu, prediction.surface_sd, prediction.next_run_sd),
            (factors.point, factors.curve, surface.verdict.kappa),
            surface.verdict.constants,
        ]
    )


@pytest.mark.slow
def test_order_of_curves_and_points_changes_no_digit(measured, law, fitted):
    random = np.random.default_rng(22)
    curves = random.permutation(len(measured.conditions))
    rows = random.permutation(len(measured.mu))
    mixed = Measurements(
        measured.conditions[curves],
        np.argsort(curves)[measured.curve_of_point][rows],
        measured.slip[rows],
        measured.mu[rows],
    )
    np.testing.assert_array_equal(numbers(fit_surface(mixed, law)), numbers(fitted))


@pytest.mark.slow
def test_number_of_blas_threads_changes_no_digit(measured, law, fitted):
    with threadpool_limits(limits=2, user_api="blas"):
        other = numbers(fit_surface(measured, law))
    np.testing.assert_array_equal(other, numbers(fitted))


def test_surface_is_nearer_to_an_oil_that_no_law_describes(law, fitted):
    conditions = np.repeat(grid((1.1, 1.4), (28.0, 38.0), (40.0, 77.0, 110.0)), 3, axis=0)
    slip = np.tile([0.005, 0.03, 0.2], 12)
    truth = np.log(TRUTHS["jt"](*conditions.T, slip))
    of_law = np.abs(law.log_mu(conditions, slip) - truth)
    of_surface = np.abs(fitted.log_mu(conditions, slip) - truth)
    # a trial: 0.048 for the law's 0.11
    assert np.quantile(of_surface, 0.95) < 0.5 * np.quantile(of_law, 0.95)


def test_new_runs_are_inside_the_interval(fitted):
    random = np.random.default_rng(23)
    conditions = grid((1.1, 1.4), (28.0, 38.0), (40.0, 77.0, 110.0))
    new = simulated(TRUTHS["jt"], conditions, random, slips=np.array([0.003, 0.01, 0.05, 0.2]))
    prediction = fitted.predict(new.point_conditions, new.slip)
    lower, upper = prediction.interval(fitted.interval_factors.point)
    assert np.mean((lower <= new.mu) & (new.mu <= upper)) >= 0.87


def test_mu_between_slips_is_held_or_has_no_interval():
    """Three slips hide the maximum of this oil, and the interval held mu at 11 to 60 %."""
    tested = grid((0.9, 1.15, 1.5), (5.0, 10.0, 20.0), (42.0, 70.0, 105.0))
    conditions = grid((1.0, 1.3), (7.0, 14.0), (50.0, 65.0, 90.0))
    for slips, slip, is_supported in (
        ((0.012, 0.06, 0.26), 0.13, False),
        ((0.012, 0.04, 0.1, 0.26), 0.17, True),
    ):
        random = np.random.default_rng(25)
        measured = simulated(rounded, tested, random, slips=np.array(slips))
        surface = fit_surface(measured, fitted_law(measured))
        prediction = surface.predict(conditions, np.full(len(conditions), slip))
        lower, upper = prediction.interval(surface.interval_factors.point)
        assert np.all(np.isfinite(lower) == is_supported)
        if is_supported:
            truth = rounded(*conditions.T, slip)
            assert np.mean((lower <= truth) & (truth <= upper)) >= 0.87


def test_repeated_runs_raise_no_claim():
    random = np.random.default_rng(24)
    measured = simulated(TRUTHS["own"], np.repeat(CORNERS, 3, axis=0), random, slips=SLIPS)
    factors = fit_surface(measured, fitted_law(measured)).interval_factors
    assert factors.level == pytest.approx(8 / 9)
    assert factors.curve >= factors.point >= 1.959


def test_standard_errors_of_constants_hold_the_planted_constants():
    errors = PlantedErrors()
    measured = simulated(TRUTHS["own"], latin(), np.random.default_rng(25), errors)
    verdict = fit_surface(measured, fitted_law(measured)).verdict
    assert verdict.kappa < 0.02
    scores = (verdict.constants - DENG_CONSTANTS) / verdict.standard_errors
    # twelve normal numbers: the largest is below 3 in 97 of 100 cases
    assert np.abs(scores).max() < 3


def test_a_law_that_does_not_fit_has_a_large_departure(fitted):
    assert fitted.verdict.kappa > 0.02


def test_a_law_that_misses_points_near_zero_by_a_third_does_not_move_the_rest():
    # the linear response is about the surface, never about the law
    slips = np.append(np.full(3, 1e-4) * (1, 2, 3), np.geomspace(0.002, 0.3, 8))
    random = np.random.default_rng(26)
    measured = simulated(TRUTHS["own"], latin(), random, slips=slips)
    assert np.any(measured.mu < 4e-4)
    constants = DENG_CONSTANTS.copy()
    constants[4] += np.log(1.3)
    surface = fit_surface(measured, FreeLaw(PAPER_LAW, constants, ALL_FREE))
    prediction = surface.predict(NEW, np.array([0.05, 0.25]))
    truth = TRUTHS["own"](*NEW.T, np.array([0.05, 0.25]))
    np.testing.assert_allclose(prediction.mu, truth, rtol=0.02)


@pytest.mark.parametrize("cut_short", [MISFIT_KAPPA_PRIOR, INTERVAL_KAPPA_PRIOR])
def test_a_surface_says_whether_both_searches_of_sizes_converged(
    measured, law, fitted, monkeypatch, cut_short
):
    def most_likely(curves, box, known, start=None):
        # what is expected before the data is as good as a search here
        medians = np.log([prior.median for prior in known])
        return FoundSizes(medians, converged=cut_short not in known)

    monkeypatch.setattr(surface_module, "most_likely_sizes", most_likely)
    assert fitted.converged
    assert not fit_surface(measured, law).converged


def test_points_that_are_all_near_zero_are_refused_with_a_reason(measured, law):
    with pytest.raises(ValueError, match="check the unit of mu"):
        fit_surface(replace(measured, mu=measured.mu * 1e-4), law)


@pytest.mark.slow
def test_a_force_that_is_far_below_zero_in_half_of_the_runs_leaves_no_interval():
    # a third of the points is below zero by up to 200 errors of the zero
    random = np.random.default_rng(87)
    clean = simulated(TRUTHS["ect"], latin(), random, slips=np.geomspace(0.0015, 0.3, 15))
    is_late = clean.curve_of_point >= 12
    wrong = replace(clean, mu=clean.mu - 0.0107 * is_late)
    surface = fit_surface(wrong, fitted_law(wrong))
    asked = latin()[:5]
    prediction = surface.predict(asked, np.full(5, 0.05))
    assert np.isfinite(prediction.next_run_sd).all()
    assert (prediction.support_codes != 0).all()
    swap = likeliest_swap(surface)
    assert swap is None or np.isfinite(swap.score)


def test_no_interval_is_given_without_support(fitted):
    prediction = fitted.predict(NEW, np.array([0.05, 3.0]))
    assert prediction.support_codes.tolist() == [Support.SUPPORTED, Support.FAR_FROM_TESTED_SLIPS]
    lower, upper = prediction.interval(2.0)
    assert np.isfinite(lower[0]) and np.isnan([lower[1], upper[1]]).all()


def test_a_lower_level_gives_a_narrower_interval_of_the_same_surface(measured, law, fitted):
    modest = fit_surface(measured, law, limits=SurfaceLimits(level=0.8))
    assert modest.interval_factors.level == pytest.approx(0.8)
    assert modest.interval_factors.point < fitted.interval_factors.point
    np.testing.assert_array_equal(modest.log_mu(NEW, NEW_SLIP), fitted.log_mu(NEW, NEW_SLIP))


def test_pure_rolling_is_refused(fitted):
    with pytest.raises(ValueError, match="not above 0"):
        fitted.predict(NEW, np.array([0.05, 0.0]))


def test_a_large_campaign_agrees_with_the_dense_surface(measured, law, fitted, monkeypatch):
    monkeypatch.setattr(surface_module, "LARGEST_EXACT_CURVE_COUNT", 5)
    large = fit_surface(measured, law)
    one, other = large.predict(NEW, NEW_SLIP), fitted.predict(NEW, NEW_SLIP)
    # all conditions are inducing, so that only the jitter differs
    np.testing.assert_allclose(one.mu, other.mu, rtol=1e-3)
    np.testing.assert_allclose(one.surface_sd, other.surface_sd, rtol=0.02)
    assert large.interval_factors.point == pytest.approx(fitted.interval_factors.point, rel=0.01)


def test_sizes_of_some_curves_stand_for_those_of_all(measured, law, fitted, monkeypatch):
    monkeypatch.setattr(surface_module, "CURVE_COUNT_FOR_SIZES", 16)
    sampled = fit_surface(measured, law)
    assert 8 <= len(surface_module._sample(sampled.measurements).conditions) <= 16
    one, other = sampled.predict(NEW, NEW_SLIP), fitted.predict(NEW, NEW_SLIP)
    # all curves give the answer; only the sizes come from fewer
    assert np.all(np.abs(np.log(one.mu / other.mu)) < other.surface_sd)
    np.testing.assert_allclose(one.next_run_sd, other.next_run_sd, rtol=0.5)


def test_a_temperature_that_was_not_varied_has_no_answer_elsewhere():
    conditions = grid((1.0, 1.25, 1.5), (25.0, 32.0, 40.0), (70.0,))
    measured = simulated(TRUTHS["own"], conditions, np.random.default_rng(27), slips=SLIPS)
    surface = fit_surface(measured, FreeLaw(PAPER_LAW, DENG_CONSTANTS, ALL_FREE))
    at = np.array([[1.1, 30.0, 71.0], [1.1, 30.0, 90.0]])
    codes = surface.predict(at, np.full(2, 0.05)).support_codes
    assert codes.tolist() == [Support.SUPPORTED, Support.CONDITION_NOT_VARIED]
