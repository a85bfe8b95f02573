"""The intervals cover the planted truth as often as they say (short; `make bench-coverage`)."""

import itertools

import numpy as np
import pytest

from campaigns import printed
from fit_points import LAW
from oilfilm.fits.engine import polish
from oilfilm.fits.problem import build_problem
from oilfilm.fits.uncertainty import curve_bootstrap, naive_covariance
from oilfilm.randomness import generator
from oilfilm.rig_twin.plateaus import simulate_curves
from oilfilm.settings.resolved import Settings
from oilfilm.traction.law import to_internal
from oilfilm.traction.laws.deng2026 import traction_coefficient


@pytest.fixture(scope="module")
def conditions(config: Settings) -> np.ndarray:
    return np.array(list(itertools.product(*config.campaign.matrix.model_dump().values())))


@pytest.mark.no_cover
def test_curve_bootstrap_covers_the_truth_and_naive_errors_do_not(
    config: Settings, conditions: np.ndarray
) -> None:
    truth = to_internal(LAW, printed()["4050"])
    rig = next(iter(config.rigs.values()))
    inside, naive = [], []
    for number in range(24):
        random = generator(1, "coverage", number)
        data = simulate_curves(printed()["4050"], conditions, config.campaign.twin, rig, random)
        problem = build_problem(LAW, data, np.ones(3, dtype=bool))
        best = polish(problem, truth)
        refits = curve_bootstrap(problem, best, 200, random)
        lower, upper = np.quantile(refits, [0.025, 0.975], axis=0)
        inside.append((lower <= truth) & (truth <= upper))
        errors = np.sqrt(np.diag(naive_covariance(problem, best)))
        naive.append(np.abs(best.values - truth) <= 1.96 * errors)
    # 24 campaigns of 12 constants that move together know a share of 95 % to about 3 %
    assert 0.88 < np.mean(inside) < 0.995
    assert np.mean(naive) < 0.7


NO_ERRORS = {
    "noise_of_full_scale": 0.0,
    "control_load": 0.0,
    "control_speed": 0.0,
    "control_temperature_c": 0.0,
    "systematic_temperature_c": 0.0,
}


@pytest.mark.parametrize("systematic_load", [0.0, 0.005])
def test_a_load_that_reads_high_lowers_mu_and_raises_the_pressure(
    config: Settings, conditions: np.ndarray, systematic_load: float
) -> None:
    """mu = F/W and P ~ W^(1/3): with W read a factor g high, mu P^3 stays what it was."""
    twin = config.campaign.twin.model_copy(update={**NO_ERRORS, "systematic_load": systematic_load})
    rig = next(iter(config.rigs.values()))
    data = simulate_curves(printed()["4102"], conditions, twin, rig, generator(1, "x"))
    gain = (data.conditions[:, 0] / conditions[:, 0]) ** 3
    assert np.std(gain) == pytest.approx(systematic_load, rel=0.3, abs=1e-12)
    nominal = traction_coefficient(printed()["4102"], *conditions[data.curve].T, data.slip)
    np.testing.assert_allclose(data.mu * gain[data.curve], nominal, rtol=1e-9, atol=1e-15)
