"""Where a signal is steady: steps found from the measured signal itself.

Decides: where a log is steady, and how much of a plateau is used.
"""

import numpy as np
import scipy

from oilfilm.curation.statistics import MAD_TO_SIGMA, IndexArray, median
from oilfilm.settings.config import PlateauSettings, TorquePlateauSettings
from oilfilm.units import FloatArray

Levels = PlateauSettings | TorquePlateauSettings


def find_steps(
    level: FloatArray,
    interval_s: float,
    min_step: float,
    settings: Levels,
) -> IndexArray:
    """Indices at which a signal steps to another level.

    The means over a window before and after each instant are compared; a step is where their
    difference peaks, above both `min_step` and `noise_factor` standard errors, the noise being
    judged from the differences of neighbouring samples.

    Args:
        level: Slide-roll ratio or speed, shape (n,), finite.
        interval_s: Time between samples.
        min_step: Smallest step, in the unit of the signal.
        settings: `window_s` and `noise_factor` of config's plateaus.
    """
    window = max(round(settings.window_s / interval_s), 2)
    if len(level) < 2 * window:
        return np.array([], dtype=np.int64)
    total = np.concatenate([[0.0], np.cumsum(level)])
    sums = total[window:] - total[:-window]
    # the first difference is at the first sample with a full window before it
    change = np.abs(sums[window:] - sums[:-window]) / window
    noise = MAD_TO_SIGMA * median(np.abs(np.diff(level))) / np.sqrt(2)
    limit = max(min_step, settings.noise_factor * noise * np.sqrt(2 / window))
    # two peaks within a window are one step seen twice through the noise: the higher one counts
    highest = scipy.ndimage.maximum_filter1d(change, 2 * window + 1, mode="constant")
    peaks = np.flatnonzero((change == highest) & (change > limit))
    return window + peaks[np.diff(peaks, prepend=-window - 1) > window]


def settled_parts(
    samples: int,
    steps: IndexArray,
    interval_s: float,
    settings: Levels,
) -> tuple[IndexArray, IndexArray]:
    """First and past-the-last index of the steady part of each level between the steps.

    `settle_s` is cut off after each step and `guard_s` before the next one, because a step is
    located only to within the noise. The level before the first step has had no step to settle
    from. A level that ends before it has settled starts after its own stop.
    """
    settle = round(settings.settle_s / interval_s)
    guard = round(settings.guard_s / interval_s)
    starts = np.concatenate([[0], steps + settle])
    stops = np.concatenate([steps - guard, [samples]])
    return np.minimum(starts, samples), stops
