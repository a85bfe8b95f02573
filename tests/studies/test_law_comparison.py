"""Laws compared: the true one wins, and curves left out are those of brute force."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from campaigns import ROOT
from law_points import EVERY_LAW, MATRIX, internal_of, points_of
from oilfilm import tables
from oilfilm.fitting import engine
from oilfilm.fitting.cross_validation import leave_curves_out, leave_ends_out, level_of
from oilfilm.fitting.engine import Optimum
from oilfilm.fitting.problem import Problem, build_problem, curve_data
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.studies.law_comparison import compare_laws, curve_shapes, information_criteria, laws_of
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS
from oilfilm.traction.law import Law, Observations
from pictures import draw

NOISE = 2e-4


@pytest.fixture(scope="module")
def quick(config: Settings) -> Settings:
    return config.with_changes({"fit": {"searches": 2}, "compare": {"bootstrap": 5}})


def fitted(law: Law, points: pd.DataFrame) -> tuple[Problem, Optimum]:
    data = curve_data(points, law.conditions)
    task = build_problem(law, data, np.ones(3, dtype=bool))
    return task, engine.polish(task, internal_of(law)[task.free])


@pytest.mark.parametrize("name", ["deng2026", "eyring", "wang-deng-groups", "tanh"])
def test_law_given_data_of_its_own_truth_wins(quick: Settings, name: str) -> None:
    only = ["deng2026", "wang-deng-groups", "eyring", "tanh"]
    config = quick.with_changes({"compare": {"laws": only}})
    frames = compare_laws(points_of(EVERY_LAW[name], NOISE), "4050", config)
    table = frames["comparison"].set_index("law")
    assert table["left_out_rmse"].idxmin() == name
    assert table["bic"].idxmin() == name
    assert table["temperature_end_out_relative_rms"].idxmin() == name
    # what is left of the errors is the noise
    assert table.at[name, "rmse"] == pytest.approx(NOISE, rel=0.05)
    assert table["n_points"].nunique() == 1


def test_curves_left_out_are_those_of_brute_force() -> None:
    law = LAWS["tanh"]
    points = points_of(law, 1e-3)
    few = points[points["run_id"].isin([f"run{number:03d}" for number in range(0, 48, 3)])]
    task, best = fitted(law, few)
    errors = leave_curves_out(task, best)
    for curve in range(task.curves):
        mine = task.at.curve == curve
        rows = np.delete(np.arange(task.curves), curve)
        kept = task.at.curve[~mine]
        others = replace(
            task,
            at=Observations(task.at.design[rows], kept - (kept > curve), task.at.slip[~mine]),
            mu=task.mu[~mine],
        )
        end = engine.polish(others, best.values)
        expected = task.residual(end.values)[mine]
        np.testing.assert_allclose(errors[mine], expected, rtol=1e-3, atol=1e-8)


def test_only_the_end_levels_are_extrapolated_to() -> None:
    law = LAWS["deng2026"]
    task, best = fitted(law, points_of(law))
    levels = level_of(MATRIX["inlet_temperature_c"].to_numpy(), 0.05)
    errors = leave_ends_out(task, best, levels)
    ends = np.isin(levels[task.at.curve], [0, 3])
    assert np.isnan(errors[~ends]).all()
    # exact points of the law itself: nothing is missed, however far
    assert np.abs(errors[ends]).max() < 1e-7


def test_end_levels_that_leave_a_constant_open_give_no_error() -> None:
    law = LAWS["deng2026"]
    points = points_of(law)
    task, best = fitted(law, points[points["max_hertz_pressure_gpa"].isin([1.0, 1.5])])
    pressure = MATRIX.loc[MATRIX["max_hertz_pressure_gpa"].isin([1.0, 1.5])].iloc[:, 0]
    assert np.isnan(leave_ends_out(task, best, level_of(pressure.to_numpy(), 0.05))).all()
    one_level = np.zeros(task.curves, dtype=np.int64)
    assert np.isnan(leave_ends_out(task, best, one_level)).all()


def test_information_criteria_are_the_formulas() -> None:
    # Burnham and Anderson (2002), 2.2: K counts the variance too
    aic, bic = information_criteria(2e-3, 50, 4)
    assert aic == pytest.approx(50 * np.log(2e-3 / 50) + 2 * 5)
    assert bic == pytest.approx(50 * np.log(2e-3 / 50) + 5 * np.log(50))
    assert np.isnan(information_criteria(0.0, 50, 4)).all()


def test_curves_that_dip_or_rise_again_are_counted() -> None:
    slip = np.linspace(0, 1, 101)
    peak, rise = slip * np.exp(-5 * slip), slip
    again = peak + 0.5 * np.where(slip > 0.8, slip - 0.8, 0)
    below = peak - 0.01 * (slip < 0.005)  # one of 101 points, the first
    negative, second = curve_shapes(np.stack([peak, rise, again, below]))
    assert negative == pytest.approx(1 / 404)
    assert second == pytest.approx(1 / 4)


def test_law_without_what_it_needs_is_not_fitted_with_the_reason(quick: Settings) -> None:
    laws = {"compare": {"laws": ["tanh", "wang-deng-groups"]}}
    config = Settings.of({**quick.with_changes(laws).plain(), "oils": {"4050": None}})
    frames = compare_laws(points_of(LAWS["tanh"], NOISE), "4050", config)
    row = frames["comparison"].set_index("law").loc["wang-deng-groups"]
    assert "needs the oil's properties" in row["certificate"]
    assert np.isnan(row["rmse"])
    assert set(frames["law_coefficients"]["law"]) == {"tanh"}
    assert "wang-deng-groups" not in laws_of("4050", config)


def test_comparison_without_any_accepted_point_still_gives_its_tables(
    quick: Settings,
) -> None:
    refused = points_of(LAWS["tanh"]).assign(accepted=False)
    frames = compare_laws(refused, "4050", quick)
    verdicts = frames["comparison"].set_index("law")["certificate"]
    assert verdicts.str.startswith("not fitted").all()
    assert "0 accepted points" in verdicts["deng2026"]
    for name, table in frames.items():
        tables.conform(table, name, name)
    results = CampaignTables.in_memory(points=refused, **frames)
    figure, drawn = draw("fig04", results, quick)
    assert drawn.empty
    assert "no law could be fitted" in figure.axes[0].texts[0].get_text()


def test_fig04_draws_what_the_table_says(quick: Settings) -> None:
    truth = LAWS["wang-deng-load"]
    config = quick.with_changes({"compare": {"laws": ["deng2026", truth.name]}})
    points = points_of(truth, NOISE)
    frames = compare_laws(points, "4050", config)
    results = CampaignTables.in_memory(points=points, **frames)
    figure, drawn = draw("fig04", results, config)
    assert "SIMULATED" in " ".join(text.get_text() for text in figure.texts)
    starts = drawn[drawn["kind"] == "zero slip"]
    assert set(starts["law"]) == {truth.name}
    # planted: mu(0) = D - |A|
    sizes = truth.sizes(internal_of(truth), truth.design(MATRIX[list(truth.conditions)].to_numpy()))
    expected = np.sort(sizes[3] - sizes[0])
    np.testing.assert_allclose(np.sort(starts["y"]), expected, atol=3 * NOISE)
    errors = drawn[(drawn["law"] == "deng2026") & (drawn["kind"] == "fitted curves")]
    row = frames["comparison"].set_index("law").loc["deng2026"]
    assert errors["x"].item() == pytest.approx(row["relative_rms"])


def test_comparison_of_the_project_names_every_oil_and_rig() -> None:
    config = resolve(ROOT / "config", {})
    for oil in config.oils:
        assert "wang-deng-groups" in laws_of(oil, config)
