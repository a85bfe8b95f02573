"""Everything known of a fit as JSON, every number with its unit beside it."""

import json
from collections.abc import Mapping
from typing import Any

from oilfilm.outputs.exports.adore import FORM, UNITS, adore_rows
from oilfilm.outputs.exports.description import (
    SLIP,
    SLIP_MEANING,
    Condition,
    Description,
    known,
)
from oilfilm.outputs.exports.json_format import ExportFile

VERSION = 2


def json_text(
    description: Description,
    files: Mapping[str, str],
    not_written: Mapping[str, str],
    provenance: Mapping[str, Any],
) -> str:
    """The description as JSON, in the format of `json_format.ExportFile`.

    Args:
        description: The fit.
        files: Form -> file beside this one.
        not_written: Form -> why there is no such file.
        provenance: Digests of code, settings and inputs.
    """
    content = {
        "format": "oilfilm traction law",
        "format_version": VERSION,
        "oil": description.oil,
        "campaign": {"name": description.campaign, "description": description.about},
        "data": description.identity["data"],
        "law": _law(description),
        "conditions": [*map(_condition, description.conditions), _slip(description)],
        "constants": [constant.model_dump() for constant in description.constants],
        "fit": _fit(description.quality),
        "adore": {
            "form": FORM,
            "units": UNITS,
            "points": adore_rows(description) if "ADORE" in files else [],
        },
        "files": dict(files),
        "not_written": dict(not_written),
        "provenance": {key: provenance[key] for key in ("code", "settings", "inputs")},
    }
    text = json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    ExportFile.model_validate_json(text)
    return text


def _law(description: Description) -> dict[str, Any]:
    law = description.law
    return {
        "name": law.name,
        "mu_for_slip_of_0_or_more": law.equation,
        "parts_of_mu": dict(law.parts),
        "mu_for_slip_below_0": "-mu(-S)",
        "coefficients": description.power_law(description.conditions),
        "known_exponents": {
            coefficient.name: list(coefficient.exponents)
            for coefficient in law.coefficients
            if coefficient.exponents is not None
        },
        "source": law.source,
    }


def _condition(condition: Condition) -> dict[str, Any]:
    return {
        "name": condition.name,
        "symbol": condition.symbol,
        "meaning": condition.meaning,
        "unit": condition.unit,
        "role": "argument" if condition.argument else "fixed",
        "level": condition.level,
        "reference": condition.reference,
        "tested": [condition.lower, condition.upper],
    }


def _slip(description: Description) -> dict[str, Any]:
    return {
        "name": SLIP,
        "symbol": "S",
        "meaning": f"{SLIP_MEANING}, of either sign",
        "unit": "1",
        "role": "argument",
        "level": None,
        "reference": None,
        "tested": [0.0, description.slip_upper],
    }


def _fit(quality: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "certified": bool(quality["certified"]),
        "verdict": quality["certificate"],
        "points": int(quality["n_points"]),
        "runs": int(quality["n_curves"]),
        "rms_error_of_mu": known(quality["rmse"]),
        "largest_error_of_mu": known(quality["max_error"]),
        "fixed_conditions": quality["fixed_conditions"],
    }
