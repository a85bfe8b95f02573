"""What two levels of a condition leave open."""

from dataclasses import replace

import numpy as np
import pytest

from lawless_truths import DENG_CONSTANTS
from oilfilm.surface.form_bends import form_bends
from oilfilm.surface.kernels import ConditionBox
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.measurements import LevelWidths, scaled_conditions
from oilfilm.traction import PAPER_LAW
from oilfilm.traction.laws.deng2026 import DENG_EXPONENTIAL

LAW = FreeLaw(PAPER_LAW, DENG_CONSTANTS, np.ones(12, dtype=bool))
LOWEST, HIGHEST = np.array([1.0, 25.0, 25.0]), np.array([1.5, 40.0, 120.0])


def box(level_counts):
    lowest, highest = scaled_conditions(np.stack([LOWEST, HIGHEST]))
    return ConditionBox(lowest, highest, np.array(level_counts), LevelWidths().scaled())


def test_a_power_law_and_an_exponential_agree_at_both_levels():
    at = np.stack([LOWEST, HIGHEST])
    np.testing.assert_allclose(form_bends(LAW, box((2, 2, 2)), at, np.full(2, 0.05)), 0, atol=1e-12)


def test_the_bend_is_the_difference_of_a_power_law_and_an_exponential():
    # at lowest slip mu is (B + A C) S: ln mu falls by D between 25 and 120 degC
    slip = np.array([1e-7])
    at = np.array([[1.2, 30.0, 72.5]])
    cold, hot = at.copy(), at.copy()
    cold[:, 2], hot[:, 2] = 25.0, 120.0
    low, middle, high = (np.exp(LAW.log_mu(c, slip)) for c in (cold, at, hot))
    exponential = np.sqrt(low * high)
    (bend,) = form_bends(LAW, box((3, 3, 2)), at, slip)
    # the two terms of the slope have powers of T of their own: nearly a power law
    assert bend == pytest.approx(np.log(middle / exponential), rel=0.05)


@pytest.mark.parametrize("lowest_c", [0.0, -10.0])
def test_between_levels_in_frost_no_power_of_the_temperature_is_expected(lowest_c):
    # a power of a temperature in degC has no value there, so that the paper's law is not asked
    box_in_frost = replace(box((3, 3, 2)), lowest=scaled_conditions([[1.0, 25.0, lowest_c]])[0])
    at = np.array([[1.2, 30.0, 20.0], [1.2, 30.0, -5.0]])
    assert form_bends(LAW, box_in_frost, at, np.full(2, 0.05)).tolist() == [[0.0], [0.0]]


def test_a_power_of_the_temperature_is_far_from_an_exponential_in_frost():
    # ln(1/1000) / ln(120/25) is -4.4 in place of -0.3, so that 4 D is left open
    law = FreeLaw(DENG_EXPONENTIAL, DENG_CONSTANTS, np.ones(12, dtype=bool))
    at, slip = (
        np.array([[1.2, 30.0, -5.0], [1.2, 30.0, 25.0], [1.2, 30.0, 120.0]]),
        np.full(3, 0.05),
    )
    _, cold, hot = law.log_mu(at, slip)
    bend_in_frost = form_bends(law, box((3, 3, 2)), at, slip)[0, 0]
    assert bend_in_frost == pytest.approx(-4.09 * (hot - cold), rel=0.01)


def test_three_levels_leave_no_form_open():
    assert form_bends(LAW, box((3, 4, 3)), np.stack([LOWEST]), np.array([0.05])).shape == (1, 0)


@pytest.mark.parametrize("without_traction", [-0.001, 0.0])
def test_a_level_at_which_the_law_has_no_traction_leaves_much_open(without_traction):
    class Law:
        """mu is 0.03 above 50 degC, at the second slip nowhere."""

        def log_mu(self, conditions, slip):
            has_traction = (conditions[:, 2] > 50) & (slip < 0.1)
            with np.errstate(invalid="ignore", divide="ignore"):
                return np.log(np.where(has_traction, 0.03, without_traction))

    at = np.array([[1.2, 30.0, 60.0], [1.2, 30.0, 60.0]])
    bend, bend_without_traction = form_bends(Law(), box((3, 3, 2)), at, np.array([0.05, 0.2]))
    # g is ln(60/25) / ln(120/25) - 35/95
    assert bend == pytest.approx((0.5581 - 0.3684) * np.log(1e3), rel=1e-3)
    assert bend_without_traction == 0
