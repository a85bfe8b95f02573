"""Repeats part the residuals into noise and lack of fit."""

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from campaigns import rows
from oilfilm.base.randomness import generator
from oilfilm.fits.conditions import condition_level_numbers
from oilfilm.fits.soundness import lack_of_fit, lack_of_fit_table
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables


def test_published_example_of_the_lack_of_fit_test() -> None:
    # Neter, Kutner, Nachtsheim, Wasserman (1996), section 3.7: docs/physics.md, Fitting
    deposit = np.array([125, 100, 200, 75, 150, 175, 75, 175, 125, 200, 100.0])
    accounts = np.array([160, 112, 124, 28, 152, 156, 42, 124, 150, 104, 136.0])
    slope, intercept = np.polyfit(deposit, accounts, 1)
    residual = intercept + slope * deposit - accounts
    _, level = np.unique(deposit, return_inverse=True)
    branch, nowhere = np.arange(11), np.zeros(11, dtype=np.int64)
    parts = lack_of_fit(residual, branch, level, nowhere, constant_count=2)
    assert (parts.repeat_count, parts.repeated_condition_count) == (5, 5)
    assert parts.noise**2 == pytest.approx(1148.0 / 5)
    assert parts.ratio == pytest.approx(14.80, abs=0.005)
    assert parts.limit == pytest.approx(stats.f.ppf(0.95, 4, 5))
    assert parts.is_shown


def test_published_example_without_lack_of_fit() -> None:
    # cars of mtcars by cylinders; sums of squares of olsrr: docs/physics.md, Fitting
    by_cylinders = {
        4: [22.8, 24.4, 22.8, 32.4, 30.4, 33.9, 21.5, 27.3, 26.0, 30.4, 21.4],
        6: [21.0, 21.0, 21.4, 18.1, 19.2, 17.8, 19.7],
        8: [18.7, 14.3, 16.4, 17.3, 15.2, 10.4, 10.4, 14.7, 15.5, 15.2, 13.3, 19.2, 15.8, 15.0],
    }
    cylinders = np.repeat(list(by_cylinders), [len(cars) for cars in by_cylinders.values()])
    miles = np.concatenate(list(by_cylinders.values()))
    slope, intercept = np.polyfit(cylinders, miles, 1)
    residual = intercept + slope * cylinders - miles
    cars = np.arange(len(miles))
    parts = lack_of_fit(residual, cars, cylinders, np.zeros_like(cars), constant_count=2)
    assert parts.noise**2 == pytest.approx(301.26 / 29, abs=0.005 / 29)
    assert parts.ratio == pytest.approx(7.07 / (301.26 / 29), rel=0.001)
    assert not parts.is_shown


def planted(form: float, repeats: int, draw: int) -> tuple[np.ndarray, ...]:
    """Residuals with noise of points and of runs, and a wave that the law has not."""
    random = generator(11, "lack of fit", str(draw))
    conditions, slips = 40, 25
    condition = np.concatenate([np.arange(conditions), np.arange(repeats)])
    run = np.repeat(np.arange(len(condition)), slips)
    slip = np.tile(np.arange(slips), len(condition))
    wave = form * np.sqrt(2) * np.sin(2 * np.pi * slip / slips)
    shared = 3e-4 * random.standard_normal(len(condition))[run]
    noise = 4e-4 * random.standard_normal(len(run))
    return wave + shared + noise, run, condition[run], slip


def test_an_exact_fit_lacks_nothing_and_copies_have_no_scatter() -> None:
    run, condition = np.repeat(np.arange(6), 4), np.repeat([0, 0, 1, 1, 2, 2], 4)
    slip = np.tile(np.arange(4), 6)
    exact = lack_of_fit(np.zeros(24), run, condition, slip, constant_count=2)
    assert (exact.noise, exact.form_rms, exact.ratio) == (0.0, 0.0, 0.0)
    assert not exact.is_shown
    # each value of a condition and a slip comes once in a run and three times in its copy
    values = np.random.default_rng(5).standard_normal((200, 3, 1, 4))
    for draw in values:
        first, copy = draw.ravel(), np.tile(draw, (1, 3, 1)).ravel()
        copied = lack_of_fit(
            np.concatenate([first, copy]),
            np.concatenate([np.repeat([0, 1, 2], 4), np.repeat([3, 4, 5], 12)]),
            np.concatenate([np.repeat([0, 1, 2], 4), np.repeat([0, 1, 2], 12)]),
            np.concatenate([np.tile(np.arange(4), 3), np.tile(np.arange(4), 9)]),
            constant_count=2,
        )
        assert copied.noise < 1e-6
        assert copied.is_shown


def test_planted_noise_and_planted_wrong_form_are_found_apart() -> None:
    parts = lack_of_fit(*planted(1.2e-3, 20, draw=0), constant_count=1)
    assert parts.repeat_count == parts.repeated_condition_count == 20
    # noise of runs and of points together, sqrt(3^2 + 4^2)
    assert parts.noise == pytest.approx(5e-4, rel=0.12)
    assert parts.form_rms == pytest.approx(1.2e-3, rel=0.03)
    assert parts.is_shown


def test_noise_alone_is_rarely_called_lack_of_fit() -> None:
    # errors that points of a run share would fool the classical test in far more than 5 %
    called = [lack_of_fit(*planted(0.0, 8, draw), constant_count=1).is_shown for draw in range(100)]
    assert np.mean(called) <= 0.08


def test_points_of_one_run_are_no_repeats_of_each_other() -> None:
    parts = lack_of_fit(*planted(1e-3, 0, draw=0), constant_count=1)
    assert parts.repeat_count == 0
    assert np.isnan([parts.noise, parts.form_rms, parts.ratio]).all()
    assert not parts.is_shown


def test_both_branches_of_a_sweep_do_not_hide_the_error_of_the_run() -> None:
    # each run has its own constant error only, read twice at each slip
    error = np.array([1.0, -1.0])
    run = np.repeat([0, 1], 10)
    slip = np.tile(np.repeat(np.arange(5), 2), 2)
    parts = lack_of_fit(error[run], run, np.zeros(20, dtype=np.int64), slip, constant_count=1)
    assert parts.noise == pytest.approx(np.std(error, ddof=1))


@pytest.mark.parametrize(("range_c", "levels"), [(4.0, [1, 1, 2]), (2.0, [1, 2, 3])])
def test_runs_have_one_condition_within_the_range_that_the_settings_give(
    config: Settings, range_c: float, levels: list[int]
) -> None:
    same = config.same_condition.model_copy(update={"inlet_temperature_c": range_c})
    temperatures = np.array([50.0, 53.0, 56.0])
    assert condition_level_numbers("inlet_temperature_c", temperatures, same).tolist() == levels


def test_a_set_temperature_below_0_is_no_level_of_a_measured_one(config: Settings) -> None:
    # two runs state -3 degC, the number that stood for the second level of measured temperatures;
    # two runs state none
    names, set_c = ["cold-1", "cold-2", "hot-1", "hot-2"], [-3.0, -3.0, np.nan, np.nan]
    runs = [
        {"run_id": name, "oil": "4102", "rig": "rig", "nominal_inlet_temperature_c": level}
        for name, level in zip(names, set_c, strict=True)
    ]
    slip = np.array([0.01, 0.02, 0.05, 0.1, 0.2])
    points = pd.DataFrame(
        {
            "run_id": np.repeat(names, len(slip)),
            "inlet_temperature_c": np.repeat([-3.0, -3.0, 60.0, 60.0], len(slip)),
            "slide_roll_ratio": np.tile(slip, len(names)),
        }
    ).assign(max_hertz_pressure_gpa=1.0, load_n=50.0, entrainment_speed_m_s=30.0)
    points["traction_coefficient"] = 0.05 * np.tanh(points["slide_roll_ratio"] / 0.03)
    # constants without exponents
    constants = {"A0": -0.01567792, "B0": 0.63482685, "C0": 24.43483717}
    coefficients = [
        {"oil": "4102", "law": "deng2026", "constant": name, "value": value}
        for name, value in constants.items()
    ]
    quality = {"oil": "4102", "law": "deng2026", "configured": True, "rmse": 1e-3}
    results = CampaignTables.from_frames(
        runs=rows("runs", *runs),
        points=points.assign(oil="4102", accepted=True, traction_coefficient_se=np.nan),
        coefficients=rows("coefficients", *coefficients),
        fit_quality=rows("fit_quality", quality),
    )
    (lack,) = lack_of_fit_table(results, config).to_dict("records")
    assert (lack["n_repeats"], lack["n_repeated_conditions"]) == (2, 2)
