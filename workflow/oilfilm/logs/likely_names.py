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


def likely_names(lines: Sequence[str]) -> tuple[int, str] | None:
    """The number from 1 and the text of the line above the first rows of numbers.

    A line of units between names and rows is passed over. None where there are no such rows.
    """
    for delimiter in _DELIMITERS:
        cells_by_line = [_cells(line, delimiter) for line in lines]
        for first_row in range(1, len(lines) - _FEWEST_ROWS + 1):
            width = len(cells_by_line[first_row])
            rows = cells_by_line[first_row : first_row + _FEWEST_ROWS]
            if width < _FEWEST_CELLS or not all(_is_row(row, width) for row in rows):
                continue
            candidate = first_row - 1
            while (
                candidate > 0
                and len(cells_by_line[candidate - 1]) == width
                and not _is_row(cells_by_line[candidate], width)
            ):
                if _is_row(cells_by_line[candidate - 1], width):
                    break
                candidate -= 1
            if len(cells_by_line[candidate]) == width and not _is_row(
                cells_by_line[candidate], width
            ):
                return candidate + 1, lines[candidate]
            break
    return None


def _cells(line: str, delimiter: str) -> list[str]:
    return [cell.strip() for cell in line.rstrip("\r\n").split(delimiter)]


def _is_row(cells: Sequence[str], width: int) -> bool:
    """Whether most cells are numbers or times: they have digits and no word."""
    if len(cells) != width:
        return False
    numbers = [cell for cell in cells if _HAS_DIGIT.search(cell) and not _HAS_LETTERS.search(cell)]
    return len(numbers) > width / 2
