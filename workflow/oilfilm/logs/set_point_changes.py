"""Where the load or the speed of a log changes from one set point to another.

Decides: which rows of a log with several loads or speeds belong to one set point.
"""

from collections.abc import Iterable
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
    all_rows = np.arange(len(run))
    # in blocks: the signals of all rows of a long log are too large
    has_level = [
        np.isfinite(_signals(run, rows)).all(axis=0) for rows in _blocks(all_rows, _MOST_BLOCKS)
    ]
    # at standstill and without load there is no level
    usable_rows = np.flatnonzero(np.concatenate(has_level))
    if len(usable_rows) < 2 * _FEWEST_ROWS:
        return [all_rows]
    blocks = _blocks(usable_rows, _MOST_BLOCKS)
    medians = np.stack([np.median(_signals(run, rows), axis=1) for rows in blocks], axis=1)
    first_blocks = _first_blocks_of_sweeps(medians)
    first_rows = [blocks[block][0] for block in first_blocks[1:]]
    stretches = np.split(usable_rows, np.searchsorted(usable_rows, first_rows))
    if len(stretches) < 2 or not _are_set_points(_signals(run, rows)[:2] for rows in stretches):
        return [all_rows]
    return np.split(all_rows, first_rows)


def _blocks(rows: IndexArray, most: int) -> list[IndexArray]:
    """Rows in equal blocks, but for the last one; one empty block of no rows.

    Args:
        rows: The rows.
        most: Largest number of blocks.
    """
    rows_per_block = max(-(-len(rows) // most), 1)
    return np.split(rows, range(rows_per_block, len(rows), rows_per_block))


def _signals(run: LoggedRun, rows: IndexArray) -> FloatArray:
    """Logarithms of load and speed, and the slip, of some rows, shape (3, rows)."""
    load = run.samples["load_n"][rows]
    ball = run.samples["ball_speed_m_s"][rows]
    disc = run.samples["disc_speed_m_s"][rows]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.stack(
            [
                np.log(np.abs(load)),
                np.log(np.abs(ball + disc) / 2),
                2 * (disc - ball) / (disc + ball),
            ]
        )


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


def _are_set_points(stretches: Iterable[FloatArray]) -> bool:
    """Whether each stretch of rows holds its level, and neighbours differ.

    Args:
        stretches: Logarithms of load and speed in each stretch, shape (2, rows).
    """
    medians: list[FloatArray] = []
    for stretch in stretches:
        median = np.median(stretch, axis=1)
        medians.append(median)
        is_at_level = (np.abs(stretch - median[:, np.newaxis]) < _SAME_LEVEL).all(axis=0)
        if stretch.shape[1] < _FEWEST_ROWS or is_at_level.mean() < _SHARE_AT_LEVEL:
            return False
    return all(
        np.abs(later - earlier).max() >= np.log1p(_SMALLEST_CHANGE)
        for earlier, later in pairwise(medians)
    )
