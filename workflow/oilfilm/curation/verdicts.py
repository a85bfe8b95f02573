"""Verdicts on plateaus and runs; a finding gets its advice here, and a refusal becomes a row.

Decides: when faulty plateaus refuse their run; the row of a refusal, with its advice.
"""

from collections.abc import Iterator
from dataclasses import asdict, replace

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.curation.gate import RULES, fault
from oilfilm.curation.plateau_gates import (
    PLATEAU_GATES,
    sentence_of,
    slip_is_held,
    surely_unphysical,
    unit_of_load,
)
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.logs.base import Refusal
from oilfilm.logs.run_sheet import EXCLUDED, EXCLUDED_ADVICE

# Two faulty plateaus may be two mishaps, where they are not most of a short run.
_MANY = 3
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
    share = rig.gates.faulty_share_max
    many = (means["faulty_where_held"] > share) & (counts["faulty_where_held"] >= _MANY)
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
