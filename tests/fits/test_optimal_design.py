"""The next curve of a linear law is that of theory; no curve makes anything less certain."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from oilfilm.base.units import FloatArray
from oilfilm.fits.measured_curves import choose_curves, rms_uncertainty, uncertainties

GRID = np.linspace(-6, 6, 121)


def line(x: FloatArray, variance: FloatArray | float = 1.0) -> FloatArray:
    """What one point of a + b x at each x tells."""
    rows = np.stack([np.ones_like(x), x], axis=-1)
    outer = rows[:, :, np.newaxis] * rows[:, np.newaxis, :]
    return np.asarray(outer / np.broadcast_to(variance, x.shape)[:, np.newaxis, np.newaxis])


def together(x: list[float]) -> FloatArray:
    return np.asarray(line(np.array(x, dtype=float)).sum(axis=0))


@pytest.mark.parametrize(("measured", "wanted"), [([-1.0, 1.0], 0.5), ([-2, -1, 0, 1, 2], 0.7)])
def test_best_point_for_a_value_moves_the_mean_there(measured: list[float], wanted: float) -> None:
    # var(a + b x0) = 1/n + (x0 - mean)^2/Sxx is least, 1/(n + 1), where the new mean is x0
    design = choose_curves(together(measured), line(GRID), np.array([[1.0, wanted]]), 1)
    count = len(measured) + 1
    assert GRID[design.chosen_indices[0]] == pytest.approx(count * wanted)
    assert design.uncertainty_after[0] ** 2 == pytest.approx(1 / count)
    assert design.uncertainty_with_one.min() == pytest.approx(design.uncertainty_after[0])


def test_best_points_for_a_slope_are_the_two_ends() -> None:
    # var(b) = 1/Sxx is least where Sxx is greatest: at the ends of the range
    design = choose_curves(together([-0.5, 0.5]), line(GRID), np.array([[0.0, 1.0]]), 2)
    assert sorted(GRID[design.chosen_indices]) == [-6, 6]
    assert design.uncertainty_after[1] ** 2 == pytest.approx(1 / (2 * 0.25 + 2 * 36))


@given(st.floats(1e-3, 1e6), st.floats(-6, 6), st.floats(-1, 1))
def test_no_curve_makes_anything_less_certain(variance: float, x: float, at: float) -> None:
    known, gradients = together([-1.0, 0.0, 1.0]), np.array([[1.0, at], [0.0, 1.0]])
    more = known + line(np.array([x]), variance)[0]
    assert (uncertainties(more, gradients) <= uncertainties(known, gradients) * (1 + 1e-9)).all()


def test_what_all_curves_share_is_not_reduced_by_more_of_them() -> None:
    # every reading is too high by 0.1 times a standard normal number, in all curves the same one:
    # a parameter of its own, known to 1 before
    rows = np.stack([np.ones_like(GRID), GRID, np.full_like(GRID, 0.1)], axis=-1)
    many = rows.T @ rows + np.diag([0, 0, 1])
    level = np.array([[1.0, 0.0, 0.0]])
    assert rms_uncertainty(many, level) ** 2 == pytest.approx(1 / len(GRID) + 0.01)
    assert rms_uncertainty(many[:2, :2], level[:, :2]) ** 2 == pytest.approx(1 / len(GRID))


def test_no_test_is_chosen_twice_and_none_that_is_not_worth_it() -> None:
    candidates, level = line(np.array([0.0, 1.0, 2.0])), np.array([[1.0, 2.0]])
    design = choose_curves(together([-1.0, 1.0]), candidates, level, 9)
    assert sorted(design.chosen_indices) == [0, 1, 2]
    assert (np.diff(design.uncertainty_after) < 0).all()
    # one further point in a thousand: 1 - sqrt(1000/1001) = 0.05 %
    mean = together([0.0, 1e-3]) * 500
    assert choose_curves(
        mean, line(np.zeros(1)), np.array([[1.0, 0.0]]), 1, 1e-4
    ).chosen_indices == [0]
    assert (
        choose_curves(mean, line(np.zeros(1)), np.array([[1.0, 0.0]]), 1, 1e-3).chosen_indices == []
    )
