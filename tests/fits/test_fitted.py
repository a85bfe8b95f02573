"""Predictions: the interval is the spread of refits, the box is tested, mu is known on lines."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import oilfilm
from campaigns import Campaign, printed
from fit_points import LAW, make_points, matrix
from measured_surfaces import with_measured_surface
from oilfilm.base.errors import OilfilmError
from oilfilm.cli.predict import prediction
from oilfilm.fits.conditions import (
    FixedCondition,
    StepPartner,
    fixed_conditions,
    fixed_conditions_from_json,
    fixed_conditions_to_json,
    followed_condition_mask,
)
from oilfilm.fits.fit import fit_oil
from oilfilm.fits.fitted import Coefficients, FittedLaw, given_surface, predict
from oilfilm.fits.interval import Band
from oilfilm.fits.measured_surface import MeasuredContact
from oilfilm.settings.resolved import Settings
from oilfilm.surface.interval import normal_half_width
from oilfilm.surface.surface import Surface
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS
from oilfilm.traction.law import CONDITIONS, QUANTITIES
from oilfilm.traction.laws.deng2026 import traction_coefficient


@pytest.fixture(scope="module")
def fit(demo: Campaign) -> CampaignTables:
    return demo.fit("4102", searches=2, bootstrap=400)


@pytest.fixture(scope="module")
def law(fit: CampaignTables) -> FittedLaw:
    return fitted(fit)


def without_calibration(law: FittedLaw) -> Coefficients:
    return replace(law.coefficients, shifted_refits=law.coefficients.shifted_refits[:0])


@pytest.mark.parametrize(
    "at", [(1.25, 30.0, 70.0, 0.05), (1.0, 40.0, 120.0, 0.01), (2.5, 200.0, 140.0, 0.2)]
)
def test_interval_is_that_of_refits(law: FittedLaw, at: tuple[float, float, float, float]) -> None:
    result = predict("deng2026", without_calibration(law), *at)
    resampled = [float(traction_coefficient(row, *at)) for row in law.coefficients.refits]
    lower, upper = np.quantile(resampled, [0.025, 0.975])
    width = upper - lower
    # 400 draws know a quantile to about 6 % of the width
    assert float(result.mean_ci_lower) == pytest.approx(lower, abs=0.15 * width)
    assert float(result.mean_ci_upper) == pytest.approx(upper, abs=0.15 * width)


def test_calibration_widens_the_interval(law: FittedLaw) -> None:
    at = (1.25, 30.0, 70.0, 0.1)
    assert len(law.coefficients.shifted_refits) == 4
    with_it = predict("deng2026", law.coefficients, *at)
    without = predict("deng2026", without_calibration(law), *at)
    wide, narrow = (at.mean_ci_upper - at.mean_ci_lower for at in (with_it, without))
    assert wide > narrow
    # by hand: half-widths of ln mu add as squares
    steps = [float(traction_coefficient(row, *at)) for row in law.coefficients.shifted_refits]
    mu = float(with_it.traction_coefficient)
    expected = np.sqrt(
        np.log(float(without.mean_ci_upper) / mu) ** 2
        + 1.96**2 * np.sum(np.log(np.array(steps) / mu) ** 2)
    )
    assert np.log(float(with_it.mean_ci_upper) / mu) == pytest.approx(expected, rel=0.02)


@given(slip=st.floats(1e-4, 0.3), pressure=st.floats(0.8, 2.5), temperature=st.floats(20.0, 140.0))
def test_traction_is_odd_in_slip_and_its_interval_too(
    law: FittedLaw, slip: float, pressure: float, temperature: float
) -> None:
    one = predict("deng2026", law.coefficients, pressure, 30.0, temperature, slip)
    other = predict("deng2026", law.coefficients, pressure, 30.0, temperature, -slip)
    assert other.traction_coefficient == -one.traction_coefficient
    assert (other.mean_ci_lower, other.mean_ci_upper) == (-one.mean_ci_upper, -one.mean_ci_lower)
    assert one.mean_ci_lower <= one.traction_coefficient <= one.mean_ci_upper


def test_distance_from_the_tested_box_is_in_tested_ranges(law: FittedLaw) -> None:
    low, high = law.coefficients.tested_box.T
    # the matrix's own ends, give or take control errors of 1 % and 0.5 K, a few of them
    assert low == pytest.approx([1.0, 25, 25, 0], rel=0.01, abs=1.5)
    assert high == pytest.approx([1.5, 40, 120, 0.3], rel=0.01, abs=1.5)
    inside = predict("deng2026", law.coefficients, 1.25, 30.0, 70.0, [0.05, -0.05])
    assert not inside.outside.any()
    assert (inside.distance == 0).all()
    far = predict("deng2026", law.coefficients, 2.5, 200.0, 70.0, 0.05)
    assert far.outside
    assert far.distance == pytest.approx((200 - high[1]) / (high[1] - low[1]))


def test_arguments_broadcast(law: FittedLaw) -> None:
    slip = np.linspace(0, 0.3, 300)
    result = predict("deng2026", law.coefficients, np.linspace(1, 1.5, 90)[:, None], 30, 70, slip)
    assert result.mean_ci_lower.shape == (90, 300)
    expected = traction_coefficient(law.coefficients.constants, 1.5, 30, 70, slip)
    np.testing.assert_allclose(result.traction_coefficient[-1], expected, rtol=1e-12, atol=1e-16)


def test_whole_numbers_and_lists_are_conditions_as_others_are(law: FittedLaw) -> None:
    level = FixedCondition("inlet_temperature_c", 70.4, 0.02)
    at_level = replace(law, coefficients=replace(law.coefficients, fixed_conditions=(level,)))
    expected = at_level.predict(np.array([[1.0, 30.0, 70.0]]), np.array([0.05]))
    # 70 is within 2 % of 70.4
    assert not expected.away.any()
    for conditions in ([[1, 30, 70]], np.array([[1, 30, 70]])):
        result = at_level.predict(conditions, [0.05])
        assert result.traction_coefficient.tolist() == expected.traction_coefficient.tolist()
        assert result.distance.tolist() == expected.distance.tolist()


@pytest.mark.parametrize("shape", [(1, 2), (3,), (2, 3)])
def test_rows_that_are_not_those_of_the_law_are_refused(
    law: FittedLaw, shape: tuple[int, ...]
) -> None:
    with pytest.raises(OilfilmError, match=r"expected \(1, 3\)"):
        law.predict(np.full(shape, 30.0), np.array([0.05]))


@pytest.mark.parametrize("level", [-0.5, 0, 1, 95, np.nan])
def test_a_level_that_is_no_share_is_refused(law: FittedLaw, level: float) -> None:
    with pytest.raises(OilfilmError, match=f"level: found {level:g};"):
        law.predict_at(1.2, 30, 70, 0.05, level)


def test_beyond_one_range_is_outside_whatever_is_unknown_of_another(law: FittedLaw) -> None:
    box = law.coefficients.tested_box.copy()
    box[0] = np.nan
    unknown = replace(law.coefficients, tested_box=box)
    low, high = box.T
    result = predict("deng2026", unknown, 1.2, [(low[1] + high[1]) / 2, 2 * high[1]], 70.0, 0.05)
    assert result.outside.tolist() == [False, True]
    assert np.isnan(result.distance[0])
    assert result.distance[1] == pytest.approx(high[1] / (high[1] - low[1]))


def test_bare_constants_give_mu_without_interval_or_box() -> None:
    result = oilfilm.predict("deng2026", printed()["4050"], 1.2, 30, 70, 0.05)
    assert result.traction_coefficient == pytest.approx(
        float(traction_coefficient(printed()["4050"], 1.2, 30.0, 70.0, 0.05))
    )
    assert np.isnan([result.mean_ci_lower, result.mean_ci_upper, result.distance]).all()


def test_nothing_fitted_gives_nothing(config: Settings) -> None:
    points = make_points("4102", matrix()).assign(accepted=False)
    law = FittedLaw.from_results(fit_oil(points, "4102", config.fit, config.seed), "4102")
    with pytest.warns(UserWarning, match="nothing could be fitted"):
        result = law.predict_at(1.25, 30.0, 70.0, 0.1)
    assert np.isnan([result.traction_coefficient, result.mean_ci_lower, result.distance]).all()


def test_interval_below_zero_is_as_wide_as_the_constants_are_unsure() -> None:
    # Wang-Deng at no slip: mu = A0 + D0, here -0.002, D0 known to 5e-4
    law = LAWS["wang-deng-load"]
    constants = np.array([-0.012, 0, 0, 0, 0.6, 0, 0, 0, 20.0, 0, 0, 0, 0.010, 0, 0, 0])
    spread = np.tile(constants, (4000, 1))
    spread[:, 12] += 5e-4 * np.random.default_rng(5).standard_normal(4000)
    unsure = replace(Coefficients.from_constants(law, constants), refits=spread)
    result = FittedLaw(law, unsure).predict(np.array([[100.0, 20.0, 20.0]]), np.array([0.0]))
    assert result.traction_coefficient[0] == pytest.approx(-0.002)
    # the spread of a logarithm: 5 % of D0 bends it by a few per cent
    assert result.mean_ci_lower[0] == pytest.approx(-0.002 - 1.96 * 5e-4, abs=1e-4)
    assert result.mean_ci_upper[0] == pytest.approx(-0.002 + 1.96 * 5e-4, abs=1e-4)


def test_a_mean_shear_stress_above_the_oils_limit_is_marked():
    # 4010 has mu 0.165 at 2.5 GPa, 20 m/s, 20 degC by the printed constants: a mean shear stress of
    # 0.275 GPa. No oil is known to carry more than 0.12 of the pressure, 0.2 GPa there
    found = predict("deng2026", printed()["4010"], np.array([2.5, 1.5]), 20.0, 20.0, 0.0375)
    assert found.traction_coefficient[0] == pytest.approx(0.165, abs=0.001)
    assert found.over_limit.tolist() == [True, False]


@pytest.mark.parametrize(
    ("mu", "half_width", "lower", "upper"),
    [
        # by hand, sqrt(mu^2 + h^2) -+ h: 3-4-5
        (4e-5, 3e-5, 2e-5, 8e-5),
        # an error of the zero of the force beside no traction to speak of: mu 7e-6 was up to 1.6e7
        (1e-9, 1e-4, 0.0, 2e-4),
        (0.02, 1e-4, 0.0199, 0.0201),
    ],
)
def test_interval_of_tiny_mu_is_narrow(
    mu: float, half_width: float, lower: float, upper: float
) -> None:
    ends = Band(np.full((1, 1), half_width)).ends(np.array([mu]), np.ones((1, 1)))
    np.testing.assert_allclose(ends[:, 0], [lower, upper], rtol=2e-5, atol=1e-12)


SEED = 7


SLIP = np.array([0.01, 0.05, 0.2])


PRESSURES = (1.0, 1.1, 1.2, 1.35, 1.5)


def in_step(pressure: float) -> float:
    """The temperature of a rig that heats up as it is loaded, in degC."""
    return 60.0 * pressure**1.8


@pytest.fixture(scope="module")
def heated(quick: Settings) -> FittedLaw:
    """4102 as printed, tested at temperatures that rose with the pressure."""
    conditions = [(p, u, in_step(p)) for p in PRESSURES for u in (25.0, 40.0)]
    return fitted(fit_oil(make_points("4102", conditions, 1e-6), "4102", quick.fit, SEED))


def fitted(fit: CampaignTables) -> FittedLaw:
    return FittedLaw.from_tables(fit.coefficients, "4102", fit.refits, fit.fit_quality)


def mu_at(law: FittedLaw, *condition: float) -> np.ndarray:
    return law.predict(np.tile(condition, (len(SLIP), 1)), SLIP).traction_coefficient


@pytest.mark.parametrize(("pressure", "speed"), [(1.0, 25.0), (1.28, 31.0), (1.5, 40.0)])
def test_conditions_in_step_give_the_truth(
    heated: FittedLaw, pressure: float, speed: float
) -> None:
    at = (pressure, speed, in_step(pressure))
    truth = traction_coefficient(printed()["4102"], *at, SLIP)
    np.testing.assert_allclose(mu_at(heated, *at), truth, rtol=2e-3)
    # a condition that is left out is the one of the line
    np.testing.assert_allclose(mu_at(heated, pressure, speed, np.nan), truth, rtol=2e-3)


@pytest.mark.parametrize("temperature", [60.0, 120.0])
def test_corner_away_from_the_line_is_refused(heated: FittedLaw, temperature: float) -> None:
    other = 1.5 if temperature < 100 else 1.0
    law = heated.predict(np.array([[other, 30.0, temperature]]), np.array([0.05]))
    assert law.away.all()
    assert np.isnan([law.traction_coefficient, law.mean_ci_lower, law.mean_ci_upper]).all()
    at = dict(zip((*CONDITIONS, "slide_roll_ratio"), (other, 30.0, temperature, 0.05), strict=True))
    with pytest.raises(OilfilmError, match=r"maximum Hertz pressure.*\^1\.8"):
        prediction(heated, "4102", at)
    del at["inlet_temperature_c"]
    assert "in step with" in str(prediction(heated, "4102", at))


@pytest.mark.parametrize(
    ("speed", "temperature", "listed"),
    [(90.0, 70.0, [1]), (30.0, 120.0, [2]), (90.0, 120.0, [1, 2])],
)
def test_refusal_lists_the_conditions_away_from_the_tested_ones_and_no_others(
    quick: Settings, speed: float, temperature: float, listed: list[int]
) -> None:
    points = make_points("4102", [(p, 30.0, 70.0) for p in PRESSURES], 1e-6)
    law = fitted(fit_oil(points, "4102", quick.fit, SEED))
    names = [QUANTITIES[CONDITIONS[index]].short_meaning for index in listed]
    text = "; ".join(f"{name} was tested at .* only .*" for name in names)
    with pytest.warns(UserWarning, match=f"NaN at 1 of 1 points: {text}$"):
        predict("deng2026", law.coefficients, 1.2, speed, temperature, 0.05)


def test_exponents_along_a_line_are_not_those_of_one_condition(quick: Settings) -> None:
    conditions = [(p, u, in_step(p)) for p in PRESSURES for u in (25.0, 40.0)]
    fit = fit_oil(make_points("4102", conditions), "4102", quick.fit, SEED)
    rows = fit.coefficients.set_index("constant")
    constants = printed()["4102"].reshape(3, 4)
    for letter, (_, x1, x2, x3) in zip("ABC", constants, strict=True):
        # X1 ln P + X3 ln T = (X1 + 1.8 X3) ln P + constant
        assert rows.loc[f"{letter}1", "value"] == pytest.approx(x1 + 1.8 * x3, abs=1e-5)
        assert rows.loc[f"{letter}2", "value"] == pytest.approx(x2, abs=1e-5)
        assert rows.loc[f"{letter}1", "verdict"] == "in step"
        assert not rows.loc[f"{letter}3", "identifiable"]


def test_one_tested_level_says_nothing_about_another(quick: Settings) -> None:
    law = fitted(fit_oil(make_points("4102", matrix(us=[30.0])), "4102", quick.fit, SEED))
    truth = traction_coefficient(printed()["4102"], 1.2, 30.0, 70.0, SLIP)
    for speed in (30.0, 30.4, np.nan):
        np.testing.assert_allclose(mu_at(law, 1.2, speed, 70.0), truth, rtol=1e-5)
    assert np.isnan(mu_at(law, 1.2, 36.0, 70.0)).all()


@pytest.mark.slow
def test_run_of_unknown_temperature_costs_no_effect_of_temperature(quick: Settings) -> None:
    points = make_points("4102", matrix())
    points.loc[points["run_id"] == "run004", "inlet_temperature_c"] = np.nan
    fit = fit_oil(points, "4102", quick.fit, SEED)
    rows = fit.coefficients.set_index("constant")
    np.testing.assert_allclose(rows["value"].to_numpy(), printed()["4102"], rtol=1e-5)
    assert fit.fit_quality["incomplete_curves"].tolist() == [("run004",)]


def test_missing_or_foreign_conditions_are_named(heated: FittedLaw) -> None:
    with pytest.raises(OilfilmError, match="Give it, as --stress"):
        prediction(heated, "4102", {"entrainment_speed_m_s": 30, "slide_roll_ratio": 0.1})
    with pytest.raises(OilfilmError, match="the law takes the maximum Hertz pressure"):
        prediction(heated, "4102", {"load_n": 30, "slide_roll_ratio": 0.1})


@given(exponents=st.tuples(st.floats(-3, 3), st.floats(-3, 3)), level=st.floats(20, 150))
def test_line_is_as_planted(quick: Settings, exponents: tuple[float, float], level: float) -> None:
    grid = np.array([(p, u) for p in (1.0, 1.3, 1.7) for u in (10.0, 20.0, 40.0)])
    temperature = level * (grid[:, 0] / 1.3) ** exponents[0] * (grid[:, 1] / 20) ** exponents[1]
    conditions = np.column_stack([grid, temperature])
    followed = followed_condition_mask(CONDITIONS, conditions, quick.fit)
    assert followed.tolist() == [True, True, False]
    (fixed,) = fixed_conditions(CONDITIONS, conditions, followed, quick.fit)
    if not fixed.in_step:  # it varied too little to be called varied
        assert np.ptp(temperature) < quick.fit.min_relative_range * temperature.max()
        return
    line = fixed.tested_value(dict(zip(CONDITIONS, conditions.T, strict=True)))
    # an exponent that moves the line by less than the tolerance is left out of it
    np.testing.assert_allclose(line, temperature, rtol=2.1 * quick.fit.level_tolerance)
    assert fixed.within <= 3.1 * quick.fit.level_tolerance


def test_independent_conditions_are_all_followed(quick: Settings) -> None:
    conditions = np.array(matrix(), dtype=float)
    assert followed_condition_mask(CONDITIONS, conditions, quick.fit).all()
    # noise of 1 % about one level is no variation; nor are two curves one of three conditions
    noisy = conditions.copy()
    noisy[:, 1] = 30 + 0.1 * np.sin(np.arange(len(conditions)))
    assert followed_condition_mask(CONDITIONS, noisy, quick.fit).tolist() == [True, False, True]
    two = followed_condition_mask(CONDITIONS, conditions[[0, -1]], quick.fit)
    assert two.tolist() == [True, False, False]
    # nor is a scatter of 0.1 K about 1 degC
    cold = conditions.copy()
    cold[:, 2] = 1 + 0.1 * np.sin(np.arange(len(conditions)))
    assert followed_condition_mask(CONDITIONS, cold, quick.fit).tolist() == [True, True, False]


def test_temperature_in_step_is_found_in_frost_too(quick: Settings) -> None:
    pressure = np.array([1.0, 1.1, 1.2, 1.3, 1.4, 1.5] * 2)
    speed = np.repeat([20.0, 40.0], 6)
    in_step = np.column_stack([pressure, speed, 200 * (pressure - 1.2)])
    followed = followed_condition_mask(CONDITIONS, in_step, quick.fit)
    assert followed.tolist() == [True, True, False]
    (fixed,) = fixed_conditions(CONDITIONS, in_step, followed, quick.fit)
    # it is known of every run, but a power law through 0 degC has no value
    assert (fixed.level, fixed.in_step) == (None, ())
    assert not fixed.is_unmeasured
    assert "not known of every run" not in fixed.sentence()
    assert "0 degC" in fixed.sentence()
    apart = np.column_stack([pressure, speed, np.tile([-30.0, 0.0, 30.0, 60.0, -10.0, 20.0], 2)])
    assert followed_condition_mask(CONDITIONS, apart, quick.fit).all()


def test_frost_off_the_line_of_other_conditions_leaves_the_line_known(quick: Settings) -> None:
    # U = 25 P at each of three temperatures, one of them in frost
    pressure = np.tile([1.0, 1.2, 1.4, 1.6], 3)
    crossed = np.column_stack([pressure, 25 * pressure, np.repeat([-10.0, 40.0, 80.0], 4)])
    followed = followed_condition_mask(CONDITIONS, crossed, quick.fit)
    assert followed.tolist() == [True, False, True]
    (fixed,) = fixed_conditions(CONDITIONS, crossed, followed, quick.fit)
    (partner,) = fixed.in_step
    assert (partner.condition, partner.exponent) == ("max_hertz_pressure_gpa", pytest.approx(1.0))
    line = fixed.tested_value(dict(zip(CONDITIONS, crossed.T, strict=True)))
    np.testing.assert_allclose(line, 25 * pressure)
    # levels that a user gives as whole numbers have the same line
    whole = {
        "max_hertz_pressure_gpa": np.array([1, 2]),
        "entrainment_speed_m_s": np.array([25, 50]),
    }
    np.testing.assert_allclose(fixed.tested_value(whole), [25.0, 50.0])


def test_temperature_in_step_through_frost_is_not_called_unmeasured(quick: Settings) -> None:
    conditions = [(p, u, 70.0) for p in PRESSURES for u in (25.0, 40.0)]
    points = make_points("4102", conditions)
    points["inlet_temperature_c"] = 200 * (points["max_hertz_pressure_gpa"] - PRESSURES[1])
    fit = fit_oil(points, "4102", quick.fit, SEED)
    at = dict(zip((*CONDITIONS, "slide_roll_ratio"), (PRESSURES[1], 30.0, 50.0, 0.05), strict=True))
    with pytest.raises(OilfilmError, match=r"0 degC.*Leave the option out") as refusal:
        prediction(fitted(fit), "4102", at)
    # that is the advice for a pressure that was not recorded
    assert "ball_radius_m" not in str(refusal.value)
    # which of the followed conditions are on the line is not known
    verdicts = fit.coefficients.set_index("constant")["verdict"]
    assert (verdicts[["A1", "A2"]] == "in step").all()
    del at["inlet_temperature_c"]
    row, _ = prediction(fitted(fit), "4102", at)
    assert np.isfinite(row["traction_coefficient"])


def test_fixed_conditions_survive_the_table() -> None:
    fixed = (
        FixedCondition("inlet_temperature_c", 60.0, 0.03, (StepPartner(CONDITIONS[0], 1.2, 1.8),)),
        FixedCondition("entrainment_speed_m_s", None, 0.0),
        FixedCondition("inlet_temperature_c", None, 0.0, line_reaches_zero=True),
    )
    assert fixed_conditions_from_json(fixed_conditions_to_json(fixed)) == fixed
    with pytest.raises(OilfilmError, match="fixed_conditions holds 'inlet_temperature_c 60 degC'"):
        fixed_conditions_from_json("inlet_temperature_c 60 degC")


def test_spacings_are_steps_to_the_nearest_of_all_tested_conditions():
    random = np.random.default_rng(5)
    lowest, highest = np.array([0.8, 10.0, 30.0]), np.array([1.6, 50.0, 120.0])
    tested = random.uniform(lowest, highest, (200, 3))
    asked = random.uniform(0.5 * lowest, 1.5 * highest, (100, 3))
    asked[0] = tested[7]
    asked[1, 0] = np.nan
    coefficients = replace(
        Coefficients.from_constants(LAW, printed()["4102"]), tested_conditions=tested
    )
    spacings = FittedLaw(LAW, coefficients).spacings(asked)

    def coordinates(conditions):
        # a temperature in degC may be 0 or below, so it is no logarithm
        return np.column_stack([np.log(conditions[:, :2]), conditions[:, 2]])

    largest_steps = np.diff(np.sort(coordinates(tested), axis=0), axis=0).max(axis=0)
    steps_away = np.abs(coordinates(asked)[:, np.newaxis] - coordinates(tested)) / largest_steps
    expected = steps_away.max(axis=2).min(axis=1)
    assert spacings[0] == 0
    assert np.isnan(spacings[1])
    np.testing.assert_allclose(spacings[2:], expected[2:], rtol=1e-12)


# ---------------------------------------------------------------- the law beside the surface


@pytest.fixture(scope="module")
def few_conditions(config: Settings) -> FittedLaw:
    """A law with the surface of runs at eight conditions, which allow a level of 89 %."""
    points = make_points("4050", matrix([1.0, 1.5], [25.0, 40.0], [50.0, 120.0]), noise=1e-4)
    exact = FittedLaw(LAW, Coefficients.from_constants(LAW, printed()["4050"]))
    return with_measured_surface(exact, points, config.surface)


AT_POINT = np.array([[1.25, 32.0, 80.0]]), np.array([0.05])


def test_error_of_the_form_is_the_surface_without_its_runs(few_conditions: FittedLaw) -> None:
    surface = few_conditions.surface
    assert surface is not None
    assert few_conditions.interval_level() == pytest.approx(8 / 9)
    predicted = surface.surface.predict(*AT_POINT)
    run_sd = 0.5 * float(predicted.next_run_sd[0])
    factor = surface.interval_factors.point / normal_half_width(surface.interval_factors.level)
    law = replace(few_conditions, coefficients=replace(few_conditions.coefficients, run_sd=run_sd))
    distance = np.log(predicted.mu[0] / law.traction(*AT_POINT)[0])
    form_variance = (factor * predicted.next_run_sd[0]) ** 2 - run_sd**2
    expected = np.sqrt(form_variance + distance**2)
    assert law.form_error(*AT_POINT, 1.0)[0] == pytest.approx(expected, rel=1e-6)


def test_a_law_that_does_not_fit_is_as_far_from_the_surface_as_it_is(
    few_conditions: FittedLaw,
) -> None:
    # mu of the law is twice that of the surface, whether or not the surface answers instead
    constants = few_conditions.coefficients.constants * np.where(np.arange(12) % 8 == 0, 2.0, 1.0)
    wrong = replace(
        few_conditions, coefficients=replace(few_conditions.coefficients, constants=constants)
    )
    surface = few_conditions.surface
    assert surface is not None
    answered_by_surface = replace(
        wrong, read_surface=partial(given_surface, replace(surface, no_law_fits=True))
    )
    distance = abs(np.log(wrong.traction(*AT_POINT)[0] / surface.surface.predict(*AT_POINT).mu[0]))
    assert distance > 0.3
    for law in (wrong, answered_by_surface):
        assert law.form_error(*AT_POINT, 1.0)[0] >= distance


def test_the_surface_knows_no_mu_where_its_law_has_no_traction(
    few_conditions: FittedLaw, monkeypatch: pytest.MonkeyPatch
) -> None:
    # as D - |A| < 0 gives it near S = 0; at pure rolling mu is 0
    monkeypatch.setattr(Surface, "is_law_positive", lambda *_: False)
    surface = few_conditions.surface
    assert surface is not None
    conditions = np.repeat(AT_POINT[0], 2, axis=0)
    predicted = surface.predict(
        few_conditions.law, conditions, np.array([0.0, 0.01]), 0.95, whole_curve=False
    )
    np.testing.assert_array_equal(predicted.mu, [0.0, np.nan])


def test_a_law_of_load_on_two_contacts_has_no_interval(few_conditions: FittedLaw) -> None:
    """The load gives no pressure, so that the surface says nothing of it."""
    surface = few_conditions.surface
    assert surface is not None
    two_contacts = replace(surface, contact=MeasuredContact(np.nan))
    law = replace(
        FittedLaw(
            LAWS["wang-deng-load"], Coefficients.from_constants(LAWS["wang-deng-load"], np.ones(12))
        ),
        read_surface=partial(given_surface, two_contacts),
    )
    assert law.surface is None
    assert replace(few_conditions, read_surface=law.read_surface).surface is not None
