"""The gates of plateaus in the order in which they judge: a cause before its consequence.

Decides: when a plateau is refused (drift, load, temperature, spikes, film).
"""

from collections.abc import Callable, Mapping

import numpy as np
import pandas as pd
import scipy

from oilfilm.curation.gate import (
    Gates,
    Judgement,
    Limits,
    PlateauJudge,
    TorqueLimits,
    TractionLimits,
    unit_hint,
)
from oilfilm.units import BoolArray

PLATEAU_GATES: Gates[PlateauJudge] = Gates()
gate = PLATEAU_GATES.gate

# So many standard errors are no chance.
_SURE = 5
# What a temperature may be in although it is labelled degC.
_IN_DEGC: Mapping[str, Callable[["pd.Series[float]"], "pd.Series[float]"]] = {
    "K": lambda kelvin: kelvin - 273.15,
    "degF": lambda fahrenheit: (fahrenheit - 32) / 1.8,
}


def _span(values: "pd.Series[float]", form: str) -> str:
    """The range of a quantity over the plateaus, as in `0.10 to 0.25`."""
    return f"{values.min():{form}} to {values.max():{form}}"


def _off_nominal(points: pd.DataFrame, name: str, tolerance: float) -> "pd.Series[bool]":
    nominal = points[f"nominal_{name}"]
    return (points[name] - nominal).abs() > tolerance * nominal


def _by_changes(
    points: pd.DataFrame, name: str, most_slip: float, most_traction: float, words: str
) -> Judgement:
    """Judgement by a change of slip and of traction within each plateau."""
    slip, traction = points[f"slip_{name}"].abs(), points[f"traction_{name}"].abs()
    return Judgement(
        (slip > most_slip) | (traction > most_traction),
        f"{words} by up to {slip.max():.4f} in slip and {traction.max():.4f} in traction; allowed "
        f"{most_slip:g} and {most_traction:g}",
    )


def _by_change(quantity: str, change: "pd.Series[float]", allowed: float) -> Judgement:
    """Judgement by a relative change within each plateau."""
    sentence = f"the {quantity} changes within the plateaus by up to {change.max():.1%}"
    return Judgement(change > allowed, f"{sentence}; allowed {allowed:.1%}")


def _must_be_positive(points: pd.DataFrame, name: str, words: str) -> Judgement:
    found = words.format(_span(points[name], ".3g"))
    return Judgement(~(points[name] > 0), f"the {found}; expected more than 0")


@gate
def traction_missing(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """Force, load or slip has no value."""
    missing = points[["traction_coefficient", "slide_roll_ratio"]].isna().any(axis=1)
    return Judgement(missing, "no traction force, load above zero or slip was logged")


@gate
def too_short(points: pd.DataFrame, limits: Limits) -> Judgement:
    """Little is left of a level once it has settled."""
    duration_s, least_s = points["duration_s"], limits.plateaus.min_duration_s
    return Judgement(
        duration_s < least_s,
        f"{duration_s.min():.2f} s to {duration_s.max():.2f} s are left of each plateau once it "
        f"has settled; expected {least_s:g} s or more",
    )


@gate
def load_off_nominal(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """The load is not the one that was set."""
    load_n, nominal_n = points["load_n"].mean(), points["nominal_load_n"].median()
    allowed, ratio = limits.gates.load_tolerance, load_n / nominal_n
    hint = unit_hint("load", lambda scale: abs(ratio * scale - 1) < 2 * allowed)
    return Judgement(
        _off_nominal(points, "load_n", allowed),
        f"the mean load is {load_n:.2f} N, nominal {nominal_n:.2f} N (tolerance {allowed:.0%})"
        f"{hint}",
    )


@gate
def speed_off_nominal(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """The entrainment speed is not the one that was set."""
    allowed = limits.gates.speed_tolerance
    return Judgement(
        _off_nominal(points, "entrainment_speed_m_s", allowed),
        f"the entrainment speed is {_span(points['entrainment_speed_m_s'], '.3f')} m/s, nominal "
        f"{points['nominal_entrainment_speed_m_s'].median():g} m/s (tolerance {allowed:.0%})",
    )


@gate
def temperature_off_nominal(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """The inlet temperature is not the one that was set."""
    found_c, nominal_c = points["inlet_temperature_c"], points["nominal_inlet_temperature_c"]
    allowed_c = limits.gates.temperature_tolerance_c
    units = [
        unit
        for unit, in_degc in _IN_DEGC.items()
        if ((in_degc(found_c) - nominal_c).abs() <= allowed_c).all()
    ]
    hint = f"; it may be in {units[0]}" if units else ""
    return Judgement(
        (found_c - nominal_c).abs() > allowed_c,
        f"the inlet temperature is {_span(found_c, '.1f')} degC, nominal "
        f"{nominal_c.median():g} degC (tolerance {allowed_c:g} degC){hint}",
    )


@gate
def slip_out_of_range(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """The slide-roll ratio is one that no sweep reaches."""
    slip = points["slide_roll_ratio"]
    least, most = limits.gates.slide_roll_ratio_min, limits.gates.slide_roll_ratio_max
    hint = "; the other body may be the slower one" if slip.median() < least else ""
    return Judgement(
        ~slip.between(least, most),
        f"the slide-roll ratio is {_span(slip, '.4f')}; expected {least:g} to {most:g}{hint}",
    )


@gate
def slip_off_set_point(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """The slide-roll ratio is none of the planned ones."""
    slip, planned = points["slide_roll_ratio"].to_numpy(), limits.planned_slips
    distance = (
        np.abs(slip[:, np.newaxis] - np.array(planned)).min(axis=1) if planned else 0.0 * slip
    )
    return Judgement(
        distance > limits.gates.slip_tolerance,
        f"the slide-roll ratio is up to {distance.max(initial=0):.4f} away from every planned one "
        f"(tolerance {limits.gates.slip_tolerance:g})",
    )


@gate
def not_steady(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """Slip or traction differs between the two halves of a plateau."""
    most = limits.gates.slip_change_max, limits.gates.traction_change_max
    return _by_changes(points, "change", *most, "the halves of the plateaus differ")


@gate
def transient_not_ended(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """The beginning of a plateau differs from the rest of it."""
    most = limits.gates.slip_transient_max, limits.gates.traction_transient_max
    words = f"the first {limits.plateaus.transient_share:.0%} of the plateaus differ from the rest"
    return _by_changes(points, "transient", *most, words)


@gate
def torque_drifts(points: pd.DataFrame, limits: TorqueLimits) -> Judgement:
    """The torque differs between the two halves of a plateau."""
    change = points["torque_change_n_m"].abs() / points["torque_n_m"].abs()
    return _by_change("torque", change, limits.gates.torque_change_max)


@gate
def load_changes(points: pd.DataFrame, limits: Limits) -> Judgement:
    """The load differs between the two halves of a plateau."""
    return _by_change("load", points["load_change"].abs(), limits.gates.load_change_max)


@gate
def temperature_changes(points: pd.DataFrame, limits: Limits) -> Judgement:
    """The oil's temperature differs between the two halves of a plateau."""
    change_c, most_c = points["temperature_change_c"].abs(), limits.gates.temperature_change_max_c
    return Judgement(
        change_c > most_c,
        f"the temperature changes within the plateaus by up to {change_c.max():.2f} degC; allowed "
        f"{most_c:g} degC",
    )


@gate
def spiky(points: pd.DataFrame, limits: Limits) -> Judgement:
    """Too many readings of a plateau are spikes."""
    spikes, allowed = points["n_spikes"], limits.gates.spike_share_max
    return Judgement(
        # a single one is left out of a plateau of few rows as well
        (spikes > 1) & (spikes > allowed * (points["n_samples"] + spikes)),
        f"up to {spikes.max()} readings of a plateau are spikes; allowed {allowed:.0%} of them",
    )


@gate
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


def _off_trend(points: pd.DataFrame, factor: float) -> BoolArray:
    names = ["measured_film_thickness_um", "entrainment_speed_m_s"]
    off = pd.Series(False, index=points.index)
    readings = points.loc[(points[names] > 0).all(axis=1), ["run_id", *names]]
    for _, of_run in readings.groupby("run_id") if len(readings) else ():
        film, speed = np.log(of_run[names].to_numpy()).T
        if np.ptp(speed) > 0:
            trend = scipy.stats.siegelslopes(film, speed)
            residual = film - trend.intercept - trend.slope * speed
            off[of_run.index] = np.abs(residual) > np.log(factor)
    return off.to_numpy()


@gate
def force_not_reversed(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """The force of one direction of slip had not reversed."""
    asymmetry, allowed = points["force_asymmetry"], limits.gates.asymmetry_max
    sliding = points["slide_roll_ratio"].abs() > limits.gates.asymmetry_slip_min
    return Judgement(
        sliding & (asymmetry > allowed),
        f"|TF1 + TF2| is {_span(asymmetry, '.2f')} of |TF1| + |TF2|, allowed {allowed:g}: one "
        "direction of the slip had not reversed",
    )


@gate
def traction_unphysical(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """The traction coefficient is one that no oil has."""
    mu, slip = points["traction_coefficient"], points["slide_roll_ratio"]
    least, most = limits.gates.traction_min, limits.gates.traction_max
    # a sweep may go to slips of the other sign, where the force has the other one too
    mu = mu.where(slip >= limits.gates.slide_roll_ratio_min, mu.abs())
    return Judgement(
        ~mu.between(least, most) & mu.notna(),
        f"the traction coefficient is {_span(mu, '.4f')}; expected {least:g} to {most:g}"
        f"{unit_of_load(points, limits)}",
    )


def unit_of_load(points: pd.DataFrame, limits: TractionLimits) -> str:
    """The units of the load that make usual traction coefficients of too large ones, as a hint."""
    sizes = points["traction_coefficient"].abs()
    sliding = points["slide_roll_ratio"].abs() > limits.gates.sign_slip_min
    middle, largest = sizes[sliding].median(), sizes.max()
    usual, most = limits.gates.sliding_traction_usual, limits.gates.traction_max
    if largest <= most:
        return ""
    return unit_hint("load", lambda scale: usual <= middle / scale and largest / scale <= most)


def slip_is_held(points: pd.DataFrame, limits: TractionLimits) -> "pd.Series[bool]":
    """Plateaus of which the slip is steady; on a ramp between two slips it is not."""
    change, transient = points["slip_change"].abs(), points["slip_transient"].abs()
    most = limits.gates.slip_change_max, limits.gates.slip_transient_max
    return ~((change > most[0]) | (transient > most[1]))


def surely_unphysical(points: pd.DataFrame, limits: TractionLimits) -> "pd.Series[bool]":
    """Plateaus whose traction coefficient is impossible by far more than its standard error.

    Without slip a zero that is slightly off makes a small coefficient negative.
    """
    mu, error = points["traction_coefficient"], points["traction_coefficient_se"].fillna(0.0)
    sliding = points["slide_roll_ratio"] > limits.gates.sign_slip_min
    above = mu - _SURE * error > limits.gates.traction_max
    return above | (sliding & (mu + _SURE * error < limits.gates.traction_min))


@gate
def thin_film(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """The film does not separate the surfaces."""
    return Judgement(
        points["film_judgement"] == "below limit",
        f"the lambda ratio is {_span(points['lambda_ratio'], '.2f')}; full film needs more than "
        f"{limits.gates.lambda_limit:g}",
    )


@gate
def film_not_judged(points: pd.DataFrame, limits: TractionLimits) -> Judgement:
    """The film cannot be calculated, and the campaign does not accept that."""
    unknown = points["film_judgement"] == "cannot be judged"
    return Judgement(
        unknown & (not limits.accept_unjudged_film),
        "the film thickness cannot be calculated: geometry, material, roughness or oil properties "
        "are not known, or no film formula holds at these loads, speeds and temperatures",
    )


@gate
def torque_not_positive(points: pd.DataFrame, limits: TorqueLimits) -> Judgement:
    """The torque does not resist the motion."""
    return _must_be_positive(points, "torque_n_m", "torque is {} N m")


@gate
def turns_backwards(points: pd.DataFrame, limits: TorqueLimits) -> Judgement:
    """The speed is negative."""
    speed = points["inner_speed_rpm"]
    return Judgement(speed < 0, f"the speed is {_span(speed, '.0f')} rpm; expected more than 0")


@gate
def unloaded(points: pd.DataFrame, limits: TorqueLimits) -> Judgement:
    """Nothing pushes the bearing together."""
    return _must_be_positive(points, "axial_load_n", "axial load is {} N")
