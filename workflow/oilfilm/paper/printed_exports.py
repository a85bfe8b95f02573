"""The constants that the paper prints, described as a fit is."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from oilfilm.exports.description import Condition, Description, constant_meanings
from oilfilm.exports.names import identifiers
from oilfilm.fits.fitted import Coefficients, FittedLaw
from oilfilm.paper.reference import printed_constants
from oilfilm.settings.config import Box, ExportSettings
from oilfilm.traction.law import QUANTITIES
from oilfilm.traction.laws.deng2026 import DENG2026
from oilfilm.units import FloatArray


def describe_printed(path: Path, tested: Box, settings: ExportSettings) -> list[Description]:
    """Describe the printed constants of each oil of the paper.

    Args:
        path: data/reference/printed_coefficients.yaml.
        tested: What the paper's abstract says was tested (`printed.boxes.tested`).
        settings: Operating points of the ADORE form.

    Raises:
        OilfilmError: The file is missing or has a mistake.
    """
    constants = printed_constants(path)
    names = identifiers([f"{oil} printed" for oil in constants])
    return [
        _describe(oil, name, values, tested, settings)
        for (oil, values), name in zip(constants.items(), names.values(), strict=True)
    ]


def _describe(
    oil: str, identifier: str, constants: FloatArray, tested: Box, settings: ExportSettings
) -> Description:
    law = DENG2026
    ends = tested.model_dump()
    box = np.array([ends[name] for name in (*law.conditions, "slide_roll_ratio")], dtype=float)
    coefficients = replace(Coefficients.bare(law, constants), box=box)
    conditions = []
    for name, reference in zip(law.conditions, law.reference, strict=True):
        quantity = QUANTITIES[name]
        lower, upper = map(float, ends[name])
        conditions.append(
            Condition(
                name,
                quantity.symbol,
                quantity.meaning,
                quantity.unit,
                "argument",
                level=None,
                reference=reference,
                tested=(lower, upper),
            )
        )
    meanings = constant_meanings(law)
    return Description(
        oil=oil,
        identifier=identifier,
        campaign=None,
        fitted=FittedLaw(law, coefficients),
        conditions=tuple(conditions),
        constants=tuple(
            _constant(constant.name, value, meanings[constant.name], constant.sign)
            for constant, value in zip(law.constants, constants.tolist(), strict=True)
        ),
        quality=None,
        adore_points=tuple(point.model_dump() for point in settings.adore_points),
    )


def _constant(name: str, value: float, meaning: str, stated_sign: int) -> dict[str, Any]:
    return {
        "name": name,
        "meaning": meaning,
        "value": value,
        "unit": "1",
        "standard_error": None,
        "interval": [None, None],
        "systematic_standard_error": None,
        "verdict": "printed" if stated_sign else "printed, sign restored",
    }
