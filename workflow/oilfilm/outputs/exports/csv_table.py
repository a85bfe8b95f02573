"""Constants, reference condition and tested box as one tidy table."""

from typing import Any

import pandas as pd

from oilfilm.outputs.exports.description import SLIP, SLIP_MEANING, Condition, Description
from oilfilm.outputs.spreadsheet import csv_text


def csv_table(description: Description) -> str:
    """A row a quantity; each says whose it is, so that the tables of several oils can be joined.

    `kind` is constant, reference (where every power is 1), level (the one level of a condition
    that gives no exponent), tested minimum or tested maximum.
    """
    constants = [
        {
            "kind": "constant",
            "quantity": one.name,
            "value": one.value,
            "unit": "1",
            "standard_error": one.standard_error,
            "lower_95": one.lower,
            "upper_95": one.upper,
            "systematic_standard_error": one.systematic_standard_error,
            "verdict": one.verdict,
            "meaning": one.meaning,
        }
        for one in description.constants
    ]
    conditions = [row for one in description.conditions for row in _rows(one)]
    slip = [
        _row(f"tested {end}", f"|{SLIP}|", value, "1", SLIP_MEANING)
        for end, value in (("minimum", 0.0), ("maximum", description.slip_upper))
    ]
    rows = pd.DataFrame([*constants, *conditions, *slip])
    rows["verdict"] = rows["verdict"].fillna("")
    rows["value"] = rows["value"].astype(float)
    return csv_text(pd.DataFrame(description.identity, index=rows.index).join(rows))


def _rows(one: Condition) -> list[dict[str, Any]]:
    values = {
        "reference": one.reference,
        **({} if one.argument else {"level": one.level}),
        "tested minimum": one.lower,
        "tested maximum": one.upper,
    }
    return [_row(kind, one.name, value, one.unit, one.meaning) for kind, value in values.items()]


def _row(kind: str, quantity: str, value: float | None, unit: str, meaning: str) -> dict[str, Any]:
    return {"kind": kind, "quantity": quantity, "value": value, "unit": unit, "meaning": meaning}
