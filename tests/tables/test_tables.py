"""The contract of the tables: what is forbidden cannot be written, and footers tell the story."""

from pathlib import Path

import numpy as np
import pandas as pd
import pandera.errors
import pyarrow.parquet as parquet
import pytest
from hypothesis import given
from hypothesis import strategies as st

from oilfilm import tables
from oilfilm.errors import OilfilmError

ABOUT = {"campaign": "test", "data": "simulated"}


@pytest.fixture
def quarantine() -> pd.DataFrame:
    row = {name: "x" for name in tables.columns("quarantine")}
    row |= {"stage": "ingest", "first_row": 1, "last_row": 2, "refused_rows": 2}
    return tables.from_rows([row], "quarantine")


def test_what_is_written_is_read_back(quarantine: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / "deep" / "q.parquet"
    tables.write(quarantine, "quarantine", path, ABOUT)
    pd.testing.assert_frame_equal(tables.read("quarantine", path), quarantine)
    assert [file.name for file in path.parent.iterdir()] == ["q.parquet"]


def test_footer_says_units_version_and_that_data_are_simulated(tmp_path: Path) -> None:
    path = tmp_path / "p.parquet"
    tables.write(tables.empty("points"), "points", path, ABOUT)
    footer = tables.read_footer(path)
    assert footer["data"] == "simulated"
    assert footer["schema_version"] == tables.SCHEMA_VERSION
    field = parquet.read_schema(path).field("load_n")
    assert field.metadata[b"unit"] == b"N"
    assert b"load" in field.metadata[b"description"]
    assert parquet.ParquetFile(path).metadata.created_by.startswith("parquet-cpp-arrow")


@pytest.mark.parametrize(
    ("column", "value", "expected"),
    [
        ("load_n", np.inf, ["'load_n'", "normal load", "inf"]),
        ("film_judgement", "thick", ["'film_judgement'", "thick"]),
        ("lambda_ratio", -1.0, ["'lambda_ratio'", "-1"]),
        ("entrainment_speed_m_s", np.nan, ["'entrainment_speed_m_s'", "nan"]),
        ("n_samples", "many", ["'n_samples'", "many"]),
    ],
)
def test_forbidden_value_is_told_with_column_and_meaning(
    demo, column: str, value: object, expected: list[str]
) -> None:
    frame = demo.curated.points.head(3).astype(object)
    frame.loc[1, column] = value
    with pytest.raises(OilfilmError) as mistake:
        tables.conform(frame, "points", "here")
    for text in expected:
        assert text.lower() in str(mistake.value).lower()


NUMBERS = st.floats() | st.sampled_from([-tables.LARGEST, tables.LARGEST, 2 * tables.LARGEST])


FLOATS = [("points", "time_s"), ("points", "lambda_ratio"), ("runs", "nominal_load_n")]
COUNTS = [("points", "n_samples"), ("points", "first_row")]
TEXTS = ["continuous", "step", "", None]


@given(
    st.tuples(st.sampled_from(FLOATS), NUMBERS)
    | st.tuples(st.sampled_from(COUNTS), st.integers(-2, 2))
    | st.tuples(st.just(("runs", "log_kind")), st.sampled_from(TEXTS))
)
def test_short_cut_past_pandera_lets_nothing_pass_that_pandera_refuses(
    demo, changed: tuple[tuple[str, str], object]
) -> None:
    (table, column), value = changed
    frame = getattr(demo.curated, table).head(3).copy()
    frame[column] = pd.Series([*frame[column][:2], value], dtype=frame[column].dtype)
    try:
        tables.TABLES[table].schema.validate(frame)
    except pandera.errors.SchemaError:
        with pytest.raises(OilfilmError, match=column):
            tables.conform(frame, table, "here")
    else:
        tables.conform(frame, table, "here")


def test_accepted_point_with_a_reason_is_a_contradiction(demo) -> None:
    frame = demo.curated.points.head(3).copy()
    frame.loc[0, "failed_gates"] = "thin_film"
    with pytest.raises(OilfilmError, match="accepted with a failed gate"):
        tables.conform(frame, "points", "here")


def test_repeated_key_is_refused(demo) -> None:
    frame = pd.concat([demo.curated.runs.head(2)] * 2)
    with pytest.raises(OilfilmError, match="2 rows repeat run_id"):
        tables.conform(frame, "runs", "here")


def test_missing_and_unknown_columns_are_named() -> None:
    frame = tables.empty("runs").drop(columns="oil").assign(colour="red")
    with pytest.raises(OilfilmError, match=r"lacks \['oil'\].*unknown \['colour'\]"):
        tables.conform(frame, "runs", "here")


def test_other_table_and_damage_are_refused(quarantine: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / "q.parquet"
    tables.write(quarantine, "quarantine", path, ABOUT)
    with pytest.raises(OilfilmError, match="holds table 'quarantine'"):
        tables.read("runs", path)
    path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(OilfilmError, match="cannot be read as Parquet"):
        tables.read("quarantine", path)
    pd.DataFrame({"a": [1]}).to_parquet(path)
    with pytest.raises(OilfilmError, match="not a table of oilfilm"):
        tables.read("quarantine", path)


@pytest.mark.parametrize(("in_footer", "every"), [(False, 7), (True, 29)])
def test_no_flipped_bit_is_read_as_another_number(
    quarantine: pd.DataFrame, tmp_path: Path, in_footer: bool, every: int
) -> None:
    """Each page carries a CRC-32: compression alone lets some bits pass. A footer has none."""
    path = tmp_path / "quarantine.parquet"
    tables.write(quarantine, "quarantine", path, ABOUT)
    content, as_written = path.read_bytes(), tables.read("quarantine", path)
    footer = len(content) - int.from_bytes(content[-8:-4], "little") - 8
    refused = 0
    for offset in range(footer, len(content), every) if in_footer else range(0, footer, every):
        damaged = bytearray(content)
        damaged[offset] ^= 1 << offset % 8
        path.write_bytes(damaged)
        try:
            assert tables.read("quarantine", path).equals(as_written) or in_footer
        except OilfilmError:
            refused += 1
    assert refused > 0
