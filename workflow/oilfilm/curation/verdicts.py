"""Verdicts on plateaus, and on the runs of which too few of them can be trusted.

Decides: when faulty plateaus refuse their run.
"""

import numpy as np
import pandas as pd

from oilfilm.curation.gate import Finding, Limits, TractionLimits
from oilfilm.curation.plateau_gates import (
    possible_load_units,
    slip_is_held,
    surely_unphysical,
)
from oilfilm.curation.refusals import plateau_gates, refusal
from oilfilm.curation.rig_kind import RigKind
from oilfilm.logs.base import Refusal
from oilfilm.tables import failed_gates

# Two faulty plateaus may be two mishaps, where they are not most of a short run.
_MANY = 3


def judge_plateaus(points: pd.DataFrame, kind: RigKind, limits: Limits) -> pd.DataFrame:
    """Which gates each plateau fails: one boolean column per gate, one row per plateau."""
    gates = plateau_gates(kind) if len(points) else []
    return pd.DataFrame(
        {gate.name: np.asarray(gate.judge(points, limits).fails) for gate in gates},
        index=points.index,
        dtype=bool,
    )


def with_gates(
    points: pd.DataFrame, kind: RigKind, limits: Limits
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Plateaus with their verdicts, and which gates each of them fails."""
    failed = judge_plateaus(points, kind, limits)
    accepted = ~failed.any(axis=1)
    return points.assign(failed_gates=failed_gates.as_text(failed), accepted=accepted), failed


def not_usable(
    points: pd.DataFrame, failed: pd.DataFrame, kind: RigKind, limits: Limits
) -> list[str]:
    """Runs of which no plateau is left, or of which the others cannot be trusted either."""
    run_id = points["run_id"]
    left = (points["accepted"] & _wanted(points, limits)).groupby(run_id).any()
    blamed = _blamed(points, failed, kind)
    most = blamed.any(axis=1).groupby(run_id).mean() > max(1 / 2, limits.faulty_share_max)
    held = _where_held(blamed, points, limits).any(axis=1).groupby(run_id)
    many = (held.mean() > limits.faulty_share_max) & (held.sum() >= _MANY)
    unphysical = _unphysical(points, failed, limits).groupby(run_id).any()
    return [str(run_id) for run_id in left.index[~left | most | many | unphysical]]


def _wanted(points: pd.DataFrame, limits: Limits) -> "pd.Series[bool]":
    """The plateaus that a run is made for: those that slide, where it has any."""
    if not isinstance(limits, TractionLimits):
        return pd.Series(True, index=points.index)
    sliding = points["slide_roll_ratio"].abs() > limits.rolling_slip_max
    return sliding | ~points["run_id"].isin(points.loc[sliding, "run_id"])


def _blamed(points: pd.DataFrame, failed: pd.DataFrame, kind: RigKind) -> pd.DataFrame:
    """Failures of gates that show a fault of the run."""
    names = [gate.name for gate in plateau_gates(kind) if gate.blames_run and len(failed)]
    return failed.loc[points.index, names]


def _where_held(blamed: pd.DataFrame, points: pd.DataFrame, limits: Limits) -> pd.DataFrame:
    """The failures without those of ramps between two slips."""
    if not isinstance(limits, TractionLimits) or blamed.empty:
        return blamed
    return blamed.mul(slip_is_held(points, limits), axis=0)


def _unphysical(points: pd.DataFrame, failed: pd.DataFrame, limits: Limits) -> "pd.Series[bool]":
    """Plateaus with slip and load as they should be and a traction that no oil has."""
    failed = failed.loc[points.index]
    if not isinstance(limits, TractionLimits) or len(failed) == 0:
        return pd.Series(False, index=points.index)
    causes = failed[["slip_out_of_range", "load_off_nominal", "load_changes"]].any(axis=1)
    return ~causes & slip_is_held(points, limits) & surely_unphysical(points, limits)


def why_not_used(
    points: pd.DataFrame, failed: pd.DataFrame, kind: RigKind, limits: Limits
) -> Refusal:
    """The refusal of a run that no plateau is left of, or too few."""
    run_id, failed = points["run_id"].iloc[0], failed.loc[points.index]
    for gate in plateau_gates(kind):
        if failed[gate.name].all():
            return refusal(gate.name, Finding(gate.judge(points, limits).sentence), kind, run_id)
    unphysical = _unphysical(points, failed, limits)
    if unphysical.any() and isinstance(limits, TractionLimits):
        worst = points.iloc[points["traction_coefficient"].abs().where(unphysical).argmax()]
        sentence = (
            f"on {unphysical.sum()} of the {len(points)} plateaus slip and load are as they should "
            "be, but the traction coefficient is impossible, as "
            f"{worst['traction_coefficient']:.4f} at a slide-roll ratio of "
            f"{worst['slide_roll_ratio']:.4f}, so that the others cannot be trusted"
            f"{possible_load_units(points, limits)}"
        )
        rows = int(worst["first_row"]), int(worst["last_row"])
        return refusal("impossible_traction", Finding(sentence, *rows), kind, run_id)
    wanted = _wanted(points, limits)
    if not points.loc[wanted, "accepted"].any():
        sentence = (
            f"none of the {wanted.sum()} plateaus{'' if wanted.all() else ' that slide'} passes "
            f"every gate ({_counts(failed[wanted])})"
        )
        return refusal("no_point_left", Finding(sentence), kind, run_id)
    blamed = _blamed(points, failed, kind)
    held = _where_held(blamed, points, limits)
    if held.any(axis=1).mean() > limits.faulty_share_max and held.any(axis=1).sum() >= _MANY:
        blamed = held
    count = blamed.any(axis=1).sum()
    sentence = (
        f"{count} of the {len(points)} plateaus ({count / len(points):.0%}) fail gates that show a "
        f"fault of the run ({_counts(blamed)}), so that the others cannot be trusted; allowed "
        f"{limits.faulty_share_max:.0%}"
    )
    return refusal("many_plateaus_fail", Finding(sentence), kind, run_id)


def _counts(failed: pd.DataFrame) -> str:
    """How many plateaus fail each gate, as in `spiky 3, not_steady 1`."""
    counts = failed.sum().sort_values(ascending=False, kind="stable")
    return ", ".join(f"{name} {count}" for name, count in counts.items() if count)
