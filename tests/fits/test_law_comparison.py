"""Laws compared: the true one wins, and curves left out are those of brute force."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from law_points import EVERY_LAW, MATRIX, internal_of, points_of
from nights import nightly
from oilfilm import tables
from oilfilm.fits import engine
from oilfilm.fits.conditions import levels_by_gap
from oilfilm.fits.engine import Optimum
from oilfilm.fits.fit import leave_curves_out, leave_ends_out
from oilfilm.fits.fit_tables import curve_shapes
from oilfilm.fits.law_comparison import compare_laws, laws_of
from oilfilm.fits.problem import Problem, build_problem, curve_data
from oilfilm.report.figures import style
from oilfilm.report.figures.fits import starts_of
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAW_NAMES, LAWS
from oilfilm.traction.law import Law, Observations
from oilfilm.units import FloatArray
from pictures import draw

NOISE = 2e-4


@pytest.fixture(scope="module")
def quick(config: Settings) -> Settings:
    return config.with_changes({"fit": {"searches": 2, "bootstrap": 20}})


def fitted(law: Law, points: pd.DataFrame) -> tuple[Problem, Optimum]:
    data = curve_data(points, law.conditions)
    task = build_problem(law, data, np.ones(3, dtype=bool))
    return task, engine.polish(task, internal_of(law)[task.free])


@pytest.mark.no_cover
@pytest.mark.parametrize(
    "name", ["deng2026", nightly("eyring"), nightly("wang-deng-groups"), "tanh"]
)
def test_law_given_data_of_its_own_truth_wins(quick: Settings, name: str) -> None:
    laws = ["deng2026", "wang-deng-groups", "eyring", "tanh"]
    frames = compare_laws(points_of(EVERY_LAW[name], NOISE), "4050", laws, quick)
    table = frames["fit_quality"].set_index("law")
    assert table["left_out_rmse"].idxmin() == name
    assert table["bic"].idxmin() == name
    assert table["temperature_end_out_relative_rms"].idxmin() == name
    # what is left of the errors is the noise
    assert table.at[name, "rmse"] == pytest.approx(NOISE, rel=0.05)
    assert table["n_points"].nunique() == 1


@pytest.mark.parametrize(
    ("count", "step"),
    [(1, 1), (2, 16), *(nightly(*case) for case in ((1, 16), (2, 1), (3, 1), (3, 16)))],
)
def test_few_curves_are_compared_without_a_mistake(quick: Settings, count: int, step: int) -> None:
    """Neighbouring and distant conditions: some laws then have constants without any effect."""
    runs = [f"run{step * number:03d}" for number in range(count)]
    points = points_of(EVERY_LAW["deng2026"], NOISE)
    frames = compare_laws(points[points["run_id"].isin(runs)], "4050", LAW_NAMES, quick)
    assert frames["fit_quality"]["n_points"].eq(len(points) * count // 48).all()


@pytest.mark.parametrize("groups", [100, 5])
def test_curves_left_out_are_those_of_brute_force(groups: int) -> None:
    """One at a time, and in groups of three or four."""
    law = LAWS["tanh"]
    points = points_of(law, 1e-3)
    few = points[points["run_id"].isin([f"run{number:03d}" for number in range(0, 48, 3)])]
    task, best = fitted(law, few)
    errors = leave_curves_out(task, best, groups, np.random.default_rng(1))
    group = np.arange(task.curves)
    if groups < task.curves:
        group = np.random.default_rng(1).permutation(group) % groups
    for each in np.unique(group):
        mine = (group == each)[task.at.curve]
        rows = np.flatnonzero(group != each)
        others = replace(
            task,
            at=Observations(
                task.at.design[rows],
                np.searchsorted(rows, task.at.curve[~mine]),
                task.at.slip[~mine],
            ),
            mu=task.mu[~mine],
        )
        end = engine.polish(others, best.values)
        expected = task.residual(end.values)[mine]
        np.testing.assert_allclose(errors[mine], expected, rtol=1e-3, atol=1e-8)


def test_only_the_end_levels_are_extrapolated_to() -> None:
    law = LAWS["deng2026"]
    task, best = fitted(law, points_of(law))
    levels = levels_by_gap(MATRIX["inlet_temperature_c"].to_numpy(), 0.05)
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
    assert np.isnan(leave_ends_out(task, best, levels_by_gap(pressure.to_numpy(), 0.05))).all()
    one_level = np.zeros(task.curves, dtype=np.int64)
    assert np.isnan(leave_ends_out(task, best, one_level)).all()


def test_curves_that_dip_or_rise_again_are_counted() -> None:
    slip = np.linspace(0, 1, 101)
    peak, rise = slip * np.exp(-5 * slip), slip
    again = peak + 0.5 * np.where(slip > 0.8, slip - 0.8, 0)
    below = peak - 0.01 * (slip < 0.005)  # one of 101 points, the first
    negative, second = curve_shapes(np.stack([peak, rise, again, below]))
    assert negative == pytest.approx(1 / 404)
    assert second == pytest.approx(1 / 4)


def test_law_without_what_it_needs_is_not_fitted_with_the_reason(quick: Settings) -> None:
    config = Settings.of({**quick.plain(), "oils": {"4050": None}})
    laws = ["tanh", "wang-deng-groups"]
    frames = compare_laws(points_of(LAWS["tanh"], NOISE), "4050", laws, config)
    row = frames["fit_quality"].set_index("law").loc["wang-deng-groups"]
    assert "needs the oil's properties" in row["certificate"]
    assert np.isnan(row["rmse"])
    assert set(frames["coefficients"]["law"]) == {"tanh"}
    assert "wang-deng-groups" not in laws_of("4050", config)


def test_comparison_without_any_accepted_point_still_gives_its_tables(
    quick: Settings,
) -> None:
    refused = points_of(LAWS["tanh"]).assign(accepted=False)
    frames = compare_laws(refused, "4050", LAW_NAMES, quick)
    verdicts = frames["fit_quality"].set_index("law")["certificate"]
    assert verdicts.str.startswith("not fitted").all()
    assert "0 accepted points" in verdicts["deng2026"]
    for name, table in frames.items():
        tables.conform(table, name, name)
    results = CampaignTables.in_memory(points=refused, **frames)
    for name, words in (("fig04", "no Wang-Deng law could"), ("law-errors", "no law could")):
        figure, drawn = draw(name, results, quick)
        assert drawn.empty
        assert words in figure.axes[0].texts[0].get_text()


@pytest.fixture(scope="module")
def starting(quick: Settings) -> tuple[Settings, CampaignTables]:
    """Points of a Wang-Deng law with traction at no slip; every other curve slips backwards."""
    points = points_of(STARTS, NOISE)
    back = points["run_id"].isin(sorted(points["run_id"].unique())[::2])
    both = ["slide_roll_ratio", "traction_coefficient"]
    # at no slip there is no direction
    points.loc[back & (points["slide_roll_ratio"] > 0), both] *= -1
    made = compare_laws(points, "4050", ["deng2026", STARTS.name], quick)
    return quick, CampaignTables.in_memory(points=points, **made)


STARTS = LAWS["wang-deng-load"]


def planted_starts() -> FloatArray:
    """mu(0) = D - |A| of each condition."""
    levels = MATRIX[list(STARTS.conditions)].to_numpy()
    sizes = STARTS.sizes(internal_of(STARTS), STARTS.design(levels))
    return np.asarray(sizes[3] - sizes[0])


def test_figure_of_errors_draws_what_the_table_says(
    starting: tuple[Settings, CampaignTables],
) -> None:
    config, results = starting
    figure, drawn = draw("law-errors", results, config)
    assert "SIMULATED" in " ".join(text.get_text() for text in figure.texts)
    ticks = [label.get_text() for label in figure.axes[0].get_yticklabels()]
    assert "load-based Wang-Deng" in ticks  # by its name, as everywhere
    errors = drawn[(drawn["words"] == "deng2026") & (drawn["series"] == "fitted curves")]
    row = results.fit_quality.set_index("law").loc["deng2026"]
    assert errors["x"].item() == pytest.approx(row["relative_rms"])


def test_traction_without_slip_is_the_planted_one(
    starting: tuple[Settings, CampaignTables],
) -> None:
    config, results = starting
    starts = starts_of(results, "4050", STARTS.name, config)["y"]
    np.testing.assert_allclose(np.sort(starts), np.sort(planted_starts()), atol=3 * NOISE)


def test_fig04_shows_the_curve_whose_error_grows_most_by_brute_force(
    starting: tuple[Settings, CampaignTables],
) -> None:
    config, results = starting
    _, drawn = draw("fig04", results, config)
    task, best = fitted(STARTS, results.points)
    seen = task.residual(best.values)
    growth = []
    for curve in range(task.curves):
        mine = task.at.curve == curve
        rows = np.delete(np.arange(task.curves), curve)
        kept = task.at.curve[~mine]
        at = Observations(task.at.design[rows], kept - (kept > curve), task.at.slip[~mine])
        end = engine.polish(replace(task, at=at, mu=task.mu[~mine]), best.values)
        unseen = task.residual(end.values)[mine]
        growth.append(np.sqrt(np.mean(unseen**2)) - np.sqrt(np.mean(seen[mine] ** 2)))
    worst = int(np.argmax(growth))
    shown = drawn.loc[drawn["panel"] == "b", "words"]
    assert set(shown.str.rpartition("run ")[2]) == {f"run{worst:03d}"}


def test_points_beside_a_law_keep_the_direction_of_their_slip(
    starting: tuple[Settings, CampaignTables],
) -> None:
    _, results = starting
    both = results.law_points.merge(results.points, on=["run_id", "first_row"], suffixes=("", "_m"))
    assert len(both) == 2 * len(results.points)
    true = both[both["law"] == STARTS.name]
    for column in ("traction_coefficient", "left_out_traction_coefficient"):
        np.testing.assert_allclose(true[column], true["traction_coefficient_m"], atol=6 * NOISE)


def test_fit_that_is_not_certified_has_an_open_symbol(
    starting: tuple[Settings, CampaignTables],
) -> None:
    config, results = starting
    for certified, face in ((False, "white"), (True, style.oil_colour("4050", ["4050"]))):
        table = results.fit_quality.assign(certified=certified)
        one_oil = Settings.of({**config.plain(), "oils": {"4050": config.plain()["oils"]["4050"]}})
        figure, _ = draw("fig04", results.replace(fit_quality=table), one_oil)
        assert figure.legends[0].legend_handles[0].get_markerfacecolor() == face
        figure, _ = draw("law-errors", results.replace(fit_quality=table), one_oil)
        symbols = [line for line in figure.axes[0].get_lines() if line.get_linestyle() == "None"]
        assert {symbol.get_markerfacecolor() for symbol in symbols} == {face}


def test_bounds_of_the_comparison_are_those_of_the_constants(quick: Settings) -> None:
    laws = ["tanh", "eyring", "carreau"]
    frames = compare_laws(points_of(LAWS["tanh"], NOISE), "4050", laws, quick)
    constants = frames["coefficients"]
    held = constants[constants["verdict"] == "at a bound"].groupby("law")["constant"].apply(set)
    for row in tables.rows(frames["fit_quality"]):
        names = set(filter(None, row["active_bounds"].split(", ")))
        assert names == held.get(row["law"], set())
        assert not (names and row["certified"])
    assert len(held)
