"""From one run's signals to its plateaus: steps, zero, means, standard errors, changes.

Decides: where a log is steady, and how much of a plateau is used; mean and standard error of a
plateau; when a missing zero refuses a run.
"""

from dataclasses import replace

import numpy as np
import pandas as pd

from oilfilm.curation import statistics
from oilfilm.curation.rig_kind import Division, RigKind, Run, Signals, nothing
from oilfilm.curation.statistics import median
from oilfilm.curation.zero import moved_zero, phase_too_short, sliding_phase, zero_reference
from oilfilm.logs.base import Columns, Refusal
from oilfilm.settings.config import StepSettings
from oilfilm.ties import exceeds, reaches
from oilfilm.units import MAD_TO_SIGMA, BoolArray, FloatArray, IndexArray


def measure(signals: Signals, rig: RigKind, name: str, settled: bool = False) -> Run:
    """The plateaus of a run, less the zero of its sensor.

    Args:
        signals: The run.
        rig: The rig.
        name: Name of its file.
        settled: Each row is a settled reading already, the zero removed by the rig.
    """
    if settled:
        return Run(rig, signals, signals, _readings(signals, rig))
    parts = rig.divide(signals, name)
    usable = parts.signals
    served, flaw = _usable_phases(parts, rig)
    starts, stops = _without(parts, served if parts.in_levels else [], rig)
    averages = average(usable, starts, stops, rig)
    if flaw is not None:
        output = output_se = nothing(len(starts))
    else:
        spike = rig.settings.curation.spikes.threshold
        zero = zero_reference(parts.at_rest, rig.sensor.column, parts.phases, spike)
        output, output_se = zero.at(averages["time_s"]), zero.standard_error_at(averages["time_s"])
        flaw = moved_zero(zero, parts, rig.sensor, rig.zero_drift_max, rig.gates)
    plateaus, working = rig.derive(averages, output, output_se), usable.at(parts.working)
    run = Run(rig, signals, working, plateaus, flaw, parts.too_short)
    return replace(run, flaw=rig.zero_fault(run, parts, name))


def _readings(signals: Signals, rig: RigKind) -> Columns:
    """Each row as a plateau without errors and changes; the rig has removed the zero."""
    rows = np.arange(len(signals))
    alone = average(signals, rows, rows + 1, rig)
    averages = {**signals.columns, **alone, "duration_s": nothing(len(rows))}
    averages["n_samples"] = np.ones(len(rows), dtype=np.int64)
    return rig.derive(averages, np.zeros(len(rows)), nothing(len(rows)))


def _usable_phases(parts: Division, rig: RigKind) -> tuple[list[slice], Refusal | None]:
    """The phases at rest up to the first that gives no zero, and what is wrong with that one."""
    usable: list[slice] = []
    slip = rig.settings.curation.zero_reference.max_slide_roll_ratio
    for name, part in parts.phases.items():
        words, least_s = f"{name} phase of {parts.words}", rig.zero.min_duration_s
        problem = phase_too_short(parts.at_rest, part, words, least_s)
        if problem is None and parts.in_levels:
            problem = sliding_phase(parts, name, slip)
        if problem is not None:
            return usable, problem
        usable.append(part)
    return usable, None


def _without(parts: Division, phases: list[slice], rig: RigKind) -> tuple[IndexArray, IndexArray]:
    """Starts and stops of the levels less the phases that have served the zero.

    What is left of such a level is a plateau where it is long enough.
    """
    signals, starts, stops = parts.signals, parts.starts, parts.stops
    for phase in phases:
        served = (starts < phase.stop) & (stops > phase.start)
        starts = np.where(served, phase.stop, starts)
        left_s = (stops - starts) * signals.interval_s
        kept = ~served | reaches(left_s, rig.plateaus.min_duration_s)
        starts, stops = starts[kept], stops[kept]
    if len(signals) == 0:
        return starts[:0], stops[:0]
    # a level cut off before it settled is a plateau of its last row, for the gate to refuse
    stops = np.maximum(stops, 1)
    return np.minimum(starts, stops - 1), stops


def average(signals: Signals, starts: IndexArray, stops: IndexArray, rig: RigKind) -> Columns:
    """Means over plateaus, spikes of the sensor left out, with errors, changes and transients.

    Args:
        signals: The run.
        starts: First sample of each plateau.
        stops: The sample past its last one.
        rig: The rig.
    """
    settings = rig.settings.curation
    names = ("time_s", *rig.means)
    logged = np.stack([signals.time_s, *(signals[name] for name in rig.means)])
    stretches, inside = statistics.cut(logged, starts, stops)
    values = dict(zip(names, stretches, strict=True))
    wild = statistics.spikes(values[rig.sensor.column], inside, settings.spikes.threshold)
    inside &= ~wild
    rows = statistics.rows_per_reading(signals[rig.sensor.column])
    means = dict(zip(names, statistics.means(stretches, inside), strict=True))
    shares = 1 / 2, settings.plateaus.transient_share
    halves, beginning = (statistics.first_part(inside, part) for part in shares)
    return {
        "first_row": signals.row[starts],
        "last_row": signals.row[stops - 1],
        "n_samples": inside.sum(axis=1) // rows,
        "n_spikes": wild.sum(axis=1) // rows,
        "duration_s": (stops - starts) * signals.interval_s,
        **means,
        **{
            f"{name}_se": statistics.standard_errors(values[name], inside, means[name])
            for name in rig.errors
        },
        **{f"{name}_change": -_excess(values[name], inside, halves) for name in rig.changes},
        **{
            f"{name}_transient": _excess(values[name], inside, beginning) for name in rig.transients
        },
    }


def _excess(values: FloatArray, inside: BoolArray, first: BoolArray) -> FloatArray:
    """Mean of each plateau over its first samples, less the mean over the others."""
    return statistics.means(values, first) - statistics.means(values, inside & ~first)


def find_steps(
    level: FloatArray, interval_s: float, min_step: float, settings: StepSettings
) -> IndexArray:
    """Indices at which a signal steps to another level.

    The means over a window before and after each instant are compared; a step is where their
    difference peaks, above both `min_step` and `noise_factor` standard errors, the noise being
    judged from the differences of neighbouring samples.

    Args:
        level: Slide-roll ratio or speed, shape (n,), finite.
        interval_s: Time between samples.
        min_step: Smallest step, in the unit of the signal.
        settings: `window_s` and `noise_factor` of config's plateaus.
    """
    window = max(round(settings.window_s / interval_s), 2)
    if len(level) < 2 * window:
        return np.array([], dtype=np.int64)
    total = np.concatenate([[0.0], np.cumsum(level)])
    sums = total[window:] - total[:-window]
    # the first difference is at the first sample with a full window before it
    change = np.abs(sums[window:] - sums[:-window]) / window
    noise = MAD_TO_SIGMA * median(np.abs(np.diff(level))) / np.sqrt(2)
    limit = max(min_step, settings.noise_factor * noise * np.sqrt(2 / window))
    # two peaks within a window are one step seen twice through the noise: the higher one counts,
    # of two that are equally high the first
    around = pd.Series(change).rolling(2 * window + 1, center=True, min_periods=1)
    is_peak = reaches(change, around.max().to_numpy())
    peaks = np.flatnonzero(is_peak & exceeds(change, limit))
    return window + peaks[np.diff(peaks, prepend=-window - 1) > window]


def settled_parts(
    samples: int, steps: IndexArray, interval_s: float, settings: StepSettings
) -> tuple[IndexArray, IndexArray]:
    """First and past-the-last index of the steady part of each level between the steps.

    `settle_s` is cut off after each step and `guard_s` before the next one, because a step is
    located only to within the noise. The level before the first step has had no step to settle
    from. A level that ends before it has settled starts after its own stop.
    """
    settle = round(settings.settle_s / interval_s)
    guard = round(settings.guard_s / interval_s)
    starts = np.concatenate([[0], steps + settle])
    stops = np.concatenate([steps - guard, [samples]])
    return np.minimum(starts, samples), stops
