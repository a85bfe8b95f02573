"""Points as arrays: scales, levels, canonical order, what is refused."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from oilfilm.surface.measurements import LevelWidths, Measurements, scaled_conditions, scaled_slip


def points(conditions, per_curve=2):
    curve = np.repeat(np.arange(len(conditions)), per_curve)
    slip = np.tile(np.linspace(0.01, 0.1, per_curve), len(conditions))
    return Measurements(np.array(conditions, dtype=float), curve, slip, 0.5 * slip)


def test_scaled_slip_is_linear_at_low_slip_and_logarithmic_above():
    assert scaled_slip(np.array([3e-6])) == pytest.approx(1e-3, rel=1e-6)
    step = scaled_slip(np.array([0.3])) - scaled_slip(np.array([0.15]))
    assert step == pytest.approx(np.log(2), rel=1e-3)


def test_one_unit_of_distance_is_the_stated_change_of_each_condition():
    low = scaled_conditions(np.array([[1.0, 20.0, 40.0]]))
    high = scaled_conditions(np.array([[np.exp(0.6), 20 * np.exp(1.5), 115.0]]))
    np.testing.assert_allclose(high - low, 1.0, rtol=1e-12)


def test_set_points_that_scatter_are_one_level():
    # a rig holds a set point within 1 % of P, 2 % of U and 2 K (see gates)
    random = np.random.default_rng(4)
    set_points = np.array(list(itertools.product((1.0, 1.5), (20.0, 30.0), (25.0, 120.0))))
    scatter = random.uniform(-1, 1, (20, 8, 3)) * (0.0099, 0.0199, 0)
    measured = set_points * np.exp(scatter)
    measured[..., 2] += random.uniform(-2, 2, (20, 8))
    conditions = measured.reshape(-1, 3)[random.permutation(160)]
    assert points(conditions).level_numbers().max(axis=0).tolist() == [1, 1, 1]


def test_a_campaign_may_state_narrower_levels():
    conditions = [(1.0, 20.0, 40.0), (1.0, 20.0, 43.0)]
    wide = points(conditions)
    narrow = replace(wide, level_widths=LevelWidths(temperature_k=2.0))
    assert wide.condition_of_curve().tolist() == [0, 0]
    assert narrow.condition_of_curve().tolist() == [0, 1]
    assert narrow.in_canonical_order().level_widths == narrow.level_widths


def test_levels_are_those_of_the_configuration_unless_a_campaign_states_others(config):
    same = config.same_condition
    assert LevelWidths() == LevelWidths(
        same.max_hertz_pressure, same.entrainment_speed, same.inlet_temperature_c
    )


def test_a_dense_row_of_values_is_not_one_level():
    # neighbours are nearer to each other than the width of a level
    conditions = np.column_stack([np.ones(101), np.full(101, 20.0), np.linspace(25, 125, 101)])
    assert points(conditions).level_numbers()[:, 2].max() == 20


def test_repeated_runs_share_a_condition():
    conditions = [(1.0, 20.0, 40.0), (1.5, 20.0, 40.0), (1.0, 20.1, 40.5)]
    first, other, repeated = points(conditions).condition_of_curve()
    assert first == repeated != other


def test_the_canonical_order_does_not_depend_on_the_order_of_curves_and_points():
    random = np.random.default_rng(1)
    measured = points(random.uniform(1, 2, (6, 3)), per_curve=4)
    curves = random.permutation(6)
    rows = random.permutation(24)
    mixed = Measurements(
        measured.conditions[curves],
        np.argsort(curves)[measured.curve_of_point][rows],
        measured.slip[rows],
        measured.mu[rows],
    )
    one, other = measured.in_canonical_order(), mixed.in_canonical_order()
    for name in ("conditions", "curve_of_point", "slip", "mu"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"slip": np.array([0.0, 0.1])}, "is not above 0"),
        ({"mu": np.array([np.nan, 0.1])}, "not finite"),
        ({"mu": np.array([0.1])}, "expected one of each per point"),
        ({"conditions": np.array([[1.0, 20.0, 40.0]] * 2)}, "has no point"),
        ({"conditions": np.array([[0.0, 20.0, 40.0]])}, "not above 0"),
        ({"conditions": np.array([[1.0, 0.0, 40.0]])}, "not above 0"),
        ({"conditions": np.array([[1.0, 20.0, np.nan]])}, "not finite"),
        ({"conditions": np.array([[1.0, 20.0]])}, "expected \\(curves, 3\\)"),
    ],
)
def test_bad_arrays_are_refused_with_what_was_found(change, message):
    good = points([(1.0, 20.0, 40.0)])
    arrays = {name: getattr(good, name) for name in ("conditions", "curve_of_point", "slip", "mu")}
    with pytest.raises(ValueError, match=message):
        Measurements(**{**arrays, **change})
