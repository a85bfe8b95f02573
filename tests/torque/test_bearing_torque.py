"""The fitted law in bearings: load variables compared, traction found again, tables and figures."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from bearings import (
    RIG_CONTACT,
    RPM,
    SETTINGS,
    exact_keys,
    in_operation,
    printed_law,
    problem,
    shipped,
)
from campaigns import LABORATORY, oil_of, printed
from oilfilm.base.units import FloatArray
from oilfilm.bearing.equilibria import friction_equilibrium
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.bearing.torque import torque_terms
from oilfilm.fits.fitted import Coefficients, FittedLaw
from oilfilm.physics.contact import Conditions
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.bearing_torque import (
    _TRACTION_FACTORS,
    OilInBearing,
    _nearest_pair_index,
    cage_slip_table,
    oils_in_bearings,
    size_effect_table,
    torque_table,
)
from oilfilm.torque.load_variables import LOAD_VARIABLES, LawInBearing
from oilfilm.traction import LAWS, laws_for
from pictures import draw, nothing_is_cut_off
from planted_fits import TESTED, printed_fits
from reports import rows

FIGURES = ["torque", "cage-slip", "size-effect"]
SPEED_RPM = np.array([6000.0, 9000.0, 12000.0])


@pytest.fixture(scope="module")
def config() -> Settings:
    small = {
        "cage_slip": {"pitch_speed_mm_rpm": [1e6, 2e6], "axial_load_n": [2000, 20000]},
        "size_effect": {"ball_size_factors": [0.25, 1.0, 1.5], "groove_curvatures": [0.51, 0.54]},
    }
    return resolve(LABORATORY, {}).with_changes({"bearing": small})


@pytest.fixture(scope="module")
def oils(config: Settings) -> list[OilInBearing]:
    return oils_in_bearings(*printed_fits(), config)


def plateaus(
    torque_n_m: Sequence[float], speed_rpm: Sequence[float], se: float = 0.01
) -> pd.DataFrame:
    """Accepted plateaus of oil 4050 at 20 kN and 100 degC."""
    columns = {"run_id": "a.csv", "oil": "4050", "axial_load_n": 20e3, "oil_temperature_c": 100.0}
    columns |= {"torque_n_m_se": se, "accepted": True, "failed_gates": ()}
    pairs = zip(torque_n_m, speed_rpm, strict=True)
    return rows(
        "torque_runs",
        *(
            {**columns, "first_row": number, "torque_n_m": torque, "inner_speed_rpm": speed}
            for number, (torque, speed) in enumerate(pairs)
        ),
    )


def test_each_operating_point_may_have_constants_of_its_own(oils):
    (oil,) = (oil for oil in oils if oil.name == "4050")
    constants = np.array([printed()["4050"], printed()["4010"], printed()["4050"]])
    point = (shipped("mainshaft-167"), 10000.0, SPEED_RPM, 100.0)
    for load_variable in LOAD_VARIABLES:
        torques_together = oil.with_constants(constants).calculate(*point, load_variable)[
            "torque_n_m"
        ]
        torques_alone = [
            oil.with_constants(row).calculate(*point[:2], speed, 100.0, load_variable)[
                "torque_n_m"
            ][0]
            for row, speed in zip(constants, SPEED_RPM, strict=True)
        ]
        np.testing.assert_allclose(torques_together, torques_alone, rtol=1e-8)
        torques_alone = oil.calculate(*point, load_variable)["torque_n_m"]
        assert list(np.isclose(torques_together, torques_alone, rtol=1e-8)) == [True, False, True]


def test_inversion_finds_the_traction_that_was_planted(config, oils):
    law, points = printed_law("4050"), OperatingPoints.from_load_and_speed(20000.0, SPEED_RPM * RPM)

    def stronger(conditions: FloatArray, slide_roll_ratio: FloatArray) -> FloatArray:
        return 1.33 * law(conditions, slide_roll_ratio)

    planted = in_operation(problem(shipped("mainshaft-167"), points, law=stronger))
    truth = torque_terms(friction_equilibrium(planted), TESTED)
    torque, inversion = torque_table(plateaus(truth["torque_n_m"], SPEED_RPM), oils, config)
    np.testing.assert_allclose(
        inversion["traction_coefficient"], truth["mean_traction_coefficient"], rtol=0.02
    )
    assert (inversion["law_traction_coefficient"] < inversion["traction_coefficient"]).all()
    # the uncertainty of the other terms is large: traction decides only a part of the torque
    assert (inversion["traction_share"] < 0.4).all()
    assert (
        inversion["traction_coefficient_systematic"] > inversion["traction_coefficient_se"]
    ).all()
    assert set(torque["load_variable"]) == {"stress", "load", "dimensionless_load"}


def test_of_two_factors_as_far_from_the_law_the_weaker_traction_is_taken():
    pairs = len(_TRACTION_FACTORS) - 1
    for lower in range(pairs // 2):
        mirrored = np.isin(np.arange(pairs), [lower, pairs - 1 - lower])
        assert _nearest_pair_index(mirrored[:, np.newaxis]).tolist() == [lower]


def test_uncertainty_of_the_inversion_is_the_change_by_a_torque_wrong_by_it(config, oils):
    se = 0.02
    calibration = {"torque_n_m": 0.03, "torque_relative": 0.0}
    exact = dict.fromkeys(("rolling", "hysteresis", "pocket", "land"), 0.0)
    # the calibration's offset alone, so that its uncertainty is known: 3/2 of the random one
    only_offset_uncertain = config.with_changes(
        {
            "campaign": {"torque": {"calibration": calibration}},
            "bearing": {"term_uncertainty": exact, "oil_volume_fraction_range": [0.0036, 0.003601]},
            "bearings": {"mainshaft-167": exact_keys("mainshaft-167")},
        }
    )
    # a torque that 1.3 times the law's traction gives; its slope is steady there
    inversion, inversion_of_wrong_torque = (
        torque_table(plateaus([torque], [9000.0], se), oils, only_offset_uncertain)[1].iloc[0]
        for torque in (5.5, 5.5 + se)
    )
    change = inversion_of_wrong_torque["traction_coefficient"] - inversion["traction_coefficient"]
    assert inversion["verdict"] == "determined"
    assert inversion["traction_coefficient_se"] == pytest.approx(change, rel=0.05)
    assert inversion["traction_coefficient_systematic"] == pytest.approx(1.5 * change, rel=0.05)


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_a_share_of_the_feed_oil_that_may_be_none_or_all_makes_the_traction_uncertain(
    config, oils, share
):
    offset_n_m, se_n_m = 0.03, 0.02
    calibration = {"torque_n_m": offset_n_m, "torque_relative": 0.0}
    exact = dict.fromkeys(("rolling", "hysteresis", "pocket", "land"), 0.0)
    exact_bearing = exact_keys("mainshaft-167")
    any_share = {"momentum_share": share, "momentum_share_range": [0.0, 1.0]}
    exact_bearing["oil_supply"] = {**exact_bearing["oil_supply"], **any_share}
    only_share_uncertain = config.with_changes(
        {
            "campaign": {"torque": {"calibration": calibration}},
            "bearing": {"term_uncertainty": exact, "oil_volume_fraction_range": [0.0036, 0.003601]},
            "bearings": {"mainshaft-167": exact_bearing},
        }
    )
    _, inversion = torque_table(plateaus([5.5], [9000.0], se_n_m), oils, only_share_uncertain)
    row = inversion.iloc[0]
    # both uncertainties of mu are those of the torque times one slope
    uncertainty_n_m = (
        se_n_m * row["traction_coefficient_systematic"] / row["traction_coefficient_se"]
    )
    # m' omega r^2 of 918 kg/m3, 8 L/min, 72.608 mm, and 1/sqrt(12) for any share from 0 to 1
    momentum_n_m = 918 * 8e-3 / 60 * 9000 * np.pi / 30 * 72.608e-3**2
    expected = np.hypot(offset_n_m, momentum_n_m / np.sqrt(12))
    assert uncertainty_n_m == pytest.approx(expected, rel=2e-3)


def test_without_the_flow_of_feed_oil_a_measured_torque_says_nothing_of_traction(config, oils):
    # the bearing takes 0.6 N m more at 9000 rpm than it does without its 8 L/min of feed oil
    points = OperatingPoints.from_load_and_speed(20000.0, SPEED_RPM * RPM)
    fed = in_operation(problem(shipped("mainshaft-167"), points, law=printed_law("4050")))
    truth = torque_terms(friction_equilibrium(fed), TESTED)
    file = config.bearings["mainshaft-167"].model_copy(update={"oil_supply": None})
    unknown = config.model_copy(update={"bearings": config.bearings | {"mainshaft-167": file}})
    torque, inversion = torque_table(plateaus(truth["torque_n_m"], SPEED_RPM), oils, unknown)
    of_stress = torque[torque["load_variable"] == "stress"]
    np.testing.assert_allclose(
        of_stress["measured_torque_n_m"] - of_stress["torque_n_m"], truth["momentum_torque_n_m"]
    )
    assert (torque["verdict"] == "not known").all()
    assert torque["compatibility"].isna().all()
    assert (inversion["verdict"] == "not known").all()
    mu_columns = [name for name in inversion if name.startswith("traction_coefficient")]
    assert inversion[mu_columns].isna().all(axis=None)


@pytest.mark.slow
def test_a_bearing_loaded_beyond_reason_has_no_torque_and_a_reason(config, oils):
    # 20 kN logged as 20 MN; the third torque is more than any traction gives
    runs = plateaus([5.0, 5.0, 500.0], [6000.0, 9000.0, 6000.0])
    runs["axial_load_n"] *= [1000.0, 1.0, 1.0]
    (oil,) = (oil for oil in oils if oil.name == "4050")
    # the search at a crushed contact is long, and the same with the laws of other load variables
    by_stress = replace(oil, laws={"stress": oil.laws["stress"]})
    torque, inversion = torque_table(runs, [by_stress], config)
    crushed, sound, _ = (torque[torque["first_row"] == row] for row in (0, 1, 2))
    assert not crushed["converged"].any()
    assert crushed["torque_n_m"].isna().all()
    assert (crushed["no_equilibrium"] == "contacts too wide").all()
    assert (crushed["equilibria"] == 0).all()
    assert (crushed["widest_contact"] >= 1).all()
    assert sound["converged"].all()
    assert (sound["no_equilibrium"] == "").all()
    assert (sound["widest_contact"] < 1).all()
    assert inversion["verdict"].iloc[0] == "not known"
    assert list(inversion["verdict"] == "no solution") == [False, False, True]
    assert list(inversion["traction_coefficient"].isna()) == [True, False, True]


def test_an_oil_without_a_fit_is_left_out(config):
    coefficients, quality = printed_fits()
    oils = oils_in_bearings(coefficients.assign(value=np.nan), quality, config)
    torque, inversion = torque_table(plateaus([5.0], [6000.0]), oils, config)
    assert torque.empty
    assert inversion.empty
    assert cage_slip_table(oils, config).empty


def test_an_oil_tested_at_one_temperature_says_nothing_about_a_bearing(config):
    coefficients, quality = printed_fits()
    lost = coefficients["constant"].str.endswith("3") & (coefficients["oil"] == "4050")
    oils = oils_in_bearings(coefficients[~lost], quality, config)
    assert [oil.name for oil in oils] == ["4102", "4010"]


def test_load_based_laws_go_wrong_with_the_ball_size_and_dimensionless_ones_do_not(config, oils):
    table = size_effect_table(oils, config)
    of_size = table[(table["varied"] == "ball size") & (table["oil"] == "4050")]
    error = of_size.pivot(
        index="ball_diameter_mm", columns="load_variable", values="relative_to_stress"
    )
    assert error["load"].is_monotonic_increasing
    assert error["load"].iloc[-1] - error["load"].iloc[0] > 0.5
    assert np.ptp(error["dimensionless_load"]) < 0.2


@pytest.mark.slow
def test_cage_slip_grows_with_speed_and_falls_with_load(config, oils):
    table = cage_slip_table(oils, config)
    assert table["converged"].all()
    assert not table["bistable"].any()
    assert table[["other_cage_slip", "other_torque_n_m"]].isna().all(axis=None)
    for _, of_oil in table.groupby("oil"):
        grid = of_oil.pivot(
            index="axial_load_n", columns="pitch_speed_mm_rpm", values="cage_slip"
        ).to_numpy()
        assert (np.diff(grid, axis=1) > 0).all()
        assert (np.diff(grid, axis=0) < 0).all()


@pytest.fixture(scope="module")
def results(config: Settings, oils: list[OilInBearing]) -> CampaignTables:
    slip = cage_slip_table(oils, config)
    return CampaignTables.from_frames(
        torque=torque_table(plateaus([5.0, 6.5], [6000.0, 9000.0]), oils, config)[0],
        cage_slip=slip,
        size_effect=size_effect_table(oils, config),
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", FIGURES)
def test_figures_show_their_data_or_say_that_there_are_none(config, results, name):
    figure, drawn = draw(name, results, config)
    assert len(drawn)
    assert nothing_is_cut_off(figure)
    figure, drawn = draw(name, CampaignTables.from_frames(), config)
    assert drawn.empty
    assert any(text.get_text() for axis in figure.axes for text in axis.texts)


@pytest.mark.slow
def test_errors_of_the_torque_are_drawn_with_their_intervals(config, results):
    torque = results.torque
    compared = torque[torque["load_variable"].isin(["stress", "wang-deng-load"])]
    _, drawn = draw("torque", results, config)
    errors = drawn[drawn["series"] == "error"]
    np.testing.assert_allclose(np.sort(errors["y"]), np.sort(100 * compared["relative_error"]))
    measured = compared["measured_torque_n_m"]
    upper = 100 * (compared["torque_n_m_upper"] / measured - 1)
    np.testing.assert_allclose(np.sort(errors["y_upper"]), np.sort(upper))


def test_catalogue_torque_is_no_opinion_beyond_the_speeds_of_the_catalogue(config, oils):
    # 167.5 mm: 0.5 and 2 million mm rpm, and just at the limit, where the product is rounded up
    pitch_mm = 1e3 * shipped("mainshaft-167").pitch_diameter_m
    limit_rpm = SETTINGS.skf_pitch_speed_max / pitch_mm
    torque, _ = torque_table(plateaus([2.0, 9.0, 5.0], [3000.0, 12000.0, limit_rpm]), oils, config)
    of_stress = torque[torque["load_variable"] == "stress"]
    assert list(of_stress["skf_valid"]) == [True, False, True]
    # Palmgren 1959 with the oil's own viscosity at 100 degC
    viscosity_cst = oil_of("4050").kinematic_viscosity_m2_s(100.0) * 1e6
    of_speed = (
        1e-7 * SETTINGS.palmgren.f0 * (viscosity_cst * 3000.0) ** (2 / 3) * 167.5375**3 * 1e-3
    )
    of_load = SETTINGS.palmgren.f1 * 0.9 * 20e3 / np.tan(np.radians(27)) * 0.1675375
    assert of_stress["palmgren_torque_n_m"].iloc[0] == pytest.approx(of_speed + of_load, rel=1e-3)


# A, B, C, D of a law on load or on groups, each by its three conditions
WANG_DENG = np.array(
    [-0.02, 0.15, -0.3, -0.1, 0.5, 0.4, -0.3, -0.9, 25, 0.2, 0.1, 0.3, 0.0205, 0.15, -0.3, -0.1]
)


def test_a_law_on_load_is_compared_as_well(config):
    law, (coefficients, quality) = LAWS["wang-deng-load"], printed_fits()
    own_laws = quality[quality["oil"] == "4050"].assign(law=law.name, configured=False)
    names = [constant.name for constant in law.constants]
    rows = pd.concat([coefficients.iloc[:1]] * len(names)).assign(oil="4050", law=law.name)
    rows = rows.assign(constant=names, value=WANG_DENG)
    oils = oils_in_bearings(pd.concat([coefficients, rows]), pd.concat([quality, own_laws]), config)
    torque, _ = torque_table(plateaus([5.0], [9000.0]), oils, config)
    assert set(torque["load_variable"]) == {*LOAD_VARIABLES, law.name}
    assert torque.set_index("load_variable").at[law.name, "converged"]


@pytest.mark.parametrize("name", ["wang-deng-load", "wang-deng-groups"])
def test_a_law_on_load_takes_the_load_and_the_groups_of_the_bearings_contact(name):
    # the law's own equation, written out: X = X0 (W/100 N)^X1 (U/20)^X2 (T/20)^X3, or with
    # W/(E' R^2), eta0 U/(E' R), eta0 beta U^2/k of the contact's own Rx and E'
    oil = oil_of("4050")
    law = laws_for(oil, RIG_CONTACT)[name]
    fitted = FittedLaw(law, Coefficients.from_constants(law, WANG_DENG))
    radius, modulus = np.array([0.004, 0.012]), 2.5e11
    load, speed = np.array([200.0, 900.0]), np.array([30.0, 60.0])

    def each(values: np.ndarray | float) -> np.ndarray:
        return np.broadcast_to(values, (1, 2))[..., np.newaxis].astype(float)

    at = Conditions(each(load), each(1.0), each(speed), each(100.0), each(radius), modulus)
    in_bearing = LawInBearing.from_fit(
        fitted, law.name, RIG_CONTACT, SETTINGS.law_floor.model_dump()
    )
    mu = in_bearing(at, np.full((1, 2, 1), 0.02))
    eta, beta = oil.dynamic_viscosity_pa_s(100.0), oil.temperature_viscosity_coefficient_1_k(100.0)
    groups = (load / 100, speed / 20, 100 / 20)
    if name == "wang-deng-groups":
        groups = (
            load / (modulus * radius**2) / 1e-6,
            eta * speed / (modulus * radius) / 1e-10,
            eta * beta * speed**2 / oil.thermal_conductivity_w_mk(100.0),
        )
    a, b, c, d = (
        x0 * groups[0] ** x1 * groups[1] ** x2 * groups[2] ** x3
        for x0, x1, x2, x3 in WANG_DENG.reshape(4, 4)
    )
    np.testing.assert_allclose(mu[0, :, 0], (a + b * 0.02) * np.exp(-c * 0.02) + d)


def test_shares_beyond_an_unknown_box_are_unknown(config):
    coefficients, quality = printed_fits()
    ends = ("tested_min_max_hertz_pressure_gpa", "tested_max_max_hertz_pressure_gpa")
    unknown = quality.assign(**dict.fromkeys(ends, np.nan))
    oils = oils_in_bearings(coefficients, unknown, config)
    table, _ = torque_table(plateaus([5.0], [9000.0]), oils, config)
    assert table["share_beyond_pressure"].isna().all()
    assert table["share_beyond_speed"].between(0, 1).all()


def test_untested_temperatures_and_levels_below_those_of_the_law_are_told(oils):
    (oil,) = (oil for oil in oils if oil.name == "4050")
    # tested from 25 to 120 degC; no law is evaluated below 5 degC
    temperatures_c = [-5.0, 10.0, 24.99, 70.0, 120.1, 150.0]
    told = oil.calculate(shipped("mainshaft-167"), 10e3, 3000.0, temperatures_c)
    assert told["converged"].all()
    assert told["share_beyond_temperature"].tolist() == [1, 1, 0, 0, 0, 1]
    assert told["below_law_floor"].tolist() == [True, False, False, False, False, False]
    # at the smallest level, frost makes the traction no stronger
    law = oil.laws["stress"]
    each = np.full((1, 2, 1), 1.0)
    mu_in_frost, mu_at_smallest_level = (
        law(Conditions(1e3 * each, each, 30 * each, level * each, 0.01 * each, 2.3e11), 0.02 * each)
        for level in (-5.0, 5.0)
    )
    np.testing.assert_array_equal(mu_in_frost, mu_at_smallest_level)


def test_contacts_above_the_limits_of_oil_and_steel_are_told(oils):
    (oil,) = (oil for oil in oils if oil.name == "4050")
    weaker = replace(oil, properties=replace(oil.properties, limiting_stress_ratio=1e-4))
    point = (shipped("mainshaft-167"), [1000.0, 60e3, 120e3], 9000.0, 100.0)
    flagged = oil.calculate(*point)
    pressure = flagged["inner_max_hertz_pressure_gpa"]
    assert (pressure < 2).tolist() == [True, False, False]  # GPa, Deng et al. (2026), section 4.3
    assert (pressure > 2.5).tolist() == [False, False, True]
    assert flagged["pressure_verdict"].tolist() == ["within", "above long-term", "above peak"]
    assert (flagged["contacts_over_stress_limit"] == 0).all()
    # a film that can carry a ten-thousandth of the pressure: two contacts of each of 20 balls
    assert (weaker.calculate(*point)["contacts_over_stress_limit"] == 40).all()
