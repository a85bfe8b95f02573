"""The zero of the traction sensor: its output under pure rolling, before and after a sweep.

A rig may give both phases, the opening one alone, or a force whose zero it has removed itself.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from oilfilm.curation import statistics
from oilfilm.curation.signals import FloatArray, Signals

# No rig that means to roll slides so much.
_ABSURD_SLIP = 0.5
# Phases of pure rolling that a zero procedure needs.
PHASES = {
    "rolling_phases": ("opening", "closing"),
    "opening_phase": ("opening",),
    "already_removed": (),
}


@dataclass(frozen=True)
class ZeroReference:
    """Sensor output under pure rolling at two times, one or none, with standard errors."""

    time_s: FloatArray
    force_n: FloatArray
    force_se_n: FloatArray

    @property
    def drift_n(self) -> float:
        """Change of the zero from the first to the last phase, in N."""
        return float(self.force_n[-1] - self.force_n[0]) if len(self.force_n) else 0.0

    def at(self, time_s: FloatArray) -> FloatArray:
        """The zero at any time: a straight line through two phases (the drift), else constant."""
        return self._weights(time_s) @ self.force_n

    def standard_error_at(self, time_s: FloatArray) -> FloatArray:
        """Standard error of `at`, from those of the means."""
        return np.sqrt(self._weights(time_s) ** 2 @ self.force_se_n**2)

    def _weights(self, time_s: FloatArray) -> FloatArray:
        """Share of each phase in the zero at each time, shape (times, phases)."""
        phases = len(self.time_s)
        if phases < 2 or self.time_s[0] == self.time_s[1]:
            return np.full((len(time_s), phases), 1 / max(phases, 1))
        share = (time_s - self.time_s[0]) / (self.time_s[1] - self.time_s[0])
        return np.stack([1 - share, share], axis=1)


def zero_reference(
    signals: Signals, phases: Mapping[str, slice], settings: Mapping[str, Any], spike: float
) -> ZeroReference | str:
    """The zero from phases of pure rolling, or a sentence why there is none.

    Args:
        signals: The run.
        phases: Name of each phase -> its samples that are averaged; none where the rig has
            removed the zero itself.
        settings: `max_slide_roll_ratio` and `min_duration_s` of config's zero_reference.
        spike: Threshold of the spike test, in robust standard deviations.
    """
    for name, part in phases.items():
        if part.stop <= part.start:
            return f"the log has no {name} phase of pure rolling"
        lasts_s = (part.stop - part.start) * signals.interval_s
        if lasts_s < settings["min_duration_s"]:
            return (
                f"{lasts_s:.2f} s are left of the {name} phase of pure rolling; expected "
                f"{settings['min_duration_s']:g} s or more"
            )
        slip = float(np.mean(signals.slide_roll_ratio[part]))
        limit = settings["max_slide_roll_ratio"]
        if not abs(slip) <= limit:
            hint = (
                "; so large a slip may come from swapped speed columns or wrong track radii"
                if abs(slip) > _ABSURD_SLIP
                else ""
            )
            return (
                f"the {name} phase runs at a slide-roll ratio of {slip:.4f}; "
                f"expected pure rolling, within {limit}{hint}"
            )
    values, inside = statistics.cut(
        np.stack([signals.time_s, signals.traction_force_n]),
        np.array([part.start for part in phases.values()], dtype=np.int64),
        np.array([part.stop for part in phases.values()], dtype=np.int64),
    )
    inside &= ~statistics.spikes(values[1], inside, spike)
    time_s, force_n = statistics.means(values, inside)
    return ZeroReference(time_s, force_n, statistics.standard_errors(values[1], inside))
