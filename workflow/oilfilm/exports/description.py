"""The one description of an oil's fit from which every form of export is made."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.tables import unit_of
from oilfilm.traction import LAWS
from oilfilm.traction.law import CONDITIONS, Law


@dataclass(frozen=True)
class Formula:
    """How a law is written at one operating condition, for S >= 0; it is odd in S.

    The operators mean the same in C, Fortran, Modelica and Python.
    """

    text: str
    source: str


FORMULAS = {
    "deng2026": Formula(
        "(A + B * S) * exp(-C * S) - A",
        "K. Deng, X. Qing, F. Pape, Y. Wang, Lubricants 14 (2026) 33, Eqs 7-9, "
        "https://doi.org/10.3390/lubricants14010033",
    )
}
_SYMBOLS = dict(zip(CONDITIONS, "PUT", strict=True))
_MEANINGS = dict(
    zip(
        CONDITIONS,
        (
            "maximum Hertz pressure",
            "entrainment speed, mean of both surface speeds",
            "oil temperature at the inlet",
        ),
        strict=True,
    )
)
SLIP = "slide_roll_ratio"
SLIP_MEANING = "sliding speed over entrainment speed"


@dataclass(frozen=True)
class Condition:
    """One operating condition: the law's argument where the data give its exponents.

    Attributes:
        name: Column of the tables, with its unit.
        reference: Value at which its power is 1.
        argument: False where the law is known at `level` only.
        level: The one level tested; None where the condition is an argument, or unknown.
        lower: Smallest value among the accepted points; None where unknown.
        upper: Largest one.
    """

    name: str
    reference: float
    argument: bool
    level: float | None
    lower: float | None
    upper: float | None

    @property
    def symbol(self) -> str:
        """P, U or T."""
        return _SYMBOLS[self.name]

    @property
    def unit(self) -> str:
        """Unit in words of the tables."""
        return unit_of(self.name)

    @property
    def meaning(self) -> str:
        """What it is."""
        return _MEANINGS[self.name]


@dataclass(frozen=True)
class Constant:
    """One dimensionless constant with its errors; None is what the data cannot give."""

    name: str
    meaning: str
    value: float | None
    standard_error: float | None
    lower: float | None
    upper: float | None
    systematic_standard_error: float | None
    verdict: str


@dataclass(frozen=True)
class Description:
    """One oil's fit, with everything that its user must know.

    Attributes:
        oil: Name as in the configuration, untrusted.
        identifier: What stands for it in file names and identifiers.
        campaign: Name of the campaign.
        about: Its description.
        simulated: Whether the data are a rig twin's.
        law: Name of the law.
        conditions: P, U and T.
        slip_upper: Largest |S| tested; None where nothing was accepted.
        constants: All constants, in the law's order.
        quality: The oil's row of the table `fit_quality`.
        adore_points: Operating points (by column) at which the ADORE form is wanted.
    """

    oil: str
    identifier: str
    campaign: str
    about: str
    simulated: bool
    law: str
    conditions: tuple[Condition, ...]
    slip_upper: float | None
    constants: tuple[Constant, ...]
    quality: Mapping[Any, Any]
    adore_points: tuple[Mapping[str, float], ...]

    @property
    def identity(self) -> dict[str, Any]:
        """What every row of a csv file says of where it comes from."""
        return {
            "oil": self.oil,
            "law": self.law,
            "campaign": self.campaign,
            "data": "simulated" if self.simulated else "measured",
            "certified": bool(self.quality["certified"]),
        }

    @property
    def arguments(self) -> tuple[Condition, ...]:
        """Conditions on which the fitted law depends."""
        return tuple(one for one in self.conditions if one.argument)

    @property
    def fixed(self) -> tuple[Condition, ...]:
        """Conditions at whose tested level alone it is known."""
        return tuple(one for one in self.conditions if not one.argument)

    @property
    def argument_names(self) -> list[str]:
        """Arguments of the exported functions."""
        return [*(one.name for one in self.arguments), SLIP]

    @property
    def formula(self) -> Formula:
        """The law as it is written."""
        return FORMULAS[self.law]

    @property
    def obstacle(self) -> str:
        """Why no function of mu can be written; empty where one can."""
        if self.law not in FORMULAS:
            return f"the law {self.law} has no formula in oilfilm.exports"
        if any(factor is None for factor, _ in self.powers.values()):
            return str(self.quality["verdict"])
        return ""

    @cached_property
    def powers(self) -> dict[str, tuple[float | None, dict[str, float]]]:
        """A, B, C -> the factor before its powers, and the exponents of P, U and T."""
        law, values = LAWS[self.law], {one.name: one.value for one in self.constants}
        powers: dict[str, tuple[float | None, dict[str, float]]] = {}
        for letter, block in _blocks(law).items():
            head, *exponents = block
            factor = values[head.name]
            known = {
                _SYMBOLS[str(one.condition)]: value
                for one in exponents
                if (value := values[one.name]) is not None
            }
            powers[letter] = (values.get(letter) if factor is None else factor, known)
        return powers

    def coefficients(self, point: Mapping[str, float]) -> tuple[float, ...]:
        """A, B and C at an operating point; conditions that are no arguments do not matter."""
        bars = {one.symbol: point[one.name] / one.reference for one in self.arguments}
        return tuple(
            (np.nan if factor is None else factor)
            * math.prod(bars[symbol] ** exponent for symbol, exponent in exponents.items())
            for factor, exponents in self.powers.values()
        )

    def outside(self, point: Mapping[str, float]) -> bool:
        """Whether an operating point lies outside the tested box, whatever its slip."""
        return not all(
            one.lower is not None
            and one.upper is not None
            and one.lower <= point[one.name] <= one.upper
            for one in self.arguments
        )

    def product(
        self, letter: str, power: Callable[[str, str], str], times: str, ending: str = ""
    ) -> str:
        """A, B or C as source code: its factor and its powers of p, u and t, all digits."""
        factor, exponents = self.powers[letter]
        powers = [
            power(symbol.lower(), f"{value!r}{ending}") for symbol, value in exponents.items()
        ]
        return times.join([f"{factor!r}{ending}", *powers])


def describe(
    oil: str,
    identifier: str,
    points: pd.DataFrame,
    coefficients: pd.DataFrame,
    quality: pd.DataFrame,
    config: Mapping[str, Any],
) -> Description:
    """Describe one oil's fit.

    Args:
        oil: The oil.
        identifier: What stands for it in identifiers (`names.identifiers`).
        points: Table of points of the campaign.
        coefficients: Table of coefficients.
        quality: Table of fit quality, with one law an oil.
        config: The resolved configuration.
    """
    campaign = config["campaign"]
    row = quality[quality["oil"] == oil].to_dict("records")[0]
    law = LAWS[row["law"]]
    of_oil = coefficients[(coefficients["oil"] == oil) & (coefficients["law"] == law.name)]
    values = of_oil.set_index("constant")["value"]
    accepted = points[(points["oil"] == oil) & points["accepted"]]
    box = tested_box(accepted)
    levels = accepted.groupby("run_id")[list(CONDITIONS)].mean().mean(skipna=False)
    conditions = []
    for name, reference in zip(CONDITIONS, law.reference, strict=True):
        exponents = [one.name for one in law.constants if one.condition == name]
        argument = bool(values[exponents].notna().all())
        level = None if argument else known(levels[name])
        conditions.append(Condition(name, float(reference), argument, level, *box[name]))
    meanings = _meanings(law)
    return Description(
        oil=oil,
        identifier=identifier,
        campaign=campaign["name"],
        about=campaign["description"],
        simulated=campaign["data"] == "simulated",
        law=law.name,
        conditions=tuple(conditions),
        slip_upper=box[SLIP][1],
        constants=tuple(
            _constant(constant, meanings[constant["constant"]])
            for constant in of_oil.to_dict("records")
        ),
        quality=row,
        adore_points=tuple(config["exports"]["adore_points"]),
    )


def tested_box(accepted: pd.DataFrame) -> dict[str, tuple[float | None, float | None]]:
    """Smallest and largest P, U, T and |S| among the accepted points; None where unknown.

    |S| begins at 0, tested or not: traction is odd in S, so that it is 0 there.
    """
    box = {
        name: (known(accepted[name].min(skipna=False)), known(accepted[name].max(skipna=False)))
        for name in CONDITIONS
    }
    return box | {SLIP: (0.0, known(accepted[SLIP].abs().max()))}


def known(value: float) -> float | None:
    """The number as plain Python has it; None for NaN."""
    return None if np.isnan(value) else float(value)


def power_law(conditions: Iterable[Condition]) -> str:
    """How A, B and C depend on these conditions."""
    powers = (
        f"({one.symbol} / {one.reference:g} {one.unit})^X{CONDITIONS.index(one.name) + 1}"
        for one in conditions
    )
    return f"X = X0 {' '.join(powers)} for X = A, B, C"


def _blocks(law: Law) -> dict[str, list[Any]]:
    """The law's constants by coefficient: the factor, then its exponents."""
    starts = [place for place, one in enumerate(law.constants) if one.condition is None]
    ends = [*starts[1:], len(law.constants)]
    blocks = [list(law.constants[start:end]) for start, end in zip(starts, ends, strict=True)]
    return dict(zip(law.local_constants, blocks, strict=True))


def _meanings(law: Law) -> dict[str, str]:
    meanings = {}
    for letter, (head, *exponents) in _blocks(law).items():
        meanings[head.name] = f"{letter} at the reference condition"
        meanings[letter] = f"{letter} at the level of what is fixed, at the reference of the rest"
        for one in exponents:
            meanings[one.name] = f"exponent of {_SYMBOLS[one.condition]} in {letter}"
    return meanings


def _constant(row: Mapping[Any, Any], meaning: str) -> Constant:
    numbers = ("value", "standard_error", "lower", "upper", "systematic_standard_error")
    given = {name: known(row[name]) for name in numbers}
    return Constant(row["constant"], meaning, verdict=row["verdict"], **given)
