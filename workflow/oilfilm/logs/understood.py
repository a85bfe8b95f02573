"""What a reader took a log for: its columns with their units and ranges."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite
from typing import Self

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

    @classmethod
    def of(
        cls, name: str, logged_unit: str, quantity: str, to: Conversion, logged: FloatArray
    ) -> Self:
        """A column with the range of its numbers, given as logged, NaN where a cell holds none."""
        known = logged
        # a number that is not finite is, or hides, one of the extremes
        if len(logged) == 0 or not (isfinite(logged.min()) and isfinite(logged.max())):
            known = logged[np.isfinite(logged)]
        ends = to.of(np.array([known.min(), known.max()] if len(known) else [np.nan, np.nan]))
        least, most = float(ends.min()), float(ends.max())
        missing = len(logged) - len(known)
        return cls(name, logged_unit, quantity, to.unit, least, most, len(known), missing)


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


NOTHING_UNDERSTOOD = Understood()
