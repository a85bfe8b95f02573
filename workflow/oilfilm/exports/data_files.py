"""Everything known of a fit: as JSON, every number with its unit beside it, and as a tidy table."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, replace
from typing import Any

import pandas as pd

from oilfilm.exports.adore import FORM, UNITS, adore_rows
from oilfilm.exports.description import (
    SLIP,
    SLIP_MEANING,
    Condition,
    Description,
    number_or_none,
)
from oilfilm.exports.header import origin
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
        "origin": origin(description),
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
