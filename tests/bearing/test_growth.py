"""Growth of rings and balls, against closed forms and an independent solver."""

from dataclasses import replace

import numpy as np
import pytest

from bearings import RPM, SETTINGS, equilibrium, in_operation, problem, shipped
from oilfilm.bearing.growth import (
    Growth,
    centrifugal_growth_m,
    fit_share,
    inner_ring_growth_m,
    operating_growth,
)
from oilfilm.bearing.inputs import Inputs
from oilfilm.bearing.quasistatic import OperatingPoints, raceway_control

MAINSHAFT = shipped("mainshaft-167")
STEEL = (7833.0, 207.5e9, 0.3)
UM = 1e-6


def inputs(point_count: int = 1, **changed_inputs: float | np.ndarray) -> Inputs:
    """Inputs of the mainshaft bearing without fits and differences of temperature."""
    no_growth = dict.fromkeys(
        (
            "shaft_interference_m",
            "housing_interference_m",
            "ring_temperature_difference_k",
            "ball_temperature_difference_k",
        ),
        0.0,
    )
    values = Inputs.without_draws(
        {**MAINSHAFT.uncertain, **SETTINGS.uncertain_inputs()}, point_count
    )
    arrays = {
        name: np.full(point_count, value) for name, value in (no_growth | changed_inputs).items()
    }
    return replace(values, **arrays)


def with_inner_ring(points: OperatingPoints, growth_m: np.ndarray) -> OperatingPoints:
    """Operating points at which the inner groove alone has moved outward."""
    centre = np.column_stack([growth_m, np.zeros_like(growth_m)])
    return replace(points, growth=Growth(centre, np.zeros_like(centre)))


# docs/physics.md, Growth of rings: Lame's rotating ring, groove of 72.6 mm
@pytest.mark.parametrize(
    ("ratio", "speed_rpm", "growth_um"),
    [
        (0.75, 12000.0, 14.577),
        (0.75, 4e6 / 167.5375, 57.705),
        (0.6, 12000.0, 10.767),
        (0.6, 4e6 / 167.5375, 42.620),
    ],
)
def test_a_rotating_ring_grows_as_lames_ring_does(ratio, speed_rpm, growth_um):
    growth = centrifugal_growth_m(speed_rpm * RPM, 72.6e-3, ratio * 72.6e-3, *STEEL)
    assert growth == pytest.approx(growth_um * UM, rel=1e-4)


def displacements(radii: np.ndarray, load: np.ndarray, pressure: float) -> np.ndarray:
    """Radial displacement of a ring in plane stress, by finite differences of its equilibrium.

    u'' + u'/r - u/r^2 = -load (1 - nu^2)/E; the bore is under pressure, the outside is free.
    """
    _, modulus, nu = STEEL
    count, step = len(radii), radii[1] - radii[0]
    matrix, right = np.zeros((count, count)), -load * (1 - nu**2) / modulus
    for row in range(1, count - 1):
        r = radii[row]
        matrix[row, row - 1 : row + 2] = [
            1 / step**2 - 1 / (2 * step * r),
            -2 / step**2 - 1 / r**2,
            1 / step**2 + 1 / (2 * step * r),
        ]
    # radial stress E/(1 - nu^2) (u' + nu u/r) at both ends, with slopes of second order
    matrix[0, :3] = np.array([-3, 4, -1]) / (2 * step)
    matrix[0, 0] += nu / radii[0]
    matrix[-1, -3:] = np.array([1, -4, 3]) / (2 * step)
    matrix[-1, -1] += nu / radii[-1]
    right[[0, -1]] = -pressure * (1 - nu**2) / modulus, 0.0
    return np.linalg.solve(matrix, right)


def test_a_tight_ring_and_its_shaft_are_one_body_and_the_fit_adds_its_share():
    bore_radius, fit_radius, groove_radius = (
        0.6 * MAINSHAFT.groove_bottom_m[0],
        62e-3,
        MAINSHAFT.groove_bottom_m[0],
    )
    speed, interference = 12000.0 * RPM, 20 * UM
    rho, modulus, nu = STEEL
    ring, shaft = (
        np.linspace(fit_radius, groove_radius, 400),
        np.linspace(bore_radius, fit_radius, 400),
    )
    inertia = rho * speed**2
    # each body alone, turning; then under a unit pressure of the fit
    ring_turning = displacements(ring, inertia * ring, 0.0)
    shaft_turning = displacements(shaft, inertia * shaft, 0.0)
    ring_pressed = displacements(ring, 0 * ring, 1.0)
    # outer pressure: pressure on both surfaces, which strains evenly, less that on the bore
    uniform = -(1 - nu) / modulus * shaft
    shaft_pressed = uniform - displacements(shaft, 0 * shaft, 1.0)
    gap = ring_turning[0] - shaft_turning[-1]
    pressure = (interference - gap) / (ring_pressed[0] - shaft_pressed[-1])
    assert pressure > 0
    expected_growth_m = ring_turning[-1] + pressure * ring_pressed[-1]
    growth_m = inner_ring_growth_m(
        MAINSHAFT, np.array([speed]), np.array([0.6]), np.array([interference])
    )
    assert MAINSHAFT.rings.bore_ratio == pytest.approx(fit_radius / groove_radius)
    assert growth_m[0] == pytest.approx(expected_growth_m, rel=1e-3)
    # neither the whole interference nor the ring's own growth beside that of the shaft
    growth_of_ring_alone_m = centrifugal_growth_m(speed, groove_radius, fit_radius, *STEEL)
    assert (
        growth_m[0]
        < growth_of_ring_alone_m + fit_share(groove_radius, fit_radius, bore_radius) * interference
    )


def test_a_ring_that_loses_its_fit_grows_alone():
    speed = np.array([4e6 / 167.5375 * RPM])
    loose = inner_ring_growth_m(MAINSHAFT, speed, np.array([0.6]), np.array([5 * UM]))
    groove = MAINSHAFT.groove_bottom_m[0]
    growth_of_ring_alone = centrifugal_growth_m(
        speed, groove, MAINSHAFT.rings.bore_ratio * groove, *STEEL
    )
    np.testing.assert_allclose(loose, growth_of_ring_alone)
    tight = inner_ring_growth_m(MAINSHAFT, speed, np.array([0.6]), np.array([200 * UM]))
    assert tight > growth_of_ring_alone


def test_a_solid_body_takes_the_share_of_its_radii():
    # ring on a solid shaft: pressure E delta/(2 a) (1 - a^2/b^2), so a/b of the interference
    assert fit_share(0.07, 0.05, 0.0) == pytest.approx(5 / 7)


def test_warm_rings_grow_by_expansion_and_equal_warmth_turns_no_contact_angle():
    # a b dT = 12e-6 x 72.6 mm x 30 K = 26.1 um at the bottom of the groove
    growth = operating_growth(
        MAINSHAFT, np.zeros(1), np.array([20.0]), inputs(ring_temperature_difference_k=30.0)
    )
    groove_growth = 12e-6 * 30 * 0.52 * 22.225e-3
    ball_growth = 12e-6 * 15 * 22.225e-3 / 2  # the balls have the mean of both rings
    bottom = growth.centre_displacement_m[0, 0] - groove_growth
    assert bottom == pytest.approx(26.1 * UM, rel=2e-3)
    assert growth.offset_growth_m[0, 0] == pytest.approx(groove_growth - ball_growth)
    # all of one steel at one temperature is the same bearing, larger
    points = OperatingPoints.axial(20000.0, 1.0)
    growth_of_hot_bearing = operating_growth(MAINSHAFT, np.zeros(1), np.array([170.0]), inputs())
    at_rest = raceway_control(MAINSHAFT, points).contacts.contact_angle_rad
    heated = raceway_control(
        MAINSHAFT, replace(points, growth=growth_of_hot_bearing)
    ).contacts.contact_angle_rad
    np.testing.assert_allclose(heated, at_rest, atol=np.radians(0.03))


def test_hot_balls_take_play_away_and_ceramic_ones_give_it():
    # 0.27 um/K of diameter: 12e-6 x 22.2 mm
    growth_of_hot_balls = operating_growth(
        MAINSHAFT, np.zeros(1), np.array([20.0]), inputs(ball_temperature_difference_k=10.0)
    )
    np.testing.assert_allclose(growth_of_hot_balls.offset_growth_m, -2.667 * UM / 2, rtol=1e-3)
    ceramic = replace(MAINSHAFT, rings=replace(MAINSHAFT.rings, ball_expansion_1_k=3.2e-6))
    points = OperatingPoints.axial(20000.0, 1.0)
    angles = []
    for bearing in (MAINSHAFT, ceramic):
        growth = operating_growth(bearing, np.zeros(1), np.array([120.0]), inputs())
        contacts = raceway_control(bearing, replace(points, growth=growth)).contacts
        angles.append(contacts.contact_angle_rad[0, 0])
    assert angles[1] > angles[0]


def test_a_housing_squeezes_the_outer_groove_and_a_clearance_does_nothing():
    sizes = np.array([-10.0, 0.0, 10.0]) * UM
    growth = operating_growth(
        MAINSHAFT, np.zeros(3), np.full(3, 20.0), inputs(3, housing_interference_m=sizes)
    )
    np.testing.assert_array_equal(growth.centre_displacement_m[:2, 1], 0)
    assert -10 * UM < growth.centre_displacement_m[2, 1] < -3 * UM


# docs/physics.md, Growth of rings: an independent program with the growth of the inner ring given;
# 4050 with the printed law, 100 degC, share of oil 0.0036
REFERENCE = {
    # load N, speed rpm: growth um, torque N m, angles deg, S of the inner contact
    (20000, 12000): [
        (0.0, 5.871, 36.5, 20.3, 0.0146),
        (14.58, 5.862, 33.8, 19.6, 0.0124),
        (40.7, 5.930, 28.7, 18.0, 0.0085),
    ],
    (10000, 12000): [
        (0.0, 4.352, 37.7, 13.7, 0.0290),
        (14.58, 4.296, 34.7, 13.6, 0.0248),
        (40.7, 4.260, 28.9, 13.0, 0.0177),
    ],
    (3000, 12000): [
        (0.0, 3.400, 38.2, 5.8, 0.1488),
        (14.58, 3.344, 35.1, 5.9, 0.1246),
        (40.7, 3.267, 28.8, 5.8, 0.0859),
    ],
    (20000, 23880): [
        (0.0, 10.246, 42.4, 8.1, 0.0569),
        (57.73, 9.366, 30.4, 8.4, 0.0284),
        (83.9, 9.320, 24.0, 8.1, 0.0176),
    ],
    (10000, 23880): [
        (0.0, 8.607, 41.8, 4.7, 0.1244),
        (57.73, 7.808, 29.3, 4.9, 0.0595),
        (83.9, 7.680, 22.2, 4.9, 0.0360),
    ],
}


@pytest.mark.parametrize("duty", REFERENCE)
def test_torque_slip_and_angles_of_a_grown_bearing_are_those_of_another_program(duty):
    load, speed = duty
    growth, torque, inner, outer, slip = np.array(REFERENCE[duty]).T
    points = OperatingPoints.axial(np.full(3, float(load)), speed * RPM)
    grown = with_inner_ring(points, growth * UM)
    motion = equilibrium(MAINSHAFT, grown, oil_volume_fraction=0.0036)
    np.testing.assert_allclose(motion.torque_n_m(), torque, atol=1.1e-3)
    angles = np.degrees(motion.balance.contacts.contact_angle_rad)
    np.testing.assert_allclose(angles, np.column_stack([inner, outer]), atol=0.11)
    slide_roll_ratio = motion.balance.sliding.middle_slide_roll_ratio[:, 0]
    np.testing.assert_allclose(slide_roll_ratio, slip, atol=1.1e-4)


def test_rings_without_play_still_find_their_equilibrium():
    # 84.8 um of radial play are gone: the balls are pressed by the rings alone
    growth = np.array([80.0, 90.0, 140.0]) * UM
    points = OperatingPoints.axial(np.full(3, 5000.0), 18000 * RPM)
    grown = with_inner_ring(points, growth)
    contacts = equilibrium(MAINSHAFT, grown).balance.contacts
    assert (np.diff(contacts.load_n[:, 0]) > 0).all()
    assert (np.diff(contacts.contact_angle_rad[:, 0]) < 0).all()
    # the axial load is still that of the balls
    axial = 20 * contacts.load_n[:, 0] * np.sin(contacts.contact_angle_rad[:, 0])
    np.testing.assert_allclose(axial, 5000, rtol=0.02)


def test_growth_of_some_points_is_that_of_these_points():
    points = OperatingPoints.axial(np.array([5e3, 1e4, 2e4]), np.array([6e3, 12e3, 18e3]) * RPM)
    problem_of_all_points = in_operation(problem(MAINSHAFT, points))
    point_index = np.array([2, 0])
    problem_of_points = in_operation(problem(MAINSHAFT, points.at_points(point_index)))
    growth_of_points = problem_of_all_points.at_points(point_index).points.growth
    np.testing.assert_array_equal(
        growth_of_points.centre_displacement_m,
        problem_of_points.points.growth.centre_displacement_m,
    )
    np.testing.assert_array_equal(
        growth_of_points.offset_growth_m, problem_of_points.points.growth.offset_growth_m
    )
