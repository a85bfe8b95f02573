"""Possible causes of a refusal: simple mistakes, which are tried one after the other.

A log has a wrong unit or two exchanged columns, or the settings do not suit it. The gates that
refuse it then do not name the cause. A hypothesis undoes one such mistake. If the run passes
without it, the refusal names the mistake.

Decides: which simple mistakes (units, exchanged columns, settings that no run of this length can
meet) are tried and named.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from itertools import permutations
from typing import Any, NamedTuple, Protocol

import numpy as np

from oilfilm.base.units import RAD_S_PER_RPM
from oilfilm.curation.statistics import median
from oilfilm.logs.base import ColumnArrays
from oilfilm.settings.config import StepSettings
from oilfilm.settings.rig import Rig


class Plausibility(Protocol):
    """A function that says whether the samples of a run may have a mistake."""

    def __call__(self, samples: ColumnArrays, level_count: int) -> bool:
        """True if they may have it.

        Args:
            samples: Samples of the run as logged.
            level_count: Number of levels that are found once the mistake is undone; 0 where the
                mistake is in the settings.
        """
        ...


@dataclass(frozen=True)
class Hypothesis:
    """A mistake that a log may hold, and how to undo it.

    Attributes:
        rule: Rule of a refusal for the mistake.
        sentence: The change with which the run would pass: the end of `the run would pass with`.
        undo: Gives the samples of the run without the mistake.
        explained_rules: Rules whose refusals the mistake may cause.
        is_plausible: Whether samples may have the mistake.
        changed_settings: Changed settings, where the mistake is in the settings.
    """

    rule: str
    sentence: str
    undo: Callable[[ColumnArrays], ColumnArrays]
    explained_rules: frozenset[str]
    is_plausible: Plausibility = lambda samples, level_count: True
    changed_settings: Mapping[str, Any] = field(default_factory=dict)


# A wrong force or slip breaks the limits that a wrong time breaks, and others.
_RULES_OF_WRONG_TIME = frozenset(
    "too_short not_steady transient_not_ended no_point_left many_plateaus_fail zero_missing "
    "no_plateau zero_drift zero_noisy zero_not_settled".split()
)
_RULES_OF_WRONG_FORCE = _RULES_OF_WRONG_TIME | {"traction_unphysical", "impossible_traction"}
_RULES_OF_WRONG_SLIP = _RULES_OF_WRONG_TIME | frozenset(
    "swapped_sign speed_off_nominal slip_out_of_range slip_off_set_point".split()
)
# Where both speeds are wrong by one factor, the slip is right.
_RULES_OF_WRONG_SPEED = frozenset({"speed_off_nominal"})

# A refusal by one of these rules may have a cause that the rule does not name: a mistake below.
RULES_WITH_HIDDEN_CAUSE = (
    _RULES_OF_WRONG_TIME | _RULES_OF_WRONG_FORCE | _RULES_OF_WRONG_SLIP | _RULES_OF_WRONG_SPEED
)

# All numbers below belong to explanations of a refusal. None decides whether a run is refused.
# A time in the settings that is a larger share of the run than this leaves nothing of its levels.
_LARGEST_SHARE_OF_RUN = 1 / 8
# Factors by which settings are reduced: the smallest step, and times.
_STEP_FACTOR = 1 / 4
_TIME_FACTORS = (0.1, 0.01, 0.001)
# Rows at the beginning and at the end in which a rig rolls.
_ROWS_AT_EACH_END = 20
# Largest relative difference between the ratios of speeds at the beginning and at the end.
_LARGEST_RATIO_CHANGE = 0.004
# A run whose first slip is in this range may begin with the sweep itself, without pure rolling.
_SLIP_RANGE_AT_START = (-0.004, 0.1)
# Longest interval of a logger, and how long rigs hold a level, in s.
_LONGEST_INTERVAL_S = 2.0
_SHORTEST_HOLD_S = 0.5
LONGEST_HOLD_S = 600.0
# The largest traction coefficients of a sweep are seldom smaller. They are taken at this quantile,
# which leaves out spikes.
_SMALLEST_USUAL_PEAK = 0.005
_QUANTILE_OF_LARGEST = 0.95
# Bodies roll on each other where the ratio of their speeds is less than this.
_LARGEST_ROLLING_RATIO = 2.0
_BALL_SPEED = "ball_speed_m_s"
_DISC_SPEED = "disc_speed_m_s"
# The unit of the numbers, the unit that the log states, and the factor that corrects the numbers.
_TIME_UNIT_MISTAKES = (("ms", "s", 1e-3), ("min", "s", 60.0), ("s", "ms", 1e3))
# What is wrong with the force, as the end of a sentence, and the factor that corrects it.
_FORCE_FACTOR_OF_PHRASE = {
    "1000 times smaller, as mN labelled N would be, or a load in kN": 1e-3,
    "102 times smaller, as gf labelled N would be": 9.80665e-3,
}
_SPEED_UNIT_MISTAKES = {("mm/s", "m/s"): 1e-3, ("m/s", "mm/s"): 1e3}
# Unit of a spindle speed -> its size in 1/min.
_RPM_PER_SPINDLE_UNIT = {"1/min": 1.0, "rad/s": 1 / RAD_S_PER_RPM, "1/s": 60.0, "deg/s": 1 / 6}


class _WrongSpeeds(NamedTuple):
    """Speeds that a log may hold wrongly.

    Attributes:
        columns: Their columns of samples.
        phrase: What they are in a sentence.
        explained_rules: Rules whose refusals they may cause.
    """

    columns: tuple[str, ...]
    phrase: str
    explained_rules: frozenset[str]


_WRONG_SPEEDS = (
    _WrongSpeeds((_BALL_SPEED, _DISC_SPEED), "both speeds", _RULES_OF_WRONG_SPEED),
    _WrongSpeeds((_BALL_SPEED,), "the ball's speed", _RULES_OF_WRONG_SLIP),
    _WrongSpeeds((_DISC_SPEED,), "the disc's speed", _RULES_OF_WRONG_SLIP),
)


def undo_by_factor(factor: float, *columns: str) -> Callable[[ColumnArrays], ColumnArrays]:
    """The function `Hypothesis.undo` that multiplies some columns of samples by a factor."""

    def undo(samples: ColumnArrays) -> ColumnArrays:
        corrected = dict(samples)
        for column in columns:
            corrected[column] = factor * samples[column]
        return corrected

    return undo


def time_hypotheses() -> Iterator[Hypothesis]:
    """Mistakes of the clock: the time is in another unit than s."""
    for unit, labelled_unit, factor in _TIME_UNIT_MISTAKES:
        yield Hypothesis(
            "time_unit",
            f"its time {factor:g} times as long, as {unit} labelled {labelled_unit} would be",
            undo_by_factor(factor, "time_s"),
            _RULES_OF_WRONG_TIME,
            partial(_has_usual_times_only_with, factor),
        )


def setting_hypotheses(
    section: str, plateau_settings: StepSettings, min_step_key: str
) -> Iterator[Hypothesis]:
    """Settings of plateaus that do not suit a run: its steps are too small, or times too long.

    Args:
        section: The section of the settings that has the plateaus.
        plateau_settings: The settings of the plateaus.
        min_step_key: Key of the smallest step.
    """
    smallest_step = getattr(plateau_settings, min_step_key)
    yield _setting_hypothesis(
        "small_steps", section, min_step_key, smallest_step, _STEP_FACTOR, longest_run_s=np.inf
    )
    for key in ("settle_s", "guard_s", "window_s", "min_duration_s"):
        time_s = getattr(plateau_settings, key)
        for factor in _TIME_FACTORS:
            longest_run_s = time_s / _LARGEST_SHARE_OF_RUN
            yield _setting_hypothesis("long_setting", section, key, time_s, factor, longest_run_s)


def _setting_hypothesis(
    rule: str, section: str, key: str, value: float, factor: float, longest_run_s: float
) -> Hypothesis:
    """The hypothesis that a setting is too large for runs up to some length.

    Args:
        rule: Rule of the refusal.
        section: Section of the settings.
        key: Key of the setting.
        value: Its value.
        factor: Factor by which it is reduced.
        longest_run_s: Longest run that may have the mistake.
    """
    return Hypothesis(
        rule,
        f"{key} of {factor * value:.3g}; {section}.plateaus.{key} is {value:g}",
        # the samples are right: the setting is not
        dict,
        _RULES_OF_WRONG_TIME,
        partial(_is_shorter_than, longest_run_s),
        {section: {"plateaus": {key: factor * value}}},
    )


def _is_shorter_than(longest_run_s: float, samples: ColumnArrays, level_count: int) -> bool:
    """Whether the run is shorter than `longest_run_s`."""
    return bool(np.ptp(samples["time_s"]) < longest_run_s)


def traction_hypotheses(rig: Rig, sliding_sign: int) -> Iterator[Hypothesis]:
    """Mistakes of the logs of a traction rig, the most frequent first.

    Args:
        rig: The rig.
        sliding_sign: 1 where the ball is slowed at positive slip, -1 where the disc is.
    """
    yield from time_hypotheses()
    for phrase, factor in _FORCE_FACTOR_OF_PHRASE.items():
        undo = undo_by_factor(factor, "traction_force_n")
        is_plausible = partial(_has_usual_traction_once_undone, undo)
        yield Hypothesis(
            "force_scale", f"a traction force {phrase}", undo, _RULES_OF_WRONG_FORCE, is_plausible
        )
    track_ratio = None
    if rig.ball_track_radius_m is not None and rig.disc_track_radius_m is not None:
        track_ratio = rig.ball_track_radius_m / rig.disc_track_radius_m
    yield _exchange_hypothesis("speeds", 1.0, sliding_sign)
    if track_ratio is not None:
        yield _exchange_hypothesis("spindle speeds", track_ratio, sliding_sign)
    for wrong_speeds in _WRONG_SPEEDS:
        sentence = f"the opposite sign of {wrong_speeds.phrase}"
        undo = undo_by_factor(-1.0, *wrong_speeds.columns)
        yield Hypothesis("speed_sign", sentence, undo, _RULES_OF_WRONG_SLIP)
    yield from _speed_unit_hypotheses(has_spindle_speeds=track_ratio is not None)
    sentence = "its slide-roll ratio in percent"
    yield Hypothesis(
        "slip_unit", sentence, _undo_percent, _RULES_OF_WRONG_SLIP, _turns_one_body_backwards
    )
    # tried after the units, which name the cause more precisely. Wrong radii make all speeds of one
    # body wrong by one factor
    if track_ratio is not None:
        for column, body in ((_BALL_SPEED, "ball"), (_DISC_SPEED, "disc")):
            sentence = f"the {body}'s speed changed by the one ratio that makes both ends roll"
            undo = partial(_undo_wrong_radii, column)
            yield Hypothesis(
                "track_radii", sentence, undo, _RULES_OF_WRONG_SLIP, _has_one_ratio_at_ends
            )


def _exchange_hypothesis(speeds_phrase: str, track_ratio: float, sliding_sign: int) -> Hypothesis:
    """The hypothesis that the columns of ball and disc are exchanged.

    Args:
        speeds_phrase: The two columns in a sentence.
        track_ratio: As for `_undo_exchange`.
        sliding_sign: As for `traction_hypotheses`.
    """
    sentence = f"the {speeds_phrase} of ball and disc exchanged"
    undo = partial(_undo_exchange, track_ratio)
    is_plausible = partial(_slips_as_stated_once_undone, undo, sliding_sign)
    return Hypothesis("swapped_channels", sentence, undo, _RULES_OF_WRONG_SLIP, is_plausible)


def _slips_as_stated_once_undone(
    undo: Callable[[ColumnArrays], ColumnArrays],
    sliding_sign: int,
    samples: ColumnArrays,
    level_count: int,
) -> bool:
    """Whether the body that the campaign file names is the slower one once a mistake is undone."""
    corrected = undo(samples)
    return bool(sliding_sign * np.nanmean(corrected[_DISC_SPEED] - corrected[_BALL_SPEED]) > 0)


def _speed_unit_hypotheses(has_spindle_speeds: bool) -> Iterator[Hypothesis]:
    """Speeds in another unit than their label says; of spindles too if `has_spindle_speeds`."""
    factor_of_mistake = dict(_SPEED_UNIT_MISTAKES)
    if has_spindle_speeds:
        for unit, labelled_unit in permutations(_RPM_PER_SPINDLE_UNIT, 2):
            factor_of_mistake[unit, labelled_unit] = (
                _RPM_PER_SPINDLE_UNIT[unit] / _RPM_PER_SPINDLE_UNIT[labelled_unit]
            )
    for wrong_speeds in _WRONG_SPEEDS:
        for (unit, labelled_unit), factor in factor_of_mistake.items():
            phrase = f"{factor:.4g} times as large, as {unit} labelled {labelled_unit} would be"
            undo = undo_by_factor(factor, *wrong_speeds.columns)
            yield Hypothesis(
                "speed_unit",
                f"{wrong_speeds.phrase} {phrase}",
                undo,
                wrong_speeds.explained_rules,
                partial(_rolls_once_undone, undo),
            )


def _undo_wrong_radii(column: str, samples: ColumnArrays) -> ColumnArrays:
    """Samples with one body's speed scaled so that both speeds are equal before the sweep."""
    ratio, _ = _ratios_at_ends(samples)
    return undo_by_factor(ratio if column == _BALL_SPEED else 1 / ratio, column)(samples)


def _ratios_at_ends(samples: ColumnArrays) -> tuple[float, float]:
    """Disc speed over ball speed at the beginning and at the end; 1 where one does not turn."""
    beginning = _speed_ratio(samples, slice(None, _ROWS_AT_EACH_END))
    end = _speed_ratio(samples, slice(-_ROWS_AT_EACH_END, None))
    return beginning, end


def _speed_ratio(samples: ColumnArrays, rows: slice) -> float:
    """Disc speed over ball speed in some rows, by their medians; 1 where one does not turn."""
    ball_speed = median(samples[_BALL_SPEED][rows])
    disc_speed = median(samples[_DISC_SPEED][rows])
    return disc_speed / ball_speed if ball_speed > 0 and disc_speed > 0 else 1.0


def _has_one_ratio_at_ends(samples: ColumnArrays, level_count: int) -> bool:
    """Whether the ratio of the speeds is the same at both ends, and is no slip of a sweep."""
    beginning, end = _ratios_at_ends(samples)
    smallest, largest = _SLIP_RANGE_AT_START
    slip = 2 * (beginning - 1) / (beginning + 1)
    is_same_ratio = abs(beginning / end - 1) < _LARGEST_RATIO_CHANGE
    return is_same_ratio and not smallest <= slip <= largest


def _has_usual_times_only_with(factor: float, samples: ColumnArrays, level_count: int) -> bool:
    """Whether no rig has the logged times, but rigs have these times multiplied by a factor.

    The length of the levels counts: a short level alone does not show that the time is in minutes.
    """
    time_s = samples["time_s"]
    interval_s = median(np.diff(time_s))
    hold_s = float(time_s[-1] - time_s[0]) / max(level_count, 1)

    def are_usual(factor_tried: float) -> bool:
        is_usual_hold = _SHORTEST_HOLD_S <= factor_tried * hold_s <= LONGEST_HOLD_S
        return factor_tried * interval_s <= _LONGEST_INTERVAL_S and is_usual_hold

    return are_usual(factor) and not are_usual(1.0)


def _rolls_once_undone(
    undo: Callable[[ColumnArrays], ColumnArrays], samples: ColumnArrays, level_count: int
) -> bool:
    """Whether ball and disc roll on each other once a mistake is undone."""
    corrected = undo(samples)
    ball_speed = median(corrected[_BALL_SPEED])
    disc_speed = median(corrected[_DISC_SPEED])
    if disc_speed == 0:
        return False
    return 1 / _LARGEST_ROLLING_RATIO < abs(ball_speed / disc_speed) < _LARGEST_ROLLING_RATIO


def _has_usual_traction_once_undone(
    undo: Callable[[ColumnArrays], ColumnArrays], samples: ColumnArrays, level_count: int
) -> bool:
    """Whether the largest forces are those of an oil once a mistake is undone."""
    corrected = undo(samples)
    largest_force_n = np.quantile(np.abs(corrected["traction_force_n"]), _QUANTILE_OF_LARGEST)
    load_n = median(np.abs(corrected["load_n"]))
    return bool(largest_force_n > _SMALLEST_USUAL_PEAK * load_n)


def _turns_one_body_backwards(samples: ColumnArrays, level_count: int) -> bool:
    """Whether one body turns backwards: a slip that is a hundred times too large causes this."""
    return bool(np.any(samples[_BALL_SPEED] * samples[_DISC_SPEED] < 0))


def _undo_exchange(track_ratio: float, samples: ColumnArrays) -> ColumnArrays:
    """Samples with ball and disc exchanged.

    Args:
        track_ratio: Ratio of their track radii where spindle speeds are logged; else 1.
        samples: The samples.
    """
    corrected = dict(samples)
    corrected[_BALL_SPEED] = samples[_DISC_SPEED] * track_ratio
    corrected[_DISC_SPEED] = samples[_BALL_SPEED] / track_ratio
    return corrected


def _undo_percent(samples: ColumnArrays) -> ColumnArrays:
    """Samples of a log with entrainment speed and slip, with a hundredth of the slip."""
    mean_m_s = (samples[_BALL_SPEED] + samples[_DISC_SPEED]) / 2
    sliding_m_s = (samples[_DISC_SPEED] - samples[_BALL_SPEED]) / 100
    corrected = dict(samples)
    corrected[_BALL_SPEED] = np.asarray(mean_m_s - sliding_m_s / 2)
    corrected[_DISC_SPEED] = np.asarray(mean_m_s + sliding_m_s / 2)
    return corrected
