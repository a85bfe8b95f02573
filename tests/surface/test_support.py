"""Where a surface gives no answer."""

import numpy as np
import pytest

from oilfilm.surface.measurements import Measurements, scaled_slip
from oilfilm.surface.support import SlipCoverage, Support, support_codes

NOTHING_AT_BOUND = np.zeros((1, 0))


def coverage(slips):
    slips = np.array(slips)
    conditions = np.array([[1.0, 20.0, 40.0], [1.5, 20.0, 40.0]])
    curve = np.repeat([0, 1], len(slips))
    both = np.tile(slips, 2)
    return SlipCoverage.of_measurements(Measurements(conditions, curve, both, 0.5 * both))


def code(slips, slip, spread=0.01, of_constants=NOTHING_AT_BOUND):
    point, at_level = np.array([slip]), np.zeros(1, dtype=bool)
    return support_codes(coverage(slips), point, np.array([spread]), of_constants, at_level)[0]


def test_reach_is_half_the_widest_gap():
    gap = scaled_slip(np.array([0.25])) - scaled_slip(np.array([0.05]))
    assert coverage([0.01, 0.05, 0.25]).reach == pytest.approx(gap[0] / 2)


@pytest.mark.parametrize(
    ("slips", "slip", "expected"),
    [
        ((0.01, 0.05, 0.25), 0.12, Support.SUPPORTED),
        ((0.1, 0.15, 0.2, 0.3), 0.01, Support.FAR_FROM_TESTED_SLIPS),
        # farther than a quarter of the widest gap below the lowest slip
        ((0.01, 0.05, 0.25), 0.005, Support.FAR_FROM_TESTED_SLIPS),
        ((0.01, 0.05, 0.25), 0.008, Support.SUPPORTED),
        ((0.01, 0.05, 0.25), 0.9, Support.FAR_FROM_TESTED_SLIPS),
        ((0.02, 0.2), 0.05, Support.FEW_SLIPS),
        ((0.02, 0.2), 0.2, Support.SUPPORTED),
        # 2 % of a slip is the scatter of a set point
        ((0.02, 0.0202, 0.2), 0.05, Support.FEW_SLIPS),
    ],
)
def test_slips_far_from_tested_ones_have_no_support(slips, slip, expected):
    assert code(slips, slip) == expected


def test_a_surface_that_is_not_known_within_fifteen_percent_has_no_support():
    assert code((0.01, 0.05, 0.25), 0.05, spread=0.149) == Support.SUPPORTED
    assert code((0.01, 0.05, 0.25), 0.05, spread=0.151) == Support.SPREAD_TOO_LARGE


def test_a_constant_at_its_bound_counts_where_it_moves_mu():
    slips = (0.01, 0.05, 0.25)
    assert code(slips, 0.05, of_constants=np.array([[0.001, 0.06]])) == Support.CONSTANT_AT_BOUND
    assert code(slips, 0.05, of_constants=np.array([[0.001, 0.04]])) == Support.SUPPORTED
