"""Parquet: types, metadata, own tables, and files made to fill the memory."""

import io
import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as arrow
import pyarrow.parquet as parquet
import pytest

import formats
from oilfilm import tables
from oilfilm.logs.base import MOST_ROWS

VALUES = formats.columns(40)


def with_load(column: Any, **options: Any) -> bytes:
    table = formats.table(VALUES)
    column_number = table.schema.get_field_index("load")
    field = arrow.field("load", column.type, metadata={"unit": "N"})
    return formats.parquet_file(table.set_column(column_number, field, column), **options)


@pytest.mark.parametrize(
    "column",
    [
        arrow.array(range(40), arrow.int32()),
        arrow.array(range(40), arrow.uint8()),
        arrow.array(map(float, range(40)), arrow.float32()),
        arrow.array(range(40), arrow.int64()).cast(arrow.decimal128(38, 3)),
    ],
)
def test_numbers_of_any_width_are_read(read, column: Any) -> None:
    assert read(with_load(column)).runs[0].samples["load_n"].tolist() == list(range(40))


def test_instants_are_in_seconds_whatever_their_unit_says(read) -> None:
    column = arrow.array(pd.date_range("2026-03-01", periods=40, freq="20ms"))
    field = arrow.field("time", column.type, metadata={"unit": "ms"})
    (run,) = read(formats.parquet_file(formats.table(VALUES).set_column(0, field, column))).runs
    np.testing.assert_allclose(run.samples["time_s"], VALUES["time"], atol=1e-9)


@pytest.mark.parametrize("missing_row", [0, 20, 39])
def test_missing_time_stamp_refuses_its_row_only(read, missing_row: int) -> None:
    instants = list(pd.date_range("2026-03-01", periods=40, freq="20ms"))
    instants[missing_row] = None
    column = arrow.array(instants, arrow.timestamp("us"))
    reading = read(formats.parquet_file(formats.table(VALUES).set_column(0, "time", column)))
    (refusal,) = reading.refusals
    assert (refusal.rule, refusal.first_row, refusal.last_row) == (
        "unreadable_row",
        missing_row + 1,
        missing_row + 1,
    )
    time_s = reading.runs[0].samples["time_s"]
    expected = np.delete(VALUES["time"], missing_row)
    np.testing.assert_allclose(time_s - time_s[0], expected - expected[0], atol=1e-9)


@pytest.mark.parametrize(
    "column", [arrow.array(40 * [each]) for each in ("80.1", [1.0], {"a": 1.0}, True, b"x", None)]
)
def test_column_of_anything_else_is_refused_in_words(read, column: Any) -> None:
    reading = read(with_load(column))
    (refusal,) = reading.refusals
    assert refusal.rule == "columns"
    assert "'load' does not hold numbers" in refusal.reason
    assert (reading.row_count, refusal.refused_rows) == (40, 40)


def test_bit_changed_in_a_page_with_a_checksum_is_found(read) -> None:
    """The digit stays a plausible load: only the checksum shows it."""
    load = np.arange(80.0, 81.0, 0.025)
    plain = {"compression": "none", "use_dictionary": False}
    for checksums in (True, False):
        content = bytearray(with_load(arrow.array(load), write_page_checksum=checksums, **plain))
        place = content.index(load.tobytes())
        content[place + 8 * 20 + 6] ^= 1  # of the twentieth row's 80.5
        reading = read(bytes(content))
        if checksums:
            assert [refusal.rule for refusal in reading.refusals] == ["damaged_file"]
        else:
            changed = reading.runs[0].samples["load_n"][20]
            assert changed != load[20]
            assert 80 < changed < 90


@pytest.mark.parametrize(
    "said", [b"\xd2\x0f", b"\x94\x00", b"\xcf\x0f"], ids=["1001", "10", "-1000"]
)
def test_footer_that_counts_other_rows_than_the_pages_have_loses_none(read, said: bytes) -> None:
    """Each count of 1000 in the footer, as Thrift writes it, is changed by a few bits."""
    content = formats.as_parquet(formats.columns(1000))
    footer = len(content) - 8 - int.from_bytes(content[-8:-4], "little")
    places = [each.start() for each in re.finditer(rb"\xd0\x0f", content) if each.start() > footer]
    reasons = set()
    for place in places:
        reading = read(content[:place] + said + content[place + 2 :])
        kept = sum(map(len, reading.runs))
        assert kept == 1000 or [each.rule for each in reading.refusals] == ["damaged_file"]
        reasons |= {each.reason for each in reading.refusals}
    assert any("1000" in reason for reason in reasons)


def test_frame_of_pandas_with_attributes_and_own_names_is_a_log(read) -> None:
    frame = pd.DataFrame(
        {
            "time": pd.Timestamp("2026-01-10T08:00:00") + pd.to_timedelta(VALUES["time"], "s"),
            "Load [kgf]": VALUES["load"],
            "traction_force_n": VALUES["traction_force"],
            "ball_speed_rpm": VALUES["ball_speed"],
            "disc_speed_rpm": VALUES["disc_speed"],
            "inlet_temperature_c": VALUES["inlet_temperature"],
        }
    )
    frame.attrs = {"oil": 4102, "max_hertz_pressure_gpa": 1.25, "simulated": False}
    buffer = io.BytesIO()
    frame.to_parquet(buffer)
    (run,) = read(buffer.getvalue()).runs
    np.testing.assert_allclose(run.samples["time_s"], VALUES["time"], atol=1e-9)
    np.testing.assert_allclose(run.samples["load_n"], VALUES["load"] * 9.80665, rtol=1e-12)
    assert run.set_points["max_hertz_pressure_gpa"] == 1.25


def test_other_columns_of_any_type_are_not_read_and_doubled_ones_refused(read) -> None:
    table = formats.table(VALUES).append_column("note", arrow.array(40 * [{"a": ["x"]}]))
    assert len(read(formats.parquet_file(table)).runs[0]) == 40
    twice = table.append_column("Load", arrow.array(VALUES["load"]))
    (refusal,) = read(formats.parquet_file(twice)).refusals
    assert "'load' and 'Load' are the same quantity 'load'" in refusal.reason


def test_table_of_oilfilm_itself_is_refused(read, tmp_path: Path) -> None:
    path = tmp_path / "samples.parquet"
    about = {"campaign": "demo", "data": "simulated"}
    tables.write(tables.empty_table("samples"), "samples", path, about)
    (refusal,) = read(path.read_bytes()).refusals
    assert refusal.rule == "own_table"
    assert "oilfilm made itself" in refusal.reason


def test_file_of_too_many_rows_is_refused_unread(read, monkeypatch: pytest.MonkeyPatch) -> None:
    # constant columns: a few kilobytes hold more than the largest log
    rows = MOST_ROWS // 16 + 1
    column = arrow.DictionaryArray.from_arrays(arrow.array(np.zeros(rows, np.int8)), [1.0])
    piece = arrow.table(dict.fromkeys(VALUES, column)).cast(
        arrow.schema([(name, arrow.float64()) for name in VALUES])
    )
    buffer = io.BytesIO()
    with parquet.ParquetWriter(buffer, piece.schema, compression="zstd") as writer:
        for _ in range(16):
            writer.write_table(piece)
    assert len(buffer.getvalue()) < 1 << 20
    monkeypatch.setattr(parquet.ParquetFile, "read", None)
    (refusal,) = read(buffer.getvalue()).refusals
    assert "the log has 4500016 rows, more than 4500000" in refusal.reason
