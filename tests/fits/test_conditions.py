"""Conditions of which the data give no exponent: where mu is known, and where it is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from campaigns import printed
from fit_points import make_points, matrix
from oilfilm.cli.predict import prediction
from oilfilm.errors import OilfilmError
from oilfilm.fits.conditions import (
    FixedCondition,
    InStep,
    fixed_conditions,
    followed_conditions,
    from_text,
    to_text,
)
from oilfilm.fits.fit import fit_oil
from oilfilm.fits.fitted import FittedLaw, predict
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import CONDITIONS, QUANTITIES
from oilfilm.traction.laws.deng2026 import traction_coefficient

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
    return FittedLaw.of(fit.coefficients, "4102", fit.refits, fit.fit_quality)


def mu_at(law: FittedLaw, *condition: float) -> np.ndarray:
    return law.predict(np.tile(condition, (len(SLIP), 1)), SLIP).traction_coefficient


@pytest.mark.parametrize(("pressure", "speed"), [(1.0, 25.0), (1.28, 31.0), (1.5, 40.0)])
def test_conditions_in_step_give_the_truth_along_their_line(
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
    with pytest.raises(OilfilmError, match=r"in step with maximum Hertz pressure only: .*\^1\.8"):
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


def test_run_of_unknown_temperature_costs_no_effect_of_temperature(quick: Settings) -> None:
    points = make_points("4102", matrix())
    points.loc[points["run_id"] == "run004", "inlet_temperature_c"] = np.nan
    fit = fit_oil(points, "4102", quick.fit, SEED)
    rows = fit.coefficients.set_index("constant")
    np.testing.assert_allclose(rows["value"].to_numpy(), printed()["4102"], rtol=1e-5)
    assert fit.fit_quality["incomplete_curves"].tolist() == ["run004"]


def test_missing_or_foreign_conditions_are_named(heated: FittedLaw) -> None:
    with pytest.raises(OilfilmError, match="Give it, as --stress"):
        prediction(heated, "4102", {"entrainment_speed_m_s": 30, "slide_roll_ratio": 0.1})
    with pytest.raises(OilfilmError, match="the law deng2026 does not take load_n"):
        prediction(heated, "4102", {"load_n": 30, "slide_roll_ratio": 0.1})


@given(exponents=st.tuples(st.floats(-3, 3), st.floats(-3, 3)), level=st.floats(20, 150))
def test_line_is_as_planted(quick: Settings, exponents: tuple[float, float], level: float) -> None:
    grid = np.array([(p, u) for p in (1.0, 1.3, 1.7) for u in (10.0, 20.0, 40.0)])
    temperature = level * (grid[:, 0] / 1.3) ** exponents[0] * (grid[:, 1] / 20) ** exponents[1]
    conditions = np.column_stack([grid, temperature])
    followed = followed_conditions(CONDITIONS, conditions, quick.fit)
    assert followed.tolist() == [True, True, False]
    (fixed,) = fixed_conditions(CONDITIONS, conditions, followed, quick.fit)
    if not fixed.in_step:  # it varied too little to be called varied
        assert np.ptp(temperature) < quick.fit.min_relative_range * temperature.max()
        return
    line = fixed.on_line(dict(zip(CONDITIONS, conditions.T, strict=True)))
    # an exponent that moves the line by less than the tolerance is left out of it
    np.testing.assert_allclose(line, temperature, rtol=2.1 * quick.fit.level_tolerance)
    assert fixed.within <= 3.1 * quick.fit.level_tolerance


def test_independent_conditions_are_all_followed(quick: Settings) -> None:
    conditions = np.array(matrix(), dtype=float)
    assert followed_conditions(CONDITIONS, conditions, quick.fit).all()
    # noise of 1 % about one level is no variation; nor are two curves one of three conditions
    noisy = conditions.copy()
    noisy[:, 1] = 30 + 0.1 * np.sin(np.arange(len(conditions)))
    assert followed_conditions(CONDITIONS, noisy, quick.fit).tolist() == [True, False, True]
    two = followed_conditions(CONDITIONS, conditions[[0, -1]], quick.fit)
    assert two.tolist() == [True, False, False]
    # nor is a scatter of 0.1 K about 1 degC
    cold = conditions.copy()
    cold[:, 2] = 1 + 0.1 * np.sin(np.arange(len(conditions)))
    assert followed_conditions(CONDITIONS, cold, quick.fit).tolist() == [True, True, False]


def test_fixed_conditions_survive_the_table() -> None:
    fixed = (
        FixedCondition("inlet_temperature_c", 60.0, 0.03, (InStep(CONDITIONS[0], 1.2, 1.8),)),
        FixedCondition("entrainment_speed_m_s", None, 0.0),
    )
    assert from_text(to_text(fixed)) == fixed
    with pytest.raises(OilfilmError, match="fixed_conditions holds 'inlet_temperature_c 60 degC'"):
        from_text("inlet_temperature_c 60 degC")
