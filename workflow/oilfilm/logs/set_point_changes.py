"""Where the load or the speed of a log changes from one set point to another.

Decides: which rows of a log with several loads or speeds belong to one set point.
"""

from itertools import pairwise

import numpy as np

from oilfilm.base.units import FloatArray
from oilfilm.logs.base import IndexArray, LoggedRun

# Blocks of rows are compared by their medians: so many at most.
_MOST_BLOCKS = 300
# Blocks whose load and speed differ by less, relative, are at one level.
_SAME_LEVEL = 0.04
# Levels that differ by less, relative, are one set point that the rig did not hold.
_SMALLEST_CHANGE = 0.08
# A level is a run where its slip covers at least this share of the range of the log.
_SHARE_OF_SWEEP = 0.7
# At least this share of the rows of a run is at its level; the others are changes of load or speed.
_SHARE_AT_LEVEL = 0.8
_FEWEST_ROWS = 6


def rows_of_set_points(run: LoggedRun) -> list[IndexArray]:
    """The rows of each set point, as positions in the samples; one array where there is one.

    The rows are divided only where the slip is swept at each load and speed. A log whose speed
    follows the slip, or whose load is not held, has one set point.
    """
    count = len(run)
    everything = [np.arange(count)]
    if count < 2 * _FEWEST_ROWS:
        return everything
    load = run.samples["load_n"]
    ball, disc = run.samples["ball_speed_m_s"], run.samples["disc_speed_m_s"]
    with np.errstate(divide="ignore", invalid="ignore"):
        level = np.log(np.abs(np.stack([load, (ball + disc) / 2])))
        slip = 2 * (disc - ball) / (disc + ball)
    rows_per_block = max(1, -(-count // _MOST_BLOCKS))
    starts = np.arange(0, count, rows_per_block)
    medians = np.stack([_block_medians(signal, starts) for signal in (*level, slip)])
    bounds = _bounds_of_sweeps(medians[:2], medians[2])
    if len(bounds) < 3:
        return everything
    rows = [
        np.arange(starts[first], starts[last] if last < len(starts) else count)
        for first, last in pairwise(bounds)
    ]
    return rows if _are_set_points(level, rows) else everything


def _block_medians(signal: FloatArray, starts: IndexArray) -> FloatArray:
    """The median of each block of rows, shape (blocks,); NaN where no row has a number."""
    finite = np.where(np.isfinite(signal), signal, np.nan)
    blocks = np.split(finite, starts[1:])
    return np.array([np.nan if np.isnan(b).all() else np.nanmedian(b) for b in blocks])


def _bounds_of_sweeps(level: FloatArray, slip: FloatArray) -> list[int]:
    """First block of each stretch that sweeps the slip at one level, and the number of blocks.

    Args:
        level: Logarithms of load and speed of each block, shape (2, blocks).
        slip: Slip of each block, shape (blocks,).
    """
    count = len(slip)
    starts = [0]
    for block in range(1, count):
        known = level[:, starts[-1] : block]
        change = np.abs(level[:, block] - np.nanmedian(known, axis=1))
        if (change > _SAME_LEVEL).any():
            starts.append(block)
    whole_range = np.nanmax(slip) - np.nanmin(slip)
    sweeps: list[int] = []
    for first, last in pairwise([*starts, count]):
        of_level = slip[first:last]
        if np.isnan(of_level).all():
            continue
        if np.nanmax(of_level) - np.nanmin(of_level) >= _SHARE_OF_SWEEP * whole_range:
            sweeps.append(first)
    # what is above a sweep belongs to it, as the loading of the contact
    ends = [last for first, last in pairwise([*starts, count]) if first in sweeps]
    return [0, *ends[:-1], count] if sweeps else [0, count]


def _are_set_points(level: FloatArray, rows: list[IndexArray]) -> bool:
    """Whether each stretch of rows holds its level, and neighbours differ.

    Args:
        level: Logarithms of load and speed, shape (2, rows).
        rows: Rows of each stretch.
    """
    medians = [np.nanmedian(level[:, of_stretch], axis=1) for of_stretch in rows]
    for of_stretch, median in zip(rows, medians, strict=True):
        if len(of_stretch) < _FEWEST_ROWS:
            return False
        at_level = (np.abs(level[:, of_stretch].T - median) < _SAME_LEVEL).all(axis=1)
        if at_level.mean() < _SHARE_AT_LEVEL:
            return False
    return all(
        np.abs(later - earlier).max() >= np.log1p(_SMALLEST_CHANGE)
        for earlier, later in pairwise(medians)
    )
