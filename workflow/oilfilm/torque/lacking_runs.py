"""Conditions that a campaign lacks before its law can be judged: levels between, levels, corners.

Two levels of a condition do not show whether a law bends between them. The same 24 runs give an
error of mu of 0.050 on three pressures, four speeds and six temperatures, and of 0.158 on eight
conditions three times. Near a missing corner of the tested box a surface extrapolates.

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

# Whether a rig can run each of some conditions, shape (runs, 3) to (runs,).
Runnable = Callable[[FloatArray], BoolArray]
# Levels of pressure, speed and temperature of a first plan. Each pair of pressure and speed is run
# at two temperatures: 24 runs. The mean error of mu of eleven oils is 0.027 with them. It is 0.031
# with the eight corners and 16 conditions that are farthest from them and from each other.
_FIRST_LEVELS = (3, 4, 6)
_TEMPERATURES_PER_PAIR = 2
# Digits of a new level, less than the width of a level.
_DIGITS = 3
# Scaled range of one level of P, U and T.
_LEVEL_WIDTHS = LevelWidths().scaled()


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
class Levels:
    """Conditions of a campaign, and the levels that they have.

    Attributes:
        conditions: P in GPa, U in m/s and T in degC, different ones, sorted, shape (conditions, 3).
        values: Levels of P, of U and of T, rising.
    """

    conditions: FloatArray
    values: tuple[FloatArray, ...]

    @classmethod
    def from_conditions(cls, conditions: FloatArray) -> "Levels":
        """The levels of conditions in any order, of which some may be equal."""
        conditions = distinct(conditions)
        values = []
        level_numbers_of_rows = level_numbers(scaled_conditions(conditions), LevelWidths())
        for column, level_of_row in zip(conditions.T, level_numbers_of_rows.T, strict=True):
            values.append(
                np.array(
                    [np.median(column[level_of_row == level]) for level in np.unique(level_of_row)]
                )
            )
        return cls(conditions, tuple(values))

    @property
    def is_constant(self) -> BoolArray:
        """Which of P, U and T were not varied, or too little for a level between, shape (3,)."""
        span = np.ptp(scaled_conditions(np.stack([self.lowest, self.highest])), axis=0)
        return ~_is_wider(span, 2 * _LEVEL_WIDTHS)

    @property
    def has_two_levels(self) -> BoolArray:
        """Which of P, U and T have two levels, shape (3,)."""
        counts = np.array([len(values) for values in self.values])
        return (counts == 2) & ~self.is_constant

    @property
    def lowest(self) -> FloatArray:
        """Lowest P, U and T, shape (3,)."""
        return np.array([values[0] for values in self.values])

    @property
    def highest(self) -> FloatArray:
        """Highest P, U and T, shape (3,)."""
        return np.array([values[-1] for values in self.values])

    @property
    def middle(self) -> FloatArray:
        """P, U and T in the middle of the box, shape (3,)."""
        middle_values = []
        for dimension, values in enumerate(self.values):
            _, middle_value, _ = evenly_spaced_values(values[0], values[-1], 3, dimension)
            middle_values.append(middle_value)
        return np.array(middle_values)

    def nearest(
        self, target: FloatArray, may_be_taken: BoolArray, is_compared: BoolArray
    ) -> FloatArray:
        """The condition that is nearest to a target, shape (3,); of equal ones the first.

        Args:
            target: P, U and T, shape (3,).
            may_be_taken: Which conditions may be taken, shape (conditions,).
            is_compared: Over which of P, U and T the distance is taken, shape (3,).
        """
        scaled = scaled_conditions(self.conditions)
        span = np.maximum(np.ptp(scaled, axis=0), _LEVEL_WIDTHS)
        scaled_distance = (scaled - scaled_conditions(target[np.newaxis])) / span
        distance = np.sum(scaled_distance[:, is_compared] ** 2, axis=1)
        row = int(first_smallest(np.where(may_be_taken, distance, np.inf)))
        return np.asarray(self.conditions[row])

    def has_level(self, dimension: int, value: float) -> BoolArray:
        """Which conditions have a level of P, U or T, shape (conditions,).

        Args:
            dimension: Column of the condition: 0 for P, 1 for U, 2 for T.
            value: The level.
        """
        target = self.conditions.copy()
        target[:, dimension] = value
        scaled_distance = scaled_conditions(self.conditions) - scaled_conditions(target)
        return ~_is_wider(scaled_distance[:, dimension], _LEVEL_WIDTHS[dimension])


def _is_wider(scaled_distance: FloatArray, width: FloatArray) -> BoolArray:
    """Whether scaled distances are larger than a width, by more than rounding."""
    # scaled conditions are of the size of 1
    return exceeds(np.abs(scaled_distance), width, size=1.0)


def distinct(conditions: FloatArray) -> FloatArray:
    """Different conditions, sorted by value, shape (conditions, 3).

    Of those that have the same levels the first one is taken.
    """
    ordered = conditions[np.lexsort(conditions.T[::-1])]
    level_numbers_of_rows = level_numbers(scaled_conditions(ordered), LevelWidths())
    _, first_rows = np.unique(level_numbers_of_rows, axis=0, return_index=True)
    return ordered[np.sort(first_rows)]


def is_among(conditions: FloatArray, listed: FloatArray) -> BoolArray:
    """Which conditions are the same as one of the others, shape (conditions,)."""
    if not len(listed):
        return np.zeros(len(conditions), dtype=bool)
    scaled = scaled_conditions(conditions)
    scaled_listed = scaled_conditions(listed)
    # the nearest by the widths of a level is the same if any is; all pairs of a large campaign do
    # not fit into memory
    tree = scipy.spatial.cKDTree(scaled_listed / _LEVEL_WIDTHS)
    _, nearest = tree.query(scaled / _LEVEL_WIDTHS, p=np.inf)
    return np.all(~_is_wider(scaled - scaled_listed[nearest], _LEVEL_WIDTHS), axis=1)


def evenly_spaced_values(lowest: float, highest: float, count: int, dimension: int) -> FloatArray:
    """Values of P, U or T at equal distances in its scale, shape (count,).

    Those between the ends have three significant digits, as a set point may have.

    Args:
        lowest: First value.
        highest: Last value.
        count: Number of values, the ends among them.
        dimension: Column of the condition: 0 for P, 1 for U, 2 for T.

    Examples:
        >>> evenly_spaced_values(25, 40, 3, CONDITIONS.index("entrainment_speed_m_s"))
        array([25. , 31.6, 40. ])
    """
    ends = np.ones((2, len(CONDITIONS)))
    ends[:, dimension] = lowest, highest
    scaled_lowest, scaled_highest = scaled_conditions(ends)
    scaled = np.linspace(scaled_lowest, scaled_highest, count)
    values = unscaled_conditions(scaled)[:, dimension]
    rounded_values = [float(f"{value:.{_DIGITS}g}") for value in values[1:-1]]
    return np.array([lowest, *rounded_values, highest], dtype=float)


def lacking_runs(
    conditions: FloatArray, levels_to_choose: Sequence[Sequence[float]], runnable: Runnable
) -> list[PlannedRun]:
    """The runs that a campaign lacks: levels of a condition, then corners of the box.

    Some of them may be beyond the limits of the rig.

    Args:
        conditions: Conditions that are tested, or will be, shape (runs, 3).
        levels_to_choose: Levels of P, U and T among which those of a condition are chosen that was
            not varied.
        runnable: Which conditions the rig can run.
    """
    tested = Levels.from_conditions(conditions)
    runs = _third_levels(tested)
    runs += _levels_of_constant_conditions(tested, levels_to_choose, runnable)
    extended = tested.conditions
    for run in runs:
        one_row = run.conditions[np.newaxis]
        if runnable(one_row).all():
            extended = np.concatenate([extended, one_row])
    runs += _corners(Levels.from_conditions(extended))
    return _new_runs(runs, tested.conditions)


def _new_runs(runs: list[PlannedRun], tested: FloatArray) -> list[PlannedRun]:
    """The runs at conditions that neither were tested nor occur before in the list."""
    new_runs = []
    seen = tested
    for run in runs:
        one_row = run.conditions[np.newaxis]
        if not is_among(one_row, seen).any():
            new_runs.append(run)
            seen = np.concatenate([seen, one_row])
    return new_runs


def _third_levels(tested: Levels) -> list[PlannedRun]:
    """Runs at the level between two levels: the centre of the box, and the centre of each face.

    Conditions with two levels are at the middle of their scale. The others are as in a tested
    condition, so that only the level between is new.
    """
    has_two = tested.has_two_levels
    if not has_two.any():
        return []
    middle = tested.middle
    everywhere = np.ones(len(tested.conditions), dtype=bool)
    runs = [_at_middle(tested, middle, has_two, everywhere)]
    for dimension in np.flatnonzero(~tested.is_constant).tolist():
        is_between = has_two.copy()
        is_between[dimension] = False
        if not is_between.any():
            continue
        for box_end in (tested.lowest, tested.highest):
            target = middle.copy()
            target[dimension] = box_end[dimension]
            on_face = tested.has_level(dimension, box_end[dimension])
            runs.append(_at_middle(tested, target, is_between, on_face))
    return runs


def _at_middle(
    tested: Levels, target: FloatArray, is_between: BoolArray, may_be_taken: BoolArray
) -> PlannedRun:
    """A run with some conditions as in the target, and the others as in the nearest tested one."""
    conditions = target
    if not is_between.all():
        nearest = tested.nearest(target, may_be_taken, ~is_between)
        conditions = np.where(is_between, target, nearest)
    return PlannedRun(conditions, "third_level", _names_of(is_between))


def _names_of(is_chosen: BoolArray) -> tuple[str, ...]:
    """Names of the chosen conditions."""
    return tuple(CONDITIONS[dimension] for dimension in np.flatnonzero(is_chosen))


def _levels_of_constant_conditions(
    tested: Levels, levels_to_choose: Sequence[Sequence[float]], runnable: Runnable
) -> list[PlannedRun]:
    """Runs at two more levels of each condition that was not varied.

    They are at tested values of the other conditions: in the middle and at their ends.
    """
    runs = []
    base_conditions = _middle_and_ends(tested)
    for dimension in np.flatnonzero(tested.is_constant).tolist():
        is_new = np.arange(len(CONDITIONS)) == dimension
        for value in _two_levels(tested, dimension, levels_to_choose[dimension], runnable):
            for base in base_conditions:
                conditions = np.where(is_new, value, base)
                runs.append(PlannedRun(conditions, "not_varied", _names_of(is_new)))
    return runs


def _middle_and_ends(tested: Levels) -> list[FloatArray]:
    """The tested conditions nearest to the middle of the box, and to that of each face."""
    all_conditions = np.ones(len(CONDITIONS), dtype=bool)
    everywhere = np.ones(len(tested.conditions), dtype=bool)
    base_conditions = [tested.nearest(tested.middle, everywhere, all_conditions)]
    for dimension in np.flatnonzero(~tested.is_constant).tolist():
        for box_end in (tested.lowest, tested.highest):
            on_face = tested.has_level(dimension, box_end[dimension])
            base_conditions.append(tested.nearest(tested.middle, on_face, all_conditions))
    return base_conditions


def _two_levels(
    tested: Levels, dimension: int, levels_to_choose: Sequence[float], runnable: Runnable
) -> list[float]:
    """Two levels beside the only one: the ends of what can be run, or the far end and the middle.

    Levels can be run if they can at all corners of the other conditions. There may be fewer than
    two.
    """
    tested_level = float(np.median(tested.values[dimension]))
    corners = corners_of(tested.lowest, tested.highest)
    possible_levels = [tested_level]
    for value in levels_to_choose:
        corners[:, dimension] = value
        if runnable(corners).all():
            possible_levels.append(value)
    lowest, highest = min(possible_levels), max(possible_levels)
    if tested_level - lowest < highest - tested_level:
        nearer_end, farther_end = lowest, highest
    else:
        nearer_end, farther_end = highest, lowest
    _, middle_level, _ = evenly_spaced_values(lowest, highest, 3, dimension)
    # a tested level in the outer quarter is an end itself
    _, quarter_level, _ = evenly_spaced_values(nearer_end, middle_level, 3, dimension)
    if abs(tested_level - nearer_end) <= abs(quarter_level - nearer_end):
        _, middle_level, _ = evenly_spaced_values(tested_level, farther_end, 3, dimension)
        chosen_levels = [middle_level, farther_end]
    else:
        chosen_levels = [nearer_end, farther_end]
    return [value for value in chosen_levels if not tested.has_level(dimension, value).any()]


def _corners(box: Levels) -> list[PlannedRun]:
    """Runs at the corners of the box."""
    return [PlannedRun(corner, "corner") for corner in corners_of(box.lowest, box.highest)]


def corners_of(lowest: FloatArray, highest: FloatArray) -> FloatArray:
    """The corners of a box of conditions, shape (8, 3)."""
    return np.array(list(itertools.product(*np.stack([lowest, highest], axis=1))))


def first_runs(levels_to_choose: Sequence[Sequence[float]], runnable: Runnable) -> list[PlannedRun]:
    """24 runs for a campaign without data: at three pressures, four speeds and six temperatures.

    The levels are equally spaced in the scale of the conditions, over the largest box among the
    levels to choose from whose corners the rig can run.

    Args:
        levels_to_choose: Levels of P, U and T.
        runnable: Which conditions the rig can run.

    Returns:
        No runs where the rig can run none of these levels.
    """
    box = _largest_box(levels_to_choose, runnable)
    if box is None:
        return []
    values = []
    for dimension, (lowest, highest) in enumerate(box):
        values.append(evenly_spaced_values(lowest, highest, _FIRST_LEVELS[dimension], dimension))
    pressures, speeds, temperatures = values
    temperature_step = len(temperatures) // _TEMPERATURES_PER_PAIR
    rows = []
    for pressure_index, pressure in enumerate(pressures):
        for speed_index, speed in enumerate(speeds):
            for step_count in range(_TEMPERATURES_PER_PAIR):
                temperature_index = (
                    pressure_index + speed_index + step_count * temperature_step
                ) % len(temperatures)
                rows.append((pressure, speed, temperatures[temperature_index]))
    return [PlannedRun(row, "first_plan") for row in distinct(np.array(rows))]


def _largest_box(
    levels_to_choose: Sequence[Sequence[float]], runnable: Runnable
) -> list[tuple[float, float]] | None:
    """The largest box among levels whose corners can be run; None where nothing can be run.

    All conditions between such corners can be run, because the others are beyond some limit.

    Returns:
        Lowest and highest P, U and T.
    """
    all_conditions = np.array(list(itertools.product(*levels_to_choose)))
    shape = tuple(len(values) for values in levels_to_choose)
    can_run = runnable(all_conditions).reshape(shape)
    scaled_levels = scaled_conditions(all_conditions).reshape(*shape, len(CONDITIONS))
    # rows of a box: P, U and T; columns: number of its lowest and of its highest level
    pairs = [list(itertools.combinations_with_replacement(range(count), 2)) for count in shape]
    boxes = np.array(list(itertools.product(*pairs)))
    is_possible = np.ones(len(boxes), dtype=bool)
    for end_of_pairs in itertools.product((0, 1), repeat=len(CONDITIONS)):
        corner = boxes[:, np.arange(len(CONDITIONS)), end_of_pairs]
        is_possible &= can_run[tuple(corner.T)]
    if not is_possible.any():
        return None
    boxes = boxes[is_possible]
    lowest = scaled_levels[tuple(boxes[:, :, 0].T)]
    highest = scaled_levels[tuple(boxes[:, :, 1].T)]
    volume = np.prod(highest - lowest + _LEVEL_WIDTHS, axis=1)
    best_box = boxes[int(first_largest(volume))]
    return [
        (values[low_index], values[high_index])
        for values, (low_index, high_index) in zip(levels_to_choose, best_box, strict=True)
    ]
