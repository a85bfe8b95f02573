"""What a reader took a log for: its columns with their units and ranges."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import isfinite

import numpy as np

from oilfilm.units import Conversion, FloatArray


@dataclass(frozen=True)
class LogColumn:
    """A column of a log that is read.

    Attributes:
        name: As the log writes it.
        logged_unit: Its unit in the log.
        quantity: What it is taken for.
        unit: The unit in which it is read.
        minimum: Smallest number that it holds, in `unit`; NaN where there is none.
        maximum: Largest number.
        count: How many rows have a number.
        missing: How many have none.
    """

    name: str
    logged_unit: str
    quantity: str
    unit: str
    minimum: float = np.nan
    maximum: float = np.nan
    count: int = 0
    missing: int = 0

    def with_range(self, logged: FloatArray, to: Conversion) -> "LogColumn":
        """The same column with the range of its numbers.

        Args:
            logged: The numbers as logged, NaN where a cell holds none.
            to: Conversion to `unit`.
        """
        known = logged
        # a number that is not finite is, or hides, one of the extremes
        if len(logged) == 0 or not (isfinite(logged.min()) and isfinite(logged.max())):
            known = logged[np.isfinite(logged)]
        if len(known) == 0:
            return replace(self, missing=len(logged))
        ends = to.of(np.array([known.min(), known.max()]))
        return LogColumn(
            self.name,
            self.logged_unit,
            self.quantity,
            self.unit,
            minimum=float(ends.min()),
            maximum=float(ends.max()),
            count=len(known),
            missing=len(logged) - len(known),
        )


@dataclass(frozen=True)
class Understood:
    """What a run was taken for.

    Attributes:
        columns: The columns that are read.
        unused: The names of the others.
        sources: Where each header key comes from.
    """

    columns: Sequence[LogColumn] = ()
    unused: Sequence[str] = ()
    sources: Mapping[str, str] = field(default_factory=dict)

    def with_sources(self, sources: Mapping[str, str]) -> "Understood":
        """The same with the sources of its keys."""
        return replace(self, sources=sources)


NOTHING_UNDERSTOOD = Understood()
