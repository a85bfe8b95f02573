"""What all formats owe: the same run, read from any of them, gives the same samples."""

import gzip

import numpy as np
import pyarrow as arrow
import pytest

import formats
from campaigns import ROOT
from oilfilm.readers import READERS
from oilfilm.readers.ingest import ingest_logs, read_log
from oilfilm.settings.resolved import Settings

WRITERS = {
    "csv": formats.csv,
    "tdms": formats.tdms,
    "lvm": formats.lvm,
    "parquet": formats.as_parquet,
}
# 1 kgf = 9.80665 N and 0 degC = 273.15 K by definition
EXPECTED = {
    "time_s": lambda v: v["time"],
    "load_n": lambda v: v["load"] * 9.80665,
    "traction_force_n": lambda v: v["traction_force"],
    "ball_speed_m_s": lambda v: v["ball_speed"] * 2 * np.pi / 60 * 0.010,
    "disc_speed_m_s": lambda v: v["disc_speed"] * 2 * np.pi / 60 * 0.040,
    "inlet_temperature_c": lambda v: v["inlet_temperature"] - 273.15,
}


@pytest.mark.parametrize("name", WRITERS)
def test_what_is_written_comes_back_in_si_units(config: Settings, name: str) -> None:
    values = formats.columns(200)
    reader, reading = read_log(WRITERS[name](values), "log", config)
    assert (reader, reading.rows, reading.refusals) == (name, 200, [])
    (run,) = reading.runs
    assert (run.run_id, run.oil, run.flaw) == ("log", "4102", None)
    assert run.nominal.max_hertz_pressure_gpa == 1.25
    assert run.samples["row"].tolist() == list(range(1, 201))
    for column, expected in EXPECTED.items():
        # subtracting 273.15 K rounds to 3e-14
        np.testing.assert_allclose(run.samples[column], expected(values), rtol=1e-12, atol=6e-14)


@pytest.mark.parametrize("name", WRITERS)
def test_every_format_gives_the_samples_of_the_text_log(config: Settings, name: str) -> None:
    values = formats.columns(50)
    (run,) = read_log(WRITERS[name](values), "log", config)[1].runs
    (text,) = read_log(formats.csv(values), "log", config)[1].runs
    np.testing.assert_equal(run.samples, text.samples)
    assert run.nominal == text.nominal


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("file", ["log.csv", "log.tdms", "log.txt", "log.parquet", "log"])
def test_format_is_known_by_content_whatever_the_extension(
    config: Settings, name: str, file: str
) -> None:
    assert read_log(WRITERS[name](formats.columns(5)), file, config)[0] == name


@pytest.mark.parametrize("name", WRITERS)
def test_compressed_files_of_every_format_are_read_in_place(config: Settings, name: str) -> None:
    content = WRITERS[name](formats.columns(5))
    for packed in (gzip.compress(content), arrow.compress(content, "zstd", asbytes=True)):
        reader, reading = read_log(packed, "log", config)
        assert (reader, len(reading.runs[0])) == (name, 5)
        runs = ingest_logs([("plain", content), ("packed", packed)], config).runs
        assert runs["sha256"].nunique() == 2
        assert runs["content_sha256"].nunique() == 1  # what refuses the copy


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 1e300])
def test_row_that_is_no_measurement_is_refused_by_number(
    config: Settings, name: str, wrong: float
) -> None:
    values = formats.columns(9)
    values["load"][3:5] = wrong
    reading = read_log(WRITERS[name](values), "log", config)[1]
    (refusal,) = reading.refusals
    assert (refusal.rule, refusal.first_row, refusal.last_row) == ("unreadable_row", 4, 5)
    assert reading.runs[0].samples["row"].tolist() == [1, 2, 3, 6, 7, 8, 9]


@pytest.mark.parametrize("name", WRITERS)
def test_unusable_log_is_refused_whole_with_the_same_rules(config: Settings, name: str) -> None:
    values = formats.columns(7)
    lacking = {key: column for key, column in values.items() if key != "load"}
    metres = {**formats.UNITS, "load": "m"}
    for content, rule, words in (
        (WRITERS[name](values, keys={"oil": "9999"}), "unknown_oil", "'9999'"),
        (WRITERS[name](values, keys={"note": "x"}), "header", "no property `oil`"),
        (WRITERS[name](lacking), "columns", "lacks the columns load"),
        (WRITERS[name](values, metres), "columns", "'m' is none of N"),
    ):
        reading = read_log(content, "log", config)[1]
        (refusal,) = reading.refusals
        assert refusal.rule == rule
        assert words in refusal.reason
        assert (reading.rows, refusal.refused_rows, reading.runs) == (7, 7, [])


@pytest.mark.parametrize("name", WRITERS)
def test_log_without_rows_says_so(config: Settings, name: str) -> None:
    reading = read_log(WRITERS[name](formats.columns(0)), "log", config)[1]
    assert reading.rows == 0
    assert [run for run in reading.runs if len(run)] == []
    assert name == "csv" or [refusal.rule for refusal in reading.refusals] == ["no_rows"]


def test_every_reader_has_its_section_in_the_guide() -> None:
    guide = (ROOT / "data/raw/README.md").read_text(encoding="utf-8")
    assert [reader.name for reader in READERS if f"## `{reader.name}`" not in guide] == []
