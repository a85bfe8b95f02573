"""The constants that the paper prints, described as a fit is."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from oilfilm.exports.description import Condition, Description, constant_meanings
from oilfilm.exports.names import identifiers
from oilfilm.paper.printed_law import PrintedLaw, printed_law
from oilfilm.paper.reference import PrintedCoefficients
from oilfilm.settings.config import Box, ExportSettings
from oilfilm.settings.messages import load
from oilfilm.traction.law import QUANTITIES


def describe_printed(path: Path, tested: Box, settings: ExportSettings) -> list[Description]:
    """Describe the printed constants of each oil of the paper.

    Args:
        path: data/reference/printed_coefficients.yaml.
        tested: What the paper's abstract says was tested (`printed.boxes.tested`).
        settings: Operating points of the ADORE form.

    Raises:
        OilfilmError: The file is missing or has a mistake.
    """
    printed = load(path, PrintedCoefficients)
    names = identifiers([f"{oil} printed" for oil in printed.falling_viscosity])
    points = tuple(point.model_dump() for point in settings.adore_points)
    described = []
    for oil, name in zip(printed.falling_viscosity, names.values(), strict=True):
        fitted = printed_law(printed, oil, tested)
        described.append(
            Description(
                oil=oil,
                identifier=name,
                campaign=None,
                fitted=fitted,
                conditions=tuple(_conditions(fitted)),
                constants=tuple(_constants(fitted)),
                quality=None,
                adore_points=points,
            )
        )
    return described


def _conditions(fitted: PrintedLaw) -> Iterator[Condition]:
    law, box = fitted.law, fitted.coefficients.box.tolist()
    for name, reference, (low, high) in zip(law.conditions, law.reference, box, strict=False):
        about = QUANTITIES[name].symbol, QUANTITIES[name].meaning, QUANTITIES[name].unit
        yield Condition(name, *about, "argument", None, reference, (low, high))


def _constants(fitted: PrintedLaw) -> Iterator[dict[str, Any]]:
    """What the description has of each constant: a value, but no uncertainty."""
    meanings, signs = constant_meanings(fitted.law), fitted.signs
    unknown = {"standard_error": None, "interval": [None, None], "systematic_standard_error": None}
    values = fitted.coefficients.constants.tolist()
    for constant, value in zip(fitted.law.constants, values, strict=True):
        name = constant.name
        sure = f"printed, sign {signs[name]}" if name in signs else "printed"
        about = {"name": name, "meaning": meanings[name], "value": value, "unit": "1"}
        yield {**about, **unknown, "verdict": sure}
