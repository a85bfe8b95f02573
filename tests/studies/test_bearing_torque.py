"""The fitted law in bearings: bases told apart, traction found again, tables and figures whole."""

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
import pytest
from scipy.optimize import least_squares

from bearings import (
    RIG,
    RPM,
    SETTINGS,
    TESTED,
    lubrication,
    printed_fits,
    printed_law,
    shipped,
)
from campaigns import ROOT, printed
from oilfilm import tables
from oilfilm.bearing.catalogue_torque import palmgren_torque_n_m
from oilfilm.bearing.ellipse import Conditions
from oilfilm.bearing.friction import friction_equilibrium
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.bearing.torque import torque_terms
from oilfilm.curation.curate import check_logs
from oilfilm.curation.torque_rig import TORQUE_RIG
from oilfilm.fitting.fitted import Coefficients, FittedLaw
from oilfilm.outputs.bearing_sentences import bearing_words
from oilfilm.outputs.figures import style
from oilfilm.outputs.figures.registry import load_figure
from oilfilm.rig_twin.torque_logs import simulate_torque
from oilfilm.rig_twin.truth import true_tractions
from oilfilm.settings.campaign import Matrix
from oilfilm.settings.messages import load as load_settings
from oilfilm.settings.oil import OilFile
from oilfilm.settings.reference import PublishedPowerLoss
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.studies.bearing_torque import (
    OilInBearing,
    cage_slip_table,
    power_loss_table,
    size_effect_table,
    torque_table,
)
from oilfilm.studies.load_variables import BASES, FittedBasis
from oilfilm.studies.slip_advice import advise
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS, laws_for
from oilfilm.traction.law import Observations, to_constants, to_internal
from pictures import draw, nothing_is_cut_off


@pytest.fixture(scope="module")
def config() -> Settings:
    small = {
        "cage_slip": {"pitch_speed_mm_rpm": [1e6, 2e6], "axial_load_n": [2000, 20000]},
        "size_effect": {"ball_size_factors": [0.25, 1.0, 1.5], "groove_curvatures": [0.51, 0.54]},
    }
    return resolve(ROOT / "config", {}).with_changes({"bearing": small})


def plateaus(torque_n_m: np.ndarray, speed_rpm: np.ndarray, se: float = 0.01) -> pd.DataFrame:
    """Accepted plateaus of oil 4050 at 20 kN and 100 degC."""
    numbers = {name: 0.0 for name in tables.columns("torque_runs")}
    rows = [
        numbers
        | {
            "run_id": "a.csv",
            "oil": "4050",
            "bearing": "mainshaft-167",
            "sha256": "",
            "reader": "csv",
            "first_row": place,
            "inner_speed_rpm": speed,
            "axial_load_n": 20000.0,
            "oil_temperature_c": 100.0,
            "torque_n_m": torque,
            "torque_n_m_se": se,
            "accepted": True,
            "failed_gates": "",
        }
        for place, (torque, speed) in enumerate(zip(torque_n_m, speed_rpm, strict=True))
    ]
    return tables.from_rows(rows, "torque_runs")


@dataclass(frozen=True)
class Stronger:
    """The printed law of 4050, a third stronger."""

    def __call__(self, at: Conditions, slide_roll_ratio: np.ndarray) -> np.ndarray:
        return 1.33 * printed_law("4050")(at, slide_roll_ratio)


def test_inversion_finds_the_traction_that_was_planted(config):
    speed = np.array([6000.0, 9000.0, 12000.0])
    truth = torque_terms(
        shipped("mainshaft-167"),
        OperatingPoints.axial(20000.0, speed * RPM),
        lubrication("4050", 100, 3),
        Stronger(),
        TESTED,
    )
    torque, inversion = torque_table(plateaus(truth["torque_n_m"], speed), *printed_fits(), config)
    np.testing.assert_allclose(
        inversion["traction_coefficient"], truth["mean_traction_coefficient"], rtol=0.02
    )
    assert (inversion["law_traction_coefficient"] < inversion["traction_coefficient"]).all()
    # what the other terms may be wrong by leaves a large doubt: traction decides a part alone
    assert (inversion["traction_share"] < 0.4).all()
    assert (
        inversion["traction_coefficient_systematic"] > inversion["traction_coefficient_se"]
    ).all()
    assert set(torque["load_variable"]) == {"stress", "load", "dimensionless_load"}


def test_doubt_of_the_inversion_is_what_a_torque_wrong_by_it_would_give(config):
    speed, se = np.array([9000.0]), 0.02
    calibration = {"torque_n_m": 0.03, "torque_relative": 0.0}
    exact = dict.fromkeys(("rolling", "hysteresis", "drag", "pocket", "land"), 0.0)
    # the calibration's offset alone, so that its doubt is known: 3/2 of the random one
    alone = config.with_changes(
        {
            "campaign": {"torque": {"calibration": calibration}},
            "bearing": {"term_uncertainty": exact},
        }
    )
    first, moved = (
        torque_table(plateaus(np.array([value]), speed, se), *printed_fits(), alone)[1].iloc[0]
        for value in (7.0, 7.0 + se)
    )
    change = moved["traction_coefficient"] - first["traction_coefficient"]
    assert first["verdict"] == "determined"
    assert first["traction_coefficient_se"] == pytest.approx(change, rel=0.05)
    assert first["traction_coefficient_systematic"] == pytest.approx(1.5 * change, rel=0.05)


def test_a_torque_that_no_traction_gives_is_said_to_have_no_solution(config):
    _, inversion = torque_table(
        plateaus(np.array([500.0]), np.array([6000.0])), *printed_fits(), config
    )
    assert list(inversion["verdict"]) == ["no solution"]
    assert inversion["traction_coefficient"].isna().all()


def test_a_bearing_loaded_beyond_reason_is_told_why_it_has_no_torque(config):
    # 20 kN logged as 20 MN
    runs = plateaus(np.array([5.0, 5.0]), np.array([6000.0, 9000.0]))
    runs["axial_load_n"] *= [1000.0, 1.0]
    torque, inversion = torque_table(runs, *printed_fits(), config)
    crushed = torque[torque["first_row"] == 0]
    assert not crushed["converged"].any()
    assert crushed["torque_n_m"].isna().all()
    assert crushed["why"].str.contains("check the axial load and its unit").all()
    sound = torque[torque["first_row"] == 1]
    assert sound["converged"].all()
    assert (sound["why"] == "").all()
    assert list(inversion["verdict"].iloc[:1]) == ["no solution"]


def test_a_ball_that_lies_nowhere_is_told_how_far_it_is_from_balance(config):
    # hardly any load at four million dmn: the balls leave the inner race
    known = OilInBearing.of("4050", *printed_fits(), config)
    bearing = replace(shipped("harris-218"), groove_curvature=(0.55, 0.55))
    at = np.array([0.01]), np.array([4e6 / 125.26]), np.array([100.0])
    (row,) = known.run(bearing, *at, known.basis("stress")).to_dict("records")
    assert not row["converged"]
    assert "out of balance" in row["why"]
    assert np.isnan(row["torque_n_m"])


def test_an_oil_without_a_fit_is_left_out(config):
    coefficients, quality = printed_fits()
    unfitted = coefficients.assign(value=np.nan)
    torque, inversion = torque_table(
        plateaus(np.array([5.0]), np.array([6000.0])), unfitted, quality, config
    )
    assert torque.empty
    assert inversion.empty
    assert cage_slip_table(unfitted, quality, config).empty


def fitted_to(traction: Callable[..., np.ndarray], matrix: Matrix) -> np.ndarray:
    """Constants of Eqs 7-9 nearest to a traction over the traction rig's matrix, free of noise."""
    law = LAWS["deng2026"]
    conditions = np.array(list(itertools.product(*matrix.model_dump().values())), dtype=float)
    slip = np.linspace(0, 0.3, 16)
    curve = np.repeat(np.arange(len(conditions)), len(slip))
    at = Observations(law.design(conditions), curve, np.tile(slip, len(conditions)))
    mu = traction(*conditions[curve].T, at.slip)
    found = least_squares(
        lambda internal: law.traction(internal, at) - mu,
        to_internal(law, printed()["4050"]),
        lambda internal: law.jacobian(internal, at),
        method="lm",
        x_scale="jac",
    )
    return to_constants(law, found.x)


def test_torque_of_local_physics_is_met_nearest_by_the_stress_basis():
    # truth: thermal EHL at every place of the ellipse; law: fitted to that film on the traction rig
    matrix = {"oil_temperature_c": [100], "axial_load_n": [10000, 20000]}
    campaign = {"oils": ["4050"], "torque": {"matrix": matrix}}
    config = resolve(ROOT / "config", {"campaign": "thermal"}).with_changes({"campaign": campaign})
    traction = true_tractions(config, printed())["4050"]
    coefficients, quality = printed_fits()
    of_oil = coefficients["oil"] == "4050"
    coefficients.loc[of_oil, "value"] = fitted_to(traction, config.campaign.matrix)
    logs = list(simulate_torque(config, printed()))
    curated = check_logs([(plan.name, content) for plan, content, _ in logs], config, TORQUE_RIG)
    runs, refused = curated.points, curated.quarantine
    assert refused.empty
    truth = tables.from_rows([row for _, _, rows in logs for row in rows], "torque_truth")
    expected = truth.sort_values(["run_id", "inner_speed_rpm"])["torque_n_m"].to_numpy()
    found = runs.sort_values(["run_id", "inner_speed_rpm"])
    # 0.3 % calibration and the noise
    np.testing.assert_allclose(found["torque_n_m"], expected, rtol=0.02)
    table, _ = torque_table(runs, coefficients, quality, config)
    error = (
        table.assign(error=table["relative_error"].abs()).groupby("load_variable")["error"].median()
    )
    # how much nearer hangs on the oil: a limiting stress makes traction follow pressure weakly
    assert error["stress"] < error["load"]
    assert error["stress"] < error["dimensionless_load"]
    assert error["stress"] < 0.05


def test_a_planted_defect_of_the_twin_is_caught(config):
    logs = {plan: content for plan, content, _ in simulate_torque(config, printed())}
    named = [(plan.name, content) for plan, content in logs.items()]
    curated = check_logs(named, config, TORQUE_RIG)
    runs, refused = curated.points, curated.quarantine
    gates = {"tare_drift": "zero_drift", "truncated": "truncated", "warming": "torque_drifts"}
    for plan in logs:
        of_run = runs[runs["run_id"] == plan.name]
        if not plan.defect:
            assert of_run["accepted"].all(), plan.name
            assert len(of_run) == 4
            continue
        found = [*of_run["failed_gates"], *refused[refused["run_id"] == plan.name]["rule"]]
        assert gates[plan.defect] in found, plan.name
        assert not of_run["accepted"].any()


def test_load_based_laws_go_wrong_with_the_ball_size_and_dimensionless_ones_do_not(config):
    table = size_effect_table(*printed_fits(), config)
    of_size = table[(table["varied"] == "ball size") & (table["oil"] == "4050")]
    error = of_size.pivot(
        index="ball_diameter_mm", columns="load_variable", values="relative_to_stress"
    )
    assert error["load"].is_monotonic_increasing
    assert error["load"].iloc[-1] - error["load"].iloc[0] > 0.5
    assert np.ptp(error["dimensionless_load"]) < 0.2


def test_cage_slip_grows_with_speed_and_falls_with_load(config):
    table = cage_slip_table(*printed_fits(), config)
    assert table["converged"].all()
    for _, of_oil in table.groupby("oil"):
        grid = of_oil.pivot(
            index="axial_load_n", columns="pitch_speed_mm_rpm", values="cage_slip"
        ).to_numpy()
        assert (np.diff(grid, axis=1) > 0).all()
        assert (np.diff(grid, axis=0) < 0).all()


@pytest.mark.parametrize("name", ["fig06", "cage-slip", "size-effect", "power-loss"])
def test_figures_say_that_data_are_simulated_and_keep_what_they_draw(config, name):
    fits = printed_fits()
    runs = plateaus(np.array([5.0, 6.5]), np.array([6000.0, 9000.0]))
    published = load_settings(ROOT / "data/reference/power_loss.yaml", PublishedPowerLoss)
    slip = cage_slip_table(*fits, config)
    results = CampaignTables.in_memory(
        torque=torque_table(runs, *fits, config)[0],
        cage_slip=slip,
        slip_advice=advise(slip, config.selection, config.gates.lambda_limit),
        size_effect=size_effect_table(*fits, config),
        power_loss=power_loss_table(published, *fits, config),
    )
    figure, drawn = draw(name, results, config)
    tables.conform(drawn, load_figure(name).table, name)
    assert len(drawn)
    assert "SIMULATED" in " ".join(text.get_text() for text in figure.texts)
    assert nothing_is_cut_off(figure)


def test_published_power_loss_has_no_oils_colour_and_its_areas_are_all_terms(config):
    published = load_settings(ROOT / "data/reference/power_loss.yaml", PublishedPowerLoss)
    table = power_loss_table(published, *printed_fits(), config)
    figure, _ = draw("power-loss", CampaignTables.in_memory(power_loss=table), config)
    (axis,) = figure.axes
    (points,) = axis.lines
    np.testing.assert_array_equal(points.get_ydata(), [350, 700, 1100, 1400])  # NASA TP-2275
    assert points.get_color() not in {style.oil_colour(oil, [*printed()]) for oil in printed()}
    top = max(float(area.get_paths()[0].vertices[:, 1].max()) for area in axis.collections)
    assert top == pytest.approx(table["power_w"].iloc[-1], rel=1e-6)


@pytest.mark.parametrize("name", ["fig06", "cage-slip", "size-effect", "power-loss"])
def test_figures_of_nothing_say_so(config, name):
    figure, drawn = draw(name, CampaignTables.in_memory(), config)
    assert drawn.empty
    assert any(text.get_text() for axis in figure.axes for text in axis.texts)


def load_law_fits() -> tuple[pd.DataFrame, pd.DataFrame]:
    """Constants of the law on load for 4050, as a comparison of laws would give them."""
    law = LAWS["wang-deng-load"]
    coefficients, quality = (table[table["oil"] == "4050"] for table in printed_fits())
    rows = pd.concat([coefficients.iloc[:1]] * len(law.constants), ignore_index=True)
    names, values = [one.name for one in law.constants], np.where(WANG_DENG == 0, 1e-9, WANG_DENG)
    return (
        rows.assign(law=law.name, constant=names, value=values),
        quality.assign(law=law.name),
    )


# A, B, C, D of the law, each by load, speed and temperature
WANG_DENG = np.array(
    [-0.02, 0.15, -0.3, -0.1, 0.5, 0.4, -0.3, -0.9, 25, 0.2, 0.1, 0.3, 0.0205, 0.15, -0.3, -0.1]
)


def test_a_law_on_load_of_its_own_stands_beside_the_bases(config):
    law, runs = LAWS["wang-deng-load"], plateaus(np.array([5.0]), np.array([9000.0]))
    torque, _ = torque_table(runs, *printed_fits(), config, load_law_fits())
    row = torque.set_index("load_variable").loc["wang-deng-load"]
    assert row["converged"]
    assert set(torque["load_variable"]) == {*BASES, law.name}
    # 20 kN over 20 balls press each with little more than 1 kN
    known = OilInBearing.of("4050", *printed_fits(), config, load_law_fits())
    asked = []

    def told(at: Conditions, slide_roll_ratio: np.ndarray) -> np.ndarray:
        mu = known.basis(law.name)(at, slide_roll_ratio)
        asked.append((at.load_n.ravel(), at.entrainment_speed_m_s.ravel(), slide_roll_ratio, mu))
        return mu

    found = friction_equilibrium(
        shipped("mainshaft-167"),
        OperatingPoints.axial(20000.0, 9000 * RPM),
        lubrication("4050", 100, 1),
        told,
    )
    load, speed, slip, mu = asked[-1]
    contacts = found.balance.contacts
    np.testing.assert_array_equal(load, contacts.load_n.ravel())
    push = contacts.load_n[0, 0, 0] * np.sin(contacts.contact_angle_rad[0, 0, 0])
    assert 20 * push == pytest.approx(20000.0, rel=0.03)  # friction carries a little
    # the law's own equation at that load, written out: X = X0 (W/100 N)^X1 (U/20)^X2 (T/20)^X3
    of_each = WANG_DENG.reshape(4, 4)
    a, b, c, d = (
        x0 * (load / 100) ** x1 * (speed / 20) ** x2 * (100 / 20) ** x3
        for x0, x1, x2, x3 in of_each
    )
    slip = slip.reshape(len(load), -1).T
    np.testing.assert_allclose(
        mu.reshape(len(load), -1).T, (a + b * slip) * np.exp(-c * slip) + d, rtol=1e-9
    )


def test_groups_of_a_law_are_those_of_the_bearings_contact():
    # W/(E' R^2), eta0 U/(E' R), eta0 beta U^2/k with the contact's own Rx and E'
    oil = load_settings(ROOT / "config/oils/4050.yaml", OilFile).properties()
    law = laws_for(oil, RIG)["wang-deng-groups"]
    fitted = FittedLaw(law, Coefficients.bare(law, WANG_DENG))
    radius, modulus = np.array([0.004, 0.012]), 2.5e11
    load, speed = np.array([200.0, 900.0]), np.array([30.0, 60.0])

    def each(values: np.ndarray | float) -> np.ndarray:
        return np.broadcast_to(values, (2,))[:, np.newaxis].astype(float)

    at = Conditions(each(load), each(1.0), each(speed), each(100.0), each(radius), modulus)
    basis = FittedBasis(fitted, "stress", RIG, SETTINGS.law_floor.model_dump())
    mu = basis(at, np.full((2, 1), 0.02))
    eta, beta = oil.dynamic_viscosity_pa_s(100.0), oil.temperature_viscosity_coefficient_1_k(100.0)
    groups = (
        load / (modulus * radius**2) / 1e-6,
        eta * speed / (modulus * radius) / 1e-10,
        eta * beta * speed**2 / oil.thermal_conductivity_w_mk(100.0),
    )
    a, b, c, d = (
        x0 * groups[0] ** x1 * groups[1] ** x2 * groups[2] ** x3
        for x0, x1, x2, x3 in WANG_DENG.reshape(4, 4)
    )
    np.testing.assert_allclose(mu[:, 0], (a + b * 0.02) * np.exp(-c * 0.02) + d)


def test_shares_beyond_an_unknown_box_are_unknown(config):
    coefficients, quality = printed_fits()
    blank = quality.assign(
        tested_min_max_hertz_pressure_gpa=np.nan, tested_max_max_hertz_pressure_gpa=np.nan
    )
    runs = plateaus(np.array([5.0]), np.array([9000.0]))
    table, _ = torque_table(runs, coefficients, blank, config)
    assert table["share_beyond_pressure"].isna().all()
    assert table["share_beyond_speed"].between(0, 1).all()


def test_the_summary_tells_of_logs_errors_and_advice(config):
    logs = list(simulate_torque(small(config), printed()))
    curated = check_logs([(plan.name, content) for plan, content, _ in logs], config, TORQUE_RIG)
    runs, refused = curated.points, curated.quarantine
    fits = printed_fits()
    torque, inversion = torque_table(runs, *fits, config)
    slip = cage_slip_table(*fits, config)
    advice = advise(slip, config.selection, config.gates.lambda_limit)
    results = CampaignTables.in_memory(
        torque_runs=runs,
        torque_quarantine=refused,
        torque=torque,
        torque_inversion=inversion,
        slip_advice=advice,
    )
    text = "\n".join(bearing_words(results))
    assert "torque logs 2 read of 3; plateaus 8 accepted of 8" in text
    refusal = "zero_drift 1: 4050_F05000_T070.csv: the zero of the torque moves"
    assert f"torque quarantine, {refusal}" in text
    assert "; load " in text
    assert "of 24 equilibria none not found" in text
    assert "pressure " in text
    assert "the paper's rules advise" in text
    nothing = bearing_words(CampaignTables.in_memory())
    assert nothing[1] == "  torque logs 0 read of 0; plateaus 0 accepted of 0"


def small(config: Settings) -> Settings:
    """The campaign with three torque logs of one oil."""
    torque = {"matrix": {"oil_temperature_c": [70]}}
    return config.with_changes({"campaign": {"oils": ["4050"], "torque": torque}})


def test_bearing_without_contact_angle_has_no_outside_opinion_by_palmgren() -> None:
    found = palmgren_torque_n_m(np.array([1e3, 0.0]), 1e3, 8e-6, 0.1, 0.0, 1.0, 1e-3)
    assert np.isnan(found).all()
