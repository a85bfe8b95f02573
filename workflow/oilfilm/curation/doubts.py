"""Warnings about a run that is used: what is not wrong for certain, with the likely cause.

Decides: warnings about a run that is used.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from oilfilm.curation.gate import Limits, Run, TractionLimits
from oilfilm.curation.run_gates import median_sliding_traction, possible_force_units
from oilfilm.curation.statistics import MAD_TO_SIGMA, changed, is_noise, median, quantile

# Small and large readings, over the largest; so many give the noise to within a tenth.
_SMALL, _LARGE, _ALMOST_ALL = 0.2, 0.8, 0.99
_CHANGES = 60
# Sensors have the same noise at any reading, and vibrations add to it.
_NOISE_LEFT = 0.6
# A fixed interval is kept to so much of it: a logger's hardware does, a program's timer does not.
_FIXED = 0.03
# Steps this many times further off than almost all others are not its rounding.
_FAR_OFF = 3


def little_traction(run: Run, limits: Limits) -> str:
    """The traction is less than oils have, though not impossible."""
    if not isinstance(limits, TractionLimits):
        return ""
    size = median_sliding_traction(run, limits)
    usual = limits.gates.sliding_traction_usual
    if not size < usual:
        return ""
    return (
        f"the median traction coefficient above a slip of {limits.gates.sign_slip_min:g} is "
        f"{size:.2g}; few oils have less than {usual:g}{possible_force_units(size, limits)}"
    )


def soft_saturation(run: Run, limits: Limits) -> str:
    """The sensor has less noise at its largest readings: its amplifier compresses them."""
    if np.isnan(run.plateaus["duration_s"]).all():
        return ""  # settled readings
    readings = run.working[run.sensor.column]
    size = np.abs(readings[1:-1])
    largest = quantile(size, _ALMOST_ALL) if len(size) else 0.0
    # no ramp shows in second differences, which have six times the variance of the noise
    change = np.abs(np.diff(readings, 2)) / np.sqrt(6)
    parts = size < _SMALL * largest, size > _LARGE * largest
    if min(map(np.count_nonzero, parts)) < _CHANGES:
        return ""
    small, large = (MAD_TO_SIGMA * median(change[part]) for part in parts)
    if large >= _NOISE_LEFT * small or not is_noise(changed(size[parts[0]])):
        return ""
    name, unit = run.sensor.name, run.sensor.unit
    return (
        f"the noise of the {name} falls from {small:.2g} {unit} at small to {large:.2g} {unit} at "
        "large readings; the sensor or its amplifier may be near the end of its range and give too "
        "little there"
    )


def uneven_clock(run: Run, limits: Limits) -> str:
    """Rows come at a fixed interval, but a few of them do not: a digit of their time may be wrong.

    A clock that runs backwards or stands still is refused before.
    """
    gap_s, step = np.diff(run.signals.time_s), np.diff(run.signals.row)
    if len(gap_s) < _CHANGES:
        return ""
    beside = step == np.median(step)  # no row between them was refused
    interval_s = run.signals.interval_s
    off_s = np.where(beside, np.abs(gap_s - interval_s), 0.0)
    usual_s = float(np.quantile(off_s[beside], _ALMOST_ALL))
    if usual_s > _FIXED * interval_s:
        return ""
    odd = np.flatnonzero(off_s > max(_FAR_OFF * usual_s, _FIXED * interval_s))
    if len(odd) == 0:
        return ""
    first = int(odd[0])
    before, after = run.signals.row[[first, first + 1]]
    return (
        f"rows come every {interval_s:g} s, but {gap_s[first]:g} s pass between row {before} and "
        f"row {after} ({len(odd)} such steps); a digit of the time may be wrong, or rows are lost"
    )


DOUBTS: dict[str, Callable[[Run, Any], str]] = {
    each.__name__: each for each in (little_traction, soft_saturation, uneven_clock)
}


def warning(run: Run, limits: Limits) -> str:
    """All warnings about a run, each with its name; empty where there is none."""
    found = {name: doubt(run, limits) for name, doubt in DOUBTS.items()}
    return "; ".join(f"{name}: {sentence}" for name, sentence in found.items() if sentence)
