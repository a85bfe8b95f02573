"""Fits on arrays: planted constants come back, with units or without."""

import pickle

import numpy as np
import pandas as pd
import pint
import pytest
from matplotlib.figure import Figure

import oilfilm
from oilfilm.arrays import ArrayFit

QUICK = {"searches": 2, "bootstrap": 20}


@pytest.fixture(scope="module")
def points() -> pd.DataFrame:
    """Points without noise on the printed law of 4102."""
    levels = np.meshgrid([1.0, 1.25, 1.5], [25, 40], [50, 120], np.linspace(0, 0.3, 11))
    pressure, speed, temperature, slip = (level.ravel() for level in levels)
    law = oilfilm.printed("4102")
    mu = oilfilm.predict(law.law, law.coefficients, pressure, speed, temperature, slip)
    frame = {"P": pressure, "U": speed, "T": temperature, "S": slip}
    return pd.DataFrame({**frame, "mu": mu.traction_coefficient})


@pytest.fixture(scope="module")
def fitted(points: pd.DataFrame) -> ArrayFit:
    return oilfilm.fit(*(points[name] for name in points), **QUICK)


def test_planted_constants_come_back(fitted: ArrayFit) -> None:
    planted = oilfilm.printed("4102").coefficients.constants
    np.testing.assert_allclose(fitted.constants["value"], planted, rtol=1e-6)
    assert fitted.soundness["optimum_confirmed"]
    # speed and temperature have two levels each: what bends between them cannot be seen
    assert fitted.soundness["law_verdict"] == "two levels"
    assert not fitted.soundness["sound"]
    at = fitted.predict(1.2, 30, 70, 0.05)
    assert at.obs_ci_lower <= at.traction_coefficient <= at.obs_ci_upper
    assert fitted.predict(1.2, 30, 70, 0.5).outside


def test_printed_law_shows_its_equation_and_the_digits_of_the_paper() -> None:
    shown = repr(oilfilm.printed(4102))
    assert shown == repr(oilfilm.printed("4102"))
    assert shown.startswith("deng2026: mu = (A + B*S)*exp(-C*S) - A; A0 -0.01567792, A1 1.6654,")


def test_search_that_misses_an_exact_fit_is_told() -> None:
    """The best search then leaves rounding alone, and the other is 1e19 times worse."""
    levels = np.meshgrid([1.0, 1.25, 1.5], [20, 30, 40], [25, 70, 120], np.linspace(0, 0.1, 12))
    law = oilfilm.printed("4102")
    mu = oilfilm.predict(law.law, law.coefficients, *levels).traction_coefficient
    fit = oilfilm.fit(*levels, mu, bootstrap=20, polished=1)
    quality = fit.tables.fit_quality.iloc[0]
    assert quality["sse_spread"] > 1e12
    assert not quality["certified"]
    assert "searches agree" in fit.verdict
    np.testing.assert_allclose(fit.constants["value"], law.coefficients.constants, rtol=1e-5)


def test_columns_of_a_frame_may_have_any_index(points: pd.DataFrame, fitted: ArrayFit) -> None:
    shuffled = points.set_index(pd.Index(range(len(points), 0, -1), name="reading"))
    conditions = shuffled.groupby(["P", "U", "T"], sort=False).ngroup()
    again = oilfilm.fit(*(shuffled[name] for name in points), curve=conditions, **QUICK)
    pd.testing.assert_frame_equal(again.constants, fitted.constants)


def test_quantities_are_converted(points: pd.DataFrame, fitted: ArrayFit) -> None:
    units = pint.UnitRegistry()
    quantities = (
        units.Quantity(points["P"].to_numpy() * 1e9, "Pa"),
        units.Quantity(points["U"].to_numpy() * 3.6, "km/h"),
        units.Quantity(points["T"].to_numpy() + 273.15, "kelvin"),
        units.Quantity(points["S"].to_numpy() * 100, "percent"),
    )
    again = oilfilm.fit(*quantities, points["mu"], **QUICK)
    np.testing.assert_allclose(again.constants["value"], fitted.constants["value"], rtol=1e-6)
    with pytest.raises(oilfilm.OilfilmError, match=r"max_hertz_pressure_gpa.*such as GPa"):
        fitted.predict(units.Quantity(1.0, "m/s"), 30, 70, 0.05)


def test_law_that_made_the_points_is_named_the_best(points: pd.DataFrame) -> None:
    random = np.random.default_rng(3)
    noisy = points["mu"] + 1e-4 * random.standard_normal(len(points))
    fit = oilfilm.fit(*(points[name] for name in "PUTS"), noisy, law="tanh", **QUICK)
    compared = fit.compare()
    assert compared.verdict.startswith("Deng (Eq. 7) describes the data better than the configured")
    assert compared.laws["bic"].idxmin() == "deng2026"
    # laws of load cannot be compared, because the load is not known
    assert "wang-deng-load" not in compared.laws.index


def test_result_shows_itself(fitted: ArrayFit) -> None:
    assert "A0" in repr(fitted)
    assert "<td>" in fitted._repr_html_()
    axes = fitted.plot(Figure().subplots())
    # points and law of each of the 12 conditions
    assert len(axes.lines) == 24


def test_data_that_cannot_be_fitted_give_a_verdict() -> None:
    few = oilfilm.fit(1.0, 25, 50, [0.0, 0.1], [0.0, 0.02], **QUICK)
    assert "at least" in few.verdict
    assert few.constants["value"].isna().all()


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({"law": "eyering"}, "no law 'eyering'.*eyring"),
        ({"law": "wang-deng-load"}, "no law"),
        ({"bootstap": 9}, "Did you mean 'bootstrap'"),
        ({"curve": [1, 2, 3]}, "`curve` has 3 values; expected 2"),
    ],
)
def test_mistake_is_told_in_a_sentence(arguments: dict[str, object], expected: str) -> None:
    with pytest.raises(oilfilm.OilfilmError, match=expected):
        oilfilm.fit(1.0, 25, 50, [0.0, 0.1], [0.0, 0.02], **arguments)


def test_arrays_that_do_not_match_and_oils_without_constants_are_told() -> None:
    with pytest.raises(oilfilm.OilfilmError, match="shapes that do not match"):
        oilfilm.fit([1.0, 1.2, 1.5], 25, 50, [0.0, 0.1], [0.0, 0.02])
    with pytest.raises(oilfilm.OilfilmError, match="no constants of '4103'; of 4102"):
        oilfilm.printed("4103")


def test_measured_conditions_that_agree_within_tolerances_are_one_curve(
    points: pd.DataFrame, fitted: ArrayFit
) -> None:
    random = np.random.default_rng(7)
    off = 1 + 0.002 * random.standard_normal((2, len(points)))
    scattered = (points["P"] * off[0], points["U"] * off[1], points["T"], points["S"], points["mu"])
    fit = oilfilm.fit(*scattered, **QUICK)
    assert fit.points["run_id"].nunique() == 12
    truth = points.groupby(["P", "U", "T"], sort=False).ngroup()
    assert (fit.points["run_id"].astype(int) == truth).all()


def test_points_taken_apart_are_warned_of(points: pd.DataFrame) -> None:
    columns = [points[name] for name in points]
    with pytest.warns(UserWarning, match=r"132 points are taken for 132 curves"):
        oilfilm.fit(*columns, curve=np.arange(len(points)), **QUICK)


@pytest.mark.parametrize(
    ("column", "factor", "hint"),
    [("S", 100.0, "percent"), ("P", 1000.0, "MPa"), ("mu", np.nan, "no number")],
)
def test_impossible_numbers_are_refused_with_their_likely_unit(
    points: pd.DataFrame, column: str, factor: float, hint: str
) -> None:
    wrong = points.assign(**{column: points[column] * factor})
    with pytest.raises(oilfilm.OilfilmError, match=hint):
        oilfilm.fit(*(wrong[name] for name in wrong), **QUICK)


def test_prediction_at_an_impossible_pressure_is_refused(fitted: ArrayFit) -> None:
    with pytest.raises(oilfilm.OilfilmError, match=r"1200 GPa.*MPa"):
        fitted.predict(1200, 30, 70, 0.05)


def test_calibration_widens_both_intervals(points: pd.DataFrame) -> None:
    columns = [points[name] for name in points]
    stated = {"load_relative": 1e-9, "traction_force_relative": 0.01, "speed_relative": 1e-9}
    fit = oilfilm.fit(*columns, calibration={**stated, "temperature_c": 0.0}, **QUICK)
    at = fit.predict(1.0, 25, 50, 0.05)
    # a gain that is off by 1 % is nearly all there is: 1.96 %
    width = float(at.obs_ci_upper - at.obs_ci_lower) / 2 / float(at.traction_coefficient)
    assert width == pytest.approx(0.0196, rel=0.05)


def test_a_fit_is_summed_up_and_pickled(fitted: ArrayFit) -> None:
    shown = fitted.summary()
    assert "132 points in 12 curves" in shown
    frame = fitted.to_frame()
    np.testing.assert_allclose(frame["fitted"] + frame["residual"], frame["traction_coefficient"])
    again = pickle.loads(pickle.dumps(fitted))
    pd.testing.assert_frame_equal(again.constants, fitted.constants)
    assert again.predict(1.2, 30, 70, 0.05) is not None
    assert {"fit", "fit_table", "predict", "printed", "read_fit"} <= set(dir(oilfilm))
