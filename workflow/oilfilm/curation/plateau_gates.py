"""The gates of plateaus in the order in which they judge, and verdicts on plateaus and runs.

A cause is judged before its consequence. A finding gets its advice here, and a refusal becomes a
row.

Decides: when a plateau is refused (not steady, drift, load, temperature, spikes, film); when faulty
plateaus refuse their run; the row of a refusal, with its advice.
"""

from collections.abc import Iterator
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import pandas as pd
import scipy

from oilfilm import tables
from oilfilm.curation.gate import RULES, Gate, Gates, PlateauJudge, fault, unit_hint
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.logs.base import Refusal
from oilfilm.logs.run_sheet import EXCLUDED, EXCLUDED_ADVICE
from oilfilm.ties import exceeds, reaches
from oilfilm.units import BoolArray

PLATEAU_GATES: Gates[PlateauJudge] = Gates()
gate = PLATEAU_GATES.gate


def _off_nominal(points: pd.DataFrame, name: str, tolerance: float) -> BoolArray:
    nominal = points[f"nominal_{name}"]
    return exceeds((points[name] - nominal).abs(), tolerance * nominal)


@gate
def traction_missing(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """Force, load or slip has no value."""
    return points[["traction_coefficient", "slide_roll_ratio"]].isna().any(axis=1)


@gate
def too_short(points: pd.DataFrame, rig: RigKind) -> BoolArray:
    """Little is left of a level once it has settled."""
    return exceeds(rig.plateaus.min_duration_s, points["duration_s"])


@gate
def load_off_nominal(points: pd.DataFrame, rig: TractionRig) -> BoolArray:
    """The load is not the one that was set."""
    return _off_nominal(points, "load_n", rig.gates.load_tolerance)


@gate
def speed_off_nominal(points: pd.DataFrame, rig: TractionRig) -> BoolArray:
    """The entrainment speed is not the one that was set."""
    return _off_nominal(points, "entrainment_speed_m_s", rig.gates.speed_tolerance)


@gate
def temperature_off_nominal(points: pd.DataFrame, rig: TractionRig) -> BoolArray:
    """The inlet temperature is not the one that was set."""
    off_c = points["inlet_temperature_c"] - points["nominal_inlet_temperature_c"]
    return exceeds(off_c.abs(), rig.gates.temperature_tolerance_c)


@gate
def slip_out_of_range(points: pd.DataFrame, rig: TractionRig) -> BoolArray:
    """The slide-roll ratio is one that no sweep reaches."""
    slip, gates = points["slide_roll_ratio"], rig.gates
    above = reaches(slip, gates.slide_roll_ratio_min)
    return ~(above & reaches(gates.slide_roll_ratio_max, slip))


@gate
def slip_off_set_point(points: pd.DataFrame, rig: TractionRig) -> BoolArray:
    """The slide-roll ratio is none of the planned ones."""
    slip, planned = points["slide_roll_ratio"].to_numpy(), np.array(rig.planned_slips)
    away = np.abs(slip[:, np.newaxis] - planned)
    off = exceeds(away, rig.gates.slip_tolerance).all(axis=1)
    return np.asarray(off & (len(planned) > 0))


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
    return (spikes > 1) & exceeds(spikes, allowed * (points["n_samples"] + spikes))


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
    error = rig.gates.significant_errors * error
    above = mu - error > rig.gates.traction_max
    return above | (sliding & (mu + error < rig.gates.traction_min))


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


# ---------------------------------------------------------------- verdicts

_IF_RIGHT = "If that is not the mistake, correct the fault that is named after 'as it is'."


def advice_for(rule: str, kind: type[RigKind]) -> str:
    """What to do about a refusal by the gate or rule of that name."""
    texts = {name: entry["advice"] for name, entry in RULES["gates"].items()}
    texts |= {**RULES["others"], EXCLUDED: EXCLUDED_ADVICE, **RULES[kind.name]}
    texts |= {name: f"{text} {_IF_RIGHT}" for name, text in RULES["mistakes"].items()}
    return str(texts[rule]).format(**kind.words)


def quarantine_rows(
    refusals: list[Refusal], runs: pd.DataFrame, kind: type[RigKind]
) -> pd.DataFrame:
    """The table of quarantine of refusals by curation; `runs` has the run of each."""
    of_run = runs.set_index("run_id")[["campaign", "file"]].assign(stage="curate").to_dict("index")
    rows = [
        {**of_run[each.run_id], **asdict(each), "advice": advice_for(each.rule, kind)}
        for each in refusals
    ]
    return tables.from_rows(rows, "quarantine")


def judge_plateaus(points: pd.DataFrame, rig: RigKind) -> pd.DataFrame:
    """Which gates each plateau fails: one boolean column per gate, one row per plateau."""
    gates = PLATEAU_GATES.of(rig.name) if len(points) else []
    return pd.DataFrame(
        {gate.name: np.asarray(gate.judge(points, rig)) for gate in gates},
        index=points.index,
        dtype=bool,
    )


def runs_not_usable(points: pd.DataFrame, failed: pd.DataFrame, rig: RigKind) -> Iterator[Refusal]:
    """Refusals of runs of which no plateau is left, or the others cannot be trusted either.

    Args:
        points: Plateaus of any number of runs.
        failed: The gates that each of them fails.
        rig: The rig.
    """
    if points.empty:
        return
    judged = _judged(points, failed, rig)
    of_runs = judged.groupby(points["run_id"])
    means, counts, some = of_runs.mean(), of_runs.sum(), of_runs.any()
    share, fewest = rig.gates.faulty_share_max, rig.gates.faulty_plateaus_min
    many = (means["faulty_where_held"] > share) & (counts["faulty_where_held"] >= fewest)
    most = means["faulty"] > max(1 / 2, share)
    blamed = judged["faulty_where_held"].where(points["run_id"].map(many), judged["faulty"])
    judged = judged.assign(blamed=blamed)
    for run_id in some.index[~some["left"] | most | many | some["unphysical"]]:
        mine = points["run_id"] == run_id
        why = _why(points[mine], failed[mine], judged[mine], rig)
        yield replace(why, run_id=str(run_id))


def _judged(points: pd.DataFrame, failed: pd.DataFrame, rig: RigKind) -> pd.DataFrame:
    """What each plateau means for its run.

    A run is made for the plateaus that slide, where it has any (`wanted`). Gates that blame the
    run find it `faulty`; ramps between two slips are left out of `faulty_where_held`. A plateau is
    `unphysical` where slip and load are as they should be and the traction is one that no oil has.
    """
    blaming = [gate.name for gate in PLATEAU_GATES.of(rig.name) if gate.blames_run]
    faulty = failed[blaming].any(axis=1)
    judged = pd.DataFrame({"wanted": True, "held": True, "unphysical": False}, index=points.index)
    if isinstance(rig, TractionRig):
        sliding = points["slide_roll_ratio"].abs() > rig.zero.max_slide_roll_ratio
        held = slip_is_held(points, rig)
        causes = failed[["slip_out_of_range", "load_off_nominal", "load_changes"]].any(axis=1)
        judged = judged.assign(
            wanted=sliding | ~points["run_id"].isin(points.loc[sliding, "run_id"]),
            held=held,
            unphysical=~causes & held & surely_unphysical(points, rig),
        )
    left = judged["wanted"] & ~failed.any(axis=1)
    return judged.assign(left=left, faulty=faulty, faulty_where_held=faulty & judged["held"])


def _why(points: pd.DataFrame, failed: pd.DataFrame, judged: pd.DataFrame, rig: RigKind) -> Refusal:
    """The refusal of one run that cannot be used."""
    gates = PLATEAU_GATES.of(rig.name)
    for gate in gates:
        if failed[gate.name].all():
            return Refusal(gate.name, sentence_of(gate, points, rig), "")
    unphysical, wanted = judged["unphysical"], judged["wanted"]
    if unphysical.any() and isinstance(rig, TractionRig):
        worst = points.iloc[points["traction_coefficient"].abs().where(unphysical).argmax()]
        rows = {"first": worst["first_row"], "last": worst["last_row"]}
        about = dict(count=unphysical.sum(), plateaus=len(points), worst=worst, **rows)
        return fault("impossible_traction", hint=unit_of_load(points, rig), **about)
    if not judged["left"].any():
        which = "" if wanted.all() else " that slide"
        counts = _counts(failed[wanted])
        return fault("no_point_left", count=wanted.sum(), which=which, counts=counts)
    faulty = judged["blamed"]
    counts = _counts(failed.loc[faulty, [gate.name for gate in gates if gate.blames_run]])
    about = dict(count=faulty.sum(), plateaus=len(points), share=faulty.mean(), counts=counts)
    return fault("many_plateaus_fail", allowed=rig.gates.faulty_share_max, **about)


def _counts(failed: pd.DataFrame) -> str:
    """How many plateaus fail each gate, as in `spiky 3, not_steady 1`."""
    counts = failed.sum().sort_values(ascending=False, kind="stable")
    return ", ".join(f"{name} {count}" for name, count in counts.items() if count)
