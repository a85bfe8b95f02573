"""The gates of plateaus in the order in which they judge: a cause before its consequence.

Decides: when a plateau is refused (not steady, drift, load, temperature, spikes, film).
"""

from typing import Any

import numpy as np
import pandas as pd
import scipy

from oilfilm.curation.gate import Gate, Gates, PlateauJudge, unit_hint
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.units import BoolArray

PLATEAU_GATES: Gates[PlateauJudge] = Gates()
gate = PLATEAU_GATES.gate

# So many standard errors are no chance.
_SURE = 5


def _off_nominal(points: pd.DataFrame, name: str, tolerance: float) -> "pd.Series[bool]":
    nominal = points[f"nominal_{name}"]
    return (points[name] - nominal).abs() > tolerance * nominal


@gate
def traction_missing(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """Force, load or slip has no value."""
    return points[["traction_coefficient", "slide_roll_ratio"]].isna().any(axis=1)


@gate
def too_short(points: pd.DataFrame, rig: RigKind) -> "pd.Series[bool]":
    """Little is left of a level once it has settled."""
    return points["duration_s"] < rig.plateaus.min_duration_s


@gate
def load_off_nominal(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """The load is not the one that was set."""
    return _off_nominal(points, "load_n", rig.gates.load_tolerance)


@gate
def speed_off_nominal(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """The entrainment speed is not the one that was set."""
    return _off_nominal(points, "entrainment_speed_m_s", rig.gates.speed_tolerance)


@gate
def temperature_off_nominal(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """The inlet temperature is not the one that was set."""
    off_c = points["inlet_temperature_c"] - points["nominal_inlet_temperature_c"]
    return off_c.abs() > rig.gates.temperature_tolerance_c


@gate
def slip_out_of_range(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """The slide-roll ratio is one that no sweep reaches."""
    least, most = rig.gates.slide_roll_ratio_min, rig.gates.slide_roll_ratio_max
    return ~points["slide_roll_ratio"].between(least, most)


@gate
def slip_off_set_point(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """The slide-roll ratio is none of the planned ones."""
    slip = points["slide_roll_ratio"]
    away = [(slip - planned).abs() > rig.gates.slip_tolerance for planned in rig.planned_slips]
    return pd.concat(away, axis=1).all(axis=1) if away else slip.isna() & False


@gate
def not_steady(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """Slip or traction differs between the two halves of a plateau."""
    slip, traction = points["slip_change"].abs(), points["traction_change"].abs()
    return (slip > rig.gates.slip_change_max) | (traction > rig.gates.traction_change_max)


@gate
def transient_not_ended(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """The beginning of a plateau differs from the rest of it."""
    slip, traction = points["slip_transient"].abs(), points["traction_transient"].abs()
    late = traction > rig.gates.traction_transient_max
    return (slip > rig.gates.slip_transient_max) | late


@gate
def torque_drifts(points: pd.DataFrame, rig: RigKind) -> "pd.Series[bool]":
    """The torque differs between the two halves of a plateau."""
    return points["torque_change"].abs() > rig.settings.torque_logs.gates.torque_change_max


@gate
def load_changes(points: pd.DataFrame, rig: RigKind) -> "pd.Series[bool]":
    """The load differs between the two halves of a plateau."""
    return points["load_change"].abs() > rig.gates.load_change_max


@gate
def temperature_changes(points: pd.DataFrame, rig: RigKind) -> "pd.Series[bool]":
    """The oil's temperature differs between the two halves of a plateau."""
    return points["temperature_change_c"].abs() > rig.gates.temperature_change_max_c


@gate
def spiky(points: pd.DataFrame, rig: RigKind) -> "pd.Series[bool]":
    """Too many readings of a plateau are spikes."""
    spikes, allowed = points["n_spikes"], rig.gates.spike_share_max
    # a single one is left out of a plateau of few rows as well
    return (spikes > 1) & (spikes > allowed * (points["n_samples"] + spikes))


@gate
def film_off_trend(points: pd.DataFrame, rig: TractionRig) -> BoolArray:
    """A measured film leaves the power law in speed that its run follows.

    The law is the repeated-median line of ln h against ln U, which holds with up to half of the
    readings wrong (A. F. Siegel, Biometrika 69 (1982) 242).
    """
    names = ["measured_film_thickness_um", "entrainment_speed_m_s"]
    off = pd.Series(False, index=points.index)
    readings = points.loc[(points[names] > 0).all(axis=1), ["run_id", *names]]
    for _, of_run in readings.groupby("run_id") if len(readings) else ():
        film, speed = np.log(of_run[names].to_numpy()).T
        if np.ptp(speed) > 0:
            trend = scipy.stats.siegelslopes(film, speed)
            residual = film - trend.intercept - trend.slope * speed
            off[of_run.index] = np.abs(residual) > np.log(rig.gates.film_trend_factor)
    return off.to_numpy()


@gate
def force_not_reversed(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """The force of one direction of slip had not reversed."""
    sliding = points["slide_roll_ratio"].abs() > rig.gates.asymmetry_slip_min
    return sliding & (points["force_asymmetry"] > rig.gates.asymmetry_max)


@gate
def traction_unphysical(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """The traction coefficient is one that no oil has."""
    mu, least = points["traction_coefficient"], rig.gates.slide_roll_ratio_min
    # a sweep may go to slips of the other sign, where the force has the other one too
    mu = mu.where(points["slide_roll_ratio"] >= least, mu.abs())
    return ~mu.between(rig.gates.traction_min, rig.gates.traction_max) & mu.notna()


def unit_of_load(points: pd.DataFrame, rig: TractionRig) -> str:
    """The units of the load that make usual traction coefficients of too large ones, as a hint."""
    sizes = points["traction_coefficient"].abs()
    sliding = points["slide_roll_ratio"].abs() > rig.gates.sign_slip_min
    middle, largest = sizes[sliding].median(), sizes.max()
    usual, most = rig.gates.sliding_traction_usual, rig.gates.traction_max
    if largest <= most:
        return ""
    return unit_hint("load", lambda scale: usual <= middle / scale and largest / scale <= most)


def slip_is_held(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """Plateaus of which the slip is steady; on a ramp between two slips it is not."""
    change, transient = points["slip_change"].abs(), points["slip_transient"].abs()
    most = rig.gates.slip_change_max, rig.gates.slip_transient_max
    return ~((change > most[0]) | (transient > most[1]))


def surely_unphysical(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """Plateaus whose traction coefficient is impossible by far more than its standard error.

    Without slip a zero that is slightly off makes a small coefficient negative.
    """
    mu, error = points["traction_coefficient"], points["traction_coefficient_se"].fillna(0.0)
    sliding = points["slide_roll_ratio"] > rig.gates.sign_slip_min
    above = mu - _SURE * error > rig.gates.traction_max
    return above | (sliding & (mu + _SURE * error < rig.gates.traction_min))


@gate
def thin_film(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """The film does not separate the surfaces."""
    # derived with rig.gates.lambda_limit
    return points["film_judgement"] == "below limit"


@gate
def film_not_judged(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """The film cannot be calculated, and the campaign does not accept that."""
    accepted = rig.settings.campaign.film_unjudged
    unknown = points["film_judgement"] == "cannot be judged"
    return unknown & (accepted is None or not accepted.accept)


@gate
def torque_not_positive(points: pd.DataFrame, rig: RigKind) -> "pd.Series[bool]":
    """The torque does not resist the motion."""
    return ~(points["torque_n_m"] > 0)


@gate
def turns_backwards(points: pd.DataFrame, rig: RigKind) -> "pd.Series[bool]":
    """The speed is negative."""
    return points["inner_speed_rpm"] < 0


@gate
def unloaded(points: pd.DataFrame, rig: RigKind) -> "pd.Series[bool]":
    """Nothing pushes the bearing together."""
    return ~(points["axial_load_n"] > 0)


def _unit_of_set_load(points: pd.DataFrame, rig: TractionRig) -> str:
    ratio = points["load_n"].mean() / points["nominal_load_n"].median()
    allowed = 2 * rig.gates.load_tolerance
    return unit_hint("load", lambda scale: abs(ratio * scale - 1) < allowed)


def sentence_of(gate: Gate[PlateauJudge], points: pd.DataFrame, rig: Any) -> str:
    """What a gate found, about all of these plateaus."""
    hints = {"load_off_nominal": _unit_of_set_load, "traction_unphysical": unit_of_load}
    hint = hints[gate.name](points, rig) if gate.name in hints else ""
    numbers = points.select_dtypes("number")
    return gate.sentence(
        rig,
        hint=hint,
        least=numbers.min(),
        most=numbers.max(),
        largest=numbers.abs().max(),
        middle=numbers.median(),
        mean=numbers.mean(),
    )
