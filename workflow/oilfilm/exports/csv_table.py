"""Constants, reference condition and tested box as one tidy table."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pandas as pd

from oilfilm.exports.description import SLIP, SLIP_MEANING, Condition, Description
from oilfilm.report.spreadsheet import csv_text


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
