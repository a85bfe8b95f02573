"""The gates: every reason for which a run or a point is refused, one small named function each.

A run gate looks at one run's signals and says what is wrong, in a sentence, and where, or nothing.
A point gate looks at all points at once and says which fail; where it refuses every point of a
run, its `describe` gives the sentence for the run.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from oilfilm.curation.signals import Signals
from oilfilm.curation.statistics import longest_hold
from oilfilm.units import conversion

BoolArray = npt.NDArray[np.bool_]
FloatArray = npt.NDArray[np.float64]
Limits = Mapping[str, Any]
# Plateaus of one run: column -> array over them.
Columns = dict[str, npt.NDArray[Any]]

# What a load may be in where it is said to be in N.
_LOAD_UNITS = ("kgf", "lbf", "gf")


@dataclass(frozen=True)
class Trouble:
    """Why a run is refused; the rows where it was seen, 0 where it is the run as a whole.

    `gate` is the name of the gate or rule that found it.
    """

    gate: str
    reason: str
    first_row: int = 0
    last_row: int = 0


@dataclass(frozen=True)
class RunGate:
    """A check of one run's signals and plateaus.

    `judge` gives the sentence and the first and last row concerned (0, 0: none in particular), or
    None where the run passes.
    """

    name: str
    advice: str
    judge: Callable[[Signals, Columns, Limits], tuple[str, int, int] | None]


@dataclass(frozen=True)
class PointGate:
    """A check of points. Points carry the nominal conditions of their run beside their own."""

    name: str
    advice: str
    fails: Callable[[pd.DataFrame, Limits], BoolArray]
    describe: Callable[[pd.DataFrame, Limits], str]


Finding = tuple[str, int, int] | None


def _stuck_sensor(signals: Signals, points: Columns, limits: Limits) -> Finding:
    force, duration_s = signals.traction_force_n, limits["stuck_duration_s"]
    start, stop = longest_hold(force)
    long_enough = (stop - start) * signals.interval_s >= duration_s
    if not long_enough or stop - start < limits["stuck_samples"]:
        return None
    first, last = int(signals.row[start]), int(signals.row[stop - 1])
    return (
        f"the traction force stays at exactly {force[start]:g} N from row {first} to row {last}; "
        f"expected noise within {duration_s:g} s",
        first,
        last,
    )


def _swapped_sign(signals: Signals, points: Columns, limits: Limits) -> Finding:
    slip = points["slide_roll_ratio"]
    sliding = np.abs(slip) > limits["sign_slip_min"]
    along = points["traction_force_n"][sliding] * np.sign(slip[sliding])
    middle = float(np.median(along)) if len(along) else 0.0
    if not middle < 0 or (along < 0).mean() < limits["sign_share"]:
        return None
    return (
        f"the traction force acts against the slip ({middle:.3g} N in the middle); "
        "expected the slower body to be dragged along",
        0,
        0,
    )


def _time_disorder(signals: Signals, points: Columns, limits: Limits) -> Finding:
    backward = np.flatnonzero(np.diff(signals.time_s) <= 0)
    if len(backward) == 0:
        return None
    place = int(backward[0])
    before, after = int(signals.row[place]), int(signals.row[place + 1])
    return (
        f"time does not go on at {len(backward)} rows, first from {signals.time_s[place]:g} s at "
        f"row {before} to {signals.time_s[place + 1]:g} s at row {after}; expected rising time "
        "stamps",
        before,
        after,
    )


def _clock_jump(signals: Signals, points: Columns, limits: Limits) -> Finding:
    gaps = np.diff(signals.time_s)
    longest = limits["clock_jump_intervals"] * signals.interval_s
    if len(gaps) == 0 or gaps.max() <= longest:
        return None
    place = int(np.argmax(gaps))
    before, after = int(signals.row[place]), int(signals.row[place + 1])
    return (
        f"{gaps[place]:g} s pass between row {before} and row {after}; expected no gap over "
        f"{longest:g} s",
        before,
        after,
    )


def _saturated(signals: Signals, points: Columns, limits: Limits) -> Finding:
    for name, values in (
        ("traction force", signals.traction_force_n),
        ("load", signals.load_n),
    ):
        for extreme in (np.max(values), np.min(values)):
            at_stop = np.flatnonzero(values == extreme)
            share = len(at_stop) / len(values)
            if (
                len(at_stop) >= limits["stuck_samples"]
                and share > limits["saturated_share"]
                and _piled_up(values, extreme, limits["piled_up_factor"])
            ):
                first, last = int(signals.row[at_stop[0]]), int(signals.row[at_stop[-1]])
                return (
                    f"the {name} stands at its extreme of {extreme:g} N in {share:.1%} of the "
                    f"rows, between row {first} and row {last}; allowed "
                    f"{limits['saturated_share']:.1%}",
                    first,
                    last,
                )
    return None


def _piled_up(values: FloatArray, extreme: float, factor: float) -> bool:
    """True where an extreme value stands more than `factor` times as often as the next one.

    A sensor at its stop gives one value again and again, with noise on one side only. Values that
    are coarse anyway are not piled up, nor is the load of a dead weight.
    """
    levels, counts = np.unique(values, return_counts=True)
    place, neighbour = (-1, -2) if extreme == levels[-1] else (0, 1)
    return len(levels) > 1 and bool(counts[place] > factor * counts[neighbour])


def _temperature_drift(signals: Signals, points: Columns, limits: Limits) -> Finding:
    levels = points["inlet_temperature_c"]
    levels = levels[~np.isnan(levels)]
    if len(levels) == 0 or levels.max() - levels.min() <= limits["temperature_drift_max_c"]:
        return None
    return (
        f"the inlet temperature goes from {levels.min():.1f} to {levels.max():.1f} degC within "
        f"the run; allowed {limits['temperature_drift_max_c']:g} degC",
        0,
        0,
    )


def _branches_differ(signals: Signals, points: Columns, limits: Limits) -> Finding:
    slip, mu = points["slide_roll_ratio"], points["traction_coefficient"]
    known = ~np.isnan(slip) & ~np.isnan(mu)
    slip, mu = slip[known], mu[known]
    turn = _turning_point(slip, limits["branch_points"])
    if turn is None:
        return None
    # interpolation asks for rising slips
    one, other = np.argsort(slip[: turn + 1]), turn + np.argsort(slip[turn:])
    low = max(slip[one].min(), slip[other].min())
    high = min(slip[one].max(), slip[other].max())
    shared = one[(slip[one] >= low) & (slip[one] <= high)]
    if len(shared) < limits["branch_points"]:
        return None
    # the middle one, because single wild points are the business of other gates
    difference = float(
        np.median(np.abs(mu[shared] - np.interp(slip[shared], slip[other], mu[other])))
    )
    if difference <= limits["branch_difference_max"]:
        return None
    return (
        f"going up and down in slip the traction coefficients differ by {difference:.4f} (median "
        f"over {len(shared)} points); allowed {limits['branch_difference_max']:g}",
        0,
        0,
    )


def _turning_point(slip: FloatArray, least: int) -> int | None:
    """Index at which a sweep turns back: its inner extreme; None where it goes one way only.

    Fewer points than `least` on either side of it are no branch.
    """
    if len(slip) < 2 * least:
        return None
    extremes = np.array([np.argmax(slip), np.argmin(slip)])
    from_end = np.minimum(extremes, len(slip) - 1 - extremes)
    turn = int(extremes[np.argmax(from_end)])
    return turn if from_end.max() >= least else None


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
        "Check the polarity of the force sensor and which body is slowed; the campaign file says "
        "both (semantics: traction_sign, slower_body).",
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
    RunGate(
        "branches_differ",
        "The contact or its temperature changed during the sweep: look at the specimens and repeat "
        "the run.",
        _branches_differ,
    ),
)


def _off_nominal(points: pd.DataFrame, name: str, tolerance: float) -> BoolArray:
    nominal = points[f"nominal_{name}"]
    return ((points[name] - nominal).abs() > tolerance * nominal).to_numpy()


def _describe_load(points: pd.DataFrame, limits: Limits) -> str:
    load, nominal = points["load_n"].mean(), points["nominal_load_n"].iloc[0]
    hints = [
        f"; {load / nominal:.4f} is the ratio of {unit} to N, so the load may be in {unit}"
        for unit in _LOAD_UNITS
        if abs(load / nominal * conversion(unit, ("N",)).scale - 1) < 2 * limits["load_tolerance"]
    ]
    return (
        f"the load is {load:.2f} N on average, nominal {nominal:.2f} N "
        f"(tolerance {limits['load_tolerance']:.0%}){''.join(hints)}"
    )


def _distance_to_plan(points: pd.DataFrame, planned: Sequence[float]) -> FloatArray:
    """Distance of each point's slip from the nearest planned one; 0 where none was planned."""
    if not planned:
        return np.zeros(len(points))
    slip = points["slide_roll_ratio"].to_numpy()
    return np.abs(slip[:, np.newaxis] - np.array(planned)).min(axis=1)


def _film_off_trend(points: pd.DataFrame, factor: float) -> BoolArray:
    """Measured films further than `factor` from the power law in speed that their run follows.

    The law is the repeated-median line of ln h against ln U, which holds with up to half of the
    readings wrong (A. F. Siegel, Biometrika 69 (1982) 242).
    """
    # imported where needed: it takes a second, and few campaigns measure films
    from scipy.stats import siegelslopes  # noqa: PLC0415

    readings = points[
        (points["measured_film_thickness_um"] > 0) & (points["entrainment_speed_m_s"] > 0)
    ]
    off = pd.Series(False, index=points.index)
    for _, of_run in readings.groupby("run_id"):
        film = np.log(of_run["measured_film_thickness_um"].to_numpy())
        speed = np.log(of_run["entrainment_speed_m_s"].to_numpy())
        if np.ptp(speed) > 0:
            trend = siegelslopes(film, speed)
            residual = film - trend.intercept - trend.slope * speed
            off[of_run.index] = np.abs(residual) > np.log(factor)
    return off.to_numpy()


def _span(values: pd.Series, form: str) -> str:
    return f"{values.min():{form}} to {values.max():{form}}"


POINT_GATES = (
    PointGate(
        "traction_missing",
        "Such rows carry no traction; nothing to do if the step was not meant to.",
        lambda points, limits: (
            points[["traction_coefficient", "slide_roll_ratio"]].isna().any(axis=1).to_numpy()
        ),
        lambda points, limits: "no traction force, load above zero or slip was logged",
    ),
    PointGate(
        "too_short",
        "Hold each slip longer than settle_s + min_duration_s of config.yaml.",
        lambda points, limits: (points["duration_s"] < limits["min_duration_s"]).to_numpy(),
        lambda points, limits: (
            f"{_span(points['duration_s'], '.2f')} s are left of each plateau once it has settled; "
            f"expected {limits['min_duration_s']:g} s or more"
        ),
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
        "slip_off_set_point",
        "Check the control of the slip and the planned slips of the campaign file.",
        lambda points, limits: (
            _distance_to_plan(points, limits["planned_slips"]) > limits["slip_tolerance"]
        ),
        lambda points, limits: (
            "the slide-roll ratio is up to "
            f"{_distance_to_plan(points, limits['planned_slips']).max():.4f} away from every "
            f"planned one (tolerance {limits['slip_tolerance']:g})"
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
        "transient_not_ended",
        "Let the rig settle longer after each step, or raise settle_s of config.yaml.",
        lambda points, limits: (
            (points["slip_transient"].abs() > limits["slip_transient_max"])
            | (points["traction_transient"].abs() > limits["traction_transient_max"])
        ).to_numpy(),
        lambda points, limits: (
            f"the first {limits['transient_share']:.0%} of the plateaus differ from the rest by up "
            f"to {points['slip_transient'].abs().max():.4f} in slip and "
            f"{points['traction_transient'].abs().max():.4f} in traction; allowed "
            f"{limits['slip_transient_max']:g} and {limits['traction_transient_max']:g}"
        ),
    ),
    PointGate(
        "spiky",
        "Look for a loose contact or a disturbance near the sensor's cable.",
        lambda points, limits: (
            points["n_spikes"]
            > limits["spike_share_max"] * (points["n_samples"] + points["n_spikes"])
        ).to_numpy(),
        lambda points, limits: (
            f"up to {points['n_spikes'].max()} spikes stand in a plateau; allowed "
            f"{limits['spike_share_max']:.0%} of its rows"
        ),
    ),
    PointGate(
        "film_off_trend",
        "Check the fringe order of these readings.",
        lambda points, limits: _film_off_trend(points, limits["film_trend_factor"]),
        lambda points, limits: (
            "the measured film thickness does not follow a power of the entrainment speed within "
            f"a factor of {limits['film_trend_factor']:g}"
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


def judge_run(signals: Signals, points: Columns, limits: Limits) -> Trouble | None:
    """What the first run gate that refuses the run found; None if all let it pass."""
    for gate in RUN_GATES:
        finding = gate.judge(signals, points, limits)
        if finding is not None:
            return Trouble(gate.name, *finding)
    return None


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
        "columns_disagree": "Look at the columns' units, the track radii of the rig file and the "
        "campaign file's semantics (slide_roll_ratio, slower_body); logged_twice of config.yaml "
        "says how far they may differ.",
        "zero_missing": "Begin and end every run with a few seconds of pure rolling.",
        "zero_drift": "Let the sensor warm up, check its mounting, and repeat the run.",
        "no_rows": "Look whether the logger wrote anything, or repeat the run.",
        "no_plateau": "Hold each slip longer than settle_s + min_duration_s of config.yaml.",
        "no_point_left": "Look at the gates that are named, one by one.",
        "duplicate_log": "Take one of the files out; a copy adds nothing.",
        "repeated_label": "Give each run a name of its own, or take one of the logs out.",
        "duplicate_condition": "Take one of the logs out, or say repeated_conditions: accept.",
    }[name]
