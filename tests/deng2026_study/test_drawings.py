"""Figures of the paper: panels, tables of values with their sources, and how they look."""

from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.patches import Rectangle

from campaigns import printed
from deng2026_study.extrapolation import truth_grid
from drawn_results import with_refits
from nights import nightly, quick_ones
from oilfilm.report.figures.sheet import save
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from pictures import (
    Draw,
    difference_from,
    drawing_of,
    is_as_wide_as_a_column,
    nothing_is_cut_off,
    settings_of_oils,
)

OILS = ["4102", "4050", "4010"]
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


FAST, SLOW = "U = 200 m/s", "U = 30 m/s"
# The captions of Figs 7 to 10, as the paper prints them; here one row of panels each.
PANELS = {
    "fig07": [f"P = {p} GPa, {FAST}" for p in ("0.8", "1.5", "2", "2.5")],
    "fig08": [f"P = 1.5 GPa, S = {s}" for s in ("0.05", "0.1", "0.15", "0.2")],
    "fig09": [f"{u}, S = {s}" for u in (FAST, SLOW) for s in ("0.05", "0.2")],
    "fig10": [f"P = {p} GPa, {u}" for p in ("0.8", "2") for u in (FAST, SLOW)],
}
ENDS = {"fig07": (0, 0.3), "fig08": (20, 200), "fig09": (0.8, 2.5), "fig10": (20, 140)}


@pytest.mark.slow
@pytest.mark.parametrize("name", PANELS)
def test_panels_of_figs_7_to_10_are_those_of_the_papers_captions(usual: Draw, name: str) -> None:
    figure, drawn = usual(name)
    titles = [axis.get_title(loc="left") for axis in figure.axes]
    of_each_oil = [levels for levels in PANELS[name] for _ in OILS]
    lettered = zip("abcdefghijkl", of_each_oil, strict=True)
    assert titles == [f"({letter}) {levels}" for letter, levels in lettered]
    shown = [text.get_text() for axis in figure.axes for text in axis.texts]
    assert shown == [*OILS] * 4
    assert drawn.groupby("panel")["oil"].unique().map(list).tolist() == [[oil] for oil in OILS] * 4
    assert (drawn["x"].min(), drawn["x"].max()) == ENDS[name]


@pytest.mark.slow
def test_dmn_of_a_bearing_is_beside_the_speeds_of_the_panels(usual: Draw) -> None:
    # dmN = 4 U/pi * 60 * 1000 mm rpm, by hand: U = omega dm/4
    (legend,) = usual("fig09")[0].legends
    assert legend.get_title().get_text() == "U = 200 m/s: dmN 7.6e6; U = 30 m/s: dmN 1.1e6"


def test_truth_of_a_simulation_is_drawn_in_place_of_printed_constants(
    drawing: Draw, usual: Draw, config: Settings
) -> None:
    truth = truth_grid(config, printed()).rename(
        columns={"traction_coefficient": "true_traction_coefficient"}
    )
    # another truth than the fitted law: half as much traction; two laws have the same truth
    truth["true_traction_coefficient"] /= 2
    laws = [truth.assign(law=law) for law in ("deng2026", "tanh")]
    _, drawn = drawing("fig09", extrapolation=pd.concat(laws))
    assert set(drawn["series"]) == {"refit", "truth"}
    of_level = (drawn["panel"] == "a") & (drawn["words"] == "T = 70 \N{DEGREE SIGN}C")
    lines = drawn[of_level].set_index("series")
    at_2_gpa = {
        series: np.interp(2.0, *lines.loc[series, ["x", "y"]].to_numpy().T)
        for series in ("refit", "truth")
    }
    assert at_2_gpa["truth"] == pytest.approx(at_2_gpa["refit"] / 2, rel=1e-3)
    assert lines.loc["truth", "x"].is_unique
    assert set(usual("fig09")[1]["series"]) == {"refit", "printed"}


@pytest.mark.slow
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
    light, heavy = shaded("fig09", 6)
    np.testing.assert_allclose([light[1], heavy[0]], [1.0, 1.5], atol=0.015)
    assert shaded("fig10", 9) == [(20, pytest.approx(140))]  # 2 GPa


@pytest.mark.parametrize("name", ["tab01", "tab03"])
def test_tables_say_every_value_with_its_source(usual: Draw, config: Settings, name: str) -> None:
    figure, drawn = usual(name)
    parts = drawn["words"].str.extract(r"^(?P<text>.*?) \[(?P<source>.*)\]$")
    texts = {each.get_text().replace("\n", " ") for axis in figure.axes for each in axis.texts}
    assert set(parts["text"]) <= texts
    assert (parts["source"] != "").all()
    assert "lost in our copy" in texts
    if name == "tab03":
        stars = parts["text"].str.endswith("*")
        assert set(parts.loc[stars, "source"]) == {"assumed"}
        # Table 3 of a paper has neither what rings grow by nor the momentum of oil
        growth = {"density_kg_m3", "expansion_1_k"}
        bearing = config.bearings[config.campaign.torque.bearing].model_dump(
            exclude={
                "mounting": True,
                "ring": growth,
                "ball": {"expansion_1_k"},
                "oil_supply": {"momentum_share"},
            }
        )
        configured = pd.json_normalize(bearing).iloc[0]
        texts = set(parts["text"].str.rstrip("*"))
        for number in configured[configured.map(pd.api.types.is_number)]:
            # with every digit, in the file's own unit, or in mm or GPa
            assert texts & {f"{factor * number:.12g}" for factor in (1, 1e3, 1e-9)}, number


DRAWN_HERE = ["fig01", "fig05", "tab01", "tab02", "fig02", "fig03", *PANELS]
# Pictures that between them have every kind of mark: patches, words, lines, bands, bars.
PICTURES = ["fig01", "fig03", "fig07"]


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
    assert [text.get_text() for text in figure.texts] in ([], ["SIMULATED"])
    assert is_as_wide_as_a_column(figure, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", PICTURES)
def test_pictures_look_as_they_did(drawing: Draw, tmp_path: Path, name: str) -> None:
    assert difference_from(BASELINE / f"{name}.png", drawing(name)[0], tmp_path) is None


def test_figure_without_data_says_so(drawing: Draw, results: CampaignTables) -> None:
    figure, drawn = drawing("fig03", points=results.points.assign(accepted=False, lambda_ratio=1.0))
    assert drawn.empty
    assert "no accepted point" in figure.axes[0].texts[0].get_text()
    assert nothing_is_cut_off(figure)


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
