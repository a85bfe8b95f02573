"""However a log is laid out, it is read right or refused in a sentence that says what is wrong."""

from collections.abc import Callable

import numpy as np
import pytest

import bad_logs
import formats
from oilfilm.logs.base import Reading
from oilfilm.logs.ingest import ingest_logs, read_log

CONFIG = bad_logs.CONFIG
NAMES = "time;load;traction_force;ball_speed;disc_speed;inlet_temperature".split(";")
UNITS = "s;N;N;rpm;rpm;degC".split(";")
ROWS = [
    "0,00;82,3;0,05;28650,12;7160,00;70,0".split(";"),
    "0,50;82,1;0,04;28651,25;7161,50;70,1".split(";"),
]
# the same numbers as a program reads them
NUMBERS = np.array([[float(cell.replace(",", ".")) for cell in row] for row in ROWS])


def log(
    names: list[str] = NAMES,
    units: list[str] | None = UNITS,
    rows: list[list[str]] = ROWS,
    delimiter: str = ";",
    above: str = "# oil: 4102",
    below: str = "",
) -> str:
    lines = [names, *([units] if units else []), *rows]
    return "\n".join([above, *map(delimiter.join, lines), below]).rstrip("\n") + "\n"


def pointed(rows: list[list[str]] = ROWS) -> list[list[str]]:
    return [[cell.replace(",", ".") for cell in row] for row in rows]


def named(*names: str) -> list[str]:
    units = dict(zip(NAMES, UNITS, strict=True))
    return [f"{name.replace('_', ' ').title()} [{units[name]}]" for name in names]


def timed(*stamps: str, rows: list[list[str]] = ROWS) -> list[list[str]]:
    return [[stamp, *row[1:]] for stamp, row in zip(stamps, rows, strict=True)]


def quoted(rows: list[list[str]]) -> list[list[str]]:
    return [[f'"{cell}"' for cell in row] for row in rows]


ENDS = [[*row, ""] for row in ROWS]
GROUPED = [[cell.replace("28", "28.").replace("7160", "7.160") for cell in row] for row in ROWS]
SPLIT = [[row[0], "", *row[1:]] for row in (NAMES, UNITS, *ROWS)]
SAME = {
    "plain": log(),
    "CR CR LF": log().replace("\n", "\r\r\n"),
    "delimiter behind rows": log(rows=ENDS),
    "delimiter behind names": log([*NAMES, ""], [*UNITS, ""]),
    "delimiter behind all": log([*NAMES, ""], [*UNITS, ""], ENDS),
    "note with a point": log([*NAMES, "note"], [*UNITS, ""], [[*row, "a.b"] for row in ROWS]),
    "note with a comma": log([*NAMES, "note"], [*UNITS, ""], [[*r, "a, b"] for r in pointed()]),
    "empty column": log(*SPLIT[:2], SPLIT[2:]),
    "quoted cells": log(rows=quoted(ROWS)),
    "quoted cells that hold the delimiter": log(rows=quoted(ROWS), delimiter=","),
    "thousands": log(rows=GROUPED),
    "thousands with points": log(
        rows=[[c.translate({44: 46, 46: 44}) for c in r] for r in GROUPED]
    ),
    "thousands with blanks": log(rows=[[c.replace(".", "\u202f") for c in r] for r in GROUPED]),
    "comments among and below the rows": log(
        rows=[ROWS[0], ["# pause"], ROWS[1]], below="# end; ok"
    ),
    "names as a comment": log(["# " + NAMES[0], *NAMES[1:]], [f"[{unit}]" for unit in UNITS]),
    "line of Excel": log(above='sep=;\n"oil";"4102";;;;'),
    "blanks": log(delimiter="  \t "),
    "blanks before the rows": log(delimiter=" ").replace("\n0", "\n   0"),
    "blanks and names with units": log(named(*NAMES), None, delimiter=" "),
    "blanks and decimal points": log(rows=pointed(), delimiter=" "),
    "blanks in names": log(["Oil Flow", *named(*NAMES)], None, [["1", *r] for r in ROWS], "   "),
    "stamps": log(rows=timed("2026-03-01T10:15:00.250", "2026-03-01T10:15:00.750")),
    "stamps in UTC": log(rows=timed("2026-03-01 10:15:00.250Z", "2026-03-01 10:15:00.750Z")),
    "stamps with offset": log(
        rows=timed("2026-03-01T10:15:00,25+02:00", "2026-03-01T08:15:00,75Z")
    ),
    "stamps, day first": log(rows=quoted(timed("1.3.2026 10:15:00", "1.3.2026 10:15:00,5"))),
    "stamps over midnight": log(rows=timed("2026/12/31 23:59:59.75", "2027/01/01 00:00:00.25")),
    "time of day": log(rows=timed("23:59:59.75", "0:00:00.25")),
    "date beside": log(
        ["Datum", *NAMES], ["", *UNITS], [["2026-03-01", *r] for r in timed("9:15:00", "9:15:00.5")]
    ),
    "stamps parted by blanks": log(
        ["Date", *NAMES], None, [["2026-03-01", *r] for r in timed("09:15:00", "09:15:00.5")], " "
    ).replace(
        "load traction_force ball_speed disc_speed inlet_temperature", " ".join(named(*NAMES)[1:])
    ),
}


def read(text: str, encoding: str = "utf-8") -> Reading:
    return read_log(text.encode(encoding), "log", CONFIG)[1]


@pytest.mark.parametrize("text", SAME.values(), ids=SAME)
def test_log_is_read_the_same_however_it_is_laid_out(text: str) -> None:
    reading = read(text)
    assert reading.refusals == []
    (run,) = reading.runs
    rig = CONFIG.rigs["ball-on-disc-20mm"]
    radii = {"ball": rig.ball_track_radius_m, "disc": rig.disc_track_radius_m}
    samples = ["time_s", "load_n", "traction_force_n", "ball_speed_m_s", "disc_speed_m_s"]
    for name, logged in zip([*samples, "inlet_temperature_c"], NUMBERS.T, strict=True):
        # a surface goes 2 pi r in a revolution
        scale = 2 * np.pi / 60 * radii[name[:4]] if name.endswith("speed_m_s") else 1.0
        np.testing.assert_allclose(run.samples[name], logged * scale, rtol=1e-12, atol=1e-12)


REFUSED = {
    "thousands or decimals": (
        log(rows=[[*ROWS[0][:4], "7.160", "70,0"], ROWS[1]]),
        "reads '0,00;82,3;0,05;28650,12;7.160;70,0'",
    ),
    "text below the rows": (log(below="End of test"), "reads 'End of test'"),
    "row above the names": (
        log(above="# oil: 4102\n" + ";".join(ROWS[0])),
        "line 2 reads '0,00;82,3;0,05;28650,12;7160,00;70,0', which looks like a row",
    ),
    "row with a stamp above the names": (
        log(rows=timed("10:15:00", "10:15:01"), above="# oil: 4102\n10:14:59" + ";1" * 5),
        "line 2 reads '10:14:59;1;1;1;1;1', which looks like a row",
    ),
    "two columns of one name": (
        log([*NAMES, "Load"], [*UNITS, "N"], [[*row, "82"] for row in ROWS]),
        "repeats the column 'load'",
    ),
    "month or day": (
        log(rows=timed("03/01/2026 10:15:00", "03/01/2026 10:15:01")),
        "holds '03/01/2026 10:15:00'; expected",
    ),
    "names of more words than cells": (
        log(["Oil Flow", *NAMES], None, [["1", *row] for row in ROWS], " "),
        "blanks part 7 columns, but 8 names",
    ),
    "unknown encoding": (log([name.replace("load", "\u8377\u91cd") for name in NAMES]), "utf-8"),
}


@pytest.mark.parametrize(("text", "sentence"), REFUSED.values(), ids=REFUSED)
def test_log_that_could_be_misread_is_refused(text: str, sentence: str) -> None:
    assert sentence in read(text).refusals[0].reason


def test_column_that_the_campaign_names_is_taken_before_one_of_the_same_meaning() -> None:
    names = ["time", "Elapsed", *NAMES[1:]]
    rows = [[stamp, *row] for stamp, row in zip(("10:15:00", "10:15:03"), ROWS, strict=True)]
    text = log(names, ["", *UNITS], rows)
    config = CONFIG.with_changes({"campaign": {"columns": {"time": {"name": "Elapsed"}}}})
    (run,) = read_log(text.encode(), "log", config)[1].runs
    assert run.samples["time_s"].tolist() == [0.0, 0.5]


@pytest.mark.parametrize("write", [formats.csv, formats.lvm])
@pytest.mark.parametrize("encoding", ["utf-8", "gb18030", "cp1252"])
def test_damaged_byte_keeps_the_encoding(write: Callable[..., bytes], encoding: str) -> None:
    units = {**formats.UNITS, "inlet_temperature": "\N{DEGREE SIGN}C"}
    note = {"gb18030": "\u8bd5\u9a8c", "cp1252": "Pr\u00fcfer"}.get(encoding, "\u6d4b\u00fc")
    text = write(formats.columns(20), units, {**formats.KEYS, "note": note})
    content = text.decode().encode(encoding)
    place = content.index(b"82.") + 1
    damaged = content[:place] + b"\xff" + content[place + 1 :]
    for log_bytes, rows in ((content, 20), (damaged, 19)):
        reading = read_log(log_bytes, "log", CONFIG)[1]
        assert reading.form.encoding == encoding
        assert len(reading.runs[0]) == rows


def test_runs_tell_the_columns_of_the_log_and_what_else_its_header_says() -> None:
    log = bad_logs.csv(run="first", operator="A; B", date="2026-03-01 10:15", ball="B7")
    (run,) = ingest_logs([("a.csv", log)], CONFIG).runs.to_dict("records")
    speeds = "ball_speed [rpm], disc_speed [rpm]"
    assert run["columns"] == (
        f"time [s], load [N], traction_force [N], {speeds}, inlet_temperature [degC]"
    )
    assert run["stated"] == "ball=B7; date=2026-03-01; operator=A, B"
