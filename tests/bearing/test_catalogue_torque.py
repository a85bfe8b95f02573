"""Catalogue torque against its equations, worked out by another program (bc, 20 digits)."""

import numpy as np
import pytest

from oilfilm.bearing.torque import palmgren_torque_n_m, skf_torque_n_m


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
