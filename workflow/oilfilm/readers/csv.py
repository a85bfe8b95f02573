"""Text logs with one row an instant: a header, one line of column names, then the rows.

data/raw/README.md describes what may vary between logs; `layout` finds it out.
"""

import io
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
import pyarrow as arrow
import pyarrow.csv as arrow_csv

from oilfilm.contact import load_for_max_hertz_pressure
from oilfilm.readers.base import (
    LARGEST_READING,
    LoggedRun,
    Nominal,
    Reading,
    Refusal,
    as_ranges,
    refused_file,
    samples_frame,
)
from oilfilm.readers.layout import (
    QUANTITIES,
    Layout,
    LayoutError,
    count_rows,
    find_layout,
    normalise,
)
from oilfilm.rigs import contact_of
from oilfilm.units import PA_PER_GPA, rpm_to_surface_speed

FloatArray = npt.NDArray[np.float64]
IndexArray = npt.NDArray[np.int64]

_SET_POINTS = ("max_hertz_pressure_gpa", "load_n", "entrainment_speed_m_s", "inlet_temperature_c")
_FORMAT = "data/raw/README.md describes the format."


class CsvReader:
    """Text logs in columns, in any dialect."""

    name = "csv"

    def recognises(self, head: bytes) -> bool:
        """True for text with a `#` comment or a line of several cells near its top."""
        text = normalise(head).decode("utf-8", "replace").lstrip("\ufeff \n")
        if not text or "\0" in text[:200]:
            return False
        return text.startswith("#") or any(
            line.count(mark) >= 3 for line in text.splitlines()[:100] for mark in ",;\t|"
        )

    def read(self, content: bytes, file: str, config: Mapping[str, Any]) -> Reading:
        """See `Reader.read`."""
        try:
            layout = find_layout(content, config["campaign"].get("columns", {}))
        except LayoutError as error:
            return refused_file(error.rows, "columns", str(error), f"{_FORMAT}")
        whole, _, tail = layout.table.rpartition(b"\n")
        rows = count_rows(layout.table)
        problem = _header_problem(layout, config)
        if problem:
            return refused_file(rows, *problem)
        values, numbers, bad = _parse(whole, layout)
        refusals = [_bad_range(file, first, last) for first, last in as_ranges(bad)]
        cut = _cut_row(tail, layout, rows, file)
        if cut is not None:
            refusals.append(cut)
        flaw = f"truncated: {cut.reason}" if cut and cut.rule == "cut_row" else ""
        return Reading(rows, [_run(values, numbers, layout, file, config, flaw)], refusals)


def _header_problem(layout: Layout, config: Mapping[str, Any]) -> tuple[str, str, str] | None:
    keys = layout.keys
    oil, rig = keys.get("oil"), keys.get("rig", next(iter(config["rigs"])))
    if oil is None:
        return ("header", "the header has no line `# oil: ...`", f"Add it. {_FORMAT}")
    for kind, name, known in (("oil", oil, config["oils"]), ("rig", rig, config["rigs"])):
        if name not in known:
            return (
                f"unknown_{kind}",
                f"the header says {kind} {name!r}; the campaign knows {', '.join(known)}",
                f"Correct the header, or add the {kind} to the campaign file.",
            )
    if keys.get("simulated", "no") != "no" and config["campaign"]["data"] == "measured":
        return (
            "simulated_log",
            "the header says that the log is simulated; the campaign file says data: measured",
            "Take the log out, or say data: simulated in the campaign file.",
        )
    for name in _SET_POINTS:
        try:
            float(keys.get(name, "0"))
        except ValueError:
            return (
                "header",
                f"the header says {name}: {keys[name]!r}; expected a number",
                f"Correct the header. {_FORMAT}",
            )
    return _rig_problem(layout, rig, config["rigs"][rig])


def _rig_problem(layout: Layout, name: str, rig: Mapping[str, Any]) -> tuple[str, str, str] | None:
    """What the columns need of the rig and its file does not say."""
    units = {column.quantity: column.to.unit for column in layout.columns}
    needed = [
        f"{body}_track_radius_m" for body in ("ball", "disc") if units[f"{body}_speed"] == "rpm"
    ]
    needed += ["ball_radius_m"] if units["load"] == "GPa" else []
    missing = [key for key in needed if key not in rig]
    if not missing:
        return None
    return (
        "rig",
        f"speeds in rpm or a load as pressure need {', '.join(missing)} of the rig {name!r}",
        f"Add it to config/rigs/{name}.yaml.",
    )


def _parse(table: bytes, layout: Layout) -> tuple[dict[str, FloatArray], IndexArray, IndexArray]:
    """Values of the good rows by quantity, their row numbers, and those of the bad rows."""
    misfits: list[int] = []
    names = [f"c{place}" for place in range(layout.width)]
    wanted = [names[column.place] for column in layout.columns]

    def skip(row: arrow_csv.InvalidRow) -> str:
        misfits.append(row.number)
        return "skip"

    def parse(as_type: arrow.DataType, decimal_mark: str) -> pd.DataFrame:
        misfits.clear()
        return arrow_csv.read_csv(
            io.BytesIO(table),
            # one thread: only then are the rows that do not fit numbered
            read_options=arrow_csv.ReadOptions(use_threads=False, column_names=names),
            parse_options=arrow_csv.ParseOptions(
                delimiter=layout.delimiter,
                # a stray quote must not swallow the lines up to the next one
                quote_char=False,
                invalid_row_handler=skip,
            ),
            convert_options=arrow_csv.ConvertOptions(
                include_columns=wanted,
                column_types=dict.fromkeys(wanted, as_type),
                decimal_point=decimal_mark,
            ),
        ).to_pandas()

    if not table:
        nothing = np.array([], dtype=np.int64)
        return {quantity: np.array([]) for quantity in QUANTITIES}, nothing, nothing
    try:
        cells = parse(arrow.float64(), layout.decimal_mark)
    except arrow.ArrowInvalid:
        cells = parse(arrow.binary(), ".").apply(_numbers, decimal_mark=layout.decimal_mark)
    bad_shape = np.array(misfits, dtype=np.int64)
    numbers = np.delete(np.arange(1, len(cells) + len(misfits) + 1), bad_shape - 1)
    good = (cells.abs() < LARGEST_READING).all(axis="columns").to_numpy()
    values = {
        column.quantity: cells[names[column.place]].to_numpy()[good] * column.to.scale
        + column.to.offset
        for column in layout.columns
    }
    return values, numbers[good], np.sort(np.concatenate([numbers[~good], bad_shape]))


def _numbers(cells: "pd.Series[Any]", decimal_mark: str) -> "pd.Series[float]":
    """Numbers of raw cells; NaN where a cell holds anything else."""
    text = cells.map(lambda cell: cell.decode("utf-8", "replace").strip(' "'), na_action="ignore")
    if decimal_mark == ",":
        # a point would be a second decimal mark: such a cell is no number
        text = text.str.replace(".", "?", regex=False).str.replace(",", ".", regex=False)
    return pd.to_numeric(text, errors="coerce").astype(float)


def _bad_range(run_id: str, first: int, last: int) -> Refusal:
    return Refusal(
        "unreadable_row",
        f"rows {first} to {last}: cells are missing, too many, not numbers or absurdly large",
        "Look at these rows of the raw log; the rows around them are used.",
        run_id,
        first,
        last,
        last - first + 1,
    )


def _cut_row(tail: bytes, layout: Layout, row: int, run_id: str) -> Refusal | None:
    """What to make of a last line without a line end."""
    if not tail:
        return None
    columns = layout.width
    cells = tail.count(layout.delimiter.encode()) + 1
    if cells < columns:
        reason = f"the log ends in the middle of row {row} (its last good row is {row - 1})"
        advice = "Nothing can be made of half a row; see what became of the run."
        return Refusal("cut_row", reason, advice, run_id, row, row, 1)
    reason = f"row {row}, the last, has no line end, so that its last number may be cut"
    return Refusal("unterminated_row", reason, "End the file with a line end.", run_id, row, row, 1)


def _run(
    values: Mapping[str, FloatArray],
    numbers: IndexArray,
    layout: Layout,
    run_id: str,
    config: Mapping[str, Any],
    flaw: str,
) -> LoggedRun:
    keys = layout.keys
    rig_name = keys.get("rig", next(iter(config["rigs"])))
    rig = config["rigs"][rig_name]
    units = {column.quantity: column.to.unit for column in layout.columns}
    samples = samples_frame(
        row=numbers,
        time_s=values["time"],
        load_n=_load_n(values["load"], units["load"], rig),
        traction_force_n=config["campaign"].get("traction_sign", 1) * values["traction_force"],
        ball_speed_m_s=_surface_speed(values, units, rig, "ball"),
        disc_speed_m_s=_surface_speed(values, units, rig, "disc"),
        inlet_temperature_c=values["inlet_temperature"],
    )
    nominal = Nominal(**{name: float(keys[name]) for name in _SET_POINTS if name in keys})
    return LoggedRun(run_id, keys["oil"], rig_name, "continuous", nominal, samples, flaw)


def _load_n(values: FloatArray, unit: str, rig: Mapping[str, Any]) -> FloatArray:
    """Load in N; a load logged as maximum Hertz pressure by way of the rig's contact."""
    contact = contact_of(rig)
    if unit == "N" or contact is None:
        return values
    return load_for_max_hertz_pressure(
        values * PA_PER_GPA, contact.radius_m, contact.reduced_modulus_pa
    )


def _surface_speed(
    values: Mapping[str, FloatArray], units: Mapping[str, str], rig: Mapping[str, Any], body: str
) -> FloatArray:
    speed = values[f"{body}_speed"]
    if units[f"{body}_speed"] == "m/s":
        return speed
    return rpm_to_surface_speed(speed, rig[f"{body}_track_radius_m"])
