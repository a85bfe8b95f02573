"""Sizes by restricted maximum likelihood: gradient, planted sizes, misfit of a law."""

import numpy as np
import pytest

from lawless_truths import DENG_CONSTANTS, TRUTHS
from oilfilm.surface import reml
from oilfilm.surface.effects import ErrorPriors, LogNormal
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.reduction import box_of, reduced_curves
from oilfilm.surface.reml import (
    MISFIT_KAPPA_PRIOR,
    most_likely_sizes,
    objective,
    priors,
    size_names,
)
from oilfilm.traction import PAPER_LAW
from surface_campaigns import PlantedErrors, fitted_law, grid, simulated

CUBE = grid((1.0, 1.25, 1.5), (25.0, 32.0, 40.0), (25.0, 72.0, 120.0))
LAW = FreeLaw(PAPER_LAW, DENG_CONSTANTS, np.ones(12, dtype=bool))
# Sizes of which hardly anything is known before the data.
OPEN = ErrorPriors(
    gain=LogNormal(median=0.004, ln_sd=2.0, smallest=1e-4, largest=0.2),
    zero=LogNormal(median=1e-4, ln_sd=2.0, smallest=1e-7, largest=5e-3),
    slip_scale=LogNormal(median=0.01, ln_sd=2.0, smallest=1e-4, largest=0.2),
    temperature_k=LogNormal(median=1.0, ln_sd=2.0, smallest=1e-2, largest=20.0),
    noise=LogNormal(median=0.006, ln_sd=2.0, smallest=5e-4, largest=0.2),
)


def curves_about(law, measured):
    ordered = measured.in_canonical_order()
    box = box_of(ordered)
    return reduced_curves(ordered, law, law.log_mu, 4e-5, box), box


@pytest.mark.parametrize("speeds", [(25.0, 40.0), (25.0, 32.0, 40.0)])
def test_gradient_is_that_of_differences(speeds):
    random = np.random.default_rng(5)
    conditions = grid((1.0, 1.25, 1.5), speeds, (25.0, 120.0))
    curves, box = curves_about(LAW, simulated(TRUTHS["jt"], conditions, random))
    known = priors(ErrorPriors(), MISFIT_KAPPA_PRIOR)
    place = np.log([prior.median for prior in known]) + 0.2 * random.standard_normal(len(known))
    _, gradient = objective(place, curves, box, known)
    for number, name in enumerate(size_names()):
        change = 1e-5 * np.eye(len(known))[number]
        above, _ = objective(place + change, curves, box, known)
        below, _ = objective(place - change, curves, box, known)
        assert gradient[number] == pytest.approx((above - below) / 2e-5, rel=1e-4, abs=1e-3), name


@pytest.mark.nightly
def test_planted_sizes_of_effects_are_found():
    # 54 runs of a true law: a size of n runs is known within a factor of 1 +- 1/sqrt(2 n) at best,
    # 10 %; a factor of 1.6 leaves room for effects that resemble each other
    planted = PlantedErrors(gain=0.012, zero=2e-4, slip_scale=0.03, temperature_k=2.0, noise=0.004)
    random = np.random.default_rng(6)
    # mu is above 0.004, so that its logarithm is linear in an error of 2e-4
    slips = np.geomspace(0.012, 0.3, 15)
    measured = simulated(TRUTHS["own"], np.repeat(CUBE, 2, axis=0), random, planted, slips)
    sizes = _most_likely(LAW, measured)
    found = (*sizes.effects, sizes.noise)
    expected = (0.012, 2e-4, 0.03, 2.0, 0.004)
    assert np.abs(np.log(np.divide(found, expected))).max() < np.log(1.6)


def test_planted_gain_and_noise_are_found_in_few_runs():
    planted = PlantedErrors(gain=0.03, zero=1e-6, slip_scale=1e-6, temperature_k=1e-3, noise=0.01)
    conditions = np.repeat(grid((1.0, 1.5), (25.0, 40.0), (25.0, 120.0)), 3, axis=0)
    sizes = _most_likely(
        LAW, simulated(TRUTHS["own"], conditions, np.random.default_rng(8), planted)
    )
    # 24 runs: 14 % at best
    assert sizes.effects[0] == pytest.approx(0.03, rel=0.5)
    assert sizes.noise == pytest.approx(0.01, rel=0.1)


@pytest.mark.slow
def test_misfit_tells_a_true_law_from_a_wrong_one():
    kappa = {}
    for name in ("own", "sol"):
        measured = simulated(TRUTHS[name], CUBE, np.random.default_rng(7))
        kappa[name] = _most_likely(fitted_law(measured), measured).departure_sizes.kappa
    # the limit below which constants of a law have standard errors
    assert kappa["own"] < 0.02 < kappa["sol"]


def test_a_search_that_is_cut_short_is_not_called_converged(monkeypatch):
    curves, box = curves_about(LAW, simulated(TRUTHS["jt"], CUBE, np.random.default_rng(9)))
    known = priors(ErrorPriors(), MISFIT_KAPPA_PRIOR)
    whole = most_likely_sizes(curves, box, known)
    monkeypatch.setattr(reml, "_ITERATIONS", 3)
    short = most_likely_sizes(curves, box, known)
    assert whole.converged and not short.converged
    # at a maximum no size gains by a change; 0.5 is the gain of one standard deviation
    assert largest_slope(whole, curves, box, known) < 0.5 < largest_slope(short, curves, box, known)


def test_sizes_are_those_where_the_slopes_vanish_wherever_the_search_begins():
    curves, box = curves_about(LAW, simulated(TRUTHS["own"], CUBE, np.random.default_rng(3)))
    known = priors(ErrorPriors(), MISFIT_KAPPA_PRIOR)
    found = most_likely_sizes(curves, box, known)
    # the likelihood rises by 1e-7 per 1e-4 of a logarithm there, which is lost in 10^4
    assert largest_slope(found, curves, box, known) < 1e-4
    beside = found.logarithms + np.random.default_rng(4).normal(0.0, 0.1, len(known))
    again = most_likely_sizes(curves, box, known, beside)
    np.testing.assert_allclose(again.logarithms, found.logarithms, atol=1e-6)


def largest_slope(found, curves, box, known):
    """Largest slope of the likelihood by the logarithm of a size that is at no bound."""
    _, slopes = objective(found.logarithms, curves, box, known)
    lower = np.log([prior.smallest for prior in known])
    upper = np.log([prior.largest for prior in known])
    is_inside = (found.logarithms > lower) & (found.logarithms < upper)
    return np.abs(slopes[is_inside]).max()


def _most_likely(law, measured):
    curves, box = curves_about(law, measured)
    return most_likely_sizes(curves, box, priors(OPEN, MISFIT_KAPPA_PRIOR)).sizes
