"""What may be wrong with a refused run: simple mistakes, each tried, before the last resort.

A log in the wrong unit, or with two columns exchanged, or settings that are not made for it: the
gates that fail have nothing to do with the cause. A hypothesis undoes one such mistake. Where the
run then passes, the mistake is named.

Decides: which simple mistakes (units, exchanged columns, settings that no run of this length can
meet) are tried and named.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from itertools import permutations
from typing import Any

import numpy as np

from oilfilm.curation.gate import Columns
from oilfilm.curation.statistics import median
from oilfilm.settings.config import StepSettings
from oilfilm.settings.rig import Rig
from oilfilm.units import RAD_S_PER_RPM


@dataclass(frozen=True)
class Hypothesis:
    """A mistake that a log may hold, and how to undo it.

    Attributes:
        rule: Rule of a refusal for it.
        sentence: What was found, if the run passes once the mistake is undone.
        undo: The samples of the run without the mistake.
        explains: Rules whose refusals it may cause.
        plausible: Whether samples with so many levels may hold the mistake.
        changes: Settings that are changed, where the mistake is one of theirs.
    """

    rule: str
    sentence: str
    undo: Callable[[Columns], Columns]
    explains: frozenset[str]
    plausible: Callable[[Columns, int], bool] = lambda samples, levels: True
    changes: Mapping[str, Any] = field(default_factory=dict)


_BY_TIME = frozenset(
    "too_short not_steady transient_not_ended no_point_left many_plateaus_fail zero_missing "
    "no_plateau zero_drift zero_noisy zero_not_settled".split()
)
_BY_FORCE = _BY_TIME | {"traction_unphysical", "impossible_traction"}
_BY_SLIP = _BY_TIME | {
    *("swapped_sign", "speed_off_nominal", "slip_out_of_range", "slip_off_set_point")
}
# Both speeds together leave the slip as it is.
_BY_SPEED = frozenset({"speed_off_nominal"})

# Refusals that a mistake of another kind may cause.
DOUBTFUL = _BY_TIME | _BY_FORCE | _BY_SLIP | _BY_SPEED

# A time of the settings that is a larger share of the run than this leaves nothing of its levels.
_LONGEST_SHARE = 1 / 8
# A lower limit for steps that is tried, over the configured one.
_SMALLER = 1 / 4
# Rows at either end at which a rig rolls; a sweep that begins with such slips has no rolling phase.
_AT_ENDS = 20
_NO_SWEEP = -0.004, 0.1
# What rigs do: s between rows, at most; s for which they hold a level.
_SLOWEST_S = 2.0
_HOLD_S = 0.5, 600.0
# Speeds that are in this ratio or less roll.
_ROLLING = 2.0
_BALL, _DISC = "ball_speed_m_s", "disc_speed_m_s"
# Unit, the unit that it is labelled as, and what the numbers must be multiplied by.
_TIME_UNITS = (
    ("ms", "s", 1e-3),
    ("min", "s", 60.0),
    ("s", "ms", 1e3),
    ("us", "s", 1e-6),
    ("h", "s", 3600.0),
)
_FORCE_UNITS = {
    "1000 times smaller, as mN labelled N would be, or a load in kN": 1e-3,
    "102 times smaller, as gf labelled N would be": 9.80665e-3,
}
_SPEED_UNITS = {("mm/s", "m/s"): 1e-3, ("m/s", "mm/s"): 1e3}
# Spindle speeds in 1/min.
_SPINDLE_UNITS = {"1/min": 1.0, "rad/s": 1 / RAD_S_PER_RPM, "1/s": 60.0, "deg/s": 1 / 6}


def scaled(factor: float, *names: str) -> Callable[[Columns], Columns]:
    """Undo by multiplying some signals."""
    return lambda samples: {**samples, **{name: factor * samples[name] for name in names}}


def time_hypotheses() -> Iterator[Hypothesis]:
    """Mistakes of the clock: the time is in another unit than s."""
    for unit, label, factor in _TIME_UNITS:
        sentence = (
            f"the run would pass with its time {factor:g} times as long, as {unit} labelled "
            f"{label} would be"
        )
        undo, plausible = scaled(factor, "time_s"), partial(_clock_off_by, factor)
        yield Hypothesis("time_unit", sentence, undo, _BY_TIME, plausible)


def setting_hypotheses(part: str, levels: StepSettings, min_step: str) -> Iterator[Hypothesis]:
    """Settings of plateaus that are not made for a run: steps too small, times too long.

    Args:
        part: The part of the settings that has the plateaus.
        levels: Its plateaus.
        min_step: Name of the key of the smallest step.
    """

    def with_value(rule: str, key: str, value: float, plausible: Any) -> Hypothesis:
        sentence = (
            f"the run would pass with {key} of {value:.3g}; {part}.plateaus.{key} is "
            f"{getattr(levels, key):g}"
        )
        changes = {part: {"plateaus": {key: value}}}
        return Hypothesis(rule, sentence, dict, _BY_TIME, plausible, changes)

    smaller = _SMALLER * getattr(levels, min_step)
    yield with_value("small_steps", min_step, smaller, lambda samples, count: True)
    for key in ("settle_s", "guard_s", "window_s", "min_duration_s"):
        too_long = partial(_long_for_run, getattr(levels, key))
        for divisor in (10, 100, 1000):
            yield with_value("long_setting", key, getattr(levels, key) / divisor, too_long)


def _long_for_run(value_s: float, samples: Columns, levels: int) -> bool:
    return value_s > _LONGEST_SHARE * float(np.ptp(samples["time_s"]))


def _radii_hypotheses(rig: Rig, others: Mapping[str, Rig]) -> Iterator[Hypothesis]:
    """Logs of spindle speeds that were read with the track radii of another rig."""
    for name, other in others.items():
        if other.ball_track_radius_m and other.disc_track_radius_m and other != rig:
            ball, disc = (
                getattr(other, key) / getattr(rig, key)
                for key in ("ball_track_radius_m", "disc_track_radius_m")
            )
            sentence = f"the run would pass with the track radii of the rig {name}"
            yield Hypothesis("track_radii", sentence, partial(_times, ball, disc), _BY_SLIP)
    for body, power in ((_BALL, 1.0), (_DISC, -1.0)):
        words = "ball" if body == _BALL else "disc"
        sentence = (
            f"before and after the sweep the {words} is faster or slower than the other body by "
            "one ratio; with that ratio taken out the run would pass"
        )
        undo = partial(_rolling_at_ends, body, power)
        yield Hypothesis("track_radii", sentence, undo, _BY_SLIP, _one_ratio_at_ends)


def _times(ball: float, disc: float, samples: Columns) -> Columns:
    return {**samples, _BALL: ball * samples[_BALL], _DISC: disc * samples[_DISC]}


def _rolling_at_ends(body: str, power: float, samples: Columns) -> Columns:
    """One body's speed such that both are equal before the sweep."""
    return {**samples, body: samples[body] * _ratios_at_ends(samples)[0] ** power}


def _ratios_at_ends(samples: Columns) -> tuple[float, float]:
    """Disc over ball at the beginning and at the end; 1 where one of them does not turn."""
    ratios = []
    for rows in (np.s_[:_AT_ENDS], np.s_[-_AT_ENDS:]):
        ball, disc = median(samples[_BALL][rows]), median(samples[_DISC][rows])
        ratios.append(disc / ball if ball > 0 and disc > 0 else 1.0)
    return ratios[0], ratios[1]


def _one_ratio_at_ends(samples: Columns, levels: int) -> bool:
    first, last = _ratios_at_ends(samples)
    least, most = _NO_SWEEP
    return abs(first / last - 1) < -least and not least <= 2 * (first - 1) / (first + 1) <= most


def traction_hypotheses(rig: Rig, rigs: Mapping[str, Rig]) -> Iterator[Hypothesis]:
    """Mistakes of the logs of a traction rig, the most frequent first; `rigs` are all of them."""
    yield from time_hypotheses()
    for words, factor in _FORCE_UNITS.items():
        sentence = f"the run would pass with a traction force {words}"
        yield Hypothesis("force_scale", sentence, scaled(factor, "traction_force_n"), _BY_FORCE)
    ratios, factors = {"speeds": 1.0}, dict(_SPEED_UNITS)
    if rig.ball_track_radius_m is not None and rig.disc_track_radius_m is not None:
        ratios["spindle speeds"] = rig.ball_track_radius_m / rig.disc_track_radius_m
        factors |= {
            (unit, label): _SPINDLE_UNITS[unit] / _SPINDLE_UNITS[label]
            for unit, label in permutations(_SPINDLE_UNITS, 2)
        }
    for words, ratio in ratios.items():
        sentence = f"the run would pass with the {words} of ball and disc exchanged"
        yield Hypothesis("swapped_channels", sentence, partial(_exchanged, ratio), _BY_SLIP)
    for names, words in (((_BALL,), "ball"), ((_DISC,), "disc"), ((_BALL, _DISC), "ball and disc")):
        sentence = f"the run would pass with the opposite sign of the speed of {words}"
        yield Hypothesis("speed_sign", sentence, scaled(-1.0, *names), _BY_SLIP)
    for names, words, explains in (
        ((_BALL, _DISC), "both speeds", _BY_SPEED),
        ((_BALL,), "the ball's speed", _BY_SLIP),
        ((_DISC,), "the disc's speed", _BY_SLIP),
    ):
        for (unit, label), factor in factors.items():
            sentence = (
                f"the run would pass with {words} {factor:.4g} times as large, as {unit} labelled "
                f"{label} would be"
            )
            undo = scaled(factor, *names)
            yield Hypothesis("speed_unit", sentence, undo, explains, partial(_rolls_with, undo))
    sentence = "the run would pass with its slide-roll ratio in percent"
    yield Hypothesis("slip_unit", sentence, _from_percent, _BY_SLIP, _turns_backwards)
    # behind the units, which name the cause more precisely
    if "spindle speeds" in ratios:
        yield from _radii_hypotheses(rig, rigs)


def _clock_off_by(factor: float, samples: Columns, levels: int) -> bool:
    """Whether no rig keeps such time as is logged, but one does once it is multiplied.

    Levels that are only short are not taken for ones of so many minutes.
    """
    time_s = samples["time_s"]
    interval_s = median(np.diff(time_s))
    hold_s = float(time_s[-1] - time_s[0]) / max(levels, 1)

    def usual(scale: float) -> bool:
        shortest_s, longest_s = _HOLD_S
        return scale * interval_s <= _SLOWEST_S and shortest_s <= scale * hold_s <= longest_s

    return usual(factor) and not usual(1.0)


def _rolls_with(undo: Callable[[Columns], Columns], samples: Columns, levels: int) -> bool:
    """Whether ball and disc have about one speed once a mistake is undone."""
    undone = undo(samples)
    ball, disc = (median(undone[name]) for name in (_BALL, _DISC))
    return 1 / _ROLLING < abs(ball / disc) < _ROLLING if disc else False


def _turns_backwards(samples: Columns, levels: int) -> bool:
    """Whether one body turns backwards, as a hundred times too much slip makes it."""
    return bool(np.any(samples[_BALL] * samples[_DISC] < 0))


def _exchanged(ratio: float, samples: Columns) -> Columns:
    """Ball and disc exchanged; `ratio` is that of their track radii, where spindles are logged."""
    return {**samples, _BALL: samples[_DISC] * ratio, _DISC: samples[_BALL] / ratio}


def _from_percent(samples: Columns) -> Columns:
    """Speeds of a log whose entrainment speed and slip were logged, the slip in percent."""
    ball, disc = samples[_BALL], samples[_DISC]
    mean, sliding = (ball + disc) / 2, (disc - ball) / 100
    return {
        **samples,
        _BALL: np.asarray(mean - sliding / 2),
        _DISC: np.asarray(mean + sliding / 2),
    }
