"""The gates of plateaus in the order in which they judge, and verdicts on plateaus and runs.

A cause is judged before its consequence. Refusals get their advice here and become rows of the
quarantine.

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
from oilfilm.base.ties import exceeds, reaches
from oilfilm.base.units import BoolArray
from oilfilm.curation.gate import RULES, Gate, Gates, PlateauJudge, fault, unit_hint
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.logs.base import Refusal
from oilfilm.logs.run_sheet import EXCLUDED, EXCLUDED_ADVICE

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
    return exceeds(rig.plateau_settings.min_duration_s, points["duration_s"])


@gate
def load_off_nominal(points: pd.DataFrame, rig: TractionRig) -> BoolArray:
    """The load is not the one that was set."""
    return _off_nominal(points, "load_n", rig.gates.load_tolerance)


@gate
def speed_off_nominal(points: pd.DataFrame, rig: TractionRig) -> BoolArray:
    """The entrainment speed is not the one that was set."""
    speed = held_speed(points)
    nominal = points["nominal_entrainment_speed_m_s"]
    return exceeds((speed - nominal).abs(), rig.gates.speed_tolerance * nominal)


def held_speed(points: pd.DataFrame) -> "pd.Series[float]":
    """The speed that each run holds while its slip changes, in m/s, one value per plateau.

    Most rigs hold the mean speed. Where a rig holds the speed of one body, the mean speed follows
    the slip, which is no fault. The speed that scatters least is the held one.
    """
    speeds = pd.DataFrame(controlled_speeds(points))
    run_id = points["run_id"]
    distance = (speeds - speeds.groupby(run_id).transform("median")).abs()
    scatter = distance.groupby(run_id).transform("median").fillna(np.inf)
    held_column = scatter.to_numpy().argmin(axis=1)
    held_speeds = speeds.to_numpy()[np.arange(len(points)), held_column]
    return pd.Series(held_speeds, index=points.index)


def controlled_speeds(points: pd.DataFrame) -> dict[str, "pd.Series[float]"]:
    """The speeds that a rig may hold while the slip changes, the mean speed first.

    With slip S over the mean speed U the faster body has U (1 + S/2), the slower one U (1 - S/2).
    """
    mean = points["entrainment_speed_m_s"]
    half_slip = points["slide_roll_ratio"].abs() / 2
    return {
        "mean speed": mean,
        "speed of the faster body": mean * (1 + half_slip),
        "speed of the slower body": mean * (1 - half_slip),
    }


@gate
def temperature_off_nominal(points: pd.DataFrame, rig: TractionRig) -> BoolArray:
    """The inlet temperature is not the one that was set."""
    off_c = points["inlet_temperature_c"] - points["nominal_inlet_temperature_c"]
    return exceeds(off_c.abs(), rig.gates.temperature_tolerance_c)


@gate
def slip_out_of_range(points: pd.DataFrame, rig: TractionRig) -> BoolArray:
    """The slide-roll ratio is one that no sweep reaches."""
    slip = points["slide_roll_ratio"]
    high_enough = reaches(slip, rig.gates.slide_roll_ratio_min)
    low_enough = reaches(rig.gates.slide_roll_ratio_max, slip)
    return ~(high_enough & low_enough)


@gate
def slip_off_set_point(points: pd.DataFrame, rig: TractionRig) -> BoolArray:
    """The slide-roll ratio is none of the planned ones."""
    slip = points["slide_roll_ratio"].to_numpy()
    planned = np.array(rig.planned_slips)
    if len(planned) == 0:
        return np.zeros(len(points), dtype=bool)
    distance = np.abs(slip[:, np.newaxis] - planned)
    return np.asarray(exceeds(distance, rig.gates.slip_tolerance).all(axis=1))


@gate
def not_steady(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """Slip or traction differs between the two halves of a plateau."""
    slip_changes = points["slip_change"].abs() > rig.gates.slip_change_max
    traction_changes = points["traction_change"].abs() > rig.gates.traction_change_max
    return slip_changes | traction_changes


@gate
def transient_not_ended(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """The beginning of a plateau differs from the rest of it."""
    slip_differs = points["slip_transient"].abs() > rig.gates.slip_transient_max
    traction_differs = points["traction_transient"].abs() > rig.gates.traction_transient_max
    return slip_differs | traction_differs


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
    spikes = points["n_spikes"]
    readings = points["n_samples"] + spikes
    # a single spike is allowed even where it is a large share of few readings
    return (spikes > 1) & exceeds(spikes, rig.gates.spike_share_max * readings)


@gate
def film_off_trend(points: pd.DataFrame, rig: TractionRig) -> BoolArray:
    """A measured film leaves the power law in speed that its run follows.

    The law is the repeated-median line of ln h against ln U, which holds with up to half of the
    readings wrong (A. F. Siegel, Biometrika 69 (1982) 242).
    """
    off_trend = pd.Series(False, index=points.index)
    measured = points["measured_film_thickness_um"] > 0
    turning = points["entrainment_speed_m_s"] > 0
    readings = points[measured & turning]
    if readings.empty:
        return off_trend.to_numpy()
    for _, readings_of_run in readings.groupby("run_id"):
        log_film = np.log(readings_of_run["measured_film_thickness_um"].to_numpy())
        log_speed = np.log(readings_of_run["entrainment_speed_m_s"].to_numpy())
        if np.ptp(log_speed) > 0:
            trend = scipy.stats.siegelslopes(log_film, log_speed)
            residual = log_film - trend.intercept - trend.slope * log_speed
            off_trend[readings_of_run.index] = np.abs(residual) > np.log(
                rig.gates.film_trend_factor
            )
    return off_trend.to_numpy()


@gate
def force_not_reversed(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """The force of one direction of slip had not reversed."""
    sliding = points["slide_roll_ratio"].abs() > rig.gates.asymmetry_slip_min
    return sliding & (points["force_asymmetry"] > rig.gates.asymmetry_max)


@gate
def traction_unphysical(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """The traction coefficient is one that no oil has."""
    mu = points["traction_coefficient"]
    return ~mu.between(rig.gates.traction_min, rig.gates.traction_max) & mu.notna()


def hint_at_unit_of_load(points: pd.DataFrame, rig: TractionRig) -> str:
    """A hint at the units of the load with which too large traction coefficients are usual ones."""
    sizes = points["traction_coefficient"].abs()
    sliding = points["slide_roll_ratio"].abs() > rig.gates.sign_slip_min
    median = sizes[sliding].median()
    largest = sizes.max()
    if largest <= rig.gates.traction_max:
        return ""

    def fits(scale: float) -> bool:
        usual = median / scale >= rig.gates.sliding_traction_usual
        possible = largest / scale <= rig.gates.traction_max
        return bool(usual and possible)

    return unit_hint("load", fits)


def slip_is_held(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """Plateaus whose slip is steady; on a ramp between two slips it is not."""
    changes = points["slip_change"].abs() > rig.gates.slip_change_max
    has_transient = points["slip_transient"].abs() > rig.gates.slip_transient_max
    return ~(changes | has_transient)


def surely_unphysical(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """Plateaus whose traction coefficient is impossible by far more than its standard error.

    A small negative coefficient without slip is none of them: the zero may be slightly off.
    """
    mu, error = points["traction_coefficient"], points["traction_coefficient_se"].fillna(0.0)
    is_sliding = points["slide_roll_ratio"] > rig.gates.sign_slip_min
    error = rig.gates.significant_errors * error
    above = mu - error > rig.gates.traction_max
    return above | (is_sliding & (mu + error < rig.gates.traction_min))


@gate
def thin_film(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """The film does not separate the surfaces."""
    # derived with rig.gates.lambda_limit
    return points["film_judgement"] == "below limit"


@gate
def film_not_judged(points: pd.DataFrame, rig: TractionRig) -> "pd.Series[bool]":
    """The film cannot be calculated, and the campaign does not accept that."""
    exception = rig.settings.campaign.film_unjudged
    unknown = points["film_judgement"] == "cannot be judged"
    return unknown & (exception is None or not exception.accept)


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


def _hint_at_unit_of_set_load(points: pd.DataFrame, rig: TractionRig) -> str:
    """A hint at the units of the load with which it is the load that was set."""
    ratio = points["load_n"].mean() / points["nominal_load_n"].median()
    allowed = 2 * rig.gates.load_tolerance

    def fits(scale: float) -> bool:
        return bool(abs(ratio * scale - 1) < allowed)

    return unit_hint("load", fits)


def _hint_at_slip_limit(points: pd.DataFrame, rig: TractionRig) -> str:
    """The limit with which the largest slip passes, in whole per cent; empty where it is low."""
    largest = points["slide_roll_ratio"].max()
    if not exceeds(largest, rig.gates.slide_roll_ratio_max):
        return ""
    return f"; they would pass with gates.slide_roll_ratio_max of {np.ceil(100 * largest) / 100:g}"


def sentence_of(gate: Gate[PlateauJudge], points: pd.DataFrame, rig: Any) -> str:
    """The sentence of a gate about plateaus that all fail it."""
    hint = ""
    if gate.name == "load_off_nominal":
        hint = _hint_at_unit_of_set_load(points, rig)
    if gate.name == "slip_out_of_range":
        hint = _hint_at_slip_limit(points, rig)
    if gate.name == "traction_unphysical":
        hint = hint_at_unit_of_load(points, rig)
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
    """What to do about a refusal by a gate or rule, in the words of a kind of rig."""
    advice = {name: entry["advice"] for name, entry in RULES["gates"].items()}
    advice |= RULES["others"]
    advice[EXCLUDED] = EXCLUDED_ADVICE
    # some rules have another advice for one kind of rig
    advice |= RULES[kind.name]
    for name, text in RULES["mistakes"].items():
        advice[name] = f"{text} {_IF_RIGHT}"
    return str(advice[rule]).format(**kind.terms)


def quarantine_rows(
    refusals: list[Refusal], runs: pd.DataFrame, kind: type[RigKind]
) -> pd.DataFrame:
    """The table of quarantine for refusals by curation.

    Args:
        refusals: The refusals.
        runs: Table of runs, with the run of each refusal.
        kind: The kind of rig.
    """
    columns_of_run: dict[Any, dict[Any, Any]] = runs.set_index("run_id")[
        ["campaign", "file"]
    ].to_dict("index")
    rows: list[dict[str, Any]] = []
    for refusal in refusals:
        row: dict[str, Any] = {"stage": "curate", **columns_of_run[refusal.run_id]}
        row |= asdict(refusal)
        row["advice"] = advice_for(refusal.rule, kind)
        rows.append(row)
    return tables.from_rows(rows, "quarantine")


def judge_plateaus(points: pd.DataFrame, rig: RigKind) -> pd.DataFrame:
    """The gates that each plateau fails: one boolean column per gate, one row per plateau."""
    gates = PLATEAU_GATES.for_rig(rig.name) if len(points) else []
    return pd.DataFrame(
        {gate.name: np.asarray(gate.judge(points, rig)) for gate in gates},
        index=points.index,
        dtype=bool,
    )


def runs_not_usable(points: pd.DataFrame, failed: pd.DataFrame, rig: RigKind) -> Iterator[Refusal]:
    """Refusals of runs without a usable plateau, or with so many faults that none can be trusted.

    Args:
        points: Plateaus of any number of runs.
        failed: The gates that each plateau fails, as `judge_plateaus` gives them.
        rig: The rig.
    """
    if points.empty:
        return
    judged = _judgements(points, failed, rig)
    judged_by_run = judged.groupby(points["run_id"])
    share_by_run = judged_by_run.mean()
    count_by_run = judged_by_run.sum()
    any_by_run = judged_by_run.any()
    share, fewest = rig.gates.faulty_share_max, rig.gates.faulty_plateaus_min
    many_fail = share_by_run["faulty_where_held"] > share
    many_fail &= count_by_run["faulty_where_held"] >= fewest
    most_fail = share_by_run["faulty"] > max(1 / 2, share)
    blamed = judged["faulty_where_held"].where(points["run_id"].map(many_fail), judged["faulty"])
    judged = judged.assign(blamed=blamed)
    is_refused = ~any_by_run["left"] | most_fail | many_fail | any_by_run["unphysical"]
    for run_id in any_by_run.index[is_refused]:
        is_of_run = points["run_id"] == run_id
        refusal = _refusal_of_run(points[is_of_run], failed[is_of_run], judged[is_of_run], rig)
        yield replace(refusal, run_id=str(run_id))


def _judgements(points: pd.DataFrame, failed: pd.DataFrame, rig: RigKind) -> pd.DataFrame:
    """What each plateau means for its run: boolean columns, one row per plateau.

    - `wanted`: it slides, or no plateau of its run does;
    - `held`: its slip is steady, which it is not on a ramp between two slips;
    - `unphysical`: slip and load are right, and no oil has the traction;
    - `left`: it is wanted and passes all gates;
    - `faulty`: it fails a gate that blames the run;
    - `faulty_where_held`: it is faulty and held.
    """
    blaming = [gate.name for gate in PLATEAU_GATES.for_rig(rig.name) if gate.blames_run]
    faulty = failed[blaming].any(axis=1)
    judged = pd.DataFrame({"wanted": True, "held": True, "unphysical": False}, index=points.index)
    if isinstance(rig, TractionRig):
        sliding = points["slide_roll_ratio"].abs() > rig.zero_settings.max_slide_roll_ratio
        held = slip_is_held(points, rig)
        causes = failed[["slip_out_of_range", "load_off_nominal", "load_changes"]].any(axis=1)
        judged = judged.assign(
            wanted=sliding | ~points["run_id"].isin(points.loc[sliding, "run_id"]),
            held=held,
            unphysical=~causes & held & surely_unphysical(points, rig),
        )
    left = judged["wanted"] & ~failed.any(axis=1)
    return judged.assign(left=left, faulty=faulty, faulty_where_held=faulty & judged["held"])


def _refusal_of_run(
    points: pd.DataFrame, failed: pd.DataFrame, judged: pd.DataFrame, rig: RigKind
) -> Refusal:
    """The refusal of one run that cannot be used.

    Args:
        points: Its plateaus.
        failed: The gates that each of them fails.
        judged: Columns of `_judgements`, and `blamed`: the plateaus whose faults count.
        rig: The rig.
    """
    gates = PLATEAU_GATES.for_rig(rig.name)
    for gate in gates:
        if failed[gate.name].all():
            return Refusal(gate.name, sentence_of(gate, points, rig), "")
    unphysical = judged["unphysical"]
    if unphysical.any() and isinstance(rig, TractionRig):
        worst = points.iloc[points["traction_coefficient"].abs().where(unphysical).argmax()]
        return fault(
            "impossible_traction",
            count=unphysical.sum(),
            plateaus=len(points),
            worst=worst,
            hint=hint_at_unit_of_load(points, rig),
            first=worst["first_row"],
            last=worst["last_row"],
        )
    wanted = judged["wanted"]
    if not judged["left"].any():
        return fault(
            "no_point_left",
            count=wanted.sum(),
            which="" if wanted.all() else " that slide",
            counts=_failures_per_gate(failed[wanted]),
        )
    blamed = judged["blamed"]
    blaming_gates = [gate.name for gate in gates if gate.blames_run]
    return fault(
        "many_plateaus_fail",
        count=blamed.sum(),
        plateaus=len(points),
        share=blamed.mean(),
        counts=_failures_per_gate(failed.loc[blamed, blaming_gates]),
        allowed=rig.gates.faulty_share_max,
    )


def _failures_per_gate(failed: pd.DataFrame) -> str:
    """The number of plateaus that fail each gate, as in `spiky 3, not_steady 1`."""
    counts = failed.sum().sort_values(ascending=False, kind="stable")
    return ", ".join(f"{name} {count}" for name, count in counts.items() if count)
