"""Covariance of two oils: its slopes, and the common part that cancels in pairs."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.optimize

from lawless_truths import DENG_CONSTANTS, TRUTHS
from oilfilm.surface.effects import ErrorPriors
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.pair_covariance import PairCovariance, PairSizes, pair_objective, pair_priors
from oilfilm.surface.ratio import RunsOfPair
from oilfilm.surface.reduction import box_of
from oilfilm.traction import PAPER_LAW
from planted_pairs import scaled_oil
from surface_campaigns import random_conditions, simulated

KNOWN = pair_priors(ErrorPriors())
INDEX_OF_FIT = np.log([prior.median for prior in KNOWN])


@pytest.fixture(scope="module")
def runs():
    random = np.random.default_rng(31)
    conditions, slips = random_conditions(6, random), np.geomspace(0.003, 0.3, 5)
    oils = [
        simulated(truth, conditions, random, slips=slips)
        for truth in (TRUTHS["jt"], scaled_oil(TRUTHS["jt"]))
    ]
    return RunsOfPair(*(oil.in_canonical_order() for oil in oils))


@pytest.fixture(scope="module")
def curves(runs):
    law = FreeLaw(PAPER_LAW, DENG_CONSTANTS, np.ones(12, dtype=bool))
    return runs.reduced_curves(law, (law.log_mu, law.log_mu), 4e-5)


def test_slopes_of_the_likelihood_are_those_of_differences(runs, curves):
    def covariance_of(sizes):
        return PairCovariance.from_curves(curves, box_of(runs.stacked), runs.oil_of_curve, sizes)

    start = INDEX_OF_FIT + 0.1
    _, slopes = pair_objective(start, covariance_of, KNOWN)
    by_differences = scipy.optimize.approx_fprime(
        start, lambda logarithms: pair_objective(logarithms, covariance_of, KNOWN)[0], 1e-6
    )
    np.testing.assert_allclose(slopes, by_differences, rtol=1e-3, atol=2e-3)


def test_in_pairs_the_ratio_depends_on_differences_only(runs, curves):
    # both oils with the same design of effects: sums and differences are then independent
    half = len(curves.departure) // 2
    same = replace(curves, effect_design=np.vstack([curves.effect_design[:half]] * 2))
    sizes = PairSizes.from_logarithms(INDEX_OF_FIT)
    pair = PairCovariance.from_curves(same, box_of(runs.stacked), runs.oil_of_curve, sizes)
    covariance = pair.matrix()
    across = pair.ratio_covariance_at(pair.all_coordinates)[:half]
    ratio = across @ np.linalg.solve(covariance, curves.departure)

    # the textbook formula on the differences alone, whatever both share
    difference = np.hstack([-np.eye(half), np.eye(half)])
    ratio_alone = (
        across
        @ difference.T
        @ np.linalg.solve(difference @ covariance @ difference.T, difference @ curves.departure)
    )
    np.testing.assert_allclose(ratio, ratio_alone, atol=1e-8)
    shared = np.sin(np.arange(half))
    with_shared = across @ np.linalg.solve(covariance, curves.departure + np.tile(shared, 2))
    np.testing.assert_allclose(with_shared, ratio, atol=1e-8)


def test_caution_never_makes_a_departure_smaller():
    sizes = PairSizes.from_logarithms(INDEX_OF_FIT)
    cautious = sizes.with_caution()
    assert cautious.ratio_sizes.departure_sizes.kappa > sizes.ratio_sizes.departure_sizes.kappa
    assert cautious.common_sizes is sizes.common_sizes
