"""Figures draw what they keep, say what is simulated, and come out in the same bytes."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from campaigns import Campaign, printed
from oilfilm.curation.coverage import coverage
from oilfilm.fits.fit import fit_oil
from oilfilm.report.figures import style
from oilfilm.report.figures.sheet import save
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.laws.deng2026 import traction_coefficient
from pictures import Draw, draw, drawing_of, nothing_is_cut_off
from reports import fits_of


def tables_of(campaign: Campaign, oils: Iterable[str]) -> CampaignTables:
    fits = [campaign.fit(oil, bootstrap=20, searches=2).coefficients for oil in oils]
    return CampaignTables.in_memory(
        points=campaign.curated.points,
        runs=campaign.curated.runs,
        **fits_of(pd.concat(fits)),
        coverage=coverage(campaign.curated.runs, campaign.config),
    )


@pytest.fixture(scope="module")
def results(demo: Campaign) -> CampaignTables:
    return tables_of(demo, demo.config.oils)


@pytest.fixture(scope="module")
def drawing(results: CampaignTables, config: Settings) -> Draw:
    return drawing_of(results, config)


def text_around(figure: Figure) -> str:
    """Small print above the panels, and labels of the whole figure."""
    return " ".join(text.get_text() for text in figure.texts)


@pytest.mark.parametrize("name", ["eqs11-13", "coverage"])
def test_figure_says_that_its_data_are_simulated(drawing: Draw, name: str) -> None:
    figure, _ = drawing(name)
    assert "SIMULATED" in text_around(figure)
    assert nothing_is_cut_off(figure)


def test_fitted_lines_lie_on_the_truth_of_the_twin(drawing: Draw) -> None:
    _, drawn = drawing("fig03")
    line = drawn.query("panel == 'b' and oil == '4010' and series == 'fit'")
    true = traction_coefficient(printed()["4010"], 1.25, 30.0, 100.0, line["x"].to_numpy())
    # conditions of a run are off nominal by the twin's control errors (0.3 % of load, 0.2 K)
    np.testing.assert_allclose(line["y"], true, rtol=0.03, atol=1e-5)


def test_an_oil_has_one_colour_in_every_figure(drawing: Draw, config: Settings) -> None:
    colours = [style.oil_colour(oil, list(config.oils)) for oil in config.oils]
    assert len(set(colours)) == 3
    figure, _ = drawing("fig03")
    for axis in figure.axes:
        drawn = {to_hex(line.get_color()).upper() for line in axis.get_lines()}
        assert drawn == set(colours)


def test_files_are_the_same_bytes_each_time(drawing: Draw, tmp_path: Path) -> None:
    for name in ("a", "b"):
        save(drawing("fig03")[0], tmp_path / f"{name}.png", tmp_path / f"{name}.svg")
    for ending in ("png", "svg"):
        assert (tmp_path / f"a.{ending}").read_bytes() == (tmp_path / f"b.{ending}").read_bytes()
    assert len(list(tmp_path.iterdir())) == 4


def test_last_bits_of_positions_are_in_no_file(drawing: Draw, tmp_path: Path) -> None:
    """They depend on the version of Python, whose `sum` rounds otherwise since 3.12."""
    figure, _ = drawing("tab02")
    save(figure, tmp_path / "before.svg")
    for axis in figure.axes:
        box = axis.get_position()
        axis.set_position([np.nextafter(each, 1) for each in box.bounds])
    save(figure, tmp_path / "after.svg")
    before, after = ((tmp_path / f"{name}.svg").read_text() for name in ("before", "after"))
    assert 'clip-path="url(#p' in before
    assert before == after


@pytest.mark.parametrize("name", ["fig03", "curves", "eqs11-13"])
def test_figure_without_any_accepted_point_says_so(
    drawing: Draw, results: CampaignTables, config: Settings, name: str
) -> None:
    refused = results.points.assign(accepted=False, reasons="thin_film")
    fits = [fit_oil(refused, oil, config.fit, config.seed).coefficients for oil in config.oils]
    figure, drawn = drawing(name, points=refused, **fits_of(pd.concat(fits)))
    if name != "eqs11-13":
        assert len(drawn) == 0
        assert "no accepted point" in figure.axes[0].texts[0].get_text()


def test_real_curves_are_called_measured(etm: Campaign) -> None:
    drawing = drawing_of(tables_of(etm, ["unrecorded-oil"]), etm.config)
    figure, drawn = drawing("curves")
    assert "SIMULATED" not in text_around(figure)
    assert (drawn["series"] == "measured").sum() == etm.curated.points["accepted"].sum()
    figure, drawn = drawing("constants")
    assert drawn["value"].notna().sum() == 3


def test_figure_of_what_is_not_there_says_so(config: Settings) -> None:
    figure, drawn = draw("coverage", CampaignTables.in_memory(), config)
    assert drawn.empty
    assert "nothing to cover" in figure.axes[0].texts[0].get_text().lower()
    assert nothing_is_cut_off(figure)


def test_measured_campaign_without_a_matrix_shows_the_levels_of_its_runs(
    drawing: Draw, config: Settings
) -> None:
    without_matrix = config.with_changes({"campaign": {"matrix": None}})
    pd.testing.assert_frame_equal(drawing("fig03", without_matrix)[1], drawing("fig03")[1])
