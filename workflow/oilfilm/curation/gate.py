"""A gate: one function that finds what is wrong, and its entry in `rules.yaml`.

A gate of runs judges the signals of one run. A gate of plateaus judges the plateaus of many runs at
once. `run_gates.py` and `plateau_gates.py` define all gates in the order in which they judge. A new
gate is one function there, which gives the values of the fields of a sentence, and one entry in
`rules.yaml`, which has the sentence and the advice.

Decides: which rigs a gate judges, when it cannot be applied, and the sentence and the advice for
every rule.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

import pandas as pd
import yaml

from oilfilm.base.units import BoolArray
from oilfilm.curation.rig_kind import MeasuredRun, RigKind
from oilfilm.logs.base import Refusal

# Group of rules -> rule -> its entry. Comments in `rules.yaml` say what the entries of a group are.
RULES: Mapping[str, Any] = yaml.load(
    Path(__file__).with_name("rules.yaml").read_bytes(),
    getattr(yaml, "CSafeLoader", yaml.SafeLoader),  # noqa: S506
)
# Unit of force -> its size in N, by definition. A force in one of these units may be labelled N.
_FORCE_UNIT_SIZE_N = {"kgf": 9.80665, "lbf": 4.4482216152605, "gf": 9.80665e-3, "kN": 1e3}


def refusal_with_sentence(rule: str, sentence: str, fields: Mapping[str, Any]) -> Refusal:
    """A refusal by a rule; its advice is added when it becomes a row of the quarantine.

    Args:
        rule: The rule.
        sentence: What was found.
        fields: May have the run as `run_id`, and the rows concerned as `first` and `last`.
    """
    return Refusal(
        rule,
        sentence,
        advice="",
        run_id=str(fields.get("run_id", "")),
        first_row=int(fields.get("first", 0)),
        last_row=int(fields.get("last", 0)),
    )


def refusal_by(rule: str, sentence_name: str = "", /, **fields: Any) -> Refusal:
    """A refusal by a rule that is no gate.

    Args:
        rule: The rule.
        sentence_name: Name of the sentence in `rules.yaml`, where it is not the rule's.
        fields: Numbers and names for the sentence and for `refusal_with_sentence`.
    """
    return refusal_with_sentence(rule, sentence_named(sentence_name or rule, **fields), fields)


def sentence_named(sentence_name: str, /, **fields: Any) -> str:
    """A sentence of a refusal or of a warning.

    Args:
        sentence_name: Its name in `rules.yaml`, group `sentences`.
        fields: Numbers and names for the sentence.
    """
    return str(RULES["sentences"][sentence_name].format(**fields))


def unit_hint(force_name: str, is_usual_in_unit: Callable[[float], bool]) -> str:
    """A hint at the units in which a force labelled N may be; empty without one.

    Args:
        force_name: The force in words.
        is_usual_in_unit: Function of the size of a unit in N. It says whether the run would be
            usual with the force in this unit.
    """
    units = [
        unit for unit, unit_size_n in _FORCE_UNIT_SIZE_N.items() if is_usual_in_unit(unit_size_n)
    ]
    return f"; the {force_name} may be in {' or '.join(units)}" if units else ""


# Numbers and names for the sentence of a gate of runs, once for each reason to refuse the run or to
# warn of it. `first` and `last` are the rows concerned.
FindingFields = Iterator[dict[str, Any]]
# A check of one run. It is called with the run and the kind of its rig (`RigKind`), which has the
# limits of gates. The first reason counts.
RunJudge = Callable[[MeasuredRun, Any], FindingFields]
# A check of plateaus, which have the oil and the set points of their run. It is called with them
# and the kind of their rig, and gives those that it refuses. A plateau whose quantity is null (no
# set point, no second half) is not refused.
PlateauJudge = Callable[[pd.DataFrame, Any], "pd.Series[bool] | BoolArray"]
Judge = TypeVar("Judge", RunJudge, PlateauJudge)


@dataclass(frozen=True)
class Gate(Generic[Judge]):
    """A check and its entry in `rules.yaml`.

    Attributes:
        name: Name of its function.
        judge: The function.
        rig_kinds: Names of the kinds of rig that it judges, separated by blanks.
        finds: Sentence about what it found, with fields in braces.
        advice: What to do about a refusal.
        blames_run: For gates of plateaus: whether a plateau that fails shows that the run is wrong.
            If many plateaus fail such a gate, the others cannot be trusted.
        needs: A column of plateaus or of runs, or a list of the rig. Where it is null in all
            plateaus, or empty, the gate cannot be applied. Empty where the gate needs none.
    """

    name: str
    judge: Judge
    rig_kinds: str
    finds: str
    advice: str = ""
    blames_run: bool = True
    needs: str = ""

    def sentence(self, rig_kind: RigKind, **fields: Any) -> str:
        """The sentence about a refusal, with the limits of the rig and the values of its fields."""
        return self.finds.format(rig_kind=rig_kind, gates=rig_kind.gate_limits, **fields)


class Gates(list[Gate[Judge]]):
    """Gates in the order in which they judge.

    Args:
        section: The section of `rules.yaml` that has their entries.
    """

    def __init__(self, section: str = "gates") -> None:
        self._section = section

    def gate(self, judge: Judge) -> Judge:
        """Add a function as the last gate, under its own name."""
        entry = RULES[self._section][judge.__name__]
        self.append(Gate(judge.__name__, judge, **entry))
        return judge

    def for_rig(self, rig_kind_name: str) -> list[Gate[Judge]]:
        """The gates that judge a kind of rig."""
        return [gate for gate in self if rig_kind_name in gate.rig_kinds.split()]
