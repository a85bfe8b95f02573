"""Everything known of a fit as JSON and as a tidy table, and its form for ADORE.

The four constants of the ADORE bearing-dynamics code at single operating points are those of

    mu = (A + B u) exp(-C u) + D

with u = S U the slip velocity in m/s, 0 or more. A law that has this form over the slide-roll
ratio S says so (`Law.adore`); B and C are then divided by U. D is mu far beyond the peak, A is mu
at rest less D, and with the peak (u_m, mu_m) C = B/(A + B u_m).

Reference: P. K. Gupta, Advanced Dynamics of Rolling Elements, Springer, 1984.
"""

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.exports.description import SLIP, SLIP_MEANING, Condition, Description, number_or_none
from oilfilm.report.spreadsheet import csv_text
from oilfilm.traction import expression
from oilfilm.units import FloatArray

FORM = "mu = (A + B u) exp(-C u) + D, u the slip velocity in m/s, 0 or more"
UNITS = {
    "A": "1",
    "B": "s/m",
    "C": "s/m",
    "D": "1",
    "mu_at_rest": "1",
    "mu_far_beyond_peak": "1",
    "peak_slip_velocity": "m/s",
    "peak_mu": "1",
}


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
        "format_version": 4,
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
            "verdict": quality["certificate"],
            "not_sound_because": list(description.fitted.wrong),
            "points": int(quality["n_points"]),
            "runs": int(quality["n_curves"]),
            "rms_error_of_mu": number_or_none(quality["rmse"]),
            "largest_error_of_mu": number_or_none(quality["max_error"]),
            "fixed_conditions": [asdict(fixed) for fixed in fixed_conditions],
        },
        "adore": {
            "form": FORM,
            "units": UNITS,
            "points": adore_rows(description) if "ADORE" in files else [],
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
        return f"the law {law.name} has not the form {FORM.partition(',')[0]}"
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
        "mu_at_rest": a + d,
        "mu_far_beyond_peak": d,
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
