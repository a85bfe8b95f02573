"""One page per refused run: its signals, its plateaus, and the rows concerned."""

import hashlib
import math
import re
import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from oilfilm import tables
from oilfilm.base.units import FloatArray
from oilfilm.curation.curate import CuratedTables, arrays_of_samples, curate_samples
from oilfilm.curation.plateau_gates import PLATEAU_GATES
from oilfilm.curation.rig_kind import RigKind, Signals
from oilfilm.curation.torque_rig import TorqueRig
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.logs.ingest import ingest_logs
from oilfilm.logs.run_sheet import NO_SHEET, REMARK_RULES, RunSheet
from oilfilm.report.figures import style
from oilfilm.report.figures.sheet import SIMULATED, Panel, Sheet, save
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from oilfilm.tables.set_points import describe_condition

# Columns of the plateaus that a page marks.
MARKED_POINT_COLUMNS = ("run_id", "first_row", "last_row", "failed_gates")
# Number of letters of 7 pt in a line of the page.
_LETTERS_PER_LINE = 112
# Height of all panels together.
_PANELS_HEIGHT_IN = 5.6
_MARKERS_MAX = 200  # a signal of fewer rows is drawn with its points
_PASSING: style.Look = {"facecolor": style.tint("#56B4E9", 0.25), "linewidth": 0.4}
_FAILING: style.Look = {
    "facecolor": style.tint("#E69F00", 0.25),
    "edgecolor": style.tint("#E69F00", 0.6),
    "hatch": "///",
    "linewidth": 0.4,
}


@dataclass(frozen=True)
class JudgedLogs:
    """The results of curation of the logs of one kind of rig.

    Attributes:
        rig_class: The class of the kind of rig.
        runs: Table of runs.
        points: Table of plateaus.
        quarantine: Table of refusals.
        samples_of_run: Function that gives the samples of a run, by its name.
    """

    rig_class: type[RigKind]
    runs: pd.DataFrame
    points: pd.DataFrame
    quarantine: pd.DataFrame
    samples_of_run: Callable[[str], pd.DataFrame]


def judged_torque_logs(
    logs: Iterable[tuple[str, bytes]],
    quarantine: pd.DataFrame,
    settings: Settings,
    run_sheet: RunSheet = NO_SHEET,
) -> JudgedLogs:
    """Torque logs with a refusal, read and curated again, because no table has their samples.

    Args:
        logs: Name and content of each log.
        quarantine: Table `torque_quarantine`, which has the refusals by the whole campaign too.
        settings: Settings of the campaign.
        run_sheet: Run sheet of the torque logs.
    """
    ingested = ingest_logs(logs, settings, TorqueRig.log_schema, run_sheet)
    samples = ingested.all_samples()
    curated = curate_samples(samples, ingested.runs, TorqueRig(settings))
    runs = _with_refusals_by_comparison(curated, quarantine)
    samples_of_run = samples.groupby("run_id").get_group
    return JudgedLogs(TorqueRig, runs, curated.points, quarantine, samples_of_run)


def _with_refusals_by_comparison(curated: CuratedTables, quarantine: pd.DataFrame) -> pd.DataFrame:
    """Runs that were curated one by one, with their refusals by comparison with other runs.

    Args:
        curated: The tables of these runs.
        quarantine: Table of all refusals.
    """
    runs = curated.runs
    refusal_columns = ["run_id", "rule", "reason"]
    is_found_again = pd.MultiIndex.from_frame(quarantine[refusal_columns]).isin(
        pd.MultiIndex.from_frame(curated.quarantine[refusal_columns])
    )
    is_of_run = quarantine["stage"].eq("curate") & quarantine["run_id"].isin(runs["run_id"])
    by_comparison = quarantine[is_of_run & ~is_found_again]
    runs_by_id = runs.set_index("run_id")
    for column in ("rule", "reason"):
        runs_by_id.loc[by_comparison["run_id"], column] = by_comparison[column].to_numpy()
    return runs_by_id.reset_index()


def draw_pages(
    logs_by_kind: Sequence[JudgedLogs], settings: Settings, pages_max: int, folder: Path
) -> pd.DataFrame:
    """Draw the pages of refused runs in a folder.

    Args:
        logs_by_kind: The judged logs of each kind of rig.
        settings: Settings of the campaign.
        pages_max: Largest number of pages, which the kinds of rigs share.
        folder: For the pages.

    Returns:
        Table `refused_pages`.
    """
    wanted_pages = [_entries_of(judged, pages_max)["page"].ne("").sum() for judged in logs_by_kind]
    entries_by_kind = []
    for judged, page_count in zip(logs_by_kind, _shared(wanted_pages, pages_max), strict=True):
        entries = _entries_of(judged, page_count)
        for entry in tables.rows(entries[entries["page"] != ""]):
            run_id = entry["run_id"]
            (run,) = tables.rows(judged.runs[judged.runs["run_id"] == run_id])
            plateaus = judged.points[judged.points["run_id"] == run_id]
            samples = judged.samples_of_run(run_id)
            page = draw_page(entry, run, samples, plateaus, settings, judged.rig_class)
            save(page, folder / entry["page"])
        entries_by_kind.append(entries)
    return pd.concat(entries_by_kind, ignore_index=True)


def _entries_of(judged: JudgedLogs, pages_max: int) -> pd.DataFrame:
    """`list_refusals` of the judged logs of a kind of rig."""
    return list_refusals(judged.runs, judged.points, judged.quarantine, pages_max, judged.rig_class)


def _shared(wanted_counts: Sequence[int], total: int) -> list[int]:
    """Parts of a total: equal ones, of which what is not wanted goes to the others.

    Examples:
        >>> _shared([30, 2, 9], total=20), _shared([1, 1], total=1)
        ([9, 2, 9], [1, 0])
    """
    parts = [0] * len(wanted_counts)
    ascending = sorted(range(len(wanted_counts)), key=lambda index: wanted_counts[index])
    for number, index in enumerate(ascending):
        others_left = len(wanted_counts) - number
        # an odd one goes to the one that wants the fewest
        parts[index] = min(wanted_counts[index], math.ceil(total / others_left))
        total -= parts[index]
    return parts


def list_refusals(
    runs: pd.DataFrame,
    points: pd.DataFrame,
    quarantine: pd.DataFrame,
    pages_max: int,
    rig_class: type[RigKind] = TractionRig,
) -> pd.DataFrame:
    """Every refused run and every log without a run, with the name of its page if it gets one.

    Where there are more runs than pages, the gates get pages in turn. Then many runs that are
    refused for one reason do not hide another reason.

    Args:
        runs: Table of runs.
        points: Table of plateaus.
        quarantine: Table of refusals.
        pages_max: Largest number of pages.
        rig_class: The class of the kind of rig.

    Returns:
        Table `refused_pages`.
    """
    refusals = _refusals_of_runs_and_logs(runs, quarantine)
    run_by_id = runs.set_index("run_id")
    sample_counts = refusals["run_id"].map(run_by_id["samples"]).fillna(0)
    # number of earlier refusals by the same rule
    turn_of_refusal = refusals[sample_counts > 0].groupby("rule").cumcount()
    with_page = set(turn_of_refusal.sort_values(kind="stable").index[:pages_max])
    marks = []
    for index in refusals.index:
        if index not in with_page:
            marks.append({"place": "", "first_row": 0, "last_row": 0, "page": ""})
            continue
        run_id = refusals["run_id"][index]
        reason = refusals["reason"][index]
        same_refusal = quarantine["run_id"].eq(run_id) & quarantine["reason"].eq(reason)
        place, first_row, last_row = _rows_to_mark(
            quarantine[same_refusal], points[points["run_id"] == run_id]
        )
        page = page_name(run_id, rig_class.name)
        marks.append({"place": place, "first_row": first_row, "last_row": last_row, "page": page})
    oil_names = refusals["run_id"].map(run_by_id["oil"].get).fillna("")
    entries = refusals[["run_id", "file", "rule", "reason", "advice"]].assign(oil=oil_names)
    columns = ["place", "first_row", "last_row", "page"]
    entries = entries.join(pd.DataFrame(marks, refusals.index, columns))
    return tables.conform(entries, "refused_pages", "refused runs")


def _refusals_of_runs_and_logs(runs: pd.DataFrame, quarantine: pd.DataFrame) -> pd.DataFrame:
    """The rows of the quarantine that refuse a run, or a log without any run, by file and run."""
    run_by_id = runs.set_index("run_id")
    refuses_run = quarantine["stage"].eq("curate")
    # the row of a single level may have the rule of its run, but it has another reason
    for column in ("rule", "reason"):
        refuses_run &= quarantine[column].eq(quarantine["run_id"].map(run_by_id[column]))
    has_no_run = ~quarantine["run_id"].isin(runs["run_id"])
    # a row without a run, on a file that has runs, does not refuse the file
    concerns_part_of_file = quarantine["run_id"].eq("") & quarantine["file"].isin(runs["file"])
    refuses_log = has_no_run & ~concerns_part_of_file
    is_remark = quarantine["rule"].isin(REMARK_RULES)
    refusals = quarantine[(refuses_run | refuses_log) & ~is_remark]
    return refusals.sort_values(["file", "run_id"], kind="stable").reset_index(drop=True)


def page_name(run_id: str, rig_kind_name: str) -> str:
    """A file name that is safe on every system and different for each run of each kind of rig.

    Example:
        >>> page_name("../a b.csv", "traction")
        'a-b-csv-8d1b61480e6c67c8.png'
    """
    slug = re.sub(r"[^a-z0-9]+", "-", run_id.lower()).strip("-")[:40]
    digest = hashlib.sha256(
        f"{rig_kind_name}:{run_id}".encode("utf-8", "surrogatepass")
    ).hexdigest()[:16]
    return f"{slug or 'run'}-{digest}.png"


def draw_page(
    entry: Mapping[str, Any],
    run: Mapping[str, Any],
    samples: pd.DataFrame,
    points: pd.DataFrame,
    settings: Settings,
    rig_class: type[RigKind] = TractionRig,
) -> Figure:
    """One page: the reason in words, then the signals against time with the rows marked.

    Args:
        entry: The run's row of the table `refused_pages`.
        run: Its row of the table of runs.
        samples: Its samples.
        points: Its plateaus.
        settings: Settings of the campaign.
        rig_class: The class of the kind of rig.
    """
    signals = rig_class.make_signals(arrays_of_samples(samples), run["rig"], settings)
    has_times = bool(np.isfinite(signals.time_s).all())
    # readings without a clock are drawn over their rows
    if not has_times:
        signals = replace(signals, time_s=signals.row_numbers.astype(float))
    abscissa = signals.time_s
    heading_lines = _heading_lines(entry, run)
    panel_count = len(rig_class.shown_signals)
    # sizes in inches
    sheet = Sheet(
        panel_count,
        width=style.DOUBLE_COLUMN_IN,
        height=_PANELS_HEIGHT_IN / panel_count,
        left=0.85,
        down=0.1,
        top=0.1 + 0.13 * len(heading_lines),
        sharex=True,
    )
    fails_own_gates = _fails_own_gates(points)
    refused_times = _time_range(signals, entry["first_row"], entry["last_row"])
    for index, (name, label) in enumerate(rig_class.shown_signals.items()):
        panel = sheet.panel(index, title=None)
        panel.axes.set_ylabel(label, fontsize=7)
        panel.axes.yaxis.set_label_coords(-0.095, 0.5)
        panel.axes.grid(axis="x", visible=False)
        _draw_signal(panel, abscissa, signals[name])
        _shade_plateaus(panel, signals, points[~fails_own_gates], _PASSING)
        _shade_plateaus(panel, signals, points[fails_own_gates], _FAILING)
        for time in refused_times:
            panel.axes.axvline(time, color=style.STATE_COLOURS["refused"], linewidth=1.0)
    margin = 0.01 * (abscissa.max() - abscissa.min()) or 1.0
    sheet.axes_of_panels[0].set_xlim(abscissa.min() - margin, abscissa.max() + margin)
    sheet.axes_of_panels[-1].set_xlabel(
        "Time on the log's clock (s)" if has_times else "Row of the log"
    )
    sheet.axes_of_panels[0].set_title(
        "\n".join(heading_lines), x=-0.11, fontsize=7, parse_math=False
    )
    marked_rows = "concerns the whole run"
    if entry["last_row"]:
        marked_rows = f"rows {entry['first_row']} to {entry['last_row']}"
    sheet.legend(
        [
            Patch(**_PASSING, label="plateau that passes its own gates"),
            Patch(**_FAILING, label="plateau refused by its own gates"),
            style.line_handle(marked_rows, color=style.STATE_COLOURS["refused"]),
        ]
    )
    return sheet.finish(SIMULATED if settings.campaign.data == "simulated" else "")


def _draw_signal(panel: Panel, abscissa: FloatArray, values: FloatArray) -> None:
    """Draw one signal against time or row, or write that it was not logged."""
    if not np.isfinite(values).any():
        panel.write_message("not logged")
        panel.axes.set_yticks([])
        return
    marker = "." if len(values) < _MARKERS_MAX else ""
    panel.axes.plot(abscissa, values, color="black", linewidth=0.6, marker=marker, markersize=2)
    panel.axes.ticklabel_format(axis="y", useOffset=False)
    panel.axes.margins(y=0.12)
    panel.axes.locator_params(nbins=5)


def _shade_plateaus(
    panel: Panel, signals: Signals, plateaus: pd.DataFrame, look: style.Look
) -> None:
    """Shade the times of plateaus behind a signal."""
    spans = []
    for first_row, last_row in zip(plateaus["first_row"], plateaus["last_row"], strict=True):
        start, stop = _time_range(signals, first_row, last_row)
        spans.append((start, stop - start))
    # from the bottom to the top of the panel
    transform = panel.axes.get_xaxis_transform()
    panel.axes.broken_barh(spans, (0, 1), transform=transform, zorder=0.5, **look)


def _rows_to_mark(refusals: pd.DataFrame, points: pd.DataFrame) -> tuple[str, int, int]:
    """What the marked rows are, in the words of the column `place`; the first and the last of them.

    They are the rows of the refusals, else those of failing plateaus, else the whole run (0, 0).
    """
    with_rows = refusals[refusals["first_row"] > 0]
    failing_plateaus = points[_fails_own_gates(points)]
    for place, rows in (("rows", with_rows), ("plateaus", failing_plateaus)):
        if len(rows):
            return place, int(rows["first_row"].min()), int(rows["last_row"].max())
    return "whole run", 0, 0


def _fails_own_gates(points: pd.DataFrame) -> "pd.Series[bool]":
    """Whether each plateau fails a gate of its own, and not only because its run was refused."""
    return failed_gates.failed_any_of(points, (gate.name for gate in PLATEAU_GATES))


def _heading_lines(entry: Mapping[str, Any], run: Mapping[str, Any]) -> list[str]:
    """Lines of the heading of a page, in characters that the font has."""
    file_text = "" if entry["file"] == entry["run_id"] else f"file {entry['file']}, "
    description = (
        f"{file_text}oil {run['oil']}, rig {run['rig']}, set points: {describe_condition(run)}; "
        f"{run['samples']} rows"
    )
    # a long text is cut after its largest number of lines; the listing has all of it
    lines_max_of_text = (
        (f"REFUSED: {entry['run_id']}", 1),
        (description, 2),
        (f"{entry['rule']}: {entry['reason']}", 4),
        (f"What to do: {entry['advice']}", 4),
    )
    lines: list[str] = []
    for text, lines_max in lines_max_of_text:
        wrapper = textwrap.TextWrapper(_LETTERS_PER_LINE, max_lines=lines_max, placeholder=" ...")
        lines += wrapper.wrap(style.plain_text(text))
    return lines


def _time_range(signals: Signals, first_row: int, last_row: int) -> tuple[float, float]:
    """First and last time (s) of a range of rows.

    From 0 to 0 means all rows. Where no row of the range was read, the nearest one is taken.
    """
    is_inside = (signals.row_numbers >= first_row) & (signals.row_numbers <= last_row)
    if last_row == 0:
        is_inside[:] = True
    if not is_inside.any():
        nearest_index = np.abs(signals.row_numbers - first_row).argmin()
        is_inside[nearest_index] = True
    times = signals.time_s[is_inside]
    return float(times.min()), float(times.max())
