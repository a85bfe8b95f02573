"""However a log is laid out, in any dialect, it is read right or refused in a true sentence."""

import gzip
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as arrow
import pytest
from hypothesis import given
from hypothesis import strategies as st

import bad_logs
import formats
from bad_logs import CONFIG
from oilfilm.logs import ingest, raw_files
from oilfilm.logs.base import ParsedLog, UnreadableLogError
from oilfilm.logs.header import (
    misspelt_key_problem,
    project_header,
    project_key_and_text,
    with_default_rig_and_oil,
)
from oilfilm.logs.ingest import ingest_logs, read_log, unpack
from oilfilm.logs.text_rows import seconds_of_stamps
from oilfilm.settings.resolved import Settings

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


@pytest.mark.parametrize("wrong", [["00:00:00"], ["02:00:00"] * 3, ["23:59:59"], ["23:59:59"] * 3])
@pytest.mark.parametrize("start", ["00:10:00", "14:00:00", "23:59:30"])
def test_wrong_time_stamps_do_not_begin_the_next_day(wrong: list[str], start: str) -> None:
    first = pd.Timestamp(f"2026-03-01 {start}")
    stamps = [f"{first + pd.Timedelta(seconds=row):%H:%M:%S}" for row in range(60)]
    expected = np.arange(60.0)
    is_wrong = np.zeros(60, dtype=bool)
    is_wrong[12 : 12 + len(wrong)] = True
    stamps[12 : 12 + len(wrong)] = wrong
    seconds = seconds_of_stamps(pd.Series(stamps))
    np.testing.assert_array_equal(seconds[~is_wrong], expected[~is_wrong])


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
    "unit row with 1": log(
        [*NAMES, "slide_roll_ratio"], [*UNITS, "1"], [[*row, "0"] for row in ROWS]
    ),
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


def read(text: str, encoding: str = "utf-8") -> ParsedLog:
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


def test_single_quote_harms_its_row_alone() -> None:
    rows = [[f"{number / 50}", *row[1:]] for number, row in enumerate(pointed() * 5)]
    rows[4][0] = '"' + rows[4][0]
    reading = read(log(units=UNITS, rows=rows, delimiter=","))
    (refusal,) = reading.refusals
    assert (refusal.first_row, refusal.last_row, len(reading.runs[0])) == (5, 5, 9)


REFUSED = {
    "thousands or decimals": (
        log(rows=[[*ROWS[0][:4], "7.160", "70,0"], ROWS[1]]),
        "reads '0,00;82,3;0,05;28650,12;7.160;70,0'",
    ),
    "a decimal point among marks between thousands": (
        log(rows=[["0,00", "1.250,50", "0.052", *ROWS[0][3:]], ["0,50", "1.250,50", *ROWS[1][2:]]]),
        "reads '0,00;1.250,50;0.052;28650,12;7160,00;70,0'",
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
        "'load' and 'Load' are the same quantity 'load'",
    ),
    "hours or minutes": (
        log(rows=timed("10:15", "10:16")),
        "holds '10:15', which may be hours and minutes or minutes and seconds; expected all three",
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
        assert reading.dialect.encoding == encoding
        assert len(reading.runs[0]) == rows


def test_runs_tell_the_columns_of_the_log_and_what_else_its_header_says() -> None:
    log = bad_logs.csv(run="first", operator="A; B", date="2026-03-01 10:15", ball="B7")
    (run,) = ingest_logs([("a.csv", log)], CONFIG).runs.to_dict("records")
    names = ["time [s]", "load [N]", "traction_force [N]", "ball_speed [rpm]", "disc_speed [rpm]"]
    assert run["columns"] == (*names, "inlet_temperature [degC]")
    assert run["stated"] == ("ball=B7", "date=2026-03-01", "operator=A; B")


# unit -> what one of it is in the reader's unit, from the definitions of the units themselves
LOGGED_IN = {
    "time": {"s": 1.0, "\u79d2": 1.0, "ms": 1e-3, "min": 60.0},
    "load": {"N": 1.0, "kgf": 9.80665, "gf": 9.80665e-3, "lbf": 4.4482216152605, "kN": 1e3},
    "traction_force": {"N": 1.0, "mN": 1e-3, "kgf": 9.80665},
    "ball_speed": {"rpm": 1.0, "1/min": 1.0, "\u8f6c/\u5206": 1.0, "rad/s": 60 / (2 * np.pi)},
    "disc_speed": {"rpm": 1.0, "r/min": 1.0, "tr/min": 1.0, "rad/s": 60 / (2 * np.pi)},
    "inlet_temperature": {"degC": 1.0, "\N{DEGREE SIGN}C": 1.0, "K": 1.0, "degF": 5 / 9},
}


ZERO_C = {"K": 273.15, "degF": 32.0}


SAMPLES = "time_s load_n traction_force_n ball_speed_m_s disc_speed_m_s inlet_temperature_c".split()


SAMPLE_COLUMNS = dict(zip(LOGGED_IN, SAMPLES, strict=True))


ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "gb18030")


DIALECTS = st.fixed_dictionaries(
    {
        "marks": st.sampled_from([",.", ";.", ";,", "\t.", "\t,", "|.", "|,"]),
        "end": st.sampled_from(["\n", "\r\n", "\r"]),
        "encoding": st.sampled_from(ENCODINGS),
        "name": st.sampled_from(["{} [{}]", "{} ({})", "{}"]),
        "comment": st.sampled_from(["# ", ""]),
        "units": st.fixed_dictionaries(
            {name: st.sampled_from(sorted(units)) for name, units in LOGGED_IN.items()}
        ),
        "order": st.permutations([*LOGGED_IN, "\u5907\u6ce8"]),
    }
)


def write(dialect: dict[str, Any], values: dict[str, np.ndarray]) -> bytes:
    """Units stand behind the names or below them; a column of words is beside the numbers."""
    (delimiter, decimal_mark), order, units = dialect["marks"], dialect["order"], dialect["units"]
    titles = [dialect["name"].format(name.title(), units.get(name, "-")) for name in order]
    below = [[units.get(name, "") for name in order]] if dialect["name"] == "{}" else []
    rows = [
        [repr(float(values[name][n])) if name in values else "x" for name in order]
        for n in range(len(values["time"]))
    ]
    cells = [[cell.replace(".", decimal_mark) for cell in row] for row in rows]
    header = [f"{dialect['comment']}{line}" for line in ("oil: 4102", "\u64cd\u4f5c\u5458: \u5f20")]
    lines = [*header, "", *map(delimiter.join, [titles, *below, *cells]), ""]
    return dialect["end"].join(lines).encode(dialect["encoding"])


@given(
    dialect=DIALECTS,
    rows=st.lists(
        st.tuples(
            *5 * [st.floats(-1e5, 1e5, allow_nan=False).map(lambda x: round(x, 6))],
            # a temperature above absolute zero in every unit
            st.floats(0.001, 900, allow_nan=False).map(lambda x: round(x, 6)),
        ),
        min_size=1,
        max_size=5,
    ),
)
def test_what_is_written_comes_back(dialect: dict[str, Any], rows: list[tuple[float, ...]]) -> None:
    values = dict(zip(LOGGED_IN, np.array(rows).T, strict=True))
    _, reading = read_log(write(dialect, values), "log", CONFIG)
    assert reading.refusals == []
    (run,) = reading.runs
    rig = CONFIG.rigs["ball-on-disc-20mm"]
    for name, logged in values.items():
        unit = dialect["units"][name]
        expected = (logged - ZERO_C.get(unit, 0.0)) * LOGGED_IN[name][unit]
        if name.endswith("speed"):
            body = name.removesuffix("_speed")
            expected = expected * 2 * np.pi / 60 * getattr(rig, f"{body}_track_radius_m")
        samples = run.samples[SAMPLE_COLUMNS[name]]
        # 1e-12 relative; degF and K subtract 255 K, whose rounding is 3e-14
        np.testing.assert_allclose(samples, expected, rtol=1e-12, atol=2e-13 * 300)


def read_rows(names: str, *rows: str, config: Settings = CONFIG) -> ParsedLog:
    log = "\n".join(["# oil: 4102", names, *rows, ""])
    return read_log(log.encode("gb18030"), "log", config)[1]


def with_campaign(**changes: Any) -> Settings:
    return CONFIG.with_changes({"campaign": changes})


SLIP_NAMES = "time_s,load_n,traction_force_n,inlet_temperature_c,entrainment speed [mm/s],"


@pytest.mark.parametrize(
    ("unit", "definition", "logged"),
    [("-", "over_mean", 0.2), ("%", "over_mean", 20), ("1", "over_sum", 0.1)],
)
def test_log_of_speed_and_slip_gives_surface_speeds(
    unit: str, definition: str, logged: float
) -> None:
    config = with_campaign(semantics={"slide_roll_ratio": definition})
    names = f"{SLIP_NAMES}slide_roll_ratio [{unit}]"
    (run,) = read_rows(names, f"0,82,1,70,10000,{logged}", config=config).runs
    assert run.samples["disc_speed_m_s"].tolist() == pytest.approx([11.0])
    assert run.samples["ball_speed_m_s"].tolist() == pytest.approx([9.0])


def test_slip_that_no_two_bodies_can_have_is_refused_with_its_row() -> None:
    config = with_campaign(semantics={"slide_roll_ratio": "over_faster"})
    rows = "0,82,1,70,10,0.1", "1,82,1,70,10,2"
    reading = read_rows(f"{SLIP_NAMES}slide_roll_ratio", *rows, config=config)
    (refusal,) = reading.refusals
    assert (refusal.rule, refusal.first_row, refusal.refused_rows) == ("unreadable_row", 2, 1)
    assert len(reading.runs[0]) == 1


def test_log_in_rpm_of_a_rig_without_radii_says_what_is_missing() -> None:
    rigs = {"pcs-etm": {"name": "x", "source": "y"}}
    config = Settings.from_plain_values({**CONFIG.plain_values(), "rigs": rigs})
    names = "time_s,load_n,traction_force_n,ball_speed_rpm,disc_speed_rpm,inlet_temperature_c"
    (refusal,) = read_rows(names, "0,1,2,3,4,5", config=config).refusals
    assert refusal.rule == "rig"
    assert "ball_track_radius_m" in refusal.reason
    assert refusal.refused_rows == 1


def test_archive_that_unfolds_without_end_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    bomb = gzip.compress(bytes(1 << 20), 9)
    stacked = arrow.compress(bytes((1 << 29) + 10), "zstd", asbytes=True)
    assert len(unpack(bomb)) == 1 << 20
    with pytest.raises(UnreadableLogError, match="16 MiB"):
        unpack(stacked)
    # a large log is no damaged one
    monkeypatch.setattr(ingest, "LARGEST_LOG_BYTES", 1 << 20)
    with pytest.raises(UnreadableLogError, match="1 MiB") as error:
        unpack(gzip.compress(bad_logs.ROWS * 99))
    assert error.value.refusal.rule == "too_large"


ONE_OIL = type(CONFIG).from_plain_values(
    {**CONFIG.plain_values(), "oils": {"4050": CONFIG.plain_values()["oils"]["4050"]}}
)


@pytest.mark.parametrize("key", ["lubricant", "test_oil", "oil_name", "Schmierstoff", "润滑油"])
def test_log_that_names_another_oil_is_not_filed_under_the_only_one(key: str) -> None:
    log = f"# {key}: 4102\n".encode() + bad_logs.ROWS
    (refusal,) = read_log(log, "log", ONE_OIL)[1].refusals
    assert (refusal.rule, "'4102'" in refusal.reason) == ("unknown_oil", True)
    (run,) = read_log(log, "log", CONFIG)[1].runs
    assert run.oil_name == "4102"
    # no name of an oil
    assert (
        with_default_rig_and_oil({"oil_temperature_c": "70", "oil_flow": "2"}, ONE_OIL)["oil"]
        == "4050"
    )


def test_key_like_that_of_the_oil_refuses_no_log_that_names_the_oil() -> None:
    listed = CONFIG.with_changes({"campaign": {"header": {"oil": ["Sample"]}}})
    for line, rules in (("# Sample: 4102\n", []), ("", ["header"])):
        log = f"{line}# Samples: 12000\n".encode() + bad_logs.ROWS
        reading = read_log(log, "log", listed)[1]
        assert [refusal.rule for refusal in reading.refusals] == rules


@pytest.mark.parametrize("key", ["load_(_kn_)", "load_[_kn_]", "load_[kn]"])
def test_blanks_within_the_brackets_of_a_unit_change_nothing(key: str) -> None:
    assert project_key_and_text(key, "0.08", {}, ".") == ("load_n", "80")
    assert project_key_and_text("entrainment_speed_[m_/_s]", "20", {}, ".") == (
        "entrainment_speed_m_s",
        "20",
    )


@pytest.mark.parametrize(
    ("key", "meant"),
    [
        ("entrainement_speed_m_s", "entrainment_speed_m_s"),
        ("inlet_temprature_c", "inlet_temperature_c"),
        ("max_herz_pressure_gpa", "max_hertz_pressure_gpa"),
        ("load", "load_n"),
    ],
)
def test_misspelt_key_is_named_unless_the_set_point_is_known(key: str, meant: str) -> None:
    refusal = misspelt_key_problem({key: "30"}, CONFIG)
    assert refusal is not None
    assert repr(key) in refusal.reason and repr(meant) in refusal.reason
    # the load has one set point, as force or as pressure
    other = {"load": "max_hertz_pressure_gpa", "max_herz_pressure_gpa": "load_n"}.get(key, meant)
    assert misspelt_key_problem({key: "30", other: "80"}, CONFIG) is None
    assert misspelt_key_problem({key: "30"}, with_campaign(set_points={other: 1.0})) is None


def test_word_of_its_own_is_no_slip_of_the_pen() -> None:
    keys = "laod_n oil_temperature_c outlet_temperature_c mean_hertz_pressure_gpa load_no operator"
    assert misspelt_key_problem(dict.fromkeys(keys.split(), "30"), CONFIG) is None


@pytest.mark.parametrize(
    ("line", "text", "key", "expected"),
    [
        ("load_kn", "0.08", "load_n", 80),
        ("load_[kn]", "0,08", "load_n", 80),
        ("load", "80 N", "load_n", 80),
        ("load_n", "0.08 kN", "load_n", 80),
        # Fortran writes no zero behind the decimal mark
        ("load_kn", "80.", "load_n", 80e3),
        ("load", "80. N", "load_n", 80),
        ("load_kn", "8.e-2", "load_n", 80),
        ("last_[kn]", "0.08", "load_n", 80),
        ("max_hertz_pressure_mpa", "1250", "max_hertz_pressure_gpa", 1.25),
        ("max_hertz_pressure", "1.25e9 Pa", "max_hertz_pressure_gpa", 1.25),
        ("entrainment_speed_mm_s", "2500", "entrainment_speed_m_s", 2.5),
        ("entrainment_speed_(m/s)", "2.5", "entrainment_speed_m_s", 2.5),
        # 0 degC is 273.15 K and 32 degF by definition
        ("inlet_temperature_k", "343.15", "inlet_temperature_c", 70),
        ("inlet_temperature", "158 \u00b0F", "inlet_temperature_c", 70),
        ("inlet_temperature_c", "70\u2103", "inlet_temperature_c", 70),
    ],
)
def test_header_set_point_may_have_a_unit(line: str, text: str, key: str, expected: float) -> None:
    config = with_campaign(header={"load_n": "Last"})
    keys = project_header({line: text, "oil": "4102"}, config)
    assert keys.keys() == {"oil", key}
    assert float(keys[key]) == pytest.approx(expected, rel=1e-11)
    # two lines that agree are one
    assert project_header({key: keys[key], line: text}, config).keys() == {key}


@pytest.mark.parametrize(
    ("line", "text", "decimal_mark", "sentence"),
    [
        ("load [N]", "1,250", ".", "load_n: '1,250 N'; expected 1250 or 1.25 (in N), without a"),
        ("load", "1.250 N", ",", "load_n: '1.250 N'; expected 1250 or 1.25 (in N), without a"),
        ("entrainment_speed [mm/s]", "30,000", ".", "expected 30000 or 30 (in mm/s), without a"),
    ],
)
def test_set_point_that_may_be_either_of_two_numbers_refuses_the_log(
    line: str, text: str, decimal_mark: str, sentence: str
) -> None:
    rows = ROWS if decimal_mark == "," else pointed()
    _, reading = read_log(
        log(above=f"# oil: 4102\n# {line}: {text}", rows=rows).encode(), "log", CONFIG
    )
    (refusal,) = [refusal for refusal in reading.refusals if refusal.rule == "header"]
    assert sentence in refusal.reason


def test_set_point_with_the_decimal_mark_of_the_log_is_read() -> None:
    _, reading = read_log(log(above="# oil: 4102\n# load [N]: 1,250").encode(), "log", CONFIG)
    assert reading.runs[0].set_points["load_n"] == 1.25
    _, reading = read_log(
        log(above="# oil: 4102\n# load [N]: 1.250", rows=pointed()).encode(), "log", CONFIG
    )
    assert reading.runs[0].set_points["load_n"] == 1.25


@pytest.mark.parametrize("line", ["load [stone]: 3", "load_n: 80 banana", "load_kn: much"])
def test_set_point_in_an_impossible_unit_is_refused(line: str) -> None:
    log = f"# oil: 4102\n# {line}\n".encode() + bad_logs.ROWS
    (refusal,) = read_log(log, "log", CONFIG)[1].refusals
    assert refusal.rule == "header"
    assert "says load_n" in refusal.reason


def test_file_larger_than_any_log_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in (ingest, raw_files):
        monkeypatch.setattr(module, "LARGEST_LOG_BYTES", 1000)
    log = tmp_path / "log.csv"
    log.write_bytes(b"# oil: 4102\n" + 5000 * b"1,2,3,4,5,6\n")
    content = ingest.read_bytes(log)
    assert len(content) == 1001
    (refusal,) = ingest.read_log(content, "log.csv", CONFIG)[1].refusals
    assert refusal.rule == "too_large"
