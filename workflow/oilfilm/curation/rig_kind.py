"""A kind of rig as curation sees it: the small part in which traction and torque rigs differ."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import pandas as pd

from oilfilm.curation.gate import BoolArray, Channel, Columns, Finding, Limits
from oilfilm.curation.hypotheses import Hypothesis
from oilfilm.curation.signals import IndexArray, Signals
from oilfilm.curation.zero import ZeroReference
from oilfilm.logs.log_kind import LogKind
from oilfilm.settings.resolved import Settings
from oilfilm.units import FloatArray


@dataclass(frozen=True)
class Division:
    """Where a run is at rest and where it holds a level, as indices into its signals.

    Attributes:
        rest: The phases that give the zero, by name, in the order of time.
        starts: First sample of the settled part of each level.
        stops: The sample past its last one.
        working: The samples between the phases at rest at which the rig turns.
        too_short: Levels that ended before they settled and give no plateau.
    """

    rest: Mapping[str, slice]
    starts: IndexArray
    stops: IndexArray
    working: BoolArray | slice
    too_short: list[Finding] = field(default_factory=list)


@dataclass(frozen=True)
class Averaging:
    """What is made of each signal over a plateau, beside its mean.

    Attributes:
        means: Columns that are averaged.
        errors: Those with a standard error.
        changes: Those whose second half is compared with the first.
        transients: Those whose beginning is compared with the rest.
    """

    means: tuple[str, ...]
    errors: tuple[str, ...]
    changes: tuple[str, ...]
    transients: tuple[str, ...] = ()


class RigKind(Protocol):
    """A kind of rig. `TractionRig` and `TorqueRig` inherit from it.

    Attributes:
        name: As the gates name it.
        logs: How its logs are read.
        table: Name of its table of plateaus.
        sensor: The signal whose zero is removed and whose spikes are left out.
        load: The signal of the load.
        channels: The logged signals beside the sensor.
        averaging: What is made of each signal over a plateau.
        words: Its words in sentences and advice: sensor, level, rest.
        advice: What to do about a refusal by a rule that is no gate.
        carried: Columns of the table of runs that every plateau carries.
        keeps_refused_runs: Whether the table has the plateaus of runs that were refused as a whole.
        shown_signals: Signals on the page of a refused run, with their labels.
    """

    name: str
    logs: LogKind
    table: str
    sensor: Channel
    load: Channel
    channels: tuple[Channel, ...]
    averaging: Averaging
    words: Mapping[str, str]
    advice: Mapping[str, str]
    carried: tuple[str, ...]
    keeps_refused_runs: bool
    shown_signals: Mapping[str, str]

    def signals(self, samples: Columns, rig: str, settings: Settings) -> Signals:
        """The signals of one run of a rig, in the senses that the gates take them."""
        ...

    def usable(self, signals: Signals, settings: Settings) -> Signals:
        """The samples from which plateaus can be made: all of them, where a rig has no reason."""
        return signals

    def divide(self, signals: Signals, rig: str, settings: Settings) -> Division:
        """Rest and levels of a run."""
        ...

    def phase_problem(
        self, signals: Signals, part: slice, name: str, settings: Settings
    ) -> Finding | None:
        """Why a phase that is long enough gives no zero, if a rig has such a reason."""
        return None

    def standstill(self, signals: Signals, settings: Settings) -> Mapping[str, slice]:
        """Opening and closing standstill of all samples, where a rig's zero is taken elsewhere."""
        return {}

    def zero_at_standstill(self, rig: str, settings: Settings) -> bool:
        """Whether the phases of `standstill` give the zero, and not those of `divide`."""
        return False

    def zero_fault(
        self, rest: Mapping[str, Signals], plateaus: Columns, rig: str, settings: Settings
    ) -> tuple[str, Finding] | None:
        """Rule and finding where phases give a zero that the plateaus contradict.

        Args:
            rest: The phases that gave the zero.
            plateaus: As derived with it.
            rig: Name of the rig.
            settings: Settings of the run.
        """
        return None

    def standstill_fault(
        self, still: Mapping[str, ZeroReference], rig: str, settings: Settings
    ) -> tuple[str, Finding] | None:
        """Rule and finding where the readings at standstill contradict the source of the zero."""
        return None

    def standstill_hint(
        self, still: Mapping[str, ZeroReference], rig: str, settings: Settings
    ) -> str:
        """What to write so that the readings at standstill give the zero."""
        return ""

    def derive(self, averages: Columns, zero: FloatArray, zero_se: FloatArray) -> Columns:
        """Plateaus with the zero removed and what follows from one plateau alone.

        Args:
            averages: `<column>`, and `<column>_se`, `_change` and `_transient` as `averaging` says;
                every signal, where the rows of the log are settled readings.
            zero: The sensor's zero at each plateau; NaN where there is none.
            zero_se: Its standard error.
        """
        ...

    def complete(self, points: pd.DataFrame, settings: Settings) -> pd.DataFrame:
        """Plateaus of all runs with the columns that need rig and oil."""
        ...

    def hypotheses(self, rig: str, settings: Settings) -> Iterable[Hypothesis]:
        """Mistakes that a refused log of the rig may hold, the most frequent first."""
        return ()

    def limits(self, settings: Settings) -> Limits:
        """The limits of its gates and of its zero."""
        ...

    def repeats(self, settings: Settings) -> tuple[str, ...]:
        """Rules of `repeats.py` that refuse a run which an earlier one repeats."""
        ...


def nothing(count: int) -> FloatArray:
    """As many values that are not known."""
    return np.full(count, np.nan)
