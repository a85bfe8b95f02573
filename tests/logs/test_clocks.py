"""Channels with clocks of their own are paired by time, or refused where no times are common."""

import io
from collections.abc import Callable

import numpy as np
import pytest
from nptdms import ChannelObject, RootObject, TdmsFile, TdmsWriter

from bad_logs import CONFIG
from oilfilm.logs.base import READING_NOTE, ParsedLog
from oilfilm.logs.clocks import _is_one_clock
from oilfilm.logs.ingest import read_log
from oilfilm.logs.logged_table import Clock as LoggedClock

INTERVAL_S = 0.1
ROWS = 200
TIME = INTERVAL_S * np.arange(ROWS)
START = np.datetime64("2026-03-01T10:15:00", "us")
UNITS = {
    "load": "N",
    "traction_force": "N",
    "ball_speed": "rpm",
    "disc_speed": "rpm",
    "inlet_temperature": "degC",
}
# what each sensor reads at a time: linear, so that interpolation between readings is exact
TRUTH: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "load": lambda time: 80 + 0.1 * time,
    "traction_force": lambda time: 0.5 * time,
    "ball_speed": lambda time: 8000 - 10 * time,
    "disc_speed": lambda time: 2500 + 10 * time,
    "inlet_temperature": lambda time: 60 + 0.2 * time,
}
# Start, interval and number of readings of a channel.
Clock = tuple[float, float, int]


def tdms(clocks: dict[str, Clock], *, by_offset: bool = False) -> bytes:
    """A TDMS log; each channel has its readings at the times of its clock."""
    channels = []
    for name, truth in TRUTH.items():
        start, interval, count = clocks.get(name, (0.0, INTERVAL_S, ROWS))
        shift = np.timedelta64(0 if by_offset else round(start * 1e6), "us")
        properties = {
            "unit_string": UNITS[name],
            "wf_increment": interval,
            "wf_start_offset": start if by_offset else 0.0,
            "wf_start_time": START + shift,
        }
        readings = truth(start + interval * np.arange(count))
        channels.append(ChannelObject("run", name, readings, properties))
    buffer = io.BytesIO()
    with TdmsWriter(buffer) as writer:
        writer.write_segment([RootObject({"oil": "4102"}), *channels])
    return buffer.getvalue()


def lvm(
    clocks: dict[str, Clock], *, by_columns: bool = False, by_start_time: bool = False
) -> bytes:
    """An LVM log, with X0 and Delta_X or with a column of time for each channel.

    The start of a channel is in these, or in its date and time.
    """
    count = len(TRUTH)
    all_clocks = [clocks.get(name, (0.0, INTERVAL_S, ROWS)) for name in TRUTH]
    shifts_s = [start if by_start_time else 0.0 for start, _, _ in all_clocks]
    instants = [str(START + np.timedelta64(round(1e6 * shift), "us")) for shift in shifts_s]
    lines = ["LabVIEW Measurement\t", "Separator\tTab", "Decimal_Separator\t."]
    lines += [f"X_Columns\t{'Multi' if by_columns else 'No'}", "Description\toil: 4102"]
    lines += ["***End_of_Header***\t", f"Channels\t{count}", "X_Dimension" + "\tTime" * count]
    lines += ["Date\t" + "\t".join(text[:10].replace("-", "/") for text in instants)]
    lines += ["Time\t" + "\t".join(text[11:] for text in instants)]
    logged_starts = [0.0 if by_start_time else start for start, _, _ in all_clocks]
    lines += ["X0\t" + "\t".join(map(str, logged_starts))]
    lines += ["Delta_X\t" + "\t".join(str(interval) for _, interval, _ in all_clocks)]
    lines += ["***End_of_Header***\t"]
    names = [f"{name} [{UNITS[name]}]" for name in TRUTH]
    between = "\tX_Value\t" if by_columns else "\t"
    lines.append("X_Value\t" + between.join(names))
    for row in range(max(readings for _, _, readings in all_clocks)):
        cells = [] if by_columns else [""]
        for truth, (start, interval, readings), logged_start in zip(
            TRUTH.values(), all_clocks, logged_starts, strict=True
        ):
            reading = f"{float(truth(np.array(start + interval * row))):.9g}"
            time = f"{logged_start + interval * row:.6f}"
            both = [time, reading] if row < readings else ["", ""]
            cells += both if by_columns else both[1:]
        lines.append("\t".join(cells))
    return ("\n".join(lines) + "\n").encode()


WRITERS: dict[str, Callable[[dict[str, Clock]], bytes]] = {
    "tdms by start time": tdms,
    "tdms by offset": lambda clocks: tdms(clocks, by_offset=True),
    "lvm by X0": lvm,
    "lvm by columns": lambda clocks: lvm(clocks, by_columns=True),
    "lvm by start time": lambda clocks: lvm(clocks, by_start_time=True),
    "lvm by start time and columns": lambda clocks: lvm(
        clocks, by_columns=True, by_start_time=True
    ),
}


def read(content: bytes) -> ParsedLog:
    return read_log(content, "log", CONFIG)[1]


def check_truth(reading: ParsedLog) -> np.ndarray:
    """Compare each row with what the sensors read at its time; the times."""
    (run,) = reading.runs
    time = run.samples["time_s"]
    for column, name in [
        ("load_n", "load"),
        ("traction_force_n", "traction_force"),
        ("inlet_temperature_c", "inlet_temperature"),
    ]:
        np.testing.assert_allclose(run.samples[column], TRUTH[name](time), rtol=1e-6, atol=1e-6)
    return time


def tdms_without_a_start(content: bytes, name: str) -> bytes:
    """The TDMS log without the start time of one channel."""
    with TdmsFile.open(io.BytesIO(content)) as log:
        channels = []
        for channel in log["run"].channels():
            properties = dict(channel.properties)
            if channel.name == name:
                del properties["wf_start_time"]
            channels.append(ChannelObject("run", channel.name, channel[:], properties))
        objects = [RootObject(dict(log.properties)), *channels]
        buffer = io.BytesIO()
        with TdmsWriter(buffer) as writer:
            writer.write_segment(objects)
    return buffer.getvalue()


def lvm_without_a_start(content: bytes) -> bytes:
    """The LVM log without the date and time of its last channel."""
    lines = content.decode().split("\n")
    for index, line in enumerate(lines):
        if line.startswith(("Date\t", "Time\t")):
            lines[index] = line.rpartition("\t")[0]
    return "\n".join(lines).encode()


@pytest.mark.parametrize("start", [0.0, 0.5])
@pytest.mark.parametrize("log_format", ["tdms", "lvm"])
def test_a_start_that_is_not_known_is_that_of_the_others_only_if_they_agree(
    log_format: str, start: float
) -> None:
    clocks = {"traction_force": (start, INTERVAL_S, ROWS)}
    if log_format == "tdms":
        content = tdms_without_a_start(tdms(clocks), "inlet_temperature")
    else:
        content = lvm_without_a_start(lvm(clocks, by_start_time=True))
    reading = read(content)
    if start == 0.0:
        check_truth(reading)
        return
    (refusal,) = reading.refusals
    assert (refusal.rule, reading.runs) == ("clocks", [])
    assert "inlet_temperature" in refusal.reason


@pytest.mark.parametrize("writer", WRITERS.values(), ids=WRITERS)
@pytest.mark.parametrize("slower", [2, 10, 50])
def test_slow_channel_is_interpolated_onto_the_fastest(
    writer: Callable[[dict[str, Clock]], bytes], slower: int
) -> None:
    # its last reading is at the end of the log
    clock = (0.0, slower * INTERVAL_S, ROWS // slower + 1)
    reading = read(writer({"inlet_temperature": clock}))
    np.testing.assert_allclose(check_truth(reading), TIME, atol=1e-9)
    (note,) = reading.refusals
    assert note.rule == READING_NOTE
    assert "inlet_temperature" in note.reason


@pytest.mark.parametrize("writer", WRITERS.values(), ids=WRITERS)
@pytest.mark.parametrize("later_s", [1.2, 0.25])
def test_channel_that_begins_later_is_paired_by_time(
    writer: Callable[[dict[str, Clock]], bytes], later_s: float
) -> None:
    reading = read(writer({"traction_force": (later_s, INTERVAL_S, ROWS)}))
    time = check_truth(reading)
    # before, there is no force
    assert time[0] >= later_s - INTERVAL_S
    assert len(time) == pytest.approx(ROWS - later_s / INTERVAL_S, abs=1)
    assert reading.row_count == ROWS


@pytest.mark.parametrize("writer", WRITERS.values(), ids=WRITERS)
def test_rows_of_a_slow_channel_that_is_read_longer_are_refused_by_number(
    writer: Callable[[dict[str, Clock]], bytes],
) -> None:
    reading = read(writer({"inlet_temperature": (0.0, 2 * INTERVAL_S, ROWS + 50)}))
    np.testing.assert_allclose(check_truth(reading), TIME, atol=1e-9)
    refused = [(found.first_row, found.last_row) for found in reading.refusals if found.first_row]
    assert refused == [(ROWS + 1, ROWS + 50)]
    assert reading.row_count == ROWS + 50


@pytest.mark.parametrize("writer", WRITERS.values(), ids=WRITERS)
def test_channels_that_were_never_read_together_are_refused(
    writer: Callable[[dict[str, Clock]], bytes],
) -> None:
    reading = read(writer({"traction_force": (500.0, INTERVAL_S, ROWS)}))
    assert reading.runs == []
    (refusal,) = reading.refusals
    assert refusal.rule == "clocks"
    assert "same time" in refusal.reason
    assert refusal.refused_rows == reading.row_count


@pytest.mark.parametrize("writer", WRITERS.values(), ids=WRITERS)
def test_clocks_that_agree_within_their_rounding_are_one(
    writer: Callable[[dict[str, Clock]], bytes],
) -> None:
    reading = read(writer({"load": (0.0, INTERVAL_S * (1 + 1e-7), ROWS)}))
    assert len(reading.runs[0]) == ROWS
    assert [refusal.rule for refusal in reading.refusals if refusal.refused_rows] == []


@pytest.mark.parametrize(("start", "is_one_clock"), [(0.09, True), (-0.09, False)])
def test_clocks_are_one_where_no_row_is_a_tenth_of_an_interval_apart(
    start: float, is_one_clock: bool
) -> None:
    # over 1001 rows the second clock loses 0.02: it ends at 0.07, or at -0.11
    clocks = [LoggedClock(0.0, 1.0, "s"), LoggedClock(start, 0.99998, "s")]
    assert _is_one_clock(clocks, 1001) == is_one_clock


def test_a_time_that_falls_is_named_as_the_log_has_it() -> None:
    # the record of the force begins 10 s after that of the others
    clocks = {"traction_force": (10.0, INTERVAL_S, ROWS)}
    lines = lvm(clocks, by_columns=True, by_start_time=True).decode().split("\n")
    (row,) = [number for number, line in enumerate(lines) if line.startswith("7.000000\t")]
    cells = lines[row].split("\t")
    cells[2] = "3.25"
    lines[row] = "\t".join(cells)
    (refusal,) = read("\n".join(lines).encode()).refusals
    assert "falls from 6.9 to 3.25" in refusal.reason


@pytest.mark.parametrize("interval_s", [10.0, 1.0, 1e-2, 1e-4])
def test_log_of_any_rate_is_read(interval_s: float) -> None:
    clocks = {name: (0.0, interval_s, ROWS) for name in TRUTH}
    (run,) = read(tdms(clocks)).runs
    np.testing.assert_allclose(run.samples["time_s"], interval_s * np.arange(ROWS), rtol=1e-12)
