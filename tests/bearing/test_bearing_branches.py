"""Two equilibria of one bearing: found where they were planted, and not where there is one."""

import numpy as np
import pytest

from bearings import RPM, lubrication, printed_law, shipped
from oilfilm.bearing.branches import other_equilibrium
from oilfilm.bearing.ellipse import Conditions, TractionLaw
from oilfilm.bearing.friction import FrictionEquilibrium, friction_equilibrium
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.bearing.torque import cage_slip, inner_ring_torque_n_m

BEARING = shipped("mainshaft-167")
POINT = OperatingPoints.axial(5000.0, 12000 * RPM)
OIL = lubrication("4010", 70, 1, oil_volume_fraction=0.02)


def holds(_: Conditions, slide_roll_ratio: np.ndarray) -> np.ndarray:
    return 0.06 * np.tanh(slide_roll_ratio / 0.005)


def slips(_: Conditions, slide_roll_ratio: np.ndarray) -> np.ndarray:
    return 0.004 * np.tanh(slide_roll_ratio / 0.005)


def equilibrium(law: TractionLaw) -> FrictionEquilibrium:
    found = friction_equilibrium(BEARING, POINT, OIL, law)
    assert found.solution.converged.all()
    return found


def slip_of(found: FrictionEquilibrium) -> float:
    return float(cage_slip(BEARING, POINT, found.balance.contacts, found.balance.motion)[0, 0])


def torque_of(found: FrictionEquilibrium) -> float:
    return float(inner_ring_torque_n_m(found.balance, found.balls_per_row)[0])


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
    rolling, skidding = equilibrium(holds), equilibrium(slips)
    # each contact of either is well inside the part of the joined law that it was calculated with,
    # so that both are equilibria of the joined law: inner contact by its slip, outer by its speed
    assert rolling.balance.traction.slide_roll_ratio.max() < 0.15
    assert rolling.balance.at.entrainment_speed_m_s.min() > 47
    assert skidding.balance.traction.slide_roll_ratio[0, 0, 0].min() > 0.6
    assert skidding.balance.at.entrainment_speed_m_s[0, 0, 1, 0] < 35
    for known, other in ((rolling, skidding), (skidding, rolling)):
        found = other_equilibrium(BEARING, POINT, OIL, holds_or_slips, np.array([slip_of(known)]))
        assert found.cage_slip[0] == pytest.approx(slip_of(other), rel=1e-5)
        assert found.torque_n_m[0] == pytest.approx(torque_of(other), rel=1e-5)


@pytest.mark.parametrize("law", [holds, slips, printed_law("4010")])
def test_where_there_is_one_equilibrium_no_other_is_found(law):
    known = np.array([slip_of(equilibrium(law))])
    found = other_equilibrium(BEARING, POINT, OIL, law, known)
    assert np.isnan(found.cage_slip).all()
    assert np.isnan(found.torque_n_m).all()
