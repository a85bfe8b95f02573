"""Figures draw exactly what their tables hold, and a broken picture is seen."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes

from drawn_results import with_refits
from fit_points import matrix
from nights import nightly, quick_ones
from oilfilm.report.figures import bearing, curves
from oilfilm.report.figures.sheet import Sheet, table_page
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import CONDITIONS
from pictures import (
    Draw,
    difference_from,
    draw,
    drawing_of,
    is_as_wide_as_a_column,
    nothing_is_cut_off,
    settings_of_oils,
)
from reports import rows

BASELINE = Path(__file__).parent / "baseline"


@pytest.fixture(scope="module")
def results() -> CampaignTables:
    return with_refits()


@pytest.fixture(scope="module")
def drawing(results: CampaignTables, config: Settings) -> Draw:
    return drawing_of(results, config)


@pytest.fixture(scope="module")
def usual(drawing: Draw) -> Draw:
    """Each figure as it usually is, drawn once for all tests that only look at it."""
    return cache(drawing)


def lines(axis: Axes) -> set[bytes]:
    """What each line of a panel holds, in bytes that can be compared exactly."""
    return {
        np.ascontiguousarray(line.get_xydata(), float).tobytes()
        for line in axis.get_lines()
        if line.get_gid() != "scale"
    }


def bytes_of(*columns: Any) -> bytes:
    return np.column_stack(columns).astype(float).tobytes()


@pytest.mark.slow
def test_residuals_show_what_is_planted(drawing: Draw, results: CampaignTables) -> None:
    _, drawn = drawing("residuals")
    assert drawn["y"].abs().max() < 1e-9
    hot = (results.points["oil"] == "4050") & (results.points["inlet_temperature_c"] == 120)
    mu = results.points["traction_coefficient"] + 1e-3 * hot
    figure, drawn = drawing("residuals", points=results.points.assign(traction_coefficient=mu))
    means = drawn.query("panel == 'g' and series == 'mean'")  # 4050 by temperature
    np.testing.assert_allclose(means["y"], [0, 0, 0, 0, 0, 1], atol=1e-9)  # thousandths
    for letter, axis in zip("abcdefghijkl", figure.axes, strict=True):
        points = drawn[(drawn["panel"] == letter) & (drawn["series"] == "point")]
        assert bytes_of(points["x"], points["y"]) in lines(axis)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "panels"), [("curves", "abc"), nightly("residuals", "aei")])
def test_points_of_some_runs_are_drawn_and_the_legend_says_so(
    drawing: Draw, results: CampaignTables, monkeypatch: pytest.MonkeyPatch, name: str, panels: str
) -> None:
    monkeypatch.setattr(curves, "_MOST_POINTS_TOLD_APART", 100)
    _, all_drawn = drawing(name)
    monkeypatch.setattr(curves, "_MOST_RUNS_DRAWN", 10)
    figure, drawn = drawing(name)
    own = {"curves": "measured", "residuals": "point"}[name]
    points_of_run = len(results.points) // results.points["run_id"].nunique()
    for panel in panels:
        is_point = (drawn["panel"] == panel) & (drawn["series"] == own)
        assert is_point.sum() == 10 * points_of_run
    # what is stated of all points is that of all
    pd.testing.assert_frame_equal(
        drawn[drawn["series"] != own].reset_index(drop=True),
        all_drawn[all_drawn["series"] != own].reset_index(drop=True),
    )
    legends = [axis.get_legend() for axis in figure.axes if axis.get_legend()] + figure.legends
    words = " ".join(text.get_text() for legend in legends for text in legend.get_texts())
    assert {"curves": f"({10 * points_of_run} of", "residuals": "at most 10 runs"}[name] in words


@pytest.mark.parametrize(
    ("calculated", "ends"),
    # 15 % more room than 20 %, or than the largest error
    [([np.nan, np.nan], (-23.0, 23.0)), ([1.4, np.nan], (-23.0, 46.0))],
)
def test_torque_without_equilibrium_leaves_the_axis_of_errors(
    calculated: list[float], ends: tuple[float, float]
) -> None:
    torque = pd.DataFrame({"measured_torque_n_m": [1.0, 1.0], "torque_n_m_lower": calculated})
    torque["relative_error"] = torque["torque_n_m_lower"] - 1
    assert bearing._limits_of_error_axis(torque) == pytest.approx(ends)


def test_one_measured_pressure_is_a_level() -> None:
    points = pd.DataFrame({"max_hertz_pressure_gpa": [1.2] * 20})
    levels = curves._levels_of_points(points, "max_hertz_pressure_gpa")
    assert points.groupby(levels, observed=True).size().to_dict() == {1.2: 20}


@pytest.mark.slow
def test_residuals_of_reversed_slip_keep_their_sign(drawing: Draw, results: CampaignTables) -> None:
    high = results.points.query("slide_roll_ratio > 0").copy()
    high["traction_coefficient"] += 1e-3
    other_way = high.copy()
    other_way[["slide_roll_ratio", "traction_coefficient"]] *= -1
    forward, reverse = (drawing("residuals", points=points)[1] for points in (high, other_way))
    np.testing.assert_allclose(forward["y"], reverse["y"])


def test_identifiability_draws_every_pair(usual: Draw) -> None:
    figure, drawn = usual("identifiability")
    pairs = drawn.query("oil == '4102'")
    squares = np.asarray(figure.axes[0].images[0].get_array().filled(np.nan))
    assert sorted(squares[~np.isnan(squares)]) == sorted(pairs["value"])
    assert len(pairs) == 12 * 11 / 2


DRAWN_HERE = ["curves", "constants", "residuals", "identifiability", "friction-map", "stribeck"]


# Pictures that between them have every kind of mark: patches, words, lines, bands, bars, an image.
PICTURES = ["curves", "identifiability"]


@pytest.mark.slow
@pytest.mark.no_cover
@pytest.mark.parametrize("oils", [["4102", "4050", "4010"], nightly(["4102"])])
@pytest.mark.parametrize("name", quick_ones(DRAWN_HERE, PICTURES))
def test_figures_are_as_wide_as_a_column_and_nothing_is_cut_off(
    drawing: Draw, config: Settings, tmp_path: Path, name: str, oils: list[str]
) -> None:
    figure, _ = drawing(name, settings_of_oils(config, oils))
    assert nothing_is_cut_off(figure)
    # all else is in the caption
    assert not figure.texts
    assert is_as_wide_as_a_column(figure, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", PICTURES)
def test_pictures_look_as_they_did(drawing: Draw, tmp_path: Path, name: str) -> None:
    message = difference_from(BASELINE / f"{name}.png", drawing(name)[0], tmp_path)
    assert message is None


@pytest.mark.slow
def test_figure_of_simulated_data_says_so(drawing: Draw, config: Settings) -> None:
    simulated = {"data": "simulated", "simulated_by": "a program"}
    figure, _ = drawing("curves", config.with_changes({"campaign": simulated}))
    assert [text.get_text() for text in figure.texts] == ["SIMULATED"]


def test_panel_keeps_what_it_draws() -> None:
    panel = Sheet().panel(title="one")
    x, y = np.arange(3.0), np.array([1.0, 4.0, 9.0])
    panel.line("line", x, y, {"color": "black"}, oil="4102", lower=y - 1, upper=y + 2)
    panel.dots("dots", x, 2 * y, {"marker": "o"}, lower=y, upper=4 * y)
    for part, line in zip(panel.drawn_parts, panel.axes.get_lines(), strict=False):
        np.testing.assert_array_equal(line.get_xydata(), np.column_stack([part["x"], part["y"]]))
    band, bars = panel.axes.collections
    for part, edges in ((panel.drawn_parts[0], band), (panel.drawn_parts[1], bars)):
        vertices = np.concatenate([path.vertices for path in edges.get_paths()])
        for end in ("y_lower", "y_upper"):
            assert {*zip(part["x"], part[end], strict=True)} <= {*map(tuple, vertices)}
    assert set(panel.drawn_parts[0]["oil"]) == {"4102"}
    assert set(panel.drawn_parts[0]["panel"]) == {"a"}


@pytest.mark.parametrize(
    ("name", "sentence"),
    [("curves", "no accepted point"), ("stribeck", "give the properties of the oil")],
)
def test_no_data_are_told(drawing: Draw, results: CampaignTables, name: str, sentence: str) -> None:
    figure, drawn = drawing(name, points=results.points.assign(accepted=False, lambda_ratio=1.0))
    assert drawn.empty
    assert sentence in figure.axes[0].texts[0].get_text()
    assert nothing_is_cut_off(figure)


def test_note_of_constants_names_only_what_has_an_exponent(
    config: Settings, results: CampaignTables
) -> None:
    def note(coefficients: pd.DataFrame) -> str:
        figure, _ = draw("constants", results.replace(coefficients=coefficients), config)
        (text,) = (each.get_text() for each in figure.axes[0].texts if "Eq. 7" in each.get_text())
        return " ".join(text.split())

    fitted = results.coefficients
    assert "P over 1 GPa, U over 20 m/s, T over 20 degC" in note(fitted)
    of_speed = fitted[fitted["constant"].str.contains("[02]$")]
    assert note(of_speed).endswith(": U over 20 m/s")


def test_runs_without_set_points_are_shown_by_their_measured_means(config: Settings) -> None:
    points = rows(
        "points",
        *(
            {
                "oil": "4102",
                "run_id": run,
                "entrainment_speed_m_s": speed,
                "inlet_temperature_c": 70.0,
                "accepted": run == "good",
            }
            for run, speed in (("good", 1.0), ("good", 3.0), ("bad", 5.0))
        ),
    )
    figure, drawn = draw("coverage", CampaignTables.from_frames(points=points), config)
    assert drawn.set_index("series")[["x", "y"]].to_dict("index") == {
        "accepted": {"x": 2.0, "y": 70.0},
        "refused": {"x": 5.0, "y": 70.0},
    }
    assert nothing_is_cut_off(figure)
    empty, nothing = draw("coverage", CampaignTables.from_frames(), config)
    assert nothing.empty
    assert "nothing to cover" in empty.axes[0].texts[0].get_text()


def test_map_shows_the_state_of_each_condition(config: Settings) -> None:
    names = [f"nominal_{name}" for name in CONDITIONS]
    cells = rows("coverage", *(dict(zip(names, levels, strict=True)) for levels in matrix()))
    cells = cells.assign(oil="4102", planned=True, runs_accepted=1)
    cells.loc[0, ["runs_accepted", "runs_refused"]] = 0, 2
    figure, drawn = draw("coverage", CampaignTables.from_frames(coverage=cells), config)
    states = {"accepted": len(cells) - 1, "refused": 1}
    assert drawn["series"].value_counts().to_dict() == states
    assert drawn.loc[drawn["series"] == "refused", "words"].tolist() == ["0/2"]
    assert nothing_is_cut_off(figure)


@pytest.mark.parametrize("texts", [["A0"], ["A0", "A1", "A2"]])
def test_column_of_a_table_has_a_text_in_each_row(texts: list[str]) -> None:
    *_, write_column = table_page(3.5, 2, 0.17, 0.34, [])
    write_column(0, "constant", ["A0", "A1"])
    with pytest.raises(ValueError, match="argument 2"):
        write_column(0, "constant", texts)
