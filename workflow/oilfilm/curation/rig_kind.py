"""A kind of rig as curation sees it: the small part in which traction and torque rigs differ."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
import pandas as pd

from oilfilm.curation.hypotheses import Hypothesis
from oilfilm.curation.statistics import median
from oilfilm.logs.base import Columns, Refusal
from oilfilm.logs.log_kind import LogKind
from oilfilm.settings.config import (
    SignalGateSettings,
    StepSettings,
    StuckSettings,
    TareSettings,
    ZeroReferenceSettings,
)
from oilfilm.settings.resolved import Settings
from oilfilm.units import BoolArray, FloatArray, IndexArray

TRACTION, TORQUE = "traction", "torque"
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
        # time stamps are decimal numbers: their differences are, too, but for rounding, which must
        # not decide how many rows a time is
        usual = float(f"{median(np.diff(self.time_s)):.9g}")
        return max(usual, _SHORTEST_INTERVAL_S) if usual > 0 else 1.0

    def at(self, chosen: BoolArray | slice) -> "Signals":
        """The samples that a mask or a slice chooses."""
        if not isinstance(chosen, slice) and chosen.all():
            return self
        columns = {name: values[chosen] for name, values in self.columns.items()}
        return Signals(self.row[chosen], self.time_s[chosen], columns)

    def rows(self, first: int, last: int) -> dict[str, int]:
        """The rows that a refusal concerns, from the first sample to the last."""
        return {"first": self.row[first], "last": self.row[last]}

    def __getitem__(self, column: str) -> FloatArray:
        return self.columns[column]

    def __len__(self) -> int:
        return len(self.row)


class Channel(NamedTuple):
    """A signal as sentences name it."""

    column: str
    name: str
    unit: str


@dataclass(frozen=True)
class Run:
    """One measured run, as the gates of runs look at it.

    Attributes:
        rig: The rig.
        signals: All samples of the run.
        working: Those between the phases that give the zero at which the rig turns.
        plateaus: Columns over the plateaus. Tables are made of all runs at once, because a small
            table costs as much as a large one.
        flaw: Why the run gives no zero, where it gives none.
        too_short: Levels that give no plateau.
    """

    rig: "RigKind"
    signals: Signals
    working: Signals
    plateaus: Columns
    flaw: Refusal | None = None
    too_short: Sequence[Refusal] = ()


@dataclass(frozen=True)
class Division:
    """Where a run is at rest, which gives the zero, and where it holds a level.

    Attributes:
        signals: The samples from which plateaus can be made.
        starts: First sample of the settled part of each level, as an index into them.
        stops: The sample past its last one.
        at_rest: The samples that the phases are parts of.
        phases: The phases that give the zero, by name, in the order of time.
        words: What the rig does there.
        in_levels: Whether the phases are parts of levels, of which the rest gives plateaus.
        working: The samples between the phases at rest at which the rig turns.
        too_short: Levels that ended before they settled and give no plateau.
    """

    signals: Signals
    starts: IndexArray
    stops: IndexArray
    at_rest: Signals
    phases: Mapping[str, slice]
    words: str = "standstill"
    in_levels: bool = False
    working: BoolArray | slice = field(default_factory=lambda: slice(None))
    too_short: Sequence[Refusal] = ()


class RigKind(Protocol):
    """A kind of rig with the settings of a run. `TractionRig` and `TorqueRig` inherit from it.

    Attributes:
        name: As the gates name it.
        logs: How its logs are read.
        table: Name of its table of plateaus.
        sensor: The signal whose zero is removed and whose spikes are left out.
        channels: The logged signals beside the sensor, the load first.
        means: Columns that are averaged over a plateau.
        errors: Those with a standard error.
        changes: Those whose second half is compared with the first.
        transients: Those whose beginning is compared with the rest.
        words: Its words in sentences and advice: sensor, level.
        carried: Columns of the table of runs that every plateau carries.
        keeps_refused_runs: Whether the table has the plateaus of runs that were refused as a whole.
        shown_signals: Signals on the page of a refused run, with their labels.
        settings: Settings of the run.
        gates: The limits of its gates.
        plateaus: How its levels are found.
        zero: When it is at rest.
        zero_drift_max: Largest change of the zero, in the sensor's unit.
        stuck: When a signal is stuck.
    """

    name: str
    logs: LogKind
    table: str
    sensor: Channel
    channels: tuple[Channel, ...]
    means: tuple[str, ...]
    errors: tuple[str, ...]
    changes: tuple[str, ...]
    transients: tuple[str, ...]
    words: Mapping[str, str]
    carried: tuple[str, ...]
    keeps_refused_runs: bool
    shown_signals: Mapping[str, str]
    settings: Settings
    gates: SignalGateSettings
    plateaus: StepSettings
    zero: ZeroReferenceSettings | TareSettings
    zero_drift_max: float
    stuck: StuckSettings

    def __init__(self, settings: Settings) -> None:
        self.settings, self.stuck = settings, settings.curation.stuck

    @staticmethod
    def signals(samples: Columns, rig: str, settings: Settings) -> Signals:
        """The signals of one run of a rig file, in the senses that the gates take them."""
        ...

    def divide(self, signals: Signals, rig: str) -> Division:
        """Rest and levels of a run."""
        ...

    def zero_fault(self, run: Run, parts: Division, rig: str) -> Refusal | None:
        """What is wrong with the zero, by all that the run shows of it.

        Args:
            run: As measured with the zero; its `flaw` is what was found before.
            parts: The phases that gave the zero.
            rig: Name of the rig's file.
        """
        return run.flaw

    def derive(self, averages: Columns, zero: FloatArray, zero_se: FloatArray) -> Columns:
        """Plateaus with the zero removed and what follows from one plateau alone.

        Args:
            averages: `<column>`, and `<column>_se`, `_change`, `_transient` of those listed;
                every signal, where the rows of the log are settled readings.
            zero: The sensor's zero at each plateau; NaN where there is none.
            zero_se: Its standard error.
        """
        ...

    def complete(self, points: pd.DataFrame) -> pd.DataFrame:
        """Plateaus of all runs with the columns that need rig file and oil."""
        ...

    def hypotheses(self, rig: str) -> Iterable[Hypothesis]:
        """Mistakes that a refused log of the rig may hold, the most frequent first."""
        ...


def nothing(count: int) -> FloatArray:
    """As many values that are not known."""
    return np.full(count, np.nan)
