"""Which line of a text seems to name columns, where no name is known.

Decides: the line that a message shows to the owner of a log with unknown names.
"""

import re
from collections.abc import Sequence

from oilfilm.base.units import possible_conversion

_DELIMITERS = ("\t", ";", "|", ",")
# Fewest consecutive rows of numbers that count as a table.
_FEWEST_ROWS = 3
_FEWEST_CELLS = 3
_HAS_DIGIT = re.compile(r"\d")
_HAS_LETTERS = re.compile(r"[^\W\d_]{2}")
_BRACKETS = "[]() "
# Each usual unit of a log can be converted to one of these.
_UNITS = ("1", "N", "N m", "Pa", "m", "m/s", "s", "rpm", "degC", "V", "A", "W")


def likely_line_of_names(lines: Sequence[str]) -> tuple[int, str] | None:
    """Number, counted from 1, and text of the line above the first rows of numbers.

    A line of units between names and rows is passed over. None where there are no such rows.
    """
    for delimiter in _DELIMITERS:
        cells_of_lines = [_cells(line, delimiter) for line in lines]
        first_row_index = _index_of_first_row(cells_of_lines)
        if first_row_index is None:
            continue
        line_index = _index_of_names(cells_of_lines, first_row_index)
        if line_index is not None:
            return line_index + 1, lines[line_index]
    return None


def _index_of_first_row(cells_of_lines: Sequence[Sequence[str]]) -> int | None:
    """Index of the first row of the first table that has a line above it; None without one."""
    for row_index in range(1, len(cells_of_lines) - _FEWEST_ROWS + 1):
        cell_count = len(cells_of_lines[row_index])
        first_rows = cells_of_lines[row_index : row_index + _FEWEST_ROWS]
        if cell_count >= _FEWEST_CELLS and all(
            _is_row_of_numbers(row, cell_count) for row in first_rows
        ):
            return row_index
    return None


def _index_of_names(cells_of_lines: Sequence[Sequence[str]], first_row_index: int) -> int | None:
    """Index of the line of names above the first row of numbers; None where none is likely.

    Lines with few filled cells are passed over: a sheet fills its title and its notes with them.
    """
    cell_count = len(cells_of_lines[first_row_index])
    line_of_units: int | None = None
    for line_index in range(first_row_index - 1, -1, -1):
        cells = cells_of_lines[line_index]
        if len(cells) != cell_count or _is_row_of_numbers(cells, cell_count):
            break
        if sum(map(bool, cells)) <= cell_count / 2:
            continue
        if line_of_units is not None or not is_line_of_units(cells):
            return line_index
        line_of_units = line_index
    return line_of_units


def _cells(line: str, delimiter: str) -> list[str]:
    return [cell.strip() for cell in line.rstrip("\r\n").split(delimiter)]


def is_line_of_units(cells: Sequence[str]) -> bool:
    """Whether most filled cells are units, with or without brackets."""
    filled_cells = [cell for cell in cells if cell]
    unit_cells = [
        cell for cell in filled_cells if possible_conversion(cell.strip(_BRACKETS), _UNITS)
    ]
    return len(unit_cells) > len(filled_cells) / 2


def _is_row_of_numbers(cells: Sequence[str], cell_count: int) -> bool:
    """Whether most cells are numbers or times: they have digits and no word."""
    if len(cells) != cell_count:
        return False
    number_cells = [
        cell for cell in cells if _HAS_DIGIT.search(cell) and not _HAS_LETTERS.search(cell)
    ]
    return len(number_cells) > cell_count / 2
