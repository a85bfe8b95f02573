"""A kind of rig in curation: everything in which traction and torque rigs differ."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
import pandas as pd

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.curation.hypotheses import Hypothesis
from oilfilm.curation.statistics import median
from oilfilm.logs.base import ColumnArrays, Refusal
from oilfilm.logs.log_schema import LogSchema
from oilfilm.settings.config import (
    SignalGateSettings,
    StepSettings,
    StuckSettings,
    TareSettings,
    ZeroReferenceSettings,
)
from oilfilm.settings.resolved import Settings

TRACTION_KIND, TORQUE_KIND = "traction", "torque"
# No logger of a rig is faster. A shorter interval from damaged time stamps would give windows with
# a huge number of rows.
_SHORTEST_INTERVAL_S = 1e-6


@dataclass(frozen=True)
class _SelectedColumns(Mapping[str, FloatArray]):
    """Name of a column -> its selected samples, copied on access.

    Copies of all columns at once would be a second log in memory.
    """

    columns: Mapping[str, FloatArray]
    selection: BoolArray | slice

    def __getitem__(self, name: str) -> FloatArray:
        return self.columns[name][self.selection]

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns)


@dataclass(frozen=True)
class Signals:
    """The samples of one run.

    Attributes:
        row_numbers: Row number of each sample, shape (n,).
        time_s: Time of each sample, shape (n,).
        columns: Name of a column -> its signal, shape (n,).
    """

    row_numbers: IndexArray
    time_s: FloatArray
    columns: Mapping[str, FloatArray]

    @cached_property
    def interval_s(self) -> float:
        """Median time between samples, in s; 1 where there are too few to tell."""
        # rounded: differences of decimal time stamps have errors of floating point, which must not
        # decide how many rows a time is
        interval_s = float(f"{median(np.diff(self.time_s)):.9g}")
        return max(interval_s, _SHORTEST_INTERVAL_S) if interval_s > 0 else 1.0

    def select(self, selection: BoolArray | slice) -> "Signals":
        """The samples that a mask or a slice selects."""
        if not isinstance(selection, slice) and selection.all():
            return self
        return Signals(
            self.row_numbers[selection],
            self.time_s[selection],
            _SelectedColumns(self.columns, selection),
        )

    def row_range(self, first_index: int, last_index: int) -> dict[str, int]:
        """Row numbers `first` and `last` for a refusal, from the indices of two samples."""
        return {"first": self.row_numbers[first_index], "last": self.row_numbers[last_index]}

    def __getitem__(self, column: str) -> FloatArray:
        return self.columns[column]

    def __len__(self) -> int:
        return len(self.row_numbers)


class Channel(NamedTuple):
    """A logged signal.

    Attributes:
        column: Its column of samples.
        name: Its name in sentences.
        unit: Its unit in sentences.
    """

    column: str
    name: str
    unit: str


@dataclass(frozen=True)
class ForceLag:
    """Time by which the traction force of a ramp is logged behind the slip.

    Attributes:
        lag_s: The lag.
        lag_se_s: Its standard error.
        is_seen: Whether rising and falling slip show it. Else it may have any value in the range.
        tried_range_s: Smallest and largest lag that was tried.
    """

    lag_s: float
    lag_se_s: float
    is_seen: bool
    tried_range_s: tuple[float, float]


@dataclass(frozen=True)
class MeasuredRun:
    """A run with its plateaus, which the gates of runs judge.

    Attributes:
        rig_kind: The kind of rig, with its settings.
        signals: All samples of the run.
        running_signals: The samples at which the rig rotates: phases of pure rolling are among
            them, phases at standstill are not.
        plateaus: Columns over the plateaus. Tables are made of all runs at once, because a small
            table costs as much as a large one.
        refusal: What was found wrong while the run was measured, mostly with its zero; else None.
        short_level_refusals: Refusals of levels that ended before they settled and give no plateau.
        zero_phases: Names of the phases that gave the zero, in the order of time. On a ramp whose
            zero both directions of slip show, these words.
        force_lag: Lag of the force, where the slip is a continuous ramp; else None.
        is_settled: Whether each row is a settled reading, as of a rig whose program steps from one
            slip to the next. Else the log is a signal against time.
    """

    rig_kind: "RigKind"
    signals: Signals
    running_signals: Signals
    plateaus: ColumnArrays
    refusal: Refusal | None = None
    short_level_refusals: Sequence[Refusal] = ()
    zero_phases: tuple[str, ...] = ()
    force_lag: ForceLag | None = None
    is_settled: bool = False


@dataclass(frozen=True)
class Division:
    """The phases at rest of a run, which give the zero, and its levels, which give plateaus.

    Attributes:
        signals: The samples from which plateaus can be made.
        level_starts: Index of the first sample of the settled part of each level, in `signals`,
            shape (levels,).
        level_stops: Index after its last sample, shape (levels,).
        phase_signals: The samples from which the phases are sliced.
        phases: Name of a phase that gives the zero -> its slice of `phase_signals`, in the order of
            time.
        rest_in_words: What the rig does in the phases, in words.
        are_phases_in_levels: Whether the phases are parts of levels, as phases of pure rolling are.
            What remains of these levels gives plateaus.
        running_selection: Mask or slice of `signals`: the samples at which the rig rotates.
        short_level_refusals: Levels that ended before they settled and give no plateau.
    """

    signals: Signals
    level_starts: IndexArray
    level_stops: IndexArray
    phase_signals: Signals
    phases: Mapping[str, slice]
    rest_in_words: str = "standstill"
    are_phases_in_levels: bool = False
    running_selection: BoolArray | slice = field(default_factory=lambda: slice(None))
    short_level_refusals: Sequence[Refusal] = ()


class RigKind(Protocol):
    """A kind of rig with the settings of a run. `TractionRig` and `TorqueRig` inherit from it.

    Attributes:
        name: Name of the kind in `rules.yaml`.
        log_schema: The columns and keys of its logs.
        table_name: Name of its table of plateaus, as `tables` knows it.
        sensor: The signal whose zero is removed and whose spikes are left out.
        channels: The logged signals beside the sensor, the load first.
        mean_columns: Columns that are averaged over a plateau.
        columns_with_error: Columns with a standard error.
        columns_with_change: Columns whose second half is compared with the first.
        columns_with_transient: Columns whose beginning is compared with the rest.
        terms: Placeholder `sensor` or `level` in sentences and advice -> the rig's word for it.
        run_columns: Columns of the table of runs that every plateau gets.
        keeps_refused_runs: Whether the table has the plateaus of refused runs.
        shown_signals: Signals on the page of a refused run -> their labels.
        settings: Settings of the run.
        gate_limits: Limits of its gates.
        plateau_settings: Settings by which its levels are found.
        zero_settings: Settings of the phases at rest.
        zero_drift_max: Largest allowed change of the zero, in the sensor's unit.
        stuck_settings: Settings of stuck signals.
    """

    name: str
    log_schema: LogSchema
    table_name: str
    sensor: Channel
    channels: tuple[Channel, ...]
    mean_columns: tuple[str, ...]
    columns_with_error: tuple[str, ...]
    columns_with_change: tuple[str, ...]
    columns_with_transient: tuple[str, ...]
    terms: Mapping[str, str]
    run_columns: tuple[str, ...]
    keeps_refused_runs: bool
    shown_signals: Mapping[str, str]
    settings: Settings
    gate_limits: SignalGateSettings
    plateau_settings: StepSettings
    zero_settings: ZeroReferenceSettings | TareSettings
    zero_drift_max: float
    stuck_settings: StuckSettings

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.stuck_settings = settings.curation.stuck

    @staticmethod
    def make_signals(samples: ColumnArrays, rig_name: str, settings: Settings) -> Signals:
        """The signals of one run, with the signs that the gates expect.

        Args:
            samples: Samples of the run.
            rig_name: Name of the rig's file.
            settings: Settings of the run.
        """
        ...

    def divide_run(self, signals: Signals, rig_name: str) -> Division:
        """The phases at rest and the levels of a run."""
        ...

    def zero_refusal(self, run: MeasuredRun, division: Division, rig_name: str) -> Refusal | None:
        """The refusal by the zero, judged with the plateaus; None without one.

        Args:
            run: The run, measured with the zero. Its `refusal` is an earlier refusal.
            division: The phases that gave the zero.
            rig_name: Name of the rig's file.
        """
        return run.refusal

    def measured_ramp(
        self, run: MeasuredRun, division: Division, rig_name: str
    ) -> MeasuredRun | None:
        """The run measured as a continuous ramp; None where it is no ramp.

        Args:
            run: The run, measured by its levels.
            division: Its phases and levels.
            rig_name: Name of the rig's file.
        """
        return None

    def settled_readings_refusal(self, run: MeasuredRun) -> Refusal | None:
        """The refusal of readings that the rig is said to have settled; None without one.

        Args:
            run: The run, of which each row is a plateau.
        """
        return None

    def derive_plateaus(
        self, averages: ColumnArrays, zero_of_plateau: FloatArray, zero_of_plateau_se: FloatArray
    ) -> ColumnArrays:
        """Plateaus with the zero removed and the quantities that follow from a single plateau.

        Args:
            averages: Columns over the plateaus: `mean_columns`, and `<column>_se`,
                `<column>_change` and `<column>_transient` of `columns_with_error`,
                `columns_with_change` and `columns_with_transient`. Where each row is a settled
                reading, every signal.
            zero_of_plateau: The sensor's zero at each plateau, shape (plateaus,); NaN where there
                is none.
            zero_of_plateau_se: Its standard error, shape (plateaus,).
        """
        ...

    def with_rig_and_oil_columns(self, points: pd.DataFrame) -> pd.DataFrame:
        """Plateaus of all runs with the columns that follow from the files of rig and oil."""
        ...

    def hypotheses(self, rig_name: str) -> Iterable[Hypothesis]:
        """Hypotheses about a refused log of the rig, the most frequent mistake first."""
        ...


def unknown_values(value_count: int) -> FloatArray:
    """NaN in place of values that are not known, shape (value_count,)."""
    return np.full(value_count, np.nan)
