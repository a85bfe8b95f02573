"""Where a surface gives no answer."""

import numpy as np
import pytest

from oilfilm.surface.kernels import ConditionBox
from oilfilm.surface.limits import SurfaceLimits
from oilfilm.surface.measurements import LevelWidths, Measurements, scaled_conditions, scaled_slip
from oilfilm.surface.support import SlipCoverage, Support, support_codes

DEFAULTS = SurfaceLimits()
NOTHING_AT_BOUND = np.zeros((1, 0))


def coverage(slips):
    slips = np.array(slips)
    conditions = np.array([[1.0, 20.0, 40.0], [1.5, 20.0, 40.0]])
    curve = np.repeat([0, 1], len(slips))
    both = np.tile(slips, 2)
    return SlipCoverage.from_measurements(Measurements(conditions, curve, both, 0.5 * both))


def code(slips, slip, spread=0.01, of_constants=NOTHING_AT_BOUND, limits=DEFAULTS, beyond=0.0):
    point, spreads, distance_in_ranges = np.array([slip]), np.array([spread]), np.array([beyond])
    return support_codes(limits, coverage(slips), point, spreads, of_constants, distance_in_ranges)[
        0
    ]


def test_widest_gap_is_that_of_a_curve():
    gap = scaled_slip(np.array([0.25])) - scaled_slip(np.array([0.05]))
    assert coverage([0.01, 0.05, 0.25]).widest_gap == pytest.approx(gap[0])


@pytest.mark.parametrize(
    ("slips", "slip", "expected"),
    [
        ((0.01, 0.03, 0.09, 0.27), 0.16, Support.SUPPORTED),
        # more than a factor of 1.8 from both: a maximum of mu may be there
        ((0.005, 0.012, 0.06, 0.26), 0.13, Support.FAR_FROM_TESTED_SLIPS),
        # a factor of 2.2 from both, but small
        ((0.01, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3), 0.022, Support.SUPPORTED),
        ((0.01, 0.05, 0.25), 0.12, Support.FAR_FROM_TESTED_SLIPS),
        ((0.012, 0.06, 0.26), 0.13, Support.FAR_FROM_TESTED_SLIPS),
        ((0.1, 0.15, 0.2, 0.3), 0.01, Support.FAR_FROM_TESTED_SLIPS),
        # farther than a quarter of the widest gap below the lowest slip
        ((0.01, 0.03, 0.09, 0.27), 0.007, Support.FAR_FROM_TESTED_SLIPS),
        ((0.01, 0.03, 0.09, 0.27), 0.008, Support.SUPPORTED),
        ((0.01, 0.03, 0.09, 0.27), 0.9, Support.FAR_FROM_TESTED_SLIPS),
        ((0.02, 0.06), 0.035, Support.FEW_SLIPS),
        ((0.02, 0.2), 0.2, Support.SUPPORTED),
        # 2 % of a slip is the scatter of a set point
        ((0.02, 0.0202, 0.06), 0.035, Support.FEW_SLIPS),
    ],
)
def test_slips_far_from_tested_ones_have_no_support(slips, slip, expected):
    assert code(slips, slip) == expected


def test_a_surface_that_is_not_known_within_fifteen_percent_has_no_support():
    assert code((0.01, 0.05, 0.25), 0.05, spread=0.149) == Support.SUPPORTED
    assert code((0.01, 0.05, 0.25), 0.05, spread=0.151) == Support.SPREAD_TOO_LARGE


def test_a_constant_at_its_bound_counts_where_it_moves_mu():
    slips = (0.01, 0.03, 0.09, 0.27)
    assert code(slips, 0.05, of_constants=np.array([[0.001, 0.06]])) == Support.CONSTANT_AT_BOUND
    assert code(slips, 0.05, of_constants=np.array([[0.001, 0.04]])) == Support.SUPPORTED


@pytest.mark.parametrize(
    ("limits", "slip", "spread", "of_constants"),
    [
        (SurfaceLimits(largest_spread=0.009), 0.05, 0.01, NOTHING_AT_BOUND),
        (SurfaceLimits(fewest_slips=5), 0.15, 0.01, NOTHING_AT_BOUND),
        # 0.15 is 0.46 of the gap above 0.09, and 1.67 times as large
        (SurfaceLimits(reach_in_gaps=0.4), 0.15, 0.01, NOTHING_AT_BOUND),
        (SurfaceLimits(reach_in_slip=1.5), 0.15, 0.01, NOTHING_AT_BOUND),
        (SurfaceLimits(largest_spread_of_bound=0.01), 0.05, 0.01, np.array([[0.02]])),
    ],
)
def test_a_stricter_limit_takes_the_support_from_an_answer(limits, slip, spread, of_constants):
    slips = (0.01, 0.03, 0.09, 0.27)
    assert code(slips, slip, spread, of_constants) == Support.SUPPORTED
    assert code(slips, slip, spread, of_constants, limits) != Support.SUPPORTED


@pytest.mark.parametrize(
    "impossible",
    [
        *({"level": 95}, {"largest_spread": 0}, {"fewest_slips": -1}),
        *({"reach_in_gaps": 0}, {"reach_in_slip": 1}),
    ],
)
def test_a_limit_that_means_nothing_is_refused_by_its_name(impossible):
    with pytest.raises(ValueError, match=next(iter(impossible))):
        SurfaceLimits(**impossible)


@pytest.mark.parametrize(
    ("beyond", "expected"),
    [
        (0.4, Support.SUPPORTED),
        (0.6, Support.FAR_FROM_TESTED_CONDITIONS),
        (np.inf, Support.CONDITION_NOT_VARIED),
    ],
)
def test_conditions_far_beyond_the_tested_ones_have_no_support(beyond, expected):
    assert code((0.01, 0.05, 0.25), 0.05, beyond=beyond) == expected


def test_distance_from_the_box_is_in_tested_ranges():
    # pressures of 1 to 1.5 GPa, speeds of 20 to 40 m/s, one temperature
    lowest, highest = scaled_conditions(np.array([[1.0, 20.0, 70.0], [1.5, 40.0, 70.0]]))
    box = ConditionBox(lowest, highest, np.array([3, 3, 1]), LevelWidths().scaled())
    at = np.array([[1.2, 30.0, 70.0], [1.5, 80.0, 70.0], [1.5, 30.0, 100.0]])
    beyond = box.distance_in_ranges(box.centred(scaled_conditions(at)))
    # twice the highest speed is one range of a factor of two
    np.testing.assert_allclose(beyond, [0.0, 1.0, np.inf])
