"""A law with free constants: values, slopes, bounds."""

import numpy as np
import pytest

from allocations import peak_bytes
from lawless_truths import DENG_CONSTANTS, TRUTHS
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.traction import PAPER_LAW

AT = np.array([[1.1, 28.0, 50.0], [1.4, 38.0, 110.0]])
SLIP = np.array([0.004, 0.2])


def law(constants=DENG_CONSTANTS, fixed=()):
    free = ~np.isin(np.arange(12), fixed)
    return FreeLaw(PAPER_LAW, constants, free)


def test_mu_is_that_of_the_equation():
    np.testing.assert_allclose(np.exp(law().log_mu(AT, SLIP)), TRUTHS["own"](*AT.T, SLIP))


def test_slopes_of_free_constants_are_those_of_differences():
    slopes = law(fixed=(3, 7)).log_slopes(AT, SLIP)
    free = np.flatnonzero(law(fixed=(3, 7)).is_free)
    for column, number in enumerate(free):
        change = 1e-6 * np.eye(12)[number]
        rise = law(DENG_CONSTANTS + change).log_mu(AT, SLIP)
        rise = rise - law(DENG_CONSTANTS - change).log_mu(AT, SLIP)
        np.testing.assert_allclose(slopes[:, column], rise / 2e-6, atol=1e-7)


def test_an_exponent_of_six_is_at_its_bound():
    constants = DENG_CONSTANTS.copy()
    constants[5] = 6.0
    assert np.flatnonzero(law(constants).is_at_bound()).tolist() == [5]
    # numbered among the free constants
    assert np.flatnonzero(law(constants, fixed=(3,)).is_at_bound()).tolist() == [4]
    assert not law().is_at_bound().any()


def test_a_law_on_other_conditions_gets_them_from_pressure_speed_and_temperature():
    doubled = FreeLaw(PAPER_LAW, DENG_CONSTANTS, np.ones(12, dtype=bool), lambda at: 2 * at)
    assert doubled.log_mu(AT, SLIP) == pytest.approx(law().log_mu(2 * AT, SLIP))


def test_mu_of_many_points_needs_little_more_memory_than_mu() -> None:
    """A million points took 230 MiB when the design of all was in memory."""
    count = 300_000
    conditions = np.tile([1.2, 30.0, 60.0], (count, 1))
    slip = np.linspace(0.001, 0.3, count)
    with peak_bytes() as peak:
        mu = np.exp(law().log_mu(conditions, slip))
    # mu, its logarithm, and the design of a block
    assert peak() < 8 * (3 * count + 40 * 2**16)
    ends = [0, 65_535, 65_536, count - 1]
    expected = TRUTHS["own"](*conditions[ends].T, slip[ends])
    assert mu[ends] == pytest.approx(expected, rel=1e-12)
