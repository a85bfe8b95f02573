"""Bearing geometry, and motion under raceway control, against independent calculations."""

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from bearings import BEARINGS_FOLDER, RPM, SHIPPED, any_bearing, shipped
from oilfilm.bearing.quasistatic import (
    OperatingPoints,
    centrifugal_force_n,
    gyroscopic_moment_n_m,
    raceway_control_equilibrium,
)
from oilfilm.physics.contact import elliptical_contact
from oilfilm.settings.messages import first_mistake, load
from oilfilm.settings.resolved import merge
from oilfilm.settings.rig import BallMaterial, BearingFile
from oilfilm.settings.yaml_file import read_yaml

REFERENCE = yaml.safe_load(
    (BEARINGS_FOLDER.parents[1] / "data/reference/bearing_benchmarks.yaml").read_text(
        encoding="utf-8"
    )
)["rows"]


@pytest.mark.parametrize("name", REFERENCE)
def test_equilibria_of_an_independent_calculation_are_met_within_half_a_percent(name):
    bearing = shipped(name)
    rows = np.array(REFERENCE[name], dtype=float)
    points = OperatingPoints.from_load_and_speed(rows[:, 0], rows[:, 1] * RPM)
    equilibrium = raceway_control_equilibrium(bearing, points, gyroscopic_factor=-1.0)
    assert equilibrium.solution.converged.all()
    ours = np.column_stack(
        [
            np.degrees(equilibrium.contacts.contact_angle_rad),
            equilibrium.contacts.load_n,
            centrifugal_force_n(bearing, equilibrium.contacts, equilibrium.motion),
            gyroscopic_moment_n_m(bearing, equilibrium.motion)[:, 2],
            equilibrium.motion.orbit_speed_rad_s / RPM,
            equilibrium.contacts.max_hertz_pressure_pa / 1e9,
        ]
    )
    printed = rows[:, 2:]
    is_printed = ~np.isnan(printed)
    np.testing.assert_allclose(ours[is_printed], printed[is_printed], rtol=5e-3, atol=1e-9)


@pytest.mark.parametrize("name", SHIPPED)
def test_at_rest_the_closed_form_of_equal_contact_angles_holds(name):
    # both races at one angle: A (cos(alpha0)/cos(alpha) - 1) = delta_i + delta_o, each by Hertz
    bearing = shipped(name)
    axial_n = 3e7 * bearing.ball_diameter_m**2
    contacts = raceway_control_equilibrium(
        bearing, OperatingPoints.from_load_and_speed(axial_n, 0.0)
    ).contacts
    angle, load = contacts.contact_angle_rad[0], contacts.load_n[0]
    assert angle[0] == pytest.approx(angle[1], rel=1e-9)
    np.testing.assert_allclose(load, axial_n / (bearing.ball_count * np.sin(angle)), rtol=1e-9)
    hertz = elliptical_contact(
        load, bearing.radius_x_m(np.cos(angle)), bearing.radius_y_m, bearing.reduced_modulus_pa
    )
    stretched = np.cos(bearing.contact_angle_rad) / np.cos(angle[0]) - 1
    assert bearing.groove_centre_distance_m * stretched == pytest.approx(
        hertz.approach_m.sum(), rel=1e-8
    )


def test_without_friction_the_centrifugal_force_alone_parts_the_angles():
    # balance of a ball pressed by two normals: cot(alpha_o) - cot(alpha_i) = Fc Z/Fa
    bearing = shipped("harris-218")
    points = OperatingPoints.from_load_and_speed(17800.0, 10000 * RPM)
    equilibrium = raceway_control_equilibrium(bearing, points, gyroscopic_factor=0.0)
    inner, outer = equilibrium.contacts.contact_angle_rad[0]
    outward = centrifugal_force_n(bearing, equilibrium.contacts, equilibrium.motion)[0]
    assert 1 / np.tan(outer) - 1 / np.tan(inner) == pytest.approx(16 * outward / 17800.0, rel=1e-8)


def test_the_gyroscopic_moment_turns_the_axis_of_the_ball_along_the_orbit():
    # the angular momentum of a ball on its orbit, differentiated numerically in a fixed frame
    bearing = shipped("harris-218")
    equilibrium = raceway_control_equilibrium(
        bearing, OperatingPoints.from_load_and_speed(17800.0, 10000 * RPM)
    )
    orbit, rotation = equilibrium.motion.orbit_speed_rad_s[0], equilibrium.motion.rotation_rad_s[0]

    def momentum(time):
        # r = (cos, sin), t = (-sin, cos) in the plane across the axis
        cosine, sine = np.cos(orbit * time), np.sin(orbit * time)
        total = rotation + np.array([orbit, 0.0, 0.0])
        across = total[1] * np.array([cosine, sine]) + total[2] * np.array([-sine, cosine])
        return bearing.ball_inertia_kg_m2 * np.array([total[0], *across])

    moment = (momentum(1e-6) - momentum(-1e-6)) / 2e-6
    ours = gyroscopic_moment_n_m(bearing, equilibrium.motion)[0]
    np.testing.assert_allclose(ours, moment, rtol=1e-6, atol=1e-9)
    assert ours[2] > 0


@pytest.mark.slow
@given(
    ball=st.floats(0.004, 0.03),
    pitch_over_ball=st.floats(2.5, 12.0),
    angle=st.floats(5.0, 45.0),
    inner=st.floats(0.505, 0.56),
    outer=st.floats(0.505, 0.56),
    load_n_mm2=st.floats(0.05, 3.0),
    dmn=st.floats(0.0, 4e6),
)
def test_any_bearing_converges_or_its_balls_climb(
    ball, pitch_over_ball, angle, inner, outer, load_n_mm2, dmn
):
    bearing = any_bearing(ball, pitch_over_ball, angle, inner, outer)
    axial_n = load_n_mm2 * 1e6 * ball**2 * bearing.ball_count
    equilibrium = raceway_control_equilibrium(
        bearing,
        OperatingPoints.from_load_and_speed(axial_n, dmn / (ball * pitch_over_ball * 1e3) * RPM),
    )
    # under a light load a fast ball sinks into the outer groove until the inner one passes it by:
    # there is no equilibrium then
    if equilibrium.solution.converged.all():
        assert (equilibrium.contacts.load_n > 0).all()
    else:
        assert np.degrees(equilibrium.contacts.contact_angle_rad[0, 0]) > 60


@pytest.mark.parametrize("name", [*SHIPPED, "template"])
def test_contacts_under_unit_load_are_exactly_hertz(name):
    bearing = shipped(name)
    cosine = np.linspace(0, 1, 50)[:, np.newaxis] * np.ones(2)
    exact = elliptical_contact(
        1.0, bearing.radius_x_m(cosine), bearing.radius_y_m, bearing.reduced_modulus_pa
    )
    stiffness, a_x, a_y = bearing.stiffness_and_unit_semi_axes(cosine)
    np.testing.assert_allclose(stiffness, exact.approach_m**-1.5, rtol=1e-13)
    np.testing.assert_allclose(a_x, exact.semi_axis_x_m, rtol=1e-13)
    np.testing.assert_allclose(a_y, exact.semi_axis_y_m, rtol=1e-13)


def test_a_hybrid_bearing_is_stiffer_and_its_balls_lighter():
    config = load(BEARINGS_FOLDER / "harris-218.yaml", BearingFile)
    ceramic = BallMaterial(
        youngs_modulus_pa=310e9, poisson_ratio=0.26, density_kg_m3=3200, expansion_1_k=3.2e-6
    )
    steel, hybrid = (
        config.model_copy(update={"ball": ball}).bearing("218") for ball in (config.ball, ceramic)
    )
    assert hybrid.reduced_modulus_pa > steel.reduced_modulus_pa
    assert hybrid.ball_mass_kg / steel.ball_mass_kg == pytest.approx(3200 / 7833)


@pytest.mark.parametrize(
    ("changes", "key", "words"),
    [
        ({"ball_count": 18}, "ball_count", "there is room for 17"),
        ({"ball_count": 16.5}, "ball_count", "a whole number"),
        ({"inner_groove_curvature": 0.5}, "inner_groove_curvature", "more than 0.5"),
        ({"contact_angle_deg": 90.0}, "contact_angle_deg", "less than 90"),
        ({"ball_diameter_m": 0.07, "ball_count": 3}, "ball_diameter_m", "less than half"),
        ({"cage": {"guidance": "inner"}}, "cage.land_diameter_m", "guidance: inner"),
        ({"cage": {"land_diameter_m": 0.2}}, "cage.land_diameter_m", "far side"),
        ({"cage": {"land_clearance_m": 0.02}}, "cage.land_clearance_m", "well below"),
        # grooves of 102.4 and 148 mm at their bottoms
        ({"mounting": {"bore_diameter_m": 0.11}}, "mounting.bore_diameter_m", "less than 0.102"),
        ({"mounting": {"outside_diameter_m": 0.14}}, "mounting.outside_diameter_m", "more than"),
        (
            {"mounting": {"shaft_bore_ratio_range": [0.5, 0.9]}},
            "mounting.shaft_bore_ratio_range",
            "less than the bore of the ring",
        ),
        (
            {"mounting": {"ring_temperature_difference_k": 50.0}},
            "mounting.ring_temperature_difference_k",
            "outside `ring_temperature_difference_k_range` (-20 to 40)",
        ),
    ],
)
def test_impossible_geometry_is_refused_by_name(changes, key, words):
    changed_values = merge(read_yaml(BEARINGS_FOLDER / "harris-218.yaml").values, changes)
    mistake = first_mistake(changed_values, BearingFile)
    assert mistake.startswith(f"`{key}`: found")
    assert words in mistake


def test_ceramic_balls_need_their_own_expansion():
    ball = {"youngs_modulus_pa": 310e9, "poisson_ratio": 0.26, "density_kg_m3": 3200.0}
    without_expansion = merge(read_yaml(BEARINGS_FOLDER / "harris-218.yaml").values, {"ball": ball})
    assert "expansion_1_k" in first_mistake(without_expansion, BearingFile)
    with_expansion = merge(without_expansion, {"ball": {"expansion_1_k": 3.2e-6}})
    assert BearingFile.model_validate(with_expansion).ball.expansion_1_k == 3.2e-6
