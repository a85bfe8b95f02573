"""Which conditions a fit follows by exponents, and where the others were tested.

A condition that did not vary gives no exponent. Of conditions that varied in step only as many
give exponents as varied independently: these exponents hold along the tested line, on which the
others are functions of them. Away from that level or line mu is not known.

Decides: which conditions give exponents, and where mu is refused because a condition did not vary
alone.
"""

import itertools
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from pydantic import TypeAdapter, ValidationError

from oilfilm import tables
from oilfilm.base.errors import OilfilmError
from oilfilm.base.ties import exceeds, reaches
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.settings.config import FitSettings, SameConditionSettings
from oilfilm.traction.law import QUANTITIES

# A temperature near 0 degC is no measure of its own variation: 10 % are 2 K at least.
LEAST_SIZE = {"inlet_temperature_c": 20.0}


@dataclass(frozen=True)
class InStep:
    """A followed condition with which another one varied in step.

    Attributes:
        condition: Column of the followed condition.
        centre: Its geometric mean over the curves.
        exponent: The other one goes with this power of it.
    """

    condition: str
    centre: float
    exponent: float


@dataclass(frozen=True)
class FixedCondition:
    """A condition that a fit does not follow: the level or the line on which it was tested.

    Attributes:
        condition: Its column.
        level: Where the conditions of `in_step` are at their centre; None where it was not
            measured in every run.
        within: Largest relative distance from the level or line at which mu is known.
        in_step: The followed conditions with which it varied; empty where it did not vary.
    """

    condition: str
    level: float | None
    within: float
    in_step: tuple[InStep, ...] = ()

    def on_line(self, levels: Mapping[str, FloatArray]) -> FloatArray:
        """Its tested value at levels of the other conditions; NaN where it is not known.

        Args:
            levels: Values of each condition by column, all of one shape.
        """
        value = np.full_like(levels[self.condition], np.nan if self.level is None else self.level)
        for other in self.in_step:
            value *= (levels[other.condition] / other.centre) ** other.exponent
        return value

    def sentence(self) -> str:
        """Where it was tested, in words."""
        name = QUANTITIES[self.condition].short_meaning
        if self.level is None:
            return f"{name} is not known of every run"
        level = f"{self.level:.4g} {tables.unit_of(self.condition)}"
        others, powers = [], ""
        for other in self.in_step:
            others.append(QUANTITIES[other.condition].short_meaning)
            base = f"{others[-1]} / {other.centre:.4g} {tables.unit_of(other.condition)}"
            powers += f" ({base})^{other.exponent:.3g}"
        where = f"in step with {' and '.join(others)} only:" if others else "at"
        only = "" if others else " only"
        return f"{name} was tested {where} {level}{powers}{only} (within {self.within:.1%})"


_FIXED = TypeAdapter(tuple[FixedCondition, ...])


def to_text(fixed: Sequence[FixedCondition]) -> str:
    """Fixed conditions as the table of fit quality has them: JSON, empty where there are none."""
    return json.dumps(_FIXED.dump_python(tuple(fixed))) if fixed else ""


def from_text(text: str) -> tuple[FixedCondition, ...]:
    """Fixed conditions of a row of the table of fit quality.

    Raises:
        OilfilmError: The text is not one that `to_text` wrote.
    """
    if not text:
        return ()
    try:
        return _FIXED.validate_json(text)
    except ValidationError:
        raise OilfilmError(
            f"fit_quality: fixed_conditions holds {text[:60]!r}; expected the JSON of oilfilm's "
            "own fits. Refit with this version."
        ) from None


def followed_conditions(
    names: Sequence[str], conditions: FloatArray, settings: FitSettings
) -> BoolArray:
    """Which conditions a fit follows: those that varied enough, and independently.

    Of conditions that varied in step the first ones in the law's order are followed.

    Args:
        names: Columns of the conditions.
        conditions: One row per curve.
        settings: `min_relative_range` and `smallest_singular_value`, below which conditions are
            in step: of their standardised logarithms, relative to the largest.
    """
    enough = varied(names, conditions, settings)
    # a law says in words that its power laws have no value at zero or below
    if np.any(conditions[:, enough] <= 0):
        return enough
    followed = np.zeros_like(enough)
    for index in np.flatnonzero(enough):
        followed[index] = True
        logs = np.log(conditions[:, followed])
        standardised = (logs - logs.mean(axis=0)) / logs.std(axis=0)
        sizes = np.linalg.svd(standardised, compute_uv=False)
        # too few curves are one case of conditions in step
        too_few = len(sizes) < followed.sum()
        followed[index] = not too_few and sizes[-1] > settings.smallest_singular_value * sizes[0]
    return followed


def varied(
    names: Sequence[str], conditions: FloatArray, settings: FitSettings
) -> npt.NDArray[np.bool_]:
    """Which conditions are known of every curve and varied enough.

    Args:
        names: Columns of the conditions.
        conditions: One row per curve.
        settings: `min_relative_range`, the smallest range over the largest magnitude.
    """
    if len(conditions) == 0:
        return np.zeros(conditions.shape[1], dtype=bool)
    low, high = conditions.min(axis=0), conditions.max(axis=0)
    size = np.maximum(np.abs(low), np.abs(high))
    size = np.maximum(size, [LEAST_SIZE.get(name, 0.0) for name in names])
    wide = reaches(high - low, settings.min_relative_range * size)
    return np.asarray((high > low) & wide)


def incomplete_curves(
    names: Sequence[str], conditions: FloatArray, settings: FitSettings
) -> BoolArray:
    """Curves that lack a condition which varied over the others: no law can follow them.

    Args:
        names: Columns of the conditions.
        conditions: One row per curve.
        settings: As `varied`.
    """
    lacking = np.zeros(len(conditions), dtype=bool)
    for index, unknown in enumerate(np.isnan(conditions).T):
        if varied(names, conditions[~unknown], settings)[index]:
            lacking |= unknown
    return lacking


def fixed_conditions(
    names: Sequence[str], conditions: FloatArray, followed: BoolArray, settings: FitSettings
) -> tuple[FixedCondition, ...]:
    """The level or line of each condition that is not followed.

    Args:
        names: Columns of the conditions.
        conditions: One row per curve.
        followed: As `followed_conditions`.
        settings: As there, and `level_tolerance`.
    """
    moving = dict(zip(names, varied(names, conditions, settings), strict=True))
    columns = dict(zip(names, conditions.T, strict=True))
    along = {name: columns[name] for name in itertools.compress(names, followed)}
    return tuple(
        _fixed(name, columns[name], along if moving[name] else {}, settings)
        for name in itertools.compress(names, ~followed)
    )


def _fixed(
    name: str, values: FloatArray, along: Mapping[str, FloatArray], settings: FitSettings
) -> FixedCondition:
    if not len(values) or np.isnan(values).any():
        return FixedCondition(name, None, 0.0)
    if along:
        *_, in_step = _line(values, along)
        # what moves the line by less than its tolerance is no part of it
        along = {
            other: levels
            for (other, levels), power in zip(along.items(), in_step, strict=True)
            if abs(power.exponent) * np.ptp(np.log(levels)) > settings.level_tolerance
        }
    level, line, in_step = _line(values, along) if along else (values.mean(), values.mean(), ())
    within = float(np.max(_relative_distance(name, values, line))) + settings.level_tolerance
    return FixedCondition(name, float(level), within, in_step)


def _line(
    values: FloatArray, along: Mapping[str, FloatArray]
) -> tuple[float, FloatArray, tuple[InStep, ...]]:
    """The nearest power law of other conditions: value at their centres, values, powers."""
    logs = np.log(list(along.values()))
    centres = logs.mean(axis=1, keepdims=True)
    design = np.vstack([np.ones(len(values)), logs - centres]).T
    solution, *_ = np.linalg.lstsq(design, np.log(values))
    in_step = tuple(
        InStep(other, float(np.exp(centre)), float(exponent))
        for other, centre, exponent in zip(along, centres[:, 0], solution[1:], strict=True)
    )
    return float(np.exp(solution[0])), np.exp(design @ solution), in_step


def away(fixed: FixedCondition, levels: Mapping[str, FloatArray]) -> npt.NDArray[np.bool_]:
    """True where a condition lies away from its tested level or line; NaN stands for the line.

    Args:
        fixed: The condition.
        levels: Values of each condition by column, all of one shape.
    """
    asked = levels[fixed.condition]
    distance = _relative_distance(fixed.condition, asked, fixed.on_line(levels))
    return np.asarray(~np.isnan(asked) & ~reaches(fixed.within, distance))


def _relative_distance(name: str, values: FloatArray, line: FloatArray) -> FloatArray:
    return np.asarray(np.abs(values - line) / np.maximum(np.abs(line), LEAST_SIZE.get(name, 0.0)))


def clusters(values: FloatArray, width: float) -> IndexArray:
    """Clusters of values no wider than `width`, counted from 0; unknown values are one of them.

    Examples:
        >>> clusters(np.array([0.101, 0.02, 0.099, 0.021, np.nan]), 0.006)
        array([2, 1, 2, 1, 0])
    """
    clusters = np.zeros(len(values), dtype=np.int64)
    first, number = -np.inf, 0
    known = np.flatnonzero(~np.isnan(values))
    for index in known[np.argsort(values[known], kind="stable")]:
        if exceeds(values[index] - first, width):
            first, number = values[index], number + 1
        clusters[index] = number
    return clusters


def levels_of(name: str, values: FloatArray, same: SameConditionSettings) -> IndexArray:
    """Level of each measured value of a condition.

    Args:
        name: Column of the condition.
        values: Measured values; unknown ones are one level.
        same: Largest range of the values of one level.
    """
    relative = {
        "max_hertz_pressure_gpa": same.max_hertz_pressure,
        "load_n": same.load,
        "entrainment_speed_m_s": same.entrainment_speed,
    }
    if name in relative:
        return clusters(np.log(values), relative[name])
    return clusters(values, same.inlet_temperature_c)


def levels_by_gap(values: FloatArray, gap: float) -> IndexArray:
    """Levels among measured values, counted from 0 for the lowest.

    Args:
        values: One per curve.
        gap: A new level begins where two neighbours differ by more than this share of the range.

    Returns:
        Level of each value; all 0 where a value is unknown.

    Examples:
        >>> levels_by_gap(np.array([25.1, 119.8, 24.9, 70.0, 120.2]), gap=0.05)
        array([0, 2, 0, 1, 2])
    """
    if not np.isfinite(values).all():
        return np.zeros(len(values), dtype=np.int64)
    order = np.argsort(values)
    steps = np.diff(values[order], prepend=values.min())
    levels = np.empty(len(values), dtype=np.int64)
    levels[order] = np.cumsum(exceeds(steps, gap * np.ptp(values)))
    return levels
