"""The constants that Deng et al. (2026) print of three oils: the truth behind simulated logs.

Decides: which constants the paper prints (in `data/reference/printed_coefficients.yaml`).
"""

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from oilfilm.base.units import FloatArray
from oilfilm.settings.base import Group, key
from oilfilm.settings.messages import load
from oilfilm.settings.quantities import Name, OneOrMoreDistinct, Text

_Constants = Annotated[list[float], Field(min_length=4, max_length=4)]
_Certainty = Literal["certain", "probable", "open", "without effect"]
_SignCertainties = Annotated[list[_Certainty], Field(min_length=3, max_length=3)]


class OilConstants(Group):
    """Printed constants of one oil, signs restored."""

    A: _Constants = key("A0 and the exponents of P, U and T.")
    B: _Constants = key("B0 and the exponents of P, U and T.")
    C: _Constants = key("C0 and the exponents of P, U and T.")
    signs: dict[Literal["A", "B", "C"], _SignCertainties] = key(
        "How sure each exponent's sign is, P, U, T."
    )


class PrintedCoefficients(Group):
    """data/reference/printed_coefficients.yaml: constants of Eqs 11-13."""

    law: Name = key("Law.")
    falling_viscosity: OneOrMoreDistinct[str] = key("Oils, the most viscous first.")
    oils: Annotated[dict[str, OilConstants], Field(min_length=1)] = key("Constants by oil.")
    doubtful: dict[Name, Text] = key(
        "Oils whose magnitudes may be damaged as well, and why.", default={}
    )

    def constants_by_oil(self) -> dict[str, FloatArray]:
        """A0..A3, B0..B3 and C0..C3 of each oil, the most viscous oil first."""
        constants = {}
        for oil in self.falling_viscosity:
            oil_constants = self.oils[oil]
            constants[oil] = np.concatenate([oil_constants.A, oil_constants.B, oil_constants.C])
        return constants

    def sign_certainties(self, oil: str) -> dict[str, str]:
        """How sure the sign of each exponent of an oil is, by the name of the constant."""
        certainty_of_constant: dict[str, str] = {}
        for letter, certainties in self.oils[oil].signs.items():
            for exponent_index, certainty in enumerate(certainties, start=1):
                certainty_of_constant[f"{letter}{exponent_index}"] = certainty
        return certainty_of_constant


def read_printed_constants(path: Path) -> dict[str, FloatArray]:
    """The twelve printed constants of each oil, signs restored; the most viscous oil first.

    Raises:
        OilfilmError: The file is missing or has a mistake.
    """
    return load(path, PrintedCoefficients).constants_by_oil()
