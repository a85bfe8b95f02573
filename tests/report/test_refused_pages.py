"""Every refused run has its page, which marks the place of the trouble and trusts no name."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

import torque_logs
from bad_logs import PCS_CONFIG
from campaigns import Campaign, carry_logs
from oilfilm import tables
from oilfilm.curation.curate import curate_logs
from oilfilm.curation.torque_rig import TorqueRig
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.report.figures import style
from oilfilm.report.figures.refused_runs import (
    JudgedLogs,
    draw_page,
    draw_pages,
    judged_torque_logs,
    list_refusals,
    page_name,
)
from oilfilm.report.figures.sheet import save
from oilfilm.settings.resolved import Settings
from pcs_exports import traction_export
from reports import rows

HOSTILE = [
    *("../../etc/passwd", "/absolute/a.csv", "..", "", "a b.csv", "a-b.csv", "A-B.csv"),
    "\N{GREEK SMALL LETTER MU}\N{CJK UNIFIED IDEOGRAPH-6CB9}.csv",
    *(
        "line\nbreak\x00.csv",
        "x" * 5000,
        "x" * 5001,
        r"$\frac{1}{$ \input{x} _^{.csv",
        "\udcff.csv",
    ),
]


@pytest.fixture(scope="module")
def pages(demo: Campaign) -> dict[str, dict[str, Any]]:
    """Entry of each page by the rule that refused its run."""
    curated = demo.curated
    listed = list_refusals(curated.runs, curated.points, curated.quarantine, 50)
    return {entry["rule"]: entry for entry in tables.rows(listed[listed["page"] != ""])}


def samples_of(demo: Campaign, run_id: str) -> pd.DataFrame:
    runs = demo.ingested.runs
    (oil,) = runs.loc[runs["run_id"] == run_id, "oil"]
    samples = demo.ingested.samples_of_oil[oil]
    return samples[samples["run_id"] == run_id]


def page_of(
    demo: Campaign, entry: dict[str, Any], samples: pd.DataFrame | None = None, **changed: Any
) -> Figure:
    runs, points, run_id = demo.curated.runs, demo.curated.points, entry["run_id"]
    (run,) = tables.rows(runs[runs["run_id"] == run_id])
    samples = samples_of(demo, run_id) if samples is None else samples
    points = points[points["run_id"] == run_id]
    return draw_page({**entry, **changed}, run, samples, points, demo.config)


def marks(figure: Figure, panel: int = 0) -> list[float]:
    """Where the upright lines of a panel are."""
    lines = figure.axes[panel].get_lines()
    refused = [line for line in lines if line.get_color() == style.STATE_COLOURS["refused"]]
    return [float(line.get_xdata()[0]) for line in refused]


def texts_of(figure: Figure) -> str:
    texts = [*figure.texts, *(text for axis in figure.axes for text in axis.texts)]
    titles = [axis.get_title("left") for axis in figure.axes]
    return " ".join([*(text.get_text() for text in texts), *titles])


def test_every_planted_defect_has_its_page(
    demo: Campaign, pages: dict[str, dict[str, Any]]
) -> None:
    planted = demo.truth.query("defect != ''")
    shown = {entry["run_id"]: rule for rule, entry in pages.items()}
    assert shown == dict(planted[["run_id", "gate"]].to_numpy())
    for entry in pages.values():
        text = texts_of(page_of(demo, entry)).replace("\n", " ")
        for part in (entry["run_id"], entry["reason"], entry["advice"], "SIMULATED"):
            assert part in text


def test_marks_are_where_the_trouble_is(demo: Campaign, pages: dict[str, dict[str, Any]]) -> None:
    # of 4020 rows at 50 Hz the rig twin holds the force from 40 % on
    first, rows = int(0.4 * 4020), 4020
    stuck = pages["stuck_sensor"]
    assert (stuck["place"], stuck["first_row"], stuck["last_row"]) == ("rows", first + 1, rows)
    page = page_of(demo, stuck)
    for panel in range(4):
        marked = marks(page, panel)
        assert marked == pytest.approx([first / 50, (rows - 1) / 50])
    # a cut log is marked at its end, a whole run at both ends
    for rule, place, ends in (
        ("truncated", "rows", [-1, -1]),
        ("duplicate_condition", "whole run", [0, -1]),
    ):
        figure = page_of(demo, pages[rule])
        time_s = figure.axes[0].get_lines()[0].get_xdata()
        assert pages[rule]["place"] == place
        assert marks(figure) == [time_s[end] for end in ends]
    # without rows the failing plateaus are marked
    thin = pages["thin_film"]
    points = demo.curated.points[demo.curated.points["run_id"] == thin["run_id"]]
    marked = thin["place"], thin["first_row"], thin["last_row"]
    assert marked == ("plateaus", points["first_row"].min(), points["last_row"].max())


def test_page_names_are_safe_and_differ(tmp_path: Path) -> None:
    names = [page_name(run_id, rig) for run_id in HOSTILE for rig in ("traction", "torque")]
    assert len({name.lower() for name in names}) == 2 * len(HOSTILE)
    for name in names:
        assert name.isascii() and len(name) < 70
        assert (tmp_path / name).resolve().parent == tmp_path.resolve()
        assert name.removesuffix(".png").replace("-", "").isalnum()


@pytest.mark.parametrize("name", [name for name in HOSTILE if set(name) & set("\n$\udcff")])
def test_text_of_logs_is_drawn_as_it_stands(
    demo: Campaign, pages: dict[str, dict[str, Any]], tmp_path: Path, name: str
) -> None:
    stuck = pages["stuck_sensor"]
    hostile = {"run_id": name, "file": f"in {name}", "reason": f"found {name!r}: {name}"}
    bare = samples_of(demo, stuck["run_id"]).iloc[:300].assign(load_n=np.nan)
    figure = page_of(demo, stuck, bare, **hostile)
    save(figure, tmp_path / "page.png")
    assert figure.get_figheight() < 8
    assert texts_of(figure).count("not logged") == 1
    if "$" in name:
        assert r"$\frac{1}{$" in texts_of(figure)


def test_pages_are_bounded_and_each_gate_gets_one_first(demo: Campaign) -> None:
    curated = demo.curated
    stuck = curated.quarantine[curated.quarantine["rule"] == "stuck_sensor"]
    run = curated.runs[curated.runs["run_id"] == stuck["run_id"].iloc[0]]
    many = [f"a{number}" for number in range(20)]
    runs = pd.concat([curated.runs, *(run.assign(run_id=name) for name in many)])
    again = (stuck.assign(run_id=name, file=name) for name in many)
    refused = pd.concat([curated.quarantine, *again])
    pages = list_refusals(runs, curated.points, refused, 7)
    assert len(pages) == 6 + 20
    shown = pages[pages["page"] != ""]
    assert len(shown) == 7
    assert shown["rule"].nunique() == 6
    assert (pages.loc[pages["page"] == "", "first_row"] == 0).all()
    assert (list_refusals(runs, curated.points, refused, 0)["page"] == "").all()


def test_what_has_no_signal_is_listed_without_a_page(demo: Campaign) -> None:
    unread = rows("quarantine", {"file": "broken.csv", "reason": "x", "stage": "ingest"})
    (entry,) = tables.rows(list_refusals(demo.curated.runs, demo.curated.points, unread, 9))
    assert (entry["file"], entry["page"], entry["reason"]) == ("broken.csv", "", "x")
    assert list_refusals(*map(tables.empty_table, ("runs", "points", "quarantine")), 9).empty
    # a step without a run is a refusal in a file with runs
    curated = carry_logs(PCS_CONFIG, [("log.txt", traction_export(range(1, 4)))]).curated
    (entry,) = tables.rows(list_refusals(curated.runs, curated.points, curated.quarantine, 9))
    assert (entry["rule"], entry["page"]) == ("not_a_sweep", "")


@pytest.mark.slow
def test_refused_torque_log_has_its_page_with_traction_logs(demo: Campaign, tmp_path: Path) -> None:
    good = torque_logs.signals()
    signals = {"stuck.csv": good.assign(torque_n_m=3.25), "good.csv": good}
    logs = [(name, torque_logs.text(log)) for name, log in signals.items()]
    quarantine = curate_logs(logs, demo.config, TorqueRig).quarantine
    torque = judged_torque_logs(logs, quarantine, demo.config)
    curated = demo.curated
    one = curated.runs[curated.runs["rule"] == "swapped_sign"]
    of_it = curated.quarantine["run_id"].isin(one["run_id"])
    tables_of_it = one, curated.points, curated.quarantine[of_it]
    traction = JudgedLogs(TractionRig, *tables_of_it, partial(samples_of, demo))
    pages = draw_pages([traction, torque], demo.config, 7, tmp_path)
    shown = pages[pages["page"] != ""]
    assert len(shown) == 2
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(shown["page"])
    # the limit is that of both rigs together
    (tmp_path / "one").mkdir()
    drawn = draw_pages([traction, torque], demo.config, 1, tmp_path / "one")
    assert drawn.loc[drawn["page"] != "", "run_id"].tolist() == one["run_id"].tolist()
    entry = pages.set_index("run_id").loc["stuck.csv"]
    assert (entry["rule"], entry["place"], entry["first_row"]) == ("stuck_sensor", "rows", 121)


def brief_log() -> bytes:
    """A torque log with one level that is too brief for a plateau, and two that are too short."""
    levels = np.repeat([0, 1, 2, 3, 0], [120, 70, 30, 70, 120])
    log = torque_logs.signals_of(3000.0 * levels, np.array([0.0, 2.0, 3.0, 5.0])[levels], seed=1)
    return torque_logs.text(log)


@pytest.mark.parametrize(
    ("logs", "run_id", "rule"),
    [
        ([("a.csv", brief_log())], "a.csv", "too_short"),
        (
            [(name, torque_logs.text(torque_logs.signals())) for name in ("a.csv", "b.csv")],
            *("b.csv", "duplicate_log"),
        ),
    ],
    ids=["refused with a level", "copy"],
)
def test_each_refused_torque_run_is_listed_once(
    config: Settings, logs: list[tuple[str, bytes]], run_id: str, rule: str
) -> None:
    quarantine = curate_logs(logs, config, TorqueRig).quarantine
    refused_logs = [log for log in logs if log[0] in set(quarantine["file"])]
    judged = judged_torque_logs(refused_logs, quarantine, config)
    listed = list_refusals(judged.runs, judged.points, judged.quarantine, 9, judged.rig_class)
    assert listed["run_id"].is_unique
    entry = listed.set_index("run_id").loc[run_id]
    assert entry["rule"] == rule
    assert entry["page"] != ""
