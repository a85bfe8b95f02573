"""Speeds and slips from geometry alone, against rigid-body motion and the friction equilibrium."""

from dataclasses import replace

import numpy as np
import pytest

from bearings import RPM, any_bearing, problem, shipped
from oilfilm.base.units import RAD_S_PER_RPM
from oilfilm.bearing.ellipse import gauss_rule, sliding_in_ellipses
from oilfilm.bearing.equilibria import friction_equilibrium
from oilfilm.bearing.kinematics import (
    cage_slip,
    entrainment_speed_m_s,
    inner_slide_roll_ratio,
    pitch_speed_mm_rpm,
    surface_speed_m_s,
)
from oilfilm.bearing.quasistatic import Motion, OperatingPoints, raceway_control_equilibrium
from oilfilm.bearing.torque import torque_terms

TESTED = dict.fromkeys(
    ("max_hertz_pressure_gpa", "entrainment_speed_m_s", "inlet_temperature_c", "slide_roll_ratio"),
    (0.0, 10.0),
)


@pytest.mark.parametrize("gamma", [0.0, 0.05, 0.118, 0.3])
def test_speed_and_slip_are_those_of_bodies_that_roll_at_the_outer_race(gamma: float) -> None:
    # two discs of radius dm/2 (1 -+ gamma) with a ball of radius gamma dm/2 between, alpha = 0,
    # seen from the cage; dm 2 m, so that the pitch circle has the radius 1
    inner, outer, ball = 1 - gamma, 1 + gamma, gamma or 1e-9
    omega, slip = 10.0, np.array([0.0, 0.083, 0.15, 0.5, 1.0])
    cage = (1 - slip) * omega * inner / (inner + outer)
    spin = cage * outer / ball  # no sliding at the outer race
    race, surface = (omega - cage) * inner, spin * ball
    pitch_speed = 2e3 * omega / RAD_S_PER_RPM
    np.testing.assert_allclose(
        inner_slide_roll_ratio(slip, gamma), 2 * (race - surface) / (race + surface), rtol=1e-12
    )
    speed = entrainment_speed_m_s(pitch_speed, gamma)
    assert speed == pytest.approx((race + surface)[0] / 2, rel=1e-12)
    assert surface_speed_m_s(pitch_speed, gamma) == pytest.approx(omega * inner, rel=1e-12)


@pytest.mark.parametrize("gamma", [0.0, 0.118])
def test_slip_and_speed_are_found_back(gamma: float) -> None:
    slip = np.linspace(0, 1, 11)
    np.testing.assert_allclose(cage_slip(inner_slide_roll_ratio(slip, gamma), gamma), slip)
    assert pitch_speed_mm_rpm(entrainment_speed_m_s(3e6, gamma), gamma) == pytest.approx(3e6)


def test_contact_of_a_real_groove_slides_as_the_closed_form_has_it() -> None:
    # both angles equal at rest; a small load, so that the contact's middle lies on the ball
    bearing = replace(any_bearing(0.02, 7.0, 30.0, 0.52, 0.52), pitch_diameter_m=0.14)
    contacts = raceway_control_equilibrium(
        bearing, OperatingPoints.from_load_and_speed(1.0, 0.0)
    ).contacts
    radius = contacts.orbit_radius_m[0]
    normal, omega, slip = contacts.normal[0, :, 1], 100.0, 0.2
    gamma = bearing.ball_diameter_m * normal[1] / (2 * radius)
    cage = (1 - slip) * omega * (1 - gamma) / 2
    spin = cage * (1 + gamma) * radius / (bearing.ball_diameter_m / 2)
    # about an axis along the tangent across the rolling direction of both contacts
    turning = spin * np.array([-normal[1], normal[0], 0.0])
    motion = Motion(np.array([cage]), turning[np.newaxis])
    rings = np.array([[omega, 0.0]])
    middle = sliding_in_ellipses(
        bearing, contacts, motion, rings, gauss_rule(2, 2)
    ).middle_slide_roll_ratio[0]
    assert middle[0] == pytest.approx(float(inner_slide_roll_ratio(slip, gamma)), rel=1e-4)
    assert abs(middle[1]) < 1e-4


def test_slide_roll_ratio_of_the_equilibrium_is_nearly_twice_the_cage_slip() -> None:
    # 4050 with its printed law at dmN 4e6, 100 degC, with much oil about
    bearing, load = shipped("mainshaft-167"), np.array([20_000.0, 14_500.0, 12_000.0, 8_000.0])
    points = OperatingPoints.from_load_and_speed(load, 4e6 / (bearing.pitch_diameter_m * 1e3) * RPM)
    terms = torque_terms(
        friction_equilibrium(problem(bearing, points, oil_volume_fraction=0.02)), TESTED
    )
    slip, ratio = terms["cage_slip"], terms["inner_slide_roll_ratio"]
    # docs/physics.md, kinematics: S at the inner race by cage slip
    printed = np.array([[0.083, 0.144, 0.215, 0.383], [0.155, 0.277, 0.423, 0.758]])
    np.testing.assert_allclose(ratio, np.interp(slip, *printed), rtol=0.01)
    # the closed form encloses it between no gamma and that of the unloaded bearing
    gamma = bearing.ball_diameter_m / bearing.pitch_diameter_m * np.cos(bearing.contact_angle_rad)
    assert (inner_slide_roll_ratio(slip, gamma) < ratio).all()
    assert (ratio < inner_slide_roll_ratio(slip)).all()
