"""The traction law: closed forms of its equation, its paper."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from campaigns import printed
from fit_points import matrix
from oilfilm.traction import LAWS
from oilfilm.traction.law import Observations, to_constants, to_internal
from oilfilm.traction.laws.deng2026 import traction_coefficient

LAW = LAWS["deng2026"]
OILS = ("4102", "4050", "4010")
MATRIX = np.array(matrix())
box = st.tuples(st.floats(0.8, 2.5), st.floats(20, 200), st.floats(20, 140))


def observe(conditions: np.ndarray, slip: np.ndarray) -> Observations:
    curve = np.repeat(np.arange(len(conditions)), len(slip))
    return Observations(LAW.design(conditions), curve, np.tile(slip, len(conditions)))


@pytest.mark.parametrize("oil", OILS)
def test_traction_over_the_matrix_stays_where_the_reconstruction_says(oil: str) -> None:
    # the reconstruction of the signs was chosen so that mu stays within 0..0.035 on the matrix; on
    # a fine grid of slip 4010 reaches 0.0393 (1.5 GPa, 25 m/s, 25 degC, S 0.03)
    mu = traction_coefficient(printed()[oil], *MATRIX.T[:, :, None], np.linspace(0, 0.3, 61))
    assert mu.min() >= 0
    assert 0.02 < mu.max() < (0.040 if oil == "4010" else 0.035)


@given(condition=box, oil=st.sampled_from(OILS))
def test_curve_has_its_closed_form(condition: tuple[float, float, float], oil: str) -> None:
    """Slope B - A C at rest, one peak at 1/C - A/B, where d mu/dS vanishes, and -A far out."""
    a, b, c = local(oil, condition)
    peak = 1 / c - a / b
    slips = np.array([0.0, 1e-7, 0.99 * peak, peak, 1.01 * peak, 60 / c])
    mu = traction_coefficient(printed()[oil], *condition, slips)
    assert mu[0] == 0
    assert mu[1] / 1e-7 == pytest.approx(b - a * c, rel=1e-4)
    assert mu[3] >= max(mu[2], mu[4])
    assert mu[5] == pytest.approx(-a, rel=1e-12)


def local(oil: str, condition: tuple[float, float, float]) -> np.ndarray:
    internal = to_internal(LAW, printed()[oil])
    return LAW.magnitudes(internal, LAW.design(np.array(condition)))[:, 0] * [-1, 1, 1]


@pytest.mark.parametrize("oil", OILS)
def test_internal_form_is_the_printed_equation(oil: str) -> None:
    slip = np.linspace(0, 0.3, 31)
    internal = to_internal(LAW, printed()[oil])
    direct = traction_coefficient(printed()[oil], *MATRIX.T[:, :, None], slip).ravel()
    observations = observe(MATRIX, slip)
    np.testing.assert_allclose(LAW.traction(internal, observations), direct, rtol=1e-12, atol=1e-16)
    np.testing.assert_allclose(to_constants(LAW, internal), printed()[oil], rtol=1e-14)


def test_wrong_sign_and_impossible_conditions_are_refused() -> None:
    with pytest.raises(ValueError, match="A0 must be of sign -1"):
        to_internal(LAW, np.abs(printed()["4102"]))
    with pytest.raises(ValueError, match="above zero"):
        LAW.design(np.array([1.0, 30.0, -5.0]))
