"""What all formats owe: the same run, read from any of them, gives the same samples."""

import gzip
from dataclasses import replace
from typing import Any

import numpy as np
import pyarrow as arrow
import pytest

import torque_logs
from damages import SOUND, SoundLog
from formats import UNITS, WRITERS, columns
from oilfilm.logs.base import ParsedLog
from oilfilm.logs.ingest import ingest_logs, read_log
from oilfilm.settings.resolved import Settings

KEYS = {"oil": "4102"}
EXAMPLES = {**SOUND, "traction": replace(SOUND["traction"], values=columns(200), units=UNITS)}
every_format = pytest.mark.parametrize("name", WRITERS)
every_rig = pytest.mark.parametrize("example", EXAMPLES.values(), ids=EXAMPLES)


def every_log(test: Any) -> Any:
    """The test for each format, with a log of each kind of rig."""
    return every_format(every_rig(test))


def logged(example: SoundLog, rows: int) -> dict[str, np.ndarray]:
    return {name: column[:rows].copy() for name, column in example.values.items()}


def write(example: SoundLog, name: str, rows: int) -> bytes:
    return WRITERS[name](logged(example, rows), example.units, KEYS)


def in_si_units(example: SoundLog) -> dict[str, np.ndarray]:
    """The samples of 200 rows by the definitions of the units."""
    values = logged(example, 200)
    if example.load == "axial_load":
        return dict(zip(torque_logs.NAMES, values.values(), strict=True))
    # 1 kgf = 9.80665 N and 0 degC = 273.15 K by definition
    return {
        "time_s": values["time"],
        "load_n": values["load"] * 9.80665,
        "traction_force_n": values["traction_force"],
        "ball_speed_m_s": values["ball_speed"] * 2 * np.pi / 60 * 0.010,
        "disc_speed_m_s": values["disc_speed"] * 2 * np.pi / 60 * 0.040,
        "inlet_temperature_c": values["inlet_temperature"] - 273.15,
    }


def read(content: bytes, config: Settings, example: SoundLog) -> ParsedLog:
    return read_log(content, "log", config, example.kind.log_schema)[1]


@every_log
def test_written_values_come_back_in_si(config: Settings, example: SoundLog, name: str) -> None:
    reader, reading = read_log(write(example, name, 200), "log", config, example.kind.log_schema)
    assert (reader, reading.row_count, reading.refusals) == (name, 200, [])
    (run,) = reading.runs
    assert (run.run_id, run.oil_name, run.refusal) == ("log", "4102", None)
    assert run.samples["row"].tolist() == list(range(1, 201))
    for column, expected in in_si_units(example).items():
        # subtracting 273.15 K rounds to 3e-14
        np.testing.assert_allclose(run.samples[column], expected, rtol=1e-12, atol=6e-14)
    (text,) = read(write(example, "csv", 200), config, example).runs
    np.testing.assert_equal(run.samples, text.samples)


@every_format
def test_settled_readings_of_a_rig_that_reverses_slip_are_read(config: Settings, name: str) -> None:
    example, rows = EXAMPLES["traction"], 9
    row = np.arange(rows)
    both_ways = {"traction_force_1": row + 5.0, "traction_force_2": row - 7.0}
    # TF = (TF1 - TF2)/2 = 6 N
    values = {**logged(example, rows), "traction_force": np.full(rows, 6.0), **both_ways}
    units = {**example.units, **dict.fromkeys(both_ways, "kN"), "traction_force": "kN"}
    log = WRITERS[name](values, units, {**KEYS, "log_kind": "steps"})
    (run,) = read(log, config, example).runs
    assert (run.log_kind, run.refusal) == ("steps", None)
    for column, given in both_ways.items():
        np.testing.assert_allclose(run.samples[f"{column}_n"], 1000 * given)
    values["traction_force_2"][4] = np.nan
    cut = read(WRITERS[name](values, units, KEYS), config, example)
    assert [refusal.first_row for refusal in cut.refusals] == [5]
    assert cut.runs[0].log_kind == "continuous"


@every_log
def test_compressed_files_are_read_in_place(config: Settings, example: SoundLog, name: str) -> None:
    content = write(example, name, 5)
    for packed in (gzip.compress(content), arrow.compress(content, "zstd", asbytes=True)):
        # whatever the name says
        reader, reading = read_log(packed, "log.csv", config, example.kind.log_schema)
        assert (reader, len(reading.runs[0])) == (name, 5)
        runs = ingest_logs(
            [("plain", content), ("packed", packed)], config, example.kind.log_schema
        ).runs
        assert runs["sha256"].nunique() == 2
        assert runs["content_sha256"].nunique() == 1  # what refuses the copy


@every_log
@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 1e300])
def test_row_that_is_no_measurement_is_refused_by_number(
    config: Settings, example: SoundLog, name: str, wrong: float
) -> None:
    values = logged(example, 9)
    values[example.load][3:5] = wrong
    reading = read(WRITERS[name](values, example.units, KEYS), config, example)
    (refusal,) = reading.refusals
    assert (refusal.rule, refusal.first_row, refusal.last_row) == ("unreadable_row", 4, 5)
    assert reading.runs[0].samples["row"].tolist() == [1, 2, 3, 6, 7, 8, 9]


@every_log
def test_unusable_log_is_refused_whole(config: Settings, example: SoundLog, name: str) -> None:
    values, units, load = logged(example, 7), example.units, example.load
    lacking = {key: column for key, column in values.items() if key != load}
    writer = WRITERS[name]
    for content, rule, sentence in (
        (writer(values, units, {"oil": "9999"}), "unknown_oil", "'9999'"),
        (writer(values, units, {"note": "x"}), "header", "no property `oil`"),
        (writer(lacking, units, KEYS), "columns", f"lacks the columns {load}"),
        (writer(values, {**units, load: "m"}, KEYS), "columns", "'m' is none of N"),
    ):
        reading = read(content, config, example)
        (refusal,) = reading.refusals
        assert refusal.rule == rule
        assert sentence in refusal.reason
        assert (reading.row_count, refusal.refused_rows, reading.runs) == (7, 7, [])


@every_log
def test_log_without_rows_says_so(config: Settings, example: SoundLog, name: str) -> None:
    reading = read(write(example, name, 0), config, example)
    assert reading.row_count == 0
    assert [run for run in reading.runs if len(run)] == []
    # a run without rows is refused when it is judged
    assert reading.runs or [refusal.rule for refusal in reading.refusals] == ["no_rows"]


def test_changed_bit_of_a_packed_log_is_found(config: Settings) -> None:
    """Its checksum shows it, even where the text would be a log with another number."""
    example = EXAMPLES["traction"]
    packed = gzip.compress(write(example, "csv", 200))
    random = np.random.default_rng(4)
    for place in random.integers(20, len(packed), 100):
        changed = bytearray(packed)
        changed[place] ^= 1 << random.integers(8)
        (refusal,) = read(bytes(changed), config, example).refusals
        assert refusal.rule == "damaged_archive"
