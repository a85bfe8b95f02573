"""Everything known of a fit as JSON, every number with its unit beside it."""

import json
from collections.abc import Mapping
from typing import Any

from oilfilm.outputs.exports.adore import FORM, UNITS, adore_rows
from oilfilm.outputs.exports.description import (
    FORMULAS,
    SLIP,
    SLIP_MEANING,
    Condition,
    Constant,
    Description,
    known,
)
from oilfilm.traction import LAWS

VERSION = 1


def json_text(
    description: Description,
    files: Mapping[str, str],
    not_written: Mapping[str, str],
    provenance: Mapping[str, Any],
) -> str:
    """The description as JSON (workflow/schemas/export.schema.json).

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
        "constants": [*map(_constant, description.constants)],
        "fit": _fit(description.quality),
        "adore": {
            "form": FORM,
            "units": UNITS,
            "points": [] if description.obstacle else adore_rows(description),
        },
        "files": dict(files),
        "not_written": dict(not_written),
        "provenance": {key: provenance[key] for key in ("code", "settings", "inputs")},
    }
    return json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _law(description: Description) -> dict[str, Any]:
    return {
        "name": description.law,
        "mu_for_slip_of_0_or_more": FORMULAS.get(description.law),
        "mu_for_slip_below_0": "-mu(-S)",
        "coefficients": description.power_law(description.conditions),
        "source": LAWS[description.law].source,
    }


def _condition(one: Condition) -> dict[str, Any]:
    return {
        "name": one.name,
        "symbol": one.symbol,
        "meaning": one.meaning,
        "unit": one.unit,
        "role": "argument" if one.argument else "fixed",
        "level": one.level,
        "reference": one.reference,
        "tested": [one.lower, one.upper],
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


def _constant(one: Constant) -> dict[str, Any]:
    return {
        "name": one.name,
        "meaning": one.meaning,
        "value": one.value,
        "unit": "1",
        "standard_error": one.standard_error,
        "interval_95": [one.lower, one.upper],
        "systematic_standard_error": one.systematic_standard_error,
        "verdict": one.verdict,
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
