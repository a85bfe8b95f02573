"""The one description of an oil's fit from which every form of export is made."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.traction import LAWS
from oilfilm.traction.law import Constant as LawConstant
from oilfilm.traction.law import Law

# How a law is written at one operating condition, for S >= 0. The operators mean the same in C,
# Fortran, Modelica and Python.
FORMULAS = {"deng2026": "(A + B * S) * exp(-C * S) - A"}
# Condition -> its symbol and its meaning.
_WORDS = {
    "max_hertz_pressure_gpa": ("P", "maximum Hertz pressure"),
    "entrainment_speed_m_s": ("U", "entrainment speed, mean of both surface speeds"),
    "inlet_temperature_c": ("T", "oil temperature at the inlet"),
    "load_n": ("W", "normal load"),
}
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
        lower: Smallest value tested; None where unknown.
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
        """P, U, T or W."""
        return _WORDS[self.name][0]

    @property
    def unit(self) -> str:
        """Unit in words of the tables."""
        return tables.unit_of(self.name)

    @property
    def meaning(self) -> str:
        """What it is."""
        return _WORDS[self.name][1]


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
        conditions: Operating conditions of the law, in its order.
        slip_upper: Largest |S| tested; None where nothing was accepted. |S| counts as tested from
            0, where traction, being odd in S, is 0.
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
    quality: Mapping[str, Any]
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
    def formula(self) -> str:
        """mu by A, B, C and S, 0 or more."""
        return FORMULAS[self.law]

    def power_law(self, conditions: Iterable[Condition]) -> str:
        """How A, B and C depend on these of the conditions."""
        powers = (
            f"({one.symbol} / {one.reference:g} {one.unit})^X{self.conditions.index(one) + 1}"
            for one in conditions
        )
        return f"X = X0 {' '.join(powers)} for X = {', '.join(self.powers)}"

    @property
    def obstacle(self) -> str:
        """Why no function of mu can be written; empty where one can."""
        if self.law not in FORMULAS:
            return f"the law {self.law} has no formula in oilfilm.outputs.exports"
        if any(factor is None for factor, _ in self.powers.values()):
            return str(self.quality["certificate"])
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
                _WORDS[str(one.condition)][0]: value
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
        points: Table of points of the campaign, for the level of conditions that did not vary.
        coefficients: Table of coefficients.
        quality: Table of fit quality, with one law an oil.
        config: The resolved configuration.
    """
    campaign = config["campaign"]
    (row,) = tables.rows(quality[quality["oil"] == oil])
    law = LAWS[row["law"]]
    of_oil = coefficients[(coefficients["oil"] == oil) & (coefficients["law"] == law.name)]
    values = of_oil.set_index("constant")["value"]
    names = list(law.conditions)
    accepted = points[(points["oil"] == oil) & points["accepted"]]
    levels = accepted.groupby("run_id")[names].mean().mean(skipna=False)
    conditions = []
    for name, reference in zip(names, law.reference, strict=True):
        exponents = [one.name for one in law.constants if one.condition == name]
        argument = bool(values[exponents].notna().all())
        level = None if argument else known(levels[name])
        box = (known(row[f"tested_{end}_{name}"]) for end in ("min", "max"))
        conditions.append(Condition(name, float(reference), argument, level, *box))
    meanings = _meanings(law)
    return Description(
        oil=oil,
        identifier=identifier,
        campaign=campaign["name"],
        about=campaign["description"],
        simulated=campaign["data"] == "simulated",
        law=law.name,
        conditions=tuple(conditions),
        slip_upper=known(row[f"tested_max_{SLIP}"]),
        constants=tuple(
            _constant(constant, meanings[constant["constant"]]) for constant in tables.rows(of_oil)
        ),
        quality=row,
        adore_points=tuple(config["exports"]["adore_points"]),
    )


def known(value: float) -> float | None:
    """The number as plain Python has it; None for NaN."""
    return None if np.isnan(value) else float(value)


def _blocks(law: Law) -> dict[str, tuple[LawConstant, ...]]:
    """The law's constants by coefficient: the factor, then its exponents."""
    size = 1 + len(law.conditions)
    starts = range(0, len(law.constants), size)
    blocks = (law.constants[start : start + size] for start in starts)
    return dict(zip(law.local_constants, blocks, strict=True))


def _meanings(law: Law) -> dict[str, str]:
    meanings = {}
    for letter, (head, *exponents) in _blocks(law).items():
        meanings[head.name] = f"{letter} at the reference condition"
        meanings[letter] = f"{letter} at the level of what is fixed, at the reference of the rest"
        for one in exponents:
            meanings[one.name] = f"exponent of {_WORDS[str(one.condition)][0]} in {letter}"
    return meanings


def _constant(row: Mapping[str, Any], meaning: str) -> Constant:
    numbers = ("value", "standard_error", "lower", "upper", "systematic_standard_error")
    given = {name: known(row[name]) for name in numbers}
    return Constant(row["constant"], meaning, verdict=row["verdict"], **given)
