"""Everything known of a fit as JSON, every number with its unit beside it."""

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from oilfilm.exports.adore import FORM, UNITS, adore_rows
from oilfilm.exports.description import Description, number_or_none
from oilfilm.exports.header import origin


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
        "constants": list(description.constants),
        "fit": quality
        and {
            "certified": description.certified,
            "verdict": quality["certificate"],
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
