"""One page per refused run: its signals, its plateaus, and the rows concerned."""

import hashlib
import re
import textwrap
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.transforms import blended_transform_factory

from oilfilm import tables
from oilfilm.curation.coverage import describe_condition
from oilfilm.curation.curate import arrays_of, curate
from oilfilm.curation.plateau_gates import PLATEAU_GATES
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.signals import Signals
from oilfilm.curation.torque_rig import TORQUE_RIG
from oilfilm.curation.traction_rig import TRACTION_RIG
from oilfilm.outputs.figures import style
from oilfilm.readers.ingest import ingest_logs
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from oilfilm.units import FloatArray

_HEIGHT_IN = 7.2
_LETTERS = 112  # of 7 pt in a line of the page
_LINES = 4  # of one sentence; the listing has all of it
_DRAWN = 4000  # steps along a signal; more cannot be told apart on paper
_PASSING, _FAILING = "#56B4E9", "#E69F00"


@dataclass(frozen=True)
class Judged:
    """What curation made of the logs of one kind of rig.

    Attributes:
        kind: The kind of rig.
        runs: Table of runs with their verdicts.
        points: Table of plateaus with their verdicts.
        quarantine: Table of what was refused.
        samples: The samples of a run, by its name.
    """

    kind: RigKind
    runs: pd.DataFrame
    points: pd.DataFrame
    quarantine: pd.DataFrame
    samples: Callable[[str], pd.DataFrame]


def judged_torque_logs(
    logs: Iterable[tuple[str, bytes]], quarantine: pd.DataFrame, settings: Settings
) -> Judged:
    """Refused torque logs, read again: their samples are in no table.

    Args:
        logs: Name and content of each log that the quarantine names.
        quarantine: What was refused of the torque logs.
        settings: Settings of the run.
    """
    ingested = ingest_logs(logs, settings, TORQUE_RIG.logs)
    samples = ingested.all_samples()
    share = curate(samples, ingested.runs, settings, TORQUE_RIG)
    return Judged(
        TORQUE_RIG,
        share.runs,
        share.points,
        quarantine,
        lambda run_id: samples[samples["run_id"] == run_id],
    )


def draw_pages(rigs: Iterable[Judged], settings: Settings, most: int, folder: Path) -> pd.DataFrame:
    """Draw the page of every refused run that gets one; the table `refused_pages`.

    Args:
        rigs: What curation made of the logs, one kind of rig after the other.
        settings: Settings of the run.
        most: Number of pages at most.
        folder: Where the pages are written.
    """
    listings = []
    for judged in rigs:
        pages = listing(judged.runs, judged.points, judged.quarantine, most, judged.kind)
        for entry in tables.rows(pages[pages["page"] != ""]):
            (run,) = tables.rows(judged.runs[judged.runs["run_id"] == entry["run_id"]])
            points = judged.points[judged.points["run_id"] == entry["run_id"]]
            samples = judged.samples(entry["run_id"])
            page = draw_page(entry, run, samples, points, settings, judged.kind)
            style.save(page, folder / entry["page"])
            most -= 1
        listings.append(pages)
    return pd.concat(listings, ignore_index=True)


def listing(
    runs: pd.DataFrame,
    points: pd.DataFrame,
    quarantine: pd.DataFrame,
    most: int,
    kind: RigKind = TRACTION_RIG,
) -> pd.DataFrame:
    """Every refused run and whatever gave no run at all, with the page of each run that gets one.

    Where there are more runs than pages, each gate gets pages in turn, so that many runs refused
    for one reason do not hide another.

    Args:
        runs: Table of runs with their verdicts.
        points: Table of plateaus with their verdicts.
        quarantine: Table of what was refused.
        most: Number of pages at most.
        kind: The kind of rig.
    """
    without_run = ~quarantine["run_id"].isin(runs["run_id"])
    # a remark on a file that has runs is no refusal of the file
    of_file = quarantine["run_id"].eq("") & quarantine["file"].isin(runs["file"])
    about = runs.set_index("run_id")
    # levels that were held too briefly refuse no run
    of_run = quarantine["stage"].eq("curate") & quarantine["rule"].eq(
        quarantine["run_id"].map(about["rule"])
    )
    refused = quarantine[of_run | (without_run & ~of_file)]
    refused = refused.sort_values(["file", "run_id"], kind="stable").reset_index(drop=True)
    samples = refused["run_id"].map(about["samples"]).fillna(0)
    turn = refused[samples > 0].groupby("rule").cumcount().sort_values(kind="stable")
    paged = set(turn.index[:most])
    plateaus = dict(iter(points[points["run_id"].isin(refused["run_id"])].groupby("run_id")))
    rows = []
    for number, entry in enumerate(tables.rows(refused)):
        run_id, shown = entry["run_id"], number in paged
        marked = ("", 0, 0)
        if shown:
            same = quarantine["run_id"].eq(run_id) & quarantine["reason"].eq(entry["reason"])
            marked = _marked(quarantine[same], plateaus.get(run_id, points.iloc[:0]))
        rows.append(
            {
                "run_id": run_id,
                "file": entry["file"],
                "oil": about.at[run_id, "oil"] if run_id in about.index else "",
                "page": page_name(run_id, kind.name) if shown else "",
                "rule": entry["rule"],
                **dict(zip(("place", "first_row", "last_row"), marked, strict=True)),
                "reason": entry["reason"],
                "advice": entry["advice"],
            }
        )
    return tables.from_rows(rows, "refused_pages")


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
    kind: RigKind = TRACTION_RIG,
) -> Figure:
    """One page: the reason in words, then the signals against time with the rows marked.

    Args:
        entry: The run's row of the listing.
        run: Its row of the table of runs.
        samples: Its samples.
        points: Its plateaus.
        settings: Settings of the run.
        kind: The kind of rig.
    """
    signals = kind.signals(arrays_of(samples), run["rig"], settings)
    head = _head(entry, run)
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, _HEIGHT_IN))
    axes = figure.subplots(
        len(kind.shown_signals) + 1,
        1,
        sharex=False,
        height_ratios=[0.15 + 0.13 * len(head), *[1.2] * len(kind.shown_signals)],
    )
    _write(axes[0], head)
    for axis, (name, label) in zip(axes[1:], kind.shown_signals.items(), strict=True):
        _draw_signal(axis, signals.time_s, signals[name], label)
        _shade_plateaus(axis, signals, points)
        _mark(axis, signals, entry)
        axis.set_xlim(*_span(signals.time_s))
        axis.tick_params(labelbottom=axis is axes[-1])
    axes[-1].set_xlabel("Time since the log's start (s)")
    figure.align_ylabels(list(axes[1:]))
    _label_marked_rows(axes[1], signals, entry)
    _draw_legend(figure)
    style.say_source(figure, settings.campaign)
    return figure


def _marked(refusals: pd.DataFrame, points: pd.DataFrame) -> tuple[str, int, int]:
    """What to mark: the rows of the refusals, else failing plateaus, else the whole run."""
    with_rows = refusals[refusals["first_row"] > 0]
    if len(with_rows):
        return "rows", int(with_rows["first_row"].min()), int(with_rows["last_row"].max())
    failing = points[_fail_alone(points)]
    if len(failing):
        return "plateaus", int(failing["first_row"].min()), int(failing["last_row"].max())
    return "whole run", 0, 0


def _fail_alone(points: pd.DataFrame) -> "pd.Series[bool]":
    """Points that fail a gate of points, not only because their whole run was refused."""
    return failed_gates.failed_any(points, (gate.name for gate in PLATEAU_GATES))


def _head(entry: Mapping[str, Any], run: Mapping[str, Any]) -> list[str]:
    """Lines of the head, in plain characters; the first is the title."""
    file = "" if entry["file"] == entry["run_id"] else f"file {entry['file']}, "
    about = (
        f"{file}oil {run['oil']}, rig {run['rig']}, set points: {describe_condition(run)}; "
        f"{run['samples']} rows"
    )
    return [
        *_wrapped(f"REFUSED: {entry['run_id']}", 2, 90),
        *_wrapped(about, 2),
        *_wrapped(f"{entry['rule']}: {entry['reason']}", _LINES),
        *_wrapped(f"What to do: {entry['advice']}", _LINES),
    ]


def _wrapped(text: str, lines: int, letters: int = _LETTERS) -> list[str]:
    return textwrap.wrap(style.plain(text), letters, max_lines=lines, placeholder=" ...") or [""]


def _write(axis: Axes, lines: list[str]) -> None:
    axis.set_axis_off()
    title, rest = lines[0], "\n".join(lines[1:])
    about: dict[str, Any] = {"transform": axis.transAxes, "va": "top", "parse_math": False}
    axis.text(0, 1, title, fontsize=9, fontweight="bold", **about)
    axis.annotate(
        rest,
        (0, 1),
        xytext=(0, -15),
        xycoords="axes fraction",
        textcoords="offset points",
        va="top",
        fontsize=7,
        linespacing=1.35,
        parse_math=False,
    )


def _draw_signal(axis: Axes, time_s: FloatArray, values: FloatArray, label: str) -> None:
    axis.set_ylabel(label, fontsize=7)
    axis.grid(axis="x", visible=False)
    if not np.isfinite(values).any():
        axis.text(0.5, 0.5, "not logged", ha="center", va="center", transform=axis.transAxes)
        axis.set_yticks([])
        return
    few = len(values) < 200
    axis.plot(
        *_thinned(time_s, values),
        color="black",
        linewidth=0.6,
        marker="." if few else "",
        markersize=2,
    )
    axis.ticklabel_format(axis="y", useOffset=False)
    axis.margins(y=0.12)


def _thinned(time_s: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A long signal as the lowest and the highest value of each of many short stretches."""
    if len(values) <= 2 * _DRAWN:
        return time_s, values
    starts = np.linspace(0, len(values), _DRAWN, endpoint=False).astype(int)
    both = np.stack([np.fmin.reduceat(values, starts), np.fmax.reduceat(values, starts)], axis=1)
    return np.repeat(time_s[starts], 2), both.ravel()


def _shade_plateaus(axis: Axes, signals: Signals, points: pd.DataFrame) -> None:
    failing = _fail_alone(points)
    for colour, share in ((_PASSING, points[~failing]), (_FAILING, points[failing])):
        spans = [
            _times(signals, first, last)
            for first, last in zip(share["first_row"], share["last_row"], strict=True)
        ]
        axis.broken_barh(
            [(start, stop - start) for start, stop in spans],
            (0, 1),
            transform=blended_transform_factory(axis.transData, axis.transAxes),
            facecolor=style.tint(colour, 0.25),
            edgecolor=style.tint(colour, 0.25 if colour == _PASSING else 0.6),
            hatch="" if colour == _PASSING else "///",
            linewidth=0.4,
            zorder=0.5,
        )


def _mark(axis: Axes, signals: Signals, entry: Mapping[str, Any]) -> None:
    start, stop = _times(signals, entry["first_row"], entry["last_row"])
    for edge in (start, stop):
        axis.axvline(edge, color=style.STATE_COLOURS["refused"], linewidth=1.0, linestyle="-")


def _label_marked_rows(axis: Axes, signals: Signals, entry: Mapping[str, Any]) -> None:
    """A bar above the first panel over the marked rows, with their numbers."""
    colour = style.STATE_COLOURS["refused"]
    start, stop = _times(signals, entry["first_row"], entry["last_row"])
    above = blended_transform_factory(axis.transData, axis.transAxes)
    axis.plot(
        [start, stop],
        [1.06, 1.06],
        color=colour,
        linewidth=3,
        solid_capstyle="butt",
        marker="v" if start == stop else "",
        markersize=5,
        transform=above,
        clip_on=False,
    )
    low, high = _span(signals.time_s)
    right = (start + stop) / 2 > (low + high) / 2
    label = {
        "rows": f"rows concerned: {_range(entry)}",
        "plateaus": f"failing plateaus: {_range(entry)}",
        "whole run": "concerns the whole run",
    }[entry["place"]]
    axis.annotate(
        label,
        (stop if right else start, 1.06),
        xytext=(0, 4),
        xycoords=above,
        textcoords="offset points",
        ha="right" if right else "left",
        fontsize=7,
        color=colour,
        annotation_clip=False,
    )


def _range(entry: Mapping[str, Any]) -> str:
    first, last = entry["first_row"], entry["last_row"]
    return f"row {first}" if first == last else f"rows {first} to {last}"


def _times(signals: Signals, first_row: int, last_row: int) -> tuple[float, float]:
    """First and last time of a range of rows; 0 and 0 mean all, unread rows the nearest one."""
    if last_row == 0:
        return float(signals.time_s.min()), float(signals.time_s.max())
    inside = (signals.row >= first_row) & (signals.row <= last_row)
    if not inside.any():
        nearest = float(signals.time_s[np.abs(signals.row - first_row).argmin()])
        return nearest, nearest
    return float(signals.time_s[inside].min()), float(signals.time_s[inside].max())


def _span(time_s: FloatArray) -> tuple[float, float]:
    low, high = float(time_s.min()), float(time_s.max())
    margin = 0.01 * (high - low) or 1.0
    return low - margin, high + margin


def _draw_legend(figure: Figure) -> None:
    failing: dict[str, Any] = {
        "edgecolor": style.tint(_FAILING, 0.6),
        "hatch": "///",
        "linewidth": 0.4,
    }
    handles = [
        Patch(facecolor=style.tint(_PASSING, 0.25), label="plateau that passes its own gates"),
        Patch(
            facecolor=style.tint(_FAILING, 0.25),
            label="plateau refused by its own gates",
            **failing,
        ),
    ]
    figure.legend(handles=handles, loc="outside lower right", ncols=2)
