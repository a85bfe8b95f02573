"""Two equilibria of one bearing: found where they were planted, and not where there is one."""

import numpy as np
import pytest

from bearings import RPM, equilibrium, printed_law, problem, shipped
from oilfilm.bearing.friction import other_equilibrium
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.physics.contact import Conditions

AT = (shipped("mainshaft-167"), OperatingPoints.axial(5000.0, 12000 * RPM), "4010", 70.0)
OILY = {"oil_volume_fraction": 0.02}


def holds(_: Conditions, slide_roll_ratio: np.ndarray) -> np.ndarray:
    return 0.06 * np.tanh(slide_roll_ratio / 0.005)


def slips(_: Conditions, slide_roll_ratio: np.ndarray) -> np.ndarray:
    return 0.004 * np.tanh(slide_roll_ratio / 0.005)


def steep(distance: np.ndarray) -> np.ndarray:
    """A step from 0 to 1."""
    return np.asarray(1 / (1 + np.exp(-np.clip(distance, -700, 700))))


def holds_or_slips(at: Conditions, slide_roll_ratio: np.ndarray) -> np.ndarray:
    """The weak law where a contact slips far or is slow, the strong one elsewhere."""
    lost = np.maximum(
        steep((slide_roll_ratio - 0.3) / 0.01), steep((40 - at.entrainment_speed_m_s) / 0.5)
    )
    return (1 - lost) * holds(at, slide_roll_ratio) + lost * slips(at, slide_roll_ratio)


def test_a_planted_fold_has_a_rolling_and_a_skidding_cage():
    rolling, skidding = (equilibrium(*AT, law=law, **OILY) for law in (holds, slips))
    # each contact of either is well inside the part of the joined law that it was calculated with,
    # so that both are equilibria of the joined law: inner contact by its slip, outer by its speed
    assert rolling.balance.traction.slide_roll_ratio.max() < 0.15
    assert rolling.balance.at.entrainment_speed_m_s.min() > 47
    assert skidding.balance.traction.slide_roll_ratio[0, 0].min() > 0.6
    assert skidding.balance.at.entrainment_speed_m_s[0, 1, 0] < 35
    joined = problem(*AT, law=holds_or_slips, **OILY)
    for known, other in ((rolling, skidding), (skidding, rolling)):
        slip, torque = other_equilibrium(joined, known.cage_slip())
        np.testing.assert_allclose(slip, other.cage_slip(), rtol=1e-5)
        np.testing.assert_allclose(torque, other.torque_n_m(), rtol=1e-5)


@pytest.mark.parametrize("law", [holds, slips, printed_law("4010")])
def test_where_there_is_one_equilibrium_no_other_is_found(law):
    known = equilibrium(*AT, law=law, **OILY).cage_slip()
    assert np.isnan(other_equilibrium(problem(*AT, law=law, **OILY), known)).all()
