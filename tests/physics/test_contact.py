"""Hertz contact against published relations, independent calculations and its own laws."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ellipe, ellipk

from oilfilm.physics.contact import (
    contact_radius,
    creep_slope,
    elliptical_contact,
    ellipticity,
    load_for_max_hertz_pressure,
    max_hertz_pressure,
    reduced_modulus,
)

M50 = reduced_modulus(203e9, 0.29, 203e9, 0.29)  # the rig's steel (docs/physics.md, check 1)
BALL_RADIUS_M = 0.010  # the rig's 20 mm ball on a flat

loads_n = st.floats(1e-2, 1e5)
radii_m = st.floats(1e-4, 1.0)
moduli_pa = st.floats(1e9, 1e12)
# Ry/Rx of ball bearings is about 10 to 100; beyond that the contact is nearly a line
radius_ratios = st.floats(1e-4, 1e4)


@pytest.mark.parametrize(
    ("max_pressure_gpa", "load_n", "rounding_n"),
    [(1.0, 42.1, 0.05), (1.5, 142, 0.5)],  # docs/physics.md, check 1 [C]
)
def test_rig_ball_needs_the_printed_load_for_its_pressure(
    max_pressure_gpa: float, load_n: float, rounding_n: float
) -> None:
    load = load_for_max_hertz_pressure(max_pressure_gpa * 1e9, BALL_RADIUS_M, M50)
    assert load == pytest.approx(load_n, abs=rounding_n)


def test_softer_body_decides_the_reduced_modulus() -> None:
    # a rigid partner adds nothing: 1/E' = (1 - nu^2)/(2 E), by hand
    assert reduced_modulus(70e9, 0.3, np.inf, 0.3) == pytest.approx(2 * 70e9 / 0.91)


def test_groove_tighter_than_the_ball_is_refused() -> None:
    with pytest.raises(ValueError, match="must be positive"):
        elliptical_contact(100.0, 5e-3, 1 / (1 / 10e-3 - 1 / 9e-3), M50)


@given(loads_n, radii_m, moduli_pa)
def test_equal_radii_give_a_circle(load_n: float, radius_m: float, modulus_pa: float) -> None:
    contact = elliptical_contact(load_n, radius_m, radius_m, modulus_pa)
    radius = contact_radius(load_n, radius_m, modulus_pa)
    assert contact.ellipticity == pytest.approx(1.0)
    assert contact.semi_axis_x_m == pytest.approx(radius)
    assert contact.semi_axis_y_m == pytest.approx(radius)
    expected = max_hertz_pressure(load_n, radius_m, modulus_pa)
    assert contact.max_hertz_pressure_pa == pytest.approx(expected)
    # Johnson (1985), Eq. 4.23: delta = a^2/R
    assert contact.approach_m == pytest.approx(radius**2 / radius_m)


@given(loads_n, radii_m, radius_ratios)
def test_quarter_turn_exchanges_the_axes(load_n: float, radius_m: float, ratio: float) -> None:
    contact = elliptical_contact(load_n, radius_m, ratio * radius_m, M50)
    turned = elliptical_contact(load_n, ratio * radius_m, radius_m, M50)
    assert turned.semi_axis_x_m == pytest.approx(contact.semi_axis_y_m)
    assert turned.semi_axis_y_m == pytest.approx(contact.semi_axis_x_m)
    assert turned.ellipticity == pytest.approx(1 / contact.ellipticity)
    assert turned.max_hertz_pressure_pa == pytest.approx(contact.max_hertz_pressure_pa)
    assert turned.approach_m == pytest.approx(contact.approach_m)


@given(loads_n, radii_m, st.floats(1.2, 1e4))
def test_wide_ellipse_obeys_the_textbook(load_n: float, radius_m: float, ratio: float) -> None:
    # Johnson (1985), Eqs 4.26 a-c, with a the longer axis; below 1.2 K - E loses digits
    contact = elliptical_contact(load_n, radius_m, ratio * radius_m, M50)
    a, b = contact.semi_axis_y_m, contact.semi_axis_x_m
    m = 1 - (b / a) ** 2
    slope = contact.max_hertz_pressure_pa / (M50 / 2) * b / (m * a**2)
    assert slope * (ellipk(m) - ellipe(m)) == pytest.approx(1 / (2 * ratio * radius_m))
    assert slope * ((a / b) ** 2 * ellipe(m) - ellipk(m)) == pytest.approx(1 / (2 * radius_m))
    approach = contact.max_hertz_pressure_pa / (M50 / 2) * b * ellipk(m)
    assert contact.approach_m == pytest.approx(approach)


# ball, pitch diameter, groove radii of inner and outer ring, in mm
HARRIS_218 = (22.23, 125.26, 11.63, 11.63)
MAINSHAFT = (22.225, 167.5375, 0.52 * 22.225, 0.515 * 22.225)


# docs/physics.md, Jones-Harris benchmark [C]: p0 is printed to 0.0005 GPa, Q to 0.5 N, which is
# another 0.0002 GPa; E 207.5 GPa; the mainshaft bearing at 12 000 rpm
@pytest.mark.parametrize(
    ("bearing", "ring", "load_n", "angle_deg", "max_pressure_gpa"),
    [
        (HARRIS_218, "inner", 1679, 41.50, 1.526),
        (HARRIS_218, "outer", 1679, 41.50, 1.352),
        (HARRIS_218, "inner", 1562, 45.42, 1.483),
        (HARRIS_218, "outer", 2022, 37.39, 1.434),
        (HARRIS_218, "inner", 1970, 44.91, 1.603),
        (HARRIS_218, "outer", 2423, 38.44, 1.524),
        (MAINSHAFT, "inner", 1770, 34.39, 1.489),
        (MAINSHAFT, "outer", 2834, 24.65, 1.479),
    ],
)
def test_angular_contact_bearings_have_the_benchmark_pressures(
    bearing: tuple[float, float, float, float],
    ring: str,
    load_n: float,
    angle_deg: float,
    max_pressure_gpa: float,
) -> None:
    ball_mm, pitch_mm, *groove_mm = bearing
    pitch_along_normal_mm = pitch_mm / (2 * np.cos(np.radians(angle_deg)))
    race_mm = pitch_along_normal_mm + (ball_mm / 2 if ring == "outer" else -ball_mm / 2)
    along = 1 / (2 / ball_mm + (1 if ring == "inner" else -1) / race_mm)
    across = 1 / (2 / ball_mm - 1 / groove_mm[ring == "outer"])
    steel = reduced_modulus(207.5e9, 0.3, 207.5e9, 0.3)
    contact = elliptical_contact(load_n, along * 1e-3, across * 1e-3, steel)
    assert contact.max_hertz_pressure_pa / 1e9 == pytest.approx(max_pressure_gpa, abs=0.0007)


@pytest.mark.parametrize("difference", [1e-3, 1e-9, -1e-9, 2e-16, -2e-16])
def test_nearly_circular_contact_is_solved(difference: float) -> None:
    # Greenwood, J. Tribol. 107 (1985) 501: k -> (Ry/Rx)^(2/3) for small ellipticities; the
    # second-order term is about a fifth of the square, the rest is rounding
    k = ellipticity(1.0, 1 + difference)
    assert k - 1 == pytest.approx(2 / 3 * difference, abs=0.2 * difference**2 + 1e-15)


def test_creep_of_a_contact_that_is_wide_across_the_rolling_direction_is_carters() -> None:
    # two cylinders (Carter 1926): C11 -> pi^2/(4 (1 - nu)), so that mu/S = 3 pi E'/(16 p0)
    assert creep_slope(1e-2, 10.0) == pytest.approx(3 * np.pi / 16 * 100, rel=0.03)
