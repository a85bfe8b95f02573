"""From one run's signals to its plateaus: means, standard errors, traction coefficient."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from oilfilm.curation import statistics
from oilfilm.curation.gates import Columns, Trouble
from oilfilm.curation.plateaus import find_steps, settled_parts
from oilfilm.curation.signals import FloatArray, IndexArray, Signals
from oilfilm.curation.statistics import BoolArray
from oilfilm.curation.zero import PHASES, zero_reference


@dataclass(frozen=True)
class Measured:
    """Plateaus of one run, before the gates. `flaw` says why the run as a whole fails, if so.

    `points` has the measured columns of the table of points, each an array over the plateaus:
    tables are made of all runs at once, because a small one costs as much as a large one.
    """

    points: Columns
    flaw: Trouble | None = None


def measure_continuous(
    signals: Signals, settings: Mapping[str, Any], procedure: str = "rolling_phases"
) -> Measured:
    """Plateaus of a continuously logged run, less the zero of the force.

    Args:
        signals: The run.
        settings: Config's `curation`.
        procedure: Where the zero comes from (`Semantics.zero`).
    """
    interval = signals.interval_s
    signals = signals.turning()
    levels = settings["plateaus"]
    steps = find_steps(signals.slide_roll_ratio, signals.interval_s, levels)
    starts, stops = settled_parts(len(signals), steps, signals.interval_s, levels)
    # the opening phase gives the zero first; what is left of it is a plateau at no slip
    zero_length = round(settings["zero_reference"]["duration_s"] / interval)
    places = {
        "opening": slice(0, min(zero_length, int(stops[0])) if len(steps) else 0),
        "closing": slice(int(starts[-1]), int(stops[-1])) if len(steps) else slice(0, 0),
    }
    phases = {name: places[name] for name in PHASES[procedure]}
    zero = zero_reference(
        signals, phases, settings["zero_reference"], settings["spikes"]["threshold"]
    )
    if "closing" in phases and not isinstance(zero, str):
        starts, stops = starts[:-1], stops[:-1]
    if "opening" in phases and len(starts):
        starts[0] = phases["opening"].stop
        if (stops[0] - starts[0]) * interval < levels["min_duration_s"]:
            # nothing is lost: the phase has served the zero
            starts, stops = starts[1:], stops[1:]
    # a level cut off before it settled is a plateau of its last row, for the gate to refuse
    stops = np.maximum(stops, 1)
    starts = np.minimum(starts, stops - 1)
    points = _average(
        signals, starts, stops, settings["spikes"]["threshold"], levels["transient_share"]
    )
    points["duration_s"] = (stops - starts) * interval
    if isinstance(zero, str):
        return Measured(_with_traction(points, math.nan, math.nan), Trouble("zero_missing", zero))
    drift_n, allowed_n = zero.drift_n, settings["zero_reference"]["max_drift_n"]
    flaw = None
    if abs(drift_n) > allowed_n:
        moves = f"the zero of the force moves by {drift_n:.3g} N during the run"
        flaw = Trouble("zero_drift", f"{moves}; allowed {allowed_n:g} N")
    time_s = points["time_s"]
    return Measured(_with_traction(points, zero.at(time_s), zero.standard_error_at(time_s)), flaw)


def measure_readings(signals: Signals) -> Measured:
    """Points of a run whose rows are settled readings already, the zero taken by the rig."""
    nothing = np.full(len(signals), np.nan)
    first, second = signals.traction_force_1_n, signals.traction_force_2_n
    both = np.abs(first) + np.abs(second)
    asymmetry = np.divide(np.abs(first + second), both, out=nothing.copy(), where=both > 0)
    averages = {
        "first_row": signals.row,
        "last_row": signals.row,
        "n_samples": np.ones(len(signals), dtype=np.int64),
        "n_spikes": np.zeros(len(signals), dtype=np.int64),
        "time_s": signals.time_s,
        "slide_roll_ratio": signals.slide_roll_ratio,
        "slide_roll_ratio_se": nothing,
        "entrainment_speed_m_s": signals.entrainment_speed_m_s,
        "load_n": signals.load_n,
        "load_se_n": nothing,
        "inlet_temperature_c": signals.inlet_temperature_c,
        "sensor_force_n": signals.traction_force_n,
        "sensor_force_se_n": nothing,
        "slip_change": nothing,
        "force_change_n": nothing,
        "slip_transient": nothing,
        "force_transient_n": nothing,
        "force_asymmetry": asymmetry,
        "measured_film_thickness_um": signals.measured_film_thickness_um,
        "duration_s": nothing,
    }
    return Measured(_with_traction(averages, 0.0, 0.0))


def _average(
    signals: Signals,
    starts: IndexArray,
    stops: IndexArray,
    spike_threshold: float,
    transient_share: float,
) -> Columns:
    # many short sums cost more in calls than in numbers: the signals go together
    values, inside = statistics.cut(
        np.stack(
            [
                signals.slide_roll_ratio,
                signals.traction_force_n,
                signals.load_n,
                signals.time_s,
                signals.entrainment_speed_m_s,
                signals.inlet_temperature_c,
            ]
        ),
        starts,
        stops,
    )
    wild = statistics.spikes(values[1], inside, spike_threshold)
    inside &= ~wild
    slip, force_n, load_n, time_s, speed_m_s, temperature_c = statistics.means(values, inside)
    slip_se, force_se_n, load_se_n = statistics.standard_errors(values[:3], inside)
    slip_change, force_change_n = _difference(values[:2], inside, 1 / 2)
    slip_transient, force_transient_n = -_difference(values[:2], inside, transient_share)
    nothing = np.full(len(starts), np.nan)
    return {
        "first_row": signals.row[starts],
        "last_row": signals.row[stops - 1],
        "n_samples": inside.sum(axis=1),
        "n_spikes": wild.sum(axis=1),
        "time_s": time_s,
        "slide_roll_ratio": slip,
        "slide_roll_ratio_se": slip_se,
        "entrainment_speed_m_s": speed_m_s,
        "load_n": load_n,
        "load_se_n": load_se_n,
        "inlet_temperature_c": temperature_c,
        "sensor_force_n": force_n,
        "sensor_force_se_n": force_se_n,
        "slip_change": slip_change,
        "force_change_n": force_change_n,
        "slip_transient": slip_transient,
        "force_transient_n": force_transient_n,
        "force_asymmetry": nothing,
        "measured_film_thickness_um": nothing,
    }


def _difference(values: FloatArray, inside: BoolArray, share: float) -> FloatArray:
    """Mean over what follows the first `share` of each plateau, less the mean over that share."""
    first = statistics.first_part(inside, share)
    return statistics.means(values, inside & ~first) - statistics.means(values, first)


# No traction rig loads a contact less; below it F/W is noise over nothing.
LEAST_LOAD_N = 1e-6
# Columns that serve the traction coefficient and are no part of the table.
_BETWEEN = (
    "sensor_force_n",
    "sensor_force_se_n",
    "load_se_n",
    "force_change_n",
    "force_transient_n",
)


def _with_traction(
    averages: Columns, zero_n: FloatArray | float, zero_se_n: FloatArray | float
) -> Columns:
    """Traction force above the zero, mu = F/W and its standard error."""
    load = np.where(averages["load_n"] > LEAST_LOAD_N, averages["load_n"], np.nan)
    force = averages["sensor_force_n"] - zero_n
    mu = force / load
    force_se = np.hypot(averages["sensor_force_se_n"], zero_se_n)
    mu_se = np.hypot(force_se, mu * averages["load_se_n"]) / load
    kept = {name: values for name, values in averages.items() if name not in _BETWEEN}
    return {
        **kept,
        "traction_force_n": force,
        "traction_coefficient": mu,
        "traction_coefficient_se": mu_se,
        "traction_change": averages["force_change_n"] / load,
        "traction_transient": averages["force_transient_n"] / load,
    }
