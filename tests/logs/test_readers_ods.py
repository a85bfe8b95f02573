"""OpenDocument sheets are read as workbooks are, repeated cells and rows included, in bounds."""

from pathlib import Path

import numpy as np
import pytest

import formats
import oilfilm
from allocations import peak_bytes
from bad_logs import CONFIG
from oilfilm.logs.ingest import read_log
from oilfilm.logs.opendocument import sheet_lines, sheet_texts
from opendocument_files import cell, document, row, rows_of, spreadsheet

VALUES = formats.columns(30)
NAMES = [f"{name} ({formats.UNITS[name]})" for name in VALUES]
ROWS = np.column_stack(list(VALUES.values())).tolist()


def rows_of_log(rows: list[list[float]]) -> str:
    named = row(*map(cell, NAMES))
    return named + "".join(row(*map(cell, values), cell(times=1000)) for values in rows)


def lines_of(*rows: str) -> list[str]:
    ((_, lines),) = sheet_lines(spreadsheet(document(Sheet="".join(rows))))
    return lines


def test_numbers_and_header_of_a_sheet_are_those_of_a_text_log(read) -> None:
    rest_of_sheet = row(cell(times=16384), times=1_000_000)
    oil = row(cell("Oil"), cell("4102"))
    reading = read(spreadsheet(document(Log=oil + rows_of_log(ROWS) + rest_of_sheet)))
    (run,) = reading.runs
    assert (run.run_id, run.oil_name) == ("log", "4102")
    np.testing.assert_array_equal(run.samples["time_s"], VALUES["time"])
    np.testing.assert_allclose(run.samples["load_n"], VALUES["load"] * 9.80665, rtol=1e-12)
    assert reading.refusals == []


def test_each_sheet_with_columns_is_a_run_and_others_are_named(read) -> None:
    oil = row(cell("Oil"), cell("4102"))
    sheets = {
        "Cover": row(cell("Test"), cell("Day")) + row(cell("traction"), cell(3)),
        "first": oil + rows_of_log(ROWS[:10]),
        "second": oil + rows_of_log(ROWS[10:]),
    }
    reading = read(spreadsheet(document(**sheets)))
    assert [(run.run_id, len(run)) for run in reading.runs] == [
        ("log:first", 10),
        ("log:second", 20),
    ]
    (note,) = reading.refusals
    assert "'Cover'" in note.reason


def test_repeated_cells_and_rows_count_as_often_as_they_stand_for() -> None:
    assert lines_of(
        row(cell(1), cell(times=2), cell(2.5, times=3), cell(times=16000)),
        row(cell(times=16384), times=2),
        row(cell(7), times=2),
        row(cell(times=16384), times=1_048_570),
    ) == ["1\t\t\t2.5\t2.5\t2.5", "", "", "7", "7"]


def test_types_of_values() -> None:
    with_note = "<office:annotation><text:p>a note</text:p></office:annotation><text:p>b</text:p>"
    in_percent = cell(0.05, kind="percentage")
    assert lines_of(
        row(cell("slip [%]"), cell("slip [1]"), cell("start"), cell("duration")),
        row(
            in_percent,
            in_percent,
            cell("2026-03-01T10:15:00.25", kind="date", name="date-value"),
            cell("PT01H00M01.5S", kind="time", name="time-value"),
            f"<table:table-cell>{with_note}</table:table-cell>",
            "<table:table-cell><text:p>a <text:span>word</text:span></text:p></table:table-cell>",
        ),
    ) == [
        "slip [%]\tslip [1]\tstart\tduration",
        "5\t0.05\t2026-03-01 10:15:00.250\t1:00:01.500000\tb\ta word",
    ]


def test_column_in_percent_without_its_sign_holds_fractions() -> None:
    in_percent = cell(0.05, kind="percentage")
    rows = row(cell("load [N]"), cell("slip [%]"), cell("SRR")) + row(
        cell(20), in_percent, in_percent
    )
    (sheet,) = sheet_texts(spreadsheet(document(Sheet=rows)))
    assert sheet.fraction_columns == {2}


def test_percent_sign_in_a_note_changes_no_number() -> None:
    lines = lines_of(
        row(cell("humidity"), cell("45 %")),
        row(cell("load [N]"), cell("slip [1]")),
        row(cell(20), cell(0.0005, kind="percentage")),
    )
    assert lines[-1] == "20\t0.0005"


def test_day_that_is_shown_without_hours_is_a_date() -> None:
    shown = "<text:p>{}</text:p>"
    typed = (
        '<table:table-cell office:value-type="date" office:date-value="{}">{}</table:table-cell>'
    )
    day, midnight = "2026-03-01", "2026-03-01T00:00:00"
    assert lines_of(
        row(
            typed.format(day, shown.format("01.03.26")),
            typed.format(midnight, shown.format("01.03.26")),
            typed.format(day, shown.format("01.03.26 00:00:00")),
            typed.format(midnight, ""),
        )
    ) == ["2026-03-01\t2026-03-01\t2026-03-01 00:00:00.000\t2026-03-01 00:00:00.000"]


def test_time_of_day_passes_midnight_within_one_run(read) -> None:
    seconds = [(86_395 + index) % 86_400 for index in range(30)]
    rows = [
        row(cell(f"PT{s // 3600}H{s // 60 % 60}M{s % 60}S", kind="time", name="time-value"), *rest)
        for s, rest in zip(seconds, [list(map(cell, values[1:])) for values in ROWS], strict=True)
    ]
    above = row(cell("Oil"), cell("4102")) + row(*map(cell, ["Time [min]", *NAMES[1:]]))
    (run,) = read(spreadsheet(document(Log=above + "".join(rows)))).runs
    np.testing.assert_allclose(run.samples["time_s"], np.arange(30))


HOSTILE = {
    "a row beyond the last one": row(cell(1), times=2_000_000),
    "a row behind empty ones": row(cell(), times=10**12) + row(cell(1)),
    "a wide row": row(cell(1, times=10**12)),
    "wide rows": row(cell(1, times=1000), times=1_000_000),
    "empty cells in front": row(cell(times=10**12), cell(1)),
    "a long text": row(cell("x" * 1000), times=1_000_000),
}


@pytest.mark.parametrize("rows", HOSTILE.values(), ids=HOSTILE)
def test_small_file_that_would_fill_the_memory_is_refused(rows: str) -> None:
    content = spreadsheet(document(Sheet=rows))
    with peak_bytes() as peak:
        _, reading = read_log(content, "log", CONFIG)
    assert [refusal.rule for refusal in reading.refusals] == ["damaged_file"]
    assert peak() < 1 << 25


def test_entities_and_large_documents_are_refused() -> None:
    entity = '<!DOCTYPE x [<!ENTITY a "aaaa">]>'
    content = document(Sheet=row(cell(1))).replace(
        "<office:document", entity + "<office:document", 1
    )
    with pytest.raises(ValueError, match="entities"):
        sheet_texts(spreadsheet(content))
    large = document(Sheet=row(cell(1))) + " " * (65 << 20)
    with pytest.raises(ValueError, match="MiB"):
        sheet_texts(spreadsheet(large))


def test_table_of_mu_may_be_a_sheet(tmp_path: Path) -> None:
    rows = [
        [pressure, 10.0, celsius, slip, 0.05 * pressure * np.tanh(slip / 0.02) * 40 / celsius]
        for pressure in (1.0, 1.3)
        for celsius in (40.0, 80.0)
        for slip in (0.005, 0.02, 0.08, 0.2)
    ]
    named = [["p [GPa]", "U [m/s]", "T [degC]", "SRR", "mu"], *rows]
    path = tmp_path / "table.ods"
    path.write_bytes(spreadsheet(document(Cover=rows_of([["a test"]]), Data=rows_of(named))))
    fitted = oilfilm.fit_table(path, searches=2, bootstrap=20)
    read = sorted(fitted.points["traction_coefficient"])
    np.testing.assert_allclose(read, sorted(cells[-1] for cells in rows))
