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

from oilfilm.curation.statistics import median
from oilfilm.logs.base import Columns
from oilfilm.settings.config import StepSettings
from oilfilm.settings.rig import Rig
from oilfilm.units import RAD_S_PER_RPM


@dataclass(frozen=True)
class Hypothesis:
    """A mistake that a log may hold, and how to undo it.

    Attributes:
        rule: Rule of a refusal for it.
        sentence: With what the run would pass, that is, what the mistake is.
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

# All numbers below belong to explanations of a refusal. None decides whether a run is refused.
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
# The largest traction coefficients of a sweep are seldom smaller; spikes are no force.
_USUAL, _ALMOST_ALL = 0.005, 0.95
# Speeds that are in this ratio or less roll.
_ROLLING = 2.0
_BALL, _DISC = "ball_speed_m_s", "disc_speed_m_s"
# Unit, the unit that it is labelled as, and what the numbers must be multiplied by.
_TIME_UNITS = (("ms", "s", 1e-3), ("min", "s", 60.0), ("s", "ms", 1e3))
_FORCE_UNITS = {
    "1000 times smaller, as mN labelled N would be, or a load in kN": 1e-3,
    "102 times smaller, as gf labelled N would be": 9.80665e-3,
}
_SPEED_UNITS = {("mm/s", "m/s"): 1e-3, ("m/s", "mm/s"): 1e3}
# Spindle speeds in 1/min.
_SPINDLE_UNITS = {"1/min": 1.0, "rad/s": 1 / RAD_S_PER_RPM, "1/s": 60.0, "deg/s": 1 / 6}
# Which speeds, as sentences name them, and the refusals that they may cause.
_SPEEDS = (
    ((_BALL, _DISC), "both speeds", _BY_SPEED),
    ((_BALL,), "the ball's speed", _BY_SLIP),
    ((_DISC,), "the disc's speed", _BY_SLIP),
)


def scaled(factor: float, *names: str) -> Callable[[Columns], Columns]:
    """Undo by multiplying some signals."""
    return lambda samples: {**samples, **{name: factor * samples[name] for name in names}}


def time_hypotheses() -> Iterator[Hypothesis]:
    """Mistakes of the clock: the time is in another unit than s."""
    for unit, label, factor in _TIME_UNITS:
        yield Hypothesis(
            "time_unit",
            f"its time {factor:g} times as long, as {unit} labelled {label} would be",
            scaled(factor, "time_s"),
            _BY_TIME,
            partial(_clock_off_by, factor),
        )


def setting_hypotheses(part: str, levels: StepSettings, min_step: str) -> Iterator[Hypothesis]:
    """Settings of plateaus that are not made for a run: steps too small, times too long.

    Args:
        part: The part of the settings that has the plateaus.
        levels: Its plateaus.
        min_step: Name of the key of the smallest step.
    """
    tried = [("small_steps", min_step, _SMALLER)]
    for key in ("settle_s", "guard_s", "window_s", "min_duration_s"):
        tried += [("long_setting", key, share) for share in (0.1, 0.01, 0.001)]
    for rule, key, share in tried:
        value = getattr(levels, key)
        shortest_s = value / _LONGEST_SHARE if rule == "long_setting" else np.inf
        yield Hypothesis(
            rule,
            f"{key} of {share * value:.3g}; {part}.plateaus.{key} is {value:g}",
            dict,
            _BY_TIME,
            partial(_shorter_than, shortest_s),
            {part: {"plateaus": {key: share * value}}},
        )


def _shorter_than(most_s: float, samples: Columns, levels: int) -> bool:
    return bool(np.ptp(samples["time_s"]) < most_s)


def traction_hypotheses(rig: Rig) -> Iterator[Hypothesis]:
    """Mistakes of the logs of a traction rig, the most frequent first."""
    yield from time_hypotheses()
    for words, factor in _FORCE_UNITS.items():
        undo = scaled(factor, "traction_force_n")
        usual = partial(_usual_traction, undo)
        yield Hypothesis("force_scale", f"a traction force {words}", undo, _BY_FORCE, usual)
    ratios, factors = {"speeds": 1.0}, dict(_SPEED_UNITS)
    if rig.ball_track_radius_m is not None and rig.disc_track_radius_m is not None:
        ratios["spindle speeds"] = rig.ball_track_radius_m / rig.disc_track_radius_m
        factors |= {
            (unit, label): _SPINDLE_UNITS[unit] / _SPINDLE_UNITS[label]
            for unit, label in permutations(_SPINDLE_UNITS, 2)
        }
    for words, ratio in ratios.items():
        sentence = f"the {words} of ball and disc exchanged"
        yield Hypothesis("swapped_channels", sentence, partial(_exchanged, ratio), _BY_SLIP)
    for names, words, _ in _SPEEDS:
        yield Hypothesis(
            "speed_sign", f"the opposite sign of {words}", scaled(-1.0, *names), _BY_SLIP
        )
    for names, words, explains in _SPEEDS:
        for (unit, label), factor in factors.items():
            sentence = f"{words} {factor:.4g} times as large, as {unit} labelled {label} would be"
            undo = scaled(factor, *names)
            yield Hypothesis("speed_unit", sentence, undo, explains, partial(_rolls_with, undo))
    sentence = "its slide-roll ratio in percent"
    yield Hypothesis("slip_unit", sentence, _from_percent, _BY_SLIP, _turns_backwards)
    # behind the units, which name the cause more precisely; the radii of another rig do this
    if "spindle speeds" in ratios:
        for body, words in ((_BALL, "ball"), (_DISC, "disc")):
            sentence = f"the {words}'s speed changed by the one ratio that makes both ends roll"
            undo = partial(_rolling_at_ends, body)
            yield Hypothesis("track_radii", sentence, undo, _BY_SLIP, _one_ratio_at_ends)


def _rolling_at_ends(body: str, samples: Columns) -> Columns:
    """One body's speed such that both are equal before the sweep."""
    ratio, _ = _ratios_at_ends(samples)
    return scaled(ratio if body == _BALL else 1 / ratio, body)(samples)


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


def _usual_traction(undo: Callable[[Columns], Columns], samples: Columns, levels: int) -> bool:
    """Whether the largest forces are those of an oil once a mistake is undone."""
    force_n, load_n = (np.abs(undo(samples)[f"{name}_n"]) for name in ("traction_force", "load"))
    return bool(np.quantile(force_n, _ALMOST_ALL) > _USUAL * median(load_n))


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
    return {**samples, _BALL: np.asarray(mean - sliding / 2), _DISC: np.asarray(mean + sliding / 2)}
