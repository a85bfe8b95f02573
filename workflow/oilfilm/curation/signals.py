"""The signals of one run, as arrays over its samples."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from oilfilm.curation.statistics import BoolArray, IndexArray, median
from oilfilm.units import FloatArray

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
        usual = median(np.diff(self.time_s))
        return max(usual, _SHORTEST_INTERVAL_S) if usual > 0 else 1.0

    def where(self, kept: BoolArray) -> "Signals":
        """The samples that a mask keeps."""
        if kept.all():
            return self
        return self.at(kept)

    def at(self, chosen: BoolArray | slice) -> "Signals":
        """The samples that a mask or a slice chooses."""
        columns = {name: values[chosen] for name, values in self.columns.items()}
        return Signals(self.row[chosen], self.time_s[chosen], columns)

    def __getitem__(self, column: str) -> FloatArray:
        return self.columns[column]

    def __len__(self) -> int:
        return len(self.row)
