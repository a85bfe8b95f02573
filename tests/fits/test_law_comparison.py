"""Laws compared: the true one wins, and curves left out are those of brute force."""

from dataclasses import replace

import numpy as np
import pytest

from fit_points import polished
from law_points import EVERY_LAW, MATRIX, TRUTH, compare_laws, internal_of, points_of
from nights import nightly
from oilfilm import tables
from oilfilm.fits import engine
from oilfilm.fits.conditions import levels_by_gap
from oilfilm.fits.fit import laws_of, leave_curves_out, leave_ends_out
from oilfilm.report.figures.fits import starts_of
from oilfilm.settings.resolved import Settings
from oilfilm.table_needs import OF_FIT
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAW_NAMES, LAWS
from oilfilm.traction.law import Observations
from pictures import draw

NOISE = 2e-4


@pytest.mark.no_cover
@pytest.mark.parametrize(
    "name", ["deng2026", nightly("eyring"), nightly("wang-deng-groups"), "tanh"]
)
def test_law_given_data_of_its_own_truth_wins(quick: Settings, name: str) -> None:
    laws = ["deng2026", "wang-deng-groups", "eyring", "tanh"]
    frames = compare_laws(points_of(EVERY_LAW[name], NOISE), "4050", laws, quick)
    table = frames.fit_quality.set_index("law")
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
    assert frames.fit_quality["n_points"].eq(len(points) * count // 48).all()


@pytest.mark.parametrize("groups", [100, 5])
def test_curves_left_out_are_those_of_brute_force(groups: int) -> None:
    """One at a time, and in groups of three or four."""
    law = LAWS["tanh"]
    points = points_of(law, 1e-3)
    few = points[points["run_id"].isin([f"run{number:03d}" for number in range(0, 48, 3)])]
    task, best = polished(few, TRUTH[law.name], law)
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
    points = points_of(LAWS["deng2026"])
    task, best = polished(points, TRUTH["deng2026"])
    levels = levels_by_gap(MATRIX["inlet_temperature_c"].to_numpy(), 0.05)
    errors = leave_ends_out(task, best, levels)
    ends = np.isin(levels[task.at.curve], [0, 3])
    assert np.isnan(errors[~ends]).all()
    # exact points of the law itself: nothing is missed, however far
    assert np.abs(errors[ends]).max() < 1e-7
    # the other levels of two, and those of one, leave a constant open
    two = MATRIX["max_hertz_pressure_gpa"].isin([1.0, 1.5]).to_numpy()
    task, best = polished(points[two[task.at.curve]], TRUTH["deng2026"])
    pressures = MATRIX.loc[two, "max_hertz_pressure_gpa"].to_numpy()
    for some in (levels_by_gap(pressures, 0.05), np.zeros(task.curves, dtype=np.int64)):
        assert np.isnan(leave_ends_out(task, best, some)).all()


def test_law_without_what_it_needs_is_not_fitted_with_the_reason(quick: Settings) -> None:
    config = Settings.of({**quick.plain(), "oils": {"4050": None}})
    laws = ["tanh", "wang-deng-groups"]
    frames = compare_laws(points_of(LAWS["tanh"], NOISE), "4050", laws, config)
    row = frames.fit_quality.set_index("law").loc["wang-deng-groups"]
    assert "needs the oil's properties" in row["certificate"]
    assert np.isnan(row["rmse"])
    assert set(frames.coefficients["law"]) == {"tanh"}
    assert "wang-deng-groups" not in laws_of("4050", config)


def test_comparison_without_any_accepted_point_still_gives_its_tables(quick: Settings) -> None:
    refused = points_of(LAWS["tanh"]).assign(accepted=False)
    frames = compare_laws(refused, "4050", LAW_NAMES, quick)
    verdicts = frames.fit_quality.set_index("law")["certificate"]
    assert verdicts.str.startswith("not fitted").all()
    assert "0 accepted points" in verdicts["deng2026"]
    for name in OF_FIT:
        tables.conform(frames.table(name), name, name)
    for name, words in (("fig04", "no Wang-Deng law could"), ("law-errors", "no law could")):
        figure, drawn = draw(name, frames, quick)
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
    return quick, compare_laws(points, "4050", ["deng2026", STARTS.name], quick)


STARTS = LAWS["wang-deng-load"]


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
    # mu(0) = D - |A| of each condition
    sizes = STARTS.sizes(
        internal_of(STARTS), STARTS.design(MATRIX[list(STARTS.conditions)].to_numpy())
    )
    np.testing.assert_allclose(np.sort(starts), np.sort(sizes[3] - sizes[0]), atol=3 * NOISE)


def test_fig04_shows_the_curve_whose_error_grows_most(
    starting: tuple[Settings, CampaignTables],
) -> None:
    config, results = starting
    _, drawn = draw("fig04", results, config)
    beside = results.law_points[results.law_points["law"] == STARTS.name]
    both = beside.merge(results.points, on=["run_id", "first_row"], suffixes=("", "_m"))
    of_run = both.set_index("run_id")
    squares = [
        (of_run[f"{left}traction_coefficient"] - of_run["traction_coefficient_m"]) ** 2
        for left in ("left_out_", "")
    ]
    unseen, seen = (np.sqrt(each.groupby("run_id").mean()) for each in squares)
    shown = drawn.loc[drawn["panel"] == "b", "words"]
    assert set(shown.str.rpartition("run ")[2]) == {(unseen - seen).idxmax()}


def test_points_beside_a_law_keep_the_direction_of_their_slip(
    starting: tuple[Settings, CampaignTables],
) -> None:
    _, results = starting
    both = results.law_points.merge(results.points, on=["run_id", "first_row"], suffixes=("", "_m"))
    assert len(both) == 2 * len(results.points)
    true = both[both["law"] == STARTS.name]
    for column in ("traction_coefficient", "left_out_traction_coefficient"):
        np.testing.assert_allclose(true[column], true["traction_coefficient_m"], atol=6 * NOISE)


def test_bounds_of_the_comparison_are_those_of_the_constants(quick: Settings) -> None:
    laws = ["tanh", "eyring", "carreau"]
    frames = compare_laws(points_of(LAWS["tanh"], NOISE), "4050", laws, quick)
    constants = frames.coefficients
    held = constants[constants["verdict"] == "at a bound"].groupby("law")["constant"].apply(set)
    for row in tables.rows(frames.fit_quality):
        names = set(filter(None, row["active_bounds"].split(", ")))
        assert names == held.get(row["law"], set())
        assert not (names and row["certified"])
    assert len(held)
