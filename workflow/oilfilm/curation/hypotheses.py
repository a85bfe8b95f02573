"""What may be wrong with a refused run: simple mistakes, each tried, before the last resort.

A log in the wrong unit, or with two columns exchanged, fails gates that have nothing to do with its
cause. A hypothesis undoes one such mistake. Where the run then passes, the mistake is named.

Decides: which simple mistakes (units, exchanged columns) are tried and named.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import permutations

import numpy as np

from oilfilm.curation.gate import Columns
from oilfilm.curation.statistics import median
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
    """

    rule: str
    sentence: str
    undo: Callable[[Columns], Columns]
    explains: frozenset[str]
    plausible: Callable[[Columns, int], bool] = lambda samples, levels: True


_BY_TIME = frozenset(
    "too_short not_steady transient_not_ended no_point_left many_plateaus_fail zero_missing "
    "no_plateau zero_drift".split()
)
_BY_FORCE = _BY_TIME | {"traction_unphysical", "impossible_traction"}
_BY_SLIP = _BY_TIME | {
    *("swapped_sign", "speed_off_nominal", "slip_out_of_range", "slip_off_set_point")
}
# Both speeds together leave the slip as it is.
_BY_SPEED = frozenset({"speed_off_nominal"})

# Refusals that a mistake of another kind may cause.
DOUBTFUL = _BY_TIME | _BY_FORCE | _BY_SLIP | _BY_SPEED

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


def traction_hypotheses(rig: Rig) -> Iterator[Hypothesis]:
    """Mistakes of the logs of a traction rig, the most frequent first."""
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
