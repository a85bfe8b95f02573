"""All exports of a campaign, as the contents of files: JSON, csv, ADORE, and one per language.

In the workbook constants are cells, so that every formula shows where its numbers come from and a
user can change them. Formulas are made from the law's expression, as those of the languages are.

The four constants of the ADORE bearing-dynamics code at single operating points are those of

    mu = (A + B u) exp(-C u) + D

with u = S U the slip velocity in m/s, 0 or more. A law that has this form over the slide-roll
ratio S says so (`Law.adore`); B and C are then divided by U. D is mu far beyond the peak, A is mu
at rest less D, and with the peak (u_m, mu_m) C = B/(A + B u_m).

Reference: P. K. Gupta, Advanced Dynamics of Rolling Elements, Springer, 1984.

Decides: which forms of exports there are.
"""

import datetime
import io
import json
import math
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from openpyxl import Workbook
from openpyxl.styles import Font, PatternFill
from openpyxl.workbook.properties import CalcProperties

from oilfilm.base import studies
from oilfilm.base.units import FloatArray
from oilfilm.exports.description import (
    KNOWN_WHERE_TESTED,
    NOT_MARKED,
    SLIP,
    SLIP_MEANING,
    Condition,
    Description,
    describe,
    identifiers,
    number_or_none,
    plain,
)
from oilfilm.exports.languages import FORTRAN, MATLAB, MODELICA, PYTHON, TEMPLATES, C
from oilfilm.fits.certificate_words import certificate
from oilfilm.report.spreadsheet import csv_text
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS, expression
from oilfilm.traction.expression import Form, Language

# ---------------------------------------------------------------- workbook

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


# ---------------------------------------------------------------- JSON and csv

UNITS = {"A": "1", "B": "s/m", "C": "s/m", "D": "1", "peak_slip_velocity": "m/s", "peak_mu": "1"}


def csv_table(description: Description) -> str:
    """One row per quantity, each with its oil and law: tables of several oils can be joined.

    `kind` is constant, reference (where every power is 1), level (the one level of a condition
    that gives no exponent), tested minimum or tested maximum.
    """
    constants = pd.DataFrame(description.constants)
    ends = pd.DataFrame(constants["interval"].tolist(), columns=["lower", "upper"])
    slip = replace(description.slip, name=f"|{SLIP}|", meaning=SLIP_MEANING)
    conditions = [row for condition in (*description.conditions, slip) for row in _rows(condition)]
    rows = pd.concat(
        [
            constants.join(ends).rename(columns={"name": "quantity"}).assign(kind="constant"),
            pd.DataFrame(conditions),
        ],
        ignore_index=True,
    )
    columns = """kind quantity value unit standard_error lower upper
        systematic_standard_error verdict meaning""".split()
    rows = rows[columns].fillna({"verdict": ""}).astype({"value": float})
    return csv_text(pd.DataFrame(description.identity, index=rows.index).join(rows))


def _rows(condition: Condition) -> Iterator[dict[str, Any]]:
    about = {"quantity": condition.name, "unit": condition.unit, "meaning": condition.meaning}
    if condition.reference is not None:
        yield {"kind": "reference", "value": condition.reference, **about}
    if condition.role == "fixed":
        yield {"kind": "level", "value": condition.level, **about}
    for kind, end in zip(("tested minimum", "tested maximum"), condition.tested, strict=True):
        yield {"kind": kind, "value": end, **about}


def json_text(
    description: Description,
    files: Mapping[str, str],
    not_written: Mapping[str, str],
    provenance: Mapping[str, Any],
) -> str:
    """The description as JSON; null where a number is not known.

    Args:
        description: The fit.
        files: Form -> file beside this one.
        not_written: Form -> why there is no such file.
        provenance: What the constants were made from, as digests.
    """
    law, campaign, quality = description.law, description.campaign, description.quality
    fixed_conditions = description.fitted.coefficients.fixed
    content = {
        "format": "oilfilm traction law",
        "format_version": 5,
        "oil": description.oil,
        "origin": description.origin,
        "campaign": campaign and {"name": campaign.name, "description": campaign.description},
        "data": description.data,
        "law": {
            "name": law.name,
            # operators and functions as in Python
            "mu_for_slip_of_0_or_more": law.equation,
            "parts_of_mu": dict(law.parts),
            "mu_for_slip_below_0": "-mu(-S)",
            "coefficients": description.power_law(description.conditions),
            # by coefficient; the law gives them, so they are no constants of the fit
            "known_exponents": {
                coefficient.name: list(coefficient.exponents)
                for coefficient in law.coefficients
                if coefficient.exponents is not None
            },
            "source": law.source,
        },
        "conditions": list(map(asdict, (*description.conditions, description.slip))),
        "limiting_stress_over_pressure": description.limit,
        "constants": list(description.constants),
        "not_sound": [*description.fitted.wrong],
        "fit": quality
        and {
            "certified": description.certified,
            "verdict": certificate(quality),
            "not_sound_because": list(description.fitted.wrong),
            "points": int(quality["n_points"]),
            "runs": int(quality["n_curves"]),
            "rms_error_of_mu": number_or_none(quality["rmse"]),
            "largest_error_of_mu": number_or_none(quality["max_error"]),
            "fixed_conditions": [asdict(fixed) for fixed in fixed_conditions],
        },
        "files": files,
        "not_written": not_written,
        "provenance": dict(provenance),
    }
    return json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


# ---------------------------------------------------------------- ADORE


def adore_csv(description: Description) -> str:
    """One row per operating point, with the units in the column names."""
    rows = pd.DataFrame(adore_rows(description))
    rows = rows.rename(columns={name: f"{name} [{unit}]" for name, unit in UNITS.items()})
    return csv_text(pd.DataFrame(description.identity, index=rows.index).join(rows))


def adore_rows(description: Description) -> list[dict[str, Any]]:
    """The constants at each requested operating point, in the units of `UNITS`.

    Conditions that the fit does not follow are given where they were tested; operating points that
    become the same are given once.
    """
    rows: list[dict[str, Any]] = []
    for point in description.adore_points:
        row = _row(description, point)
        if row not in rows:
            rows.append(row)
    return rows


def adore_obstacle(description: Description) -> str:
    """Why there are no such constants; empty where there are."""
    law = description.law
    if law.adore is None:
        return f"the law {law.name} has not the form mu = (A + B u) exp(-C u) + D"
    lacking = {
        name for point in description.adore_points for name in law.conditions if name not in point
    }
    if lacking:
        return f"the points of exports.adore_points lack {', '.join(sorted(lacking))}"
    return ""


def _row(description: Description, requested: Mapping[str, float]) -> dict[str, Any]:
    law = description.law
    fixed = {each.condition for each in description.fitted.coefficients.fixed}
    asked = [[np.nan if name in fixed else requested[name] for name in law.conditions]]
    conditions = description.fitted.on_line(np.array(asked))
    point = dict(zip(law.conditions, map(number_or_none, conditions[0]), strict=True))
    speed = point["entrainment_speed_m_s"]
    if speed is None:
        raise ValueError("the point has no entrainment speed")
    groups = law.group_values(conditions)[0]
    a, b, c, d = _form_at(description, groups)
    peak = 1 / c - a / b
    return {
        **point,
        "A": a,
        "B": b / speed,
        "C": c / speed,
        "D": d,
        "peak_slip_velocity": peak * speed,
        "peak_mu": (a + b * peak) * math.exp(-c * peak) + d,
        "outside_tested_box": description.outside(groups),
        "peak_above_limiting_stress": (a + b * peak) * math.exp(-c * peak) + d > description.limit,
        "peak_outside_tested_slip": peak > (description.slip.tested[1] or 0.0),
    }


def _form_at(description: Description, groups: FloatArray) -> tuple[float, ...]:
    """A, B, C and D over the slide-roll ratio."""
    law = description.law
    values = description.coefficients_at(groups)
    names = {name: expression.name(name) for name in values}
    form = [expression.parse(text, names) for text in law.adore or ()]
    return tuple(map(float, expression.compiled(list(names), form)(*values.values())))


class _Form(NamedTuple):
    """One form: its file, whom it is for, how it is used, and what writes it."""

    file: str
    users: str
    use: str
    write: Callable[[Description], str | bytes]


# These need all coefficients of the law.
FORMS = {
    "Python": _Form("traction_*.py", "Python", "import it; needs NumPy; arrays too", PYTHON.source),
    "spreadsheet": _Form("traction_*.xlsx", "Excel, LibreOffice", "type P, U, T and S", workbook),
    "C": _Form("traction_*.h", "C99, C++11", "include it; needs libm (`-lm`) only", C.source),
    "Fortran": _Form("traction_*.f90", "Fortran 2008", "compile it; arrays too", FORTRAN.source),
    "Modelica": _Form("Traction_*.mo", "Modelica", "load it; Pa, m/s, K", MODELICA.source),
    "MATLAB, Octave": _Form(
        "traction_coefficient_*.m", "MATLAB, GNU Octave", "put it on the path", MATLAB.source
    ),
    "ADORE": _Form("adore_*.csv", "ADORE", "A to D of (A + B u) exp(-C u) + D", adore_csv),
}


def export_campaign(
    results: CampaignTables, settings: Settings, provenance: Mapping[str, Any]
) -> dict[str, bytes]:
    """Every oil's fit in every form, and what the campaign's studies export beside them.

    Args:
        results: Tables `points`, `coefficients`, `fit_quality` and `soundness`.
        settings: `campaign`, `fit`, `exports` and `studies` of them.
        provenance: Digests of code, settings and inputs.

    Returns:
        File, relative to the folder of the exports -> its content. A form that cannot be
        written is named in the JSON file, with the reason.
    """
    law, quality = LAWS[settings.fit.law], results.fit_quality
    names = identifiers(quality.loc[quality["law"] == law.name, "oil"])
    fits = [describe(results, oil, name, law, settings) for oil, name in names.items()]
    sources = {key: provenance[key] for key in ("code", "settings", "inputs")}
    files: dict[str, bytes] = {}
    links = []
    for study in studies.load(settings.campaign.studies):
        if of_study := study.exports(names, settings, sources):
            files |= of_study
            links.append(f"\n{study.exported}\n")
    return in_folders(fits, sources, "".join(links)) | files


def in_folders(
    descriptions: Sequence[Description], provenance: Mapping[str, Any], below: str = ""
) -> dict[str, bytes]:
    """Several oils in every form, and the page that lists them: file -> its content.

    Args:
        descriptions: One per oil; its files are in a folder of its name.
        provenance: What they were made from, as digests.
        below: A line below the list.
    """
    files = {"README.md": _index(descriptions, below).encode()}
    for each in descriptions:
        contents = export(each, provenance).items()
        files |= {f"{each.identifier}/{file}": content for file, content in contents}
    return files


def export(fit: Description, provenance: Mapping[str, Any]) -> dict[str, bytes]:
    """One oil's constants in every form: file -> its content."""
    name = fit.identifier
    files, not_written = {"CSV": f"traction_{name}.csv"}, {}
    texts: dict[str, str | bytes] = {files["CSV"]: csv_table(fit)}
    for name_of_form, form in FORMS.items():
        obstacle = fit.obstacle or (adore_obstacle(fit) if name_of_form == "ADORE" else "")
        if obstacle:
            not_written[name_of_form] = obstacle
        else:
            files[name_of_form] = form.file.replace("*", name)
            texts[files[name_of_form]] = form.write(fit)
    texts[f"traction_{name}.json"] = json_text(fit, files, not_written, provenance)
    return {
        file: text if isinstance(text, bytes) else text.encode() for file, text in texts.items()
    }


def _index(fits: Sequence[Description], below: str) -> str:
    """The page that says which file is for whom, in Markdown."""
    return TEMPLATES.get_template("README.md.jinja").render(
        origins=dict.fromkeys(fit.origin for fit in fits),
        oils=[
            {"name": plain(fit.oil), "folder": fit.identifier, "certificate": fit.certificate}
            | {"depends": _depends(fit)}
            for fit in fits
        ],
        forms=FORMS.values(),
        below=below,
    )


def _depends(fit: Description) -> str:
    """What mu depends on, and where it is known."""
    if fit.obstacle:
        return "unknown"
    symbols = ", ".join([*(condition.symbol for condition in fit.arguments), "S"])
    return f"{symbols}; {fit.where_known}" if fit.where_known else symbols
