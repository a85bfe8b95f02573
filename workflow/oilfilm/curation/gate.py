"""What a gate is: one function that finds a fault, and what `rules.yaml` says of it.

A gate of runs looks at the signals of one run; a gate of plateaus looks at the plateaus of many
runs at once. `run_gates.py` and `plateau_gates.py` define them all in the order in which they
judge. A new gate is one function there, which gives numbers, and one entry in `rules.yaml`, which
has the sentence and the advice.

Decides: which rigs a gate judges, when it cannot be applied, and the sentence and the advice for
every rule.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

import pandas as pd
import yaml

from oilfilm.curation.rig_kind import RigKind, Run
from oilfilm.logs.base import Refusal
from oilfilm.units import BoolArray

# The rules and their advice, by kind of rule.
RULES: Mapping[str, Any] = yaml.load(
    Path(__file__).with_name("rules.yaml").read_bytes(),
    getattr(yaml, "CSafeLoader", yaml.SafeLoader),  # noqa: S506
)
# What a force may be in although it is labelled N, by definition.
_FORCE_UNITS_N = {"kgf": 9.80665, "lbf": 4.4482216152605, "gf": 9.80665e-3, "kN": 1e3}


def refused(rule: str, sentence: str, numbers: Mapping[str, Any]) -> Refusal:
    """A refusal by a rule; the advice is added where it becomes a row of the quarantine.

    Args:
        rule: The rule.
        sentence: What was found.
        numbers: May have the run as `run_id`, and the rows concerned as `first` and `last`.
    """
    first, last = (int(numbers.get(row, 0)) for row in ("first", "last"))
    return Refusal(rule, sentence, "", str(numbers.get("run_id", "")), first, last)


def fault(rule: str, sentence: str = "", /, **numbers: Any) -> Refusal:
    """A refusal by a rule that is no gate.

    Args:
        rule: The rule.
        sentence: Name of the sentence in `rules.yaml`, where it is not the rule's.
        numbers: What was found, as the sentence and `refused` need it.
    """
    return refused(rule, RULES["sentences"][sentence or rule].format(**numbers), numbers)


def unit_hint(name: str, fits: Callable[[float], bool]) -> str:
    """The units that a force labelled N may be in, as a hint.

    Args:
        name: The force in words.
        fits: Whether the run would be right with the force so many times as large.
    """
    units = " or ".join(unit for unit, newton in _FORCE_UNITS_N.items() if fits(newton))
    return f"; the {name} may be in {units}" if units else ""


# What a gate found in a run, as its sentence needs it; `first` and `last` are the rows concerned.
Found = Iterator[dict[str, Any]]
# A check of one run, of which the first thing found counts. The limits are those of the rig.
RunJudge = Callable[[Run, Any], Found]
# A check of plateaus, which carry the oil and the set points of their run: those that it refuses.
# Where its quantity is null (no set point, no second half) it does not refuse.
PlateauJudge = Callable[[pd.DataFrame, Any], "pd.Series[bool] | BoolArray"]
Judge = TypeVar("Judge", RunJudge, PlateauJudge)


@dataclass(frozen=True)
class Gate(Generic[Judge]):
    """A check with what `rules.yaml` says of it.

    Attributes:
        name: Of its function.
        judge: The function.
        judges: Kinds of rig, separated by blanks.
        finds: Sentence about a refusal, with names of numbers in braces.
        advice: What to do about a refusal.
        blames_run: For gates of plateaus: it shows a fault of the run. Where many plateaus fail
            it, the others are no better.
        needs: A column of plateaus or of runs, or a list of the rig. Where it is null in all
            plateaus, or empty, the gate cannot be applied. Empty where it needs none.
    """

    name: str
    judge: Judge
    judges: str
    finds: str
    advice: str = ""
    blames_run: bool = True
    needs: str = ""

    def sentence(self, rig: RigKind, **numbers: Any) -> str:
        """The sentence about a refusal, by the limits of the rig and what was found."""
        return self.finds.format(rig=rig, gates=rig.gates, **numbers)


class Gates(list[Gate[Judge]]):
    """Gates in the order in which they judge; `part` of `rules.yaml` has what they find."""

    def __init__(self, part: str = "gates") -> None:
        self._part = part

    def gate(self, judge: Judge) -> Judge:
        """Make a function a gate under its own name, the last one so far."""
        self.append(Gate(judge.__name__, judge, **RULES[self._part][judge.__name__]))
        return judge

    def of(self, kind: str) -> list[Gate[Judge]]:
        """The gates that judge a kind of rig."""
        return [gate for gate in self if kind in gate.judges.split()]
