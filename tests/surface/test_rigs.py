"""Rigs in a surface: the gain that runs of a rig share, and a run on one of them or another."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
import scipy.optimize

from lawless_truths import DENG_CONSTANTS, TRUTHS
from nights import nightly, quick_ones
from oilfilm.surface import surface as surface_module
from oilfilm.surface.effects import ErrorPriors, LogNormal
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.posterior import DensePosterior, NystromPosterior, smooth_covariance
from oilfilm.surface.reduction import ANOTHER_RIG, box_of, coordinates_at_points, reduced_curves
from oilfilm.surface.reml import (
    INTERVAL_KAPPA_PRIOR,
    CurveCovariance,
    Sizes,
    objective,
    priors,
    size_names,
)
from oilfilm.surface.rig_gain import factor_of_another_rig, resolved_gain_count
from oilfilm.surface.surface import fit_surface
from oilfilm.traction import PAPER_LAW
from surface_campaigns import PlantedErrors, fitted_law, grid, random_conditions, simulated

LAW = FreeLaw(PAPER_LAW, DENG_CONSTANTS, np.ones(12, dtype=bool))
LEVELS = ((1.0, 1.25, 1.5), (25.0, 32.0, 40.0), (25.0, 72.0, 120.0))
# each rig, of which runs take turns, runs one temperature
CONFOUNDED = grid(*LEVELS)
SLIPS = np.geomspace(0.003, 0.3, 8)
NEW = np.array([[1.1, 30.0, 50.0], [1.4, 38.0, 100.0]])
NEW_SLIP = np.array([0.01, 0.12])
KNOWN = priors(ErrorPriors(), INTERVAL_KAPPA_PRIOR, tells_rigs_apart=True)


def mixed_rigs() -> np.ndarray:
    """27 conditions in an order that brings each level of each condition onto each rig."""
    rows = []
    for i, pressure in enumerate(LEVELS[0]):
        for j, speed in enumerate(LEVELS[1]):
            rows += [(pressure, speed, LEVELS[2][(i + j + rig) % 3]) for rig in range(3)]
    return np.array(rows)


def campaign(conditions, seed, gains=None, rig_gain=0.03):
    errors = PlantedErrors(rig_gain=rig_gain)
    random = np.random.default_rng(seed)
    return simulated(TRUTHS["own"], conditions, random, errors, SLIPS, gains)


@pytest.fixture(scope="module")
def measured():
    return campaign(mixed_rigs(), 31, np.array([0.03, 0.0, -0.03]))


@pytest.fixture(scope="module")
def fitted(measured):
    return fit_surface(measured, fitted_law(measured))


def covariance_of(measured, rig_gain=0.02):
    ordered = measured.in_canonical_order()
    box = box_of(ordered)
    logarithms = np.log([prior.median for prior in KNOWN])
    sizes = replace(Sizes.from_logarithms(logarithms), rig_gain=rig_gain)
    return CurveCovariance(reduced_curves(ordered, LAW, LAW.log_mu, 4e-5, box), box, sizes)


def test_the_gradient_has_the_gain_of_rigs(measured):
    covariance = covariance_of(measured)
    curves, box = covariance.curves, covariance.box
    place = np.log([prior.median for prior in KNOWN]) + 0.1
    _, gradient = objective(place, curves, box, KNOWN)
    for number, name in enumerate(size_names(tells_rigs_apart=True)):
        change = 1e-5 * np.eye(len(KNOWN))[number]
        above, _ = objective(place + change, curves, box, KNOWN)
        below, _ = objective(place - change, curves, box, KNOWN)
        assert gradient[number] == pytest.approx((above - below) / 2e-5, rel=1e-4, abs=1e-3), name


def test_sizes_survive_their_logarithms():
    logarithms = np.log([prior.median for prior in KNOWN])
    np.testing.assert_allclose(Sizes.from_logarithms(logarithms).logarithms(), logarithms)
    assert Sizes.from_logarithms(logarithms[:-1]).rig_gain == 0
    assert len(Sizes.from_logarithms(logarithms[:-1]).logarithms()) == len(logarithms) - 1


@pytest.mark.parametrize("rig", [0, 2, ANOTHER_RIG])
def test_posterior_on_a_rig_is_that_of_a_normal_distribution(measured, rig):
    # 8 slips are as many as a curve has coordinates at most, so that points are coordinates
    covariance = covariance_of(measured)
    curves = covariance.curves
    places = coordinates_at_points(LAW, covariance.box, NEW, NEW_SLIP)
    places = replace(places, rig_of_coordinate=np.full(2, rig))
    without = covariance_of(measured, rig_gain=0.0)
    rig_of_coordinate = measured.in_canonical_order().rig_of_curve[curves.curve_of_coordinate]
    everything = curves.select_coordinates(np.arange(len(curves.curve_of_coordinate)))
    across = smooth_covariance(without, places, everything)
    across = across + 0.02**2 * (rig_of_coordinate == rig)
    total = without.matrix()
    total += 0.02**2 * np.equal.outer(rig_of_coordinate, rig_of_coordinate)
    own = np.diag(smooth_covariance(without, places, places)) + 0.02**2 * (rig != ANOTHER_RIG)
    solved = scipy.linalg.solve(total, across.T, assume_a="pos").T
    dense = DensePosterior(covariance)
    np.testing.assert_allclose(dense.mean(places), solved @ curves.departure, atol=1e-8)
    variance = own - np.sum(solved * across, axis=1)
    np.testing.assert_allclose(dense.variance(places), variance, rtol=1e-5)
    nystrom = NystromPosterior(covariance, np.arange(len(curves.curve_of_coordinate)))
    np.testing.assert_allclose(nystrom.mean(places), dense.mean(places), atol=2e-5)
    np.testing.assert_allclose(nystrom.variance(places), dense.variance(places), rtol=1e-3)


@pytest.mark.slow
def test_planted_gains_of_rigs_are_found(fitted):
    # standard deviation of (0.03, 0, -0.03) about 0; three rigs know it within 40 % at best
    assert fitted.covariance.sizes.rig_gain == pytest.approx(0.0245, rel=0.5)
    another = fitted.predict(NEW, NEW_SLIP, ANOTHER_RIG).mu
    for rig, gain in enumerate((0.03, 0.0, -0.03)):
        # nine runs of a rig scatter by 0.8 % each
        np.testing.assert_allclose(
            fitted.predict(NEW, NEW_SLIP, rig).mu / another - 1, gain, atol=0.008
        )


def test_a_change_of_rigs_stays_in_what_steadiness_is_judged_by(fitted):
    assert fitted.misfit_covariance.sizes.rig_gain == 0


def test_one_of_the_rigs_is_the_mean_of_the_rigs(fitted):
    on_rigs = [fitted.predict(NEW, NEW_SLIP, rig) for rig in range(3)]
    one_of_them = fitted.predict(NEW, NEW_SLIP)
    logarithms = np.log([on_rig.mu for on_rig in on_rigs])
    np.testing.assert_allclose(np.log(one_of_them.mu), logarithms.mean(axis=0), rtol=1e-12)
    # variance of a mixture: the mean of the variances, and the variance of the means
    variances = np.array([on_rig.next_run_sd**2 for on_rig in on_rigs])
    expected = variances.mean(axis=0) + logarithms.var(axis=0)
    np.testing.assert_allclose(one_of_them.next_run_sd**2, expected, rtol=1e-9)


def test_the_gain_of_another_rig_is_that_of_three_rigs_and_of_what_was_expected(fitted):
    another = fitted.predict(NEW, NEW_SLIP, ANOTHER_RIG)
    sizes = fitted.covariance.sizes
    without = replace(
        fitted, covariance=replace(fitted.covariance, sizes=replace(sizes, rig_gain=0.0))
    )
    without = replace(without, posterior=fitted.posterior)
    of_rig = another.next_run_sd**2 - without.predict(NEW, NEW_SLIP).next_run_sd ** 2
    # the mean of the three gains belongs to the law: the runs resolve two of them
    factor = factor_of_another_rig(sizes.rig_gain, 2.0, ErrorPriors().rig_gain, 0.95)
    np.testing.assert_allclose(of_rig, (factor * sizes.rig_gain) ** 2, rtol=0.02)


def test_a_gain_of_which_nothing_was_known_follows_students_t():
    nothing_known = LogNormal(median=0.01, ln_sd=100.0, smallest=1e-9, largest=1e5)
    # quantiles of Student's t with one, two and five degrees of freedom
    for resolved_rigs, quantile in ((1.0, 12.706), (2.0, 4.3027), (5.0, 2.5706)):
        factor = factor_of_another_rig(0.02, resolved_rigs, nothing_known, 0.95)
        assert factor == pytest.approx(quantile / 1.95996, rel=1e-3)


def test_a_stated_gain_is_normally_distributed():
    stated = LogNormal(median=0.01, ln_sd=0.001, smallest=1e-4, largest=0.2)
    assert factor_of_another_rig(0.01, 0.0, stated, 0.95) == pytest.approx(1, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("resolved_rigs", [nightly(0), 2])
def test_another_rig_is_inside_as_often_as_claimed(resolved_rigs):
    before_data = LogNormal(median=0.01, ln_sd=0.6, smallest=1e-4, largest=0.2)
    random = np.random.default_rng(5)
    is_inside = []
    for _ in range(1000):
        size = 0.01 * np.exp(0.6 * random.standard_normal())
        sum_of_squares = np.sum((size * random.standard_normal(resolved_rigs)) ** 2)

        def slope(ln_size, sum_of_squares=sum_of_squares):
            expected = -(ln_size - np.log(0.01)) / 0.6**2
            return expected - resolved_rigs + sum_of_squares * np.exp(-2 * ln_size)

        most_likely = np.exp(scipy.optimize.brentq(slope, np.log(1e-4), np.log(0.2)))
        factor = factor_of_another_rig(most_likely, resolved_rigs, before_data, 0.95)
        half_width = 1.95996 * factor * most_likely
        is_inside.append(abs(size * random.standard_normal()) < half_width)
    # three standard deviations of a share of 1 000
    assert np.mean(is_inside) == pytest.approx(0.95, abs=0.021)


@pytest.mark.parametrize("rig_count", [2, 3, 7])
def test_rigs_of_which_only_the_mean_is_not_known_resolve_all_but_one(rig_count):
    only_the_mean = np.full((rig_count, rig_count), 1 / rig_count)
    assert resolved_gain_count(only_the_mean) == pytest.approx(rig_count - 1)
    assert resolved_gain_count(np.eye(rig_count)) == 0


@pytest.mark.parametrize("new_numbers", quick_ones([(7, 1, 4), (4, 7, 1), (2, 1, 0)], [(4, 7, 1)]))
def test_numbers_of_rigs_and_order_of_runs_change_no_digit(measured, fitted, new_numbers):
    random = np.random.default_rng(32)
    curves = random.permutation(len(measured.conditions))
    rows = random.permutation(len(measured.mu))
    mixed = replace(
        measured,
        conditions=measured.conditions[curves],
        curve_of_point=np.argsort(curves)[measured.curve_of_point][rows],
        slip=measured.slip[rows],
        mu=measured.mu[rows],
        rig_of_curve=np.array(new_numbers)[measured.rig_of_curve[curves]],
    )
    other = fit_surface(mixed, fitted.law)
    assert other.covariance.sizes.rig_gain == fitted.covariance.sizes.rig_gain
    same_rigs = [*enumerate(new_numbers), (ANOTHER_RIG, ANOTHER_RIG), (None, None)]
    for rig, number in same_rigs:
        one, same = fitted.predict(NEW, NEW_SLIP, rig), other.predict(NEW, NEW_SLIP, number)
        np.testing.assert_array_equal(one.mu, same.mu)
        np.testing.assert_array_equal(one.next_run_sd, same.next_run_sd)


@pytest.mark.slow
def test_runs_of_one_rig_are_as_runs_whose_rig_is_not_named(measured):
    law = fitted_law(measured)
    one_rig = fit_surface(replace(measured, rig_of_curve=np.zeros(27, dtype=np.int64)), law)
    unnamed = fit_surface(replace(measured, rig_of_curve=None), law)
    for name in ("mu", "surface_sd", "next_run_sd"):
        one = getattr(one_rig.predict(NEW, NEW_SLIP), name)
        np.testing.assert_array_equal(one, getattr(unnamed.predict(NEW, NEW_SLIP), name))


def test_an_unknown_rig_is_refused(fitted):
    with pytest.raises(ValueError, match="rig number 5"):
        fitted.predict(NEW, NEW_SLIP, 5)


def test_rigs_without_a_number_each_are_refused(measured):
    with pytest.raises(ValueError, match="number of a rig"):
        replace(measured, rig_of_curve=measured.rig_of_curve[1:])


def test_a_large_campaign_knows_each_rig(measured, fitted, monkeypatch):
    # five conditions stand for all, and each rig has a curve among them
    monkeypatch.setattr(surface_module, "LARGEST_EXACT_CURVE_COUNT", 5)
    monkeypatch.setattr(surface_module, "_INDUCING_CONDITIONS", 2)
    large = fit_surface(measured, fitted.law)
    chosen = np.unique(
        large.covariance.curves.curve_of_coordinate[large.posterior.inducing_indices]
    )
    assert set(large.covariance.curves.rig_of_curve[chosen]) == {0, 1, 2}


def test_the_sizes_of_a_large_campaign_come_from_curves_of_each_rig(measured, monkeypatch):
    # two curves are asked for, and there are three rigs
    monkeypatch.setattr(surface_module, "CURVE_COUNT_FOR_SIZES", 2)
    sample = surface_module._sample(measured.in_canonical_order())
    assert len(sample.conditions) < 6
    assert set(sample.rig_of_curve) == {0, 1, 2}


@pytest.mark.slow
@pytest.mark.parametrize("kind", quick_ones(["norm", "logn", "heavy"], ["logn"]))
@pytest.mark.parametrize("conditions", [CONFOUNDED, nightly(mixed_rigs())])
def test_interval_holds_new_runs_on_other_rigs(conditions, kind):
    # 95 % is claimed. Three campaigns of three other rigs: the 480 points of a campaign share
    # three rigs, so that the share inside scatters by several per cent
    shares = []
    for seed in range(3):
        random = np.random.default_rng(100 + seed)
        errors = PlantedErrors(rig_gain=0.01, kind=kind)
        measured = simulated(TRUTHS["own"], conditions, random, errors)
        surface = fit_surface(measured, fitted_law(measured))
        new = simulated(TRUTHS["own"], random_conditions(40, random), random, errors)
        prediction = surface.predict(new.point_conditions, new.slip, ANOTHER_RIG)
        lower, upper = prediction.interval(surface.interval_factors.point)
        shares.append(np.mean((lower <= new.mu) & (new.mu <= upper)))
    assert np.mean(shares) > 0.92
