"""Refusals of curation: a finding gets its advice here, and a refusal becomes a row.

Decides: the row of a refusal, with its advice.
"""

from dataclasses import asdict
from typing import Any

import pandas as pd

from oilfilm import tables
from oilfilm.curation.gate import Finding, Gate, PlateauJudge, RunJudge
from oilfilm.curation.hypotheses import ADVICE as HYPOTHESIS_ADVICE
from oilfilm.curation.plateau_gates import PLATEAU_GATES
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.run_gates import RUN_GATES
from oilfilm.logs.base import Refusal
from oilfilm.logs.run_sheet import EXCLUDED, EXCLUDED_ADVICE

# What to do about a refusal by a rule that is no gate, on any rig.
OTHER_ADVICE = {
    "zero_drift": "Let the {sensor} sensor warm up, check its mounting, and repeat the run.",
    "no_rows": "Check whether the logger wrote any data, or repeat the run.",
    "no_plateau": "Hold each {level} longer than settle_s + min_duration_s of config.yaml.",
    "no_point_left": "Look at the gates that are named, one by one.",
    "many_plateaus_fail": "Look at the gates that are named, one by one, and repeat the run.",
    "impossible_traction": "Check the units of force and load, and the zero and calibration of the "
    "{sensor} sensor.",
    EXCLUDED: EXCLUDED_ADVICE,
    "duplicate_log": "Take one of the files out; a copy adds nothing.",
    "repeated_label": "Give each run a name of its own, or take one of the logs out.",
    "conflicting_labels": "Find out which oil was run, correct the other label or take it out.",
    "conflicting_condition": "Find out which of the runs has the wrong label or went wrong, and "
    "take it out; then the other one is used.",
    "duplicate_condition": "Take one of the logs out, or set repeated_conditions: accept.",
}


def run_gates(kind: RigKind) -> list[Gate[RunJudge]]:
    """The gates of runs that judge a kind of rig."""
    return [gate for gate in RUN_GATES if kind.name in gate.rigs]


def plateau_gates(kind: RigKind) -> list[Gate[PlateauJudge]]:
    """The gates of plateaus that judge a kind of rig."""
    return [gate for gate in PLATEAU_GATES if kind.name in gate.rigs]


def advice_for(rule: str, kind: RigKind) -> str:
    """What to do about a refusal by the gate or rule of that name."""
    gates: list[Gate[Any]] = [*RUN_GATES, *PLATEAU_GATES]
    of_gates = {gate.name: gate.advice for gate in gates}
    advice = {**of_gates, **OTHER_ADVICE, **HYPOTHESIS_ADVICE, **kind.advice}
    return advice[rule].format(**kind.words)


def refusal(rule: str, finding: Finding, kind: RigKind, run_id: str) -> Refusal:
    """A finding about a run as a refusal, with the advice for the rig."""
    sentence, first_row, last_row = finding
    return Refusal(rule, sentence, advice_for(rule, kind), run_id, first_row, last_row)


def quarantine_rows(refusals: list[Refusal], runs: pd.DataFrame) -> pd.DataFrame:
    """The table of quarantine of refusals by curation; `runs` has the run of each."""
    of_run = dict(
        zip(runs["run_id"], zip(runs["campaign"], runs["file"], strict=True), strict=True)
    )
    rows = [
        {"campaign": campaign, "file": file, "stage": "curate", **asdict(each)}
        for each in refusals
        for campaign, file in [of_run[each.run_id]]
    ]
    return tables.from_rows(rows, "quarantine")
