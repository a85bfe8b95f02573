"""The zero of the traction sensor: its output under pure rolling, before and after a sweep."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from oilfilm.curation import statistics
from oilfilm.curation.signals import FloatArray, Signals


@dataclass(frozen=True)
class ZeroReference:
    """Sensor output under pure rolling at two times, with standard errors."""

    time_s: FloatArray
    force_n: FloatArray
    force_se_n: FloatArray

    @property
    def drift_n(self) -> float:
        """Change of the zero from the opening to the closing phase, in N."""
        return float(self.force_n[1] - self.force_n[0])

    def at(self, time_s: FloatArray) -> FloatArray:
        """The zero at any time: a straight line through the two (the drift)."""
        early, late = self.force_n
        return early + (late - early) * self._share(time_s)

    def standard_error_at(self, time_s: FloatArray) -> FloatArray:
        """Standard error of `at`, from those of the two means."""
        share = self._share(time_s)
        return np.hypot((1 - share) * self.force_se_n[0], share * self.force_se_n[1])

    def _share(self, time_s: FloatArray) -> FloatArray:
        return (time_s - self.time_s[0]) / (self.time_s[1] - self.time_s[0])


def zero_reference(
    signals: Signals, opening: slice, closing: slice, settings: Mapping[str, Any], spike: float
) -> ZeroReference | str:
    """The zero from the opening and the closing rolling phase, or a sentence why there is none.

    Args:
        signals: The run.
        opening: Samples of the opening phase that are averaged.
        closing: Samples of the closing phase.
        settings: `max_slide_roll_ratio` of config's zero_reference.
        spike: Threshold of the spike test, in robust standard deviations.
    """
    starts = np.array([opening.start, closing.start])
    stops = np.array([opening.stop, closing.stop])
    for name, start, stop in zip(("opening", "closing"), starts, stops, strict=True):
        if stop <= start:
            return f"the log has no {name} phase of pure rolling"
        slip = float(np.mean(signals.slide_roll_ratio[start:stop]))
        limit = settings["max_slide_roll_ratio"]
        if not abs(slip) <= limit:
            return (
                f"the {name} phase runs at a slide-roll ratio of {slip:.4f}; "
                f"expected pure rolling, within {limit}"
            )
    windows = statistics.Windows.between(starts, stops)
    force = signals.traction_force_n
    windows = windows.without(statistics.spikes(force, windows, spike))
    return ZeroReference(
        statistics.means(signals.time_s, windows),
        statistics.means(force, windows),
        statistics.standard_errors(force, windows),
    )
