"""The plateaus of a run from its signals: steps, zero, means, standard errors, changes.

Decides: where a log is steady, and how much of a plateau is used; mean and standard error of a
plateau; when a missing zero refuses a run.
"""

from dataclasses import replace

import numpy as np
import pandas as pd

from oilfilm.base.ties import exceeds, reaches
from oilfilm.base.units import MAD_TO_SIGMA, FloatArray, IndexArray
from oilfilm.curation.rig_kind import Division, MeasuredRun, RigKind, Signals, unknown_values
from oilfilm.curation.statistics import Stretches, median, rows_per_reading
from oilfilm.curation.zero import (
    moved_zero_refusal,
    short_phase_refusal,
    sliding_phase_refusal,
    zero_reference,
)
from oilfilm.logs.base import ColumnArrays, Refusal
from oilfilm.settings.config import StepSettings


def measure_run(
    signals: Signals, rig_kind: RigKind, rig_name: str, is_settled: bool = False
) -> MeasuredRun:
    """The plateaus of a run, less the zero of its sensor.

    Args:
        signals: The run.
        rig_kind: The kind of rig, with its settings.
        rig_name: Name of its file.
        is_settled: Whether each row is a settled reading, the zero removed by the rig.
    """
    if is_settled:
        plateaus = _settled_readings(signals, rig_kind)
        run = MeasuredRun(rig_kind, signals, signals, plateaus, is_settled=True)
        return replace(run, refusal=rig_kind.settled_readings_refusal(run))
    division = rig_kind.divide_run(signals, rig_name)
    usable_signals = division.signals
    phases, refusal = _usable_phases(division, rig_kind)
    phases_to_cut_off = phases if division.are_phases_in_levels else []
    starts, stops = _levels_without_phases(division, phases_to_cut_off, rig_kind)
    averages = average_plateaus(usable_signals, starts, stops, rig_kind)
    if refusal is not None:
        zero_of_plateau = zero_of_plateau_se = unknown_values(len(starts))
    else:
        spike_threshold = rig_kind.settings.curation.spikes.threshold
        zero = zero_reference(
            division.phase_signals, rig_kind.sensor.column, division.phases, spike_threshold
        )
        zero_of_plateau = zero.zero_at(averages["time_s"])
        zero_of_plateau_se = zero.standard_error_at(averages["time_s"])
        refusal = moved_zero_refusal(
            zero, division, rig_kind.sensor, rig_kind.zero_drift_max, rig_kind.gate_limits
        )
    plateaus = rig_kind.derive_plateaus(averages, zero_of_plateau, zero_of_plateau_se)
    running_signals = usable_signals.select(division.running_selection)
    run = MeasuredRun(
        rig_kind,
        signals,
        running_signals,
        plateaus,
        refusal,
        division.short_level_refusals,
        tuple(division.phases),
    )
    ramp = rig_kind.measured_ramp(run, division, rig_name)
    return ramp or replace(run, refusal=rig_kind.zero_refusal(run, division, rig_name))


def _settled_readings(signals: Signals, rig_kind: RigKind) -> ColumnArrays:
    """Plateaus of one row each, without errors and changes; the rig has removed the zero."""
    count = len(signals)
    rows = np.arange(count)
    averages: ColumnArrays = dict(signals.columns) | average_plateaus(
        signals, rows, rows + 1, rig_kind
    )
    averages["duration_s"] = unknown_values(count)
    averages["n_samples"] = np.ones(count, dtype=np.int64)
    return rig_kind.derive_plateaus(
        averages, zero_of_plateau=np.zeros(count), zero_of_plateau_se=unknown_values(count)
    )


def _usable_phases(division: Division, rig_kind: RigKind) -> tuple[list[slice], Refusal | None]:
    """The phases at rest before the first that gives no zero, and the refusal by that one."""
    usable_phases: list[slice] = []
    largest_slip = rig_kind.settings.curation.zero_reference.max_slide_roll_ratio
    for name, phase in division.phases.items():
        phase_in_words = f"{name} phase of {division.rest_in_words}"
        refusal = short_phase_refusal(
            division.phase_signals, phase, phase_in_words, rig_kind.zero_settings.min_duration_s
        )
        if refusal is None and division.are_phases_in_levels:
            refusal = sliding_phase_refusal(division, name, largest_slip)
        if refusal is not None:
            return usable_phases, refusal
        usable_phases.append(phase)
    return usable_phases, None


def _levels_without_phases(
    division: Division, phases: list[slice], rig_kind: RigKind
) -> tuple[IndexArray, IndexArray]:
    """Starts and stops of the levels without the phases that gave the zero.

    The rest of such a level is a plateau if it is long enough. A level that ended before it settled
    has no settled part: it stops at its start, or before.
    """
    interval_s = division.signals.interval_s
    starts, stops = division.level_starts, division.level_stops
    for phase in phases:
        has_phase = (starts < phase.stop) & (stops > phase.start)
        starts = np.where(has_phase, phase.stop, starts)
        remaining_s = (stops - starts) * interval_s
        is_kept = ~has_phase | reaches(remaining_s, rig_kind.plateau_settings.min_duration_s)
        starts = starts[is_kept]
        stops = stops[is_kept]
    if len(division.signals) == 0:
        return starts[:0], stops[:0]
    return starts, stops


def average_plateaus(
    signals: Signals, starts: IndexArray, stops: IndexArray, rig_kind: RigKind
) -> ColumnArrays:
    """Means over plateaus without spikes of the sensor, with errors, changes and transients.

    A level without a settled part is a plateau of one row with a duration of 0, which a gate
    refuses.

    Args:
        signals: The run.
        starts: Index of the first sample of each plateau.
        stops: Index after its last sample.
        rig_kind: The kind of rig, with its settings.
    """
    curation_settings = rig_kind.settings.curation
    settled_rows = np.maximum(stops - starts, 0)
    stops = np.maximum(stops, 1)
    starts = np.minimum(starts, stops - 1)
    stretches = Stretches(starts, stops)
    sensor = signals[rig_kind.sensor.column]
    is_spike = stretches.spikes(stretches.cut(sensor), curation_settings.spikes.threshold)
    is_used = ~is_spike
    is_in_first_half = stretches.is_in_first_part(is_used, 1 / 2)
    is_in_beginning = stretches.is_in_first_part(
        is_used, curation_settings.plateaus.transient_share
    )
    # a reading of a slow sensor is repeated in so many rows, and counts once
    rows_held = rows_per_reading(sensor)
    averages: ColumnArrays = {
        "first_row": signals.row_numbers[starts],
        "last_row": signals.row_numbers[stops - 1],
        "n_samples": stretches.counts(is_used) // rows_held,
        "n_spikes": stretches.counts(is_spike) // rows_held,
        "duration_s": settled_rows * signals.interval_s,
        "time_s": stretches.means(stretches.cut(signals.time_s), is_used),
    }
    # one signal at a time: the memory of a long log must not grow with the number of signals
    for name in rig_kind.mean_columns:
        plateau_samples = stretches.cut(signals[name])
        mean = stretches.means(plateau_samples, is_used)
        averages[name] = mean
        if name in rig_kind.columns_with_error:
            averages[f"{name}_se"] = stretches.standard_errors(plateau_samples, is_used, mean)
        if name in rig_kind.columns_with_change:
            mean_of_second_half = stretches.means(plateau_samples, is_used & ~is_in_first_half)
            averages[f"{name}_change"] = mean_of_second_half - stretches.means(
                plateau_samples, is_in_first_half
            )
        if name in rig_kind.columns_with_transient:
            mean_of_remainder = stretches.means(plateau_samples, is_used & ~is_in_beginning)
            averages[f"{name}_transient"] = (
                stretches.means(plateau_samples, is_in_beginning) - mean_of_remainder
            )
    return averages


def find_steps(
    signal: FloatArray, interval_s: float, min_step: float, plateau_settings: StepSettings
) -> IndexArray:
    """Indices at which a signal steps to another level.

    The means over a window before and after each instant are compared. A step is a peak of their
    difference above both `min_step` and `noise_factor` standard errors. The noise is estimated from
    the differences of neighbouring samples.

    Args:
        signal: Slide-roll ratio or speed, shape (n,), finite.
        interval_s: Time between samples.
        min_step: Smallest step, in the unit of the signal.
        plateau_settings: `window_s` and `noise_factor`.
    """
    window_samples = max(round(plateau_settings.window_s / interval_s), 2)
    if len(signal) < 2 * window_samples:
        return np.array([], dtype=np.int64)
    running_sum = np.concatenate([[0.0], np.cumsum(signal)])
    window_sums = running_sum[window_samples:] - running_sum[:-window_samples]
    # the first difference is at the first sample with a full window before it
    mean_change = (
        np.abs(window_sums[window_samples:] - window_sums[:-window_samples]) / window_samples
    )
    noise = MAD_TO_SIGMA * median(np.abs(np.diff(signal))) / np.sqrt(2)
    limit = max(min_step, plateau_settings.noise_factor * noise * np.sqrt(2 / window_samples))
    # noise may give two peaks within a window for one step: the higher one counts, or the first of
    # equals
    highest_around = (
        pd.Series(mean_change).rolling(2 * window_samples + 1, center=True, min_periods=1).max()
    )
    is_peak = reaches(mean_change, highest_around.to_numpy())
    peak_indices = np.flatnonzero(is_peak & exceeds(mean_change, limit))
    distance_to_last_peak = np.diff(peak_indices, prepend=-window_samples - 1)
    return window_samples + peak_indices[distance_to_last_peak > window_samples]


def settled_parts(
    sample_count: int, steps: IndexArray, interval_s: float, plateau_settings: StepSettings
) -> tuple[IndexArray, IndexArray]:
    """First index of the steady part of each level between the steps, and the index after its last.

    `settle_s` is cut off after each step. `guard_s` is cut off before the next one, because noise
    makes the position of a step uncertain. The first level has no step before it. A level that ends
    before it has settled starts after its own stop.
    """
    settle_rows = round(plateau_settings.settle_s / interval_s)
    guard_rows = round(plateau_settings.guard_s / interval_s)
    starts = np.concatenate([[0], steps + settle_rows])
    stops = np.concatenate([steps - guard_rows, [sample_count]])
    return np.minimum(starts, sample_count), stops
