"""Torque of a bearing: the film at the slip of its contacts, and what catalogues estimate.

SKF and Palmgren against their equations, worked out by another program (bc, 20 digits).
"""

import numpy as np
import pytest

from bearings import RPM, equilibrium, problem, shipped
from oilfilm.bearing.ellipse import gauss_rule
from oilfilm.bearing.equilibria import friction_equilibrium
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.bearing.torque import palmgren_torque_n_m, skf_torque_n_m, torque_terms
from planted_fits import TESTED

MAINSHAFT = shipped("mainshaft-167")
# at 3.5 million mm rpm the inner contacts slide by half of their rolling speed
SLIPPING = OperatingPoints.from_load_and_speed(3000.0, 20891 * RPM)


def by_hand(slip: np.ndarray, contact: dict[str, np.ndarray]) -> np.ndarray:
    """docs/physics.md, Film: h_min of Hamrock and Dowson times phi_T of Gupta et al."""
    # 23699-type oil at 100 degC by the table of docs/physics.md, Oils; k = 0.14868 -
    # 2.2275e-4 (373.15 - 366.67)
    eta, alpha, beta, k_oil = 5.01e-3, 1.103e-8, 0.0200, 0.1472
    # E 207.5 GPa, nu 0.3 for ball and ring: E' = E/(1 - nu^2)
    modulus = 207.5e9 / 0.91
    u = eta * contact["speed"] / (modulus * contact["radius"])
    w = contact["load"] / (modulus * contact["radius"] ** 2)
    sides = 1 - np.exp(-0.68 * contact["ellipticity"])
    h_min = 3.63 * u**0.68 * (alpha * modulus) ** 0.49 * w**-0.073 * sides * contact["radius"]
    heating = eta * beta * contact["speed"] ** 2 / k_oil
    phi = (1 - 13.2 * contact["pressure"] / modulus * heating**0.42) / (
        1 + 0.213 * (1 + 2.23 * slip**0.83) * heating**0.64
    )
    return phi * h_min


def test_film_of_a_slipping_bearing_is_that_by_hand_at_the_slip_of_its_contacts():
    balance = equilibrium(MAINSHAFT, SLIPPING).balance
    contacts, speed = balance.contacts, balance.conditions.entrainment_speed_m_s[0, :, 0]
    ball, ratio = 22.225e-3, 22.225 / 167.5375
    cosine = np.abs(contacts.normal[0, 1])
    area = np.pi * contacts.semi_axis_x_m[0] * contacts.semi_axis_y_m[0]
    contact = {
        "speed": speed,
        "load": contacts.load_n[0],
        "pressure": 1.5 * contacts.load_n[0] / area,
        "radius": ball / 2 * (1 + np.array([-1, 1]) * ratio * cosine),
        "ellipticity": contacts.semi_axis_y_m[0] / contacts.semi_axis_x_m[0],
    }
    # mean slip with the load of strips across the ellipse as weight, 1 - y^2, on a plain fine
    # grid; along the rolling direction the slip hardly changes
    nodes = balance.traction.slide_roll_ratio[0].reshape(2, 16, 4).mean(axis=-1)
    width = contacts.semi_axis_y_m[0]
    across = width[:, np.newaxis] * gauss_rule(16, 4).across.reshape(16, 4)[:, 0]
    fine = np.linspace(-1, 1, 2001)
    slip = np.array(
        [
            np.average(np.interp(fine * b, y[order], s[order]), weights=1 - fine**2)
            for b, y, s, order in zip(width, across, nodes, np.argsort(across), strict=True)
        ]
    )
    assert slip.max() > 0.4
    thinnest_m = by_hand(slip, contact).min()
    # Ra 0.014 and 0.05 um, Rq = 1.25 Ra
    expected = thinnest_m / (1.25 * np.hypot(0.014e-6, 0.05e-6))
    # the oil's properties have three digits on that page
    terms = torque_terms(friction_equilibrium(problem(MAINSHAFT, SLIPPING)), TESTED)
    assert terms["lambda_ratio"][0] == pytest.approx(expected, rel=5e-3)
    # without slip it would be far too thick there
    assert by_hand(0 * slip, contact).min() > 1.2 * thinnest_m


@pytest.mark.parametrize(
    ("speed_rpm", "viscosity_cst", "torque_n_m"),
    [
        (100.0, 3.0, 0.02575520933117298720),  # the surfaces touch: phi_bl is 0.995
        (3000.0, 12.0, 0.06144611492038682635),  # a film, phi_bl 0.021, and phi_ish 0.952
        (20000.0, 12.0, 0.69693718251045000561),  # no touching, and phi_ish 0.637
    ],
)
def test_skf_torque_is_that_of_the_catalogues_equations(
    speed_rpm: float, viscosity_cst: float, torque_n_m: float
) -> None:
    """800 N axial load on a pitch diameter of 62 mm."""
    torque = skf_torque_n_m(800.0, speed_rpm, viscosity_cst * 1e-6, 0.062)
    assert torque == pytest.approx(torque_n_m, rel=1e-12)


def test_palmgren_torque_is_that_of_his_equations() -> None:
    # of speed 44.17321309814681 N mm, of load 52.20008566205318 N mm
    torque = palmgren_torque_n_m(800.0, 3000.0, 12e-6, 0.062, 0.6, 1.7, 8e-4)
    assert torque == pytest.approx(0.09637329876019999676, rel=1e-12)


def test_bearing_without_contact_angle_has_no_outside_opinion_by_palmgren() -> None:
    torque = palmgren_torque_n_m(np.array([1e3, 0.0]), 1e3, 8e-6, 0.1, 0.0, 1.0, 1e-3)
    assert np.isnan(torque).all()
