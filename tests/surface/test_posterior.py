"""Posteriors beside the plain formulas of normal distributions over all points."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

from allocations import peak_bytes
from lawless_truths import DENG_CONSTANTS, TRUTHS
from oilfilm.surface import posterior as posterior_module
from oilfilm.surface import reduction
from oilfilm.surface.effects import effect_design
from oilfilm.surface.kernels import DepartureSizes
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.measurements import scaled_conditions, scaled_slip
from oilfilm.surface.posterior import (
    DensePosterior,
    NystromPosterior,
    farthest_point_selection,
    smooth_covariance,
    weighted_covariance,
)
from oilfilm.surface.reduction import box_of, coordinates_at_points, reduced_curves
from oilfilm.surface.reml import CurveCovariance, Sizes
from oilfilm.traction import PAPER_LAW
from surface_campaigns import fitted_law, grid, random_conditions, simulated

LAW = FreeLaw(PAPER_LAW, DENG_CONSTANTS, np.ones(12, dtype=bool))
SIZES = Sizes(
    effects=np.array([0.008, 4e-5, 0.004, 0.5]),
    noise=0.003,
    departure_sizes=DepartureSizes(
        kappa=0.2,
        main=np.array([0.5, 0.7, 0.9]),
        interaction=0.3,
        slip_length=1.4,
        lengths=np.array([0.8, 1.1, 0.6]),
        slip_trend=0.4,
    ),
)
CONDITIONS = grid((1.0, 1.25, 1.5), (25.0, 40.0), (25.0, 72.0, 120.0))
# As many slips as a curve has coordinates: nothing is lost.
FEW_SLIPS = np.geomspace(0.003, 0.3, 6)
NEW = np.array([[1.1, 30.0, 50.0], [1.4, 38.0, 100.0], [1.0, 25.0, 25.0]])
NEW_SLIP = np.array([0.004, 0.05, 0.2])
LARGEST_BYTES_OF_A_CURVE = 8_000


def covariance_of(measured, law=LAW):
    box = box_of(measured)
    return CurveCovariance(reduced_curves(measured, law, law.log_mu, 4e-5, box), box, SIZES)


@pytest.fixture(scope="module")
def measured():
    random = np.random.default_rng(11)
    return simulated(TRUTHS["sol"], CONDITIONS, random, slips=FEW_SLIPS).in_canonical_order()


def plain_matern(left, right, length):
    """Matern-5/2 by its general form with a polynomial, written anew for this test."""
    ratio = np.abs(left[:, None] - right[None]) / length
    return (1 + 5**0.5 * ratio + 5 / 3 * ratio**2) * np.exp(-(5**0.5) * ratio)


def with_speed(points, speed):
    """The points (conditions, slip) at another speed."""
    conditions = points[0].copy()
    conditions[:, 1] = speed
    return conditions, points[1]


def plain_covariance(measured, left, right, law):
    """Smooth covariance between points (conditions, slip), term by term as the recipe states it."""
    box, of = box_of(measured), SIZES.departure_sizes
    middle, half = (box.lowest + box.highest) / 2, (box.highest - box.lowest) / 2
    x, y = (scaled_conditions(conditions) - middle for conditions, _ in (left, right))
    over_slip = plain_matern(scaled_slip(left[1]), scaled_slip(right[1]), of.slip_length)
    products = [np.outer(x[:, d], y[:, d]) for d in range(3)]
    pairs = products[0] * products[1] + products[0] * products[2] + products[1] * products[2]
    correlations = [plain_matern(x[:, d], y[:, d], of.lengths[d]) for d in range(3)]
    # P and T have three levels; U has two
    curved = of.main[0] ** 2 * correlations[0] + of.main[2] ** 2 * correlations[2]
    curved = curved + of.interaction**2 * correlations[0] * correlations[1] * correlations[2]
    bend = [0.03 * (1 - (z[:, 1] / half[1]) ** 2) for z in (x, y)]
    total = of.kappa**2 * (4 + sum(products) + pairs) * (1 + over_slip / 2)
    total += (of.kappa**2 * curved + np.outer(*bend)) * (0.5 + over_slip / 2)
    # 0.4 times the size at a slip of 0.3 as at rolling, exponential in the scaled slip
    relative = [np.arcsinh(slip / 0.003) / np.arcsinh(100) - 0.5 for _, slip in (left, right)]
    total *= np.outer(*(0.4**power for power in relative))
    level = [np.interp(c[:, 1], (25, 40), (0, 1)) for c, _ in (left, right)]
    power = [np.log(c[:, 1] / 25) / np.log(40 / 25) for c, _ in (left, right)]
    change = [
        law.log_mu(*with_speed(p, 40)) - law.log_mu(*with_speed(p, 25)) for p in (left, right)
    ]
    form = [(power[side] - level[side]) * change[side] for side in (0, 1)]
    return total + np.outer(*form) + 0.3**2 * law.log_slopes(*left) @ law.log_slopes(*right).T


def plain_posterior(measured, kept, law=LAW):
    """Mean and variance at the new points from the points `kept`, without any reduction."""
    conditions, slip = measured.point_conditions[kept], measured.slip[kept]
    at = (conditions, slip)
    design = effect_design(law.log_mu, *at) * SIZES.effects
    curve = measured.curve_of_point[kept]
    total = plain_covariance(measured, at, at, law) + SIZES.noise**2 * np.eye(len(slip))
    total += (curve[:, None] == curve) * (design @ design.T)
    across = plain_covariance(measured, (NEW, NEW_SLIP), at, law)
    departure = np.log(measured.mu[kept]) - law.log_mu(*at)
    own = np.diag(plain_covariance(measured, (NEW, NEW_SLIP), (NEW, NEW_SLIP), law))
    solved = scipy.linalg.solve(total, across.T, assume_a="pos").T
    return solved @ departure, own - np.sum(solved * across, axis=1), total, departure


def test_posterior_is_that_of_all_points(measured):
    posterior = DensePosterior(covariance_of(measured))
    places = coordinates_at_points(LAW, box_of(measured), NEW, NEW_SLIP)
    mean, variance, *_ = plain_posterior(measured, np.ones(len(measured.mu), dtype=bool))
    np.testing.assert_allclose(posterior.mean(places), mean, atol=1e-8)
    np.testing.assert_allclose(posterior.variance(places), variance, rtol=1e-5)


def test_reduction_of_twenty_slips_never_promises_more_than_all_points():
    # nine coordinates of 20 slips lose detail: the spread is larger, by a half at most
    random = np.random.default_rng(12)
    slips = np.geomspace(0.003, 0.3, 20)
    measured = simulated(TRUTHS["sol"], CONDITIONS, random, slips=slips).in_canonical_order()
    law = fitted_law(measured)
    posterior = DensePosterior(covariance_of(measured, law))
    places = coordinates_at_points(law, box_of(measured), NEW, NEW_SLIP)
    everything = np.ones(len(measured.mu), dtype=bool)
    mean, variance, *_ = plain_posterior(measured, everything, law)
    spread = np.sqrt(posterior.variance(places))
    ratio = spread / np.sqrt(variance)
    assert np.all((ratio > 0.99) & (ratio < 1.5))
    assert np.all(np.abs(posterior.mean(places) - mean) < 0.5 * spread)


def test_left_out_condition_is_predicted_as_without_its_runs(measured):
    group = measured.condition_of_curve()
    for number, left_out in enumerate(
        DensePosterior(covariance_of(measured)).leave_groups_out(group)
    ):
        if number not in (0, 7):
            continue
        out = group[measured.curve_of_point] == number
        _, _, total, departure = plain_posterior(measured, np.ones(len(out), dtype=bool))
        weights = scipy.linalg.solve(total[np.ix_(~out, ~out)], total[np.ix_(~out, out)]).T
        error = departure[out] - weights @ departure[~out]
        spread = total[np.ix_(out, out)] - weights @ total[np.ix_(~out, out)]
        np.testing.assert_allclose(left_out.error, error, atol=1e-8)
        np.testing.assert_allclose(left_out.covariance, spread, rtol=1e-4, atol=1e-10)


def test_nystrom_with_all_curves_is_the_dense_posterior(measured):
    covariance = covariance_of(measured)
    dense = DensePosterior(covariance)
    nystrom = NystromPosterior(covariance, np.arange(len(covariance.curves.curve_of_coordinate)))
    places = coordinates_at_points(LAW, covariance.box, NEW, NEW_SLIP)
    # the jitter of the inducing coordinates leaves 1e-5
    np.testing.assert_allclose(nystrom.mean(places), dense.mean(places), atol=2e-5)
    np.testing.assert_allclose(nystrom.variance(places), dense.variance(places), rtol=1e-3)
    group = measured.condition_of_curve()
    for one, other in zip(
        nystrom.leave_groups_out(group), dense.leave_groups_out(group), strict=True
    ):
        np.testing.assert_array_equal(one.coordinate_indices, other.coordinate_indices)
        np.testing.assert_allclose(one.error, other.error, atol=2e-5)
    slopes = covariance.curves.law_slopes
    dense_change, dense_spread = dense.parameter_posterior(slopes)
    change, spread = nystrom.parameter_posterior(slopes)
    np.testing.assert_allclose(change, dense_change, atol=3e-3)
    np.testing.assert_allclose(np.diag(spread), np.diag(dense_spread), rtol=1e-3)


def test_blocks_of_curves_change_nothing(monkeypatch):
    # repeated runs: three curves per condition, which one block must hold together
    random = np.random.default_rng(14)
    conditions = np.repeat(CONDITIONS[:7], 3, axis=0)
    measured = simulated(TRUTHS["sol"], conditions, random, slips=FEW_SLIPS).in_canonical_order()
    covariance, group = covariance_of(measured), measured.condition_of_curve()
    places = coordinates_at_points(LAW, covariance.box, NEW, NEW_SLIP)
    # inducing coordinates of few curves, so that a remainder is left
    inducing = np.flatnonzero(covariance.curves.curve_of_coordinate < 6)
    whole = NystromPosterior(covariance, inducing)
    expected = [whole.mean(places), whole.variance(places)]
    expected_left_out = list(whole.leave_groups_out(group))
    monkeypatch.setattr(posterior_module, "_CURVES_AT_ONCE", 4)
    parts = NystromPosterior(covariance, inducing)
    np.testing.assert_allclose([parts.mean(places), parts.variance(places)], expected, rtol=1e-6)
    for one, other in zip(parts.leave_groups_out(group), expected_left_out, strict=True):
        np.testing.assert_array_equal(one.coordinate_indices, other.coordinate_indices)
        np.testing.assert_allclose(one.error, other.error, atol=1e-7)


def test_factor_of_a_curve_is_that_of_what_only_its_points_share(measured):
    covariance = covariance_of(measured)
    basis = covariance.curves.select_coordinates(
        np.flatnonzero(covariance.curves.curve_of_coordinate < 6)
    )
    posterior = NystromPosterior(
        covariance, np.flatnonzero(covariance.curves.curve_of_coordinate < 6)
    )
    every = list(posterior.features_by_curve())
    assert len(every) == len(measured.conditions)
    coordinates, features, factor = every[8]
    part = covariance.curves.select_coordinates(coordinates)
    # what the basis explains, and what it leaves over beside the errors of the run
    across = smooth_covariance(covariance, part, basis)
    among = smooth_covariance(covariance, basis, basis)
    explained = across @ scipy.linalg.solve(among, across.T, assume_a="pos")
    np.testing.assert_allclose(features @ features.T, explained, atol=1e-6)
    total = covariance.matrix()[np.ix_(coordinates, coordinates)]
    np.testing.assert_allclose(factor @ factor.T, total - explained, atol=1e-6)


def test_weighted_covariance_is_that_of_all_coordinates(measured):
    # places that share conditions, and slips of their own
    conditions, slip = np.repeat(NEW, 4, axis=0), np.geomspace(0.004, 0.25, 12)
    covariance = covariance_of(measured)
    everything = covariance.curves.select_coordinates(
        np.arange(len(covariance.curves.curve_of_coordinate))
    )
    weights = np.random.default_rng(15).standard_normal(len(covariance.curves.curve_of_coordinate))
    places = coordinates_at_points(LAW, covariance.box, conditions, slip)
    expected = smooth_covariance(covariance, places, everything) @ weights
    found = weighted_covariance(covariance, places, everything, weights)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


def test_fewer_inducing_conditions_never_promise_more_than_the_dense_posterior(measured):
    covariance = covariance_of(measured)
    chosen = farthest_point_selection(covariance.curves.conditions, 6)
    inducing = np.flatnonzero(np.isin(covariance.curves.curve_of_coordinate, chosen))
    places = coordinates_at_points(LAW, covariance.box, NEW, NEW_SLIP)
    nystrom, dense = NystromPosterior(covariance, inducing), DensePosterior(covariance)
    assert np.all(nystrom.variance(places) > 0.999 * dense.variance(places))


@pytest.mark.parametrize(
    # with few runs the peak is that of another step, which grows more slowly
    "run_counts",
    [(20, 60, 100), pytest.param((300, 1000, 3000), marks=pytest.mark.nightly)],
)
def test_memory_is_linear_in_the_number_of_runs(run_counts):
    peaks = [peak_memory(runs) for runs in run_counts]
    first, second = np.diff(peaks) / np.diff(run_counts)
    assert second < 1.3 * first


def peak_memory(runs):
    """Largest memory of arrays, bytes, of a posterior on twelve curves."""
    random = np.random.default_rng(13)
    conditions = random_conditions(runs, random)
    measured = simulated(TRUTHS["jt"], conditions, random, slips=FEW_SLIPS)
    with peak_bytes() as peak:
        covariance = covariance_of(measured)
        inducing = np.flatnonzero(np.isin(covariance.curves.curve_of_coordinate, np.arange(12)))
        posterior = NystromPosterior(covariance, inducing)
        posterior.mean(coordinates_at_points(LAW, covariance.box, NEW, NEW_SLIP))
        for _ in posterior.leave_groups_out(np.arange(runs)):
            pass
    return peak()


@pytest.mark.slow
def test_bytes_of_a_curve_do_not_grow_with_their_number(monkeypatch: pytest.MonkeyPatch):
    """Slips that no two points share: dense weights would take 100 columns of 9 numbers a curve."""
    monkeypatch.setattr(reduction, "_CURVES_AT_ONCE", 50)
    random = np.random.default_rng(17)
    peaks = []
    for runs in (100, 200, 400):
        measured = simulated(TRUTHS["jt"], random_conditions(runs, random), random)
        slip = measured.slip * np.exp(0.01 * random.standard_normal(len(measured.slip)))
        measured = replace(measured, slip=slip).in_canonical_order()
        covariance_of(measured)
        with peak_bytes() as peak:
            covariance_of(measured)
        peaks.append(peak())
    first, second = np.diff(peaks) / [100, 200]
    # twice as much where the bytes grow with the square of the curves
    assert second < 1.25 * first
    assert second < LARGEST_BYTES_OF_A_CURVE


def test_rounding_does_not_choose_the_inducing_conditions():
    # the corners of a cube are equally far from its middle
    corners = np.array([(p, u, t) for p in (-1.0, 1.0) for u in (-1.0, 1.0) for t in (-1.0, 1.0)])
    conditions = np.vstack([np.zeros((1, 3)), corners])
    rounding = 1e-15 * np.random.default_rng(1).standard_normal(conditions.shape)
    np.testing.assert_array_equal(
        farthest_point_selection(conditions + rounding, 4), farthest_point_selection(conditions, 4)
    )
