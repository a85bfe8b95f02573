"""Refusals of curation: a finding becomes a sentence here, and a refusal becomes a row."""

from collections.abc import Mapping

import pandas as pd

from oilfilm import tables
from oilfilm.curation.gate import Finding, Gate, Judgement, PlateauGate, RunGate
from oilfilm.curation.plateau_gates import PLATEAU_GATES
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.run_gates import RUN_GATES
from oilfilm.readers.base import Refusal

# What to do about a refusal by a rule that is no gate, on any rig.
_ADVICE = {
    "zero_drift": "Let the {sensor} sensor warm up, check its mounting, and repeat the run.",
    "no_rows": "Look whether the logger wrote anything, or repeat the run.",
    "no_plateau": "Hold each {level} longer than settle_s + min_duration_s of config.yaml.",
    "no_point_left": "Look at the gates that are named, one by one.",
    "duplicate_log": "Take one of the files out; a copy adds nothing.",
    "repeated_label": "Give each run a name of its own, or take one of the logs out.",
    "duplicate_condition": "Take one of the logs out, or set repeated_conditions: accept.",
}


def run_gates(kind: RigKind) -> list[RunGate]:
    """The gates of runs that judge a kind of rig."""
    return [gate for gate in RUN_GATES if kind.name in gate.rigs]


def plateau_gates(kind: RigKind) -> list[PlateauGate]:
    """The gates of plateaus that judge a kind of rig."""
    return [gate for gate in PLATEAU_GATES if kind.name in gate.rigs]


def advice_for(rule: str, kind: RigKind) -> str:
    """What to do about a refusal by the gate or rule of that name."""
    every_gate: tuple[Gate, ...] = (*RUN_GATES, *PLATEAU_GATES)
    gates = {gate.name: gate.advice for gate in every_gate}
    return {**gates, **_ADVICE, **kind.advice}[rule].format(**kind.words)


def refusal(rule: str, finding: Finding, kind: RigKind, run_id: str) -> Refusal:
    """A finding about a run as a refusal, with its sentence and the advice for the rig."""
    rows = {"first_row": finding.first_row, "last_row": finding.last_row}
    numbers = {**finding.numbers, **rows}
    sentence = finding.sentence.format(**{**kind.words, **numbers})
    return Refusal(rule, sentence, advice_for(rule, kind), run_id, **rows, numbers=numbers)


def refusal_of_all(rule: str, judgement: Judgement, kind: RigKind, run_id: str) -> Refusal:
    """The refusal of a run of which one gate refuses every plateau."""
    return refusal(rule, Finding(judgement.sentence, numbers=judgement.numbers), kind, run_id)


def quarantine_rows(refusals: list[Refusal], runs: pd.DataFrame) -> pd.DataFrame:
    """The table of quarantine of refusals by curation.

    Args:
        refusals: Each of one run.
        runs: Table of runs, which has them all.
    """
    about: Mapping[str, Mapping[str, str]] = runs.set_index("run_id")[["campaign", "file"]].to_dict(
        "index"
    )  # type: ignore[assignment]
    rows = []
    for each in refusals:
        rows.append({**about[each.run_id], "stage": "curate", **each.row()})
    return tables.from_rows(rows, "quarantine")
