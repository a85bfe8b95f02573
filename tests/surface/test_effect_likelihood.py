"""Likelihood of changes in the effects of runs."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.stats

from lawless_truths import TRUTHS
from oilfilm.surface import effect_likelihood as effect_likelihood_module
from oilfilm.surface.effect_likelihood import FIT_VARIANCE_INDEX, effect_likelihood
from oilfilm.surface.effects import EFFECT_NAMES
from oilfilm.surface.surface import fit_surface
from surface_campaigns import fitted_law, latin, simulated

SLIPS = np.geomspace(0.002, 0.3, 7)


@pytest.fixture(scope="module")
def covariance():
    measured = simulated(TRUTHS["jt"], latin(), np.random.default_rng(46), slips=SLIPS)
    return fit_surface(measured, fitted_law(measured)).misfit_covariance


@pytest.mark.parametrize("effect", EFFECT_NAMES)
def test_likelihood_is_that_of_the_normal_distribution(covariance, effect):
    likelihood = effect_likelihood(covariance, effect)
    number = EFFECT_NAMES.index(effect)
    pattern = np.linspace(-0.5, 0.5, len(covariance.curves.conditions))
    expected = covariance.sizes.effects[number] ** 2

    def log_density(ratio, size):
        sizes = covariance.sizes.effects.copy()
        sizes[number] = np.sqrt(ratio * expected)
        total = replace(covariance, sizes=replace(covariance.sizes, effects=sizes)).matrix()
        column = covariance.curves.effect_design[:, number]
        mean = size * pattern[covariance.curves.curve_of_coordinate] * column
        density = scipy.stats.multivariate_normal(mean, total).logpdf(covariance.curves.departure)
        # what is known of a size before the data: 0.6 in its logarithm
        return density - (np.log(ratio) / 2 / 0.6) ** 2 / 2

    ratios = effect_likelihood_module._VARIANCE_RATIOS
    size = 0.7 * np.sqrt(expected)
    first = log_density(1.0, 0.0)
    for chosen in (3, FIT_VARIANCE_INDEX, 22):
        information = likelihood.information(chosen)
        steady = (
            likelihood.twice_ln_steady_likelihoods()[chosen]
            - likelihood.twice_ln_steady_likelihoods()[FIT_VARIANCE_INDEX]
        )
        assert steady == pytest.approx(2 * (log_density(ratios[chosen], 0.0) - first), abs=1e-3)
        changed = 2 * size * information.vector @ pattern
        changed -= size**2 * pattern @ information.matrix_times(pattern)
        direct = 2 * (log_density(ratios[chosen], size) - log_density(ratios[chosen], 0.0))
        assert changed == pytest.approx(direct, rel=1e-4, abs=1e-4)


def test_features_of_all_conditions_give_the_exact_likelihood(covariance, monkeypatch):
    exact = {effect: effect_likelihood(covariance, effect) for effect in EFFECT_NAMES}
    monkeypatch.setattr(effect_likelihood_module, "LARGEST_EXACT_CURVE_COUNT", 1)
    featured = {effect: effect_likelihood(covariance, effect) for effect in EFFECT_NAMES}
    for effect in EFFECT_NAMES:
        difference = (
            exact[effect].twice_ln_steady_likelihoods()
            - featured[effect].twice_ln_steady_likelihoods()
        )
        assert np.ptp(difference) < 1e-2
        for number in (2, FIT_VARIANCE_INDEX, 25):
            left, right = exact[effect].information(number), featured[effect].information(number)
            unit = np.eye(len(left.vector))
            np.testing.assert_allclose(right.vector, left.vector, atol=1e-5 * np.ptp(left.vector))
            whole = left.matrix_times(unit)
            np.testing.assert_allclose(
                right.matrix_times(unit), whole, atol=1e-5 * np.abs(whole).max()
            )
            np.testing.assert_allclose(right.diagonal(), np.diag(right.matrix_times(unit)))
