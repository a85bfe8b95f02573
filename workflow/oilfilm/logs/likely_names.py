"""Which line of a text seems to name columns, where no name is known.

Decides: the line that a message shows to the owner of a log with unknown names.
"""

import re
from collections.abc import Sequence

_DELIMITERS = ("\t", ";", "|", ",")
# So many rows of numbers in a row are a table.
_FEWEST_ROWS = 3
_FEWEST_CELLS = 3
_HAS_DIGIT = re.compile(r"\d")
_HAS_LETTERS = re.compile(r"[^\W\d_]{2}")


def likely_line_of_names(lines: Sequence[str]) -> tuple[int, str] | None:
    """Number, counted from 1, and text of the line above the first rows of numbers.

    A line of units between names and rows is passed over. None where there are no such rows.
    """
    for delimiter in _DELIMITERS:
        cells_of_lines = [_cells(line, delimiter) for line in lines]
        for first_row_index in range(1, len(lines) - _FEWEST_ROWS + 1):
            cell_count = len(cells_of_lines[first_row_index])
            first_rows = cells_of_lines[first_row_index : first_row_index + _FEWEST_ROWS]
            if cell_count < _FEWEST_CELLS or not all(
                _is_row(row, cell_count) for row in first_rows
            ):
                continue
            candidate_index = first_row_index - 1
            while (
                candidate_index > 0
                and len(cells_of_lines[candidate_index - 1]) == cell_count
                and not _is_row(cells_of_lines[candidate_index], cell_count)
            ):
                if _is_row(cells_of_lines[candidate_index - 1], cell_count):
                    break
                candidate_index -= 1
            if len(cells_of_lines[candidate_index]) == cell_count and not _is_row(
                cells_of_lines[candidate_index], cell_count
            ):
                return candidate_index + 1, lines[candidate_index]
            break
    return None


def _cells(line: str, delimiter: str) -> list[str]:
    return [cell.strip() for cell in line.rstrip("\r\n").split(delimiter)]


def _is_row(cells: Sequence[str], cell_count: int) -> bool:
    """Whether most cells are numbers or times: they have digits and no word."""
    if len(cells) != cell_count:
        return False
    number_cells = [
        cell for cell in cells if _HAS_DIGIT.search(cell) and not _HAS_LETTERS.search(cell)
    ]
    return len(number_cells) > cell_count / 2
