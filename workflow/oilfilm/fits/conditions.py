"""Which conditions a fit follows by exponents, and where the others were tested.

A condition that did not vary gives no exponent: it has a tested level. Conditions that varied in
step, as a load that was raised together with the speed, cannot have an exponent each. Some of them
are followed. The others are functions of the followed ones along the tested line. Away from the
tested level or line mu is not known.

Decides: which conditions give exponents, and where mu is refused because a condition did not vary
alone.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from pydantic import TypeAdapter, ValidationError

from oilfilm import tables
from oilfilm.base.errors import OilfilmError
from oilfilm.base.levels import level_indices
from oilfilm.base.ties import exceeds, reaches
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.settings.config import FitSettings, SameConditionSettings
from oilfilm.traction.law import QUANTITIES

# Least magnitude of a condition, in the unit of its column, where a range is stated as a share of
# the magnitude. Near 0 degC a share of the temperature would mean nothing: with this, 10 % are 2 K
# or more.
LEAST_MAGNITUDES = {"inlet_temperature_c": 20.0}


@dataclass(frozen=True)
class StepPartner:
    """A followed condition with which a fixed condition varied in step.

    Attributes:
        condition: Column of the followed condition.
        centre: Its geometric mean over the curves.
        exponent: The fixed condition is proportional to this power of it.
    """

    condition: str
    centre: float
    exponent: float


@dataclass(frozen=True)
class FixedCondition:
    """A condition that a fit does not follow: the level or the line on which it was tested.

    Attributes:
        condition: Column of the condition.
        level: Its value where the conditions of `in_step` are at their centre; None where it was
            not measured in every run, or where `line_reaches_zero`.
        within: Largest relative distance from the level or line at which mu is still known.
        in_step: The followed conditions with which it varied in step, each with its exponent; empty
            where it did not vary, and where `line_reaches_zero`.
        line_reaches_zero: Whether it varied in step, and a temperature reached 0 degC. The line is
            a power law, which has no value there.
    """

    condition: str
    level: float | None
    within: float
    in_step: tuple[StepPartner, ...] = ()
    line_reaches_zero: bool = False

    @property
    def is_unmeasured(self) -> bool:
        """Whether it was not measured in every run."""
        return self.level is None and not self.line_reaches_zero

    @property
    def varied_in_step(self) -> bool:
        """Whether it varied in step with followed conditions: it has no level of its own."""
        return bool(self.in_step) or self.line_reaches_zero

    def tested_value(self, values_by_condition: Mapping[str, FloatArray]) -> FloatArray:
        """Its tested value at given levels of the followed conditions; NaN where it is not known.

        Args:
            values_by_condition: Values of each condition by column, all of one shape.
        """
        level = np.nan if self.level is None else self.level
        value = np.full(np.shape(values_by_condition[self.condition]), level)
        for partner in self.in_step:
            value *= (values_by_condition[partner.condition] / partner.centre) ** partner.exponent
        return value

    def sentence(self) -> str:
        """Where it was tested, in words."""
        name = QUANTITIES[self.condition].short_meaning
        if self.line_reaches_zero:
            return (
                f"{name} varied in step with other conditions, and the line along which they "
                "varied is not known (a power law has no value at 0 degC and below)"
            )
        if self.level is None:
            return f"{name} is not known of every run"
        level = f"{self.level:.4g} {tables.unit_of(self.condition)}"
        within = f"(within {self.within:.1%})"
        if not self.in_step:
            return f"{name} was tested at {level} only {within}"
        partner_names = []
        powers = ""
        for partner in self.in_step:
            partner_name = QUANTITIES[partner.condition].short_meaning
            partner_names.append(partner_name)
            centre = f"{partner.centre:.4g} {tables.unit_of(partner.condition)}"
            powers += f" ({partner_name} / {centre})^{partner.exponent:.3g}"
        partners = " and ".join(partner_names)
        return f"{name} was tested in step with {partners} only: {level}{powers} {within}"


# Converts fixed conditions to plain values, and checks their JSON.
_FIXED_CONDITIONS = TypeAdapter(tuple[FixedCondition, ...])


def fixed_conditions_to_json(fixed_conditions: Sequence[FixedCondition]) -> str:
    """Fixed conditions as JSON, for the table `fit_quality`; empty where there are none."""
    return (
        json.dumps(_FIXED_CONDITIONS.dump_python(tuple(fixed_conditions)))
        if fixed_conditions
        else ""
    )


def fixed_conditions_from_json(json_text: str) -> tuple[FixedCondition, ...]:
    """Fixed conditions of a row of the table `fit_quality`.

    Raises:
        OilfilmError: The text is not one that `fixed_conditions_to_json` wrote.
    """
    if not json_text:
        return ()
    try:
        return _FIXED_CONDITIONS.validate_json(json_text)
    except ValidationError:
        raise OilfilmError(
            f"fit_quality: fixed_conditions holds {json_text[:60]!r}; expected the JSON of "
            "oilfilm's own fits. Refit with this version."
        ) from None


def followed_condition_mask(
    condition_names: Sequence[str], conditions: FloatArray, settings: FitSettings
) -> BoolArray:
    """Whether a fit follows each condition: it does if they varied enough, and independently.

    Of conditions that varied in step, the first ones in the law's order are followed.

    Args:
        condition_names: Columns of the conditions.
        conditions: Mean conditions of each curve, shape (curves, conditions).
        settings: `min_relative_range` and `smallest_singular_value`. Conditions are in step where
            the smallest singular value of their standardised logarithms, relative to the largest
            one, is not above `smallest_singular_value`. A temperature that reaches 0 degC enters
            without a logarithm, as in the exponential of a law.

    Returns:
        Shape (conditions,).
    """
    is_varied = varied_condition_mask(condition_names, conditions, settings)
    has_logarithm = np.all(conditions > 0, axis=0)
    condition_terms = np.log(conditions, out=conditions.copy(), where=has_logarithm)
    is_followed = np.zeros_like(is_varied)
    for condition_index in np.flatnonzero(is_varied):
        is_followed[condition_index] = True
        followed_terms = condition_terms[:, is_followed]
        standardised = (followed_terms - followed_terms.mean(axis=0)) / followed_terms.std(axis=0)
        singular_values = np.linalg.svd(standardised, compute_uv=False)
        # too few curves are one case of conditions in step
        too_few_curves = len(singular_values) < is_followed.sum()
        smallest_allowed = settings.smallest_singular_value * singular_values[0]
        is_followed[condition_index] = not too_few_curves and singular_values[-1] > smallest_allowed
    return is_followed


def varied_condition_mask(
    condition_names: Sequence[str], conditions: FloatArray, settings: FitSettings
) -> BoolArray:
    """Whether each condition is known of every curve and varied enough.

    Args:
        condition_names: Columns of the conditions.
        conditions: Mean conditions of each curve, shape (curves, conditions).
        settings: `min_relative_range`, the smallest range over the largest magnitude.

    Returns:
        Shape (conditions,).
    """
    if len(conditions) == 0:
        return np.zeros(conditions.shape[1], dtype=bool)
    smallest = conditions.min(axis=0)
    largest = conditions.max(axis=0)
    least_magnitude = [LEAST_MAGNITUDES.get(name, 0.0) for name in condition_names]
    magnitude = np.maximum(np.maximum(np.abs(smallest), np.abs(largest)), least_magnitude)
    is_wide = reaches(largest - smallest, settings.min_relative_range * magnitude)
    return np.asarray((largest > smallest) & is_wide)


def incomplete_curve_mask(
    condition_names: Sequence[str], conditions: FloatArray, settings: FitSettings
) -> BoolArray:
    """Whether each curve lacks a condition that varied over the others: no law can be fitted to it.

    Args:
        condition_names: Columns of the conditions.
        conditions: Mean conditions of each curve, shape (curves, conditions).
        settings: As in `varied_condition_mask`.

    Returns:
        Shape (curves,).
    """
    is_incomplete = np.zeros(len(conditions), dtype=bool)
    for condition_index, is_unknown in enumerate(np.isnan(conditions).T):
        if varied_condition_mask(condition_names, conditions[~is_unknown], settings)[
            condition_index
        ]:
            is_incomplete |= is_unknown
    return is_incomplete


def fixed_conditions(
    condition_names: Sequence[str],
    conditions: FloatArray,
    is_followed: BoolArray,
    settings: FitSettings,
) -> tuple[FixedCondition, ...]:
    """The level or line of each condition that is not followed.

    Args:
        condition_names: Columns of the conditions.
        conditions: Mean conditions of each curve, shape (curves, conditions).
        is_followed: As `followed_condition_mask` returns it.
        settings: As in `followed_condition_mask`, and `level_tolerance`.
    """
    is_varied = varied_condition_mask(condition_names, conditions, settings)
    values_of_followed = {}
    for condition_index in np.flatnonzero(is_followed).tolist():
        values_of_followed[condition_names[condition_index]] = conditions[:, condition_index]
    fixed = []
    for condition_index in np.flatnonzero(~is_followed).tolist():
        # a condition that did not vary has a level; one that varied has a line
        followed_values = values_of_followed if is_varied[condition_index] else {}
        fixed.append(
            _fixed_condition(
                condition_names[condition_index],
                conditions[:, condition_index],
                followed_values,
                settings,
            )
        )
    return tuple(fixed)


def _fixed_condition(
    condition_name: str,
    values: FloatArray,
    followed_values: Mapping[str, FloatArray],
    settings: FitSettings,
) -> FixedCondition:
    """The level or line of one condition.

    Args:
        condition_name: Column of the condition.
        values: Its value in each curve.
        followed_values: Values of the followed conditions with which it may be in step, by column;
            empty for a level.
        settings: `level_tolerance`, and those of `followed_condition_mask`.
    """
    if not len(values) or np.isnan(values).any():
        return FixedCondition(condition_name, None, 0.0)
    if followed_values and np.min([values, *followed_values.values()]) <= 0:
        # a line is a power law: it has no conditions at 0 or below, but may be one of the others
        followed_values = {
            name: partner_values
            for name, partner_values in followed_values.items()
            if partner_values.min() > 0
        }
        names = [*followed_values, condition_name]
        conditions = np.column_stack([*followed_values.values(), values])
        is_in_step = not followed_condition_mask(names, conditions, settings)[-1]
        if values.min() <= 0 or not followed_values or not is_in_step:
            return FixedCondition(condition_name, None, 0.0, line_reaches_zero=True)
    if followed_values:
        # a condition that moves the line by less than the tolerance is no part of it
        followed_values = {
            partner.condition: followed_values[partner.condition]
            for partner in _nearest_line(values, followed_values).in_step
            if _ln_range_along_line(partner, followed_values) > settings.level_tolerance
        }
    if followed_values:
        line = _nearest_line(values, followed_values)
    else:
        line = _Line(float(values.mean()), np.full(len(values), values.mean()), ())
    farthest = float(np.max(_relative_distance(condition_name, values, line.values)))
    return FixedCondition(
        condition_name, line.level, farthest + settings.level_tolerance, line.in_step
    )


@dataclass(frozen=True)
class _Line:
    """A fixed condition as a power law of followed conditions.

    Attributes:
        level: Its value where the followed conditions are at their centres.
        values: Its value in each curve by the power law, shape (curves,).
        in_step: The followed conditions and their exponents.
    """

    level: float
    values: FloatArray
    in_step: tuple[StepPartner, ...]


def _nearest_line(values: FloatArray, followed_values: Mapping[str, FloatArray]) -> _Line:
    """The power law of other conditions that is nearest to the values of a condition.

    Args:
        values: Value of the condition in each curve, shape (curves,).
        followed_values: Values of the other conditions by column.
    """
    log_values = np.log(list(followed_values.values()))
    centres = log_values.mean(axis=1, keepdims=True)
    design = np.vstack([np.ones(len(values)), log_values - centres]).T
    fitted_constants, *_ = np.linalg.lstsq(design, np.log(values))
    in_step = tuple(
        StepPartner(followed_name, float(np.exp(centre)), float(exponent))
        for followed_name, centre, exponent in zip(
            followed_values, centres[:, 0], fitted_constants[1:], strict=True
        )
    )
    return _Line(float(np.exp(fitted_constants[0])), np.exp(design @ fitted_constants), in_step)


def _ln_range_along_line(partner: StepPartner, followed_values: Mapping[str, FloatArray]) -> float:
    """Range over the curves of the logarithm of the line, by one of its conditions alone."""
    return float(abs(partner.exponent) * np.ptp(np.log(followed_values[partner.condition])))


def is_off_tested_level(
    fixed: FixedCondition, values_by_condition: Mapping[str, FloatArray]
) -> BoolArray:
    """Whether a condition is away from its tested level or line.

    An unknown value (NaN) counts as on the level.

    Args:
        fixed: The condition.
        values_by_condition: Values of each condition by column, all of one shape.
    """
    values = values_by_condition[fixed.condition]
    distance = _relative_distance(fixed.condition, values, fixed.tested_value(values_by_condition))
    return np.asarray(~np.isnan(values) & ~reaches(fixed.within, distance))


def _relative_distance(
    condition_name: str, values: FloatArray, tested_values: FloatArray
) -> FloatArray:
    """Distance of a condition's values from its tested values, over their magnitude."""
    magnitude = np.maximum(np.abs(tested_values), LEAST_MAGNITUDES.get(condition_name, 0.0))
    return np.asarray(np.abs(values - tested_values) / magnitude)


def condition_level_numbers(
    condition_name: str, values: FloatArray, same_condition: SameConditionSettings
) -> IndexArray:
    """Index of the level of each measured value of a condition, from 1, shape of the values.

    Args:
        condition_name: Column of the condition.
        values: Measured values. Unknown ones have the level 0.
        same_condition: Largest range of the values of one level, for each condition.
    """
    relative_width = {
        "max_hertz_pressure_gpa": same_condition.max_hertz_pressure,
        "load_n": same_condition.load,
        "entrainment_speed_m_s": same_condition.entrainment_speed,
    }
    if condition_name in relative_width:
        # the logarithm of 0, as of no load, is -inf: a level of its own
        with np.errstate(divide="ignore"):
            logarithms = np.log(values)
        return level_indices(logarithms, relative_width[condition_name])
    return level_indices(values, same_condition.inlet_temperature_c)


def level_numbers_by_gap(values: FloatArray, gap: float) -> IndexArray:
    """Index of the level of each measured value, 0 for the lowest level.

    Args:
        values: One per curve.
        gap: A new level begins where two neighbours differ by more than this share of the range.

    Returns:
        Shape (curves,); all 0 where a value is unknown.

    Examples:
        >>> level_numbers_by_gap(np.array([25.1, 119.8, 24.9, 70.0, 120.2]), gap=0.05)
        array([0, 2, 0, 1, 2])
    """
    if not len(values) or not np.isfinite(values).all():
        return np.zeros(len(values), dtype=np.int64)
    curves_by_value = np.argsort(values)
    steps = np.diff(values[curves_by_value], prepend=values.min())
    level_of_curve = np.empty(len(values), dtype=np.int64)
    level_of_curve[curves_by_value] = np.cumsum(exceeds(steps, gap * np.ptp(values)))
    return level_of_curve
