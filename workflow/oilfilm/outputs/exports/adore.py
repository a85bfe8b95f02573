"""The four constants of the ADORE bearing-dynamics code at single operating points.

    mu = (A + B u) exp(-C u) + D

with u the slip velocity in m/s, 0 or more. Put u = S U into (A' + B' S) exp(-C' S) - A': that is
the form, exactly, with A = A', B = B'/U, C = C'/U and D = -A'. D is mu far beyond the peak, A is
mu at rest less D, and with the peak (u_m, mu_m) C = B/(A + B u_m).

Reference: P. K. Gupta, Advanced Dynamics of Rolling Elements, Springer, 1984.
"""

import math
from collections.abc import Mapping
from typing import Any

import pandas as pd

from oilfilm.outputs.exports.description import Description
from oilfilm.outputs.spreadsheet import csv_text

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
    """A row an operating point, with the units in the column names."""
    rows = pd.DataFrame(adore_rows(description))
    rows = rows.rename(columns={name: f"{name} [{unit}]" for name, unit in UNITS.items()})
    return csv_text(pd.DataFrame(description.identity, index=rows.index).join(rows))


def adore_rows(description: Description) -> list[dict[str, Any]]:
    """The constants at each operating point asked for, in the units of `UNITS`.

    Conditions of which the fit knows one level only stand at that level; points that become the
    same are given once.
    """
    rows: list[dict[str, Any]] = []
    for asked in description.adore_points:
        row = _row(description, asked)
        if row not in rows:
            rows.append(row)
    return rows


def _row(description: Description, asked: Mapping[str, float]) -> dict[str, Any]:
    point = {
        one.name: asked[one.name] if one.argument else one.level for one in description.conditions
    }
    speed = point["entrainment_speed_m_s"]
    if speed is None:
        raise ValueError("the point has no entrainment speed")
    a, b, c = description.coefficients(asked)
    peak = 1 / c - a / b
    return {
        **point,
        "A": a,
        "B": b / speed,
        "C": c / speed,
        "D": -a,
        "mu_at_rest": 0.0,
        "mu_far_beyond_peak": -a,
        "peak_slip_velocity": peak * speed,
        "peak_mu": (a + b * peak) * math.exp(-c * peak) - a,
        "outside_tested_box": description.outside(asked),
        "peak_outside_tested_slip": peak > (description.slip_upper or 0.0),
    }
