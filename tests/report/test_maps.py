"""Maps for a tribologist: friction map, traction over the film, curves without their own heat."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import quad

from campaigns import HEATED_FILM, oil_of, printed
from fit_points import matrix
from oilfilm.base.units import FloatArray
from oilfilm.physics.contact import Conditions
from oilfilm.physics.film import InletOil, film_thickness, film_viscosity_ratio
from oilfilm.physics.thermal_traction import ThermalEhlConstants, film_stress, thermal_ehl_traction
from oilfilm.report.figures.fits import _levels_up_to, without_heat
from oilfilm.settings.base import required_value
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import CONDITIONS
from oilfilm.traction.laws.deng2026 import traction_coefficient
from pictures import Draw, drawing_of, nothing_is_cut_off, settings_of_oils


@pytest.fixture(scope="module")
def drawing(on_printed_law: CampaignTables, config: Settings) -> Draw:
    return drawing_of(on_printed_law, config)


def test_friction_map_is_the_law_and_knows_the_film(drawing: Draw, config: Settings) -> None:
    figure, drawn = drawing("friction-map")
    assert nothing_is_cut_off(figure)
    of_oil = drawn[(drawn["oil"] == "4050") & (drawn["panel"] == "e")]  # 1.5 GPa
    mu = of_oil[of_oil["series"] == "mu"]
    expected = traction_coefficient(printed()["4050"], 1.5, mu["x"], 100.0, mu["y"])
    np.testing.assert_allclose(mu["value"], expected, rtol=1e-9)
    # docs/physics.md: 0.161 um at 25 m/s, 100 degC and S = 0.3
    fast = of_oil[(of_oil["series"] == "lambda") & (of_oil["y"] > 0.2999)]
    (rig,) = config.rigs.values()
    roughness_um = 1e6 * required_value(rig.contact(), "contact", "the rig").roughness_rq_m
    ratio = np.interp(25.0, fast["x"], fast["value"])
    assert ratio == pytest.approx(0.161 / roughness_um, rel=0.01)


def test_law_that_runs_away_beyond_its_tests_has_a_map() -> None:
    levels = [_levels_up_to(highest)[[0, -1]].tolist() for highest in (0.1, 600.0)]
    assert levels == [[0.001, 0.1], [0.05, 5.0]]


def test_traction_is_drawn_over_lambda(drawing: Draw) -> None:
    figure, drawn = drawing("stribeck")
    assert nothing_is_cut_off(figure)
    assert len(drawn) == 3 * len(matrix())
    speeds = drawn["x"] / 0.4
    assert set(speeds.round(6)) == {speed for _, speed, _ in matrix()}


@dataclass
class HeatedTruth:
    """Traction of thermal elastohydrodynamics in place of a fitted law."""

    law = SimpleNamespace(conditions=CONDITIONS)
    widened_box = np.array([[0.8, 2.0], [5.0, 60.0], [20.0, 120.0], [0.0, 0.6]])

    def predict(self, conditions: Any, slip: Any) -> Any:
        pressure, speed, temperature = conditions.T
        mu = thermal_ehl_traction(
            OIL, CONSTANTS, 1e9 * pressure, speed, temperature, slip, 0.010, MODULUS_PA
        )
        return SimpleNamespace(traction_coefficient=mu)


OIL, MODULUS_PA = oil_of("4050"), 221.6e9
CONSTANTS = ThermalEhlConstants(**HEATED_FILM)


def isothermal_truth(pressure_gpa: float, speed: float, inlet_c: float, slip: float) -> float:
    """The mean of the contact's points by their load, with a film as cold as the inlet."""
    (rig_load,) = [pressure_gpa**3 * 142 / 1.5**3]  # 142 N give 1.5 GPa (docs/physics.md)
    at = Conditions(rig_load, pressure_gpa, speed, inlet_c, 0.010, MODULUS_PA)
    film_m = float(film_thickness(InletOil.from_oil(OIL, inlet_c), at, slip, "central"))

    def of_ring(s: float) -> float:
        pressure = np.array(1e9 * pressure_gpa * s)
        rate = np.array(speed * slip / film_m)
        return float(film_stress(OIL, CONSTANTS, pressure, np.array(inlet_c), rate) / pressure)

    return 3 * quad(lambda s: of_ring(s) * s**2, 0, 1)[0]


def curve_of(conditions: FloatArray, slip: Any, mu: Any) -> pd.DataFrame:
    """Points of a curve of the oil 4050; 142 N give 1.5 GPa (docs/physics.md)."""
    load_n = conditions[:, 0] ** 3 * 142 / 1.5**3
    return pd.DataFrame(conditions, columns=list(CONDITIONS)).assign(
        oil="4050", load_n=load_n, slide_roll_ratio=slip, traction_coefficient=mu
    )


@pytest.mark.parametrize(("pressure", "slip"), [(1.0, 0.05), (1.0, 0.2), (1.5, 0.05), (1.5, 0.1)])
def test_correction_recovers_most_of_heat(config: Settings, pressure: float, slip: float) -> None:
    speed, inlet = 30.0, 100.0
    truth = HeatedTruth()
    at = np.array([[pressure, speed, inlet]])
    measured = truth.predict(at, np.array([slip])).traction_coefficient.item()
    curve = curve_of(at, slip, measured)
    (rig,) = config.rigs.values()
    contact = required_value(rig.contact(), "contact", "the rig")
    corrected = without_heat(curve, truth, contact, config)  # type: ignore[arg-type]
    cold = isothermal_truth(pressure, speed, inlet, slip)
    lost = cold - measured
    assert lost > 0.02 * cold
    left = cold - corrected["traction_coefficient"].item()
    assert abs(left) < 0.36 * lost
    hot = curve.assign(inlet_temperature_c=25.0)
    if slip == 0.2:  # colder than any test
        assert without_heat(hot, truth, contact, config)["traction_coefficient"].isna().all()  # type: ignore[arg-type]


class LawWithoutHeat(HeatedTruth):
    """A law of saturated traction that holds no heat: no film made its curves."""

    def predict(self, conditions: Any, slip: Any) -> Any:
        _, speed, temperature = conditions.T
        largest = 0.05 * np.exp(-0.012 * (temperature - 60)) * (speed / 30) ** -0.3
        return SimpleNamespace(traction_coefficient=largest * np.tanh(slip / 0.15))


def test_impossible_correction_is_refused(config: Settings) -> None:
    """No film gains more than its viscosity does, and none has a mu/S that rises with S."""
    pressure, speed, inlet = 1.5, 40.0, 120.0
    slip = np.linspace(0.01, 0.2, 20)
    law = LawWithoutHeat()
    at = np.tile([pressure, speed, inlet], (len(slip), 1))
    measured = law.predict(at, slip).traction_coefficient
    curve = curve_of(at, slip, measured)
    (rig,) = config.rigs.values()
    contact = required_value(rig.contact(), "contact", "the rig")
    corrected = without_heat(curve, law, contact, config)  # type: ignore[arg-type]
    mu = corrected["traction_coefficient"].to_numpy()
    kept = np.isfinite(mu)
    assert kept.any()
    assert not kept.all()
    slope = (mu / slip)[kept]
    assert (np.diff(slope) <= 0.021 * slope[:-1]).all()


def test_viscosity_ratio_is_that_of_barus() -> None:
    pressure, inlet, rise = np.array([0.0, 1.2]), np.array([60.0, 60.0]), np.array([15.0, 15.0])
    ratio = film_viscosity_ratio(OIL, pressure, inlet, rise)
    eta, alpha = OIL.dynamic_viscosity_pa_s, OIL.pressure_viscosity_coefficient_1_pa
    at_no_pressure = eta(60.0) / eta(75.0)
    assert ratio[0] == pytest.approx(at_no_pressure)
    assert ratio[1] == pytest.approx(at_no_pressure * np.exp((alpha(60.0) - alpha(75.0)) * 0.8e9))


def test_isothermal_curves_are_above_the_measured_ones(drawing: Draw) -> None:
    figure, drawn = drawing("isothermal")
    assert nothing_is_cut_off(figure)
    curves = drawn.query("oil == '4102' and x > 0").pivot_table("y", ["words", "x"], "series")
    # heat lowers the traction
    assert (curves["isothermal"] > curves["measured"])[curves["isothermal"].notna()].all()


def test_isothermal_curve_is_corrected_in_the_contact_of_its_own_rig(
    drawing: Draw, on_printed_law: CampaignTables, config: Settings
) -> None:
    plain = config.plain_values()
    (rig_name,) = plain["rigs"]
    small_ball = plain["rigs"][rig_name] | {"ball_radius_m": 0.005}
    points = on_printed_law.points.query(
        "oil == '4102' and entrainment_speed_m_s == 40 and inlet_temperature_c == 120"
    )[::10]
    first, second, third = points["run_id"].unique()
    runs = on_printed_law.runs
    runs = runs.assign(rig=runs["run_id"].map({first: "small"}).fillna(rig_name))
    is_unknown = points["run_id"] == third
    pressure = points["max_hertz_pressure_gpa"].mask(is_unknown)
    points = points.assign(max_hertz_pressure_gpa=pressure)
    new = {
        name: getattr(on_printed_law, name).query("oil == '4102'")
        for name in ("coefficients", "fit_quality")
    }
    new |= {"points": points, "runs": runs}
    drawn_in_order = []
    for names in ((rig_name, "small"), ("small", rig_name)):
        rig_of_name = {rig_name: plain["rigs"][rig_name], "small": small_ball}
        rigs = {name: rig_of_name[name] for name in names}
        settings = Settings.from_plain_values(plain | {"rigs": rigs})
        _, drawn = drawing("isothermal", settings_of_oils(settings, ["4102"]), **new)
        drawn_in_order.append(drawn)
    pd.testing.assert_frame_equal(*drawn_in_order)
    assert drawn["value"].max() > 0
    assert set(drawn["words"]) == {first, second}
