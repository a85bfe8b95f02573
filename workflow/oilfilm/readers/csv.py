"""Comma-separated logs: a `# key: value` header, one line of column names, then the rows.

data/raw/README.md describes the format for the person who writes such files.
"""

import io
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
import pyarrow as arrow
import pyarrow.csv as arrow_csv

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
from oilfilm.units import rpm_to_surface_speed

_COLUMNS = (
    "time_s",
    "load_n",
    "traction_force_n",
    "ball_speed_rpm",
    "disc_speed_rpm",
    "inlet_temperature_c",
)
_SET_POINTS = ("max_hertz_pressure_gpa", "load_n", "entrainment_speed_m_s", "inlet_temperature_c")
_FORMAT = "data/raw/README.md describes the format."


class CsvReader:
    """The project's own csv format."""

    name = "csv"

    def recognises(self, head: bytes) -> bool:
        """True where the file starts with a `#` comment or with the first column's name."""
        return head.lstrip().startswith((b"#", _COLUMNS[0].encode()))

    def read(self, content: bytes, file: str, config: Mapping[str, Any]) -> Reading:
        """See `Reader.read`."""
        keys, table = _split_header(content)
        whole, _, tail = table.rpartition(b"\n")
        names = whole.partition(b"\n")[0].decode("utf-8", "replace").strip().split(",")
        rows = _count_rows(whole) + bool(tail.strip())
        problem = _header_problem(keys, config) or _column_problem(names)
        if problem:
            return refused_file(rows, *problem)
        values, numbers, bad = _parse(whole)
        refusals = [_bad_range(file, first, last) for first, last in as_ranges(bad)]
        cut = _cut_row(tail, len(names), rows, file)
        if cut is not None:
            refusals.append(cut)
        flaw = f"{cut.rule}: {cut.reason}" if cut and cut.rule == "truncated" else ""
        return Reading(rows, [_run(values, numbers, keys, file, config, flaw)], refusals)


def _split_header(content: bytes) -> tuple[dict[str, str], bytes]:
    """The header's keys and the bytes from the line of column names on."""
    keys: dict[str, str] = {}
    start = 0
    while start < len(content):
        end = content.find(b"\n", start)
        line = content[start : end if end >= 0 else len(content)].strip()
        if line and not line.startswith(b"#"):
            break
        key, colon, value = line.lstrip(b"#").decode("utf-8", "replace").partition(":")
        if colon:
            keys[key.strip()] = value.strip()
        start = end + 1 if end >= 0 else len(content)
    return keys, content[start:]


def _count_rows(table: bytes) -> int:
    """Lines that hold something, but for the line of names."""
    if b"\n\n" in table or b"\r" in table:
        lines = sum(bool(line.strip()) for line in table.split(b"\n"))
    else:
        lines = table.count(b"\n") + bool(table)
    return max(lines - 1, 0)


def _header_problem(
    keys: Mapping[str, str], config: Mapping[str, Any]
) -> tuple[str, str, str] | None:
    oil, rig = keys.get("oil"), keys.get("rig", next(iter(config["rigs"])))
    if oil is None:
        return ("header", "the header has no line `# oil: ...`", f"Add it. {_FORMAT}")
    if oil not in config["oils"]:
        known = ", ".join(config["oils"])
        return (
            "unknown_oil",
            f"the header says oil {oil!r}; the campaign knows {known}",
            "Correct the header, or add the oil to the campaign file.",
        )
    if rig not in config["rigs"]:
        known = ", ".join(config["rigs"])
        return (
            "unknown_rig",
            f"the header says rig {rig!r}; the campaign knows {known}",
            "Correct the header, or add the rig to the campaign file.",
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
    return None


def _column_problem(names: list[str]) -> tuple[str, str, str] | None:
    missing = [name for name in _COLUMNS if name not in names]
    repeated = sorted({name for name in names if names.count(name) > 1})
    if not missing and not repeated:
        return None
    found = f"lacks the columns {', '.join(missing)}" if missing else f"repeats {repeated[0]!r}"
    return (
        "columns",
        f"the line of column names {found}; it reads {','.join(names)[:200]!r}",
        f"Name the columns as expected, once each. {_FORMAT}",
    )


def _parse(
    table: bytes,
) -> tuple[pd.DataFrame, npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Values of the good rows, their row numbers, and the numbers of the bad rows."""
    misfits: list[int] = []

    def skip(row: arrow_csv.InvalidRow) -> str:
        # rows are numbered from 1, the line of names included
        misfits.append(row.number - 1)
        return "skip"

    def parse(as_type: arrow.DataType) -> pd.DataFrame:
        misfits.clear()
        return arrow_csv.read_csv(
            io.BytesIO(table),
            # one thread: only then are the rows that do not fit numbered
            read_options=arrow_csv.ReadOptions(use_threads=False),
            parse_options=arrow_csv.ParseOptions(invalid_row_handler=skip),
            convert_options=arrow_csv.ConvertOptions(
                include_columns=list(_COLUMNS), column_types=dict.fromkeys(_COLUMNS, as_type)
            ),
        ).to_pandas()

    try:
        values = parse(arrow.float64())
    except arrow.ArrowInvalid:
        values = parse(arrow.binary()).apply(_numbers)
    numbers = np.delete(
        np.arange(1, len(values) + len(misfits) + 1), np.array(misfits, dtype=np.int64) - 1
    )
    good = (values.abs() < LARGEST_READING).all(axis="columns").to_numpy()
    bad = np.sort(np.concatenate([numbers[~good], np.array(misfits, dtype=np.int64)]))
    return values[good], numbers[good], bad


def _numbers(cells: "pd.Series[Any]") -> "pd.Series[float]":
    """Numbers of raw cells; NaN where a cell holds anything else."""
    text = cells.map(lambda cell: cell.decode("utf-8", "replace"), na_action="ignore")
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


def _cut_row(tail: bytes, columns: int, row: int, run_id: str) -> Refusal | None:
    """What to make of a last line without a line end."""
    if not tail.strip():
        return None
    cells = tail.count(b",") + 1
    if cells < columns:
        reason = f"the log ends in the middle of row {row} (its last good row is {row - 1})"
        advice = "The disk may have been full or the program killed: repeat the run."
        return Refusal("truncated", reason, advice, run_id, row, row, 1)
    reason = f"row {row}, the last, has no line end, so that its last number may be cut"
    return Refusal("unterminated_row", reason, "End the file with a line end.", run_id, row, row, 1)


def _run(
    values: pd.DataFrame,
    numbers: npt.NDArray[np.int64],
    keys: Mapping[str, str],
    run_id: str,
    config: Mapping[str, Any],
    flaw: str,
) -> LoggedRun:
    rig_name = keys.get("rig", next(iter(config["rigs"])))
    rig = config["rigs"][rig_name]
    samples = samples_frame(
        row=numbers,
        time_s=values["time_s"].to_numpy(),
        load_n=values["load_n"].to_numpy(),
        traction_force_n=values["traction_force_n"].to_numpy(),
        ball_speed_m_s=rpm_to_surface_speed(
            values["ball_speed_rpm"].to_numpy(), rig["ball_track_radius_m"]
        ),
        disc_speed_m_s=rpm_to_surface_speed(
            values["disc_speed_rpm"].to_numpy(), rig["disc_track_radius_m"]
        ),
        inlet_temperature_c=values["inlet_temperature_c"].to_numpy(),
    )
    nominal = Nominal(**{name: float(keys[name]) for name in _SET_POINTS if name in keys})
    return LoggedRun(run_id, keys["oil"], rig_name, "continuous", nominal, samples, flaw)
