"""Constants, reference condition and tested box as one tidy table."""

from typing import Any

import pandas as pd

from oilfilm.outputs.exports.description import SLIP, SLIP_MEANING, Condition, Description
from oilfilm.outputs.spreadsheet import csv_text


def csv_table(description: Description) -> str:
    """One row per quantity, each with its oil and law: tables of several oils can be joined.

    `kind` is constant, reference (where every power is 1), level (the one level of a condition
    that gives no exponent), tested minimum or tested maximum.
    """
    constants = [
        {
            "kind": "constant",
            "quantity": constant.name,
            "value": constant.value,
            "unit": constant.unit,
            "standard_error": constant.standard_error,
            "lower_95": constant.interval_95[0],
            "upper_95": constant.interval_95[1],
            "systematic_standard_error": constant.systematic_standard_error,
            "verdict": constant.verdict,
            "meaning": constant.meaning,
        }
        for constant in description.constants
    ]
    conditions = [row for condition in description.conditions for row in _rows(condition)]
    slip = [
        _row(f"tested {end}", f"|{SLIP}|", value, "1", SLIP_MEANING)
        for end, value in (("minimum", 0.0), ("maximum", description.slip_upper))
    ]
    rows = pd.DataFrame([*constants, *conditions, *slip])
    rows["verdict"] = rows["verdict"].fillna("")
    rows["value"] = rows["value"].astype(float)
    return csv_text(pd.DataFrame(description.identity, index=rows.index).join(rows))


def _rows(condition: Condition) -> list[dict[str, Any]]:
    values = {
        "reference": condition.reference,
        **({} if condition.argument else {"level": condition.level}),
        "tested minimum": condition.lower,
        "tested maximum": condition.upper,
    }
    return [
        _row(kind, condition.name, value, condition.unit, condition.meaning)
        for kind, value in values.items()
    ]


def _row(kind: str, quantity: str, value: float | None, unit: str, meaning: str) -> dict[str, Any]:
    return {"kind": kind, "quantity": quantity, "value": value, "unit": unit, "meaning": meaning}
