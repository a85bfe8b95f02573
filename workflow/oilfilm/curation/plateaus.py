"""Where a signal is steady: steps of slip found from the measured slip itself."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.ndimage import maximum_filter1d

from oilfilm.curation.signals import FloatArray, IndexArray, sampling_interval

# The median absolute deviation of a normal distribution times this is its standard deviation.
MAD_TO_SIGMA = 1.4826


def find_steps(time_s: FloatArray, slip: FloatArray, settings: Mapping[str, Any]) -> IndexArray:
    """Indices at which the slip steps to another level.

    The means over a window before and after each instant are compared; a step lies where their
    difference peaks, above both `min_step` and `noise_factor` standard errors, the noise being
    judged from the differences of neighbouring samples.

    Args:
        time_s: Time, increasing, shape (n,).
        slip: Slide-roll ratio, shape (n,), finite.
        settings: `window_s`, `noise_factor` and `min_step` of config's plateaus.
    """
    window = max(round(settings["window_s"] / sampling_interval(time_s)), 2)
    if len(slip) < 2 * window:
        return np.array([], dtype=np.int64)
    total = np.concatenate([[0.0], np.cumsum(slip)])
    middle = np.arange(window, len(slip) - window + 1)
    after = total[middle + window] - total[middle]
    before = total[middle] - total[middle - window]
    change = np.abs(after - before) / window
    noise = MAD_TO_SIGMA * float(np.median(np.abs(np.diff(slip)))) / np.sqrt(2)
    limit = max(settings["min_step"], settings["noise_factor"] * noise * np.sqrt(2 / window))
    # two peaks within a window are one step seen twice through the noise: the higher one counts
    highest = maximum_filter1d(change, 2 * window + 1, mode="constant")
    peaks = np.flatnonzero((change == highest) & (change > limit))
    return middle[peaks[np.diff(peaks, prepend=-window - 1) > window]]


def settled_parts(
    time_s: FloatArray, steps: IndexArray, settings: Mapping[str, Any]
) -> tuple[IndexArray, IndexArray]:
    """First and past-the-last index of the steady part of each level between the steps.

    `settle_s` is cut off after each step and `guard_s` before the next one, because a step is
    located only to within the noise. The level before the first step has had no step to settle
    from. A level that ends before it has settled starts after its own stop.
    """
    interval = sampling_interval(time_s)
    settle, guard = round(settings["settle_s"] / interval), round(settings["guard_s"] / interval)
    starts = np.concatenate([[0], steps + settle])
    stops = np.concatenate([steps - guard, [len(time_s)]])
    return np.minimum(starts, len(time_s)), stops
