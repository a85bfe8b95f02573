"""What the logs of one kind of rig may hold, and what is made of them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from oilfilm.logs.base import (
    NOTHING_UNDERSTOOD,
    Columns,
    Flaw,
    LoggedRun,
    Nominal,
    Refusal,
    Understood,
)
from oilfilm.settings import campaign as campaign_file
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.resolved import Settings
from oilfilm.units import Conversion

FloatArray = npt.NDArray[np.float64]
IndexArray = npt.NDArray[np.int64]
Renamed = Mapping[str, campaign_file.Column]


@dataclass(frozen=True)
class Vocabulary:
    """What the logs of one kind of rig may hold.

    Attributes:
        name: Kind of log, in a word.
        columns_key: Key of the campaign file that says which columns have names of their own.
        own_names: Column names that carry their unit -> quantity and unit.
        always: Quantities that every log must have.
        either: Sets of quantities of which one must be there; the first is what a log is asked for,
            what a log has of those after its own is compared with it.
        optional: Quantities that a log may have; where it does, every row needs them.
    """

    name: str
    columns_key: str
    own_names: Mapping[str, tuple[str, str]]
    always: tuple[str, ...]
    either: tuple[tuple[str, ...], ...]
    optional: tuple[str, ...] = ()

    @cached_property
    def quantities(self) -> Mapping[str, tuple[str, ...]]:
        """Quantity -> the units that can be used of it."""
        known = self.own_names.values()
        return {name: tuple(unit for each, unit in known if each == name) for name, _ in known}


@dataclass(frozen=True)
class Column:
    """Place of a quantity in a row and its conversion to the reader's unit.

    A `spare` column repeats what others give: it is compared, and no row needs it. `name` and
    `logged_unit` are those of the log.
    """

    quantity: str
    index: int
    to: Conversion
    name: str
    logged_unit: str
    spare: bool = False


def named_columns(columns: campaign_file.Columns | campaign_file.TorqueColumns) -> Renamed:
    """Quantity -> the column of that quantity, of those that the campaign file names."""
    return {quantity: column for quantity, column in columns if column is not None}


@dataclass(frozen=True)
class ContinuousLog:
    """The usable rows of a log whose header has no problem.

    Attributes:
        run_id: Unique name of the run.
        keys: Header keys.
        columns: As `find_columns` gave them.
        rows: Row numbers in the log, shape (n,).
        values: Quantity -> numbers in the units of `columns`, each of shape (n,).
        flaw: Why the run cannot be used, if so.
        understood: What its columns were taken for.
    """

    run_id: str
    keys: Mapping[str, str]
    columns: Sequence[Column]
    rows: IndexArray
    values: Mapping[str, FloatArray]
    flaw: Flaw | None = None
    understood: Understood = NOTHING_UNDERSTOOD

    def run(self, rig: str, nominal: Nominal, samples: Columns) -> LoggedRun:
        """The run of a rig that it makes."""
        oil, label = self.keys["oil"], self.keys.get("run", "")
        return LoggedRun(
            self.run_id,
            oil,
            rig,
            "continuous",
            nominal,
            samples,
            self.flaw,
            label,
            self.understood,
        )


@dataclass(frozen=True)
class LogKind:
    """A kind of log: formats find names, units, keys and numbers, and it makes a run of them.

    Attributes:
        vocabulary: What such logs may hold.
        renamed: Quantity -> `name` and `unit` of the columns with names of their own in a campaign.
        header_problem: Why a log with these header keys and columns cannot be used, if so.
        run: The run that a log makes.
        sheet_keys: Header keys that the run sheet may give beside the oil.
    """

    vocabulary: Vocabulary
    renamed: Callable[[Campaign], Renamed]
    header_problem: Callable[[Mapping[str, str], Sequence[Column], Settings], Refusal | None]
    run: Callable[[ContinuousLog, Settings], LoggedRun]
    sheet_keys: tuple[str, ...]
