"""The bearing's explorer of the report: planted laws of torque and slip, and where it refuses.

Needs chromium or Chrome (`.ci/tools` installs Debian's chromium); skipped where there is none.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from browsers import Page, Tab
from campaigns import rows
from nights import nightly
from oilfilm.report.bearing_explorer import _slider, bearing_explorer_data
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.best_oil import find_best_oil
from reports import OILS, report_of

pytestmark = pytest.mark.slow

LOADS, SPEEDS = [500.0, 2000.0, 5000.0, 12000.0, 30000.0], [1000.0, 3000.0, 9000.0, 20000.0]
MAP_TEMPERATURE = 100.0
# of the coarse map: every second load and speed, both ends among them
COARSE_LOADS, COARSE_SPEEDS = LOADS[::2], [1000.0, 9000.0, 20000.0]
# Where 4010 may roll or skid.
PARTED = {"oil": "4010", "axial_load_n": 500.0, "inner_speed_rpm": 20000.0}


def planted(
    oil: str, load_n: Any, speed_rpm: Any, temperature_c: Any
) -> dict[str, np.ndarray[Any, Any]]:
    """Torque, slip and film that interpolation on the page's axes meets exactly.

    They are power laws of load and speed, exponential in the temperature; the root of the slip is
    linear in the logarithm of the speed and in the temperature.
    """
    number = OILS.index(oil)
    load, speed, temperature = np.broadcast_arrays(load_n, speed_rpm, temperature_c)
    torque = (2 + 0.1 * number) * (load / 5000) ** 0.6 * (speed / 9000) ** (1.2 + 0.1 * number)
    torque = torque * np.exp(-0.004 * (temperature - 100))
    slip = (0.3 + 0.05 * np.log(speed / 9000) - 0.002 * (temperature - 100) + 0.01 * number) ** 2
    film = (9.0 - 2 * number) * (speed / 9000) ** 0.7 * np.exp(-(temperature - 100) / 90)
    return {
        "torque_n_m": torque,
        "torque_n_m_lower": 0.8 * torque,
        "torque_n_m_upper": 1.3 * torque,
        "cage_slip": slip,
        "cage_slip_lower": 0.64 * slip,
        "cage_slip_upper": 1.44 * slip,
        "lambda_ratio": film,
        "best_share": np.full(load.shape, (0.5, 0.3, 0.2)[number]),
    }


@pytest.mark.parametrize(
    ("levels", "ends_and_start"),
    [
        ([72.5], (72.5, 72.5, 72.5)),  # one level that is no round number
        ([72.3, 72.7], (72.7, 72.7, 72.7)),  # no round number between
        ([60.4, 72.6, 99.6], (61.0, 99.0, 73.0)),
        ([70.6, 99.6], (71.0, 99.0, 99.0)),  # the start would be beyond the end
    ],
)
def test_slider_starts_between_its_ends(
    levels: list[float], ends_and_start: tuple[float, float, float]
) -> None:
    slider = _slider("temperature", {"temperature": levels}, {"temperature": levels})
    assert (slider["low"], slider["high"], slider["start"]) == ends_and_start


def planted_map(
    table: str, loads: list[float], speeds: list[float], temperatures: list[float]
) -> pd.DataFrame:
    load, speed, temperature = np.meshgrid(loads, speeds, temperatures, indexing="ij")
    made = []
    for oil in OILS:
        values = planted(oil, load, speed, temperature)
        for place in np.ndindex(load.shape):
            row = {name: float(of_all[place]) for name, of_all in values.items()}
            row |= {"oil": oil, "bearing": "planted", "axial_load_n": load[place]}
            row |= {"inner_speed_rpm": speed[place], "pitch_speed_mm_rpm": 100 * speed[place]}
            row |= {"inlet_temperature_c": temperature[place]}
            row["bistable"] = all(row[name] == value for name, value in PARTED.items())
            made.append(row)
    return rows(table, *made)


@pytest.fixture(scope="module")
def with_maps(results: CampaignTables) -> CampaignTables:
    return results.replace(
        cage_slip=planted_map("cage_slip", LOADS, SPEEDS, [MAP_TEMPERATURE]),
        cage_slip_by_temperature=planted_map(
            "cage_slip_by_temperature", COARSE_LOADS, COARSE_SPEEDS, [70.0, 140.0]
        ),
    )


@pytest.fixture(scope="module")
def report(
    with_maps: CampaignTables, config: Settings, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    folder = tmp_path_factory.mktemp("bearing")
    (folder / "report.html").write_text(report_of(with_maps, config, folder), encoding="utf-8")
    return folder / "report.html"


@pytest.fixture
def page(tab: Tab, report: Path) -> Page:
    return tab.open(report)


def predicted(page: Page, oil: str, points: np.ndarray[Any, Any]) -> pd.DataFrame:
    answers = page.evaluate(
        "([oil, points]) => points.map(point => oilfilmBearing.predictBearing(oil, point))",
        [OILS.index(oil), points.tolist()],
    )
    return pd.DataFrame(answers)


def choose(page: Page, **values: float) -> None:
    for name, value in values.items():
        page.fill(f"#bearing-value-{name}", str(value))
        page.keyboard.press("Enter")


def test_between_calculated_points_the_page_has_the_planted_laws(page: Page) -> None:
    random = np.random.default_rng(5)
    # above 2000 N, where every oil is interpolated
    points = random.uniform([2000, 1000, 70], [30000, 20000, 140], (60, 3))
    # also at calculated points, and at the temperature of the map
    points[:3] = [[5000, 9000, 100], [30000, 20000, 140], [2000, 1000, 70]]
    points[3:20, 2] = MAP_TEMPERATURE
    names = {"torque": "torque_n_m", "torqueUpper": "torque_n_m_upper", "film": "lambda_ratio"}
    names |= {"torqueLower": "torque_n_m_lower", "slip": "cage_slip", "share": "best_share"}
    names |= {"slipLower": "cage_slip_lower", "slipUpper": "cage_slip_upper"}
    for oil in OILS:
        expected = planted(oil, *points.T)
        answer = predicted(page, oil, points)
        # at 500 N and 20 000 rpm, next to 5000 N, the coarse map of 4010 is not interpolated
        known = answer["known"].to_numpy(dtype=bool)
        assert known.all() == (oil != "4010")
        assert known.mean() > 0.7
        for name, column in names.items():
            # five digits are in the page
            np.testing.assert_allclose(answer[name][known], expected[column][known], rtol=1e-4)


def test_the_best_oil_is_that_of_the_tables(page: Page) -> None:
    random = np.random.default_rng(6)
    slip = random.uniform(0.05, 0.3, (200, 3))
    torque = random.uniform(1, 9, (200, 3))
    film = random.uniform(2, 5, (200, 3))
    film[random.random((200, 3)) < 0.1] = np.nan
    limits = page.evaluate("[oilfilmBearing.DATA.slipLimit, oilfilmBearing.DATA.filmLimit]")
    answers = [
        [
            {"slip": s, "torque": t, "film": None if np.isnan(f) else f, "known": True}
            for s, t, f in zip(*point, strict=True)
        ]
        for point in zip(slip, torque, film, strict=True)
    ]
    best = page.evaluate(
        "all => all.map(oils => oilfilmBearing.bestOil(oils.map("
        "oil => ({ ...oil, film: oil.film ?? NaN }))))",
        answers,
    )
    expected = find_best_oil(slip.T, torque.T, film.T, *limits)
    assert best == [
        int(oil) if is_known else None
        for oil, is_known in zip(expected.oil_index, expected.is_known, strict=True)
    ]
    assert None in best
    assert -1 in best


def test_the_page_shows_torque_loss_slip_and_best_oil_with_intervals(page: Page) -> None:
    choose(page, load=4000, speed=6000, temperature=90)
    values = planted("4050", 4000.0, 6000.0, 90.0)
    shown = {
        name: page.inner_text(f"#bearing-{name}-1").replace(" to ", "\n").split("\n")
        for name in ("torque", "loss", "slip")
    }
    ends = ("", "_lower", "_upper")
    torque = np.array([values[f"torque_n_m{end}"] for end in ends])
    slip = np.array([values[f"cage_slip{end}"] for end in ends])
    for name, expected in (
        ("torque", torque),
        ("loss", torque * 6000 * np.pi / 30),
        ("slip", 100 * slip),
    ):
        np.testing.assert_allclose(np.array(shown[name], dtype=float), expected, rtol=5e-3)
    # the smallest torque of a held cage with a full film
    oils = [planted(oil, 4000.0, 6000.0, 90.0) for oil in OILS]
    films = [float(oil["lambda_ratio"]) for oil in oils]
    assert min(films) > 3
    best = int(np.argmin([float(oil["torque_n_m"]) for oil in oils]))
    share = (50, 30, 20)[best]
    assert page.inner_text("#bearing-best") == f"Best oil: {OILS[best]}, in {share} % of the draws"
    command = page.inner_text("#bearing-command")
    assert "--bearing planted --load 4000N --speed 6000rpm --temperature 90degC" in command


def test_outside_the_calculated_points_nothing_is_shown(page: Page) -> None:
    choose(page, load=400)
    assert "Axial load 400 N: calculated from 500 to 30000 N" in page.inner_text("#bearing-outside")
    assert page.inner_text("#bearing-torque-0") == "not known"
    assert page.inner_text("#bearing-best") == "Best oil: not known here"
    choose(page, load=600, temperature=150)
    assert "Oil temperature 150" in page.inner_text("#bearing-outside")
    choose(page, temperature=100)
    assert page.locator("#bearing-outside").is_hidden()
    assert page.inner_text("#bearing-torque-0") != "not known"


def test_near_a_jump_of_the_cage_nothing_is_interpolated(page: Page) -> None:
    choose(page, load=600, speed=15000, temperature=100)
    assert page.inner_text("#bearing-torque-2") == "not known"
    assert page.inner_text("#bearing-torque-0") != "not known"
    assert "Not interpolated for 4010" in page.inner_text("#bearing-not-interpolated")
    # the oil that is not known may be the best one
    assert page.inner_text("#bearing-best") == "Best oil: not known here"


@pytest.mark.parametrize("width", [390, nightly(1440)])
def test_everyone_can_use_the_explorer_of_the_bearing(tab: Tab, report: Path, width: int) -> None:
    page = tab.open(report, width=width)
    assert tab.problems == []
    assert tab.violations() == []
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    # all columns are on the screen of a phone, also where the loss has five digits
    choose(page, load=30000, speed=20000)
    box = page.locator("#bearing-slip-0").bounding_box()
    assert box["x"] + box["width"] <= width
    page.focus("#bearing-slider-load")
    before = page.input_value("#bearing-value-load")
    page.keyboard.press("ArrowLeft")
    assert float(page.input_value("#bearing-value-load")) < float(before)


def test_without_a_map_there_is_no_explorer(results: CampaignTables, config: Settings) -> None:
    assert bearing_explorer_data(results, config) is None
