"""The law as a workbook with live formulas, for Excel and LibreOffice.

Constants are cells, so that every formula shows where its numbers come from and a user can change
them. Formulas are made from the law's expression, as those of the other languages are.
"""

import datetime
import io
import zipfile
from typing import Any

from openpyxl import Workbook
from openpyxl.chart import Reference, ScatterChart, Series
from openpyxl.styles import Font, PatternFill
from openpyxl.workbook.properties import CalcProperties

from oilfilm.exports.description import (
    KNOWN_WHERE_TESTED,
    NOT_MARKED,
    SLIP,
    SLIP_MEANING,
    Description,
    plain,
)
from oilfilm.report.spreadsheet import is_formula
from oilfilm.traction.expression import Form, Language, Node

# Spreadsheets lack two functions; both forms are without cancellation at small x.
_EXPM1 = "IF({0}>0.5,EXP({0})-1,2*TANH({0}/2)/(1-TANH({0}/2)))"
_LOG1P = "2*ATANH({0}/(2+{0}))"
_SAME = ("exp", "sqrt", "tanh", "asinh", "abs", "sign")
_FORMS = {name: Form(f"{name.upper()}({{}})") for name in _SAME} | {
    "log": Form("LN({})"),
    # a minus sign binds more strongly than a power there: -2^2 is 4
    "negative": Form("-{}", 1, (5,)),
    "**": Form("{}^{}", 4, (5, 5)),
    # the operand occurs several times, so it needs brackets of its own
    "expm1": Form(_EXPM1, 5, (5,)),
    "log1p": Form(_LOG1P, 5, (5,)),
}
# Rows of the curve; a slip of 0 and then steps up to the largest tested.
CURVE_STEPS = 30
_IMPOSSIBLE = "IMPOSSIBLE: above the limiting shear stress of the oil"
_EPOCH = datetime.datetime(1980, 1, 1)
_BOLD, _TITLE = Font(bold=True), Font(bold=True, size=14)
_GIVEN = PatternFill("solid", fgColor="FFF2CC")
_COLUMNS = "ABCDEFGH"


def workbook(description: Description) -> bytes:
    """A workbook of two sheets: mu at one operating point, and its curve over S.

    The same description gives the same bytes.
    """
    book = Workbook()
    book.properties.creator = "oilfilm"
    book.properties.title = f"Traction coefficient of the oil {plain(description.oil)}"
    book.properties.created = book.properties.modified = _EPOCH
    book.calculation = CalcProperties(fullCalcOnLoad=True)
    book.active.title = "mu"
    cells = _point(book.active, description)
    _curve(book.create_sheet("curve"), description, cells)
    for sheet in book:
        for letter, width in zip(_COLUMNS, (12, 18, *[16] * 6), strict=True):
            sheet.column_dimensions[letter].width = width
    return _fixed_bytes(book)


class _Formula(str):
    """Text of a formula, without its equals sign."""

    __slots__ = ()


def _add(sheet: Any, *values: Any, font: Font | None = None) -> int:
    """Write the next row; returns its number. Text that begins as a formula does not become one."""
    sheet.append([f"={value}" if isinstance(value, _Formula) else value for value in values])
    for cell, value in zip(sheet[sheet.max_row], values, strict=False):
        if isinstance(value, str) and not isinstance(value, _Formula) and is_formula(value):
            cell.data_type, cell.quotePrefix = "s", True
        if font:
            cell.font = font
    return int(sheet.max_row)


def _point(sheet: Any, description: Description) -> dict[str, str]:
    """The sheet of one operating point; returns the cell of each name in the law's steps."""
    _add(sheet, f"Traction coefficient of the oil {plain(description.oil)}", font=_TITLE)
    _add(sheet, description.origin, font=_BOLD)
    for line in (*description.fit_sentences, *description.law_sentences):
        _add(sheet, line)
    if description.where_known:
        _add(sheet, f"{KNOWN_WHERE_TESTED}: {description.where_known}")
    _add(sheet, None)
    _add(sheet, "Type numbers into the yellow cells", font=_BOLD)
    first = 1 + _add(
        sheet, "symbol", "value", "unit", "tested from", "to", "", "meaning", font=_BOLD
    )
    cells = {}
    last = description.slip.tested[1] or 0.0
    inputs = [(each, *each.tested, each.meaning) for each in description.arguments]
    slip = f"slide-roll ratio, {SLIP_MEANING}, either sign"
    for condition, lower, upper, meaning in (*inputs, (description.slip, -last, last, slip)):
        middle = None if lower is None or upper is None else (lower + upper) / 2
        start = (last or 0.1) / 6 if condition.name == SLIP else middle
        row = sheet.max_row + 1
        inside = f"AND(ISNUMBER(B{row}),B{row}>=D{row},B{row}<=E{row})"
        tested = _Formula(f'IF({inside},"tested","OUTSIDE")')
        _add(sheet, condition.symbol, start, condition.unit, lower, upper, tested, meaning)
        sheet.cell(row, 2).fill = _GIVEN
        cells[condition.name] = f"$B${row}"
    outside = f'COUNTIF(F{first}:F{sheet.max_row},"OUTSIDE")'
    _add(sheet, None)
    result = _add(sheet, "mu", None, "1", "traction force over load, of the sign of S", font=_TITLE)
    within = f'IF(ABS(B{result})>{description.limit!r},"{_IMPOSSIBLE}","inside the tested box")'
    beyond = '"EXTRAPOLATED: outside the tested box"'
    row = _add(sheet, "range", _Formula(f"IF({outside}=0,{within},{beyond})"))
    cells["range"] = f"$B${row}"
    _add(sheet, NOT_MARKED)
    _add(sheet, None)
    _add(sheet, "Constants (power law of each coefficient)", font=_BOLD)
    groups = [f"exponent of {condition.symbol}" for condition in description.conditions]
    _add(sheet, "", "at the reference", *groups, font=_BOLD)
    for name in description.law.local_constants:
        names = [f"{name}{number}" for number in range(len(groups) + 1)]
        row = _add(sheet, name, *(description.values[each] for each in names))
        cells |= {each: f"${_COLUMNS[at]}${row}" for at, each in enumerate(names, 1)}
    _add(sheet, None)
    _add(sheet, "Steps", font=_BOLD)
    for name, value in description.steps(named=True):
        row = _add(sheet, name, _Formula(_write(value, cells)))
        cells[name] = f"$B${row}"
    positive = ",".join(f"{cells[condition.name]}>0" for condition in description.arguments)
    mu = f"IF({cells[SLIP]}<0,-{cells['mu']},{cells['mu']})"
    sheet.cell(result, 2).value = f"=IF(AND({positive}),{mu},NA())" if positive else f"={mu}"
    sheet.cell(result, 2).number_format = "0.00000"
    return cells


def _curve(sheet: Any, description: Description, cells: dict[str, str]) -> None:
    """mu over S at the operating point of the first sheet, with a chart."""
    _add(sheet, "mu over S at the operating point of the sheet mu", font=_TITLE)
    _add(sheet, description.origin, font=_BOLD)
    _add(sheet, _Formula(f"mu!{cells['range']}"))
    along = [name for name, _ in description.law.steps]
    first = 1 + _add(sheet, "S", *along, font=_BOLD)
    values = dict(description.steps(named=True))
    last = description.slip.tested[1] or 0.3
    for step in range(CURVE_STEPS + 1):
        row = first + step
        here = {name: f"mu!{cell}" for name, cell in cells.items()}
        here |= {name: f"${_COLUMNS[at]}{row}" for at, name in enumerate(("S", *along))}
        formulas = [_Formula(_write(values[name], here)) for name in along]
        _add(sheet, last * step / CURVE_STEPS, *formulas)
    chart = ScatterChart()
    chart.title = f"{plain(description.oil)}, {description.law.name}, {description.data}"
    chart.style, chart.legend = 13, None
    chart.x_axis.title, chart.y_axis.title = "slide-roll ratio S", "traction coefficient mu"
    chart.x_axis.delete = chart.y_axis.delete = False
    slips, mu = (
        Reference(sheet, min_col=column, min_row=first, max_row=sheet.max_row)
        for column in (1, 1 + len(along))
    )
    chart.series.append(Series(mu, slips))
    sheet.add_chart(chart, f"{_COLUMNS[len(along) + 2]}4")


def _write(node: Node, cells: dict[str, str]) -> str:
    return Language(_FORMS, identifier=cells.__getitem__).write(node)


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
