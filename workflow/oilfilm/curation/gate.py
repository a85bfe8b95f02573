"""What a gate is: one function that finds a fault, with its advice and the rigs that it judges.

A gate of runs looks at the signals of one run; a gate of plateaus looks at the plateaus of many
runs at once. `run_gates.py` and `plateau_gates.py` define them all in the order in which they
judge. A new gate is one function there.

Decides: which rigs a gate judges, and when it cannot be applied.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, TypeVar

import numpy.typing as npt
import pandas as pd

from oilfilm.curation.signals import Signals
from oilfilm.curation.statistics import BoolArray
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

TRACTION, TORQUE = "traction", "torque"
BOTH = (TRACTION, TORQUE)

# Plateaus of one run: column -> array over them.
Columns = dict[str, npt.NDArray[Any]]


@dataclass(frozen=True)
class Channel:
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


class Judgement(NamedTuple):
    """Which plateaus a gate refuses, and the sentence about them all."""

    fails: "pd.Series[bool] | BoolArray"
    sentence: str


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


# A check of one run: None where the run passes. The limits are those of the rigs that it judges.
RunJudge = Callable[[Run, Any], Finding | None]
# A check of plateaus, which carry the oil and the set points of their run. Where its quantity is
# null (no set point, no second half) it does not refuse.
PlateauJudge = Callable[[pd.DataFrame, Any], Judgement]
Judge = TypeVar("Judge", RunJudge, PlateauJudge)


class Need(NamedTuple):
    """What a gate cannot be applied without.

    Attributes:
        name: A column of plateaus or of runs, or a list of the limits. Where it is null in all
            plateaus, or empty, the gate cannot be applied.
        lacking: Why a log may not have it, as `oilfilm check` says.
    """

    name: str
    lacking: str


# Needs of several gates.
HELD_LEVELS = Need("duration_s", "each row is a settled reading, without a beginning and an end")
MEASURED_TRACTION = Need(
    "traction_coefficient",
    "no traction coefficient: the log has no force, or the force no zero",
)


@dataclass(frozen=True)
class Gate(Generic[Judge]):
    """A check with its advice and the kinds of rig that it judges.

    A gate of plateaus that `blames_run` shows a fault of the run: where many plateaus fail it, the
    others are no better.
    """

    name: str
    rigs: tuple[str, ...]
    advice: str
    judge: Judge
    blames_run: bool = True
    needs: Need | None = None


class Gates(list[Gate[Judge]]):
    """Gates in the order in which they judge."""

    def gate(
        self, *rigs: str, advice: str, blames_run: bool = True, needs: Need | None = None
    ) -> Callable[[Judge], Gate[Judge]]:
        """Make a function a gate under its own name, the last one so far.

        Args:
            rigs: Kinds of rig that it judges.
            advice: What to do about a refusal. May hold words of the rig in braces
                (`RigKind.words`).
            blames_run: See `Gate`.
            needs: What it cannot be applied without.
        """

        def add(judge: Judge) -> Gate[Judge]:
            self.append(Gate(judge.__name__, rigs, advice, judge, blames_run, needs))
            return self[-1]

        return add

    def of(self, rig: str) -> list[Gate[Judge]]:
        """The gates that judge a kind of rig."""
        return [gate for gate in self if rig in gate.rigs]
