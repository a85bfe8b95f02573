"""The signals of one run, as arrays over its samples."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from oilfilm.settings.semantics import Semantics

FloatArray = npt.NDArray[np.float64]
IndexArray = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Signals:
    """One run's samples: every array has one value a sample, SI units."""

    row: IndexArray
    time_s: FloatArray
    load_n: FloatArray
    traction_force_n: FloatArray
    traction_force_1_n: FloatArray
    traction_force_2_n: FloatArray
    ball_speed_m_s: FloatArray
    disc_speed_m_s: FloatArray
    inlet_temperature_c: FloatArray
    measured_film_thickness_um: FloatArray
    direction: int = 1

    @classmethod
    def of(cls, samples: Mapping[str, npt.NDArray[Any]], log: Semantics) -> "Signals":
        """Signals of the samples of one run, force and slip positive with the slower body slowed.

        Args:
            samples: Columns of the table of samples, `SIGNALS` at least, over one run.
            log: How the rig's logs are meant.
        """
        arrays: dict[str, Any] = {name: samples[name] for name in SIGNALS}
        arrays["traction_force_n"] = log.traction_sign * log.direction * arrays["traction_force_n"]
        return cls(**arrays, direction=log.direction)

    @cached_property
    def interval_s(self) -> float:
        """Median time between samples, in s (see `sampling_interval`)."""
        return sampling_interval(self.time_s)

    @cached_property
    def entrainment_speed_m_s(self) -> FloatArray:
        """U = (U_ball + U_disc)/2."""
        return (self.ball_speed_m_s + self.disc_speed_m_s) / 2

    @cached_property
    def slide_roll_ratio(self) -> FloatArray:
        """S = (faster - slower speed)/U, the slower body being the one that the rig slows.

        NaN where nothing turns.
        """
        speed = self.entrainment_speed_m_s
        sliding = self.direction * (self.disc_speed_m_s - self.ball_speed_m_s)
        return np.divide(sliding, speed, out=np.full_like(speed, np.nan), where=speed != 0)

    def turning(self) -> "Signals":
        """The samples at which the rig turns; at the others S has no value."""
        kept = np.isfinite(self.slide_roll_ratio)
        if kept.all():
            return self
        return replace(self, **{name: getattr(self, name)[kept] for name in SIGNALS})

    def __len__(self) -> int:
        return len(self.row)


SIGNALS = tuple(field.name for field in fields(Signals) if field.name != "direction")

# No logger of a rig is faster; damaged time stamps are, and would ask for endless windows.
_SHORTEST_INTERVAL_S = 1e-6


def sampling_interval(time_s: FloatArray) -> float:
    """Median time between samples, in s; 1 where there are too few to tell."""
    intervals = np.diff(time_s)
    median = float(np.median(intervals)) if len(intervals) else 0.0
    return max(median, _SHORTEST_INTERVAL_S) if median > 0 else 1.0
