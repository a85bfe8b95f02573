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
from oilfilm.curation.gate import RULES, Gate, Gates, PlateauJudge, refusal_by, unit_hint
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.curation.zero import DIRECTION_COLUMN
from oilfilm.logs.base import Refusal
from oilfilm.logs.run_sheet import EXCLUDED, EXCLUDED_ADVICE

# Slide-roll ratio at which one body is at rest; at a larger one this body turns backwards.
_LARGEST_SLIP = 2.0

PLATEAU_GATES: Gates[PlateauJudge] = Gates()
gate = PLATEAU_GATES.gate


def _is_off_nominal(points: pd.DataFrame, column: str, tolerance: float) -> BoolArray:
    """Mask of the plateaus at which a column is off its set point by more than a share of it."""
    nominal = points[f"nominal_{column}"]
    return exceeds((points[column] - nominal).abs(), tolerance * nominal)


@gate
def traction_missing(points: pd.DataFrame, rig_kind: TractionRig) -> "pd.Series[bool]":
    """Force, load or slip has no value."""
    return points[["traction_coefficient", "slide_roll_ratio"]].isna().any(axis=1)


@gate
def too_short(points: pd.DataFrame, rig_kind: RigKind) -> BoolArray:
    """Little is left of a level once it has settled."""
    return exceeds(rig_kind.plateau_settings.min_duration_s, points["duration_s"])


@gate
def load_off_nominal(points: pd.DataFrame, rig_kind: TractionRig) -> BoolArray:
    """The load is not the one that was set."""
    return _is_off_nominal(points, "load_n", rig_kind.gate_limits.load_tolerance)


@gate
def speed_off_nominal(points: pd.DataFrame, rig_kind: TractionRig) -> BoolArray:
    """The entrainment speed is not the one that was set, nor is the speed that the run holds."""
    tolerance = rig_kind.gate_limits.speed_tolerance
    nominal = points["nominal_entrainment_speed_m_s"]
    is_held_speed_off = exceeds((held_speed(points) - nominal).abs(), tolerance * nominal)
    # where the slip hardly changes, the speed of one body may scatter less by chance
    return is_held_speed_off & _is_off_nominal(points, "entrainment_speed_m_s", tolerance)


def held_speed(points: pd.DataFrame) -> "pd.Series[float]":
    """The speed that each run holds while its slip changes, in m/s, one value per plateau.

    Most rigs hold the mean speed. Where a rig holds the speed of one body, the mean speed follows
    the slip, which is not wrong. The speed that scatters least is the held one.
    """
    speeds = pd.DataFrame(controlled_speeds(points))
    # ball and disc exchange their speeds where the slip changes its direction
    signed_half_slip = points[DIRECTION_COLUMN] * points["slide_roll_ratio"] / 2
    mean_speed = points["entrainment_speed_m_s"]
    speeds["one body"] = mean_speed * (1 + signed_half_slip)
    speeds["other body"] = mean_speed * (1 - signed_half_slip)
    run_id = points["run_id"]
    deviation = (speeds - speeds.groupby(run_id).transform("median")).abs()
    scatter = deviation.groupby(run_id).transform("median").fillna(np.inf)
    held_column_indices = scatter.to_numpy().argmin(axis=1)
    held_speeds = speeds.to_numpy()[np.arange(len(points)), held_column_indices]
    return pd.Series(held_speeds, index=points.index)


def controlled_speeds(points: pd.DataFrame) -> dict[str, "pd.Series[float]"]:
    """The speeds that a rig may hold while the slip changes, the mean speed first.

    With slip S over the mean speed U the faster body has U (1 + S/2), the slower one U (1 - S/2).
    """
    mean_speed = points["entrainment_speed_m_s"]
    half_slip = points["slide_roll_ratio"].abs() / 2
    return {
        "mean speed": mean_speed,
        "speed of the faster body": mean_speed * (1 + half_slip),
        "speed of the slower body": mean_speed * (1 - half_slip),
    }


@gate
def temperature_off_nominal(points: pd.DataFrame, rig_kind: TractionRig) -> BoolArray:
    """The inlet temperature is not the one that was set."""
    deviation_c = points["inlet_temperature_c"] - points["nominal_inlet_temperature_c"]
    return exceeds(deviation_c.abs(), rig_kind.gate_limits.temperature_tolerance_c)


@gate
def slip_out_of_range(points: pd.DataFrame, rig_kind: TractionRig) -> BoolArray:
    """The slide-roll ratio is one that no sweep reaches."""
    slip = points["slide_roll_ratio"]
    is_high_enough = reaches(slip, rig_kind.gate_limits.slide_roll_ratio_min)
    is_low_enough = reaches(rig_kind.gate_limits.slide_roll_ratio_max, slip)
    return ~(is_high_enough & is_low_enough)


@gate
def slip_off_set_point(points: pd.DataFrame, rig_kind: TractionRig) -> BoolArray:
    """The slide-roll ratio is none of the planned ones."""
    slip = points["slide_roll_ratio"].to_numpy()
    planned = np.array(rig_kind.planned_slips)
    if len(planned) == 0:
        return np.zeros(len(points), dtype=bool)
    distance = np.abs(slip[:, np.newaxis] - planned)
    return np.asarray(exceeds(distance, rig_kind.gate_limits.slip_tolerance).all(axis=1))


@gate
def not_steady(points: pd.DataFrame, rig_kind: TractionRig) -> "pd.Series[bool]":
    """Slip or traction differs between the two halves of a plateau."""
    is_slip_changing = points["slip_change"].abs() > rig_kind.gate_limits.slip_change_max
    is_traction_changing = (
        points["traction_change"].abs() > rig_kind.gate_limits.traction_change_max
    )
    return is_slip_changing | is_traction_changing


@gate
def transient_not_ended(points: pd.DataFrame, rig_kind: TractionRig) -> "pd.Series[bool]":
    """The beginning of a plateau differs from the rest of it."""
    has_slip_transient = points["slip_transient"].abs() > rig_kind.gate_limits.slip_transient_max
    has_traction_transient = (
        points["traction_transient"].abs() > rig_kind.gate_limits.traction_transient_max
    )
    return has_slip_transient | has_traction_transient


@gate
def torque_drifts(points: pd.DataFrame, rig_kind: RigKind) -> "pd.Series[bool]":
    """The torque differs between the two halves of a plateau."""
    return points["torque_change"].abs() > rig_kind.settings.torque_logs.gates.torque_change_max


@gate
def load_changes(points: pd.DataFrame, rig_kind: RigKind) -> "pd.Series[bool]":
    """The load differs between the two halves of a plateau."""
    return points["load_change"].abs() > rig_kind.gate_limits.load_change_max


@gate
def temperature_changes(points: pd.DataFrame, rig_kind: RigKind) -> "pd.Series[bool]":
    """The oil's temperature differs between the two halves of a plateau."""
    return points["temperature_change_c"].abs() > rig_kind.gate_limits.temperature_change_max_c


@gate
def spiky(points: pd.DataFrame, rig_kind: RigKind) -> "pd.Series[bool]":
    """Too many readings of a plateau are spikes."""
    spikes = points["n_spikes"]
    readings = points["n_samples"] + spikes
    # a single spike is allowed even where it is a large share of few readings
    return (spikes > 1) & exceeds(spikes, rig_kind.gate_limits.spike_share_max * readings)


@gate
def film_off_trend(points: pd.DataFrame, rig_kind: TractionRig) -> BoolArray:
    """A measured film leaves the power law in speed that its run follows.

    The law is the repeated-median line of ln h against ln U, which holds with up to half of the
    readings wrong (A. F. Siegel, Biometrika 69 (1982) 242).
    """
    is_off_trend = pd.Series(False, index=points.index)
    is_measured = points["measured_film_thickness_um"] > 0
    is_turning = points["entrainment_speed_m_s"] > 0
    readings = points[is_measured & is_turning]
    if readings.empty:
        return is_off_trend.to_numpy()
    for _, readings_of_run in readings.groupby("run_id"):
        log_film = np.log(readings_of_run["measured_film_thickness_um"].to_numpy())
        log_speed = np.log(readings_of_run["entrainment_speed_m_s"].to_numpy())
        if np.ptp(log_speed) > 0:
            trend = scipy.stats.siegelslopes(log_film, log_speed)
            residual = log_film - trend.intercept - trend.slope * log_speed
            is_off_trend[readings_of_run.index] = np.abs(residual) > np.log(
                rig_kind.gate_limits.film_trend_factor
            )
    return is_off_trend.to_numpy()


@gate
def force_not_reversed(points: pd.DataFrame, rig_kind: TractionRig) -> "pd.Series[bool]":
    """The force of one direction of slip had not reversed."""
    is_sliding = points["slide_roll_ratio"].abs() > rig_kind.gate_limits.asymmetry_slip_min
    return is_sliding & (points["force_asymmetry"] > rig_kind.gate_limits.asymmetry_max)


@gate
def traction_unphysical(points: pd.DataFrame, rig_kind: TractionRig) -> "pd.Series[bool]":
    """The traction coefficient is one that no oil has."""
    mu = points["traction_coefficient"]
    return (
        ~mu.between(rig_kind.gate_limits.traction_min, rig_kind.gate_limits.traction_max)
        & mu.notna()
    )


def _hint_at_unit_of_load(points: pd.DataFrame, rig_kind: TractionRig) -> str:
    """A hint at the units of the load with which too large traction coefficients are usual ones."""
    mu_sizes = points["traction_coefficient"].abs()
    # the slip from which the sign of the force is judged is also one at which mu has a usual size
    is_sliding = points["slide_roll_ratio"].abs() > rig_kind.gate_limits.sign_slip_min
    median_mu = mu_sizes[is_sliding].median()
    largest_mu = mu_sizes.max()
    if largest_mu <= rig_kind.gate_limits.traction_max:
        return ""

    def is_usual_in_unit(unit_size_n: float) -> bool:
        is_usual = median_mu / unit_size_n >= rig_kind.gate_limits.sliding_traction_usual
        is_possible = largest_mu / unit_size_n <= rig_kind.gate_limits.traction_max
        return bool(is_usual and is_possible)

    return unit_hint("load", is_usual_in_unit)


def _is_slip_held(points: pd.DataFrame, rig_kind: TractionRig) -> "pd.Series[bool]":
    """Plateaus whose slip is steady; on a ramp between two slips it is not."""
    is_changing = points["slip_change"].abs() > rig_kind.gate_limits.slip_change_max
    has_transient = points["slip_transient"].abs() > rig_kind.gate_limits.slip_transient_max
    return ~(is_changing | has_transient)


def _is_surely_unphysical(points: pd.DataFrame, rig_kind: TractionRig) -> "pd.Series[bool]":
    """Plateaus whose traction coefficient is impossible by far more than its standard error.

    A small negative coefficient without slip is none of them: the zero may be slightly off.
    """
    mu = points["traction_coefficient"]
    mu_se = points["traction_coefficient_se"].fillna(0.0)
    is_sliding = points["slide_roll_ratio"] > rig_kind.gate_limits.sign_slip_min
    margin = rig_kind.gate_limits.significant_errors * mu_se
    is_above = mu - margin > rig_kind.gate_limits.traction_max
    return is_above | (is_sliding & (mu + margin < rig_kind.gate_limits.traction_min))


@gate
def thin_film(points: pd.DataFrame, rig_kind: TractionRig) -> "pd.Series[bool]":
    """The film does not separate the surfaces."""
    # `with_film` has compared lambda with the limit. The page of gates finds it by the next line:
    # settings.gates.lambda_limit
    return points["film_judgement"] == "below limit"


@gate
def film_not_judged(points: pd.DataFrame, rig_kind: TractionRig) -> "pd.Series[bool]":
    """The film cannot be calculated, and the campaign does not accept that."""
    film_unjudged = rig_kind.settings.campaign.film_unjudged
    is_unjudged = points["film_judgement"] == "cannot be judged"
    return is_unjudged & (film_unjudged is None or not film_unjudged.accept)


@gate
def torque_not_positive(points: pd.DataFrame, rig_kind: RigKind) -> "pd.Series[bool]":
    """The torque does not resist the motion."""
    return ~(points["torque_n_m"] > 0)


@gate
def turns_backwards(points: pd.DataFrame, rig_kind: RigKind) -> "pd.Series[bool]":
    """The speed is negative."""
    return points["inner_speed_rpm"] < 0


@gate
def unloaded(points: pd.DataFrame, rig_kind: RigKind) -> "pd.Series[bool]":
    """Nothing pushes the bearing together."""
    return ~(points["axial_load_n"] > 0)


def _hint_at_unit_of_set_load(points: pd.DataFrame, rig_kind: TractionRig) -> str:
    """A hint at the units of the load with which it is the load that was set."""
    load_ratio = points["load_n"].mean() / points["nominal_load_n"].median()
    largest_deviation = 2 * rig_kind.gate_limits.load_tolerance

    def is_set_load_in_unit(unit_size_n: float) -> bool:
        return bool(abs(load_ratio * unit_size_n - 1) < largest_deviation)

    return unit_hint("load", is_set_load_in_unit)


def _hint_at_slip_limit(points: pd.DataFrame, rig_kind: TractionRig) -> str:
    """A hint at the limit with which all slips pass, in whole per cent; empty without one."""
    slip = points["slide_roll_ratio"]
    # rounding must not raise 1.1 to 1.11
    limit = np.ceil(100 * slip.max() - 1e-9) / 100
    if limit > _LARGEST_SLIP or not exceeds(slip, rig_kind.gate_limits.slide_roll_ratio_max).all():
        return ""
    return f"; they would pass with gates.slide_roll_ratio_max of {limit:g}"


def sentence_of(plateau_gate: Gate[PlateauJudge], points: pd.DataFrame, rig_kind: Any) -> str:
    """The sentence of a gate about plateaus that all fail it."""
    hint = ""
    if plateau_gate.name == "load_off_nominal":
        hint = _hint_at_unit_of_set_load(points, rig_kind)
    if plateau_gate.name == "slip_out_of_range":
        hint = _hint_at_slip_limit(points, rig_kind)
    if plateau_gate.name == "traction_unphysical":
        hint = _hint_at_unit_of_load(points, rig_kind)
    number_columns = points.select_dtypes("number")
    return plateau_gate.sentence(
        rig_kind,
        hint=hint,
        least=number_columns.min(),
        most=number_columns.max(),
        largest=number_columns.abs().max(),
        middle=number_columns.median(),
        mean=number_columns.mean(),
    )


# ---------------------------------------------------------------- verdicts

# A run that is refused by a likely mistake also names, after these words, what refuses it as it is.
_IF_NOT_THE_MISTAKE = (
    "If that is not the mistake, correct the fault that is named after 'as it is'."
)


def advice_for(rule: str, rig_class: type[RigKind]) -> str:
    """What to do about a refusal by a gate or rule, in the words of a kind of rig."""
    advice = {name: entry["advice"] for name, entry in RULES["gates"].items()}
    # rules that are no gates, as that of a missing zero
    advice |= RULES["others"]
    advice[EXCLUDED] = EXCLUDED_ADVICE
    # some rules have another advice for one kind of rig
    advice |= RULES[rig_class.name]
    # mistakes in a log that would explain its faults, as two exchanged columns
    for name, text in RULES["mistakes"].items():
        advice[name] = f"{text} {_IF_NOT_THE_MISTAKE}"
    return str(advice[rule]).format(**rig_class.terms)


def quarantine_rows(
    refusals: list[Refusal], runs: pd.DataFrame, rig_class: type[RigKind]
) -> pd.DataFrame:
    """The table of quarantine for refusals by curation.

    Args:
        refusals: The refusals.
        runs: Table of runs, with the run of each refusal.
        rig_class: The class of the kind of rig.
    """
    columns_of_run: dict[Any, dict[Any, Any]] = runs.set_index("run_id")[
        ["campaign", "file", "oil"]
    ].to_dict("index")
    rows: list[dict[str, Any]] = []
    for refusal in refusals:
        row: dict[str, Any] = {"stage": "curate", **columns_of_run[refusal.run_id]}
        row |= asdict(refusal)
        row["advice"] = advice_for(refusal.rule, rig_class)
        rows.append(row)
    return tables.from_rows(rows, "quarantine")


def judge_plateaus(points: pd.DataFrame, rig_kind: RigKind) -> pd.DataFrame:
    """The gates that each plateau fails: one boolean column per gate, one row per plateau."""
    gates = PLATEAU_GATES.for_rig(rig_kind.name) if len(points) else []
    return pd.DataFrame(
        {
            plateau_gate.name: np.asarray(plateau_gate.judge(points, rig_kind))
            for plateau_gate in gates
        },
        index=points.index,
        dtype=bool,
    )


def refusals_of_unusable_runs(
    points: pd.DataFrame, failed_by_gate: pd.DataFrame, rig_kind: RigKind
) -> Iterator[Refusal]:
    """Refusals of runs without a usable plateau, or with too many faulty plateaus.

    Args:
        points: Plateaus of any number of runs.
        failed_by_gate: The gates that each plateau fails, as `judge_plateaus` gives them.
        rig_kind: The kind of rig, with its settings.
    """
    if points.empty:
        return
    judgements = _judgements(points, failed_by_gate, rig_kind)
    judgements_by_run = judgements.groupby(points["run_id"])
    share_by_run = judgements_by_run.mean()
    count_by_run = judgements_by_run.sum()
    any_by_run = judgements_by_run.any()
    largest_faulty_share = rig_kind.gate_limits.faulty_share_max
    fewest_faulty = rig_kind.gate_limits.faulty_plateaus_min
    do_many_fail = share_by_run["faulty_where_held"] > largest_faulty_share
    do_many_fail &= count_by_run["faulty_where_held"] >= fewest_faulty
    largest_share_where_not_held = max(1 / 2, largest_faulty_share)
    do_most_fail = share_by_run["faulty"] > largest_share_where_not_held
    is_blamed = judgements["faulty_where_held"].where(
        points["run_id"].map(do_many_fail), judgements["faulty"]
    )
    judgements = judgements.assign(blamed=is_blamed)
    is_refused = ~any_by_run["usable"] | do_most_fail | do_many_fail | any_by_run["unphysical"]
    for run_id in any_by_run.index[is_refused]:
        is_of_run = points["run_id"] == run_id
        refusal = _refusal_of_run(
            points[is_of_run],
            failed_by_gate[is_of_run],
            judgements[is_of_run],
            rig_kind,
            allowed_share=largest_faulty_share
            if do_many_fail[run_id]
            else largest_share_where_not_held,
        )
        yield replace(refusal, run_id=str(run_id))


def _judgements(
    points: pd.DataFrame, failed_by_gate: pd.DataFrame, rig_kind: RigKind
) -> pd.DataFrame:
    """What each plateau means for its run: boolean columns, one row per plateau.

    - `informative`: it slides, or no plateau of its run does;
    - `held`: its slip is steady, which it is not on a ramp between two slips;
    - `unphysical`: slip and load are right, and no oil has the traction;
    - `usable`: it is informative and passes all gates;
    - `faulty`: it fails a gate that blames the run;
    - `faulty_where_held`: it is faulty and held.
    """
    blaming_gate_names = [
        plateau_gate.name
        for plateau_gate in PLATEAU_GATES.for_rig(rig_kind.name)
        if plateau_gate.blames_run
    ]
    is_faulty = failed_by_gate[blaming_gate_names].any(axis=1)
    judgements = pd.DataFrame(
        {"informative": True, "held": True, "unphysical": False}, index=points.index
    )
    if isinstance(rig_kind, TractionRig):
        is_sliding = points["slide_roll_ratio"].abs() > rig_kind.zero_settings.max_slide_roll_ratio
        is_held = _is_slip_held(points, rig_kind)
        has_other_cause = failed_by_gate[
            ["slip_out_of_range", "load_off_nominal", "load_changes"]
        ].any(axis=1)
        judgements = judgements.assign(
            informative=is_sliding | ~points["run_id"].isin(points.loc[is_sliding, "run_id"]),
            held=is_held,
            unphysical=~has_other_cause & is_held & _is_surely_unphysical(points, rig_kind),
        )
    is_usable = judgements["informative"] & ~failed_by_gate.any(axis=1)
    return judgements.assign(
        usable=is_usable, faulty=is_faulty, faulty_where_held=is_faulty & judgements["held"]
    )


def _refusal_of_run(
    points: pd.DataFrame,
    failed_by_gate: pd.DataFrame,
    judgements: pd.DataFrame,
    rig_kind: RigKind,
    *,
    allowed_share: float,
) -> Refusal:
    """The refusal of one run that cannot be used.

    Args:
        points: Its plateaus.
        failed_by_gate: The gates that each of them fails.
        judgements: Columns of `_judgements`, and `blamed`: the plateaus whose faults count.
        rig_kind: The kind of rig, with its settings.
        allowed_share: Largest share of blamed plateaus that does not refuse the run.
    """
    gates = PLATEAU_GATES.for_rig(rig_kind.name)
    for plateau_gate in gates:
        if failed_by_gate[plateau_gate.name].all():
            return Refusal(plateau_gate.name, sentence_of(plateau_gate, points, rig_kind), "")
    is_unphysical = judgements["unphysical"]
    if is_unphysical.any() and isinstance(rig_kind, TractionRig):
        worst_point = points.iloc[
            points["traction_coefficient"].abs().where(is_unphysical).argmax()
        ]
        return refusal_by(
            "impossible_traction",
            count=is_unphysical.sum(),
            plateaus=len(points),
            worst=worst_point,
            hint=_hint_at_unit_of_load(points, rig_kind),
            first=worst_point["first_row"],
            last=worst_point["last_row"],
        )
    is_informative = judgements["informative"]
    if not judgements["usable"].any():
        return refusal_by(
            "no_point_left",
            count=is_informative.sum(),
            that_slide="" if is_informative.all() else " that slide",
            counts=_gate_counts_in_words(failed_by_gate[is_informative]),
        )
    is_blamed = judgements["blamed"]
    blaming_gate_names = [plateau_gate.name for plateau_gate in gates if plateau_gate.blames_run]
    return refusal_by(
        "many_plateaus_fail",
        count=is_blamed.sum(),
        plateaus=len(points),
        share=is_blamed.mean(),
        counts=_gate_counts_in_words(failed_by_gate.loc[is_blamed, blaming_gate_names]),
        allowed=allowed_share,
    )


def _gate_counts_in_words(failed_by_gate: pd.DataFrame) -> str:
    """The number of plateaus that fail each gate, as in `spiky 3, not_steady 1`."""
    counts = failed_by_gate.sum().sort_values(ascending=False, kind="stable")
    return ", ".join(f"{name} {count}" for name, count in counts.items() if count)
