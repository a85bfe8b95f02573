"""What a gate is: one function that finds a fault, with its advice and the rigs that it judges.

A gate of runs looks at the signals of one run; a gate of plateaus looks at the plateaus of many
runs at once. `run_gates.py` and `plateau_gates.py` define them all in the order in which they
judge. A new gate is one function there.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from oilfilm.curation.signals import Signals
from oilfilm.settings.config import (
    GateSettings,
    SignalGateSettings,
    StuckSettings,
    TorqueGateSettings,
)
from oilfilm.units import FloatArray

BoolArray = npt.NDArray[np.bool_]

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


@dataclass(frozen=True)
class Run:
    """What a gate of runs looks at.

    Attributes:
        signals: All samples of the run.
        plateaus: Its measured plateaus.
        sensor: The signal whose zero is removed: traction force or torque.
        load: The signal of the load.
        working: The samples between the phases that give the zero.
    """

    signals: Signals
    plateaus: Columns
    sensor: Channel
    load: Channel
    working: slice

    def of(self, channel: Channel) -> FloatArray:
        """A signal while the rig works."""
        return self.signals[channel.column][self.working]


@dataclass(frozen=True)
class Finding:
    """What a gate found in a run: a sentence with its numbers, and the rows concerned.

    Rows are 0 where none in particular is meant. The sentence names its numbers in braces; the
    rows are among them as `first_row` and `last_row`.
    """

    sentence: str
    first_row: int = 0
    last_row: int = 0
    numbers: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Judgement:
    """Which plateaus a gate refuses, and the sentence about them with its numbers."""

    fails: "pd.Series[bool] | BoolArray"
    sentence: str
    numbers: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Limits:
    """What the gates of every rig compare with; the drift of the zero in the sensor's unit."""

    signals: SignalGateSettings
    stuck: StuckSettings
    min_duration_s: float
    zero_min_duration_s: float
    zero_drift_max: float


@dataclass(frozen=True)
class TractionLimits(Limits):
    """What the gates of traction rigs compare with."""

    gates: GateSettings
    transient_share: float
    planned_slips: Sequence[float]
    accept_unjudged_film: bool


@dataclass(frozen=True)
class TorqueLimits(Limits):
    """What the gates of torque rigs compare with."""

    gates: TorqueGateSettings
    standstill_rpm: float


# The limits are those of the rigs that the gate judges.
RunJudge = Callable[[Run, Any], Finding | None]
PlateauJudge = Callable[[pd.DataFrame, Any], Judgement]


@dataclass(frozen=True)
class Gate:
    """A check with its advice and the kinds of rig that it judges."""

    name: str
    rigs: tuple[str, ...]
    advice: str


@dataclass(frozen=True)
class RunGate(Gate):
    """A check of one run. `judge` gives None where the run passes."""

    judge: RunJudge


@dataclass(frozen=True)
class PlateauGate(Gate):
    """A check of plateaus, which carry the oil and the set points of their run.

    A gate whose quantity is null (no set point, no second half) does not refuse.
    """

    judge: PlateauJudge


def run_gate(*rigs: str, advice: str) -> Callable[[RunJudge], RunGate]:
    """Make a function a gate of runs, under its own name.

    Args:
        rigs: Kinds of rig that it judges.
        advice: What to do about a refusal. May hold words of the rig in braces (`RigKind.words`).
    """
    return lambda judge: RunGate(judge.__name__, rigs, advice, judge)


def plateau_gate(*rigs: str, advice: str) -> Callable[[PlateauJudge], PlateauGate]:
    """Make a function a gate of plateaus, as `run_gate` does for runs."""
    return lambda judge: PlateauGate(judge.__name__, rigs, advice, judge)
