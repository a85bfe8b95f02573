"""The constants that the paper prints, described as a fit is."""

from pathlib import Path

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
    return [
        _describe(oil, name, printed_law(printed, oil, tested), settings)
        for oil, name in zip(printed.falling_viscosity, names.values(), strict=True)
    ]


def _describe(
    oil: str, identifier: str, fitted: PrintedLaw, settings: ExportSettings
) -> Description:
    law, box = fitted.law, fitted.coefficients.box.tolist()
    conditions = [
        Condition(
            name,
            QUANTITIES[name].symbol,
            QUANTITIES[name].meaning,
            QUANTITIES[name].unit,
            "argument",
            level=None,
            reference=reference,
            tested=(low, high),
        )
        for name, reference, (low, high) in zip(law.conditions, law.reference, box, strict=False)
    ]
    meanings, values = constant_meanings(law), fitted.coefficients.constants.tolist()
    constants = [
        {
            "name": constant.name,
            "meaning": meanings[constant.name],
            "value": value,
            "unit": "1",
            "standard_error": None,
            "interval": [None, None],
            "systematic_standard_error": None,
            "verdict": f"printed, sign {sure}"
            if (sure := fitted.signs.get(constant.name))
            else "printed",
        }
        for constant, value in zip(law.constants, values, strict=True)
    ]
    return Description(
        oil=oil,
        identifier=identifier,
        campaign=None,
        fitted=fitted,
        conditions=tuple(conditions),
        constants=tuple(constants),
        quality=None,
        adore_points=tuple(point.model_dump() for point in settings.adore_points),
    )
