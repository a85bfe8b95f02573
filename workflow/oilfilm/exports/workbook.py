"""The law as a workbook with live formulas, for Excel and LibreOffice.

Constants are cells, so that every formula shows where its numbers come from and a user can change
them. Formulas are made from the law's expression, as those of the other languages are.
"""

import datetime
import io
import zipfile
from typing import Any

from openpyxl import Workbook
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
from oilfilm.traction.expression import Form, Language

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
_IMPOSSIBLE = "IMPOSSIBLE: above the limiting shear stress of the oil"
_EPOCH = datetime.datetime(1980, 1, 1)
_BOLD, _TITLE = Font(bold=True), Font(bold=True, size=14)
_GIVEN = PatternFill("solid", fgColor="FFF2CC")
_COLUMNS = "ABCDEFGH"


def workbook(description: Description) -> bytes:
    """A workbook that computes mu at one operating point.

    The same description gives the same bytes.
    """
    book = Workbook()
    book.properties.creator = "oilfilm"
    book.properties.title = f"Traction coefficient of the oil {plain(description.oil)}"
    book.properties.created = book.properties.modified = _EPOCH
    book.calculation = CalcProperties(fullCalcOnLoad=True)
    book.active.title = "mu"
    _fill(book.active, description)
    for letter, width in zip(_COLUMNS, (12, 18, *[16] * 6), strict=True):
        book.active.column_dimensions[letter].width = width
    return _fixed_bytes(book)


def _add(sheet: Any, *values: Any, font: Font | None = None) -> int:
    """Write the next row; returns its number. A text that begins with "=" is a formula."""
    sheet.append(values)
    for cell in sheet[sheet.max_row] if font else ():
        cell.font = font
    return int(sheet.max_row)


def _fill(sheet: Any, description: Description) -> None:
    """Write what is known of the fit, cells for the operating point, constants and formulas.

    No text begins with a name or sentence of the campaign, which could be a formula.
    """
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
        tested = f'=IF({inside},"tested","OUTSIDE")'
        _add(sheet, condition.symbol, start, condition.unit, lower, upper, tested, meaning)
        sheet.cell(row, 2).fill = _GIVEN
        cells[condition.name] = f"$B${row}"
    outside = f'COUNTIF(F{first}:F{sheet.max_row},"OUTSIDE")'
    _add(sheet, None)
    result = _add(sheet, "mu", None, "1", "traction force over load, of the sign of S", font=_TITLE)
    within = f'IF(ABS(B{result})>{description.limit!r},"{_IMPOSSIBLE}","inside the tested box")'
    beyond = '"EXTRAPOLATED: outside the tested box"'
    _add(sheet, "range", f"=IF({outside}=0,{within},{beyond})")
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
        formula = f"={Language(_FORMS, identifier=cells.__getitem__).write(value)}"
        cells[name] = f"$B${_add(sheet, name, formula)}"
    positive = ",".join(f"{cells[condition.name]}>0" for condition in description.arguments)
    mu = f"IF({cells[SLIP]}<0,-{cells['mu']},{cells['mu']})"
    sheet.cell(result, 2).value = f"=IF(AND({positive}),{mu},NA())" if positive else f"={mu}"
    sheet.cell(result, 2).number_format = "0.00000"


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
