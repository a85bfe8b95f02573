"""The next curve of a linear law is the one that theory gives; shared errors never shrink."""

import numpy as np
import pytest

from oilfilm.fits.optimal_design import Information, choose
from oilfilm.units import FloatArray

GRID = np.linspace(-6, 6, 121)
NO_SENSOR = np.zeros((2, 1))


def line(x: FloatArray, variance: FloatArray | float = 1.0) -> Information:
    """What one point of a + b x at each x tells."""
    rows = np.stack([np.ones_like(x), x], axis=-1)
    outer = rows[:, :, np.newaxis] * rows[:, np.newaxis, :]
    scatter = np.broadcast_to(variance, x.shape)[:, np.newaxis, np.newaxis] * outer
    return Information(outer, scatter, np.zeros((len(x), 2, 1)))


def together(each: Information) -> Information:
    return Information(each.hessian.sum(axis=0), each.scatter.sum(axis=0), each.shared.sum(axis=0))


@pytest.mark.parametrize(("measured", "wanted"), [([-1.0, 1.0], 0.5), ([-2, -1, 0, 1, 2], 0.7)])
def test_best_point_for_one_value_of_a_line_moves_the_mean_there(
    measured: list[float], wanted: float
) -> None:
    # var(a + b x0) = 1/n + (x0 - mean)^2/Sxx is least, 1/(n + 1), where the new mean is x0
    known = together(line(np.array(measured, dtype=float)))
    design = choose(known, line(GRID), np.array([[1.0, wanted]]), 1)
    count = len(measured) + 1
    assert GRID[design.chosen[0]] == pytest.approx(count * wanted)
    assert design.after[0] ** 2 == pytest.approx(1 / count)
    assert design.alone.min() == pytest.approx(design.after[0])


def test_best_points_for_a_slope_are_the_two_ends() -> None:
    # var(b) = 1/Sxx is least where Sxx is greatest: at the ends of the range
    known = together(line(np.array([-0.5, 0.5])))
    design = choose(known, line(GRID), np.array([[0.0, 1.0]]), 2)
    assert sorted(GRID[design.chosen]) == [-6, 6]
    assert design.after[1] ** 2 == pytest.approx(1 / (2 * 0.25 + 2 * 36))


def test_plain_least_squares_can_lose_by_a_bad_curve_and_the_plan_knows() -> None:
    known = together(line(np.array([-1.0, 0.0, 1.0])))
    bad = line(np.array([0.0]), variance=1e4)
    gradients = np.array([[1.0, 0.0]])
    design = choose(known, bad, gradients, 1)
    # mean of four, one of them with variance 1e4
    assert design.after[0] ** 2 == pytest.approx((3 + 1e4) / 16)
    assert design.after[0] > design.before


def test_what_all_curves_share_is_not_reduced_by_more_of_them() -> None:
    sensor = line(GRID)
    # every reading is too high by 0.1 times a standard normal number, in all curves the same one
    shifted = Information(
        sensor.hessian, sensor.scatter, 0.1 * np.stack([np.ones_like(GRID), GRID], -1)[..., None]
    )
    many = together(shifted)
    level = np.array([[1.0, 0.0]])
    assert many.uncertainty(level) ** 2 == pytest.approx(1 / len(GRID) + 0.01)
    assert many.without_calibration().uncertainty(level) ** 2 == pytest.approx(1 / len(GRID))


def test_no_test_is_chosen_twice() -> None:
    known = together(line(np.array([-1.0, 1.0])))
    design = choose(known, line(np.array([0.0, 1.0, 2.0])), np.array([[1.0, 2.0]]), 9)
    assert sorted(design.chosen) == [0, 1, 2]
    assert (np.diff(design.after) < 0).all()
