"""The oil's temperature at the outlet: conservation of energy, closed forms, limits."""

from collections.abc import Callable

import numpy as np
import pytest

from bearings import RPM, equilibrium, shipped
from campaigns import oil_of
from oilfilm.bearing.geometry import OilSupply
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.torque.heat_balance import HeatBalance, heat_balance

SUPPLY = OilSupply(flow_m3_s=8e-3 / 60, heat_share=0.8, outlet_weight=0.5)


def balance_of(heat_w: Callable[[np.ndarray], np.ndarray], **changed: float) -> HeatBalance:
    """Balance of one point of oil 4050 at 100 degC whose heat depends on the temperature alone."""
    supply = OilSupply(**(vars(SUPPLY) | changed))
    return heat_balance(lambda at, which: heat_w(at), oil_of("4050"), supply, np.array([100.0]))


def test_constant_heat_warms_the_oil_by_heat_over_flow_and_heat_capacity():
    # docs/physics.md, Oils: 23699 type, rho 918 kg/m3 at 100 degC, c_p 2000 J/(kg K).
    # 0.8 x 10 kW / (918 x 8e-3/60 x 2000) = 32.7 K
    balance = balance_of(lambda at: np.full_like(at, 10e3))
    assert balance.is_balanced.all()
    assert balance.outlet_temperature_c[0] == pytest.approx(132.7, abs=0.1)
    assert balance.contact_temperature_c[0] == pytest.approx(100 + 32.7 / 2, abs=0.05)


def test_heat_that_falls_by_a_line_meets_the_cooling_where_the_lines_cross():
    # H = 10 kW (1 - (T - 100)/50): rise r from C r = 0.8 x 10 kW (1 - r/100), C = 244.8 W/K
    balance = balance_of(lambda at: 10e3 * (1 - (at - 100) / 50))
    assert balance.outlet_temperature_c[0] - 100 == pytest.approx(8000 / (244.8 + 80), rel=2e-3)


def test_a_bearing_that_does_not_turn_heats_nothing():
    balance = balance_of(np.zeros_like)
    assert balance.is_balanced.all()
    assert balance.outlet_temperature_c[0] == 100


def test_where_the_heat_jumps_there_is_no_steady_temperature():
    balance = balance_of(lambda at: np.where(at < 110, 10e3, 1e3))
    assert not balance.is_balanced.any()
    assert np.isnan(balance.outlet_temperature_c).all()


def test_a_trickle_of_oil_cannot_carry_the_heat():
    balance = balance_of(lambda at: np.full_like(at, 10e3), flow_m3_s=1e-3 / 60)
    # 261 K would be needed: 361 degC; half of that flow would boil
    assert balance.is_balanced.all()
    assert not balance_of(lambda at: np.full_like(at, 10e3), flow_m3_s=5e-4 / 60).is_balanced.any()


@pytest.mark.parametrize("oil", ["4010", "4102"])
def test_the_oil_takes_its_share_of_the_heat_of_a_bearing(oil):
    bearing, speed = shipped("mainshaft-167"), np.array([3000.0, 9000.0, 15000.0])
    inlet = np.array([70.0, 100.0, 100.0])

    def heat_w(at: np.ndarray, which: np.ndarray) -> np.ndarray:
        points = OperatingPoints.from_load_and_speed(10e3, speed[which] * RPM)
        found = equilibrium(bearing, points, oil, at)
        return bearing.ball_count * np.sum(found.balance.heats_w, axis=0)

    balance = heat_balance(heat_w, oil_of(oil), SUPPLY, inlet)
    assert balance.is_balanced.all()
    known, outlet = oil_of(oil), balance.outlet_temperature_c
    # enthalpy by c_p integrated in fine steps
    steps = np.linspace(inlet, outlet, 20001)
    enthalpy = np.trapezoid(known.specific_heat_j_kgk(steps), steps, axis=0)
    taken = known.density_kg_m3(inlet) * SUPPLY.flow_m3_s * enthalpy
    made = heat_w(balance.contact_temperature_c, np.arange(3))
    np.testing.assert_allclose(taken, 0.8 * made, rtol=1e-3)
    # heated oil makes less heat than cool oil would
    assert (made < heat_w(inlet, np.arange(3))).all()
