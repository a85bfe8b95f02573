"""Where a traction rig stands still, and what of its turning is no ramp beside a standstill.

Decides: where a rig stands still.
"""

import numpy as np

from oilfilm.curation.signals import Signals
from oilfilm.curation.statistics import BoolArray, quantile
from oilfilm.curation.zero import phase_too_short
from oilfilm.settings.config import CurationSettings
from oilfilm.units import FloatArray

# The speed of a run is that of its fastest rows, without the wild readings among them.
_FASTEST = 0.9


def stands_still(ball_m_s: FloatArray, disc_m_s: FloatArray, share: float) -> BoolArray:
    """Where both surfaces are slower than a share of the run's speed.

    Examples:
        >>> stands_still(np.array([0.0, 2.0, 2.0]), np.array([0.001, 2.0, 0.0]), 0.002)
        array([ True, False, False])
    """
    faster = np.maximum(np.abs(ball_m_s), np.abs(disc_m_s))
    known = faster[np.isfinite(faster)]
    run_m_s = quantile(known, _FASTEST) if len(known) else 0.0
    return np.asarray(faster <= share * run_m_s)


def ends(still: BoolArray) -> dict[str, slice]:
    """The samples before a rig first turns and those after it has last turned."""
    turning = np.flatnonzero(~still)
    first, last = (turning[0], turning[-1] + 1) if len(turning) else (0, len(still))
    return {"opening": slice(0, int(first)), "closing": slice(int(last), len(still))}


def phases_at_standstill(signals: Signals, settings: CurationSettings) -> dict[str, slice]:
    """The settled samples at standstill before a run, and those after it where they suffice."""
    guard = round(settings.plateaus.guard_s / signals.interval_s)
    settle = round(settings.plateaus.settle_s / signals.interval_s)
    both = ends(_still(signals, settings))
    opening, closing = both["opening"], both["closing"]
    phases = {"opening": slice(0, max(opening.stop - guard, 0))}
    after = slice(min(closing.start + settle, closing.stop), closing.stop)
    least_s = settings.zero_reference.min_duration_s
    if phase_too_short(signals, after, "closing phase", least_s) is None:
        phases["closing"] = after
    return phases


def turns_steadily(signals: Signals, settings: CurationSettings) -> BoolArray:
    """The samples at which a rig turns, without those of ramps out of and into standstill.

    A ramp ends where the speed is that of the window which follows; `settle_s` goes off after it
    and `guard_s` before the next one.
    """
    still = _still(signals, settings)
    kept = ~still
    if not still.any():
        return kept
    levels = settings.plateaus
    window = max(round(levels.window_s / signals.interval_s), 2)
    settle, guard = (round(t / signals.interval_s) for t in (levels.settle_s, levels.guard_s))
    speed, tolerance = signals["entrainment_speed_m_s"], settings.zero_reference.ramp_tolerance
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still, [0]]).astype(int)))
    for start, stop in edges.reshape(-1, 2):
        # within a run a reading or two of 0 are lost readings and no standstill
        if stop - start < window and 0 < start and stop < len(still):
            continue
        after = stop + _ramp(speed[stop:], window, tolerance) + settle
        before = start - _ramp(speed[:start][::-1], window, tolerance) - guard
        kept[max(before, 0) : after] = False
    return kept


def _still(signals: Signals, settings: CurationSettings) -> BoolArray:
    share = settings.zero_reference.standstill_share
    return stands_still(signals["ball_speed_m_s"], signals["disc_speed_m_s"], share)


def _ramp(speed: FloatArray, window: int, tolerance: float) -> int:
    """Samples until a speed is the mean of the window that it begins; all where it never is."""
    if len(speed) < window:
        return len(speed)
    total = np.concatenate([[0.0], np.cumsum(speed)])
    mean = (total[window:] - total[:-window]) / window
    steady = np.abs(speed[: len(mean)] - mean) <= tolerance * np.abs(mean)
    # zeros are steady, too: those of the next standstill are no end of this ramp
    steady &= mean != 0
    return int(np.argmax(steady)) if steady.any() else len(speed)
