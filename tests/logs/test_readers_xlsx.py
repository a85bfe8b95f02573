"""Workbooks are read sheet by sheet, and one that would fill the memory is refused at once."""

import datetime
import io
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import openpyxl
import pytest

import formats
import oilfilm
from allocations import peak_bytes
from bad_logs import CONFIG
from oilfilm.api.mu_columns import stated_columns
from oilfilm.api.table_fit import SLIP, StatedByUser, read_mu_table
from oilfilm.base.errors import OilfilmError
from oilfilm.logs.base import READING_NOTE
from oilfilm.logs.ingest import read_log
from oilfilm.logs.workbook import checked_workbook, sheet_texts

VALUES = formats.columns(30)
NAMES = [f"{name} ({formats.UNITS[name]})" for name in VALUES]
ROWS = np.column_stack(list(VALUES.values())).tolist()


def book(**sheets: Sequence[Sequence[Any]]) -> bytes:
    made = openpyxl.Workbook()
    made.remove(made.active)
    for title, rows in sheets.items():
        sheet = made.create_sheet(title)
        for row in rows:
            sheet.append(list(row))
    buffer = io.BytesIO()
    made.save(buffer)
    return buffer.getvalue()


def test_numbers_and_header_of_a_sheet_are_those_of_a_text_log(read) -> None:
    reading = read(book(Log=[["Oil", "4102"], [], NAMES, *ROWS]))
    (run,) = reading.runs
    assert (run.run_id, run.oil_name) == ("log", "4102")
    np.testing.assert_array_equal(run.samples["time_s"], VALUES["time"])
    np.testing.assert_allclose(run.samples["load_n"], VALUES["load"] * 9.80665, rtol=1e-12)
    assert reading.refusals == []


def test_each_sheet_with_columns_is_a_run_and_others_are_named(read) -> None:
    reading = read(
        book(
            Cover=[["Test", "Day"], ["traction", 3]],
            first=[["Oil", "4102"], NAMES, *ROWS[:10]],
            second=[["Oil", "4050"], NAMES, *ROWS[10:]],
        )
    )
    assert [(run.run_id, run.oil_name, len(run)) for run in reading.runs] == [
        ("log:first", "4102", 10),
        ("log:second", "4050", 20),
    ]
    (note,) = reading.refusals
    assert note.rule == READING_NOTE
    assert "'Cover'" in note.reason


def test_column_of_runs_and_repeated_headers_divide_a_sheet(read) -> None:
    with_runs = [["Run", *NAMES], *([row // 10, *ROWS[row]] for row in range(30))]
    runs = read(book(Log=[["Oil", "4102"], *with_runs])).runs
    assert [run.run_id for run in runs] == ["log:0", "log:1", "log:2"]
    block = [["Load (N)", 20], NAMES, *ROWS[:10]]
    runs = read(book(Log=[["Oil", "4102"], *block, [], ["Load (N)", 40], *block[1:]])).runs
    assert [run.set_points["load_n"] for run in runs] == [20, 40]


def test_instants_of_a_sheet_are_seconds(read) -> None:
    start = datetime.datetime(2026, 3, 1, 10, 15)
    times = [start + datetime.timedelta(seconds=row / 4) for row in range(30)]
    rows = [[instant, *row[1:]] for instant, row in zip(times, ROWS, strict=True)]
    (run,) = read(book(Log=[["Oil", "4102"], ["time", *NAMES[1:]], *rows])).runs
    np.testing.assert_allclose(run.samples["time_s"], np.arange(30) / 4, atol=1e-9)


def test_date_in_a_column_of_its_own_counts(read) -> None:
    """Ten rows on the first of March, twenty on the third, which begin at midnight."""
    made = openpyxl.Workbook()
    made.active.append(["Oil", "4102"])
    made.active.append(["Date", "time", *NAMES[1:]])
    for index, values in enumerate(ROWS):
        second = index + 1 if index < 10 else index - 10
        day = datetime.datetime(2026, 3, 1 if index < 10 else 3)
        made.active.append([day, datetime.time(0, 0, second), *values[1:]])
        made.active.cell(made.active.max_row, 1).number_format = 'd\\.m\\.yyyy" (Thursday)"'
    buffer = io.BytesIO()
    made.save(buffer)
    (run,) = read(buffer.getvalue()).runs
    two_days_s = 2 * 86_400 - 1
    expected = [*range(10), *range(two_days_s, two_days_s + 20)]
    np.testing.assert_allclose(run.samples["time_s"], expected)


def test_instant_at_midnight_keeps_its_time_of_day(read) -> None:
    midnight = datetime.datetime(2026, 3, 1)
    times = [midnight + datetime.timedelta(seconds=index - 5) for index in range(30)]
    rows = [[instant, *values[1:]] for instant, values in zip(times, ROWS, strict=True)]
    (run,) = read(book(Log=[["Oil", "4102"], ["time", *NAMES[1:]], *rows])).runs
    np.testing.assert_allclose(run.samples["time_s"], np.arange(30))


@pytest.mark.parametrize("name", ["Time [min]", "Time [s]", "Time"])
def test_durations_of_a_sheet_say_their_unit_themselves(read, name: str) -> None:
    # the sheet shows 24:59:55 and so on: openpyxl writes durations so
    times = [datetime.timedelta(hours=25, seconds=row / 4 - 5) for row in range(30)]
    rows = [[duration, *row[1:]] for duration, row in zip(times, ROWS, strict=True)]
    (run,) = read(book(Log=[["Oil", "4102"], [name, *NAMES[1:]], *rows])).runs
    np.testing.assert_allclose(run.samples["time_s"], np.arange(30) / 4, atol=1e-9)


@pytest.mark.parametrize(("unit", "shown"), [("%", True), ("1", True), ("%", False), ("1", False)])
def test_slip_is_read_as_the_sheet_shows_it(read, unit: str, shown: bool) -> None:
    names = ["time (s)", "load (N)", "traction_force (N)", "entrainment_speed (m/s)"]
    names += [f"slide_roll_ratio ({unit})", "inlet_temperature (degC)"]
    made = openpyxl.Workbook()
    made.active.append(["Oil", "4102"])
    made.active.append(names)
    # the sheet shows 5.0%, or 5 below %, or 0.05 below 1
    made.active.append([0.0, 20, 1, 10, 0.05 if shown or unit == "1" else 5, 60])
    if shown:
        made.active["E3"].number_format = "0.0%"
    buffer = io.BytesIO()
    made.save(buffer)
    (run,) = read(buffer.getvalue()).runs
    slip = run.samples["disc_speed_m_s"] - run.samples["ball_speed_m_s"]
    np.testing.assert_allclose(slip / 10, [0.05])


@pytest.mark.parametrize(
    ("name", "unit", "is_read"),
    [("SRR", None, True), ("SRR", "%", False), ("SRR (percent)", None, False)],
)
def test_slip_shown_in_percent_without_its_sign_is_a_fraction(
    name: str, unit: str | None, is_read: bool
) -> None:
    """The sheet shows 60 %, and its cell holds 0.6: it must not be read as 0.6 %."""
    made = openpyxl.Workbook()
    made.active.append(["Oil", "4102"])
    made.active.append([*NAMES[:3], "entrainment_speed (m/s)", name, NAMES[5]])
    made.active.append([0.0, 20, 1, 10, 0.6, 60])
    made.active["E3"].number_format = "0.0%"
    buffer = io.BytesIO()
    made.save(buffer)
    columns = {"slide_roll_ratio": {"name": "SRR", "unit": unit}}
    settings = CONFIG.with_changes({"campaign": {"columns": columns}})
    _, reading = read_log(buffer.getvalue(), "log", settings)
    slips = [run.samples["disc_speed_m_s"] - run.samples["ball_speed_m_s"] for run in reading.runs]
    np.testing.assert_allclose(slips, [[6.0]] if is_read else [])


@pytest.mark.parametrize("number_format", ['0.0"%"', r"0.0\%", "0.0_%", '0.0" % of mean"'])
def test_percent_sign_in_a_text_of_the_format_changes_no_number(read, number_format: str) -> None:
    names = [*NAMES[:3], "entrainment_speed (m/s)", "slide_roll_ratio (%)", NAMES[5]]
    made = openpyxl.Workbook()
    for cells in (["Oil", "4102"], names, [0.0, 20, 1, 10, 5, 60]):
        made.active.append(cells)
    made.active["E3"].number_format = number_format
    buffer = io.BytesIO()
    made.save(buffer)
    (run,) = read(buffer.getvalue()).runs
    slip = run.samples["disc_speed_m_s"] - run.samples["ball_speed_m_s"]
    np.testing.assert_allclose(slip / 10, [0.05])


_UNITS = ["s", "N", "N", "m/s", "%", "degC"]


@pytest.mark.parametrize(
    ("rows_above", "slip_name", "rows_below"),
    [
        # the slip is a ratio: the percent sign is in a note above its column or between rows
        ([["Humidity", None, None, None, "45 %"]], "slide_roll_ratio (1)", []),
        ([["Air", "dry", "at", "a humidity of", "45 %"]], "slide_roll_ratio (1)", []),
        ([["Load", 20, "at", "humidity", "45 %"]], "slide_roll_ratio (1)", []),
        # as many words as there are names
        ([["Air", "dry", "at", "a humidity", "45 %", "here"]], "slide_roll_ratio (1)", []),
        # the name or the unit has it, below a note or above one
        ([["Humidity", None, None, None, "45"]], "slide_roll_ratio (%)", []),
        ([], "slide_roll_ratio", [_UNITS]),
        ([], "slide_roll_ratio", [["s", "N", 1, "m/s", "%", "degC"]]),
        ([["Humidity", None, None, None, "45 %"]], "slide_roll_ratio", [_UNITS]),
        # a row of a log may begin without a number, and a title may have numbers
        ([], "slide_roll_ratio (%)", [["NaN"] * 6]),
        ([["Ball", 10.5, "mm, disc", 50, "mm", None, 7]], "slide_roll_ratio (%)", []),
    ],
)
def test_percent_sign_counts_in_names_and_units_only(
    rows_above: list[list[Any]], slip_name: str, rows_below: list[list[Any]]
) -> None:
    """The sheet shows 0.05 % and 5 %; the column says what is in %."""
    names = [*NAMES[:4], slip_name, NAMES[5]]
    made = openpyxl.Workbook()
    for cells in (*rows_above, names, *rows_below):
        made.active.append(cells)
    for slip in (0.0005, 0.05):
        made.active.append([0.0, 20, 2.5, 10, slip, 60])
        made.active.cell(made.active.max_row, 5).number_format = "0.00%"
    buffer = io.BytesIO()
    made.save(buffer)
    ((_, text, _),) = sheet_texts(buffer.getvalue())
    slips = [line.split("\t")[4].strip() for line in text.decode().splitlines()[-2:]]
    is_ratio = slip_name.endswith("(1)")
    assert slips == (["0.0005", "0.05"] if is_ratio else ["0.05", "5"])


def test_names_of_a_second_table_count_below_it() -> None:
    first, second = "slide_roll_ratio (%)", "slide_roll_ratio (1)"
    made = openpyxl.Workbook()
    for slip_name in (first, second):
        made.active.append([*NAMES[:4], slip_name, NAMES[5]])
        made.active.append([0.0, 20, 2.5, 10, 0.05, 60])
        made.active.cell(made.active.max_row, 5).number_format = "0.00%"
    buffer = io.BytesIO()
    made.save(buffer)
    ((_, text, _),) = sheet_texts(buffer.getvalue())
    lines = text.decode().splitlines()
    assert [lines[index].split("\t")[4] for index in (1, 3)] == ["5", "0.05"]


@pytest.mark.parametrize(
    "row_between",
    [
        ["10:15:07", "NaN", "NaN", "NaN", "NaN", "NaN"],
        ["#N/A", "#N/A", "#N/A", "#N/A", "#N/A", "#N/A"],
        ["break", None, None, None, "lamp off"],
        ["Step 2", "Load 20 N", "Temp 40 C"],
        ["Step 2", "Load 20 N", "Temp 40 C", "dry", "clean", "late"],
    ],
)
def test_text_between_rows_of_numbers_names_no_column(row_between: list[str | None]) -> None:
    names = [*NAMES[:4], "slide_roll_ratio (%)", NAMES[5]]
    made = openpyxl.Workbook()
    for cells in (names, [0.0, 20, 2.5, 10, 0.05, 60], row_between, [1.0, 20, 2.5, 10, 0.05, 60]):
        made.active.append(cells)
    for row in (2, 4):
        made.active.cell(row, 5).number_format = "0.00%"
    buffer = io.BytesIO()
    made.save(buffer)
    ((_, text, _),) = sheet_texts(buffer.getvalue())
    lines = text.decode().splitlines()
    assert [lines[index].split("\t")[4] for index in (1, 3)] == ["5", "5"]


# ---------------------------------------------------------------- hostile workbooks

_MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
_RELATIONS = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
_PACKAGE = "http://schemas.openxmlformats.org/package/2006"
_OFFICE = "application/vnd.openxmlformats-officedocument.spreadsheetml"


def bare_book(sheet: str, part: str = "worksheets/sheet1.xml", strings: str = "") -> bytes:
    """A workbook of the parts that it needs, with the content of its sheet and shared strings."""
    parts = {
        "[Content_Types].xml": f'<Types xmlns="{_PACKAGE}/content-types">'
        '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.'
        'relationships+xml"/><Default Extension="xml" ContentType="application/xml"/>'
        f'<Override PartName="/xl/workbook.xml" ContentType="{_OFFICE}.sheet.main+xml"/>'
        f'<Override PartName="/xl/{part}" ContentType="{_OFFICE}.worksheet+xml"/>'
        "</Types>",
        "_rels/.rels": f'<Relationships xmlns="{_PACKAGE}/relationships"><Relationship Id="r1" '
        f'Type="{_RELATIONS}/officeDocument" Target="xl/workbook.xml"/></Relationships>',
        "xl/workbook.xml": f'<workbook xmlns="{_MAIN}" xmlns:r="{_RELATIONS}"><sheets><sheet '
        'name="a" sheetId="1" r:id="r1"/></sheets></workbook>',
        "xl/_rels/workbook.xml.rels": f'<Relationships xmlns="{_PACKAGE}/relationships">'
        f'<Relationship Id="r1" Type="{_RELATIONS}/worksheet" Target="{part}"/>'
        "</Relationships>",
        f"xl/{part}": sheet,
    }
    if strings:
        parts["xl/sharedStrings.xml"] = f'<sst xmlns="{_MAIN}">{strings}</sst>'
        parts["[Content_Types].xml"] = parts["[Content_Types].xml"].replace(
            "</Types>",
            '<Override PartName="/xl/sharedStrings.xml" '
            f'ContentType="{_OFFICE}.sharedStrings+xml"/></Types>',
        )
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in parts.items():
            archive.writestr(name, text)
    return buffer.getvalue()


def sheet_of(rows: str, dimension: str = "") -> str:
    stated = f'<dimension ref="{dimension}"/>' if dimension else ""
    return f'<worksheet xmlns="{_MAIN}">{stated}<sheetData>{rows}</sheetData></worksheet>'


def cell(where: str, text: str) -> str:
    return f'<c r="{where}" t="inlineStr"><is><t>{text}</t></is></c>'


FIRST_ROW = f'<row r="1">{cell("A1", "file")}</row>'
HOSTILE = {
    "far row": sheet_of(f'{FIRST_ROW}<row r="99999999999">{cell("A99999999999", "a.csv")}</row>'),
    "last column": sheet_of(
        "".join(f'<row r="{row}">{cell(f"XFD{row}", "x")}</row>' for row in range(1, 4001))
    ),
    "entities": '<!DOCTYPE x [<!ENTITY a "aaaa">]>' + sheet_of(FIRST_ROW),
}


@pytest.mark.parametrize("sheet", HOSTILE.values(), ids=HOSTILE)
def test_workbook_that_would_fill_the_memory_is_refused_at_once(sheet: str, tmp_path: Path) -> None:
    content = bare_book(sheet)
    with pytest.raises(ValueError, match=r"row|cells|entities"):
        checked_workbook(content)
    with peak_bytes() as peak:
        _, reading = read_log(content, "log", CONFIG)
    assert [refusal.rule for refusal in reading.refusals] == ["damaged_file"]
    path = tmp_path / "table.xlsx"
    path.write_bytes(content)
    with pytest.raises(OilfilmError, match="cannot be read"):
        oilfilm.fit_table(path)
    # without the bounds each of these takes gigabytes
    assert peak() < 1 << 25


@pytest.mark.parametrize("part", ["other/sheet.xml", "sheet.bin"])
def test_sheet_under_another_name_is_bounded_too(part: str) -> None:
    _, reading = read_log(bare_book(HOSTILE["far row"], part), "log", CONFIG)
    assert "row 99999999999" in reading.refusals[0].reason


def test_long_text_that_many_cells_share_is_bounded() -> None:
    rows = "".join(
        f'<row r="{row}"><c r="A{row}" t="s"><v>0</v></c></row>' for row in range(1, 1000)
    )
    content = bare_book(sheet_of(rows), strings=f"<si><t>{'x' * 1_000_000}</t></si>")
    _, reading = read_log(content, "log", CONFIG)
    assert "MiB" in reading.refusals[0].reason


def test_stated_size_of_a_sheet_is_not_believed() -> None:
    content = bare_book(sheet_of(FIRST_ROW, "A1:XFD1048576"))
    with peak_bytes() as peak:
        _, reading = read_log(content, "log", CONFIG)
    assert [refusal.rule for refusal in reading.refusals] == ["columns"]
    assert peak() < 1 << 25


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(500), "(.xls)"),
        (b"\x89HDF\r\n\x1a\n" + bytes(500), "HDF5"),
        (b"PK\x03\x04" + b"some/log.csv", "zip archive"),
    ],
)
def test_other_containers_are_refused_with_what_to_do(content: bytes, sentence: str) -> None:
    _, reading = read_log(content, "log", CONFIG)
    (refusal,) = reading.refusals
    assert refusal.rule == "unknown_format"
    assert sentence in refusal.reason


# ---------------------------------------------------------------- tables of mu


def mu_rows(scale: float = 1.0) -> list[list[Any]]:
    """Rows on a law whose mu is known: proportional to pressure, a tanh of the slip."""
    rows: list[list[Any]] = [["p [GPa]", "U [m/s]", "T [degC]", "SRR", "mu"]]
    for pressure in (1.0, 1.3):
        for speed in (5.0, 20.0):
            for temperature in (40.0, 80.0):
                for slip in (0.005, 0.02, 0.08, 0.2):
                    mu = scale * 0.05 * pressure * np.tanh(slip / 0.02) * (40 / temperature) ** 0.3
                    rows.append([pressure, speed, temperature, slip, float(mu)])
    return rows


@pytest.fixture
def saved(tmp_path: Path) -> Callable[[bytes], Path]:
    def save(content: bytes) -> Path:
        path = tmp_path / "table.xlsx"
        path.write_bytes(content)
        return path

    return save


@pytest.mark.slow
def test_sheets_of_a_table_are_oils_that_are_asked_for(saved) -> None:
    path = saved(book(M46=mu_rows(), M68=mu_rows(0.6), Notes=[["made by", "hand"]]))
    with pytest.raises(OilfilmError, match="M46, M68"):
        oilfilm.fit_table(path)
    fitted = oilfilm.fit_table(path, oil="M68", searches=2, bootstrap=20)
    assert len(fitted.points) == 32
    largest = 0.6 * 0.05 * 1.3 * np.tanh(10)
    assert fitted.points["traction_coefficient"].max() == pytest.approx(largest)
    assert any("'Notes'" in note for note in fitted.notes)


def test_table_behind_a_cover_sheet_is_found(saved) -> None:
    path = saved(book(Cover=[["Test", "Day"], ["a", 1]], Data=mu_rows()))
    fitted = oilfilm.fit_table(path, searches=2, bootstrap=20)
    assert len(fitted.points) == 32
    assert any("'Data' is read" in note for note in fitted.notes)


def test_slip_of_a_table_shown_in_percent_without_its_sign_is_a_fraction(tmp_path: Path) -> None:
    """The sheet shows 50 %: `SRR [%]` would make 0.5 % of it."""
    made = openpyxl.Workbook()
    made.active.append(["mu", "SRR"])
    for slip in (0.25, 0.5):
        made.active.append([0.05, slip])
        made.active.cell(made.active.max_row, 2).number_format = "0%"
    path = tmp_path / "table.xlsx"
    made.save(path)
    table = read_mu_table(path, StatedByUser(stated_columns("slide_roll_ratio=SRR")))
    assert table.points[SLIP].tolist() == [0.25, 0.5]
    with pytest.raises(OilfilmError, match="unit"):
        read_mu_table(path, StatedByUser(stated_columns("slide_roll_ratio=SRR [%]")))


def test_blocks_of_a_text_table_are_one_table(tmp_path: Path) -> None:
    names, *rows = mu_rows()
    lines: list[str] = []
    for block in range(4):
        lines += [f"Step {block}", ",".join(names)]
        lines += [",".join(map(str, row)) for row in rows[8 * block : 8 * (block + 1)]]
    path = tmp_path / "blocks.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    fitted = oilfilm.fit_table(path, searches=2, bootstrap=20)
    assert len(fitted.points) == 32
    together = sorted(fitted.points["traction_coefficient"])
    np.testing.assert_allclose(together, sorted(row[-1] for row in rows))


def percent_book(rows: Sequence[Sequence[Any]], column: str) -> bytes:
    made = openpyxl.Workbook()
    sheet = made.active
    assert sheet is not None
    for row in rows:
        sheet.append(list(row))
    for cell in sheet[column]:
        cell.number_format = "0.0%"
    buffer = io.BytesIO()
    made.save(buffer)
    return buffer.getvalue()


@pytest.mark.parametrize("units", [[], [[1, "%"]]], ids=["names only", "row of units"])
def test_the_first_row_of_a_column_in_percent_is_read_as_the_others(units: list[list[Any]]) -> None:
    # a 1 beside the number may be a reading, or a unit where the other cells are texts
    content = percent_book([["step", "S (%)"], *units, [1, 0.05], [2, 0.06]], "B")
    (sheet,) = sheet_texts(content)
    assert sheet.text.decode().splitlines()[-2:] == ["1\t5", "2\t6"]


def test_rows_of_one_cell_beside_a_far_cell_do_not_fill_the_memory() -> None:
    made = openpyxl.Workbook()
    sheet = made.active
    assert sheet is not None
    sheet["XFD1"] = "note"
    for row in range(2, 5000):
        sheet.cell(row, 1, row)
    buffer = io.BytesIO()
    made.save(buffer)
    with pytest.raises(ValueError, match="64 MiB"):
        sheet_texts(buffer.getvalue())


def test_a_negative_duration_keeps_its_size() -> None:
    duration = datetime.timedelta(minutes=-90)
    (sheet,) = sheet_texts(book(Log=[["t", "x"], [duration, 1.5]]))
    assert sheet.text.decode().splitlines()[-1].startswith("-1:30:00")
