"""Where the load or the speed of a log changes from one set point to another.

Decides: which rows of a log with several loads or speeds belong to one set point.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.logs.base import LoggedRun

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
    one_set_point = [np.arange(len(run))]
    load = run.samples["load_n"]
    ball, disc = run.samples["ball_speed_m_s"], run.samples["disc_speed_m_s"]
    with np.errstate(divide="ignore", invalid="ignore"):
        signals = np.stack(
            [
                np.log(np.abs(load)),
                np.log(np.abs(ball + disc) / 2),
                2 * (disc - ball) / (disc + ball),
            ]
        )
    # at standstill and without load there is no level
    usable_rows = np.flatnonzero(np.isfinite(signals).all(axis=0))
    if len(usable_rows) < 2 * _FEWEST_ROWS:
        return one_set_point
    signals = signals[:, usable_rows]
    rows_per_block = -(-len(usable_rows) // _MOST_BLOCKS)
    starts = np.arange(0, len(usable_rows), rows_per_block)
    signals_by_block = np.split(signals, starts[1:], axis=1)
    medians = np.stack([np.median(block, axis=1) for block in signals_by_block], axis=1)
    first_rows = starts[_first_blocks_of_sweeps(medians)]
    if len(first_rows) < 2 or not _are_set_points(np.split(signals[:2], first_rows[1:], axis=1)):
        return one_set_point
    return np.split(one_set_point[0], usable_rows[first_rows[1:]])


def _first_blocks_of_sweeps(medians: FloatArray) -> list[int]:
    """First block of each stretch that sweeps the slip at one level; the first one is 0.

    Args:
        medians: Logarithms of load and speed, and the slip, of each block, shape (3, blocks).
    """
    load_and_speed, slip = medians[:2], medians[2]
    block_count = len(slip)
    starts = [0]
    for block in range(1, block_count):
        level = np.median(load_and_speed[:, starts[-1] : block], axis=1)
        if (np.abs(load_and_speed[:, block] - level) > _SAME_LEVEL).any():
            starts.append(block)
    ends = [
        last
        for first, last in pairwise([*starts, block_count])
        if np.ptp(slip[first:last]) >= _SHARE_OF_SWEEP * np.ptp(slip)
    ]
    # what is above a sweep belongs to it, as the loading of the contact
    return [0, *ends[:-1]]


def _are_set_points(stretches: Sequence[FloatArray]) -> bool:
    """Whether each stretch of rows holds its level, and neighbours differ.

    Args:
        stretches: Logarithms of load and speed in each stretch, shape (2, rows).
    """
    medians = [np.median(stretch, axis=1) for stretch in stretches]
    for stretch, median in zip(stretches, medians, strict=True):
        is_at_level = (np.abs(stretch - median[:, np.newaxis]) < _SAME_LEVEL).all(axis=0)
        if stretch.shape[1] < _FEWEST_ROWS or is_at_level.mean() < _SHARE_AT_LEVEL:
            return False
    return all(
        np.abs(later - earlier).max() >= np.log1p(_SMALLEST_CHANGE)
        for earlier, later in pairwise(medians)
    )
