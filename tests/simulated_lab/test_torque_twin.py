"""The law behind the traction logs stands behind the torque logs: a control of the whole chain."""

from collections.abc import Callable

import numpy as np
import pytest

from bearings import RPM, in_operation, problem, shipped
from campaigns import ROOT, Campaign, printed
from oilfilm.bearing.equilibria import friction_equilibrium
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.physics.contact import Conditions
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.torque.bearing_torque import oils_in_bearings, torque_table
from torque_logs import curated_logs


def eq7(oil: str) -> Callable[[Conditions, np.ndarray], np.ndarray]:
    """The printed law in a bearing, written out: Eqs 7-9."""

    def law(at: Conditions, slip: np.ndarray) -> np.ndarray:
        pressure, speed = at.max_hertz_pressure_gpa, at.entrainment_speed_m_s / 20
        bars = (pressure, speed, at.inlet_temperature_c / 20)
        a, b, c = (
            x0 * bars[0] ** x1 * bars[1] ** x2 * bars[2] ** x3
            for x0, x1, x2, x3 in printed()[oil].reshape(3, 4)
        )
        return (a + b * slip) * np.exp(-c * slip) - a

    return law


def test_true_torque_is_that_of_the_law_behind_the_traction_logs(config: Settings) -> None:
    *_, truth = curated_logs(config)
    of_oil = truth[truth["oil"] == "4050"]
    load, speed, temperature = of_oil[
        ["axial_load_n", "inner_speed_rpm", "oil_temperature_c"]
    ].to_numpy().T  # fmt: skip
    points = OperatingPoints.from_load_and_speed(load, speed * RPM)
    bearing, law = shipped("mainshaft-167"), eq7("4050")
    at_rest = problem(bearing, points, "4050", temperature, law, (32, 8))
    torque = friction_equilibrium(in_operation(at_rest)).torque_n_m()
    np.testing.assert_allclose(of_oil["torque_n_m"], torque, rtol=1e-5)
    assert (truth["law_misfit"] == 0).all()


@pytest.mark.nightly
def test_torque_by_a_heated_film_falls_when_the_oil_is_warmer() -> None:
    # each node of the contact has its own pressure: this truth is a law of certain nodes
    matrix = {"axial_load_n": [20000], "inner_speed_rpm": [6000], "oil_temperature_c": [70, 100]}
    changes = {"oils": ["4050"], "torque": {"matrix": matrix, "twin": {"defects": []}}}
    thermal = resolve(ROOT / "config", {"campaign": "thermal"}).with_changes({"campaign": changes})
    *_, truth = curated_logs(thermal)
    cold, warm = truth.sort_values("oil_temperature_c")["torque_n_m"]
    assert 0 < warm < cold


@pytest.mark.slow
def test_with_one_truth_the_fitted_law_meets_the_torque(demo: Campaign, config: Settings) -> None:
    # positive control: from simulated traction logs by the fit to the torque of simulated logs
    plain = config.with_changes({"campaign": {"oils": ["4102"]}}).plain_values()
    config = Settings.from_plain_values({**plain, "oils": {"4102": plain["oils"]["4102"]}})
    fit = demo.fit("4102", bootstrap=20, searches=2)
    (oil,) = oils_in_bearings(fit.coefficients, fit.fit_quality, config)
    _, curated, true = curated_logs(config)
    # free of noise: 0.04 % in the median and 1.1 % where the cage skids, from the fit's errors
    load, speed, temperature = (
        true[name].to_numpy() for name in ("axial_load_n", "inner_speed_rpm", "oil_temperature_c")
    )
    calculated = oil.calculate(config.tested_bearing(), load, speed, temperature)["torque_n_m"]
    error = np.abs(calculated.to_numpy() / true["torque_n_m"].to_numpy() - 1)
    assert np.median(error) < 4e-4
    assert error.max() < 0.012
    # and of the logs: noise, and the sensor's calibration of 0.3 % and 0.01 N m
    table, _ = torque_table(curated.points, [oil], config)
    by_stress = table[table["load_variable"] == "stress"]
    measured, se = by_stress["measured_torque_n_m"], by_stress["measured_torque_n_m_se"]
    allowed = np.sqrt(se**2 + 0.01**2 + (0.003 * measured) ** 2)
    assert (np.abs(by_stress["torque_n_m"] - measured) < 4 * allowed).all()
    assert by_stress["relative_error"].abs().median() < 0.003


def test_a_planted_defect_of_the_twin_is_caught(config: Settings) -> None:
    defects, curated, _ = curated_logs(config)
    runs, refused = curated.points, curated.quarantine
    gates = {"tare_drift": "zero_drift", "truncated": "truncated", "warming": "torque_drifts"}
    for name, defect in defects.items():
        of_run = runs[runs["run_id"] == name]
        if not defect:
            assert of_run["accepted"].all(), name
            assert len(of_run) == 4
            continue
        refusals = [*of_run["failed_gates"], *refused[refused["run_id"] == name]["rule"]]
        assert gates[defect] in refusals, name
        assert not of_run["accepted"].any()
