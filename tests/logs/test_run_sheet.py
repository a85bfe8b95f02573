"""The run sheet: what it says beats headers, and every mistake in it is named."""

import gzip
import io
import shutil
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import openpyxl
import pyarrow as arrow
import pytest
from hypothesis import given
from hypothesis import strategies as st
from nptdms import GroupObject, RootObject

import formats
import torque_logs
from bad_logs import CONFIG, KEYS, PCS_ROW, UNITS, csv, good, pcs
from campaigns import LABORATORY
from oilfilm.base.errors import OilfilmError
from oilfilm.cli import main
from oilfilm.curation.curate import curate_logs
from oilfilm.curation.torque_rig import TorqueRig
from oilfilm.logs.base import SET_POINT_KEYS as NAMED
from oilfilm.logs.ingest import IngestedLogs, ingest_logs
from oilfilm.logs.log_schema import LogSchema
from oilfilm.logs.raw_files import find_run_sheet, raw_log_names
from oilfilm.logs.run_sheet import RunSheet
from oilfilm.logs.sheet_file import read_run_sheet
from oilfilm.logs.torque_log import TORQUE
from oilfilm.logs.traction_log import TRACTION
from oilfilm.settings.resolved import Settings
from opendocument_files import document, row, rows_of, spreadsheet

NO_KEYS: Mapping[str, Any] = {}
BARE = csv(oil=None, max_hertz_pressure_gpa=None, entrainment_speed_m_s=None,
    inlet_temperature_c=None)  # fmt: skip
HEAD = "file,oil,max_hertz_pressure_gpa,entrainment_speed_m_s,inlet_temperature_c\n"
SET_POINTS = "1.25,30,70"
NAMES_OF_SHEET = HEAD.strip().split(",")
ROW_OF_SHEET = ["a.csv", 4102, 1.25, 30.0, 70]


def sheet(
    text: str | bytes,
    files: Sequence[str] = ("a.csv",),
    settings: Settings = CONFIG,
    log_schema: LogSchema = TRACTION,
) -> RunSheet:
    content = text.encode() if isinstance(text, str) else text
    return read_run_sheet(content, Path("runs.csv"), files, settings, log_schema)


def ingested(
    text: str | bytes, logs: Mapping[str, bytes], settings: Settings = CONFIG
) -> IngestedLogs:
    return ingest_logs(logs.items(), settings, TRACTION, sheet(text, list(logs), settings))


def nominal(run: Mapping[str, Any]) -> list[float]:
    return [run[f"nominal_{name}"] for name in NAMED if name != "load_n"]


def zstd(log: bytes) -> bytes:
    return bytes(arrow.compress(log, "zstd", True))


@pytest.mark.parametrize("name", formats.WRITERS)
@pytest.mark.parametrize("pack", [bytes, gzip.compress, zstd])
def test_log_without_header_becomes_the_run_that_its_row_describes(name: str, pack: Any) -> None:
    bare, labelled = (formats.WRITERS[name](good(), UNITS, keys) for keys in (NO_KEYS, KEYS))
    found = ingested(f"{HEAD}a.log,4102,{SET_POINTS}\n", {"a.log": pack(bare)})
    expected = ingest_logs([("a.log", labelled)], CONFIG)
    assert found.quarantine.empty
    own = ["sha256", "content_sha256", "stated"]
    assert found.runs.drop(columns=own).equals(expected.runs.drop(columns=own))
    assert found.all_samples().equals(expected.all_samples())


def bomb() -> bytes:
    """A workbook of 66 kB with 65 MiB of blanks in it."""
    made = io.BytesIO(workbook(["file"], ["a.csv"]))
    with zipfile.ZipFile(made, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("xl/blanks.xml", b" " * (65 << 20))
    return made.getvalue()


def workbook(*rows: Sequence[Any]) -> bytes:
    book = openpyxl.Workbook()
    for values in rows:
        book.active.append(values)
    buffer = io.BytesIO()
    book.save(buffer)
    return buffer.getvalue()


def test_formula_without_its_value_is_refused_with_its_address() -> None:
    """As openpyxl writes it: the run would be used."""
    content = workbook(["file", "exclude"], ["a.csv", ""], ["b.csv", '="bad bearing"'])
    with pytest.raises(OilfilmError, match=r"runs\.csv, cell B3: .*formula"):
        sheet(content, ["a.csv", "b.csv"])


LISTED = {
    "file": ["Datei", "文件"],
    "oil": ["Schmierstoff", "Öl", "润滑油"],
    "exclude": "Ausschluss",
    "remarks": ["Bemerkung", "Prüfer"],
    "max_hertz_pressure_gpa": ["Pressung", "最大接触压力"],
    "entrainment_speed_m_s": ["Rollgeschwindigkeit", "卷吸速度"],
    "inlet_temperature_c": ["Öltemperatur", "入口温度"],
}
GERMAN = (
    "Datei;Öl;Pressung;Rollgeschwindigkeit;Öltemperatur;Ausschluss;Prüfer\r\n"
    "Übung.csv;4102;1,25;30,0;70;;Müller\r\n"
)
CHINESE = "文件\t润滑油\t最大接触压力\t卷吸速度\t入口温度\n试验.csv\t4102\t1.25\t30\t70\n"
ROW = f"a.csv,4102,{SET_POINTS}\n"


@pytest.mark.parametrize(
    ("content", "file"),
    [
        (GERMAN.encode("cp1252"), "Übung.csv"),
        (("sep=;\r\n" + GERMAN).encode("cp1252"), "Übung.csv"),
        # a Mac writes an umlaut in a name of a file as two characters
        (GERMAN.encode("cp1252"), "U\u0308bung.csv"),
        (CHINESE.encode("gb18030"), "试验.csv"),
        (CHINESE.encode("utf-16"), "试验.csv"),
        ((HEAD + ROW).replace("\n", "\r").encode(), "a.csv"),
        (f"# runs of June\n\n{HEAD}\n{ROW}".encode(), "a.csv"),
        (workbook(NAMES_OF_SHEET, ROW_OF_SHEET), "a.csv"),
        (spreadsheet(document(Runs=row() + rows_of([NAMES_OF_SHEET, ROW_OF_SHEET]))), "a.csv"),
    ],
)
def test_sheet_is_read_in_every_language_and_encoding(content: bytes, file: str) -> None:
    settings = CONFIG.with_changes({"campaign": {"header": LISTED}})
    found = ingested(content, {file: BARE}, settings)
    assert found.quarantine.empty
    (run,) = found.runs.to_dict("records")
    assert (run["oil"], nominal(run)) == ("4102", [1.25, 30, 70])


@pytest.mark.parametrize(
    ("text", "key", "value"),
    [
        # 1 kgf = 9.80665 N, 0 degC = 273.15 K by definition
        ("file,oil,load [kgf]\na.csv,4102,8", "load_n", 78.4532),
        ("file,oil,Last\uff08kN\uff09\na.csv,4102,0.08", "load_n", 80),
        ("file,oil,load [MPa]\na.csv,4102,1250", "max_hertz_pressure_gpa", 1.25),
        ("file,oil,inlet_temperature [K]\na.csv,4102,343.15", "inlet_temperature_c", 70),
        ("file,oil,inlet_temperature_c\na.csv,4102,-5", "inlet_temperature_c", -5),
    ],
)
def test_set_point_is_converted_from_its_column_unit(text: str, key: str, value: float) -> None:
    settings = CONFIG.with_changes({"campaign": {"header": {"load_n": "Last"}}})
    (run,) = ingested(text, {"a.csv": BARE}, settings).runs.to_dict("records")
    assert run[f"nominal_{key}"] == pytest.approx(value, rel=1e-9)


@pytest.mark.parametrize(
    ("given", "logged", "named"),
    [
        ("file,oil\na.csv,Öl Nr. 3", {}, ""),
        (HEAD + f"a.csv,4050,{SET_POINTS}", {}, "oil 4050 (header: oil '4102')"),
        (HEAD + "a.csv,4102,1.5,30,70", {}, "1.5 (header: max_hertz_pressure_gpa '1.25')"),
        (HEAD + ROW, {"oil": "mystery"}, "oil 4102 (header: oil 'mystery')"),
        (HEAD + ROW, {"oil": None, "lubricant": "mystery"}, "4102 (header: oil 'mystery')"),
        (HEAD + ROW, {"inlet_temperature_c": "warm"}, "70 (header: inlet_temperature_c 'warm')"),
        (HEAD + ROW, {}, ""),
        # the same to the third digit, or the same load by the contact of the rig
        (HEAD + "a.csv,4102,1.252,30.1,70.4", {}, ""),
    ],
)
def test_sheet_beats_the_header(given: str, logged: Mapping[str, Any], named: str) -> None:
    oils = {"4102": {"aliases": ["Öl Nr. 3"]}}
    settings = CONFIG.with_changes({"campaign": {"oils": ["4050", "4102"]}, "oils": oils})
    found = ingested(given, {"a.csv": csv(**logged)}, settings)
    (run,) = found.runs.to_dict("records")
    assert run["rule"] == ""
    assert run["oil"] == ("4050" if "4050" in given else "4102")
    reasons = found.quarantine["reason"].tolist()
    assert [named in reason for reason in reasons] == [True] * bool(named)
    assert found.quarantine["refused_rows"].sum() == 0


def test_excluded_run_is_listed_with_its_reason_and_keeps_its_rows() -> None:
    text = "file,exclude\na.csv,pump failed\nb.csv,no\n"
    logs = {"a.csv": csv(), "b.csv": csv(inlet_temperature_c=69.9)}
    verdict = curate_logs(logs.items(), CONFIG, sheet=sheet(text, list(logs)))
    # b is a copy of a, which is not there for other runs
    assert verdict.runs.set_index("run_id")["verdict"].to_dict() == {
        "a.csv": "refused",
        "b.csv": "accepted",
    }
    (excluded,) = verdict.quarantine.to_dict("records")
    assert excluded["reason"] == "runs.csv excludes it: pump failed"
    rows = len(good()["time"])
    assert verdict.runs["samples"].tolist() == [rows, rows]
    assert not verdict.points.query("run_id == 'a.csv'")["accepted"].any()


@pytest.mark.parametrize("log", [BARE, csv(oil="mystery"), csv()[:-20]])
def test_excluded_log_is_listed_as_such_whatever_is_wrong_with_it(log: bytes) -> None:
    text = "file,oil,load_n,exclude\na.csv,water,?,wrong oil filled in"
    logs = {"a.csv": log}
    verdict = curate_logs(logs.items(), CONFIG, sheet=sheet(text))
    listed = verdict.quarantine[verdict.quarantine["rule"] == "excluded"]
    assert listed["reason"].str.contains("wrong oil filled in").tolist() == [True]
    assert len(verdict.runs) or "besides" in listed["reason"].iloc[0]
    assert verdict.points["accepted"].sum() == 0


def test_runs_of_one_file_have_rows_of_their_own() -> None:
    text = "file,run,oil,exclude\na.tdms,A,4102,\na.tdms,B,4050,stopped\na.tdms,C,4050,\n"
    settings = CONFIG.with_changes({"campaign": {"oils": ["4050", "4102"]}})
    groups = [
        item
        for name in ("A", "B")
        for item in (GroupObject(name), *formats.tdms_channels(name, good(), UNITS))
    ]
    log = formats.tdms_file([RootObject({}), *groups])
    found = ingested(text, {"a.tdms": log}, settings)
    assert found.runs.set_index("run_id")[["oil", "rule"]].to_numpy().tolist() == [
        ["4102", ""],
        ["4050", "excluded"],
    ]
    (remark,) = found.quarantine.to_dict("records")
    assert remark["rule"] == "sheet_row_unmatched"
    assert "'a.tdms', run 'C', but the runs of the log are 'A', 'B'" in remark["reason"]


def two_runs(*, loads_n: Sequence[float] = (80, 80), restarts: bool = False) -> bytes:
    """A log with a column `Run`: A in two halves, with their loads and clocks, and B."""
    names = ["Run", *(f"{name} [{UNITS[name]}]" for name in good())]
    lines = [",".join(names)]
    rows = 400
    for row_index in range(3 * rows):
        half, row_of_half = divmod(row_index, rows)
        load = [*loads_n, loads_n[0]][half]
        slip = 0.1 * row_of_half / rows
        time = row_of_half if restarts else row_index
        force = 0.03 * load
        speeds = f"{28000 * (1 - slip / 2):.3f},{7000 * (1 + slip / 2):.3f}"
        lines.append(f"{'AAB'[half]},{0.02 * time:.2f},{load},{force},{speeds},70")
    return ("\n".join(lines) + "\n").encode()


@pytest.mark.parametrize(
    ("log", "parts"),
    [
        (two_runs(loads_n=(50, 100)), ["A setpoint1", "A setpoint2"]),
        (two_runs(restarts=True), ["A part1", "A part2"]),
    ],
    ids=["set points", "restart of time"],
)
def test_row_of_a_run_holds_for_each_part_into_which_the_run_is_divided(
    log: bytes, parts: Sequence[str]
) -> None:
    text = "file,run,oil,exclude\na.csv,A,4102,pump failed\na.csv,B,4050,\n"
    found = ingested(text, {"a.csv": log})
    assert found.runs[["run_id", "oil", "rule"]].to_numpy().tolist() == [
        *([f"a.csv:{part}", "4102", "excluded"] for part in parts),
        ["a.csv:B", "4050", ""],
    ]
    assert "sheet_row_unmatched" not in set(found.quarantine["rule"])


def test_row_of_a_run_with_two_oils_holds_for_the_rows_of_both() -> None:
    names = ",".join(f"{name} [{UNITS[name]}]" for name in good())
    lines = [f"Run,Oil,{names}"]
    rows = np.column_stack(list(good().values())).tolist()
    for label, rows_of_label in zip(
        ["A,4102", "A,4050", "B,4102"], np.array_split(rows, 3), strict=True
    ):
        lines += [",".join([label, *map(repr, cells)]) for cells in rows_of_label.tolist()]
    log = ("\n".join(lines) + "\n").encode()
    found = ingested("file,run,exclude\na.csv,A,pump failed\n", {"a.csv": log})
    assert found.runs[["run_id", "rule"]].to_numpy().tolist() == [
        ["a.csv:A 4102", "excluded"],
        ["a.csv:A 4050", "excluded"],
        ["a.csv:B 4102", ""],
    ]


def test_steps_of_a_pcs_export_may_be_of_several_oils() -> None:
    second = pcs(PCS_ROW).replace(b"Step 1", b"Step 2").replace(b"06/05", b"07/05")
    log = pcs(PCS_ROW).replace(b"\n\nAll steps completed\n", b"\n") + second
    text = "file,run,oil,inlet_temperature_c\n*.txt,step001,4050,40\n*.txt,step*2,4102,60\n"
    found = ingested(text, {"a.txt": log})
    assert found.runs["oil"].tolist() == ["4050", "4102"]
    assert found.runs["nominal_inlet_temperature_c"].tolist() == [40, 60]
    assert found.quarantine.empty


def test_rows_that_disagree_about_a_run_refuse_it() -> None:
    # a load and a pressure are one set point; `run` is not read for a csv, which is one run
    text = "file,run,oil,load_n\n*.csv,,4102,\na.csv,,4050,80\nb.csv,step1,,200\n"
    settings = CONFIG.with_changes({"campaign": {"oils": ["4050", "4102"]}})
    found = ingested(text, {"a.csv": BARE, "b.csv": csv(oil=None)}, settings)
    assert found.runs["run_id"].tolist() == ["b.csv"]
    # rows that agree complete each other and the header
    assert found.runs["nominal_load_n"].tolist() == [200]
    assert found.runs["nominal_max_hertz_pressure_gpa"].isna().all()
    (refusal,) = found.quarantine.to_dict("records")
    assert refusal["rule"] == "sheet_rows_disagree"
    assert "oil: '4102' (row of '*.csv'), '4050' (row of 'a.csv')" in refusal["reason"]
    assert refusal["refused_rows"] == len(good()["time"])


FILES = ["a.csv", "june/a.csv", "june/b.csv", "july/c.csv.gz", "july/b.csv", "r[1].csv"]


@pytest.mark.parametrize(
    ("cell", "found"),
    [
        ("a.csv", ["a.csv"]),
        ("./june/a.csv", ["june/a.csv"]),
        ("june\\a.csv", ["june/a.csv"]),
        ("june/*", ["june/a.csv", "june/b.csv"]),
        ("?.csv", ["a.csv", "june/a.csv", "june/b.csv", "july/c.csv.gz", "july/b.csv"]),
        ("c.csv", ["july/c.csv.gz"]),
        ("r[1].csv", ["r[1].csv"]),
        ("A.csv", []),
        ("../a.csv", []),
    ],
)
def test_row_means_the_logs_that_fit_its_cell(cell: str, found: list[str]) -> None:
    assert sheet(f"file,oil\n{cell},4102\n", FILES).rows_of_log.keys() == {*found}


def test_rows_and_logs_without_each_other_are_named() -> None:
    text = f"{HEAD}a.cvs,4102,{SET_POINTS}\n\nb.csv,4102,{SET_POINTS}\n"
    found = ingested(text, {"a.csv": csv(), "b.csv": BARE})
    remarks = found.quarantine.set_index("rule")
    assert remarks["file"].unique().tolist() == ["runs.csv"]
    unmatched = remarks.at["sheet_row_unmatched", "reason"]
    assert unmatched == "row 2: 'a.cvs' matches no log"
    unlisted = remarks.at["logs_not_in_sheet", "reason"]
    assert unlisted == "no row for 1 of 2 logs: a.csv"
    assert found.runs["run_id"].tolist() == ["a.csv", "b.csv"]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "expected a row of column names, one of them `file`"),
        ("time_s,load_n\n0,1\n", "found 'time_s, load_n', expected a row of column names"),
        ("file,oi\na.csv,4102\n", "row 1: found the unknown column 'oi'; expected file"),
        ("file,oil,oil\n", "row 1: 2 columns give oil"),
        ("file,load\na.csv,80\n", "column 'load': has no unit, expected N or GPa in brackets"),
        ("file,load [m/s]\n", "found the unit 'm/s', expected N or GPa"),
        ("\nfile,oil\na.csv,water\n", "row 3, column 'oil': found 'water', expected oil of the "),
        ("file,rig\na.csv,mars\n", "row 2, column 'rig': found 'mars', expected rig of the camp"),
        ("file,load_n\na.csv,80 s\n", "row 2, column 'load_n': found '80 s', expected a number"),
        ("file,max_hertz_pressure_gpa\na.csv,1250\n", "found '1250', expected a number above 0"),
        # a unit in a cell makes no pressure of a load, and no load of a pressure
        ("file,load [N]\na.csv,1.2 GPa\n", "row 2, column 'load [N]': found '1.2 GPa', expected"),
        ("file,load [N]\na.csv,900 MPa\n", "row 2, column 'load [N]': found '900 MPa', expected"),
        ("file,load [GPa]\na.csv,50 N\n", "row 2, column 'load [GPa]': found '50 N', expected"),
        ("file,oil\n,4102\n", "row 2, column 'file': is empty, expected the name of a log"),
        ("file,oil\na.csv,4102,80\n", "row 2: the cell '80' is in no column"),
        ("file,oil\nb.csv,4102\n", "row 2: 'b.csv' is the name of june/b.csv, july/b.csv"),
        (b"PK\x03\x04" + bytes(90), "cannot be read as a workbook"),
        (bomb(), "unpacked it has 65 MiB"),
    ],
)
def test_mistake_in_the_sheet_is_named_with_its_place(text: str | bytes, sentence: str) -> None:
    with pytest.raises(OilfilmError) as error:
        sheet(text, FILES)
    assert sentence in str(error.value)
    assert all(line.startswith("runs.csv") for line in str(error.value).splitlines())


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        # nothing in the sheet says which mark is the decimal one
        ("file;load [N]\na.csv;1.250\n", "found '1.250', expected 1250 or 1.25 (in N), without"),
        ("file;load [N]\na.csv;1,250\n", "found '1,250', expected 1250 or 1.25 (in N), without"),
        ('file,load_n\na.csv,"1,250"\n', "found '1,250', expected 1250 or 1.25 (in N), without"),
        ("file;u [mm/s];T\na.csv;30.000;70,5\n", "expected 30000 or 30 (in mm/s), without a mark"),
    ],
)
def test_set_point_that_may_be_either_of_two_numbers_is_refused(text: str, sentence: str) -> None:
    names = {"entrainment_speed_m_s": "u", "inlet_temperature_c": "T"}
    with pytest.raises(OilfilmError) as error:
        sheet(text, settings=CONFIG.with_changes({"campaign": {"header": names}}))
    assert sentence in str(error.value)


@pytest.mark.parametrize(
    ("text", "set_point", "expected"),
    [
        ("file,load_n\na.csv,1.250\n", "load_n", "1.25"),
        # another cell has a decimal comma, or point
        ("file;load_n;inlet_temperature_c\na.csv;1,250;70,5\n", "load_n", "1.25"),
        ("file;load_n;inlet_temperature_c\na.csv;1.250;70.5\n", "load_n", "1.25"),
        # no contact bears 1250 GPa, no oil is at 70000 degC, no disc runs at 2500 m/s
        ("file;max_hertz_pressure_gpa\na.csv;1,250\n", "max_hertz_pressure_gpa", "1.25"),
        ("file;inlet_temperature_c\na.csv;70.000\n", "inlet_temperature_c", "70"),
        ("file;entrainment_speed_m_s\na.csv;2,500\n", "entrainment_speed_m_s", "2.5"),
    ],
)
def test_set_point_with_three_decimals_is_read_where_only_that_is_possible(
    text: str, set_point: str, expected: str
) -> None:
    (row_of_sheet,) = sheet(text).rows_of_log["a.csv"]
    assert row_of_sheet.text_of_key[set_point] == expected


def test_all_mistakes_are_named_at_once() -> None:
    with pytest.raises(OilfilmError) as error:
        sheet("file,oil,load_n\na.csv,water,80\na.csv,4102,much\n" + ",4102,80\n" * 28)
    *named, others = str(error.value).splitlines()
    assert [line.split(",")[1] for line in named] == [f" row {n}" for n in range(2, 22)]
    assert others == "runs.csv: 10 more mistakes"


@given(st.binary(max_size=300) | st.text("file,;\n\toil4102*\"'[]()N ä", max_size=200))
def test_any_bytes_are_a_sheet_or_end_in_a_sentence(content: bytes | str) -> None:
    try:
        sheet(content, FILES)
    except OilfilmError as error:
        assert "runs.csv" in str(error)


def test_torque_log_gets_its_oil_from_the_sheet() -> None:
    logs = {
        name: torque_logs.text(torque_logs.signals(seed), header="")
        for seed, name in enumerate(("a.csv", "b.csv"))
    }
    text = "file;oil;exclude\na.csv;4050;\nb.csv;4050;bearing was noisy\n"
    of_torque = sheet(text, list(logs), CONFIG, TORQUE)
    curated = curate_logs(logs.items(), CONFIG, TorqueRig, of_torque)
    assert curated.runs["oil"].tolist() == ["4050", "4050"]
    assert curated.runs["verdict"].tolist() == ["accepted", "refused"]
    assert curated.quarantine["rule"].tolist() == ["excluded"]
    with pytest.raises(OilfilmError, match="row 2, column 'bearing': found '6205'"):
        sheet("file,oil,bearing\na.csv,4050,6205", list(logs), CONFIG, TORQUE)


def test_part_of_a_share_changes_with_its_own_rows_alone() -> None:
    files = ["a.csv", "b.csv"]

    def parts(text: str) -> list[dict[str, Any]]:
        return [sheet(text, files).to_params([file], with_remarks=False) for file in files]

    before = parts("file,oil,remarks\na.csv,4102,\nb.csv,4102,\n")
    assert RunSheet.from_params(before[0]).rows_of_log == sheet("file,oil\na.csv,4102").rows_of_log
    # a remark, a row of no log and the order change no result
    again = "file,oil,remarks\nz.csv,4102,\nb.csv,4102,warm day\na.csv,4102,\n"
    assert parts(again) == before
    changed = parts("file,oil\na.csv,4102\nb.csv,4050\n")
    assert (changed[0] == before[0], changed[1] == before[1]) == (True, False)


def test_sheet_is_no_log_and_there_is_one(tmp_path: Path) -> None:
    (tmp_path / "june").mkdir()
    for name in ("a.csv", "Runs.CSV", "june/runs.csv", "~$runs.xlsx"):
        (tmp_path / name).write_text("x")
    assert raw_log_names(tmp_path) == ["a.csv", "june/runs.csv"]
    assert find_run_sheet(tmp_path) == tmp_path / "Runs.CSV"
    (tmp_path / "runs.tsv").write_text("x")
    with pytest.raises(OilfilmError, match=r"Runs.CSV and runs.tsv"):
        find_run_sheet(tmp_path)


def test_check_uses_the_sheet_nearby(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    raw = tmp_path / "data/raw/laboratory"
    raw.mkdir(parents=True)
    (raw / "runs.csv").write_text(f"{HEAD}a.csv,4102,{SET_POINTS}\n")
    # of two logs of a folder without a header, one has a row; elsewhere there is no sheet
    where = ["--config", str(tmp_path / "config")]
    shutil.copytree(LABORATORY, tmp_path / "config")
    for log, code, said in (
        (raw / "a.csv", 0, "a.csv: ACCEPTED"),
        (raw / "b.csv", 1, "no row for this log"),
        (tmp_path / "a.csv", 1, "no line `# oil: ...`"),
    ):
        log.write_bytes(BARE)
        assert main(["check", str(log), *where]) == code
        assert said in " ".join(capsys.readouterr().out.split())
    assert main(["check", str(raw / "runs.csv"), *where]) == 2
    assert "runs.csv" in capsys.readouterr().err
