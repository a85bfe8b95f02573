"""The gates: every reason for which a run or a point is refused, one small named function each.

A run gate looks at one run's signals and says what is wrong, in a sentence, or nothing. A point
gate looks at all points at once and says which fail; where it refuses every point of a run, its
`describe` gives the sentence for the run.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from oilfilm.curation.plateaus import sampling_interval
from oilfilm.curation.signals import Signals

BoolArray = npt.NDArray[np.bool_]
Limits = Mapping[str, Any]

# What a load is multiplied by when its unit is mistaken for N.
_LOAD_UNITS = {"kgf": 1 / 9.80665, "lbf": 1 / 4.4482216, "gf": 1000 / 9.80665}


@dataclass(frozen=True)
class RunGate:
    """A check of one run's signals and plateaus: a sentence where it fails, else empty."""

    name: str
    advice: str
    judge: Callable[[Signals, pd.DataFrame, Limits], str]


@dataclass(frozen=True)
class PointGate:
    """A check of points. Points carry the nominal conditions of their run beside their own."""

    name: str
    advice: str
    fails: Callable[[pd.DataFrame, Limits], BoolArray]
    describe: Callable[[pd.DataFrame, Limits], str]


def _stuck_sensor(signals: Signals, points: pd.DataFrame, limits: Limits) -> str:
    force, duration_s = signals.traction_force_n, limits["stuck_duration_s"]
    changes = np.flatnonzero(np.diff(force) != 0) + 1
    edges = np.concatenate([[0], changes, [len(force)]])
    longest = int(np.argmax(np.diff(edges)))
    start, stop = int(edges[longest]), int(edges[longest + 1])
    long_enough = (stop - start) * sampling_interval(signals.time_s) >= duration_s
    if not long_enough or stop - start < limits["stuck_samples"]:
        return ""
    return (
        f"the traction force stays at exactly {force[start]:g} N from row {signals.row[start]} to "
        f"row {signals.row[stop - 1]}; expected noise within {duration_s:g} s"
    )


def _swapped_sign(signals: Signals, points: pd.DataFrame, limits: Limits) -> str:
    sliding = points[points["slide_roll_ratio"].abs() > 0.02]
    along = sliding["traction_force_n"] * np.sign(sliding["slide_roll_ratio"])
    if sliding.empty or not along.median() < 0 or (along < 0).mean() < 0.9:
        return ""
    return (
        f"the traction force acts against the slip ({along.median():.3g} N in the middle); "
        "expected the slower body to be dragged along"
    )


def _time_disorder(signals: Signals, points: pd.DataFrame, limits: Limits) -> str:
    backward = np.flatnonzero(np.diff(signals.time_s) <= 0)
    if len(backward) == 0:
        return ""
    place = int(backward[0])
    return (
        f"time does not go on at {len(backward)} rows, first from {signals.time_s[place]:g} s at "
        f"row {signals.row[place]} to {signals.time_s[place + 1]:g} s at row "
        f"{signals.row[place + 1]}; expected rising time stamps"
    )


def _clock_jump(signals: Signals, points: pd.DataFrame, limits: Limits) -> str:
    gaps = np.diff(signals.time_s)
    longest = limits["clock_jump_intervals"] * sampling_interval(signals.time_s)
    if len(gaps) == 0 or gaps.max() <= longest:
        return ""
    place = int(np.argmax(gaps))
    return (
        f"{gaps[place]:g} s pass between row {signals.row[place]} and row "
        f"{signals.row[place + 1]}; expected no gap over {longest:g} s"
    )


def _saturated(signals: Signals, points: pd.DataFrame, limits: Limits) -> str:
    for name, values in (
        ("traction force", signals.traction_force_n),
        ("load", signals.load_n),
    ):
        for extreme in (np.max(values), np.min(values)):
            # a sensor at its stop gives one value over and over, with noise on one side only
            at_stop = np.flatnonzero(values == extreme)
            share = len(at_stop) / len(values)
            if len(at_stop) >= limits["stuck_samples"] and share > limits["saturated_share"]:
                return (
                    f"the {name} stands at its extreme of {extreme:g} N in {share:.1%} of the "
                    f"rows, first at row {signals.row[at_stop[0]]}; allowed "
                    f"{limits['saturated_share']:.1%}"
                )
    return ""


def _temperature_drift(signals: Signals, points: pd.DataFrame, limits: Limits) -> str:
    levels = points["inlet_temperature_c"]
    if len(points) == 0 or levels.max() - levels.min() <= limits["temperature_drift_max_c"]:
        return ""
    return (
        f"the inlet temperature goes from {levels.min():.1f} to {levels.max():.1f} degC within "
        f"the run; allowed {limits['temperature_drift_max_c']:g} degC"
    )


RUN_GATES = (
    RunGate(
        "time_disorder",
        "Check the logger's clock, and whether two logs were joined.",
        _time_disorder,
    ),
    RunGate(
        "clock_jump",
        "The logger paused or its clock was set: repeat the run.",
        _clock_jump,
    ),
    RunGate(
        "stuck_sensor",
        "Check the force sensor, its cable and amplifier, and repeat the run.",
        _stuck_sensor,
    ),
    RunGate(
        "swapped_sign",
        "Check the polarity of the force sensor and which body is slowed.",
        _swapped_sign,
    ),
    RunGate(
        "saturated",
        "Choose a wider range of the sensor or its amplifier.",
        _saturated,
    ),
    RunGate(
        "temperature_drift",
        "Let rig and oil warm through before the sweep.",
        _temperature_drift,
    ),
)


def _off_nominal(points: pd.DataFrame, name: str, tolerance: float) -> BoolArray:
    nominal = points[f"nominal_{name}"]
    return ((points[name] - nominal).abs() > tolerance * nominal).to_numpy()


def _describe_load(points: pd.DataFrame, limits: Limits) -> str:
    load, nominal = points["load_n"].mean(), points["nominal_load_n"].iloc[0]
    hints = [
        f"; {load / nominal:.4f} is the ratio of {unit} to N, so the load may be in {unit}"
        for unit, ratio in _LOAD_UNITS.items()
        if abs(load / nominal / ratio - 1) < 2 * limits["load_tolerance"]
    ]
    return (
        f"the load is {load:.2f} N on average, nominal {nominal:.2f} N "
        f"(tolerance {limits['load_tolerance']:.0%}){''.join(hints)}"
    )


def _span(values: pd.Series, form: str) -> str:
    return f"{values.min():{form}} to {values.max():{form}}"


POINT_GATES = (
    PointGate(
        "traction_missing",
        "Such rows carry no traction; nothing to do if the step was not meant to.",
        lambda points, limits: (
            points[["traction_coefficient", "slide_roll_ratio"]].isna().any(axis=1).to_numpy()
        ),
        lambda points, limits: "no traction force, load or slip was logged",
    ),
    PointGate(
        "load_off_nominal",
        "Check the load's unit and calibration and the set point in the header.",
        lambda points, limits: _off_nominal(points, "load_n", limits["load_tolerance"]),
        _describe_load,
    ),
    PointGate(
        "speed_off_nominal",
        "Check the spindle control, the track radii of the rig file and the set point.",
        lambda points, limits: _off_nominal(
            points, "entrainment_speed_m_s", limits["speed_tolerance"]
        ),
        lambda points, limits: (
            f"the entrainment speed is {_span(points['entrainment_speed_m_s'], '.3f')} m/s, "
            f"nominal {points['nominal_entrainment_speed_m_s'].iloc[0]:g} m/s "
            f"(tolerance {limits['speed_tolerance']:.0%})"
        ),
    ),
    PointGate(
        "temperature_off_nominal",
        "Check the temperature control and the set point.",
        lambda points, limits: (
            (points["inlet_temperature_c"] - points["nominal_inlet_temperature_c"]).abs()
            > limits["temperature_tolerance_c"]
        ).to_numpy(),
        lambda points, limits: (
            f"the inlet temperature is {_span(points['inlet_temperature_c'], '.1f')} degC, nominal "
            f"{points['nominal_inlet_temperature_c'].iloc[0]:g} degC "
            f"(tolerance {limits['temperature_tolerance_c']:g} degC)"
        ),
    ),
    PointGate(
        "slip_out_of_range",
        "Check the spindle speeds: one of them may have slipped for a moment.",
        lambda points, limits: (
            ~points["slide_roll_ratio"].between(
                limits["slide_roll_ratio_min"], limits["slide_roll_ratio_max"]
            )
        ).to_numpy(),
        lambda points, limits: (
            f"the slide-roll ratio is {_span(points['slide_roll_ratio'], '.4f')}, expected "
            f"{limits['slide_roll_ratio_min']:g} to {limits['slide_roll_ratio_max']:g}"
        ),
    ),
    PointGate(
        "not_steady",
        "Let the rig settle longer, or check its control.",
        lambda points, limits: (
            (points["slip_change"].abs() > limits["slip_change_max"])
            | (points["traction_change"].abs() > limits["traction_change_max"])
        ).to_numpy(),
        lambda points, limits: (
            f"slip or traction changes within the plateaus by up to "
            f"{points['slip_change'].abs().max():.4f} and "
            f"{points['traction_change'].abs().max():.4f}; allowed "
            f"{limits['slip_change_max']:g} and {limits['traction_change_max']:g}"
        ),
    ),
    PointGate(
        "force_not_reversed",
        "Let the force settle after the rig reverses the slip.",
        lambda points, limits: (
            (points["slide_roll_ratio"].abs() > limits["asymmetry_slip_min"])
            & (points["force_asymmetry"] > limits["asymmetry_max"])
        ).to_numpy(),
        lambda points, limits: (
            f"|TF1 + TF2| is {_span(points['force_asymmetry'], '.2f')} of |TF1| + |TF2|, allowed "
            f"{limits['asymmetry_max']:g}: one direction of the slip had not reversed"
        ),
    ),
    PointGate(
        "traction_unphysical",
        "Check the zero and the calibration of the force sensor.",
        lambda points, limits: (
            (points["traction_coefficient"] < limits["traction_min"])
            | (points["traction_coefficient"] > limits["traction_max"])
        ).to_numpy(),
        lambda points, limits: (
            f"the traction coefficient is {_span(points['traction_coefficient'], '.4f')}, "
            f"expected {limits['traction_min']:g} to {limits['traction_max']:g}"
        ),
    ),
    PointGate(
        "thin_film",
        "Raise the speed, or lower the temperature or the load: this is mixed lubrication.",
        lambda points, limits: (points["film_judgement"] == "below limit").to_numpy(),
        lambda points, limits: (
            f"the lambda ratio is {_span(points['lambda_ratio'], '.2f')}; full film needs more "
            f"than {limits['lambda_limit']:g}"
        ),
    ),
    PointGate(
        "film_not_judged",
        "Fill in the rig's geometry, materials and roughness and the oil's properties, or set "
        "film_unjudged in the campaign file, with a reason.",
        lambda points, limits: (
            (points["film_judgement"] == "cannot be judged") & (not limits["accept_unjudged_film"])
        ).to_numpy(),
        lambda points, limits: (
            "the film thickness cannot be calculated: geometry, material, roughness or oil "
            "properties are not known"
        ),
    ),
)


def judge_run(signals: Signals, points: pd.DataFrame, limits: Limits) -> str:
    """The first run gate that refuses the run, as `name: sentence`; empty if none does."""
    for gate in RUN_GATES:
        sentence = gate.judge(signals, points, limits)
        if sentence:
            return f"{gate.name}: {sentence}"
    return ""


def judge_points(points: pd.DataFrame, limits: Limits) -> pd.DataFrame:
    """Which point gates fail: one boolean column a gate, one row a point.

    A gate whose quantity is null (no set point, no reversed force) does not refuse.
    """
    return pd.DataFrame(
        {gate.name: gate.fails(points, limits) for gate in POINT_GATES}, index=points.index
    )


def advice_for(name: str) -> str:
    """What to do about a run refused by the gate or rule of that name."""
    advices: dict[str, str] = {gate.name: gate.advice for gate in (*RUN_GATES, *POINT_GATES)}
    return {
        **advices,
        "truncated": "Repeat the run; the disk may have been full or the program killed.",
        "zero_missing": "Begin and end every run with a few seconds of pure rolling.",
        "zero_drift": "Let the sensor warm up, check its mounting, and repeat the run.",
        "no_plateau": "Hold each slip longer than settle_s + min_duration_s of config.yaml.",
        "no_point_left": "Look at the gates that are named, one by one.",
        "duplicate_condition": "Take one of the logs out, or say repeated_conditions: accept.",
    }[name]
