"""The four constants of the ADORE bearing-dynamics code at single operating points.

    mu = (A + B u) exp(-C u) + D

with u = S U the slip velocity in m/s, 0 or more. A law that has this form over the slide-roll
ratio S says so (`Law.adore`); B and C are then divided by U. D is mu far beyond the peak, A is mu
at rest less D, and with the peak (u_m, mu_m) C = B/(A + B u_m).

Reference: P. K. Gupta, Advanced Dynamics of Rolling Elements, Springer, 1984.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.exports.description import Description, number_or_none
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
