"""A heated film in the contact of a rig and of a bearing: the ellipse, and the spin of the disc."""

from collections.abc import Mapping

import numpy as np
import pytest

from bearings import shipped
from campaigns import ROOT, printed, rig_contact
from oilfilm.bearing.ellipse import gauss_rule
from oilfilm.physics.contact import Conditions, contact_radius, elliptical_contact
from oilfilm.physics.rig_spin import edge_slip, spin_correction
from oilfilm.settings.config import Config
from oilfilm.settings.messages import load
from oilfilm.settings.resolve import resolve
from simulated_lab.truth import TrueTraction, true_tractions

RULE = gauss_rule(32, 12)
RIG = rig_contact()
BEARING = shipped("mainshaft-167")


@pytest.fixture(scope="module")
def films() -> Mapping[str, TrueTraction]:
    return true_tractions(resolve(ROOT / "config", {"campaign": "thermal"}), printed())


def in_contact(
    film: TrueTraction,
    condition: tuple[float, float, float],
    slips: np.ndarray,
    radii_m: tuple[float, float],
    modulus_pa: float,
) -> np.ndarray:
    """mu of a contact with other radii at pressure in GPa, speed in m/s and temperature in degC."""
    pressure, speed, temperature = condition
    unit = elliptical_contact(1.0, *radii_m, modulus_pa)
    unit_pressure = 1.5 / (np.pi * unit.semi_axis_x_m * unit.semi_axis_y_m)
    shape = (len(slips), 1, 1)
    conditions = Conditions(
        load_n=np.full(shape, (pressure * 1e9 / unit_pressure) ** 3),
        max_hertz_pressure_gpa=np.full(shape, pressure),
        entrainment_speed_m_s=np.full(shape, speed),
        inlet_temperature_c=np.full(shape, temperature),
        radius_x_m=np.full(shape, radii_m[0]),
        reduced_modulus_pa=modulus_pa,
    )
    law = film.local_law(RULE, np.asarray(radii_m[1]))
    slip_of_node = slips[:, np.newaxis, np.newaxis] * np.ones(len(RULE.load_share))
    return (law(conditions, slip_of_node) @ RULE.load_share)[:, 0]


# docs/physics.md, Ellipse and circle: change of mu in percent at S 0.003, 0.015, 0.05, 0.15
@pytest.mark.parametrize(
    ("oil", "condition", "change"),
    [
        ("4102", (1.5, 49.0, 100.0), [-3, -3, -4, -5]),
        ("4050", (1.5, 49.0, 100.0), [-3, -3, -4, -5]),
        ("4010", (1.5, 49.0, 100.0), [-7, -6, -6, -7]),
        ("4102", (1.2, 92.0, 100.0), [-4, -4, -6, -7]),
        ("4050", (1.2, 92.0, 100.0), [-5, -4, -6, -7]),
        ("4010", (1.2, 92.0, 100.0), [-11, -8, -8, -10]),
    ],
)
def test_a_heated_film_has_less_traction_in_an_ellipse(films, oil, condition, change):
    slips = np.array([0.003, 0.015, 0.05, 0.15])
    circle = in_contact(films[oil], condition, slips, (RIG.radius_m,) * 2, RIG.reduced_modulus_pa)
    inner = float(BEARING.radius_x_m(np.full(2, np.cos(np.radians(30))))[0])
    radii = (inner, float(BEARING.radius_y_m[0]))
    ellipse = in_contact(films[oil], condition, slips, radii, BEARING.reduced_modulus_pa)
    # whole percents of a program whose contact angle is not stated
    np.testing.assert_allclose(100 * (ellipse / circle - 1), change, atol=1.0)
    # the range that is set holds all of them
    low, high = load(ROOT / "config/config.yaml", Config).bearing.ellipse_factor_range
    assert (ellipse / circle > low).all()
    assert (ellipse / circle < high).all()


def with_spin(
    film: TrueTraction, condition: tuple[float, float, float], slip: float, edge: float
) -> float:
    """mu that a rig measures whose disc spins, by quadrature over the circle."""
    along, across = slip - edge * RULE.across, edge * RULE.along
    size = np.hypot(along, across)
    return float(np.sum(film(*condition, size) * along / size * RULE.load_share))


# docs/physics.md, Spin of the rig: mu with spin over mu without at S 0.001, 0.003, 0.01, 0.03
@pytest.mark.parametrize(
    ("oil", "condition", "ratio"),
    [
        ("4102", (1.5, 25.0, 25.0), [0.238, 0.617, 0.966, 0.997]),
        ("4102", (1.5, 40.0, 120.0), [0.293, 0.656, 0.969, 0.997]),
        ("4010", (1.0, 25.0, 25.0), [0.435, 0.835, 0.984, 0.999]),
    ],
)
def test_spin_takes_from_a_heated_film_what_another_program_found(films, oil, condition, ratio):
    film = films[oil]
    radius = contact_radius(RIG.load_n(condition[0]), RIG.radius_m, RIG.reduced_modulus_pa)
    edge = float(edge_slip(radius, 0.040))
    found = [
        with_spin(film, condition, slip, edge) / float(film(*condition, slip))
        for slip in (0.001, 0.003, 0.01, 0.03)
    ]
    np.testing.assert_allclose(found, ratio, atol=0.01)
    # above twice the edge's slip the correction gives it back
    for slip, error in ((0.0125, 3e-3), (0.02, 1e-3)):
        step = 0.05 * slip
        below, here, above = (
            with_spin(film, condition, slip + off, edge) for off in (-step, 0.0, step)
        )
        slope, curvature = (above - below) / (2 * step), (above - 2 * here + below) / step**2
        corrected = here * (1 + spin_correction(slip, here, slope, curvature, edge))
        assert corrected == pytest.approx(float(film(*condition, slip)), rel=error)
