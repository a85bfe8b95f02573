"""The one description of an oil's fit from which every form of export is made."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.fitting.fitted import FittedLaw
from oilfilm.outputs.exports.json_format import ConstantFacts
from oilfilm.settings.resolved import Settings
from oilfilm.traction import expression
from oilfilm.traction.expression import Node
from oilfilm.traction.law import QUANTITIES, FloatArray, Law, to_internal

SLIP = "slide_roll_ratio"
SLIP_MEANING = "sliding speed over entrainment speed"
_PRESSURE = "max_hertz_pressure_gpa"
_LOAD = "load_n"
# Contacts whose load over the cube of the pressure differs less than this are one contact.
_SAME_CONTACT = 1e-6


@dataclass(frozen=True)
class Condition:
    """What the law's coefficients are power laws of: an argument where the data give exponents.

    Attributes:
        name: Column of the tables, with its unit; or a dimensionless group of the law.
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
        """As in the law's equation."""
        return QUANTITIES[self.name].symbol

    @property
    def unit(self) -> str:
        """Unit of every value here."""
        return QUANTITIES[self.name].unit

    @property
    def meaning(self) -> str:
        """What it is."""
        return QUANTITIES[self.name].meaning

    @property
    def relative(self) -> str:
        """Name of its value over the reference, in exported code."""
        return f"bar_{self.symbol.lower()}"


@dataclass(frozen=True)
class Description:
    """One oil's fit, with everything that its user must know.

    Attributes:
        oil: Name as in the configuration, untrusted.
        identifier: What stands for it in file names and identifiers.
        campaign: Name of the campaign.
        about: Its description.
        simulated: Whether the data are a rig twin's.
        fitted: The law with its constants.
        conditions: What the law's coefficients are power laws of, in the law's order.
        slip_upper: Largest |S| tested; None where nothing was accepted. |S| counts as tested from
            0, because traction is odd in S.
        constants: All constants, in the law's order.
        quality: The oil's row of the table `fit_quality`.
        adore_points: Operating points (by column) at which the ADORE form is wanted.
    """

    oil: str
    identifier: str
    campaign: str
    about: str
    simulated: bool
    fitted: FittedLaw
    conditions: tuple[Condition, ...]
    slip_upper: float | None
    constants: tuple[ConstantFacts, ...]
    quality: Mapping[str, Any]
    adore_points: tuple[Mapping[str, float], ...]

    @property
    def law(self) -> Law:
        """The law that was fitted."""
        return self.fitted.law

    @property
    def identity(self) -> dict[str, Any]:
        """What every row of a csv file says of where it comes from."""
        return {
            "oil": self.oil,
            "law": self.law.name,
            "campaign": self.campaign,
            "data": "simulated" if self.simulated else "measured",
            "certified": bool(self.quality["certified"]),
        }

    @property
    def arguments(self) -> tuple[Condition, ...]:
        """Conditions on which the fitted law depends."""
        return tuple(condition for condition in self.conditions if condition.argument)

    @property
    def fixed(self) -> tuple[Condition, ...]:
        """Conditions at whose tested level alone it is known."""
        return tuple(condition for condition in self.conditions if not condition.argument)

    @property
    def argument_names(self) -> list[str]:
        """Arguments of the exported functions."""
        return [*(condition.name for condition in self.arguments), SLIP]

    @property
    def argument_meanings(self) -> str:
        """The arguments before S in a few words: "pressure and speed"."""
        *first, last = (condition.meaning.partition(",")[0] for condition in self.arguments)
        return f"{', '.join(first)} and {last}" if first else last

    def power_law(self, conditions: Sequence[Condition]) -> str:
        """How the coefficients depend on these of the conditions."""
        powers = (
            f"({condition.symbol} / {condition.reference:g} {condition.unit})"
            f"^X{self.conditions.index(condition) + 1}"
            for condition in conditions
        )
        return f"X = X0 {' '.join(powers)} for X = {', '.join(self.law.local_constants)}"

    @property
    def obstacle(self) -> str:
        """Why no function of mu can be written; empty where one can."""
        lost = np.isnan(self.fitted.coefficients.constants).any()
        return str(self.quality["certificate"]) if lost else ""

    @property
    def coefficients(self) -> dict[str, str]:
        """Each coefficient as a product of powers of the arguments over their references."""
        blocks = self.fitted.coefficients.constants.reshape(len(self.law.coefficients), -1)
        products = {}
        for name, (factor, *exponents) in zip(self.law.local_constants, blocks, strict=True):
            powers = [
                f"{condition.relative}**{float(exponent)!r}"
                for condition, exponent in zip(self.conditions, exponents, strict=True)
                if condition.argument and exponent != 0
            ]
            products[name] = " * ".join([repr(float(factor)), *powers])
        return products

    @cached_property
    def steps(self) -> list[tuple[str, Node]]:
        """mu in straight-line form: name and value of each step from the arguments to "mu".

        mu is that of |S|; the last thing a function does is to give it the sign of S.
        """
        ratios = (
            (condition.relative, f"{condition.name}/{condition.reference!r}")
            for condition in self.arguments
        )
        steps = (*ratios, *self.coefficients.items(), ("S", f"abs({SLIP})"), *self.law.steps)
        return expression.parse_steps(steps, self.argument_names)

    def coefficients_at(self, groups: FloatArray) -> dict[str, float]:
        """The coefficients, with their signs, at one row of the law's groups."""
        law, known = self.law, self.fitted.coefficients.known
        relative = np.where(known, groups / np.array(law.reference), 1.0)
        design = np.concatenate([[1.0], np.log(relative)])[np.newaxis]
        internal = to_internal(law, self.fitted.coefficients.constants)
        sizes = law.sizes(internal, design)[:, 0]
        signs = (coefficient.sign for coefficient in law.coefficients)
        values = (float(size) * sign for size, sign in zip(sizes, signs, strict=True))
        return dict(zip(law.local_constants, values, strict=True))

    def outside(self, groups: FloatArray) -> bool:
        """Whether a row of the law's groups lies outside the tested box, whatever the slip."""
        return not all(
            condition.lower is not None
            and condition.upper is not None
            and condition.lower <= value <= condition.upper
            for condition, value in zip(self.conditions, groups, strict=True)
            if condition.argument
        )


def describe(
    oil: str,
    identifier: str,
    points: pd.DataFrame,
    coefficients: pd.DataFrame,
    quality: pd.DataFrame,
    law: Law,
    settings: Settings,
) -> Description:
    """Describe one oil's fit.

    Args:
        oil: The oil.
        identifier: What stands for it in identifiers (`names.identifiers`).
        points: Table of points of the campaign: what was tested.
        coefficients: Table of coefficients.
        quality: Table of fit quality.
        law: The fitted law.
        settings: `campaign` and `exports` of them.
    """
    campaign = settings.campaign
    asked = [point.model_dump() for point in settings.exports.adore_points]
    fitted = FittedLaw.of(coefficients, oil, quality=quality, law=law)
    rows = coefficients[(coefficients["oil"] == oil) & (coefficients["law"] == law.name)]
    (row,) = tables.rows(quality[(quality["oil"] == oil) & (quality["law"] == law.name)])
    accepted = points[(points["oil"] == oil) & points["accepted"]]
    meanings = _meanings(law)
    return Description(
        oil=oil,
        identifier=identifier,
        campaign=campaign.name,
        about=campaign.description,
        simulated=campaign.data == "simulated",
        fitted=fitted,
        conditions=_conditions(fitted, accepted),
        slip_upper=known(fitted.coefficients.box[-1, 1]),
        constants=tuple(_constant(row, meanings[row["constant"]]) for row in tables.rows(rows)),
        quality=row,
        adore_points=_with_load(asked, accepted),
    )


def _conditions(fitted: FittedLaw, accepted: pd.DataFrame) -> tuple[Condition, ...]:
    law = fitted.law
    names = list(law.groups)
    groups = law.group_values(accepted[list(law.conditions)].to_numpy(dtype=float))
    tested = pd.DataFrame(groups, columns=names, index=accepted.index)
    levels = tested.groupby(accepted["run_id"])[names].mean().mean(skipna=False)
    return tuple(
        Condition(
            name,
            reference,
            follows,
            None if follows else known(levels[name]),
            known(tested[name].min()),
            known(tested[name].max()),
        )
        for name, reference, follows in zip(
            names, law.reference, fitted.coefficients.known.tolist(), strict=True
        )
    )


def _with_load(
    asked: Sequence[Mapping[str, float]], accepted: pd.DataFrame
) -> tuple[Mapping[str, float], ...]:
    """Operating points with the load besides, where all points were measured in one contact.

    W goes with p_max^3 in a circular contact.
    """
    factors = (accepted[_LOAD] / accepted[_PRESSURE] ** 3).to_numpy(dtype=float)
    if not len(factors) or not np.ptp(factors) <= _SAME_CONTACT * factors.max():
        return tuple(asked)
    return tuple({**point, _LOAD: float(factors[0]) * point[_PRESSURE] ** 3} for point in asked)


def known(value: float) -> float | None:
    """The number as plain Python has it; None for NaN."""
    return None if np.isnan(value) else float(value)


def _meanings(law: Law) -> dict[str, str]:
    meanings = {}
    for name in law.local_constants:
        meanings[f"{name}0"] = f"{name} at the reference condition"
        meanings[name] = f"{name} at the level of what is fixed, at the reference of the rest"
        for number, group in enumerate(law.groups, 1):
            meanings[f"{name}{number}"] = f"exponent of {QUANTITIES[group].symbol} in {name}"
    return meanings


def _constant(row: Mapping[str, Any], meaning: str) -> ConstantFacts:
    return ConstantFacts(
        name=row["constant"],
        meaning=meaning,
        value=known(row["value"]),
        unit="1",
        standard_error=known(row["standard_error"]),
        interval_95=[known(row["lower"]), known(row["upper"])],
        systematic_standard_error=known(row["systematic_standard_error"]),
        verdict=row["verdict"],
    )
