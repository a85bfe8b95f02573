"""The same run written in each raw format, for the tests of readers."""

import io
from collections.abc import Mapping
from typing import Any

import numpy as np
import pyarrow as arrow
import pyarrow.parquet as parquet
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

# Columns of a log and their units by name, and header keys.
Columns = Mapping[str, np.ndarray]
Units = Mapping[str, str]
Keys = Mapping[str, Any]

NAMES = "time load traction_force ball_speed disc_speed inlet_temperature".split()
# Mean of each column but the time, in the units of `UNITS`.
MEANS = dict(zip(NAMES[1:], (82, 0, 28650, 7160, 343), strict=True))
KEYS = {"oil": "4102", "max_hertz_pressure_gpa": 1.25, "entrainment_speed_m_s": 30}


def columns(rows: int) -> dict[str, np.ndarray]:
    """Numbers of a log without regard to what a rig would measure."""
    random = np.random.default_rng(1)
    noisy = {name: mean + random.standard_normal(rows) for name, mean in MEANS.items()}
    return {"time": np.arange(rows) / 50, **noisy}


UNITS = dict(zip(NAMES, "s kgf N rpm 1/min K".split(), strict=True))


def csv(values: Columns, units: Units = UNITS, keys: Keys = KEYS) -> bytes:
    """A log as CSV, with units in the names of columns and one header line per key."""
    lines = [f"# {key}: {value}" for key, value in keys.items()]
    lines.append(",".join(f"{name} [{units[name]}]" for name in values))
    lines += [",".join(map(repr, row)) for row in np.column_stack(list(values.values())).tolist()]
    return ("\n".join(lines) + "\n").encode()


def tdms_channels(group: str, values: Columns, units: Units = UNITS) -> list[ChannelObject]:
    return [
        ChannelObject(group, name, column, {"unit_string": units.get(name, "")})
        for name, column in values.items()
    ]


def tdms_file(*segments: list[Any]) -> bytes:
    """A TDMS file with one segment per list of objects."""
    buffer = io.BytesIO()
    with TdmsWriter(buffer) as writer:
        for segment in segments:
            writer.write_segment(segment)
    return buffer.getvalue()


def tdms(values: Columns, units: Units = UNITS, keys: Keys = KEYS, segments: int = 1) -> bytes:
    """A log as TDMS, its rows in as many segments."""
    root, group = RootObject(keys), GroupObject("run")
    parts_of_columns = {name: np.array_split(column, segments) for name, column in values.items()}
    channels_of_segments = []
    for index in range(segments):
        part = {name: parts[index] for name, parts in parts_of_columns.items()}
        channels_of_segments.append(tdms_channels("run", part, units))
    return tdms_file([root, group], *channels_of_segments)


def lvm_segment(values: Columns, units: Units, mark: str, notes: str = "") -> list[str]:
    """Lines of one segment of an LVM file; `mark` is its decimal mark."""
    names = [name for name in values if name != "time"]
    rows = np.column_stack([values["time"], *(values[name] for name in names)]).tolist()
    count = len(rows)
    return [
        f"Channels\t{len(names)}",
        *([f"Notes\t{notes}"] if notes else []),
        "Samples\t" + "\t".join([str(count)] * len(names)),
        "Y_Unit_Label\t" + "\t".join(units[name] for name in names),
        "X_Dimension\t" + "\t".join(["Time"] * len(names)),
        "X0\t" + "\t".join(["0.0000000000000000E+0".replace(".", mark)] * len(names)),
        "Delta_X\t" + "\t".join(["0.020000".replace(".", mark)] * len(names)),
        "***End_of_Header***" + "\t" * len(names),
        "X_Value\t" + "\t".join(names) + "\tComment",
        *("\t".join(repr(cell).replace(".", mark) for cell in row) for row in rows),
        "",
    ]


def lvm_header(keys: Keys, mark: str = ".", x_columns: str = "One") -> list[str]:
    """Lines of the header of an LVM file; `mark` is its decimal mark."""
    return [
        *("LabVIEW Measurement\t", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab"),
        *(f"Decimal_Separator\t{mark}", "Multi_Headings\tYes", f"X_Columns\t{x_columns}"),
        "Time_Pref\tRelative",
        "Description\t" + "; ".join(f"{key}: {value}" for key, value in keys.items()),
        *("Date\t2026/01/10", "***End_of_Header***\t", ""),
    ]


def lvm(values: Columns, units: Units = UNITS, keys: Keys = KEYS, mark: str = ".") -> bytes:
    """A log as LabVIEW measurement file, with this decimal mark."""
    lines = lvm_header(keys, mark) + lvm_segment(values, units, mark)
    return "\r\n".join(lines).encode()


def table(values: Columns, units: Units = UNITS, keys: Keys = KEYS) -> arrow.Table:
    """A log as Arrow table, with units and header keys as metadata."""
    fields = [
        arrow.field(name, arrow.array(column).type, metadata={"unit": units.get(name, "")})
        for name, column in values.items()
    ]
    metadata = {key: str(value) for key, value in keys.items()}
    return arrow.table(list(values.values()), schema=arrow.schema(fields, metadata))


def parquet_file(content: arrow.Table, **options: Any) -> bytes:
    """An Arrow table as Parquet file."""
    buffer = io.BytesIO()
    parquet.write_table(content, buffer, **options)
    return buffer.getvalue()


def as_parquet(values: Columns, units: Units = UNITS, keys: Keys = KEYS, **options: Any) -> bytes:
    """A log as Parquet file."""
    return parquet_file(table(values, units, keys), **options)


WRITERS = {"csv": csv, "tdms": tdms, "lvm": lvm, "parquet": as_parquet}
