"""What a gate is: one function that finds a fault, and what `rules.yaml` says of it.

A gate of runs looks at the signals of one run; a gate of plateaus looks at the plateaus of many
runs at once. `run_gates.py` and `plateau_gates.py` define them all in the order in which they
judge. A new gate is one function there, which gives numbers, and one entry in `rules.yaml`, which
has the sentence and the advice.

Decides: which rigs a gate judges, when it cannot be applied, and the sentence and the advice for
every rule.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt
import pandas as pd
import yaml

from oilfilm.curation.statistics import median
from oilfilm.settings.config import (
    GateSettings,
    PlateauSettings,
    SignalGateSettings,
    StuckSettings,
    TareSettings,
    TorqueGateSettings,
    TorquePlateauSettings,
    ZeroReferenceSettings,
)
from oilfilm.units import BoolArray, FloatArray, IndexArray

TRACTION, TORQUE = "traction", "torque"

# The rules and their advice, by kind of rule.
RULES: Mapping[str, Any] = yaml.load(
    Path(__file__).with_name("rules.yaml").read_bytes(),
    getattr(yaml, "CSafeLoader", yaml.SafeLoader),  # noqa: S506
)
# Plateaus of one run: column -> array over them.
Columns = dict[str, npt.NDArray[Any]]
# What a force may be in although it is labelled N, by definition.
_FORCE_UNITS_N = {"kgf": 9.80665, "lbf": 4.4482216152605, "gf": 9.80665e-3, "kN": 1e3}
# No logger of a rig is faster; damaged time stamps are, and would give endless windows.
_SHORTEST_INTERVAL_S = 1e-6


@dataclass(frozen=True)
class Signals:
    """One run: `row` and `time_s` of each sample, every other signal by the name of its column."""

    row: IndexArray
    time_s: FloatArray
    columns: Mapping[str, FloatArray]

    @cached_property
    def interval_s(self) -> float:
        """Median time between samples, in s; 1 where there are too few to tell."""
        usual = median(np.diff(self.time_s))
        return max(usual, _SHORTEST_INTERVAL_S) if usual > 0 else 1.0

    def at(self, chosen: BoolArray | slice) -> "Signals":
        """The samples that a mask or a slice chooses."""
        if not isinstance(chosen, slice) and chosen.all():
            return self
        columns = {name: values[chosen] for name, values in self.columns.items()}
        return Signals(self.row[chosen], self.time_s[chosen], columns)

    def __getitem__(self, column: str) -> FloatArray:
        return self.columns[column]

    def __len__(self) -> int:
        return len(self.row)


class Channel(NamedTuple):
    """A signal as sentences name it."""

    column: str
    name: str
    unit: str


class Finding(NamedTuple):
    """What a gate found in a run: a sentence and the rows concerned, 0 where none is meant."""

    sentence: str
    first_row: int = 0
    last_row: int = 0


# Rule and finding about a run.
Fault = tuple[str, Finding]


def found(rule: str, **numbers: Any) -> Finding:
    """What was found, by the sentence that `rules.yaml` has for a rule that is no gate."""
    rows = (int(numbers.get(row, 0)) for row in ("first", "last"))
    return Finding(RULES["sentences"][rule].format(**numbers), *rows)


def fault(rule: str, **numbers: Any) -> Fault:
    """A rule that is no gate, and what was found."""
    return rule, found(rule, **numbers)


@dataclass(frozen=True)
class Run:
    """One measured run, as the gates of runs look at it.

    Attributes:
        signals: All samples of the run.
        working: Those between the phases that give the zero at which the rig turns.
        plateaus: Columns over the plateaus. Tables are made of all runs at once, because a small
            table costs as much as a large one.
        sensor: The signal whose zero is removed: traction force or torque.
        load: The signal of the load.
        channels: The other logged signals, the load among them.
        flaw: Rule and finding where the run gives no zero.
        too_short: Levels that give no plateau.
    """

    signals: Signals
    working: Signals
    plateaus: Columns
    sensor: Channel
    load: Channel
    channels: Sequence[Channel]
    flaw: Fault | None = None
    too_short: Sequence[Finding] = ()


def unit_hint(name: str, fits: Callable[[float], bool]) -> str:
    """The units that a force labelled N may be in, as a hint.

    Args:
        name: The force in words.
        fits: Whether the run would be right with the force so many times as large.
    """
    units = " or ".join(unit for unit, newton in _FORCE_UNITS_N.items() if fits(newton))
    return f"; the {name} may be in {units}" if units else ""


@dataclass(frozen=True)
class Limits:
    """What the gates of every rig compare with; the drift of the zero in the sensor's unit."""

    zero_drift_max: float
    gates: SignalGateSettings
    stuck: StuckSettings
    plateaus: PlateauSettings | TorquePlateauSettings
    zero: ZeroReferenceSettings | TareSettings


@dataclass(frozen=True)
class TractionLimits(Limits):
    """What the gates of traction rigs compare with."""

    gates: GateSettings
    plateaus: PlateauSettings
    zero: ZeroReferenceSettings
    planned_slips: Sequence[float]
    accept_unjudged_film: bool


@dataclass(frozen=True)
class TorqueLimits(Limits):
    """What the gates of torque rigs compare with."""

    gates: TorqueGateSettings
    plateaus: TorquePlateauSettings
    zero: TareSettings


# What a gate found in a run, as its sentence needs it; `first` and `last` are the rows concerned.
Found = Iterator[dict[str, Any]]
# A check of one run, of which the first thing found counts. The limits are those of its rigs.
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
        needs: A column of plateaus or of runs, or a list of the limits. Where it is null in all
            plateaus, or empty, the gate cannot be applied. Empty where it needs none.
    """

    name: str
    judge: Judge
    judges: str
    finds: str
    advice: str = ""
    blames_run: bool = True
    needs: str = ""

    @property
    def rigs(self) -> tuple[str, ...]:
        """The kinds of rig that it judges."""
        return tuple(self.judges.split())

    def sentence(self, limits: Limits, **numbers: Any) -> str:
        """The sentence about a refusal, by the limits and what was found."""
        return self.finds.format(limits=limits, gates=limits.gates, **numbers)


class Gates(list[Gate[Judge]]):
    """Gates in the order in which they judge; `part` of `rules.yaml` has what they find."""

    def __init__(self, part: str = "gates") -> None:
        self._part = part

    def gate(self, judge: Judge) -> Judge:
        """Make a function a gate under its own name, the last one so far."""
        self.append(Gate(judge.__name__, judge, **RULES[self._part][judge.__name__]))
        return judge

    def of(self, rig: str) -> list[Gate[Judge]]:
        """The gates that judge a kind of rig."""
        return [gate for gate in self if rig in gate.rigs]
