"""Figures draw exactly what their tables hold, and a broken picture is seen."""

from functools import cache
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from matplotlib.testing.compare import compare_images

from fit_points import matrix
from nights import nightly, quick_ones
from oilfilm.base.randomness import generator
from oilfilm.report.figures.sheet import Sheet, save
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import CONDITIONS
from pictures import Draw, draw, drawing_of, nothing_is_cut_off
from reports import rows

BASELINE = Path(__file__).parent / "baseline"
# Root-mean-square difference of the pictures' values, of 255. The same code gives 0; this leaves
# room for the font rendering of another build of matplotlib, and every fault below is larger.
TOLERANCE = 1.0


@pytest.fixture(scope="module")
def results(on_printed_law: CampaignTables) -> CampaignTables:
    """Points on the printed law of every oil, and refits that scatter by 1 % about it."""
    coefficients, points = on_printed_law.coefficients, on_printed_law.points
    coefficients = coefficients.assign(standard_error=0.01 * coefficients["value"].abs())
    random = generator(1, "refits")
    refits = pd.concat(
        coefficients[["oil", "law", "constant"]].assign(
            cause="resampled curves",
            refit=number,
            value=coefficients["value"] * random.normal(1, 0.01, len(coefficients)),
        )
        for number in range(40)
    )
    runs = points.groupby("run_id", as_index=False).first()[["run_id", "oil", *CONDITIONS]]
    runs = runs.rename(columns={name: f"nominal_{name}" for name in CONDITIONS})
    runs = runs.assign(rig="ball-on-disc-20mm", nominal_load_n=np.nan)
    correlations = _correlations(refits)
    return on_printed_law.replace(
        runs=runs, coefficients=coefficients, refits=refits, correlations=correlations
    )


def _correlations(refits: pd.DataFrame) -> pd.DataFrame:
    parts = []
    for oil, of_oil in refits.groupby("oil", sort=False):
        wide = of_oil.pivot(index="refit", columns="constant", values="value").corr()
        rows = wide.rename_axis(index="other").stack().rename("correlation").reset_index()
        parts.append(rows[rows["constant"] < rows["other"]].assign(oil=oil, law="deng2026"))
    return pd.concat(parts)


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


# dmN = 4 U/pi * 60 * 1000 mm rpm, by hand: U = omega dm/4
FAST, SLOW = "U = 200 m/s (dmN 7.6e6)", "U = 30 m/s (dmN 1.1e6)"
# The captions of Figs 7 to 10, as the paper prints them, with dmN.
PANELS = {
    "fig07": [f"P = {p} GPa, {FAST}" for p in ("0.8", "1.5", "2", "2.5")],
    "fig08": [f"P = 1.5 GPa, S = {s}" for s in ("0.05", "0.1", "0.15", "0.2")],
    "fig09": [f"{u}, S = {s}" for u in (FAST, SLOW) for s in ("0.05", "0.2")],
    "fig10": [f"P = {p} GPa, {u}" for p in ("0.8", "2") for u in (FAST, SLOW)],
}
ENDS = {"fig07": (0, 0.3), "fig08": (20, 200), "fig09": (0.8, 2.5), "fig10": (20, 140)}


@pytest.mark.parametrize("name", PANELS)
def test_panels_of_figs_7_to_10_are_those_of_the_papers_captions(usual: Draw, name: str) -> None:
    figure, drawn = usual(name)
    titles = [axis.get_title(loc="left") for axis in figure.axes]
    lettered = zip("abcd", PANELS[name], strict=True)
    assert titles == [f"({letter}) {levels}" for letter, levels in lettered]
    assert set(drawn["oil"]) == {"4102", "4050", "4010"}
    assert (drawn["x"].min(), drawn["x"].max()) == ENDS[name]


def test_shade_covers_what_no_test_reaches(usual: Draw) -> None:
    # tested: 1.0 to 1.5 GPa, 25 to 40 m/s, 25 to 120 degC
    def shaded(name: str, panel: int) -> list[tuple[float, float]]:
        figure, _ = usual(name)
        spans = [patch for patch in figure.axes[panel].patches if isinstance(patch, Rectangle)]
        return [(span.get_x(), span.get_x() + span.get_width()) for span in spans]

    assert shaded("fig07", 1) == [(0, pytest.approx(0.3))]  # 200 m/s
    slow, fast = shaded("fig08", 0)
    assert (slow[0], fast[1]) == (20, pytest.approx(200))
    np.testing.assert_allclose([slow[1], fast[0]], [25, 40], atol=1.5)  # a step along the abscissa
    light, heavy = shaded("fig09", 2)
    np.testing.assert_allclose([light[1], heavy[0]], [1.0, 1.5], atol=0.015)
    assert shaded("fig10", 3) == [(20, pytest.approx(140))]  # 2 GPa


@pytest.mark.parametrize("name", ["tab01", "tab03"])
def test_tables_say_every_value_with_its_source(usual: Draw, config: Settings, name: str) -> None:
    figure, drawn = usual(name)
    parts = drawn["words"].str.extract(r"^(?P<text>.*?) \[(?P<source>.*)\]$")
    texts = {each.get_text().replace("\n", " ") for axis in figure.axes for each in axis.texts}
    assert set(parts["text"]) <= texts
    assert (parts["source"] != "").all()
    assert "lost" in texts
    if name == "tab03":
        stars = parts["text"].str.endswith("*")
        assert set(parts.loc[stars, "source"]) == {"assumed"}
        bearing = config.bearings[config.campaign.torque.bearing].model_dump()
        configured = pd.json_normalize(bearing).iloc[0]
        texts = set(parts["text"].str.rstrip("*"))
        for number in configured[configured.map(pd.api.types.is_number)]:
            # with every digit, in the file's own unit, or in mm or GPa
            assert texts & {f"{factor * number:.12g}" for factor in (1, 1e3, 1e-9)}, number


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


DRAWN_HERE = ["fig01", "fig05", "tab01", "fig02", "fig03", *PANELS, "residuals", "identifiability"]


# Pictures that between them have every kind of mark: patches, words, lines, bands, bars, an image.
PICTURES = ["fig01", "fig03", "fig07", "identifiability"]


@pytest.mark.no_cover
@pytest.mark.parametrize("oils", [["4102", "4050", "4010"], nightly(["4102"])])
@pytest.mark.parametrize("name", quick_ones(DRAWN_HERE, PICTURES))
def test_figures_are_as_wide_as_a_column_and_nothing_is_cut_off(
    drawing: Draw, config: Settings, tmp_path: Path, name: str, oils: list[str]
) -> None:
    plain = config.plain()
    fewer = {oil: plain["oils"][oil] for oil in oils}
    figure, _ = drawing(name, Settings.of({**plain, "oils": fewer}))
    assert nothing_is_cut_off(figure)
    # all else is in the caption
    assert [text.get_text() for text in figure.texts] in ([], ["SIMULATED"])
    save(figure, tmp_path / "figure.png")
    width = matplotlib.image.imread(tmp_path / "figure.png").shape[1]
    assert width in [int(mm / 25.4 * 180) for mm in (84, 174)]


@pytest.mark.parametrize("name", PICTURES)
def test_pictures_look_as_they_did(drawing: Draw, tmp_path: Path, name: str) -> None:
    path = tmp_path / f"{name}.png"
    drawing(name)[0].savefig(path, dpi=60, metadata={"Software": None})
    message = compare_images(str(BASELINE / f"{name}.png"), str(path), TOLERANCE)
    assert message is None, f"{message}\nIs it meant? Look at it, then copy it over the baseline."


def test_panel_keeps_what_it_draws() -> None:
    panel = Sheet().panel(title="one")
    x, y = np.arange(3.0), np.array([1.0, 4.0, 9.0])
    panel.line("line", x, y, {"color": "black"}, oil="4102", lower=y - 1, upper=y + 2)
    panel.dots("dots", x, 2 * y, {"marker": "o"}, lower=y, upper=4 * y)
    for part, line in zip(panel.parts, panel.axis.get_lines(), strict=False):
        np.testing.assert_array_equal(line.get_xydata(), np.column_stack([part["x"], part["y"]]))
    band, bars = panel.axis.collections
    for part, edges in ((panel.parts[0], band), (panel.parts[1], bars)):
        vertices = np.concatenate([path.vertices for path in edges.get_paths()])
        for end in ("y_lower", "y_upper"):
            assert {*zip(part["x"], part[end], strict=True)} <= {*map(tuple, vertices)}
    assert set(panel.parts[0]["oil"]) == {"4102"}
    assert set(panel.parts[0]["panel"]) == {"a"}


def test_same_figure_gives_the_same_bytes_whatever_last_bits(drawing: Draw, tmp_path: Path) -> None:
    """These depend on the version of Python, whose `sum` rounds otherwise since 3.12."""
    for shift in (0, 1):
        figure, _ = drawing("tab02")
        for axis in figure.axes if shift else ():
            axis.set_position([np.nextafter(each, 1) for each in axis.get_position().bounds])
        save(figure, tmp_path / f"{shift}.png", tmp_path / f"{shift}.svg")
    assert 'clip-path="url(#p' in (tmp_path / "0.svg").read_text()
    for ending in ("png", "svg"):
        assert (tmp_path / f"0.{ending}").read_bytes() == (tmp_path / f"1.{ending}").read_bytes()


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        *(("fig03", "no accepted point"), ("curves", "no accepted point")),
        *(("coverage", "nothing to cover"), ("stribeck", "give the properties of the oil")),
    ],
)
def test_no_data_are_told(drawing: Draw, results: CampaignTables, name: str, sentence: str) -> None:
    figure, drawn = drawing(name, points=results.points.assign(accepted=False, lambda_ratio=1.0))
    assert drawn.empty
    assert sentence in figure.axes[0].texts[0].get_text()
    assert nothing_is_cut_off(figure)


def test_map_shows_the_state_of_each_condition(config: Settings) -> None:
    names = [f"nominal_{name}" for name in CONDITIONS]
    cells = rows("coverage", *(dict(zip(names, levels, strict=True)) for levels in matrix()))
    cells = cells.assign(oil="4102", planned=True, runs_accepted=1)
    cells.loc[0, ["runs_accepted", "runs_refused"]] = 0, 2
    figure, drawn = draw("coverage", CampaignTables.in_memory(coverage=cells), config)
    states = {"accepted": len(cells) - 1, "refused": 1}
    assert drawn["series"].value_counts().to_dict() == states
    assert drawn.loc[drawn["series"] == "refused", "words"].tolist() == ["0/2"]
    assert nothing_is_cut_off(figure)
