"""The plateaus of a run from its signals: steps, zero, means, standard errors, changes.

Decides: where a log is steady, and how much of a plateau is used; mean and standard error of a
plateau; when a missing zero refuses a run.
"""

from dataclasses import replace

import numpy as np
import pandas as pd

from oilfilm.base.ties import exceeds, reaches
from oilfilm.base.units import MAD_TO_SIGMA, FloatArray, IndexArray
from oilfilm.curation import statistics
from oilfilm.curation.rig_kind import Division, RigKind, Run, Signals, unknown_values
from oilfilm.curation.statistics import Stretches, median
from oilfilm.curation.zero import moved_zero, phase_too_short, sliding_phase, zero_reference
from oilfilm.logs.base import Columns, Refusal
from oilfilm.settings.config import StepSettings


def measure(signals: Signals, rig: RigKind, rig_name: str, is_settled: bool = False) -> Run:
    """The plateaus of a run, less the zero of its sensor.

    Args:
        signals: The run.
        rig: The rig.
        rig_name: Name of its file.
        is_settled: Whether each row is a settled reading, the zero removed by the rig.
    """
    if is_settled:
        run = Run(rig, signals, signals, _settled_readings(signals, rig))
        return replace(run, flaw=rig.settled_fault(run))
    division = rig.divide(signals, rig_name)
    usable = division.signals
    phases, flaw = _usable_phases(division, rig)
    phases_to_cut_off = phases if division.phases_in_levels else []
    starts, stops = _levels_without_phases(division, phases_to_cut_off, rig)
    averages = average(usable, starts, stops, rig)
    if flaw is not None:
        zero_output = zero_output_se = unknown_values(len(starts))
    else:
        spike_threshold = rig.settings.curation.spikes.threshold
        zero = zero_reference(division.at_rest, rig.sensor.column, division.phases, spike_threshold)
        zero_output = zero.zero_at(averages["time_s"])
        zero_output_se = zero.standard_error_at(averages["time_s"])
        flaw = moved_zero(zero, division, rig.sensor, rig.zero_drift_max, rig.gates)
    plateaus = rig.derive(averages, zero_output, zero_output_se)
    working = usable.select(division.working)
    run = Run(rig, signals, working, plateaus, flaw, division.too_short, tuple(division.phases))
    ramp = rig.measured_ramp(run, division, rig_name)
    return ramp or replace(run, flaw=rig.zero_fault(run, division, rig_name))


def _settled_readings(signals: Signals, rig: RigKind) -> Columns:
    """Each row as a plateau without errors and changes; the rig has removed the zero."""
    count = len(signals)
    rows = np.arange(count)
    averages: Columns = dict(signals.columns) | average(signals, rows, rows + 1, rig)
    averages["duration_s"] = unknown_values(count)
    averages["n_samples"] = np.ones(count, dtype=np.int64)
    return rig.derive(averages, zero=np.zeros(count), zero_se=unknown_values(count))


def _usable_phases(division: Division, rig: RigKind) -> tuple[list[slice], Refusal | None]:
    """The phases at rest before the first that gives no zero, and the fault of that one."""
    usable: list[slice] = []
    max_slip = rig.settings.curation.zero_reference.max_slide_roll_ratio
    for name, phase in division.phases.items():
        phase_in_words = f"{name} phase of {division.rest_in_words}"
        problem = phase_too_short(
            division.at_rest, phase, phase_in_words, rig.zero_settings.min_duration_s
        )
        if problem is None and division.phases_in_levels:
            problem = sliding_phase(division, name, max_slip)
        if problem is not None:
            return usable, problem
        usable.append(phase)
    return usable, None


def _levels_without_phases(
    division: Division, phases: list[slice], rig: RigKind
) -> tuple[IndexArray, IndexArray]:
    """Starts and stops of the levels without the phases that gave the zero.

    The rest of such a level is a plateau if it is long enough.
    """
    interval_s = division.signals.interval_s
    starts, stops = division.starts, division.stops
    for phase in phases:
        has_phase = (starts < phase.stop) & (stops > phase.start)
        starts = np.where(has_phase, phase.stop, starts)
        rest_s = (stops - starts) * interval_s
        kept = ~has_phase | reaches(rest_s, rig.plateau_settings.min_duration_s)
        starts = starts[kept]
        stops = stops[kept]
    if len(division.signals) == 0:
        return starts[:0], stops[:0]
    # a level that ended before it settled becomes a plateau of its last row, which a gate refuses
    stops = np.maximum(stops, 1)
    return np.minimum(starts, stops - 1), stops


def average(signals: Signals, starts: IndexArray, stops: IndexArray, rig: RigKind) -> Columns:
    """Means over plateaus without spikes of the sensor, with errors, changes and transients.

    Args:
        signals: The run.
        starts: Index of the first sample of each plateau.
        stops: Index after its last sample.
        rig: The rig.
    """
    settings = rig.settings.curation
    stretches = Stretches(starts, stops)
    sensor = signals[rig.sensor.column]
    spikes = stretches.spikes(stretches.cut(sensor), settings.spikes.threshold)
    inside = ~spikes
    first_half = stretches.first_part(inside, 1 / 2)
    beginning = stretches.first_part(inside, settings.plateaus.transient_share)
    rows_per_reading = statistics.rows_per_reading(sensor)
    averages: Columns = {
        "first_row": signals.row[starts],
        "last_row": signals.row[stops - 1],
        "n_samples": stretches.counts(inside) // rows_per_reading,
        "n_spikes": stretches.counts(spikes) // rows_per_reading,
        "duration_s": (stops - starts) * signals.interval_s,
        "time_s": stretches.means(stretches.cut(signals.time_s), inside),
    }
    # one signal at a time: the memory of a long log must not grow with the number of signals
    for name in rig.means:
        values = stretches.cut(signals[name])
        averages[name] = mean = stretches.means(values, inside)
        if name in rig.errors:
            averages[f"{name}_se"] = stretches.standard_errors(values, inside, mean)
        if name in rig.changes:
            mean_of_rest = stretches.means(values, inside & ~first_half)
            averages[f"{name}_change"] = mean_of_rest - stretches.means(values, first_half)
        if name in rig.transients:
            mean_of_rest = stretches.means(values, inside & ~beginning)
            averages[f"{name}_transient"] = stretches.means(values, beginning) - mean_of_rest
    return averages


def find_steps(
    level: FloatArray, interval_s: float, min_step: float, settings: StepSettings
) -> IndexArray:
    """Indices at which a signal steps to another level.

    The means over a window before and after each instant are compared. A step is a peak of their
    difference above both `min_step` and `noise_factor` standard errors. The noise is estimated from
    the differences of neighbouring samples.

    Args:
        level: Slide-roll ratio or speed, shape (n,), finite.
        interval_s: Time between samples.
        min_step: Smallest step, in the unit of the signal.
        settings: `window_s` and `noise_factor` of config's plateaus.
    """
    window = max(round(settings.window_s / interval_s), 2)
    if len(level) < 2 * window:
        return np.array([], dtype=np.int64)
    running_sum = np.concatenate([[0.0], np.cumsum(level)])
    sums = running_sum[window:] - running_sum[:-window]
    # the first difference is at the first sample with a full window before it
    change = np.abs(sums[window:] - sums[:-window]) / window
    noise = MAD_TO_SIGMA * median(np.abs(np.diff(level))) / np.sqrt(2)
    limit = max(min_step, settings.noise_factor * noise * np.sqrt(2 / window))
    # noise may give two peaks within a window for one step: the higher one counts, or the first of
    # equals
    highest_around = pd.Series(change).rolling(2 * window + 1, center=True, min_periods=1).max()
    is_peak = reaches(change, highest_around.to_numpy())
    peaks = np.flatnonzero(is_peak & exceeds(change, limit))
    distance = np.diff(peaks, prepend=-window - 1)
    return window + peaks[distance > window]


def settled_parts(
    samples: int, steps: IndexArray, interval_s: float, settings: StepSettings
) -> tuple[IndexArray, IndexArray]:
    """First index of the steady part of each level between the steps, and the index after its last.

    `settle_s` is cut off after each step. `guard_s` is cut off before the next one, because noise
    makes the position of a step uncertain. The first level has no step before it. A level that ends
    before it has settled starts after its own stop.
    """
    settle = round(settings.settle_s / interval_s)
    guard = round(settings.guard_s / interval_s)
    starts = np.concatenate([[0], steps + settle])
    stops = np.concatenate([steps - guard, [samples]])
    return np.minimum(starts, samples), stops
