"""One page per refused run: its signals, its plateaus, and the rows concerned."""

import hashlib
import re
import textwrap
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from oilfilm import tables
from oilfilm.curation.curate import arrays_of, curate
from oilfilm.curation.plateau_gates import PLATEAU_GATES
from oilfilm.curation.rig_kind import RigKind, Signals
from oilfilm.curation.torque_rig import TorqueRig
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.logs.ingest import ingest_logs
from oilfilm.logs.run_sheet import NO_SHEET, REMARKS, RunSheet
from oilfilm.report.figures import style
from oilfilm.report.figures.sheet import SIMULATED, Sheet, save
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from oilfilm.tables.set_points import describe_condition

# Letters of 7 pt in a line of the page.
_LETTERS = 112
_PASSING: style.Look = {"facecolor": style.tint("#56B4E9", 0.25), "linewidth": 0.4}
_FAILING: style.Look = {
    "facecolor": style.tint("#E69F00", 0.25),
    "edgecolor": style.tint("#E69F00", 0.6),
    "hatch": "///",
    "linewidth": 0.4,
}


@dataclass(frozen=True)
class Judged:
    """What curation made of the logs of one kind of rig; `samples` gives those of a run by name."""

    kind: type[RigKind]
    runs: pd.DataFrame
    points: pd.DataFrame
    quarantine: pd.DataFrame
    samples: Callable[[str], pd.DataFrame]


def judged_torque_logs(
    logs: Iterable[tuple[str, bytes]],
    quarantine: pd.DataFrame,
    settings: Settings,
    sheet: RunSheet = NO_SHEET,
) -> Judged:
    """Refused torque logs by name and content, read again: their samples are in no table."""
    ingested = ingest_logs(logs, settings, TorqueRig.logs, sheet)
    samples = ingested.all_samples()
    curated = curate(samples, ingested.runs, TorqueRig(settings))
    by_run = samples.groupby("run_id").get_group
    return Judged(TorqueRig, curated.runs, curated.points, quarantine, by_run)


def draw_pages(rigs: Iterable[Judged], settings: Settings, most: int, folder: Path) -> pd.DataFrame:
    """Draw the pages of refused runs in a folder, up to `most`; gives the table `refused_pages`."""
    listings = []
    for judged in rigs:
        runs, points = judged.runs, judged.points
        pages = listing(runs, points, judged.quarantine, most, judged.kind)
        for entry in tables.rows(pages[pages["page"] != ""]):
            run_id = entry["run_id"]
            (run,) = tables.rows(runs[runs["run_id"] == run_id])
            plateaus, samples = points[points["run_id"] == run_id], judged.samples(run_id)
            page = draw_page(entry, run, samples, plateaus, settings, judged.kind)
            save(page, folder / entry["page"])
            most -= 1
        listings.append(pages)
    return pd.concat(listings, ignore_index=True)


def listing(
    runs: pd.DataFrame,
    points: pd.DataFrame,
    quarantine: pd.DataFrame,
    most: int,
    kind: type[RigKind] = TractionRig,
) -> pd.DataFrame:
    """Every refused run and whatever gave no run at all, with the page of each run that gets one.

    Where there are more runs than pages, each gate gets pages in turn, so that many runs refused
    for one reason do not hide another. There are `most` pages at most.
    """
    about = runs.set_index("run_id")
    without_run = ~quarantine["run_id"].isin(about.index)
    # a remark on a file that has runs is no refusal of the file
    of_file = quarantine["run_id"].eq("") & quarantine["file"].isin(runs["file"])
    # levels that were held too briefly refuse no run
    of_run = quarantine["stage"].eq("curate") & quarantine["rule"].eq(
        quarantine["run_id"].map(about["rule"])
    )
    refused = quarantine[(of_run | (without_run & ~of_file)) & ~quarantine["rule"].isin(REMARKS)]
    refused = refused.sort_values(["file", "run_id"], kind="stable").reset_index(drop=True)
    samples = refused["run_id"].map(about["samples"]).fillna(0)
    turn = refused[samples > 0].groupby("rule").cumcount().sort_values(kind="stable")
    marks = {}
    for number in turn.index[:most]:
        run_id, reason = refused.loc[number, ["run_id", "reason"]]
        same = quarantine["run_id"].eq(run_id) & quarantine["reason"].eq(reason)
        marked = _marked(quarantine[same], points[points["run_id"] == run_id])
        marks[number] = (*marked, page_name(run_id, kind.name))
    shown = [marks.get(number, ("", 0, 0, "")) for number in refused.index]
    columns = ["place", "first_row", "last_row", "page"]
    oils = refused["run_id"].map(about["oil"].get).fillna("")
    listed = refused[["run_id", "file", "rule", "reason", "advice"]].assign(oil=oils)
    listed = listed.join(pd.DataFrame(shown, refused.index, columns))
    return tables.conform(listed, "refused_pages", "refused runs")


def page_name(run_id: str, rig: str) -> str:
    """A file name that is safe on every system, and another one for every run of a kind of rig.

    Example:
        >>> page_name("../a b.csv", "traction")
        'a-b-csv-8d1b61480e6c67c8.png'
    """
    slug = re.sub(r"[^a-z0-9]+", "-", run_id.lower()).strip("-")[:40]
    digest = hashlib.sha256(f"{rig}:{run_id}".encode("utf-8", "surrogatepass")).hexdigest()[:16]
    return f"{slug or 'run'}-{digest}.png"


def draw_page(
    entry: Mapping[str, Any],
    run: Mapping[str, Any],
    samples: pd.DataFrame,
    points: pd.DataFrame,
    settings: Settings,
    kind: type[RigKind] = TractionRig,
) -> Figure:
    """One page: the reason in words, then the signals against time with the rows marked.

    Args:
        entry: The run's row of the listing.
        run: Its row of the table of runs.
        samples: Its samples.
        points: Its plateaus.
        settings: Settings of the campaign.
        kind: The kind of rig.
    """
    signals = kind.signals(arrays_of(samples), run["rig"], settings)
    timed = bool(np.isfinite(signals.time_s).all())
    if not timed:
        signals = replace(signals, time_s=signals.row.astype(float))
    time_s = signals.time_s
    head, count = _head(entry, run), len(kind.shown_signals)
    layout: style.Look = {"width": style.DOUBLE_COLUMN_IN, "height": 5.6 / count, "left": 0.85}
    sheet = Sheet(count, down=0.1, top=0.1 + 0.13 * len(head), sharex=True, **layout)
    failing = _fail_own_gates(points)
    for number, (name, label) in enumerate(kind.shown_signals.items()):
        panel = sheet.panel(number, None)
        axis, values = panel.axis, signals[name]
        axis.set_ylabel(label, fontsize=7)
        axis.yaxis.set_label_coords(-0.095, 0.5)
        axis.grid(axis="x", visible=False)
        if np.isfinite(values).any():
            marker = "." if len(values) < 200 else ""
            axis.plot(time_s, values, color="black", linewidth=0.6, marker=marker, markersize=2)
            axis.ticklabel_format(axis="y", useOffset=False)
            axis.margins(y=0.12)
            axis.locator_params(nbins=5)
        else:
            panel.say("not logged")
            axis.set_yticks([])
        for plateaus, look in ((points[~failing], _PASSING), (points[failing], _FAILING)):
            rows = zip(plateaus["first_row"], plateaus["last_row"], strict=True)
            spans = [_times(signals, first, last) for first, last in rows]
            bars = [(start, stop - start) for start, stop in spans]
            axis.broken_barh(bars, (0, 1), transform=axis.get_xaxis_transform(), zorder=0.5, **look)
        for edge in _times(signals, entry["first_row"], entry["last_row"]):
            axis.axvline(edge, color=style.STATE_COLOURS["refused"], linewidth=1.0)
    margin = 0.01 * (time_s.max() - time_s.min()) or 1.0
    sheet.axes[0].set_xlim(time_s.min() - margin, time_s.max() + margin)
    sheet.axes[-1].set_xlabel("Time since the log's start (s)" if timed else "Row of the log")
    sheet.axes[0].set_title("\n".join(head), x=-0.11, fontsize=7, parse_math=False)
    first, last = entry["first_row"], entry["last_row"]
    concerned = f"rows {first} to {last}" if last else "concerns the whole run"
    marked = style.line_handle(concerned, color=style.STATE_COLOURS["refused"])
    passing = Patch(**_PASSING, label="plateau that passes its own gates")
    sheet.legend([passing, Patch(**_FAILING, label="plateau refused by its own gates"), marked])
    return sheet.finish(SIMULATED if settings.campaign.data == "simulated" else "")


def _marked(refusals: pd.DataFrame, points: pd.DataFrame) -> tuple[str, int, int]:
    """What to mark: the rows of the refusals, else failing plateaus, else the whole run."""
    with_rows = refusals[refusals["first_row"] > 0]
    for name, rows in (("rows", with_rows), ("plateaus", points[_fail_own_gates(points)])):
        if len(rows):
            return name, int(rows["first_row"].min()), int(rows["last_row"].max())
    return "whole run", 0, 0


def _fail_own_gates(points: pd.DataFrame) -> "pd.Series[bool]":
    """Points that fail a gate of points, not only because their whole run was refused."""
    return failed_gates.failed_any(points, (gate.name for gate in PLATEAU_GATES))


def _head(entry: Mapping[str, Any], run: Mapping[str, Any]) -> list[str]:
    """Lines of the head, in plain characters."""
    file = "" if entry["file"] == entry["run_id"] else f"file {entry['file']}, "
    about = (
        f"{file}oil {run['oil']}, rig {run['rig']}, set points: {describe_condition(run)}; "
        f"{run['samples']} rows"
    )
    # a long text is cut after so many lines; the listing has all of it
    reason, advice = f"{entry['rule']}: {entry['reason']}", f"What to do: {entry['advice']}"
    texts = ((f"REFUSED: {entry['run_id']}", 1), (about, 2), (reason, 4), (advice, 4))
    return [
        line
        for text, lines in texts
        for line in textwrap.wrap(style.plain(text), _LETTERS, max_lines=lines, placeholder=" ...")
    ]


def _times(signals: Signals, first_row: int, last_row: int) -> tuple[float, float]:
    """First and last time of a range of rows.

    From 0 to 0 means all rows. Where no row of the range was read, the nearest one is taken.
    """
    inside = (signals.row >= first_row) & (signals.row <= last_row) | (last_row == 0)
    if not inside.any():
        inside[np.abs(signals.row - first_row).argmin()] = True
    return float(signals.time_s[inside].min()), float(signals.time_s[inside].max())
