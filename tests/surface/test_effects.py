"""Effects of errors of runs on ln mu, and their sizes before the data."""

import numpy as np
import pytest

from oilfilm.surface.effects import LogNormal, effect_design


def test_effects_of_a_power_law_are_its_exponents():
    def log_mu(conditions, slip):
        return 0.5 * np.log(slip) - 0.01 * conditions[:, 2]

    at = np.array([[1.0, 20.0, 100.0]])
    gain, zero, slip_scale, temperature = effect_design(log_mu, at, np.array([0.04]))[0]
    assert gain == 1.0
    assert zero == pytest.approx(1 / (0.2 * np.exp(-1.0)))
    assert slip_scale == pytest.approx(0.5)
    assert temperature == pytest.approx(-0.01)


def test_a_power_of_a_temperature_near_zero_has_a_slope():
    def log_mu(conditions, slip):
        assert np.all(conditions[:, 2] > 0)
        return -0.5 * np.log(conditions[:, 2])

    conditions = np.array([[1.0, 20.0, 0.5], [1.0, 20.0, 1.0], [1.0, 20.0, 50.0]])
    temperature = effect_design(log_mu, conditions, np.full(3, 0.04))[:, 3]
    # chords of the next degree, and the derivative
    assert temperature[:2] == pytest.approx([-0.5 * np.log(3.0), -0.5 * np.log(2.0)])
    assert temperature[2] == pytest.approx(-0.01, rel=1e-3)


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ((0.01, 0.6, 0.02, 1.0), "is not between the smallest value 0.02"),
        ((0.01, 0.6, 0.0, 1.0), "all above 0"),
        ((0.01, 0.0, 0.001, 1.0), "ln_sd is 0; expected a number above 0"),
    ],
)
def test_an_impossible_size_of_an_error_is_refused(numbers, message):
    with pytest.raises(ValueError, match=message):
        LogNormal(**dict(zip(("median", "ln_sd", "smallest", "largest"), numbers, strict=True)))
