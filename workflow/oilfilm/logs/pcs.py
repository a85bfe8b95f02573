"""Text exports of PCS Instruments rigs: MTM and ETM (traction), EHD (film thickness).

An export is a sequence of steps, each with lines of its own and, for some, a table. Steps are
found by their structure; the lines above the first one are not relied on. Traction steps measure
each slip in both directions: index 1 with the disc faster, index 2 with the ball faster.

Decides: what a PCS export holds.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pandas as pd

from oilfilm.logs.base import (
    LARGEST_READING,
    LogColumn,
    LoggedRun,
    Names,
    Reading,
    Refusal,
    TextForm,
    Understood,
    distinct,
    number,
    refused_file,
    refused_ranges,
    samples_of_run,
)
from oilfilm.logs.encoding import encodings_of
from oilfilm.logs.header import FORMAT_ADVICE
from oilfilm.logs.log_kind import FloatArray, IndexArray, LogKind
from oilfilm.logs.run_sheet import Labels, SheetOfLog
from oilfilm.logs.traction_log import TRACTION, nominal
from oilfilm.settings.resolved import Settings
from oilfilm.units import Conversion

_STEP = re.compile(r"^Step (\d{1,9})\b.* started at (.+)$")
_DATE_FORMATS = ("%d/%m/%Y %H:%M:%S", "%d/%m/%Y %H:%M")
# A row of a table, were it cut after its first cell.
_ROW = re.compile(r"^(\s*[-+.\d]|.*\t.*\t.*\t)")
# So many cells are a row even where the line of names above them is damaged.
_TABS_OF_A_ROW = 6
# Step types whose rows are settled readings; the others (warm-up, mapping) are no sweep.
_SWEEPS = {"traction", "film"}
# Our name -> quantity, unit, and the names that the programs of the different rigs give the column.
_COLUMNS = {
    "time_s": ("time", "s", "Step Time (s)"),
    "load_n": ("load", "N", "Ball Load (N)"),
    "ball_1": ("ball_speed_1", "mm/s", "Ball Speed 1"),
    "ball_2": ("ball_speed_2", "mm/s", "Ball Speed 2"),
    "disc_1": ("disc_speed_1", "mm/s", "Disc Speed 1"),
    "disc_2": ("disc_speed_2", "mm/s", "Disc Speed 2"),
    "rolling": ("entrainment_speed", "mm/s", "Rolling Speed (mm/s)"),
    "sliding": ("sliding_speed", "mm/s", "Sliding Speed (mm/s)"),
    "srr": ("slide_roll_ratio", "%", "SRR (%)"),
    "force_1": ("traction_force_1", "N", "TF1 (N)", "Traction Force 1 (N)"),
    "force_2": ("traction_force_2", "N", "TF2 (N)", "Traction Force 2 (N)"),
    "force": ("traction_force", "N", "Traction Force (N)"),
    "coefficient": ("traction_coefficient", "1", "Traction Coeff (-)"),
    "inlet_temperature_c": (
        "inlet_temperature",
        "degC",
        *("Lube RTD Temp (degC)", "Lube Temp (°C)", "Lube Temp (degC)"),
    ),
    "film_nm": ("film_thickness", "nm", "Average Film (nm)"),
}
# Room for floating point where an identity holds to exactly half a printed digit.
_FLOATING = 1e-9
_REQUIRED = ("time_s", "load_n", "ball_1", "disc_1", "rolling", "sliding", "srr")


@dataclass
class _Step:
    """One step of the file."""

    number: int
    started: str
    type: str = "unknown"
    names: list[str] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)
    first_row: int = 0

    @property
    def rows(self) -> IndexArray:
        return np.arange(self.first_row, self.first_row + len(self.lines))


def recognises(head: bytes) -> bool:
    """True where the first lines have a PCS step or the title of a PCS file."""
    text = head.decode("utf-8-sig", "replace")
    return any(_STEP.match(line) or "Test Data File" in line for line in text.splitlines()[:40])


def read(
    content: bytes, file: str, settings: Settings, kind: LogKind, sheet: SheetOfLog
) -> Reading:
    """See `Reader.read`."""
    text, encoding = _decode(content)
    steps = list(_steps(text.splitlines()))
    labels = distinct(f"step{step.number:03d}" for step in steps)
    rows = sum(len(step.lines) for step in steps)
    if kind is not TRACTION:
        reason = f"the file is an export of a PCS traction rig, not a {kind.vocabulary.name} log"
        advice = "Move it to the folder of the campaign's traction logs."
        return refused_file(rows, "columns", reason, advice)
    runs: list[LoggedRun] = []
    refusals = list(_misdated(steps))
    cut = bool(text) and not text.endswith(("\n", "\r"))
    for step, label in zip(steps, labels, strict=True):
        if step.lines:
            last_is_cut = cut and step is steps[-1]
            run_id = f"{file}:{label}"
            known = sheet.labels(run_id, {}, settings, label)
            run, refused = _read_step(step, run_id, known, settings, last_is_cut)
            runs += [run] if run is not None else []
            refusals += refused
    return Reading(rows, runs, refusals, TextForm.of(encoding, "\t", "."))


def names(content: bytes) -> list[Names]:
    """See `Reader.names`: exports of these programs have the columns above."""
    return []


def _decode(content: bytes) -> tuple[str, str]:
    """The text and the encoding that it is in."""
    # older programs write the degree sign in the encoding of western Windows
    likely = encodings_of(content)[0]
    encoding = likely if likely in {"ascii", "utf-8"} else "cp1252"
    return content.decode(encoding, "replace").removeprefix("\ufeff"), encoding


def _steps(lines: Iterable[str]) -> Iterator[_Step]:
    """Steps of a file; rows are counted through the file, from 1."""
    step: _Step | None = None
    row = 1
    for line in lines:
        start = _STEP.match(line)
        if start:
            if step is not None:
                yield step
            step = _Step(int(start[1]), start[2].strip())
        elif step is None:
            continue
        elif line.startswith("Step type\t"):
            step.type = line.split("\t")[1].strip()
        elif "Step Time (s)" in line:
            if step.lines:
                # a second table in one step: the line that began another step is damaged
                yield step
                step = _Step(step.number, step.started, step.type)
            step.names = [name.strip() for name in line.split("\t")]
            step.first_row = row
        elif _ROW.match(line) and (step.names or line.count("\t") >= _TABS_OF_A_ROW):
            step.first_row = step.first_row or row
            step.lines.append(line)
            row += 1
    if step is not None:
        yield step


def _misdated(steps: list[_Step]) -> Iterator[Refusal]:
    """Steps dated after a later one: the clock or the file's order is not to be trusted."""
    started = pd.Series([step.started for step in steps], dtype=str)
    full, short = (pd.to_datetime(started, format=form, errors="coerce") for form in _DATE_FORMATS)
    dates = full.fillna(short)
    for (step, following), later in zip(pairwise(steps), dates > dates.shift(-1), strict=False):
        if later:
            yield Refusal(
                "misdated_step",
                f"step {step.number} is dated {step.started}, after step {following.number} "
                f"({following.started})",
                "No row is refused for it; do not rely on the dates of these steps.",
            )


def _read_step(
    step: _Step, run_id: str, labels: Labels, settings: Settings, cut: bool
) -> tuple[LoggedRun | None, list[Refusal]]:
    columns = _column_indices(step.names)
    missing = [_COLUMNS[name][2] for name in _REQUIRED if name not in columns]
    problem = labels.problem or _unlabelled(labels.keys, settings)
    if step.type.lower() not in _SWEEPS:
        problem = Refusal(
            "not_a_sweep",
            f"step {step.number} is of type {step.type[:60]!r}; expected a traction or film sweep",
            "Nothing to do: such rows carry no traction curve.",
        )
    elif missing:
        reason = f"step {step.number} lacks the columns {', '.join(missing)}"
        problem = Refusal("columns", reason, "Export the step again with all columns.")
    if problem is not None:
        last = step.first_row + len(step.lines) - 1
        return None, [problem.of_rows(run_id, step.first_row, last)]
    values, readable = _cells(step, columns)
    if cut:
        readable[-1] = False
    sound = readable & _identities_hold(values)
    refusals = [
        *refused_ranges(
            run_id,
            step.rows[~readable],
            "unreadable_row",
            "cells are missing, cut or no numbers",
            "Look at these rows of the raw file.",
        ),
        *refused_ranges(
            run_id,
            step.rows[readable & ~sound],
            "identity_broken",
            "the row contradicts itself: its speeds, slip, forces and coefficient do not agree",
            "Look at these rows: a sensor or the export has failed there.",
        ),
    ]
    sound_values = {name: array[sound] for name, array in values.items()}
    understood = _understood(step.names, columns, values, labels.sources)
    return _run(run_id, sound_values, step.rows[sound], understood, labels, settings), refusals


def _understood(
    names: list[str],
    columns: Mapping[str, int],
    values: Mapping[str, FloatArray],
    sources: Mapping[str, str],
) -> Understood:
    """What the columns of a step were taken for, in the units of the program."""
    read = [
        LogColumn.of(names[index], unit, quantity, Conversion(unit), values[ours])
        for ours, index in columns.items()
        for quantity, unit, *_ in (_COLUMNS[ours],)
    ]
    used = {column.name for column in read}
    return Understood(read, [name for name in names if name not in used], sources)


def _unlabelled(keys: Mapping[str, str], settings: Settings) -> Refusal | None:
    """Why nothing says which oil and which rig a step is of."""
    several = {"oil": list(settings.oils), "rig": list(settings.rigs)}
    lacking = [key for key, known in several.items() if key not in keys and len(known) > 1]
    if not lacking:
        return None
    what = " and ".join(f"{key} ({len(several[key])} in the campaign)" for key in lacking)
    return Refusal(
        "unknown_oil" if "oil" in lacking else "unknown_rig",
        f"a PCS export does not name its {what}",
        f"Name it in the run sheet of the campaign. {FORMAT_ADVICE}",
    )


def _column_indices(names: list[str]) -> dict[str, int]:
    """Position of each known column; the first columns of a table repeat later ones."""
    return {
        ours: len(names) - 1 - names[::-1].index(theirs)
        for ours, (_, _, *known) in _COLUMNS.items()
        for theirs in known
        if theirs in names
    }


def _cells(
    step: _Step, columns: Mapping[str, int]
) -> tuple[dict[str, FloatArray], npt.NDArray[np.bool_]]:
    """Numbers of the known columns (blank: NaN) and whether each row can be read."""
    cells = [line.split("\t") for line in step.lines]
    values = {name: np.full(len(cells), np.nan) for name in _COLUMNS}
    values |= {
        name: np.array([_number(row[place : place + 1]) for row in cells])
        for name, place in columns.items()
    }
    readable = [~(np.abs(numbers) > LARGEST_READING) for numbers in values.values()]
    readable += [~np.isnan(values[name]) for name in _REQUIRED]
    return values, np.logical_and.reduce(readable)


def _number(cell: Sequence[str]) -> float:
    """The number of a cell; NaN where it is blank or missing, infinity where it holds none."""
    try:
        return number(cell[0]) if cell and cell[0].strip() else np.nan
    except ValueError:
        return np.inf


def _identities_hold(values: Mapping[str, FloatArray]) -> npt.NDArray[np.bool_]:
    """Whether each row agrees with itself to the rounding of its cells.

    TF = (TF1 - TF2)/2; coefficient = |TF|/W; rolling = mean surface speed; sliding = disc minus
    ball, directions averaged; SRR = 100 sliding/rolling. Identities of cells that the rig leaves
    blank are not asked.
    """
    ball, disc = _surface_speeds(values)
    rolling, force, srr = values["rolling"], values["force"], values["srr"]
    abs_load, abs_rolling = np.abs(values["load_n"]), np.abs(rolling)
    with np.errstate(divide="ignore", invalid="ignore"):
        # what rounding each cell of the identity to its printed digits can make of it
        differences = (
            (force - (values["force_1"] - values["force_2"]) / 2, 1e-4),
            (np.abs(force) / values["load_n"] - values["coefficient"], 5e-5 + 1e-4 / abs_load),
            (rolling - (ball + disc) / 2, 0.010),
            (values["sliding"] - (disc - ball), 0.015),
            # both speeds rounded to 0.01 mm/s, SRR to 0.001 %
            (
                srr - 100 * values["sliding"] / rolling,
                (0.5 + 0.005 * np.abs(srr)) / abs_rolling + 0.0005,
            ),
        )
        broken = [np.abs(difference) > allowed + _FLOATING for difference, allowed in differences]
    return np.asarray(~np.any(broken, axis=0))


def _surface_speeds(values: Mapping[str, FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Ball and disc speed as if the disc were the faster body in both directions, in mm/s."""
    two_ways = ~np.isnan(values["ball_2"]) & ~np.isnan(values["disc_2"])
    slower = np.where(two_ways, (values["ball_1"] + values["disc_2"]) / 2, values["ball_1"])
    faster = np.where(two_ways, (values["disc_1"] + values["ball_2"]) / 2, values["disc_1"])
    return slower, faster


def _run(
    run_id: str,
    values: Mapping[str, FloatArray],
    rows: IndexArray,
    understood: Understood,
    labels: Labels,
    settings: Settings,
) -> LoggedRun:
    ball, disc = _surface_speeds(values)
    samples = samples_of_run(
        row=rows,
        time_s=values["time_s"],
        load_n=values["load_n"],
        traction_force_n=values["force"],
        traction_force_1_n=values["force_1"],
        traction_force_2_n=values["force_2"],
        ball_speed_m_s=ball * 1e-3,
        disc_speed_m_s=disc * 1e-3,
        inlet_temperature_c=values["inlet_temperature_c"],
        measured_film_thickness_um=values["film_nm"] * 1e-3,
    )
    keys = labels.keys
    return LoggedRun(
        run_id,
        keys["oil"],
        keys.get("rig", next(iter(settings.rigs))),
        "steps",
        nominal(keys, settings),
        samples,
        labels.excluded,
        understood=understood,
    )
