"""The ratio of two oils: planted ratios, levels, order of rows and of oils, what is not covered."""

from dataclasses import replace

import numpy as np
import pytest

from lawless_truths import TRUTHS
from oilfilm.surface import ratio as ratio_module
from oilfilm.surface.measurements import Measurements
from oilfilm.surface.ratio import OilOfPair, RunsOfPair, fit_ratio
from oilfilm.surface.support import Support
from planted_pairs import PLANTED_RATIO, related_oil, scaled_oil
from surface_campaigns import (
    PRESSURES,
    SPEEDS,
    TEMPERATURES,
    ends,
    fitted_law,
    grid,
    latin,
    random_conditions,
    simulated,
)

SLIPS = np.geomspace(0.002, 0.3, 6)
CORNERS = grid(ends(PRESSURES), ends(SPEEDS), ends(TEMPERATURES))


def oil_of(truth, conditions, seed):
    measurements = simulated(truth, conditions, np.random.default_rng(seed), slips=SLIPS)
    return OilOfPair(measurements, fitted_law(measurements))


def asked(count, seed):
    random = np.random.default_rng(seed)
    return random_conditions(count, random), np.exp(random.uniform(*np.log([0.002, 0.3]), count))


@pytest.fixture(scope="module")
def oils():
    # no law of the library has this truth
    truth = TRUTHS["limited_eyring"]
    return oil_of(truth, latin(), 41), oil_of(scaled_oil(truth), latin(), 42)


@pytest.fixture(scope="module")
def fitted(oils):
    return fit_ratio(*oils)


@pytest.mark.slow
def test_a_planted_ratio_is_inside_narrow_and_certain_with_24_runs_of_each_oil(fitted):
    prediction = fitted.predict(*asked(200, 43))
    factors = fitted.interval_factors
    assert factors.level == 0.95
    assert (prediction.support_codes == Support.SUPPORTED).all() and not prediction.is_outside.any()
    lower, upper = prediction.interval(factors.point)
    assert np.mean((lower < PLANTED_RATIO) & (PLANTED_RATIO < upper)) >= 0.95
    assert np.median(factors.point * prediction.ln_ratio_sd) <= 0.015
    assert (lower > 1).all()


@pytest.mark.slow
def test_a_ratio_that_changes_with_slip_and_conditions_is_inside():
    truth = TRUTHS["rat"]
    surface = fit_ratio(oil_of(truth, latin(), 44), oil_of(related_oil(truth), latin(), 45))
    conditions, slip = asked(200, 46)
    lower, upper = surface.predict(conditions, slip).interval(surface.interval_factors.point)
    true = related_oil(truth)(*conditions.T, slip) / truth(*conditions.T, slip)
    assert np.ptp(true) > 0.05
    # errors of one campaign go together: its share may be 8 % below the claim, not the mean of many
    assert np.mean((lower <= true) & (true <= upper)) >= 0.95 - 0.08


@pytest.mark.slow
def test_order_of_rows_and_of_oils_changes_no_digit(oils, fitted):
    random = np.random.default_rng(47)
    mixed = []
    for oil in oils:
        points = oil.measurements
        curves, rows = random.permutation(24), random.permutation(len(points.mu))
        mixed.append(
            replace(
                oil,
                measurements=Measurements(
                    points.conditions[curves],
                    np.argsort(curves)[points.curve_of_point][rows],
                    points.slip[rows],
                    points.mu[rows],
                ),
            )
        )
    back = fit_ratio(mixed[1], mixed[0])
    at = asked(5, 48)
    there, reciprocal = fitted.predict(*at), back.predict(*at)
    np.testing.assert_array_equal(reciprocal.ln_ratio_sd, there.ln_ratio_sd)
    np.testing.assert_allclose(reciprocal.ratio, 1 / there.ratio, rtol=1e-15)
    assert back.interval_factors == fitted.interval_factors


@pytest.mark.slow
@pytest.mark.parametrize("repeats", [1, 2])
def test_eight_conditions_claim_no_95_percent_however_often_they_are_repeated(repeats):
    conditions = np.repeat(CORNERS, repeats, axis=0)
    truth = TRUTHS["own"]
    surface = fit_ratio(oil_of(truth, conditions, 49), oil_of(scaled_oil(truth), conditions, 50))
    # of eight left-out conditions a ninth is within the largest error in 8 of 9 cases
    assert surface.interval_factors.level == pytest.approx(8 / 9)


@pytest.mark.slow
def test_a_gain_that_all_runs_of_an_oil_share_moves_the_ratio_and_not_its_interval(oils, fitted):
    first, second = oils
    points = replace(second.measurements, mu=1.01 * second.measurements.mu)
    moved = fit_ratio(first, OilOfPair(points, second.law))
    at = asked(5, 51)
    np.testing.assert_allclose(
        moved.predict(*at).ratio, 1.01 * fitted.predict(*at).ratio, rtol=2e-3
    )
    np.testing.assert_allclose(
        moved.predict(*at).ln_ratio_sd, fitted.predict(*at).ln_ratio_sd, rtol=0.1
    )


@pytest.mark.slow
def test_conditions_of_one_oil_count_and_raise_no_level():
    truth, random = TRUTHS["jt"], np.random.default_rng(52)
    shared, own = latin()[::2], random_conditions(12, random)
    first = oil_of(truth, np.vstack([shared, own]), 53)
    second = oil_of(scaled_oil(truth), shared, 54)
    surface = fit_ratio(first, second)
    assert surface.interval_factors.level == pytest.approx(12 / 13)
    lower, upper = surface.predict(*asked(100, 55)).interval(surface.interval_factors.point)
    assert np.mean((lower < PLANTED_RATIO) & (PLANTED_RATIO < upper)) >= 0.92


@pytest.mark.slow
def test_what_an_oil_was_not_tested_at_is_marked(fitted):
    at = np.array([[1.2, 30.0, 70.0], [2.5, 30.0, 70.0], [1.2, 30.0, 70.0]])
    prediction = fitted.predict(at, np.array([0.05, 0.05, 3.0]))
    assert prediction.is_outside.tolist() == [False, True, True]
    assert prediction.support_codes[1] == Support.FAR_FROM_TESTED_CONDITIONS
    assert prediction.support_codes[2] == Support.FAR_FROM_TESTED_SLIPS
    assert np.isnan(prediction.interval(2.0)[0]).tolist() == [False, True, True]


@pytest.mark.slow
def test_a_slip_below_the_tested_ones_of_either_oil_is_marked():
    # the first oil was tested from 0.002 on, the second from about 0.0055
    truth = TRUTHS["limited_eyring"]
    first, second = oil_of(truth, CORNERS, 57), oil_of(scaled_oil(truth), CORNERS, 58)
    is_kept = second.measurements.slip > 1.1 * SLIPS[0]
    fewer = replace(second, measurements=second.measurements.select_points(is_kept))
    slip = np.array([0.001, 0.004, SLIPS[1], 0.01])
    at = np.tile([1.2, 30.0, 70.0], (len(slip), 1))
    for pair in ((first, fewer), (fewer, first)):
        assert fit_ratio(*pair).predict(at, slip).is_outside.tolist() == [True, True, False, False]


def test_far_conditions_stand_for_all_of_a_large_campaign(oils):
    runs = RunsOfPair(*(oil.measurements.in_canonical_order() for oil in oils))
    few = runs.at_representative_conditions(10)
    assert np.count_nonzero(few.is_paired()) == len(few.is_paired()) == 10
    assert runs.at_representative_conditions(24) is runs


@pytest.mark.slow
def test_a_large_campaign_agrees_with_all_of_its_conditions(oils, fitted, monkeypatch):
    monkeypatch.setattr(ratio_module, "_CONDITION_COUNT_FOR_RATIO", 16)
    large = fit_ratio(*oils)
    at = asked(20, 56)
    few, every = large.predict(*at), fitted.predict(*at)
    assert (np.abs(np.log(few.ratio / every.ratio)) < 2 * few.ln_ratio_sd).all()
    assert (few.ln_ratio_sd > every.ln_ratio_sd).all()


def test_the_noise_of_one_oil_counts_where_that_of_the_other_is_not_known(oils):
    first, second = (oil.measurements for oil in oils)
    ratio_of_first = np.where(np.arange(len(first.slip)) % 2, 5.0, 1.0)
    runs = RunsOfPair(replace(first, noise_ratio=ratio_of_first), second)
    expected = np.append(ratio_of_first, np.ones(len(second.slip)))
    np.testing.assert_array_equal(runs.stacked.noise_ratio_of_points, expected)


def test_a_run_of_both_oils_is_refused(oils):
    with pytest.raises(ValueError, match="a run belongs to both oils"):
        fit_ratio(oils[0], oils[0])


def test_equal_rounded_values_of_single_points_are_no_run_of_both_oils():
    conditions, curves, slips = latin(), np.arange(24), np.full(24, 0.05)
    first = Measurements(conditions, curves, slips, 0.020 + 0.001 * np.arange(24))
    second = Measurements(conditions, curves, slips, 0.043 + 0.001 * np.arange(24))
    assert set(first.mu.round(3)) & set(second.mu.round(3)) == {0.043}
    second = replace(second, mu=second.mu.round(3))
    first = replace(first, mu=first.mu.round(3))
    assert not RunsOfPair(first, second).has_common_runs()
    assert RunsOfPair(first, first).has_common_runs()
