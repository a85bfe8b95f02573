"""Where the load or the speed of a log changes from one set point to another.

Decides: which rows of a log with several loads or speeds belong to one set point.
"""

from bisect import insort
from collections.abc import Iterable
from itertools import pairwise
from math import ceil
from statistics import median

import numpy as np

from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.logs.base import LoggedRun

# Rows are compared in blocks, by the medians of these: so many blocks at most.
_MOST_BLOCKS = 300
# Rows whose signals are computed at once: those of all rows of a long log are too large.
_ROWS_AT_ONCE = 50_000
# Blocks whose load and speed differ by less, relative, are at one level.
_LARGEST_LEVEL_DIFFERENCE = 0.04
# Levels that differ by less, relative, are one set point that the rig did not hold.
_SMALLEST_CHANGE = 0.08
# A level is a run where its slip covers at least this share of the range of the log.
_SHARE_OF_SWEEP = 0.7
# At least this share of the rows of a run is at its level; the others are changes of load or speed.
_SHARE_AT_LEVEL = 0.8
_FEWEST_ROWS = 6


def row_indices_of_set_points(run: LoggedRun) -> list[IndexArray]:
    """Indices of the samples of each set point; one array where a run has one set point.

    The rows are divided only where the slip is swept at each load and speed. A log whose speed
    follows the slip, or whose load is not held, has one set point.
    """
    all_rows = np.arange(len(run))
    has_level = np.concatenate(
        [
            np.isfinite(_level_signals(run, row_indices)).all(axis=0)
            for row_indices in _parts(all_rows, _ROWS_AT_ONCE)
        ]
    )
    # at standstill and without load there is no level
    usable_indices = np.flatnonzero(has_level)
    if len(usable_indices) < 2 * _FEWEST_ROWS:
        return [all_rows]
    rows_per_block = ceil(len(usable_indices) / _MOST_BLOCKS)
    blocks = _parts(usable_indices, rows_per_block)
    medians = _medians_of_blocks(run, usable_indices, rows_per_block)
    first_blocks = _first_block_of_each_sweep(medians)
    first_rows_of_sweeps = [
        _row_of_change(run, blocks[block_index - 1], blocks[block_index])
        for block_index in first_blocks[1:]
    ]
    indices_of_stretches = np.split(
        usable_indices, np.searchsorted(usable_indices, first_rows_of_sweeps)
    )
    if len(indices_of_stretches) < 2 or not _are_set_points(
        _level_signals(run, row_indices)[:2] for row_indices in indices_of_stretches
    ):
        return [all_rows]
    return np.split(all_rows, first_rows_of_sweeps)


def _parts(row_indices: IndexArray, rows_per_part: int) -> list[IndexArray]:
    """Indices of rows in parts of equal length, the last one perhaps shorter.

    Args:
        row_indices: Indices of the rows; without any there is one empty part.
        rows_per_part: Number of rows of each part but the last one.
    """
    return np.split(row_indices, range(rows_per_part, len(row_indices), rows_per_part))


def _medians_of_blocks(run: LoggedRun, row_indices: IndexArray, rows_per_block: int) -> FloatArray:
    """Medians of the signals of each block of rows, shape (3, blocks).

    Args:
        run: The run.
        row_indices: Indices of the rows.
        rows_per_block: Number of rows of each block but the last one.
    """
    blocks_at_once = ceil(_ROWS_AT_ONCE / rows_per_block)
    medians = []
    for rows in _parts(row_indices, blocks_at_once * rows_per_block):
        signals = _level_signals(run, rows)
        rows_in_full_blocks = len(rows) - len(rows) % rows_per_block
        full_blocks = signals[:, :rows_in_full_blocks].reshape(3, -1, rows_per_block)
        medians.append(np.median(full_blocks, axis=2))
        if rows_in_full_blocks < len(rows):
            last_block = signals[:, rows_in_full_blocks:]
            medians.append(np.median(last_block, axis=1, keepdims=True))
    return np.concatenate(medians, axis=1)


def _level_signals(run: LoggedRun, row_indices: IndexArray) -> FloatArray:
    """Logarithms of load and speed, and the slip, of some rows, shape (3, rows)."""
    load_n = run.samples["load_n"][row_indices]
    ball_m_s = run.samples["ball_speed_m_s"][row_indices]
    disc_m_s = run.samples["disc_speed_m_s"][row_indices]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.stack(
            [
                np.log(np.abs(load_n)),
                np.log(np.abs(ball_m_s + disc_m_s) / 2),
                2 * (disc_m_s - ball_m_s) / (disc_m_s + ball_m_s),
            ]
        )


def _row_of_change(run: LoggedRun, earlier_block: IndexArray, later_block: IndexArray) -> int:
    """The row at which load or speed changes from the median of a block to that of the next one.

    It is between the middles of both blocks.

    Args:
        run: The run.
        earlier_block: Indices of the rows of the last block at the earlier level.
        later_block: Indices of the rows of the first block at the later level.
    """
    earlier_signals = _level_signals(run, earlier_block)[:2]
    later_signals = _level_signals(run, later_block)[:2]
    earlier_level = np.median(earlier_signals, axis=1, keepdims=True)
    later_level = np.median(later_signals, axis=1, keepdims=True)
    earlier_middle, later_middle = len(earlier_block) // 2 + 1, len(later_block) // 2 + 1
    row_indices = np.concatenate([earlier_block[earlier_middle:], later_block[:later_middle]])
    signals = np.concatenate(
        [earlier_signals[:, earlier_middle:], later_signals[:, :later_middle]], axis=1
    )
    # negative in rows that are nearer to the earlier level
    excess_distance = np.abs(signals - earlier_level) - np.abs(signals - later_level)
    # sum over all rows above each row: least where all of them, and no others, are at that level
    excess_above = np.concatenate([[0.0], np.cumsum(excess_distance.sum(axis=0))])
    return int(row_indices[np.argmin(excess_above[:-1])])


def _first_block_of_each_sweep(medians: FloatArray) -> list[int]:
    """First block of each stretch that sweeps the slip at one level; the first one is 0.

    Args:
        medians: Logarithms of load and speed, and the slip, of each block, shape (3, blocks).
    """
    slip = medians[2]
    block_count = len(slip)
    # of the stretch so far; a median of sorted numbers is quickly taken
    sorted_loads: list[float] = []
    sorted_speeds: list[float] = []
    start_blocks = [0]
    for block_index, (load, speed) in enumerate(medians[:2].T.tolist()):
        is_at_other_level = block_index > 0 and (
            abs(load - median(sorted_loads)) > _LARGEST_LEVEL_DIFFERENCE
            or abs(speed - median(sorted_speeds)) > _LARGEST_LEVEL_DIFFERENCE
        )
        if is_at_other_level:
            start_blocks.append(block_index)
            sorted_loads.clear()
            sorted_speeds.clear()
        insort(sorted_loads, load)
        insort(sorted_speeds, speed)
    stop_blocks = [
        stop_block
        for start_block, stop_block in pairwise([*start_blocks, block_count])
        if np.ptp(slip[start_block:stop_block]) >= _SHARE_OF_SWEEP * np.ptp(slip)
    ]
    # what is above a sweep belongs to it, as the loading of the contact
    return [0, *stop_blocks[:-1]]


def _are_set_points(stretches: Iterable[FloatArray]) -> bool:
    """Whether each stretch of rows holds its level, and neighbours differ.

    Args:
        stretches: Logarithms of load and speed in each stretch, shape (2, rows).
    """
    levels: list[FloatArray] = []
    for stretch in stretches:
        level = np.median(stretch, axis=1)
        levels.append(level)
        is_at_level = (np.abs(stretch - level[:, np.newaxis]) < _LARGEST_LEVEL_DIFFERENCE).all(
            axis=0
        )
        if stretch.shape[1] < _FEWEST_ROWS or is_at_level.mean() < _SHARE_AT_LEVEL:
            return False
    return all(
        np.abs(later - earlier).max() >= np.log1p(_SMALLEST_CHANGE)
        for earlier, later in pairwise(levels)
    )
