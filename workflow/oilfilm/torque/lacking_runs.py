"""Runs that a campaign lacks before its law can be judged: at further levels and at corners.

Two levels of a condition do not show whether a law bends between them. 24 runs at three pressures,
four speeds and six temperatures give a relative error of mu of 0.050, 24 runs at eight conditions,
three at each, one of 0.158 (95 % quantiles at new conditions, eleven oils). Near a missing corner
of the tested box a surface extrapolates.

Distances are those of the scaled conditions (`oilfilm.surface.measurements`): ln P, ln U and T.

Decides: which levels of a condition are missing, and which runs supply them; which conditions a
first plan has.
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from oilfilm.base.ties import exceeds, first_largest, first_smallest
from oilfilm.base.units import BoolArray, FloatArray
from oilfilm.surface.measurements import (
    LevelWidths,
    level_numbers,
    scaled_conditions,
    unscaled_conditions,
)
from oilfilm.traction.law import CONDITIONS

# Function that returns which of some conditions a rig can run: shape (runs, 3) to (runs,).
CanRun = Callable[[FloatArray], BoolArray]
# Levels of pressure, speed and temperature of a first plan. Each pair of pressure and speed is run
# at two temperatures: 24 runs. The mean of the relative error of mu of eleven oils is 0.027 with
# them. It is 0.031 with the eight corners and 16 conditions that are farthest from them and from
# each other.
_FIRST_LEVELS = (3, 4, 6)
_TEMPERATURES_PER_PAIR = 2
# Digits of a new level. Rounding moves it by less than the width of a level.
_SIGNIFICANT_DIGITS = 3


@dataclass(frozen=True)
class PlannedRun:
    """A run of a plan.

    Attributes:
        conditions: P in GPa, U in m/s and T in degC, shape (3,).
        reason: Code of the reason, one of the column `run_reason` of the table `run_plan`.
        new_levels: Names of the conditions that have a new level in the run.
    """

    conditions: FloatArray
    reason: str
    new_levels: tuple[str, ...] = ()


@dataclass(frozen=True)
class ConditionLevels:
    """Distinct conditions of a campaign, and the levels of P, U and T that they have.

    Attributes:
        conditions: P in GPa, U in m/s and T in degC, different ones, sorted, shape (conditions, 3).
        levels_of_condition: Levels of P, of U and of T, rising.
        level_widths: Largest range of the values of one level.
    """

    conditions: FloatArray
    levels_of_condition: tuple[FloatArray, ...]
    level_widths: LevelWidths

    @classmethod
    def from_conditions(
        cls, conditions: FloatArray, level_widths: LevelWidths
    ) -> "ConditionLevels":
        """The levels of conditions in any order, of which some may be equal."""
        conditions = distinct_conditions(conditions, level_widths)
        levels_of_condition = []
        level_numbers_of_conditions = level_numbers(scaled_conditions(conditions), level_widths)
        for values_of_condition, level_number_of_value in zip(
            conditions.T, level_numbers_of_conditions.T, strict=True
        ):
            levels = [
                np.median(values_of_condition[level_number_of_value == level_number])
                for level_number in np.unique(level_number_of_value)
            ]
            levels_of_condition.append(np.array(levels))
        return cls(conditions, tuple(levels_of_condition), level_widths)

    @property
    def is_constant(self) -> BoolArray:
        """Which of P, U and T were not varied, or too little for a level between, shape (3,)."""
        span = np.ptp(scaled_conditions(np.stack([self.lowest, self.highest])), axis=0)
        return ~_is_wider(span, 2 * self.level_widths.scaled())

    @property
    def has_two_levels(self) -> BoolArray:
        """Which of P, U and T have two levels, shape (3,)."""
        level_counts = np.array([len(levels) for levels in self.levels_of_condition])
        return (level_counts == 2) & ~self.is_constant

    @property
    def lowest(self) -> FloatArray:
        """Lowest P, U and T, shape (3,)."""
        return np.array([levels[0] for levels in self.levels_of_condition])

    @property
    def highest(self) -> FloatArray:
        """Highest P, U and T, shape (3,)."""
        return np.array([levels[-1] for levels in self.levels_of_condition])

    @property
    def middle(self) -> FloatArray:
        """P, U and T in the middle of the box, shape (3,)."""
        middle_values = []
        for condition_index, levels in enumerate(self.levels_of_condition):
            _, middle_value, _ = evenly_spaced_values(levels[0], levels[-1], 3, condition_index)
            middle_values.append(middle_value)
        return np.array(middle_values)

    def nearest(
        self, target_conditions: FloatArray, is_allowed: BoolArray, is_compared: BoolArray
    ) -> FloatArray:
        """The condition that is nearest to a target, shape (3,); of equal ones the first.

        Args:
            target_conditions: P, U and T, shape (3,).
            is_allowed: Which conditions may be returned, shape (conditions,).
            is_compared: Over which of P, U and T the distance is taken, shape (3,).
        """
        scaled = scaled_conditions(self.conditions)
        span = np.maximum(np.ptp(scaled, axis=0), self.level_widths.scaled())
        scaled_distance = (scaled - scaled_conditions(target_conditions[np.newaxis])) / span
        distance = np.sum(scaled_distance[:, is_compared] ** 2, axis=1)
        nearest_index = int(first_smallest(np.where(is_allowed, distance, np.inf)))
        return np.asarray(self.conditions[nearest_index])

    def has_level(self, condition_index: int, level: float) -> BoolArray:
        """Which conditions have a level of P, U or T, shape (conditions,).

        Args:
            condition_index: Column of the condition: 0 for P, 1 for U, 2 for T.
            level: The level.
        """
        target_conditions = self.conditions.copy()
        target_conditions[:, condition_index] = level
        scaled_distance = scaled_conditions(self.conditions) - scaled_conditions(target_conditions)
        width = self.level_widths.scaled()[condition_index]
        return ~_is_wider(scaled_distance[:, condition_index], width)


def _is_wider(scaled_distance: FloatArray, width: FloatArray) -> BoolArray:
    """Whether scaled distances are larger than a width, by more than rounding."""
    # scaled conditions are of the size of 1
    return exceeds(np.abs(scaled_distance), width, term_size=1.0)


def distinct_conditions(conditions: FloatArray, level_widths: LevelWidths) -> FloatArray:
    """Different conditions, sorted by value, shape (conditions, 3).

    Of those that have the same levels the first one is taken.
    """
    sorted_conditions = conditions[np.lexsort(conditions.T[::-1])]
    level_numbers_of_conditions = level_numbers(scaled_conditions(sorted_conditions), level_widths)
    _, first_index = np.unique(level_numbers_of_conditions, axis=0, return_index=True)
    return sorted_conditions[np.sort(first_index)]


def is_among(
    conditions: FloatArray, listed_conditions: FloatArray, level_widths: LevelWidths
) -> BoolArray:
    """Which conditions are the same as one of the others, shape (conditions,)."""
    if not len(listed_conditions):
        return np.zeros(len(conditions), dtype=bool)
    scaled = scaled_conditions(conditions)
    scaled_listed = scaled_conditions(listed_conditions)
    # the nearest by the widths of a level is the same if any is; all pairs of a large campaign do
    # not fit into memory
    widths = level_widths.scaled()
    tree = scipy.spatial.cKDTree(scaled_listed / widths)
    _, nearest_index = tree.query(scaled / widths, p=np.inf)
    return np.all(~_is_wider(scaled - scaled_listed[nearest_index], widths), axis=1)


def evenly_spaced_values(
    lowest: float, highest: float, value_count: int, condition_index: int
) -> FloatArray:
    """Values of P, U or T at equal distances in its scale, shape (count,).

    Those between the ends have three significant digits, as a set point may have.

    Args:
        lowest: First value.
        highest: Last value.
        value_count: Number of values, the ends among them.
        condition_index: Column of the condition: 0 for P, 1 for U, 2 for T.

    Examples:
        >>> evenly_spaced_values(25, 40, 3, CONDITIONS.index("entrainment_speed_m_s"))
        array([25. , 31.6, 40. ])
    """
    ends = np.ones((2, len(CONDITIONS)))
    ends[:, condition_index] = lowest, highest
    scaled_lowest, scaled_highest = scaled_conditions(ends)
    scaled = np.linspace(scaled_lowest, scaled_highest, value_count)
    values = unscaled_conditions(scaled)[:, condition_index]
    rounded_values = [float(f"{value:.{_SIGNIFICANT_DIGITS}g}") for value in values[1:-1]]
    return np.array([lowest, *rounded_values, highest], dtype=float)


def lacking_runs(
    conditions: FloatArray,
    levels_to_choose: Sequence[Sequence[float]],
    can_run: CanRun,
    level_widths: LevelWidths,
) -> list[PlannedRun]:
    """The runs that a campaign lacks: levels of a condition, then corners of the box.

    Some of them may be beyond the limits of the rig.

    Args:
        conditions: Conditions that are tested, or will be, shape (runs, 3).
        levels_to_choose: Levels of P, U and T. New levels of a condition that was not varied are
            chosen among them.
        can_run: Which conditions the rig can run.
        level_widths: Largest range of the values of one level.
    """
    tested_levels = ConditionLevels.from_conditions(conditions, level_widths)
    runs = _third_level_runs(tested_levels)
    runs += _runs_of_constant_conditions(tested_levels, levels_to_choose, can_run)
    extended_conditions = tested_levels.conditions
    for run in runs:
        conditions_of_run = run.conditions[np.newaxis]
        if can_run(conditions_of_run).all():
            extended_conditions = np.concatenate([extended_conditions, conditions_of_run])
    runs += _corner_runs(ConditionLevels.from_conditions(extended_conditions, level_widths))
    return _new_runs(runs, tested_levels)


def _new_runs(runs: list[PlannedRun], tested_levels: ConditionLevels) -> list[PlannedRun]:
    """The runs at conditions that neither were tested nor occur before in the list."""
    new_runs = []
    seen_conditions = tested_levels.conditions
    for run in runs:
        conditions_of_run = run.conditions[np.newaxis]
        if not is_among(conditions_of_run, seen_conditions, tested_levels.level_widths).any():
            new_runs.append(run)
            seen_conditions = np.concatenate([seen_conditions, conditions_of_run])
    return new_runs


def _third_level_runs(tested_levels: ConditionLevels) -> list[PlannedRun]:
    """Runs at the level between two levels: the centre of the box, and the centre of each face.

    Conditions with two levels are at the middle of their scale. The others are as in a tested
    condition, so that only the level between is new.
    """
    has_two_levels = tested_levels.has_two_levels
    if not has_two_levels.any():
        return []
    middle_of_box = tested_levels.middle
    is_allowed_everywhere = np.ones(len(tested_levels.conditions), dtype=bool)
    runs = [_run_at_middle(tested_levels, middle_of_box, has_two_levels, is_allowed_everywhere)]
    for condition_index in np.flatnonzero(~tested_levels.is_constant).tolist():
        is_between = has_two_levels.copy()
        is_between[condition_index] = False
        if not is_between.any():
            continue
        for box_end in (tested_levels.lowest, tested_levels.highest):
            target_conditions = middle_of_box.copy()
            target_conditions[condition_index] = box_end[condition_index]
            on_face = tested_levels.has_level(condition_index, box_end[condition_index])
            runs.append(_run_at_middle(tested_levels, target_conditions, is_between, on_face))
    return runs


def _run_at_middle(
    tested_levels: ConditionLevels,
    target_conditions: FloatArray,
    is_between: BoolArray,
    is_allowed: BoolArray,
) -> PlannedRun:
    """A run with some conditions as in the target, and the others as in the nearest tested one."""
    conditions = target_conditions
    if not is_between.all():
        nearest = tested_levels.nearest(target_conditions, is_allowed, ~is_between)
        conditions = np.where(is_between, target_conditions, nearest)
    return PlannedRun(conditions, "third_level", _condition_names(is_between))


def _condition_names(is_chosen: BoolArray) -> tuple[str, ...]:
    """Names of the chosen conditions."""
    return tuple(CONDITIONS[condition_index] for condition_index in np.flatnonzero(is_chosen))


def _runs_of_constant_conditions(
    tested_levels: ConditionLevels, levels_to_choose: Sequence[Sequence[float]], can_run: CanRun
) -> list[PlannedRun]:
    """Runs at two more levels of each condition that was not varied.

    They are at tested values of the other conditions: in the middle and at their ends.
    """
    runs = []
    central_conditions = _central_conditions(tested_levels)
    for condition_index in np.flatnonzero(tested_levels.is_constant).tolist():
        is_new = np.arange(len(CONDITIONS)) == condition_index
        for new_level in _two_levels(
            tested_levels, condition_index, levels_to_choose[condition_index], can_run
        ):
            for central_condition in central_conditions:
                conditions = np.where(is_new, new_level, central_condition)
                runs.append(PlannedRun(conditions, "not_varied", _condition_names(is_new)))
    return runs


def _central_conditions(tested_levels: ConditionLevels) -> list[FloatArray]:
    """The tested conditions nearest to the middle of the box, and to that of each face."""
    all_conditions = np.ones(len(CONDITIONS), dtype=bool)
    is_allowed_everywhere = np.ones(len(tested_levels.conditions), dtype=bool)
    central_conditions = [
        tested_levels.nearest(tested_levels.middle, is_allowed_everywhere, all_conditions)
    ]
    for condition_index in np.flatnonzero(~tested_levels.is_constant).tolist():
        for box_end in (tested_levels.lowest, tested_levels.highest):
            on_face = tested_levels.has_level(condition_index, box_end[condition_index])
            central_conditions.append(
                tested_levels.nearest(tested_levels.middle, on_face, all_conditions)
            )
    return central_conditions


def _two_levels(
    tested_levels: ConditionLevels,
    condition_index: int,
    levels_to_choose: Sequence[float],
    can_run: CanRun,
) -> list[float]:
    """Two new levels of a condition that has only one.

    They are the ends of the levels that can be run. If the tested level is near an end itself, they
    are the other end and the level in the middle between both. A level can be run if the rig can
    run it at all corners of the other conditions. There may be fewer than two.
    """
    tested_level = float(np.median(tested_levels.levels_of_condition[condition_index]))
    corners = corners_of(tested_levels.lowest, tested_levels.highest)
    possible_levels = [tested_level]
    for level in levels_to_choose:
        corners[:, condition_index] = level
        if can_run(corners).all():
            possible_levels.append(level)
    lowest, highest = min(possible_levels), max(possible_levels)
    _, middle_level, _ = evenly_spaced_values(lowest, highest, 3, condition_index)
    if tested_level < middle_level:
        nearer_end, farther_end = lowest, highest
    else:
        nearer_end, farther_end = highest, lowest
    # a tested level in the outer quarter is an end itself
    _, quarter_level, _ = evenly_spaced_values(nearer_end, middle_level, 3, condition_index)
    if abs(tested_level - nearer_end) <= abs(quarter_level - nearer_end):
        _, middle_level, _ = evenly_spaced_values(tested_level, farther_end, 3, condition_index)
        chosen_levels = [middle_level, farther_end]
    else:
        chosen_levels = [nearer_end, farther_end]
    return [
        level
        for level in chosen_levels
        if not tested_levels.has_level(condition_index, level).any()
    ]


def _corner_runs(levels: ConditionLevels) -> list[PlannedRun]:
    """Runs at the corners of the box."""
    return [PlannedRun(corner, "corner") for corner in corners_of(levels.lowest, levels.highest)]


def corners_of(lowest: FloatArray, highest: FloatArray) -> FloatArray:
    """The corners of a box of conditions, shape (8, 3)."""
    return np.array(list(itertools.product(*np.stack([lowest, highest], axis=1))))


def first_runs(
    levels_to_choose: Sequence[Sequence[float]], can_run: CanRun, level_widths: LevelWidths
) -> list[PlannedRun]:
    """24 runs for a campaign without data: at three pressures, four speeds and six temperatures.

    They are fewer where there is only one level of a condition to choose from.

    The levels are equally spaced in the scale of the conditions, over the largest box among the
    levels to choose from whose corners the rig can run. Where it can run no such corner, they are
    spaced over all levels: the limits that these runs are beyond tell why.

    Args:
        levels_to_choose: Levels of P, U and T.
        can_run: Which conditions the rig can run.
        level_widths: Largest range of the values of one level.
    """
    range_of_condition = _largest_box(levels_to_choose, can_run, level_widths)
    levels_of_condition = []
    for condition_index, (lowest, highest) in enumerate(range_of_condition):
        levels_of_condition.append(
            evenly_spaced_values(lowest, highest, _FIRST_LEVELS[condition_index], condition_index)
        )
    pressures, speeds, temperatures = levels_of_condition
    temperature_step = len(temperatures) // _TEMPERATURES_PER_PAIR
    conditions_of_runs = []
    for pressure_index, pressure in enumerate(pressures):
        for speed_index, speed in enumerate(speeds):
            for step_index in range(_TEMPERATURES_PER_PAIR):
                temperature_index = (
                    pressure_index + speed_index + step_index * temperature_step
                ) % len(temperatures)
                conditions_of_runs.append((pressure, speed, temperatures[temperature_index]))
    return [
        PlannedRun(conditions, "first_plan")
        for conditions in distinct_conditions(np.array(conditions_of_runs), level_widths)
    ]


def _largest_box(
    levels_to_choose: Sequence[Sequence[float]], can_run: CanRun, level_widths: LevelWidths
) -> list[tuple[float, float]]:
    """The largest box among levels whose corners can be run; that of all levels if none can.

    Each limit of a rig is one of a quantity that rises or falls with P, with U and with T. So all
    conditions between corners that can be run can be run.

    Returns:
        Lowest and highest P, U and T.
    """
    all_conditions = np.array(list(itertools.product(*levels_to_choose)))
    level_counts = tuple(len(levels) for levels in levels_to_choose)
    is_runnable = can_run(all_conditions).reshape(level_counts)
    scaled_levels = scaled_conditions(all_conditions).reshape(*level_counts, len(CONDITIONS))
    pressure_count, speed_count, temperature_count = level_counts
    lowest_pressure, highest_pressure = np.triu_indices(pressure_count)
    lowest_speed, highest_speed = np.triu_indices(speed_count)
    # at which temperatures all four pairs of a range of P and a range of U can be run
    is_possible = np.logical_and.reduce(
        [
            is_runnable[pressure_index][:, speed_index]
            for pressure_index in (lowest_pressure, highest_pressure)
            for speed_index in (lowest_speed, highest_speed)
        ]
    )
    if not is_possible.any():
        is_possible[:] = True
    lowest_temperature = is_possible.argmax(axis=2)
    highest_temperature = temperature_count - 1 - is_possible[:, :, ::-1].argmax(axis=2)
    lowest = scaled_levels[lowest_pressure[:, np.newaxis], lowest_speed, lowest_temperature]
    highest = scaled_levels[highest_pressure[:, np.newaxis], highest_speed, highest_temperature]
    volume = np.prod(highest - lowest + level_widths.scaled(), axis=2)
    volume = np.where(is_possible.any(axis=2), volume, 0.0)
    pressure_range, speed_range = np.unravel_index(int(first_largest(volume.ravel())), volume.shape)
    index_ranges = [
        (lowest_pressure[pressure_range], highest_pressure[pressure_range]),
        (lowest_speed[speed_range], highest_speed[speed_range]),
        (
            lowest_temperature[pressure_range, speed_range],
            highest_temperature[pressure_range, speed_range],
        ),
    ]
    return [
        (levels[lowest_index], levels[highest_index])
        for levels, (lowest_index, highest_index) in zip(
            levels_to_choose, index_ranges, strict=True
        )
    ]
