"""Fits on arrays: planted constants come back, with units or without."""

import itertools
import pickle
import runpy
from collections.abc import Callable
from dataclasses import replace
from inspect import signature
from pathlib import Path

import numpy as np
import pandas as pd
import pint
import pytest
import xarray
from matplotlib.figure import Figure

import oilfilm
from known_laws import known_law
from nights import quick_ones
from oilfilm.api.arrays import ArrayFit
from oilfilm.api.fit_keys import FitKeys
from oilfilm.settings.config import FitSettings

QUICK: FitKeys = {"searches": 2, "bootstrap": 20}


@pytest.fixture(scope="module")
def points() -> pd.DataFrame:
    """Points without noise on the printed law of 4102."""
    levels = np.meshgrid([1.0, 1.25, 1.5], [25, 40], [50, 120], np.linspace(0, 0.3, 11))
    pressure, speed, temperature, slip = (level.ravel() for level in levels)
    law = known_law("4102")
    mu = oilfilm.predict(law.law, law.coefficients, pressure, speed, temperature, slip)
    frame = {"P": pressure, "U": speed, "T": temperature, "S": slip}
    return pd.DataFrame({**frame, "mu": mu.traction_coefficient})


@pytest.fixture(scope="module")
def fitted(points: pd.DataFrame) -> ArrayFit:
    return oilfilm.fit(*(points[name] for name in points), **QUICK)


@pytest.mark.slow
def test_planted_constants_come_back(fitted: ArrayFit) -> None:
    planted = known_law("4102").coefficients.constants
    np.testing.assert_allclose(fitted.constants["value"], planted, rtol=1e-6)
    assert fitted.soundness["optimum_confirmed"]
    # speed and temperature have two levels each: what bends between them cannot be seen
    assert fitted.soundness["law_verdict"] == "two levels"
    assert not fitted.soundness["sound"]
    prediction = fitted.predict(1.2, 30, 70, 0.05)
    assert prediction.obs_ci_lower <= prediction.traction_coefficient <= prediction.obs_ci_upper
    assert fitted.predict(1.2, 30, 70, 0.5).outside


@pytest.mark.slow
def test_exact_fit_has_a_summary(fitted: ArrayFit) -> None:
    exact_quality = fitted.tables.fit_quality.assign(rmse=0.0, relative_rms=0.0, left_out_rmse=0.0)
    exact = replace(fitted, tables=fitted.tables.replace(fit_quality=exact_quality))
    assert "misfit 0.00% of mu (rms); R2" in exact.summary()


@pytest.mark.slow
def test_columns_of_a_frame_may_have_any_index(points: pd.DataFrame, fitted: ArrayFit) -> None:
    shuffled = points.set_index(pd.Index(range(len(points), 0, -1), name="reading"))
    curve_of_point = shuffled.groupby(["P", "U", "T"], sort=False).ngroup()
    refitted = oilfilm.fit(*(shuffled[name] for name in points), curve=curve_of_point, **QUICK)
    pd.testing.assert_frame_equal(refitted.constants, fitted.constants)


def test_columns_of_different_rows_are_refused(points: pd.DataFrame) -> None:
    by_slip = points.sort_values("S")
    with pytest.raises(oilfilm.OilfilmError, match="the same labels in another order"):
        oilfilm.fit(points["P"], points["U"], points["T"], by_slip["S"], by_slip["mu"], **QUICK)
    curve_of_point = by_slip.groupby(["P", "U", "T"]).ngroup()
    with pytest.raises(oilfilm.OilfilmError, match=r"and curve.*another order"):
        oilfilm.fit(*(points[name] for name in points), curve=curve_of_point, **QUICK)
    with pytest.raises(oilfilm.OilfilmError, match="132 and 131 rows"):
        oilfilm.fit(points["P"], 30.0, 70.0, points["S"], points["mu"].iloc[1:], **QUICK)


@pytest.mark.slow
def test_arrays_of_xarray_are_fitted_by_their_dimensions(fitted: ArrayFit) -> None:
    levels = {"P": [1.0, 1.25, 1.5], "U": [25.0, 40.0], "T": [50.0, 120.0]}
    data = xarray.Dataset(coords={**levels, "S": np.linspace(0, 0.3, 11)})
    mu = known_law("4102").predict_at(data["P"], data["U"], data["T"], data["S"])
    # the order of the dimensions does not count
    transposed_mu = mu.traction_coefficient.transpose("S", "T", "U", "P")
    refitted = oilfilm.fit(data["P"], data["U"], data["T"], data["S"], transposed_mu, **QUICK)
    np.testing.assert_allclose(refitted.constants["value"], fitted.constants["value"], rtol=1e-6)
    with pytest.raises(oilfilm.OilfilmError, match="array without names of dimensions"):
        oilfilm.fit(data["P"], data["U"], data["T"], data["S"].to_numpy(), transposed_mu, **QUICK)
    with pytest.raises(oilfilm.OilfilmError, match="different coordinates"):
        oilfilm.fit(
            data["P"], data["U"], data["T"], data["S"].isel(S=slice(3)), transposed_mu, **QUICK
        )


def test_settings_are_typed_as_they_are_declared() -> None:
    declared = {
        name: field.annotation
        for name, field in FitSettings.model_fields.items()
        # the law is an argument of its own
        if name != "law"
    }
    assert FitKeys.__annotations__ == declared


def test_signature_of_fit_is_short_enough_to_be_read() -> None:
    assert len(str(signature(oilfilm.fit))) < 360


@pytest.mark.slow
def test_quantities_are_converted(points: pd.DataFrame, fitted: ArrayFit) -> None:
    units = pint.UnitRegistry()
    quantities = (
        units.Quantity(points["P"].to_numpy() * 1e9, "Pa"),
        units.Quantity(points["U"].to_numpy() * 3.6, "km/h"),
        units.Quantity(points["T"].to_numpy() + 273.15, "kelvin"),
        units.Quantity(points["S"].to_numpy() * 100, "percent"),
    )
    refitted = oilfilm.fit(*quantities, points["mu"], **QUICK)
    np.testing.assert_allclose(refitted.constants["value"], fitted.constants["value"], rtol=1e-6)
    with pytest.raises(oilfilm.OilfilmError, match=r"max_hertz_pressure_gpa.*such as GPa"):
        fitted.predict(units.Quantity(1.0, "m/s"), 30, 70, 0.05)


@pytest.mark.slow
def test_result_shows_itself(fitted: ArrayFit) -> None:
    assert "A0" in repr(fitted)
    assert "<td>" in fitted._repr_html_()
    axes = fitted.plot(Figure().subplots())
    # all points in grey, then law and points of five of the 12 conditions
    assert len(axes.lines) == 1 + 2 * 5
    axes = fitted.plot(Figure().subplots(), at=[1.2, 30, 70])
    (band,), (label,) = axes.collections, axes.get_legend().get_texts()
    assert label.get_text() == "1.2 GPa, 30 m/s, 70 degC"
    # the interval of the next run
    row, slip = np.array([[1.2, 30.0, 70.0]]), np.array([0.3])
    prediction = fitted.law.predict(row, slip, whole_curve=True)
    band_corners = band.get_paths()[0].vertices
    ends_at_last_slip = band_corners[np.isclose(band_corners[:, 0], 0.3), 1]
    np.testing.assert_allclose(
        [ends_at_last_slip.min(), ends_at_last_slip.max()],
        [prediction.obs_ci_lower[0], prediction.obs_ci_upper[0]],
    )


def test_predictions_keep_the_index_of_a_column(points: pd.DataFrame) -> None:
    printed = known_law("4102")
    slip = points["S"].iloc[3:6].set_axis(["a", "b", "c"])
    predicted = printed.predict_at(1.2, 30, 70, slip)
    np.testing.assert_array_equal(
        predicted.traction_coefficient["b"],
        printed.predict_at(1.2, 30, 70, slip["b"]).traction_coefficient,
    )
    assert list(predicted.to_frame().index) == ["a", "b", "c"]
    assert repr(predicted).splitlines()[1].startswith("a ")
    with pytest.raises(oilfilm.OilfilmError, match="different indices"):
        printed.predict_at(1.2, points["U"], 70, slip)
    for other_speeds in ([[20.0], [30.0]], [[20.0, 25.0, 30.0]]):
        with pytest.raises(oilfilm.OilfilmError, match="a column of 3 rows"):
            printed.predict_at(1.2, np.array(other_speeds), 70, slip)


def test_arrays_of_xarray_broadcast_by_the_names_of_their_dimensions() -> None:
    speed = xarray.DataArray([25.0, 40.0], dims="speed", coords={"speed": [25, 40]})
    slip = xarray.DataArray([0.02, 0.1], dims="slip")
    mu = known_law("4102").predict_at(1.2, speed, 70, slip).traction_coefficient
    assert mu.dims == ("speed", "slip")
    alone = known_law("4102").predict_at(1.2, 40, 70, 0.02).traction_coefficient
    assert float(mu.sel(speed=40)[0]) == float(alone)


def test_mu_has_the_coordinates_of_all_arguments_and_the_attributes_of_none() -> None:
    pressure = xarray.DataArray(
        [1.0, 1.2], dims="pressure", attrs={"units": "GPa"}, coords={"operator": "a", "rig": "mtm"}
    )
    sweep = {"slip": [0.02, 0.1], "step": ("slip", [1, 2]), "operator": "b"}
    slip = xarray.DataArray([0.02, 0.1], dims="slip", coords=sweep)
    speed = pint.UnitRegistry().Quantity(40_000.0, "mm/s")
    mu = known_law("4102").predict_at(pressure, speed, 70, slip).traction_coefficient
    assert mu.dims == ("pressure", "slip")
    assert mu.attrs == {}
    assert mu.name == "traction_coefficient"
    assert mu.coords["step"].to_numpy().tolist() == [1, 2]
    assert mu.coords["rig"] == "mtm"
    # two arguments differ in it
    assert "operator" not in mu.coords
    alone = known_law("4102").predict_at(1.2, 40, 70, 0.1).traction_coefficient
    assert float(mu.isel(pressure=1).sel(slip=0.1)) == float(alone)


def test_indices_of_texts_and_numbers_are_compared() -> None:
    speed = pd.Series([20.0, 30.0], index=[1, "a"])
    slip = pd.Series([0.05, 0.06], index=["a", 1])
    with pytest.raises(oilfilm.OilfilmError, match="the same labels in another order"):
        known_law("4102").predict_at(1.2, speed, 70, slip)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({"max_hertz_pressure": [1.0, 1.2, 1.5]}, "shapes that do not match"),
        ({"law": "eyering"}, "no law 'eyering'.*eyring"),
        ({"bootstap": 9}, "Did you mean 'bootstrap'"),
        ({"curve": [1, 2, 3]}, r"`curve` has the shape \(3,\); expected \(2,\)"),
        # as many values as points, in another order
        (
            {
                "slide_roll_ratio": [[0, 0.1, 0.2], [0, 0.1, 0.2]],
                "traction_coefficient": [[0, 0.02, 0.03], [0, 0.02, 0.03]],
                "curve": [[1, 1], [1, 2], [2, 2]],
            },
            r"`curve` has the shape \(3, 2\); expected \(2, 3\)",
        ),
    ],
)
def test_mistake_is_told(arguments: dict[str, object], expected: str) -> None:
    names = ("max_hertz_pressure", "entrainment_speed", "inlet_temperature", "slide_roll_ratio")
    conditions = dict(zip(names, (1.0, 25, 50, [0.0, 0.1]), strict=True))
    with pytest.raises(oilfilm.OilfilmError, match=expected):
        oilfilm.fit(**(conditions | {"traction_coefficient": [0.0, 0.02]} | arguments))


def test_conditions_within_tolerances_are_one_curve(points: pd.DataFrame, fitted: ArrayFit) -> None:
    random = np.random.default_rng(7)
    error_factors = 1 + 0.002 * random.standard_normal((2, len(points)))
    scattered = (
        points["P"] * error_factors[0],
        points["U"] * error_factors[1],
        points["T"],
        points["S"],
        points["mu"],
    )
    fit = oilfilm.fit(*scattered, **QUICK)
    assert fit.points["run_id"].nunique() == 12
    true_curve_of_point = points.groupby(["P", "U", "T"], sort=False).ngroup()
    assert (fit.points["run_id"].astype(int) == true_curve_of_point).all()


@pytest.mark.slow
def test_points_taken_apart_are_warned_of(points: pd.DataFrame) -> None:
    columns = [points[name] for name in points]
    with pytest.warns(UserWarning, match=r"132 points.* 132 curves") as warned:
        oilfilm.fit(*columns, curve=np.arange(len(points)), **QUICK)
    # advice that a caller can follow who gave `curve`, or a table
    assert "curve=" not in str(warned[0].message)


@pytest.mark.parametrize(
    ("column", "change", "hint"),
    [
        ("S", lambda slip: 100 * slip, "percent"),
        ("P", lambda pressure: 1000 * pressure, "MPa"),
        ("P", lambda pressure: -pressure, "wrong sign"),
        ("U", lambda speed: 0 * speed, r"found 0 m/s.*expected above 0 to 500 m/s\.$"),
        ("T", lambda celsius: celsius + 273.15, "in kelvins"),
        ("mu", lambda mu: np.nan * mu, "no number"),
        ("T", lambda celsius: celsius.astype(str) + " degC", "inlet_temperature_c: expected num"),
    ],
)
def test_impossible_numbers_are_refused_with_their_likely_unit(
    points: pd.DataFrame, column: str, change: Callable[[pd.Series], pd.Series], hint: str
) -> None:
    wrong = points.assign(**{column: change(points[column])})
    with pytest.raises(oilfilm.OilfilmError, match=hint):
        oilfilm.fit(*(wrong[name] for name in wrong), **QUICK)


@pytest.mark.parametrize(
    ("at", "expected"),
    [((1200, 30, 70), r"1200 GPa.*MPa"), ((1.2, 30, -5), "above zero; found 1.2, 30, -5")],
)
def test_impossible_condition_is_told(
    fitted: ArrayFit, at: tuple[float, ...], expected: str
) -> None:
    with pytest.raises(oilfilm.OilfilmError, match=expected):
        fitted.predict(*at, 0.05)


@pytest.mark.slow
def test_calibration_widens_the_interval_of_the_laws_mean(
    points: pd.DataFrame, fitted: ArrayFit
) -> None:
    columns = [points[name] for name in points]
    calibration = {"load_relative": 1e-9, "traction_force_relative": 0.01, "speed_relative": 1e-9}
    fit = oilfilm.fit(*columns, calibration={**calibration, "temperature_c": 0.0}, **QUICK)
    prediction = fit.predict(1.0, 25, 50, 0.05)
    # a gain that is off by 1 % is nearly all there is
    half_width = (float(prediction.mean_ci_upper) - float(prediction.mean_ci_lower)) / 2
    assert half_width / float(prediction.traction_coefficient) == pytest.approx(0.0196, rel=0.05)
    # a load that is not known stays so
    assert fit.campaign_points["load_n"].isna().all()
    assert fit.tables.fit_quality[["tested_min_load_n", "tested_max_load_n"]].isna().all(axis=None)
    # the next run has the same calibration, which its interval does not contain
    prediction_without = fitted.predict(1.0, 25, 50, 0.05)
    assert float(prediction.obs_ci_upper) == float(prediction_without.obs_ci_upper)


def test_a_fit_is_summed_up_and_pickled(fitted: ArrayFit) -> None:
    summary = fitted.summary()
    assert "132 points in 12 curves" in summary
    assert "R2 1.00000" in summary
    frame = fitted.to_frame()
    np.testing.assert_allclose(frame["fitted"] + frame["residual"], frame["traction_coefficient"])
    unpickled = pickle.loads(pickle.dumps(fitted))
    pd.testing.assert_frame_equal(unpickled.constants, fitted.constants)
    assert unpickled.predict(1.2, 30, 70, 0.05) is not None
    assert {"fit", "fit_table", "predict", "read_fit"} <= set(dir(oilfilm))


@pytest.mark.slow
def test_constants_have_the_level_of_their_intervals_and_their_correlations(
    points: pd.DataFrame,
) -> None:
    noise = 1e-3 * np.random.default_rng(4).standard_normal(len(points))
    noisy = points.assign(mu=points["mu"] * (1 + noise))
    fit = oilfilm.fit(*(noisy[name] for name in noisy), **QUICK)
    assert "joint 95% intervals" in fit.summary()
    correlations = fit.correlations
    np.testing.assert_allclose(np.diag(correlations), 1)
    # of A0 and A1 by the definition, over the constants of the refits
    a0, a1 = fit.law.coefficients.refits[:, :2].T
    expected = np.cov(a0, a1)[0, 1] / (a0.std(ddof=1) * a1.std(ddof=1))
    assert correlations.loc["A0", "A1"] == pytest.approx(expected)
    # by the residuals that the table of points has
    residual = fit.to_frame()["residual"]
    assert fit.r_squared == pytest.approx(
        1 - residual.var(ddof=0) / noisy["mu"].var(ddof=0), abs=1e-6
    )


def test_a_condition_without_a_number_is_outside(fitted: ArrayFit) -> None:
    predicted = fitted.predict([np.nan, 1.2, 1.2], 30, 70, [0.05, np.nan, 0.05])
    assert predicted.outside.tolist() == [True, True, False]


@pytest.mark.parametrize("at", [[1.2, 30], [[1.2, 30, 70, 0.1]], [[[1.2, 30, 70]]], "warm"])
def test_operating_points_of_a_plot_have_a_number_for_each_condition(
    fitted: ArrayFit, at: object
) -> None:
    with pytest.raises(oilfilm.OilfilmError, match=r"at: found .* 3 numbers each.*inlet_temp"):
        fitted.plot(at=at)


def test_a_plot_that_cannot_be_drawn_is_told(
    fitted: ArrayFit, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(oilfilm.OilfilmError, match=r"found 'a\.png'; expected axes"):
        fitted.plot("a.png")
    monkeypatch.setattr("oilfilm.api.axes.find_spec", lambda name: None)
    with pytest.raises(oilfilm.OilfilmError, match="needs matplotlib"):
        fitted.plot()


@pytest.mark.slow
def test_a_saved_fit_predicts_the_same(fitted: ArrayFit, tmp_path: Path) -> None:
    replace(fitted, oil="4102").save(tmp_path / "june")
    # a number names an oil, too
    prediction = oilfilm.read_fit(tmp_path / "june", 4102).predict_at(1.2, 30, 70, 0.05)
    pd.testing.assert_frame_equal(
        prediction.to_frame(), fitted.predict(1.2, 30, 70, 0.05).to_frame()
    )
    assert (tmp_path / "june/report.html").is_file()
    (tmp_path / "broken").symlink_to(tmp_path / "gone")
    messages = {"june": "exists already", "broken": "exists already", 300 * "x": "cannot be a name"}
    for name, message in messages.items():
        with pytest.raises(oilfilm.OilfilmError, match=message):
            fitted.save(tmp_path / name)


@pytest.mark.slow
def test_a_fit_is_exported_by_the_ending_of_a_file(fitted: ArrayFit, tmp_path: Path) -> None:
    fitted.export(tmp_path / "law.py")
    exported = runpy.run_path(str(tmp_path / "law.py"))
    mu = fitted.predict(1.2, 30, 70, 0.05).traction_coefficient
    assert exported["traction_coefficient"](1.2, 30, 70, 0.05) == pytest.approx(float(mu), rel=1e-9)
    fitted.export(tmp_path / "law.h")
    assert "Measured data" in (tmp_path / "law.h").read_text(encoding="utf-8")
    with pytest.raises(oilfilm.OilfilmError, match=r"law\.rs: there is no export.*\.f90"):
        fitted.export(tmp_path / "law.rs")


def test_few_curves_of_one_pressure_say_why_numbers_are_missing(points: pd.DataFrame) -> None:
    noise = 1e-3 * np.random.default_rng(4).standard_normal(len(points))
    few = points.assign(mu=points["mu"] * (1 + noise))[points["P"] == 1.0]
    text = oilfilm.fit(*(few[name] for name in few), **QUICK).summary()
    assert "surface.fewest_curves" in text
    assert "1 GPa only" in text


@pytest.mark.slow
@pytest.mark.parametrize("seed", quick_ones([2, 3, 4], [2]))
def test_twelve_runs_with_scattered_loads_are_not_called_changed(seed: int) -> None:
    """As the tutorial's logs; each was called changed by a split into two kinds by chance."""
    random, law = np.random.default_rng(1000 + seed), known_law("4102")
    points, mu = [], []
    for condition in itertools.product((1.0, 1.5), (25.0, 40.0), (40.0, 70.0, 100.0)):
        slip = np.linspace(0, 0.3, 16)
        true_condition = condition[0] * (1 + random.normal(0, 0.005)), *condition[1:]
        load_n = 42.1 if condition[0] == 1 else 142.1
        noise = random.normal(0, 0.004, 16) / np.sqrt(150) / load_n
        mu.append(law.predict_at(*true_condition, slip).traction_coefficient + noise)
        points += [(*condition, slip_of_point) for slip_of_point in slip]
    fit = oilfilm.fit(*np.transpose(points), np.concatenate(mu), **QUICK)
    assert fit.soundness["campaign_verdict"] == "steady"


@pytest.mark.parametrize("missing", [None, float("nan"), ""])
def test_a_point_without_the_name_of_its_run_is_refused(
    points: pd.DataFrame, missing: object
) -> None:
    names = points.groupby(["P", "U", "T"], sort=False).ngroup().astype(object)
    names[7] = missing
    with pytest.raises(oilfilm.OilfilmError, match=r"names no run for 1 of 132 .* is number 8"):
        oilfilm.fit(*(points[name] for name in points), curve=names, **QUICK)


@pytest.mark.slow
def test_a_name_that_several_conditions_share_is_doubted(points: pd.DataFrame) -> None:
    with pytest.warns(UserWarning, match="2 of 2 curves have points at several conditions"):
        fit = oilfilm.fit(*(points[name] for name in points), curve=points["T"], **QUICK)
    assert any("these names do not mean runs" in note for note in fit.notes)


def test_a_level_that_the_next_run_does_not_have_is_told(fitted: ArrayFit) -> None:
    with pytest.warns(UserWarning, match=r"has the level 0.923, .* not 0.99"):
        fitted.predict(1.2, 30, 70, 0.05, level=0.99)


@pytest.mark.slow
@pytest.mark.parametrize("coldest_c", quick_ones([-10.0, 0.0, 0.5], [-10.0]))
def test_cold_tests_are_fitted_where_the_law_has_a_value(coldest_c: float) -> None:
    temperatures = coldest_c + np.array([0.0, 30.0, 70.0])
    grid = np.meshgrid([1.0, 1.25, 1.5], [25, 32, 40], temperatures, [0.01, 0.03, 0.1, 0.3])
    mu = 0.04 * np.exp(-0.01 * grid[2]) * np.tanh(grid[3] / 0.02)
    fit = oilfilm.fit(*grid, mu, law="deng-exponential", **QUICK)
    assert fit.law.coefficients.tested_box[2].tolist() == [temperatures[0], temperatures[-1]]
    prediction = fit.predict(1.25, 32, coldest_c, 0.03)
    assert not prediction.outside
    truth = 0.04 * np.exp(-0.01 * coldest_c) * np.tanh(0.03 / 0.02)
    assert float(prediction.obs_ci_lower) < truth < float(prediction.obs_ci_upper)


@pytest.mark.slow
def test_tests_at_one_temperature_below_zero_have_a_surface() -> None:
    grid = np.meshgrid([1.0, 1.25, 1.5], [25, 32, 40], [-10.0], [0.01, 0.03, 0.1, 0.3])
    mu = 0.04 * np.sqrt(grid[0]) * np.tanh(grid[3] / 0.02)
    fit = oilfilm.fit(*grid, mu, **QUICK)
    assert not fit.tables.surfaces.empty
    assert np.isfinite(fit.predict(1.25, 32, -10.0, 0.05).obs_ci_upper)
