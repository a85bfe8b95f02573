"""Continuation against curves that are known in closed form."""

import numpy as np
import pytest

from oilfilm.bearing.continuation import trace

ONE = np.ones((1, 1))


def cubic(unknowns: np.ndarray, level: np.ndarray, _: np.ndarray) -> np.ndarray:
    """x^3 - 3 x = level: folds at x = -1 and 1, levels 2 and -2."""
    return np.asarray(unknowns**3 - 3 * unknowns - level[..., np.newaxis])


def test_a_curve_with_two_folds_is_crossed_at_all_three_roots():
    start = np.array([[-2.5]])
    level = cubic(start, np.zeros(1), np.arange(1))[:, 0]
    crossings = trace(
        cubic, start, ONE, level, wanted_value=0.0, first_value=-100.0, last_value=5.0
    )
    # x^3 - 3 x = 0
    np.testing.assert_allclose(crossings.unknowns[:, 0], [-np.sqrt(3), 0.0, np.sqrt(3)], atol=2e-3)
    assert crossings.reached_last_value.all()
    assert not crossings.turned_back.any()


def test_every_curve_is_followed_by_itself():
    starts = np.array([[-2.5], [-3.0], [-2.2]])
    level = cubic(starts, np.zeros(3), np.arange(3))[:, 0]
    crossings_together = trace(cubic, starts, np.ones((3, 1)), level, 0.0, -100.0, 5.0)
    assert crossings_together.point_index.tolist() == [0, 0, 0, 1, 1, 1, 2, 2, 2]
    for curve_index in range(3):
        curve_slice = slice(curve_index, curve_index + 1)
        crossings_alone = trace(
            cubic, starts[curve_slice], ONE, level[curve_slice], 0.0, -100.0, 5.0
        )
        np.testing.assert_array_equal(
            crossings_together.unknowns[crossings_together.point_index == curve_index],
            crossings_alone.unknowns,
        )


def test_a_curve_that_turns_back_says_so():
    # x^2 = 1 - level: from x = 1 through the fold at level 1 and back
    def parabola(unknowns, level, _):
        return unknowns**2 - 1 + level[..., np.newaxis]

    crossings = trace(
        parabola, ONE, ONE, np.zeros(1), wanted_value=2.0, first_value=0.0, last_value=2.0
    )
    assert crossings.turned_back.all()
    assert not crossings.reached_last_value.any()
    assert len(crossings.point_index) == 0


def test_a_pair_of_crossings_within_one_step_is_seen():
    # level = 0.501 - x^2/100 passes 0.5 at x = -sqrt(0.1) and back at sqrt(0.1)
    def flat(unknowns, level, _):
        return 0.501 - unknowns**2 / 100 - level[..., np.newaxis]

    start = np.array([[-1.0]])
    crossings = trace(
        flat, start, ONE, np.array([0.491]), wanted_value=0.5, first_value=0.0, last_value=1.0
    )
    np.testing.assert_allclose(crossings.unknowns[:, 0], [-np.sqrt(0.1), np.sqrt(0.1)], rtol=1e-3)


def test_a_curve_without_a_direction_stalls_and_leaves_the_others_alone():
    # level = x, but from level 0.5 on nothing depends on the second curve's x, nor on the level
    def loose(unknowns, level, curve_index):
        is_loose = (curve_index == 1) & (level > 0.5)
        return np.where(is_loose, 0.0, unknowns[..., 0] - level)[..., np.newaxis]

    starts = np.zeros((2, 1))
    crossings = trace(loose, starts, np.ones((2, 1)), np.zeros(2), 0.9, -1.0, 1.0)
    assert crossings.reached_last_value.tolist() == [True, False]
    assert crossings.point_index.tolist() == [0]
    np.testing.assert_allclose(crossings.unknowns, [[0.9]], rtol=1e-9)


@pytest.mark.parametrize("kink", [0.0, 1e-3])
def test_a_kink_stalls_a_curve_unless_its_steps_may_turn(kink):
    # level = x, then level = x/10: the tangent turns by 39 degrees, whatever the step
    def bent(unknowns, level, _):
        return np.where(unknowns < 1, unknowns, 1 + (unknowns - 1) / 10) - level[..., np.newaxis]

    crossings = trace(bent, 0 * ONE, ONE, np.zeros(1), 1.05, -1.0, 1.1, kink_length=kink)
    assert crossings.reached_last_value.tolist() == [kink > 0]
    if kink:
        np.testing.assert_allclose(crossings.unknowns, [[1.5]], atol=1e-6)


@pytest.mark.parametrize("kink", [0.0, 1.0])
def test_a_curve_that_takes_only_steps_below_the_kink_length_is_given_up(kink):
    # level = x: no step is longer than 0.4, so that 61 of them come no farther than level 25
    def line(unknowns, level, _):
        return unknowns - level[..., np.newaxis]

    crossings = trace(line, 0 * ONE, ONE, np.zeros(1), 50.0, -1.0, 60.0, kink_length=kink)
    assert crossings.reached_last_value.tolist() == [kink == 0]
    assert not crossings.turned_back.any()
    if kink:
        assert 5.0 < crossings.end_parameter[0] < 25.0
