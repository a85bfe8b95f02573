"""The zero of a sensor: its output at rest, before and after a run.

A traction rig is at rest under pure rolling, a torque rig at standstill. A rig may give both
phases, the opening one alone, or a signal whose zero it has removed itself.

Decides: how the zero of the force or torque sensor is removed.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from oilfilm.curation import statistics
from oilfilm.curation.gate import Finding
from oilfilm.curation.signals import Signals
from oilfilm.units import FloatArray


@dataclass(frozen=True)
class ZeroReference:
    """Sensor output at rest at two times, one or none, with standard errors; in its unit."""

    time_s: FloatArray
    output: FloatArray
    output_se: FloatArray

    @property
    def drift(self) -> float:
        """Change of the zero from the first to the last phase."""
        return float(self.output[-1] - self.output[0]) if len(self.output) else 0.0

    def at(self, time_s: FloatArray) -> FloatArray:
        """The zero at any time: a straight line through two phases (the drift), else constant."""
        return self._weights(time_s) @ self.output

    def standard_error_at(self, time_s: FloatArray) -> FloatArray:
        """Standard error of `at`, from those of the means."""
        return np.sqrt(self._weights(time_s) ** 2 @ self.output_se**2)

    def _weights(self, time_s: FloatArray) -> FloatArray:
        """Share of each phase in the zero at each time, shape (times, phases)."""
        phases = len(self.time_s)
        if phases < 2 or self.time_s[0] == self.time_s[1]:
            return np.full((len(time_s), phases), 1 / max(phases, 1))
        share = (time_s - self.time_s[0]) / (self.time_s[1] - self.time_s[0])
        return np.stack([1 - share, share], axis=1)


def phase_too_short(
    signals: Signals, part: slice, name: str, min_duration_s: float
) -> Finding | None:
    """What is wrong with the length of a phase at rest, if anything.

    Args:
        signals: The run.
        part: The samples of the phase.
        name: The phase in words, as in `opening phase of standstill`.
        min_duration_s: Shortest phase that can be used.
    """
    rows = part.stop - part.start
    if rows <= 0:
        return Finding(f"the log has no {name}")
    duration_s = rows * signals.interval_s
    # a single row gives no standard error
    if duration_s >= min_duration_s and rows > 1:
        return None
    return Finding(
        f"{duration_s:.2f} s ({rows} rows) are left of the {name}; expected {min_duration_s:g} s "
        "or more, and two rows"
    )


def zero_reference(
    signals: Signals, sensor: str, phases: Mapping[str, slice], spike: float
) -> ZeroReference:
    """The zero from the phases at rest.

    Args:
        signals: The run.
        sensor: Column of the sensor.
        phases: Name of each phase -> its samples that are averaged; none where the rig has
            removed the zero itself.
        spike: Threshold of the spike test, in robust standard deviations.
    """
    values, inside = statistics.cut(
        np.stack([signals.time_s, signals[sensor]]),
        np.array([part.start for part in phases.values()], dtype=np.int64),
        np.array([part.stop for part in phases.values()], dtype=np.int64),
    )
    inside &= ~statistics.spikes(values[1], inside, spike)
    time_s, output = statistics.means(values, inside)
    return ZeroReference(time_s, output, statistics.standard_errors(values[1], inside, output))
