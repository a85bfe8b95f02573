"""What a gate is: one function that finds a fault, with its advice and the rigs that it judges.

A gate of runs looks at the signals of one run; a gate of plateaus looks at the plateaus of many
runs at once. `run_gates.py` and `plateau_gates.py` define them all in the order in which they
judge. A new gate is one function there.

Decides: which rigs a gate judges, and when it cannot be applied.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, TypeVar

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
        working: Those between the phases that give the zero at which the rig turns.
        plateaus: Its measured plateaus.
        sensor: The signal whose zero is removed: traction force or torque.
        load: The signal of the load.
        channels: The other logged signals, the load among them.
    """

    signals: Signals
    working: Signals
    plateaus: Columns
    sensor: Channel
    load: Channel
    channels: Sequence[Channel]


class Finding(NamedTuple):
    """What a gate found in a run: a sentence and the rows concerned, 0 where none is meant."""

    sentence: str
    first_row: int = 0
    last_row: int = 0


class Judgement(NamedTuple):
    """Which plateaus a gate refuses, and the sentence about them all."""

    fails: "pd.Series[bool] | BoolArray"
    sentence: str


@dataclass(frozen=True)
class Limits:
    """What the gates of every rig compare with; the drift of the zero in the sensor's unit."""

    signals: SignalGateSettings
    stuck: StuckSettings
    min_duration_s: float
    zero_min_duration_s: float
    zero_drift_max: float
    faulty_share_max: float


@dataclass(frozen=True)
class TractionLimits(Limits):
    """What the gates of traction rigs compare with."""

    gates: GateSettings
    transient_share: float
    rolling_slip_max: float
    planned_slips: Sequence[float]
    accept_unjudged_film: bool


@dataclass(frozen=True)
class TorqueLimits(Limits):
    """What the gates of torque rigs compare with."""

    gates: TorqueGateSettings
    standstill_rpm: float


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


def gate(
    *rigs: str, advice: str, blames_run: bool = True, needs: Need | None = None
) -> Callable[[Judge], Gate[Judge]]:
    """Make a function a gate under its own name.

    Args:
        rigs: Kinds of rig that it judges.
        advice: What to do about a refusal. May hold words of the rig in braces (`RigKind.words`).
        blames_run: See `Gate`.
        needs: What it cannot be applied without.
    """
    return lambda judge: Gate(judge.__name__, rigs, advice, judge, blames_run, needs)
