"""A kind of rig as curation sees it: the small part in which traction and torque rigs differ."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import pandas as pd

from oilfilm.curation.gate import Channel, Columns, Fault, Finding, Limits, Run, Signals
from oilfilm.curation.hypotheses import Hypothesis
from oilfilm.logs.log_kind import LogKind
from oilfilm.settings.resolved import Settings
from oilfilm.units import BoolArray, FloatArray, IndexArray


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
    too_short: Sequence[Finding] = ()


class RigKind(Protocol):
    """A kind of rig. `TractionRig` and `TorqueRig` inherit from it.

    Attributes:
        name: As the gates name it.
        logs: How its logs are read.
        table: Name of its table of plateaus.
        sensor: The signal whose zero is removed and whose spikes are left out.
        load: The signal of the load.
        channels: The logged signals beside the sensor.
        means: Columns that are averaged over a plateau.
        errors: Those with a standard error.
        changes: Those whose second half is compared with the first.
        transients: Those whose beginning is compared with the rest.
        words: Its words in sentences and advice: sensor, level.
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
    means: tuple[str, ...]
    errors: tuple[str, ...]
    changes: tuple[str, ...]
    transients: tuple[str, ...]
    words: Mapping[str, str]
    carried: tuple[str, ...]
    keeps_refused_runs: bool
    shown_signals: Mapping[str, str]

    def signals(self, samples: Columns, rig: str, settings: Settings) -> Signals:
        """The signals of one run of a rig, in the senses that the gates take them."""
        ...

    def divide(self, signals: Signals, rig: str, settings: Settings) -> Division:
        """Rest and levels of a run."""
        ...

    def zero_fault(self, run: Run, parts: Division, rig: str, settings: Settings) -> Fault | None:
        """What is wrong with the zero, by all that the run shows of it.

        Args:
            run: As measured with the zero; its `flaw` is what was found before.
            parts: The phases that gave the zero.
            rig: Name of the rig.
            settings: Settings of the run.
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

    def complete(self, points: pd.DataFrame, settings: Settings) -> pd.DataFrame:
        """Plateaus of all runs with the columns that need rig and oil."""
        ...

    def hypotheses(self, rig: str, settings: Settings) -> Iterable[Hypothesis]:
        """Mistakes that a refused log of the rig may hold, the most frequent first."""
        return ()

    def limits(self, settings: Settings) -> Limits:
        """The limits of its gates and of its zero."""
        ...


def nothing(count: int) -> FloatArray:
    """As many values that are not known."""
    return np.full(count, np.nan)
