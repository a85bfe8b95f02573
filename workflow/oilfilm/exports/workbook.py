"""The law as a workbook with live formulas, for Excel and LibreOffice.

Constants are cells, so that every formula shows where its numbers come from and a user can change
them. Formulas are made from the law's expression, as those of the other languages are.
"""

import datetime
import io
import zipfile
from collections.abc import Iterable, Sequence
from typing import Any

from openpyxl import Workbook
from openpyxl.chart import Reference, ScatterChart, Series
from openpyxl.formatting.rule import FormulaRule
from openpyxl.styles import Alignment, Font, PatternFill
from openpyxl.workbook.properties import CalcProperties
from openpyxl.worksheet.datavalidation import DataValidation
from openpyxl.worksheet.properties import PageSetupProperties

from oilfilm.exports.description import SLIP, SLIP_MEANING, Description
from oilfilm.exports.header import KNOWN_WHERE_TESTED, fit_sentences, law_sentences, origin
from oilfilm.exports.names import plain
from oilfilm.report.spreadsheet import is_formula
from oilfilm.traction.expression import Form, Language, Node

# Spreadsheets lack two functions; both forms are without cancellation at small x.
_EXPM1 = "IF({0}>0.5,EXP({0})-1,2*TANH({0}/2)/(1-TANH({0}/2)))"
_LOG1P = "2*ATANH({0}/(2+{0}))"
_FORMS = {
    "+": Form("{}+{}", 1, (1, 2)),
    "-": Form("{}-{}", 1, (1, 2)),
    # a minus sign binds more strongly than a power there: -2^2 is 4
    "negative": Form("-{}", 1, (5,)),
    "*": Form("{}*{}", 2, (2, 3)),
    "/": Form("{}/{}", 2, (2, 3)),
    "**": Form("{}^{}", 4, (5, 5)),
    "exp": Form("EXP({})"),
    # the operand occurs several times, so it needs brackets of its own
    "expm1": Form(_EXPM1, 5, (5,)),
    "log": Form("LN({})"),
    "log1p": Form(_LOG1P, 5, (5,)),
    "sqrt": Form("SQRT({})"),
    "tanh": Form("TANH({})"),
    "asinh": Form("ASINH({})"),
    "abs": Form("ABS({})"),
    "sign": Form("SIGN({})"),
}
# Rows of the curve; a slip of 0 and then steps up to the largest tested.
CURVE_STEPS = 30
_EPOCH = datetime.datetime(1980, 1, 1)
_BOLD, _TITLE = Font(bold=True), Font(bold=True, size=14)
_GIVEN = PatternFill("solid", fgColor="FFF2CC")
_WARNING = PatternFill("solid", fgColor="F8CBAD")
_NOT_FINITE = "NA()"


def workbook(description: Description) -> bytes:
    """A workbook of three sheets: mu at one point, its curve over S, and every constant.

    The same description gives the same bytes.
    """
    book = Workbook()
    book.properties.creator = "oilfilm"
    book.properties.title = f"Traction coefficient of the oil {plain(description.oil)}"
    book.properties.created = book.properties.modified = _EPOCH
    book.calculation = CalcProperties(fullCalcOnLoad=True)
    point = book.active
    point.title = "mu"
    cells = _point(point, description)
    _curve(book.create_sheet("curve"), description, cells)
    _constants(book.create_sheet("constants"), description)
    return _fixed_bytes(book)


class _Rows:
    """Writes a sheet row by row."""

    def __init__(self, sheet: Any) -> None:
        self.sheet, self.row = sheet, 0

    def add(self, *values: Any, font: Font | None = None) -> int:
        """Write a row; returns its number. Text that begins as a formula does not become one."""
        self.row += 1
        for column, value in enumerate(values, 1):
            cell = self.sheet.cell(self.row, column)
            if isinstance(value, _Formula):
                cell.value = f"={value}"
            elif value is not None:
                cell.value = value
                if isinstance(value, str) and is_formula(value):
                    cell.data_type, cell.quotePrefix = "s", True
            if font:
                cell.font = font
            # heads are above numbers, units beside them
            cell.alignment = Alignment(
                horizontal="center" if column > 1 and isinstance(value, str) else None
            )
        return self.row

    def skip(self) -> None:
        """Leave a row empty."""
        self.row += 1


class _Formula(str):
    """Text of a formula, without its equals sign."""

    __slots__ = ()


def _point(sheet: Any, description: Description) -> dict[str, str]:
    """The sheet of one operating point; returns the cell of each name in the law's steps."""
    rows = _Rows(sheet)
    rows.add(f"Traction coefficient of the oil {plain(description.oil)}", font=_TITLE)
    rows.add(origin(description), font=_BOLD)
    for line in (*fit_sentences(description), *law_sentences(description)):
        rows.add(line)
    if description.where_known:
        rows.add(f"{KNOWN_WHERE_TESTED}: {description.where_known}")
    cells, first = _inputs(rows, description)
    rows.skip()
    result = rows.add("mu", None, "1", font=_TITLE)
    _label(sheet, result, "traction force over load, of the sign of S")
    warning = f'COUNTIF(F{first}:F{result - 2},"OUTSIDE")'
    rows.add(
        "range",
        _Formula(f'IF({warning}=0,"inside the tested box","EXTRAPOLATED: outside the tested box")'),
    )
    sheet.conditional_formatting.add(
        f"A{first}:G{rows.row}", FormulaRule(formula=[f'$F{first}="OUTSIDE"'], fill=_WARNING)
    )
    sheet.conditional_formatting.add(
        f"B{rows.row}", FormulaRule(formula=[f"{warning}>0"], fill=_WARNING)
    )
    rows.skip()
    rows.add("Constants (power law of each coefficient)", font=_BOLD)
    groups = [f"exponent of {condition.symbol}" for condition in description.conditions]
    rows.add("", "at the reference", *groups, font=_BOLD)
    values = description.values
    for name in description.law.local_constants:
        names = [f"{name}{number}" for number in range(len(groups) + 1)]
        row = rows.add(name, *(values[each] for each in names))
        cells |= {each: f"${'BCDEFGH'[column]}${row}" for column, each in enumerate(names)}
    rows.skip()
    rows.add("Steps", font=_BOLD)
    for name, value in description.steps_of_named_constants:
        row = rows.add(name, _Formula(_write(value, cells)))
        cells[name] = f"$B${row}"
    positive = ",".join(f"{cells[condition.name]}>0" for condition in description.arguments)
    signed = f"IF({cells[SLIP]}<0,-{cells['mu']},{cells['mu']})"
    mu = f"IF(AND({positive}),{signed},{_NOT_FINITE})" if positive else signed
    sheet.cell(result, 2).value, sheet.cell(result, 2).number_format = f"={mu}", "0.00000"
    _widths(sheet, (12, 18, 16, 16, 16, 12, 50))
    return cells


def _inputs(rows: _Rows, description: Description) -> tuple[dict[str, str], int]:
    """The cells that a user fills in, by the argument's name; and the first of their rows."""
    sheet = rows.sheet
    rows.skip()
    rows.add("Type the yellow cells", font=_BOLD)
    rows.add("symbol", "value", "unit", "tested from", "to", "", "meaning", font=_BOLD)
    cells: dict[str, str] = {}
    inputs = []
    for condition in description.arguments:
        lower, upper = condition.tested
        middle = None if lower is None or upper is None else (lower + upper) / 2
        row = rows.add(condition.symbol, middle, condition.unit, lower, upper)
        _label(sheet, row, condition.meaning)
        inputs.append(row)
        cells[condition.name] = f"$B${row}"
    last = description.slip.tested[1]
    row = rows.add("S", (last or 0.1) / 6, "1", -(last or 0.0), last)
    _label(sheet, row, f"slide-roll ratio, {SLIP_MEANING}, either sign")
    cells[SLIP] = f"$B${row}"
    for each in (*inputs, row):
        sheet.cell(each, 2).fill = _GIVEN
        inside = f"AND(ISNUMBER(B{each}),B{each}>=D{each},B{each}<=E{each})"
        sheet.cell(each, 6).value = f'=IF({inside},"tested","OUTSIDE")'
    _refuse_text(sheet, [f"B{each}" for each in inputs], "above 0", "greaterThan", "0")
    _refuse_text(sheet, [f"B{row}"], "of either sign", "between", "-2", "2")
    return cells, (*inputs, row)[0]


def _curve(sheet: Any, description: Description, cells: dict[str, str]) -> None:
    """mu over S at the operating point of the first sheet, with a chart."""
    rows = _Rows(sheet)
    rows.add("mu over S at the operating point of the sheet mu", font=_TITLE)
    rows.add(origin(description), font=_BOLD)
    rows.skip()
    elsewhere = {name: f"mu!{cell}" for name, cell in cells.items()}
    along = [name for name, _ in description.law.steps]
    rows.add("S", *along, font=_BOLD)
    first = rows.row + 1
    columns = dict(zip(("S", *along), "ABCDEFGH", strict=False))
    values = dict(description.steps_of_named_constants)
    last = description.slip.tested[1] or 0.3
    for step in range(CURVE_STEPS + 1):
        row = rows.row + 1
        here = elsewhere | {name: f"${column}{row}" for name, column in columns.items()}
        rows.add(last * step / CURVE_STEPS, *(_Formula(_write(values[n], here)) for n in along))
        for column in range(2, len(along) + 2):
            sheet.cell(row, column).number_format = "0.00000"
    chart = ScatterChart()
    chart.title = f"{plain(description.oil)}, {description.law.name}, {description.data}"
    chart.style, chart.legend = 13, None
    chart.x_axis.title, chart.y_axis.title = "slide-roll ratio S", "traction coefficient mu"
    chart.x_axis.delete = chart.y_axis.delete = False
    slips = Reference(sheet, min_col=1, min_row=first, max_row=rows.row)
    mu = Reference(sheet, min_col=1 + len(along), min_row=first, max_row=rows.row)
    chart.series.append(Series(mu, slips))
    sheet.add_chart(chart, f"{'ABCDEFGH'[len(along) + 2]}4")
    _widths(sheet, (12, *[14] * len(along)))


def _constants(sheet: Any, description: Description) -> None:
    """Every constant with its errors and verdict, as in the CSV file."""
    rows = _Rows(sheet)
    rows.add("Constants with their errors; the formulas use those of the sheet mu", font=_TITLE)
    rows.add(origin(description), font=_BOLD)
    rows.skip()
    head = (
        "name",
        "value",
        "unit",
        "standard error",
        "interval from",
        "interval to",
        "verdict",
        "meaning",
    )
    rows.add(*head, font=_BOLD)
    for each in description.constants:
        rows.add(
            *(each["name"], each["value"], each["unit"], each["standard_error"]),
            *each["interval"],
            *(each["verdict"], each["meaning"]),
        )
    _widths(sheet, (12, 18, 8, 16, 16, 16, 24, 60))


def _write(node: Node, cells: dict[str, str]) -> str:
    return Language(_FORMS, identifier=cells.__getitem__).write(node)


def _label(sheet: Any, row: int, text: str) -> None:
    sheet.cell(row, 7).value = text


def _refuse_text(
    sheet: Any, cells: Iterable[str], range_text: str, operator: str, *ends: str
) -> None:
    """Refuse anything but numbers of a range in some cells."""
    rule = DataValidation("decimal", operator=operator, formula1=ends[0], showErrorMessage=True)
    if len(ends) > 1:
        rule.formula2 = ends[1]
    rule.error = f"Type a number {range_text}, without its unit."
    rule.errorTitle = "Not a number in the unit beside it"
    for cell in cells:
        rule.add(cell)
    if rule.sqref:
        sheet.add_data_validation(rule)


def _widths(sheet: Any, widths: Sequence[int]) -> None:
    """Widths of the columns; printed, the sheet is one page wide."""
    sheet.page_setup.orientation, sheet.page_setup.fitToHeight = "landscape", 1
    sheet.sheet_properties.pageSetUpPr = PageSetupProperties(fitToPage=True)
    for letter, width in zip("ABCDEFGH", widths, strict=False):
        sheet.column_dimensions[letter].width = width


def _fixed_bytes(book: Workbook) -> bytes:
    """The workbook without the clock, and uncompressed: another zlib gives other bytes."""
    written, fixed = io.BytesIO(), io.BytesIO()
    book.save(written)
    with zipfile.ZipFile(written) as source, zipfile.ZipFile(fixed, "w") as target:
        for name in source.namelist():
            content = source.read(name)
            if name == "docProps/core.xml":
                now = book.properties.modified.strftime("%Y-%m-%dT%H:%M:%SZ")
                content = content.replace(now.encode(), _EPOCH.strftime("%Y-%m-%dT%XZ").encode())
            target.writestr(zipfile.ZipInfo(name, _EPOCH.timetuple()[:6]), content)
    return fixed.getvalue()
