"""Uncertainty of the calculated torque: draws against derivatives, and where cages part."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.special import ndtri

from bearings import SETTINGS, exact_keys, printed_law, shipped
from campaigns import LABORATORY, oil_of
from nights import nightly
from oilfilm.base.units import FloatArray
from oilfilm.bearing.equilibria import friction_equilibrium
from oilfilm.bearing.inputs import InputValues, UncertainInput
from oilfilm.fits.fitted import FittedLaw
from oilfilm.settings.config import StandInUncertaintySettings, TermUncertaintySettings
from oilfilm.settings.resolve import resolve
from oilfilm.torque.answers import calculate_answers, operating_point_table, range_text
from oilfilm.torque.bearing_torque import (
    CaseGroup,
    FrictionCases,
    OilInBearing,
    cage_slip_table,
    torque_table,
)
from oilfilm.torque.load_variables import LOAD_VARIABLES, LawInBearing
from oilfilm.torque.torque_uncertainty import (
    RANDOM_FACTOR_TERMS,
    RandomDraws,
    add_uncertainty,
    law_error,
    random_factor,
)
from oilfilm.traction.law import CONDITIONS, to_constants

SHIPPED = shipped("mainshaft-167")
# Its inputs are known exactly, so that a test draws what it names.
BEARING = replace(
    SHIPPED,
    uncertain_inputs={
        name: UncertainInput(value, value, value)
        for name, (value, _, _) in SHIPPED.uncertain_inputs.items()
    },
)
EXACT = dict.fromkeys(RANDOM_FACTOR_TERMS, 0.0)
OIL_VOLUME_FRACTION = SETTINGS.oil_volume_fraction
LOAD_SPEED_TEMPERATURE = {
    "axial_load_n": 10000.0,
    "inner_speed_rpm": 12000.0,
    "inlet_temperature_c": 100.0,
}
LOAD_SPEEDS_TEMPERATURE = (10000.0, np.array([6000.0, 12000.0]), 100.0)


def test_factors_on_terms_have_the_mean_and_the_spread_that_are_set() -> None:
    normal = ndtri((np.arange(20000) + 0.5) / 20000)
    for term in RANDOM_FACTOR_TERMS:
        factors = random_factor(SETTINGS, term, normal)
        assert factors.mean() == pytest.approx(1, rel=1e-3)
        spread = getattr(SETTINGS.term_uncertainty, term)
        assert factors.std() == pytest.approx(spread, rel=5e-3)


def oil(
    name: str,
    refits: np.ndarray,
    shifts: np.ndarray,
    drag: float = 0.0,
    viscosity: float = 0.0,
    run_sd: float = float("nan"),
    law_error: float = 0.0,
) -> OilInBearing:
    """An oil with the printed law, refits that differ from it by `refits`, and one calibration.

    Args:
        name: Of the oil.
        refits: Differences of the internal constants, shape (refits, constants).
        shifts: The same of refits with one sensor off.
        drag: Half the range of the logarithm of the oil's volume fraction.
        viscosity: Relative standard uncertainty of the stand-in's viscosity.
        run_sd: Standard deviation of ln mu in a run.
        law_error: Standard error of ln mu by the law where nothing was tested.
    """

    def refitted(law: LawInBearing) -> LawInBearing:
        internal = law.internal_constants[0]
        refitted_constants, shifted_constants = (
            to_constants(law.fitted.law, internal + difference) for difference in (refits, shifts)
        )
        coefficients = replace(
            law.fitted.coefficients,
            refits=refitted_constants,
            shifted_refits=shifted_constants,
            run_sd=run_sd,
        )
        return replace(law, fitted=replace(law.fitted, coefficients=coefficients))

    laws = {variable: refitted(printed_law(name, variable)) for variable in LOAD_VARIABLES}
    stand_in = {"viscosity": viscosity, "pressure_viscosity_coefficient": 0.0}
    changed_settings = {
        "term_uncertainty": TermUncertaintySettings(**EXACT),
        "stand_in_uncertainty": StandInUncertaintySettings(**stand_in),
        "oil_volume_fraction_range": [
            OIL_VOLUME_FRACTION * np.exp(-drag),
            OIL_VOLUME_FRACTION * np.exp(drag),
        ],
        "replenishment_constant_range": [SETTINGS.replenishment_constant] * 2,
        "ellipse_factor_range": [SETTINGS.ellipse_factor] * 2,
        "law_error_beyond": law_error,
    }
    unknown_ranges = dict.fromkeys((*CONDITIONS, "slide_roll_ratio"), (np.nan, np.nan))
    return OilInBearing(
        name, oil_of(name), laws, unknown_ranges, SETTINGS.model_copy(update=changed_settings)
    )


def with_first_constant(value: float, rows: int = 1) -> np.ndarray:
    """Rows of 12 internal constants of which the first, ln|A0|, has a value."""
    return np.pad(np.full((rows, 1), value), ((0, 0), (0, 11)))


def torque(oil_in_bearing: OilInBearing, **changed_settings: float) -> np.ndarray:
    settings = oil_in_bearing.bearing_settings.model_copy(update=changed_settings)
    return (
        replace(oil_in_bearing, bearing_settings=settings)
        .calculate(BEARING, *LOAD_SPEEDS_TEMPERATURE)["torque_n_m"]
        .to_numpy()
    )


def with_shares(
    oil_in_bearing: OilInBearing, oil_volume_fractions: np.ndarray, points: pd.DataFrame
) -> pd.DataFrame:
    """Friction at operating points with each share of oil."""
    cases = []
    for oil_volume_fraction in oil_volume_fractions:
        settings = oil_in_bearing.bearing_settings.model_copy(
            update={"oil_volume_fraction": oil_volume_fraction}
        )
        cases.append(
            CaseGroup(replace(oil_in_bearing, bearing_settings=settings), "stress", points)
        )
    return FrictionCases(BEARING, cases).calculate()


def drawn(oil_in_bearing: OilInBearing, *point: object, seed: int = 1) -> pd.DataFrame:
    names = ("axial_load_n", "inner_speed_rpm", "inlet_temperature_c")
    values = np.broadcast_arrays(*map(np.atleast_1d, point))
    points = pd.DataFrame(dict(zip(names, values, strict=True)))
    return FrictionCases(
        BEARING, [CaseGroup(oil_in_bearing, "stress", points)]
    ).calculate_with_uncertainty(seed)[0]


def test_draws_give_the_uncertainty_of_refits_calibration_and_drag_by_their_derivatives():
    random = np.random.default_rng(0)
    spread, shift, drag = 0.02, 0.015, 0.1
    refits = with_first_constant(1.0, 400) * spread * random.standard_normal((400, 1))
    uncertain_oil = oil("4050", refits, with_first_constant(shift), drag=drag)
    law = uncertain_oil.laws["stress"]
    internal = law.internal_constants[0]
    moved_oil = uncertain_oil.with_constants(
        to_constants(law.fitted.law, internal + with_first_constant(shift)[0])
    )
    by_shift = torque(moved_oil) - torque(uncertain_oil)
    by_drag = (
        torque(uncertain_oil, oil_volume_fraction=1.01 * OIL_VOLUME_FRACTION)
        - torque(uncertain_oil)
    ) / 0.01
    # evenly spread over the logarithm from -drag to drag
    expected = np.hypot(by_shift * np.hypot(spread / shift, 1), by_drag * drag / np.sqrt(3))
    results = drawn(uncertain_oil, *LOAD_SPEEDS_TEMPERATURE)
    np.testing.assert_allclose(results["torque_n_m_uncertainty"], expected, rtol=0.15)
    # about normal at rolling cages: 1.96 standard uncertainties to either side
    half_interval = (results["torque_n_m_upper"] - results["torque_n_m_lower"]) / 2
    np.testing.assert_allclose(half_interval, 1.96 * expected, rtol=0.25)
    assert not results["draws_split"].any()
    inner_speed_rad_s = results["inner_speed_rpm"] * np.pi / 30
    np.testing.assert_allclose(
        results["power_w_upper"], results["torque_n_m_upper"] * inner_speed_rad_s
    )


@pytest.mark.slow
def test_calculated_and_measured_torque_agree_within_two_uncertainties_of_their_side():
    # drag may be up to 2.2 times as large, or 2.2 times as small: the upper side is the longer one
    uncertain_oil = oil("4050", with_first_constant(0.0, 10), with_first_constant(0.0, 0), drag=0.8)
    calculated = drawn(uncertain_oil, *LOAD_SPEED_TEMPERATURE.values()).iloc[0]
    torque, lower, upper = (calculated[f"torque_n_m{end}"] for end in ("", "_lower", "_upper"))
    below, above = torque - lower, upper - torque
    assert above > 1.4 * below
    # 1.3 times the shorter side is well within the longer one
    measured = torque + np.array([1.3 * below, -1.3 * below, 1.3 * above, -0.7 * below])
    plateaus = pd.DataFrame({"torque_n_m": measured, "first_row": range(4)}).assign(
        run_id="a.csv", oil="4050", accepted=True, axial_load_n=10000.0, inner_speed_rpm=12000.0
    )
    plateaus = plateaus.assign(oil_temperature_c=100.0, torque_n_m_se=0.01)
    config = resolve(LABORATORY, {}).with_changes(
        {"bearings": {"mainshaft-167": exact_keys("mainshaft-167")}}
    )
    table, _ = torque_table(plateaus, [uncertain_oil], config)
    rows = table[table["load_variable"] == "stress"].sort_values("first_row")
    # of the sensor: 0.01 N m at random, 0.01 N m offset, 0.3 % gain
    sensor_uncertainty = np.sqrt(0.01**2 + 0.01**2 + (0.003 * measured) ** 2)
    np.testing.assert_allclose(rows["measured_torque_n_m_uncertainty"], sensor_uncertainty)
    # an interval of 95 % has 1.96 standard uncertainties to each side
    interval_sides = rows["torque_n_m_upper"] - torque, torque - rows["torque_n_m_lower"]
    interval_side = np.where(measured > torque, *interval_sides)
    expected = (torque - measured) / np.sqrt((interval_side / 1.96) ** 2 + sensor_uncertainty**2)
    np.testing.assert_allclose(rows["compatibility"], expected)
    verdicts = ["compatible", "not compatible", "not compatible", "compatible"]
    assert rows["verdict"].tolist() == verdicts


def test_a_law_without_refits_has_no_uncertainty():
    results = drawn(
        oil("4050", with_first_constant(0.0, 0), with_first_constant(0.0, 0)),
        *LOAD_SPEEDS_TEMPERATURE,
    )
    names = [name for name in results if name.endswith(("_uncertainty", "_lower", "_upper"))]
    assert len(names) == 9
    assert results[names].isna().all(axis=None)
    assert not results["draws_split"].any()
    assert results["power_w"].notna().all()


@pytest.mark.slow
@pytest.mark.parametrize(("load_n", "split"), [(4800.0, True), (20000.0, False)])
def test_draws_on_both_sides_of_a_fold_are_told(load_n, split):
    # 4010 at 12 000 rpm and 70 degC under little load, where traction falls with slip
    point = {"axial_load_n": [load_n], "inner_speed_rpm": 12000.0, "inlet_temperature_c": 70.0}
    uncertain = oil("4010", with_first_constant(0.0, 10), with_first_constant(0.0, 0), drag=0.6)
    results = drawn(uncertain, *point.values()).iloc[0]
    shares = OIL_VOLUME_FRACTION * np.exp(np.linspace(-0.6, 0.6, 25))
    slips = with_shares(uncertain, shares, pd.DataFrame(point))["cage_slip"]
    # with more drag the cage slips more: by a jump where there is a fold
    assert (np.diff(slips).max() > 0.05) == split
    assert results["draws_split"] == split
    assert results["cage_slip_lower"] < results["cage_slip"] < results["cage_slip_upper"]


def test_viscosity_of_a_stand_in_and_errors_of_runs_widen_the_torque():
    exact_oil = oil("4050", with_first_constant(0.0, 10), with_first_constant(0.0, 0))
    assert (drawn(exact_oil, *LOAD_SPEEDS_TEMPERATURE)["torque_n_m_uncertainty"] < 1e-6).all()
    oil_of_unknown_viscosity = oil(
        "4050", with_first_constant(0.0, 10), with_first_constant(0.0, 0), viscosity=0.1
    )
    cases = FrictionCases(
        BEARING,
        [CaseGroup(oil_of_unknown_viscosity, "stress", pd.DataFrame([LOAD_SPEED_TEMPERATURE]))],
    )
    lubrication = cases.problem.lubrication
    thicker_oil = replace(
        lubrication.inlet_oil,
        dynamic_viscosity_pa_s=1.01 * lubrication.inlet_oil.dynamic_viscosity_pa_s,
    )
    problem_with_thicker_oil = replace(
        cases.problem, lubrication=replace(lubrication, inlet_oil=thicker_oil)
    )
    torque_n_m, torque_of_thicker_oil_n_m = (
        friction_equilibrium(problem).torque_n_m()[0]
        for problem in (cases.problem, problem_with_thicker_oil)
    )
    results = drawn(oil_of_unknown_viscosity, *LOAD_SPEED_TEMPERATURE.values())[
        "torque_n_m_uncertainty"
    ]
    assert results[0] == pytest.approx(
        (torque_of_thicker_oil_n_m - torque_n_m) / np.log(1.01) * 0.1, rel=0.1
    )
    # a run is off by 5 % of mu at one standard deviation
    problem_with_more_traction = replace(
        cases.problem, lubrication=lubrication.with_traction_factor(np.array([1.01]))
    )
    change = friction_equilibrium(problem_with_more_traction).torque_n_m()[0] - torque_n_m
    oil_with_run_error = oil(
        "4050", with_first_constant(0.0, 10), with_first_constant(0.0, 0), run_sd=0.05
    )
    results = drawn(oil_with_run_error, *LOAD_SPEED_TEMPERATURE.values())["torque_n_m_uncertainty"]
    assert results[0] == pytest.approx(abs(change) / np.log(1.01) * 0.05, rel=0.15)


@pytest.mark.slow
def test_all_oils_of_a_draw_have_one_drag_and_the_best_of_each_draw_is_counted():
    # of 4010 the cage slips by just more or just less than the limit at 1.4e6 mm rpm and 3 kN
    names = ("4102", "4010")
    config = resolve(LABORATORY, {}).with_changes(
        {
            "bearing": {
                "cage_slip": {"pitch_speed_mm_rpm": [1.2e6, 1.4e6], "axial_load_n": [3e3, 1e4]}
            },
            "bearings": {"mainshaft-167": exact_keys("mainshaft-167")},
        }
    )
    oils = [
        oil(name, with_first_constant(0.0, 10), with_first_constant(0.0, 0), drag=0.8)
        for name in names
    ]
    table = cage_slip_table(oils, config)
    points = ["pitch_speed_mm_rpm", "axial_load_n"]
    np.testing.assert_allclose(table.groupby(points)["best_share"].sum(), 1.0)
    assert table["best_share"].between(0.3, 0.7).any()
    # the same by hand: each drag for all oils, evenly over its logarithm
    points = table.loc[table["oil"] == "4010", [*LOAD_SPEED_TEMPERATURE]]
    shares = OIL_VOLUME_FRACTION * np.exp(np.linspace(-0.8, 0.8, 21))
    runs = pd.concat([with_shares(oil_in_bearing, shares, points) for oil_in_bearing in oils])
    columns = runs[["cage_slip", "torque_n_m", "lambda_ratio"]].to_numpy()
    slip, torque, lambda_ratio = np.moveaxis(columns.reshape(2, 21, 4, 3), -1, 0)
    has_full_film = lambda_ratio > config.gates.lambda_limit
    holds_cage = has_full_film & (slip <= config.bearing.cage_slip.slip_limit)
    by_torque = np.where(holds_cage, torque, np.inf).argmin(axis=0)
    by_slip = np.where(has_full_film, slip, np.inf).argmin(axis=0)
    best_oil_index = np.where(
        has_full_film.any(axis=0), np.where(holds_cage.any(axis=0), by_torque, by_slip), -1
    )
    share = np.stack([(best_oil_index == oil_index).mean(axis=0) for oil_index in range(2)])
    np.testing.assert_allclose(table["best_share"], share.ravel(), atol=0.06)


@pytest.mark.slow
def test_shares_of_variance_are_those_of_an_independent_variation():
    # two causes with known slopes: all traction by 5 % in a run, and the flow from 4 to 16 L/min
    flow = SHIPPED.uncertain_inputs["feed_flow_m3_s"]
    bearing = replace(
        BEARING, uncertain_inputs={**BEARING.uncertain_inputs, "feed_flow_m3_s": flow}
    )
    oil_with_run_error = oil(
        "4050", with_first_constant(0.0, 10), with_first_constant(0.0, 0), run_sd=0.05
    )
    cases = FrictionCases(
        bearing, [CaseGroup(oil_with_run_error, "stress", pd.DataFrame([LOAD_SPEED_TEMPERATURE]))]
    )
    shares = (
        cases.calculate_with_uncertainty(1)[2]
        .calculate_shares(np.arange(1))
        .set_index("variance_cause")["torque_share"]
    )

    def torques_with(factors: Sequence[float], flow_m3_s: float) -> FloatArray:
        changed_bearing = replace(
            bearing,
            uncertain_inputs={
                **bearing.uncertain_inputs,
                "feed_flow_m3_s": UncertainInput(*[flow_m3_s] * 3),
            },
        )
        frame = pd.DataFrame(
            [{**LOAD_SPEED_TEMPERATURE, "traction_factor": factor} for factor in factors]
        )
        groups = [CaseGroup(oil_with_run_error, "stress", frame)]
        return FrictionCases(changed_bearing, groups).calculate()["torque_n_m"]

    levels = (np.arange(20) + 0.5) / 20
    by_flow = np.var([torques_with([1.0], flow_m3_s) for flow_m3_s in flow.quantiles(levels)])
    by_run = np.var(torques_with(np.exp(0.05 * ndtri(levels)), flow.value))
    expected = by_flow / (by_flow + by_run)
    assert shares["feed_flow_m3_s"] == pytest.approx(expected, abs=0.1)
    assert shares["runs"] == pytest.approx(1 - expected, abs=0.1)
    assert shares.drop(["feed_flow_m3_s", "runs"]).max() < 1e-6


FLOW_INPUTS = ("feed_flow_m3_s", "momentum_share")


@pytest.mark.slow
@pytest.mark.parametrize("is_flow_known", [True, False])
@pytest.mark.parametrize(("run_sd", "text"), [(np.nan, "not known"), (0.05, "5 % of it")])
def test_a_scatter_of_runs_or_a_flow_that_nobody_knows_has_no_share(run_sd, text, is_flow_known):
    no_refits = with_first_constant(0.0, 10)
    uncertain_oil = oil("4050", no_refits, with_first_constant(0.0, 0), drag=0.1, run_sd=run_sd)
    points = operating_point_table(BEARING, 1e4, 12e3, 100.0)
    config = resolve(LABORATORY, {})
    unknown_inputs = dict.fromkeys(FLOW_INPUTS, UncertainInput(np.nan, np.nan, np.nan))
    unknown_inputs = {} if is_flow_known else unknown_inputs
    bearing = replace(BEARING, uncertain_inputs={**BEARING.uncertain_inputs, **unknown_inputs})
    answered = calculate_answers(
        [uncertain_oil], bearing, points, config, lambda rows: np.ones(1, bool)
    )
    shares = answered.shares.set_index("variance_cause", drop=False)
    is_known = bool(np.isfinite(run_sd))
    assert range_text(shares.loc["runs"]).startswith(text)
    assert shares.loc["runs", ["torque_share", "slip_share"]].notna().all() == is_known
    assert range_text(shares.loc["rig"]) == "as stated in the rig's file"
    assert (shares.loc[list(FLOW_INPUTS), "torque_share"].notna() == is_flow_known).all()
    assert shares.drop(["runs", *FLOW_INPUTS])["torque_share"].notna().all()


def test_shares_of_variance_need_no_known_film():
    # at -30 degC lambda is not known in any draw; a warning of NumPy would end this test
    uncertain_oil = oil("4050", with_first_constant(0.0, 10), with_first_constant(0.0, 0), drag=0.5)
    point = {**LOAD_SPEED_TEMPERATURE, "inlet_temperature_c": -30.0}
    group = CaseGroup(uncertain_oil, "stress", pd.DataFrame([point]))
    results, _, draws = FrictionCases(BEARING, [group]).calculate_with_uncertainty(1)
    assert results["lambda_ratio"].isna().all()
    shares = draws.calculate_shares(np.arange(1))[["torque_share", "slip_share"]]
    assert shares.notna().all(axis=None)


@pytest.mark.parametrize(("lost_draws", "is_known"), [(5, True), (6, False)])
def test_shares_of_variance_are_not_known_where_the_interval_is_withheld(
    monkeypatch, lost_draws, is_known
):
    solved = RandomDraws._solve_draws

    def without_some(self, numbers_of_group, position_in_drawn):
        # of 100 draws; 5 % may be lost
        results = solved(self, numbers_of_group, position_in_drawn)
        results[:, :lost_draws] = np.nan
        return results

    monkeypatch.setattr(RandomDraws, "_solve_draws", without_some)
    uncertain_oil = oil("4050", with_first_constant(0.0, 10), with_first_constant(0.0, 0), drag=0.5)
    assert uncertain_oil.bearing_settings.uncertainty.draws == 100
    group = CaseGroup(uncertain_oil, "stress", pd.DataFrame([LOAD_SPEED_TEMPERATURE]))
    results, _, draws = FrictionCases(BEARING, [group]).calculate_with_uncertainty(1)
    shares = draws.calculate_shares(np.arange(1))[["torque_share", "slip_share"]]
    assert results["torque_n_m_lower"].notna().all() == is_known
    assert shares.notna().all(axis=None) == is_known
    assert shares.isna().all(axis=None) != is_known


def test_the_laws_error_is_that_at_the_slips_of_spin(monkeypatch):
    # 4102 at 7500 rpm and 12 kN: the cage rolls, and the ball spins on the inner race
    point = {"axial_load_n": 12e3, "inner_speed_rpm": 7500.0, "inlet_temperature_c": 100.0}
    uncertain_oil = oil("4102", with_first_constant(0.0, 10), with_first_constant(0.0, 0))
    cases = FrictionCases(BEARING, [CaseGroup(uncertain_oil, "stress", pd.DataFrame([point]))])
    balance = friction_equilibrium(cases.problem).balance
    speed_m_s = balance.conditions.entrainment_speed_m_s[0, :, 0]
    # pure spin slides by omega |y|, and the mean |y| under Hertz's pressure, with the weights
    # 1 - y^2 of strips, is 3/8 of the semi-axis
    spin_speed_m_s = np.abs(balance.sliding.relative_spin_rad_s) * balance.contacts.semi_axis_y_m
    slip_by_spin = (3 / 8 * spin_speed_m_s / speed_m_s)[0]
    assert balance.sliding.middle_slide_roll_ratio[0, 0] < 0.25 * slip_by_spin[0]

    def planted_error(_law, conditions, slip, _error_without_interval):
        # grows with the speed and with the slip
        return conditions[:, 1] * np.abs(slip)

    monkeypatch.setattr(FittedLaw, "form_error", planted_error)
    error = law_error(uncertain_oil.laws["stress"], cases.calculate(), 0.15)
    assert error[0] == pytest.approx((speed_m_s * slip_by_spin).max(), rel=0.06)


@pytest.mark.slow
def test_an_interval_of_a_hundred_draws_holds_the_next_draw_with_95_percent():
    random = np.random.default_rng(8)
    draws = random.standard_normal((101, 5_000)) + 9
    first_hundred_draws = np.broadcast_to(draws[:100], (3, 100, 5_000))
    calculated = pd.DataFrame({"torque_n_m": np.full(5_000, 9.0)})
    was_drawn = np.ones(5_000, dtype=bool)
    interval = add_uncertainty(
        calculated, first_hundred_draws, was_drawn, np.ones(5_000), SETTINGS.uncertainty
    )
    inside = interval["torque_n_m_lower"].to_numpy() <= draws[100]
    inside &= draws[100] <= interval["torque_n_m_upper"].to_numpy()
    # the share of 5000 is known to 0.3 %; the usual ranks hold 93 %
    assert inside.mean() == pytest.approx(0.95, abs=0.01)


def test_where_all_draws_may_be_lost_one_draw_gives_no_interval() -> None:
    draws = np.ones((3, 40, 3))
    # no draw, one draw and two draws have an equilibrium
    draws[:, :, 0] = draws[:, 1:, 1] = draws[:, 2:, 2] = np.nan
    settings = SETTINGS.uncertainty.model_copy(update={"lost_share_max": 1.0})
    calculated = pd.DataFrame({"torque_n_m": np.ones(3)})
    interval = add_uncertainty(calculated, draws, np.ones(3, bool), np.ones(3), settings)
    assert interval["torque_n_m_lower"].notna().tolist() == [False, False, True]
    assert interval["draws_split"].notna().tolist() == [False, False, True]


OILS = pytest.mark.parametrize("oil_name", ["4102", nightly("4050")])


@pytest.mark.slow
@OILS
def test_the_interval_holds_independent_variations_of_every_known_effect(oil_name):
    held = held_by_interval(oil_name, seed=1)
    # 95 %, less two standard errors of a share of 80 points; an exact interval holds 76 of them or
    # more in 63 % of such tests only
    assert min(held) >= 0.95 - 2 * np.sqrt(0.95 * 0.05 / 80)


@pytest.mark.nightly
@OILS
def test_over_several_sets_of_draws_the_interval_holds_95_percent(oil_name):
    held = np.array([held_by_interval(oil_name, seed, answer_count=20) for seed in range(1, 7)])
    # a hundred draws know their 95 % to 2 %; six sets to 1 %
    assert np.abs(held.mean(axis=0) - 0.95).max() <= 0.02


def held_by_interval(oil_name: str, seed: int, answer_count: int = 1) -> tuple[float, float]:
    """Share of answers in the intervals of torque and of cage slip.

    The answers are those at 80 points at dmN of 3e6 to 4e6. Each has effects that this test draws
    from their ranges.

    Args:
        oil_name: The oil.
        seed: Of the product's draws; the test's own numbers follow it.
        answer_count: Answers at each point.
    """
    random = np.random.default_rng(46 + seed)
    points = pd.DataFrame(
        {
            "axial_load_n": random.uniform(8e3, 3e4, 80),
            "inner_speed_rpm": random.uniform(3e6, 4e6, 80) / 167.5375,
            "inlet_temperature_c": 100.0,
        }
    )
    no_refits = with_first_constant(0.0, 10)
    shipped_oil = replace(
        oil(oil_name, no_refits, with_first_constant(0.0, 0)), bearing_settings=SETTINGS
    )
    interval = FrictionCases(
        SHIPPED, [CaseGroup(shipped_oil, "stress", points)]
    ).calculate_with_uncertainty(seed)[0]
    repeated_points = pd.concat([points] * answer_count, ignore_index=True)
    case_count = len(repeated_points)
    cases = FrictionCases(
        SHIPPED, [CaseGroup(shipped_oil, "stress", repeated_points)], own_draw(random, case_count)
    )
    lubrication = cases.problem.lubrication
    factors = lubrication.factors.copy()
    for factor_index, log_spread in enumerate((SETTINGS.law_error_beyond, 0.1, 0.2, 0.0, 0.5, 0.3)):
        factors[:, factor_index] = np.exp(
            log_spread * random.standard_normal(case_count) - log_spread**2 / 2
        )
    viscosity = np.exp(SETTINGS.stand_in_uncertainty.viscosity * random.standard_normal(case_count))
    thicker = replace(
        lubrication.inlet_oil,
        dynamic_viscosity_pa_s=lubrication.inlet_oil.dynamic_viscosity_pa_s * viscosity,
    )
    drawn_problem = replace(
        cases.problem, lubrication=replace(lubrication, factors=factors, inlet_oil=thicker)
    )
    equilibrium = friction_equilibrium(drawn_problem)
    share_held = []
    for name, values in (
        ("torque_n_m", equilibrium.torque_n_m()),
        ("cage_slip", equilibrium.cage_slip()),
    ):
        results_of_points = values.reshape(answer_count, 80)
        lower = interval[f"{name}_lower"].to_numpy()
        upper = interval[f"{name}_upper"].to_numpy()
        share_held.append(
            float(((lower <= results_of_points) & (results_of_points <= upper)).mean())
        )
    return share_held[0], share_held[1]


def own_draw(random: np.random.Generator, point_count: int) -> InputValues:
    """Inputs from the ranges of bearing and settings, by this test's own numbers.

    Half of the values are below the stated value, half above.
    """
    drawn = {}
    for name, (value, low, high) in {
        **SHIPPED.uncertain_inputs,
        **SETTINGS.uncertain_inputs(),
    }.items():
        below = random.uniform(low, value, point_count)
        above = random.uniform(value, high, point_count)
        drawn[name] = np.where(random.random(point_count) < 0.5, below, above)
        if value in (low, high):
            drawn[name] = random.uniform(low, high, point_count)
    return InputValues(**drawn)
