"""The gates of plateaus in the order in which they judge: a cause before its consequence.

Decides: when a plateau is refused (drift, load, temperature, spikes, film), and the advice.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd
import scipy

from oilfilm.curation.gate import (
    BOTH,
    HELD_LEVELS,
    MEASURED_TRACTION,
    TORQUE,
    TRACTION,
    Gates,
    Judgement,
    Limits,
    Need,
    PlateauJudge,
    TorqueLimits,
    TractionLimits,
)
from oilfilm.units import FloatArray, conversion

PLATEAU_GATES: Gates[PlateauJudge] = Gates()
gate = PLATEAU_GATES.gate

# So many standard errors are no chance.
_SURE = 5
# What a temperature may be in although it is labelled degC, and a load although it is labelled N.
_TEMPERATURE_UNITS = ("K", "degF")
_LOAD_UNITS = ("kgf", "lbf", "gf", "kN")


@gate(
    TRACTION,
    advice="Such rows carry no traction; nothing to do if the step was not meant to.",
    blames_run=False,
)
def traction_missing(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """Force, load or slip has no value."""
    missing = points[["traction_coefficient", "slide_roll_ratio"]].isna().any(axis=1)
    return Judgement(missing, "no traction force, load above zero or slip was logged")


@gate(
    *BOTH,
    advice="Hold each {level} longer than settle_s + min_duration_s of config.yaml.",
    blames_run=False,
    needs=HELD_LEVELS,
)
def too_short(points: pd.DataFrame, limits: Limits) -> Judgement:
    """Little is left of a level once it has settled."""
    duration_s, least_s = points["duration_s"], limits.plateaus.min_duration_s
    return Judgement(
        duration_s < least_s,
        f"{duration_s.min():.2f} s to {duration_s.max():.2f} s are left of each plateau once it "
        f"has settled; expected {least_s:g} s or more",
    )


@gate(
    TRACTION,
    advice="Check the load's unit and calibration, and its set point.",
    needs=Need(
        "nominal_load_n",
        "no set point of the load is given; one of pressure also needs the rig's geometry and "
        "materials",
    ),
)
def load_off_nominal(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """The load is not the one that was set."""
    load_n, nominal_n = points["load_n"].mean(), points["nominal_load_n"].median()
    allowed = limits.gates.load_tolerance
    hints = [
        f"; {load_n / nominal_n:.4g} is near the ratio of {unit} to N: the load may be in {unit}"
        for unit in _LOAD_UNITS
        if abs(load_n / nominal_n * conversion(unit, ("N",)).scale - 1) < 2 * allowed
    ]
    return Judgement(
        _off_nominal(points, "load_n", allowed),
        f"the mean load is {load_n:.2f} N, nominal {nominal_n:.2f} N (tolerance {allowed:.0%})"
        + "".join(hints),
    )


def _off_nominal(points: pd.DataFrame, name: str, tolerance: float) -> "pd.Series[bool]":
    nominal = points[f"nominal_{name}"]
    return (points[name] - nominal).abs() > tolerance * nominal


@gate(
    TRACTION,
    advice="Check the spindle control, the track radii of the rig file and the set point.",
    needs=Need("nominal_entrainment_speed_m_s", "no set point of the entrainment speed is given"),
)
def speed_off_nominal(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """The entrainment speed is not the one that was set."""
    allowed = limits.gates.speed_tolerance
    return Judgement(
        _off_nominal(points, "entrainment_speed_m_s", allowed),
        f"the entrainment speed is {_span(points['entrainment_speed_m_s'], '.3f')} m/s, nominal "
        f"{points['nominal_entrainment_speed_m_s'].median():g} m/s (tolerance {allowed:.0%})",
    )


def _span(values: "pd.Series[float]", form: str) -> str:
    """The range of a quantity over the plateaus, as in `0.10 to 0.25`."""
    return f"{values.min():{form}} to {values.max():{form}}"


@gate(
    TRACTION,
    advice="Check the temperature control and the set point.",
    needs=Need("nominal_inlet_temperature_c", "no set point of the inlet temperature is given"),
)
def temperature_off_nominal(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """The inlet temperature is not the one that was set."""
    temperature_c = points["inlet_temperature_c"]
    nominal_c = points["nominal_inlet_temperature_c"]
    allowed_c = limits.gates.temperature_tolerance_c
    hints = [
        f"; it would be {nominal_c.median():g} degC if it were in {unit}"
        for unit in _TEMPERATURE_UNITS
        if (
            (conversion(unit, ("degC",)).of(temperature_c.to_numpy()) - nominal_c).abs()
            <= allowed_c
        ).all()
    ]
    return Judgement(
        (temperature_c - nominal_c).abs() > allowed_c,
        f"the inlet temperature is {_span(temperature_c, '.1f')} degC, nominal "
        f"{nominal_c.median():g} degC (tolerance {allowed_c:g} degC)" + "".join(hints),
    )


@gate(
    TRACTION,
    advice="Check the spindle speeds: one of them may have slipped for a moment. Where all "
    "slips are negative, set slower_body under semantics of the campaign file.",
    blames_run=False,
)
def slip_out_of_range(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """The slide-roll ratio is one that no sweep reaches."""
    slip = points["slide_roll_ratio"]
    least, most = limits.gates.slide_roll_ratio_min, limits.gates.slide_roll_ratio_max
    hint = "; the other body may be the slower one" if slip.median() < least else ""
    return Judgement(
        ~slip.between(least, most),
        f"the slide-roll ratio is {_span(slip, '.4f')}; expected {least:g} to {most:g}{hint}",
    )


@gate(
    TRACTION,
    advice="Check the control of the slip and the planned slips of the campaign file.",
    blames_run=False,
    needs=Need(
        "planned_slips", "no slips are planned (set_points: slide_roll_ratio of the campaign file)"
    ),
)
def slip_off_set_point(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """The slide-roll ratio is none of the planned ones."""
    distance = _distance_to_plan(points, limits.planned_slips)
    return Judgement(
        distance > limits.gates.slip_tolerance,
        f"the slide-roll ratio is up to {distance.max(initial=0):.4f} away from every planned one "
        f"(tolerance {limits.gates.slip_tolerance:g})",
    )


def _distance_to_plan(points: pd.DataFrame, planned: Sequence[float]) -> FloatArray:
    """Distance of each point's slip from the nearest planned one; 0 where none was planned."""
    if not planned:
        return np.zeros(len(points))
    slip = points["slide_roll_ratio"].to_numpy()
    return np.abs(slip[:, np.newaxis] - np.array(planned)).min(axis=1)


@gate(
    TRACTION,
    advice="Change the slip in steps and let the rig settle longer, or check its control.",
    needs=HELD_LEVELS,
)
def not_steady(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """Slip or traction differs between the two halves of a plateau."""
    slip, traction = points["slip_change"].abs(), points["traction_change"].abs()
    most_slip, most_traction = limits.gates.slip_change_max, limits.gates.traction_change_max
    return Judgement(
        (slip > most_slip) | (traction > most_traction),
        f"slip and traction change within the plateaus by up to {slip.max():.4f} and "
        f"{traction.max():.4f}; allowed {most_slip:g} and {most_traction:g}",
    )


@gate(
    TRACTION,
    advice="Let the rig settle longer after each step, or raise settle_s of config.yaml.",
    needs=HELD_LEVELS,
)
def transient_not_ended(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """The beginning of a plateau differs from the rest of it."""
    slip, traction = points["slip_transient"].abs(), points["traction_transient"].abs()
    most_slip, most_traction = limits.gates.slip_transient_max, limits.gates.traction_transient_max
    return Judgement(
        (slip > most_slip) | (traction > most_traction),
        f"the first {limits.plateaus.transient_share:.0%} of the plateaus differ from the rest by "
        f"up to {slip.max():.4f} in slip and {traction.max():.4f} in traction; allowed "
        f"{most_slip:g} and {most_traction:g}",
    )


@gate(
    TORQUE,
    advice="Wait until the bearing has warmed through.",
    blames_run=False,
    needs=HELD_LEVELS,
)
def torque_drifts(points: pd.DataFrame, limits: TorqueLimits) -> Judgement:
    """The torque differs between the two halves of a plateau."""
    change = points["torque_change_n_m"].abs() / points["torque_n_m"].abs()
    return _by_change("torque", change, limits.gates.torque_change_max)


def _by_change(quantity: str, change: "pd.Series[float]", allowed: float) -> Judgement:
    """Judgement by a relative change within each plateau."""
    sentence = f"the {quantity} changes within the plateaus by up to {change.max():.1%}"
    return Judgement(change > allowed, f"{sentence}; allowed {allowed:.1%}")


@gate(
    *BOTH,
    advice="Check the load's control, and hold the load while the {level} steps.",
    needs=HELD_LEVELS,
)
def load_changes(points: pd.DataFrame, limits: Limits) -> Judgement:
    """The load differs between the two halves of a plateau."""
    return _by_change("load", points["load_change"].abs(), limits.gates.load_change_max)


@gate(
    *BOTH,
    advice="Wait until the temperature of the oil is steady.",
    blames_run=False,
    needs=HELD_LEVELS,
)
def temperature_changes(points: pd.DataFrame, limits: Limits) -> Judgement:
    """The oil's temperature differs between the two halves of a plateau."""
    change_c = points["temperature_change_c"].abs()
    allowed_c = limits.gates.temperature_change_max_c
    return Judgement(
        change_c > allowed_c,
        f"the temperature changes within the plateaus by up to {change_c.max():.2f} degC; allowed "
        f"{allowed_c:g} degC",
    )


@gate(
    *BOTH,
    advice="Look for a loose contact or a disturbance near the cable of the {sensor} sensor. Where "
    "the spikes are at the beginning or end of the plateau, a ramp of the {level} or of the speeds "
    "reaches into it: raise settle_s or guard_s of config.yaml.",
)
def spiky(points: pd.DataFrame, limits: Limits) -> Judgement:
    """Too many readings of a plateau are spikes."""
    spikes, allowed = points["n_spikes"], limits.gates.spike_share_max
    return Judgement(
        # a single one is left out of a plateau of few rows as well
        (spikes > 1) & (spikes > allowed * (points["n_samples"] + spikes)),
        f"up to {spikes.max()} readings of a plateau are spikes; allowed {allowed:.0%} of its rows",
    )


@gate(
    TRACTION,
    advice="Check the fringe order of these readings.",
    blames_run=False,
    needs=Need("measured_film_thickness_um", "the log has no measured film thickness"),
)
def film_off_trend(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """A measured film leaves the power law in speed that its run follows.

    The law is the repeated-median line of ln h against ln U, which holds with up to half of the
    readings wrong (A. F. Siegel, Biometrika 69 (1982) 242).
    """
    factor = limits.gates.film_trend_factor
    return Judgement(
        _off_trend(points, factor),
        "the measured film thickness does not follow a power of the entrainment speed within a "
        f"factor of {factor:g}",
    )


def _off_trend(points: pd.DataFrame, factor: float) -> npt.NDArray[np.bool_]:
    readings = points[
        (points["measured_film_thickness_um"] > 0) & (points["entrainment_speed_m_s"] > 0)
    ]
    off = pd.Series(False, index=points.index)
    if len(readings) == 0:
        return off.to_numpy()
    for _, of_run in readings.groupby("run_id"):
        film = np.log(of_run["measured_film_thickness_um"].to_numpy())
        speed = np.log(of_run["entrainment_speed_m_s"].to_numpy())
        if np.ptp(speed) > 0:
            trend = scipy.stats.siegelslopes(film, speed)
            residual = film - trend.intercept - trend.slope * speed
            off[of_run.index] = np.abs(residual) > np.log(factor)
    return off.to_numpy()


@gate(
    TRACTION,
    advice="Let the force settle after the rig reverses the slip.",
    needs=Need("force_asymmetry", "the log has no separate forces for the two directions of slip"),
)
def force_not_reversed(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """The force of one direction of slip had not reversed."""
    asymmetry, allowed = points["force_asymmetry"], limits.gates.asymmetry_max
    sliding = points["slide_roll_ratio"].abs() > limits.gates.asymmetry_slip_min
    return Judgement(
        sliding & (asymmetry > allowed),
        f"|TF1 + TF2| is {_span(asymmetry, '.2f')} of |TF1| + |TF2|, allowed {allowed:g}: one "
        "direction of the slip had not reversed",
    )


@gate(
    TRACTION,
    advice="Check the units of force and load, and the zero and calibration of the force sensor.",
    needs=MEASURED_TRACTION,
)
def traction_unphysical(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """The traction coefficient is one that no oil has."""
    mu, slip = points["traction_coefficient"], points["slide_roll_ratio"]
    least, most = limits.gates.traction_min, limits.gates.traction_max
    # a sweep may go to slips of the other sign, where the force has the other one too
    mu = mu.where(slip >= limits.gates.slide_roll_ratio_min, mu.abs())
    return Judgement(
        (mu < least) | (mu > most),
        f"the traction coefficient is {_span(mu, '.4f')}; expected {least:g} to {most:g}"
        f"{possible_load_units(points, limits)}",
    )


def possible_load_units(points: pd.DataFrame, limits: TractionLimits) -> str:
    """The units of the load that make usual traction coefficients of too large ones, as a hint."""
    sizes = points["traction_coefficient"].abs()
    sliding = points["slide_roll_ratio"].abs() > limits.gates.sign_slip_min
    middle, largest = sizes[sliding].median(), sizes.max()
    usual, most = limits.gates.sliding_traction_usual, limits.gates.traction_max
    scales = {unit: conversion(unit, ("N",)).scale for unit in _LOAD_UNITS}
    units = [
        f"{unit} (times {scale:.4g})"
        for unit, scale in scales.items()
        if largest > most and usual <= middle / scale and largest / scale <= most
    ]
    return f"; the load labelled N may be in {' or '.join(units)}" if units else ""


def slip_is_held(points: pd.DataFrame, limits: TractionLimits) -> "pd.Series[bool]":
    """Plateaus of which the slip is steady; on a ramp between two slips it is not."""
    change, transient = points["slip_change"].abs(), points["slip_transient"].abs()
    most, most_transient = limits.gates.slip_change_max, limits.gates.slip_transient_max
    return ~((change > most) | (transient > most_transient))


def surely_unphysical(points: pd.DataFrame, limits: TractionLimits) -> "pd.Series[bool]":
    """Plateaus whose traction coefficient is impossible by far more than its standard error.

    Without slip a zero that is slightly off makes a small coefficient negative.
    """
    mu, error = points["traction_coefficient"], points["traction_coefficient_se"].fillna(0.0)
    sliding = points["slide_roll_ratio"] > limits.gates.sign_slip_min
    above = mu - _SURE * error > limits.gates.traction_max
    return above | (sliding & (mu + _SURE * error < limits.gates.traction_min))


@gate(
    TRACTION,
    advice="Raise the speed, or lower the temperature or the load: this is mixed lubrication.",
    blames_run=False,
    needs=Need(
        "lambda_ratio",
        "lambda cannot be calculated: geometry, materials or roughness of the rig or properties "
        "of the oil are not known",
    ),
)
def thin_film(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """The film does not separate the surfaces."""
    return Judgement(
        points["film_judgement"] == "below limit",
        f"the lambda ratio is {_span(points['lambda_ratio'], '.2f')}; full film needs more than "
        f"{limits.gates.lambda_limit:g}",
    )


_CONDITIONS_OF_FILM = {
    "max_hertz_pressure_gpa": "GPa",
    "entrainment_speed_m_s": "m/s",
    "inlet_temperature_c": "degC",
}


@gate(
    TRACTION,
    advice="Check the units of load and speeds where these conditions are impossible. Else fill in "
    "the rig's geometry, materials and roughness and the oil's properties, or set film_unjudged in "
    "the campaign file, with a reason.",
    blames_run=False,
)
def film_not_judged(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """The film cannot be calculated, and the campaign does not accept that."""
    unknown = points["film_judgement"] == "cannot be judged"
    found = [
        f"{_span(points[name], '.3g')} {unit}"
        for name, unit in _CONDITIONS_OF_FILM.items()
        if name in points and points[name].notna().any()
    ]
    return Judgement(
        unknown & (not limits.accept_unjudged_film),
        "the film thickness cannot be calculated: geometry, material, roughness or oil properties "
        f"are not known, or no film formula holds at {', '.join(found) or 'these conditions'}",
    )


@gate(TORQUE, advice="Check the sign and the zero of the torque sensor.")
def torque_not_positive(points: pd.DataFrame, limits: TorqueLimits) -> Judgement:
    """The torque does not resist the motion."""
    torque = points["torque_n_m"]
    sentence = f"the torque is {_span(torque, '.3g')} N m; expected more than 0"
    return Judgement(~(torque > 0), sentence)


@gate(
    TORQUE,
    advice="Log the speed of the inner ring as positive: its torque is what resists it.",
    blames_run=False,
)
def turns_backwards(points: pd.DataFrame, limits: TorqueLimits) -> Judgement:
    """The speed is negative."""
    speed = points["inner_speed_rpm"]
    return Judgement(speed < 0, f"the speed is {_span(speed, '.0f')} rpm; expected more than 0")


@gate(
    TORQUE,
    advice="Check the load cell: a ball bearing of this kind must be pushed together.",
    blames_run=False,
)
def unloaded(points: pd.DataFrame, limits: TorqueLimits) -> Judgement:
    """Nothing pushes the bearing together."""
    load = points["axial_load_n"]
    sentence = f"the axial load is {_span(load, '.3g')} N; expected more than 0"
    return Judgement(~(load > 0), sentence)
