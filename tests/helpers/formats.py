"""The same run written in each raw format, for the tests of readers."""

import io
from collections.abc import Mapping
from typing import Any

import numpy as np
import pyarrow as arrow
import pyarrow.parquet as parquet
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

Columns = Mapping[str, np.ndarray]
Units = Mapping[str, str]
Keys = Mapping[str, Any]

NAMES = "time load traction_force ball_speed disc_speed inlet_temperature".split()
MEANS = dict(zip(NAMES[1:], (82, 0, 28650, 7160, 343), strict=True))
KEYS = {"oil": "4102", "max_hertz_pressure_gpa": 1.25, "entrainment_speed_m_s": 30}


def columns(rows: int) -> dict[str, np.ndarray]:
    """Numbers of a log without regard to what a rig would measure."""
    random = np.random.default_rng(1)
    noisy = {name: mean + random.standard_normal(rows) for name, mean in MEANS.items()}
    return {"time": np.arange(rows) / 50, **noisy}


UNITS = dict(zip(NAMES, "s kgf N rpm 1/min K".split(), strict=True))


def csv(values: Columns, units: Units = UNITS, keys: Keys = KEYS) -> bytes:
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
    """A segment a list of objects; with the metadata of each in its own segment."""
    buffer = io.BytesIO()
    with TdmsWriter(buffer) as writer:
        for segment in segments:
            writer.write_segment(segment)
    return buffer.getvalue()


def tdms(values: Columns, units: Units = UNITS, keys: Keys = KEYS, segments: int = 1) -> bytes:
    root, group = RootObject(keys), GroupObject("run")
    shares = [
        {name: share for name, share in zip(values, parts, strict=True)}
        for parts in zip(
            *(np.array_split(column, segments) for column in values.values()), strict=True
        )
    ]
    return tdms_file([root, group], *(tdms_channels("run", share, units) for share in shares))


def lvm_segment(values: Columns, units: Units, mark: str, notes: str = "") -> list[str]:
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
    return [
        *("LabVIEW Measurement\t", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab"),
        *(f"Decimal_Separator\t{mark}", "Multi_Headings\tYes", f"X_Columns\t{x_columns}"),
        "Time_Pref\tRelative",
        "Description\t" + "; ".join(f"{key}: {value}" for key, value in keys.items()),
        *("Date\t2026/01/10", "***End_of_Header***\t", ""),
    ]


def lvm(values: Columns, units: Units = UNITS, keys: Keys = KEYS, mark: str = ".") -> bytes:
    lines = lvm_header(keys, mark) + lvm_segment(values, units, mark)
    return "\r\n".join(lines).encode()


def table(values: Columns, units: Units = UNITS, keys: Keys = KEYS) -> arrow.Table:
    fields = [
        arrow.field(name, arrow.array(column).type, metadata={"unit": units.get(name, "")})
        for name, column in values.items()
    ]
    metadata = {key: str(value) for key, value in keys.items()}
    return arrow.table(list(values.values()), schema=arrow.schema(fields, metadata))


def parquet_file(content: arrow.Table, **options: Any) -> bytes:
    buffer = io.BytesIO()
    parquet.write_table(content, buffer, **options)
    return buffer.getvalue()


def as_parquet(values: Columns, units: Units = UNITS, keys: Keys = KEYS, **options: Any) -> bytes:
    return parquet_file(table(values, units, keys), **options)


WRITERS = {"csv": csv, "tdms": tdms, "lvm": lvm, "parquet": as_parquet}
