"""The exported workbook: LibreOffice computes with its formulas what the law says."""

import io
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from openpyxl import Workbook, load_workbook

from campaigns import printed
from exported import HOSTILE, arguments_of, beyond, describe_law, expected, grid
from oilfilm.exports.campaign import workbook
from oilfilm.exports.description import Description
from oilfilm.settings.resolved import Settings
from oilfilm.traction.laws.deng2026 import traction_coefficient

# Of the grid of the other exports: within and far beyond the box, S of both signs and 0.
ROWS = grid().iloc[::61].reset_index(drop=True)


def first_column(sheet: Any) -> dict[str, int]:
    """Row of each text of the column A, the first where there are several."""
    rows: dict[str, int] = {}
    for row in range(1, sheet.max_row + 1):
        rows.setdefault(str(sheet.cell(row, 1).value), row)
    return rows


def typed(fit: Description, arguments: np.ndarray) -> Workbook:
    """The workbook with a copy of its first sheet for each row of numbers that a user types."""
    book = load_workbook(io.BytesIO(workbook(fit)))
    symbols = [*(condition.symbol for condition in fit.arguments), "S"]
    rows = first_column(book["mu"])
    for number, values in enumerate(arguments.tolist()):
        sheet = book.copy_worksheet(book["mu"]) if number else book["mu"]
        sheet.title = f"mu{number or ''}"
        for symbol, value in zip(symbols, values, strict=True):
            sheet.cell(rows[symbol], 2).value = value
    return book


def computed(books: dict[str, Workbook], folder: Path) -> dict[str, Workbook]:
    """The workbooks with the values that LibreOffice computes, all in one start of it."""
    office = shutil.which("soffice")
    if office is None:
        pytest.skip("soffice (LibreOffice Calc) is not on PATH (.ci/tools installs it)")
    files = []
    for name, book in books.items():
        files.append(folder / f"{name}.xlsx")
        book.save(files[-1])
    command = [office, "--headless", f"-env:UserInstallation=file://{folder}/profile"]
    command += ["--convert-to", "xlsx", "--outdir", str(folder / "computed"), *map(str, files)]
    subprocess.run(command, check=True, capture_output=True, timeout=300)
    return {
        name: load_workbook(folder / "computed" / f"{name}.xlsx", data_only=True) for name in books
    }


def values_beside(book: Workbook, text: str) -> list[Any]:
    """What is beside a text on each copy of the first sheet."""
    sheets = [sheet for sheet in book if sheet.title.startswith("mu")]
    return [sheet.cell(first_column(sheet)[text], 2).value for sheet in sheets]


# Of each function of a spreadsheet one law; the others are made of the same.
LAWS = ("deng2026", "wang-deng-critical-load", "eyring", "carreau", "tanh")
CASES = [*((law, None) for law in LAWS), ("carreau", 1)]


@pytest.fixture(scope="module")
def fits(config: Settings) -> dict[str, Description]:
    return {f"{law}-{left_out}": describe_law(config, law, left_out) for law, left_out in CASES}


@pytest.fixture(scope="module")
def by_libreoffice(
    fits: dict[str, Description], config: Settings, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, Workbook]:
    """Every law at every row, and one at a corner of its box and where it has no value."""
    books = {name: typed(fit, arguments_of(fit, ROWS)) for name, fit in fits.items()}
    at_ends = np.array([[1.5, 40.0, 120.0, -0.3], [1.2, 30.0, 0.0, 0.1]])
    books["ends"] = typed(fits["deng2026-None"], at_ends)
    return computed(books, tmp_path_factory.mktemp("workbooks"))


@pytest.mark.slow
@pytest.mark.parametrize("name", [f"{law}-{left_out}" for law, left_out in CASES])
def test_workbook_computes_the_law_and_says_where_it_extrapolates(
    name: str, fits: dict[str, Description], by_libreoffice: dict[str, Workbook]
) -> None:
    fit = fits[name]
    mu = values_beside(by_libreoffice[name], "mu")
    # 16 of 17 digits are kept in a cell
    np.testing.assert_allclose(mu, expected(fit, ROWS), rtol=1e-12, atol=1e-16)
    marked = [
        said.startswith(("EXTRAPOLATED", "IMPOSSIBLE"))
        for said in values_beside(by_libreoffice[name], "range")
    ]
    assert marked == beyond(fit, arguments_of(fit, ROWS), np.array(mu)).tolist()


@pytest.mark.slow
def test_workbook_computes_the_corner_of_the_box_and_says_where_there_is_no_value(
    by_libreoffice: dict[str, Workbook],
) -> None:
    book = by_libreoffice["ends"]
    corner, cold = values_beside(book, "mu")
    mu = -traction_coefficient(printed()["4050"], 1.5, 40.0, 120.0, 0.3)
    assert corner == pytest.approx(float(mu), rel=1e-12)
    assert cold == "#N/A"
    # the corner of the tested box belongs to it
    assert values_beside(book, "range")[0] == "inside the tested box"


def test_same_description_gives_the_same_bytes_at_another_time(
    fits: dict[str, Description], monkeypatch: pytest.MonkeyPatch
) -> None:
    fit = fits["deng2026-None"]
    before = workbook(fit)
    monkeypatch.setattr("time.time", lambda: 2e9)
    monkeypatch.setattr("openpyxl.workbook.properties.datetime", None, raising=False)
    assert workbook(fit) == before


def test_name_of_an_oil_becomes_no_formula(fits: dict[str, Description]) -> None:
    for oil in HOSTILE:
        fit = replace(fits["deng2026-None"], oil=oil)
        book = load_workbook(io.BytesIO(workbook(fit)))
        for sheet in book:
            for row in sheet.iter_rows(max_row=3):
                assert {cell.data_type for cell in row} <= {"s", "n"}
