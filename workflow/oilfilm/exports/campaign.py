"""All exports of a campaign, as the contents of files: JSON, csv, ADORE, and one per language.

In the workbook, constants are cells: a formula refers to them, and a user can change them. Formulas
are made from the law's expression, as the functions in other languages are.

The four constants of the ADORE bearing-dynamics code at single operating points are those of

    mu = (A + B u) exp(-C u) + D

with u = S U the slip velocity in m/s, 0 or more. `Law.adore` has this form over the slide-roll
ratio S, for the laws that have it; B and C are then divided by U. D is mu far beyond the peak, A is
mu at rest less D, and with the peak (u_m, mu_m) C = B/(A + B u_m).

Reference: P. K. Gupta, Advanced Dynamics of Rolling Elements, Springer, 1984.

Decides: which forms of exports there are.
"""

import datetime
import io
import json
import math
import zipfile
from collections.abc import Callable, Mapping, Sequence
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
    Description,
    LawVariable,
    describe,
    exponent_meaning,
    make_identifiers,
    number_or_none,
    plain_text,
)
from oilfilm.exports.languages import (
    C_LANGUAGE,
    FORTRAN,
    MATLAB,
    MODELICA,
    PYTHON,
    TEMPLATE_ENVIRONMENT,
)
from oilfilm.fits.certificate_sentences import certificate_sentence
from oilfilm.report.spreadsheet import csv_text
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS, expression
from oilfilm.traction.expression import Form, Language

# ---------------------------------------------------------------- workbook

# Spreadsheets lack expm1 and log1p. These forms lose no digits by cancellation at small x.
_EXPM1 = "IF({0}>0.5,EXP({0})-1,2*TANH({0}/2)/(1-TANH({0}/2)))"
_LOG1P = "2*ATANH({0}/(2+{0}))"
_FUNCTIONS_OF_SAME_NAME = ("exp", "sqrt", "tanh", "asinh", "abs", "sign")
_SPREADSHEET_FORMS = {name: Form(f"{name.upper()}({{}})") for name in _FUNCTIONS_OF_SAME_NAME} | {
    "log": Form("LN({})"),
    # a minus sign binds more strongly than a power there: -2^2 is 4
    "negative": Form("-{}", 1, (5,)),
    "**": Form("{}^{}", 4, (5, 5)),
    # the operand occurs several times, so it needs brackets of its own
    "expm1": Form(_EXPM1, 5, (5,)),
    # a product
    "log1p": Form(_LOG1P, 2, (5,)),
}
_ABOVE_LIMIT_TEXT = "IMPOSSIBLE: above the limiting shear stress of the oil"
_FIXED_TIME = datetime.datetime(1980, 1, 1)  # in place of the clock
_TIME_FORMAT = "%Y-%m-%dT%H:%M:%SZ"
_BOLD_FONT = Font(bold=True)
_TITLE_FONT = Font(bold=True, size=14)
_INPUT_COLOUR = PatternFill("solid", fgColor="FFF2CC")
_COLUMN_LETTERS = "ABCDEFGH"
_COLUMN_WIDTHS = (12, 18, 16, 16, 16, 16, 16, 16)  # in characters


def workbook(description: Description) -> bytes:
    """A workbook that computes mu at one operating point.

    The same description gives the same bytes.
    """
    book = Workbook()
    book.properties.creator = "oilfilm"
    book.properties.title = f"Traction coefficient of the oil {plain_text(description.oil)}"
    book.properties.created = _FIXED_TIME
    book.properties.modified = _FIXED_TIME
    book.calculation = CalcProperties(fullCalcOnLoad=True)
    book.active.title = "mu"
    _fill_sheet(book.active, description)
    for letter, width in zip(_COLUMN_LETTERS, _COLUMN_WIDTHS, strict=True):
        book.active.column_dimensions[letter].width = width
    return _reproducible_bytes(book)


def _add_row(sheet: Any, *values: Any, font: Font | None = None) -> int:
    """Write the next row. A text that begins with "=" is a formula.

    Returns:
        Number of the row.
    """
    sheet.append(values)
    if font is not None:
        for cell in sheet[sheet.max_row]:
            cell.font = font
    return int(sheet.max_row)


def _fill_sheet(sheet: Any, description: Description) -> None:
    """Write a head, cells for the operating point, mu, the constants and the steps to mu.

    No text begins with a name or sentence of the campaign, because it could be a formula.
    """
    _add_head(sheet, description)
    cell_of_name, outside_count_formula = _add_inputs(sheet, description)
    _add_row(sheet, None)
    mu_row = _add_row(
        sheet, "mu", None, "1", "traction force over load, of the sign of S", font=_TITLE_FONT
    )
    inside_formula = (
        f'IF(ABS(B{mu_row})>{description.limiting_stress_ratio!r},"{_ABOVE_LIMIT_TEXT}",'
        '"inside the tested box")'
    )
    outside_formula = '"EXTRAPOLATED: outside the tested box"'
    _add_row(sheet, "range", f"=IF({outside_count_formula}=0,{inside_formula},{outside_formula})")
    _add_row(sheet, NOT_MARKED)
    _add_row(sheet, None)
    cell_of_name |= _add_constants(sheet, description)
    _add_row(sheet, None)
    _add_row(sheet, "Steps", font=_BOLD_FONT)
    spreadsheet_language = Language(_SPREADSHEET_FORMS, write_name=lambda name: cell_of_name[name])
    for name, expression_of_step in description.steps(constants_by_name=True):
        step_row = _add_row(sheet, name, f"={spreadsheet_language.write(expression_of_step)}")
        cell_of_name[name] = f"$B${step_row}"
    mu_size_cell = cell_of_name["mu"]
    mu_formula = f"IF({cell_of_name[SLIP]}<0,-{mu_size_cell},{mu_size_cell})"
    positivity_formulas = [
        f"{cell_of_name[argument.name]}>0" for argument in description.power_arguments
    ]
    if positivity_formulas:
        mu_formula = f"IF(AND({','.join(positivity_formulas)}),{mu_formula},NA())"
    sheet.cell(mu_row, 2).value = f"={mu_formula}"
    sheet.cell(mu_row, 2).number_format = "0.00000"


def _add_head(sheet: Any, description: Description) -> None:
    """Write the oil, the origin of the constants, the quality of the fit and the law."""
    _add_row(
        sheet, f"Traction coefficient of the oil {plain_text(description.oil)}", font=_TITLE_FONT
    )
    _add_row(sheet, description.origin, font=_BOLD_FONT)
    for line in (*description.fit_sentences, *description.law_sentences):
        _add_row(sheet, line)
    if description.where_known:
        _add_row(sheet, f"{KNOWN_WHERE_TESTED}: {description.where_known}")
    _add_row(sheet, None)


def _add_inputs(sheet: Any, description: Description) -> tuple[dict[str, str], str]:
    """Write one row per argument: a cell for its value, its tested range, whether it is inside.

    Returns:
        The cell of each argument by name, and a formula for the number of arguments outside.
    """
    _add_row(sheet, "Type numbers into the yellow cells", font=_BOLD_FONT)
    headings = ("symbol", "value", "unit", "tested from", "to", "", "meaning")
    heading_row = _add_row(sheet, *headings, font=_BOLD_FONT)
    cell_of_name = {}
    for argument in (*description.arguments, description.slip_variable):
        lower, upper = argument.tested
        meaning = argument.meaning
        # a first value that the user replaces: the middle of the range, and a small slip
        first_value = None if lower is None or upper is None else (lower + upper) / 2
        if argument.name == SLIP:
            largest_slip = upper or 0.0
            lower = -largest_slip
            upper = largest_slip
            meaning = f"slide-roll ratio, {SLIP_MEANING}, either sign"
            first_value = (largest_slip or 0.1) / 6
        row = sheet.max_row + 1
        inside_formula = f"AND(ISNUMBER(B{row}),B{row}>=D{row},B{row}<=E{row})"
        tested_formula = f'=IF({inside_formula},"tested","OUTSIDE")'
        _add_row(
            sheet,
            argument.symbol,
            first_value,
            argument.unit,
            lower,
            upper,
            tested_formula,
            meaning,
        )
        sheet.cell(row, 2).fill = _INPUT_COLOUR
        cell_of_name[argument.name] = f"$B${row}"
    return cell_of_name, f'COUNTIF(F{heading_row + 1}:F{sheet.max_row},"OUTSIDE")'


def _add_constants(sheet: Any, description: Description) -> dict[str, str]:
    """Write one row of constants per coefficient of the law.

    Returns:
        The cell of each constant by name.
    """
    _add_row(sheet, "Constants (power law of each coefficient)", font=_BOLD_FONT)
    law = description.law
    exponents = [exponent_meaning(law, group) for group in law.groups]
    _add_row(sheet, "", "at the reference", *exponents, font=_BOLD_FONT)
    cell_of_name = {}
    for coefficient in law.coefficient_names:
        names = [f"{coefficient}{number}" for number in range(len(exponents) + 1)]
        row = _add_row(sheet, coefficient, *(description.value_by_constant[name] for name in names))
        # column A has the name of the coefficient
        for column, name in zip(_COLUMN_LETTERS[1:], names, strict=False):
            cell_of_name[name] = f"${column}${row}"
    return cell_of_name


def _reproducible_bytes(book: Workbook) -> bytes:
    """The workbook without the clock, and uncompressed: another zlib gives other bytes."""
    saved_file = io.BytesIO()
    fixed_file = io.BytesIO()
    book.save(saved_file)
    # openpyxl sets the time of the last change when it saves
    saved_time = book.properties.modified.strftime(_TIME_FORMAT).encode()
    fixed_time = _FIXED_TIME.strftime(_TIME_FORMAT).encode()
    with zipfile.ZipFile(saved_file) as source, zipfile.ZipFile(fixed_file, "w") as target:
        for name in source.namelist():
            content = source.read(name)
            if name == "docProps/core.xml":
                content = content.replace(saved_time, fixed_time)
            target.writestr(zipfile.ZipInfo(name, _FIXED_TIME.timetuple()[:6]), content)
    return fixed_file.getvalue()


# ---------------------------------------------------------------- JSON and csv

_CSV_COLUMNS = [
    "kind",
    "quantity",
    "value",
    "unit",
    "standard_error",
    "lower",
    "upper",
    "systematic_standard_error",
    "verdict",
    "meaning",
]


def constants_csv(description: Description) -> str:
    """The csv file: one row per quantity, with oil and law, so that files of oils can be joined.

    `kind` is constant, reference (where every power is 1), level (the one level of a condition
    that gives no exponent), tested minimum or tested maximum.
    """
    constants = pd.DataFrame(description.constants_as_json)
    intervals = pd.DataFrame(constants["interval"].tolist(), columns=["lower", "upper"])
    constants = constants.join(intervals).rename(columns={"name": "quantity"})
    constants = constants.assign(kind="constant")
    slip = replace(description.slip_variable, name=f"|{SLIP}|", meaning=SLIP_MEANING)
    variable_rows: list[dict[str, Any]] = []
    for variable in (*description.law_variables, slip):
        variable_rows += _rows_of_variable(variable)
    rows = pd.concat([constants, pd.DataFrame(variable_rows)], ignore_index=True)
    rows = rows[_CSV_COLUMNS].fillna({"verdict": ""}).astype({"value": float})
    return csv_text(pd.DataFrame(description.csv_identity, index=rows.index).join(rows))


def _rows_of_variable(variable: LawVariable) -> list[dict[str, Any]]:
    """Rows of the csv table for one variable of the law: its reference, level and tested range."""
    lowest, highest = variable.tested
    value_of_kind: dict[str, float | None] = {}
    if variable.reference is not None:
        value_of_kind["reference"] = variable.reference
    if variable.role == "fixed":
        value_of_kind["level"] = variable.level
    value_of_kind["tested minimum"] = lowest
    value_of_kind["tested maximum"] = highest
    return [
        {
            "kind": kind,
            "quantity": variable.name,
            "value": value,
            "unit": variable.unit,
            "meaning": variable.meaning,
        }
        for kind, value in value_of_kind.items()
    ]


def json_text(
    description: Description,
    file_of_form: Mapping[str, str],
    obstacle_of_form: Mapping[str, str],
    provenance: Mapping[str, Any],
) -> str:
    """The text of the JSON file; null where a number is not known.

    Args:
        description: The fit.
        file_of_form: Name of the file of each form, beside this one.
        obstacle_of_form: Why a form has no file, by form.
        provenance: Digests of what the constants were made from.
    """
    law = description.law
    campaign = description.campaign
    campaign_as_json = None
    if campaign is not None:
        campaign_as_json = {"name": campaign.name, "description": campaign.description}
    content = {
        "format": "oilfilm traction law",
        "format_version": 6,
        "oil": description.oil,
        "origin": description.origin,
        "campaign": campaign_as_json,
        "data": description.kind_of_data,
        "law": {
            "name": law.name,
            # operators and functions as in Python
            "mu_for_slip_of_0_or_more": law.equation,
            "parts_of_mu": dict(law.parts),
            "mu_for_slip_below_0": "-mu(-S)",
            "coefficients": description.power_law(description.law_variables),
            # conditions g that enter as exp(X (g/reference - 1)) in place of (g/reference)^X
            "exponential": list(law.exponential),
            # by coefficient; the law gives them, so they are no constants of the fit
            "known_exponents": {
                coefficient.name: list(coefficient.exponents)
                for coefficient in law.coefficients
                if coefficient.exponents is not None
            },
            "source": law.source,
        },
        "conditions": [
            asdict(variable) for variable in (*description.law_variables, description.slip_variable)
        ],
        "limiting_stress_over_pressure": description.limiting_stress_ratio,
        "constants": list(description.constants_as_json),
        "not_sound": list(description.law_with_constants.warnings),
        "fit": _fit_as_json(description),
        "files": file_of_form,
        "not_written": obstacle_of_form,
        "provenance": dict(provenance),
    }
    return json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _fit_as_json(description: Description) -> dict[str, Any] | None:
    """Quality of the fit; None for printed constants."""
    quality = description.quality
    if quality is None:
        return None
    misfit, run_scatter = description.misfit_and_scatter
    return {
        "certified": description.is_certified,
        "verdict": certificate_sentence(quality),
        "not_sound_because": list(description.law_with_constants.warnings),
        "points": int(quality["n_points"]),
        "runs": int(quality["n_curves"]),
        "rms_error_of_mu": number_or_none(quality["rmse"]),
        "largest_error_of_mu": number_or_none(quality["max_error"]),
        "misfit_of_law_relative": number_or_none(misfit),
        "scatter_of_runs_relative": number_or_none(run_scatter),
        "fixed_conditions": [
            asdict(fixed) for fixed in description.law_with_constants.coefficients.fixed_conditions
        ],
    }


# ---------------------------------------------------------------- ADORE

_ADORE_UNITS = {
    "A": "1",
    "B": "s/m",
    "C": "s/m",
    "D": "1",
    "peak_slip_velocity": "m/s",
    "peak_mu": "1",
}


def adore_csv(description: Description) -> str:
    """The ADORE file: one row per operating point, with the units in the column names."""
    rows = pd.DataFrame(adore_rows(description))
    rows = rows.rename(columns={name: f"{name} [{unit}]" for name, unit in _ADORE_UNITS.items()})
    return csv_text(pd.DataFrame(description.csv_identity, index=rows.index).join(rows))


def adore_rows(description: Description) -> list[dict[str, Any]]:
    """The ADORE constants at each requested operating point, in the units of `_ADORE_UNITS`.

    Conditions on which the fit does not depend have their tested level. Operating points that are
    then the same occur once.
    """
    rows: list[dict[str, Any]] = []
    for point in description.adore_points:
        row = _adore_row(description, point)
        if row not in rows:
            rows.append(row)
    return rows


def adore_obstacle(description: Description) -> str:
    """Why there are no ADORE constants; empty where there are."""
    law = description.law
    if law.adore is None:
        return f"the law {law.name} has not the form mu = (A + B u) exp(-C u) + D"
    lacking_conditions: set[str] = set()
    for point in description.adore_points:
        lacking_conditions |= set(law.conditions) - set(point)
    if lacking_conditions:
        return f"the points of exports.adore_points lack {', '.join(sorted(lacking_conditions))}"
    speed_index = law.conditions.index("entrainment_speed_m_s")
    for point in description.adore_points:
        if np.isnan(_conditions_at_point(description, point)[speed_index]):
            return "B and C need an entrainment speed, which is not known"
    return ""


def _adore_row(description: Description, requested_point: Mapping[str, float]) -> dict[str, Any]:
    """The ADORE constants at one operating point, in the units of `_ADORE_UNITS`.

    Args:
        description: The fit, which has no `adore_obstacle`.
        requested_point: The operating point, by column.
    """
    law = description.law
    conditions = _conditions_at_point(description, requested_point)
    condition_values = [number_or_none(value) for value in conditions]
    point = dict(zip(law.conditions, condition_values, strict=True))
    speed = float(conditions[law.conditions.index("entrainment_speed_m_s")])
    groups = law.group_values(conditions[np.newaxis])[0]
    a, b, c, d = _adore_constants(description, groups)
    peak_slip = 1 / c - a / b
    peak_mu = (a + b * peak_slip) * math.exp(-c * peak_slip) + d
    return {
        **point,
        "A": a,
        "B": b / speed,
        "C": c / speed,
        "D": d,
        "peak_slip_velocity": peak_slip * speed,
        "peak_mu": peak_mu,
        "outside_tested_box": description.is_outside_tested_box(groups),
        "peak_above_limiting_stress": peak_mu > description.limiting_stress_ratio,
        "peak_outside_tested_slip": peak_slip > (description.slip_variable.tested[1] or 0.0),
    }


def _conditions_at_point(
    description: Description, requested_point: Mapping[str, float]
) -> FloatArray:
    """Conditions of the law at an operating point, shape (conditions,).

    Those on which the fit does not depend have their tested level; NaN where it is not known.
    """
    fitted = description.law_with_constants
    fixed_names = {fixed.condition for fixed in fitted.coefficients.fixed_conditions}
    requested_values = [
        np.nan if name in fixed_names else requested_point[name]
        for name in description.law.conditions
    ]
    return fitted.at_tested_levels(np.array([requested_values]))[0]


def _adore_constants(
    description: Description, group_values: FloatArray
) -> tuple[float, float, float, float]:
    """A, B, C and D of mu over the slide-roll ratio.

    Args:
        description: The fit.
        group_values: Value of each group of the law, shape (groups,).
    """
    coefficients = description.coefficients_at(group_values)
    nodes = {name: expression.name_node(name) for name in coefficients}
    expressions = [expression.parse(text, nodes) for text in description.law.adore or ()]
    evaluate = expression.compile_function(list(coefficients), expressions)
    a, b, c, d = evaluate(*coefficients.values())
    return float(a), float(b), float(c), float(d)


class _ExportForm(NamedTuple):
    """One form of export.

    Attributes:
        file: Name of its file, with `*` for the oil.
        users: Programs that read it.
        use: What a user does with it.
        write: Function that makes its content.
    """

    file: str
    users: str
    use: str
    write: Callable[[Description], str | bytes]


# Forms of export by name. Each needs all coefficients of the law. CSV and JSON do not, and are not
# here.
EXPORT_FORMS = {
    "Python": _ExportForm(
        "traction_*.py", "Python", "import it; needs NumPy; arrays too", PYTHON.source
    ),
    "spreadsheet": _ExportForm(
        "traction_*.xlsx", "Excel, LibreOffice", "type the conditions and S", workbook
    ),
    "C": _ExportForm(
        "traction_*.h", "C99, C++11", "include it; needs libm (`-lm`) only", C_LANGUAGE.source
    ),
    "Fortran": _ExportForm(
        "traction_*.f90", "Fortran 2008", "compile it; arrays too", FORTRAN.source
    ),
    "Modelica": _ExportForm("Traction_*.mo", "Modelica", "load it; SI units", MODELICA.source),
    "MATLAB, Octave": _ExportForm(
        "traction_coefficient_*.m", "MATLAB, GNU Octave", "put it on the path", MATLAB.source
    ),
    "ADORE": _ExportForm("adore_*.csv", "ADORE", "A to D of (A + B u) exp(-C u) + D", adore_csv),
}


def export_campaign(
    results: CampaignTables, settings: Settings, provenance: Mapping[str, Any]
) -> dict[str, bytes]:
    """The fit of each oil in every form, and the exports of the campaign's studies.

    Args:
        results: Tables `points`, `coefficients`, `fit_quality` and `soundness`.
        settings: At least `campaign`, `fit`, `exports` and `studies`.
        provenance: Digests of code, settings and inputs.

    Returns:
        Content of each file, by its path below the folder of the exports. The JSON file names the
        forms that cannot be written, with the reason.
    """
    law = LAWS[settings.fit.law]
    quality = results.fit_quality
    identifier_of_oil = make_identifiers(quality.loc[quality["law"] == law.name, "oil"])
    descriptions = [
        describe(results, oil, identifier, law, settings)
        for oil, identifier in identifier_of_oil.items()
    ]
    digests = {key: provenance[key] for key in ("code", "settings", "inputs")}
    files_of_studies: dict[str, bytes] = {}
    sentences_of_studies = ""
    for study in studies.load_studies(settings.campaign.studies):
        files_of_study = study.exports(identifier_of_oil, settings, digests)
        if files_of_study:
            files_of_studies |= files_of_study
            sentences_of_studies += f"\n{study.exports_sentence}\n"
    return export_oils(descriptions, digests, sentences_of_studies) | files_of_studies


def export_oils(
    descriptions: Sequence[Description], provenance: Mapping[str, Any], text_below: str = ""
) -> dict[str, bytes]:
    """The constants of several oils in every form, and a page that lists them.

    Args:
        descriptions: One per oil. The files of an oil are in a folder with its identifier.
        provenance: Digests of what they were made from.
        text_below: Text below the list of oils on the page.

    Returns:
        Content of each file, by path.
    """
    files = {"README.md": _readme_page(descriptions, text_below).encode()}
    for description in descriptions:
        for file_name, content in export_oil(description, provenance).items():
            files[f"{description.identifier}/{file_name}"] = content
    return files


def export_oil(description: Description, provenance: Mapping[str, Any]) -> dict[str, bytes]:
    """One oil's constants in every form.

    Args:
        description: The oil's fit.
        provenance: Digests of what it was made from.

    Returns:
        Content of each file, by name.
    """
    csv_file = f"traction_{description.identifier}.csv"
    file_of_form = {"CSV": csv_file}
    obstacle_of_form = {}
    content_of_file: dict[str, str | bytes] = {csv_file: constants_csv(description)}
    for form_name, form in EXPORT_FORMS.items():
        obstacle = description.obstacle
        if not obstacle and form_name == "ADORE":
            obstacle = adore_obstacle(description)
        if obstacle:
            obstacle_of_form[form_name] = obstacle
            continue
        file_name = form.file.replace("*", description.identifier)
        file_of_form[form_name] = file_name
        content_of_file[file_name] = form.write(description)
    json_file = f"traction_{description.identifier}.json"
    content_of_file[json_file] = json_text(description, file_of_form, obstacle_of_form, provenance)
    bytes_of_file = {}
    for file_name, content in content_of_file.items():
        bytes_of_file[file_name] = content.encode() if isinstance(content, str) else content
    return bytes_of_file


def _readme_page(descriptions: Sequence[Description], text_below: str) -> str:
    """A page in Markdown: the oils, and the programs that read each file."""
    rows = []
    for description in descriptions:
        rows.append(
            {
                "name": plain_text(description.oil),
                "folder": description.identifier,
                "certificate": description.certificate_sentence,
                "depends": _variables_of_mu(description),
            }
        )
    return TEMPLATE_ENVIRONMENT.get_template("README.md.jinja").render(
        origins=dict.fromkeys(description.origin for description in descriptions),
        oils=rows,
        forms=EXPORT_FORMS.values(),
        below=text_below,
    )


def _variables_of_mu(description: Description) -> str:
    """The variables on which mu depends, and the levels of the other conditions, as text."""
    if description.obstacle:
        return "unknown"
    symbols = ", ".join([argument.symbol for argument in description.arguments] + ["S"])
    return f"{symbols}; {description.where_known}" if description.where_known else symbols
