"""Tables as text, aligned for a terminal and for Markdown.

Decides: how a table looks as plain text, wherever the program writes one.
"""

import unicodedata
from collections.abc import Sequence

from oilfilm.base.errors import printable

# Texts of the cells of one row.
Row = Sequence[str]


def text_table(rows: Sequence[Row], *, right_aligned_count: int = 0, indent: str = "") -> list[str]:
    """Lines of a table without ruled lines; control characters in cells are escaped.

    Args:
        rows: Cells; each row has the same number of them.
        right_aligned_count: Number of columns at the end that are aligned to the right.
        indent: Text before each line.

    Examples:
        >>> rows = [["oil", "points"], ["4102", "70"]]
        >>> print(*text_table(rows, right_aligned_count=1), sep=chr(10))
        oil   points
        4102      70
    """
    return [
        f"{indent}{'  '.join(cells)}".rstrip() for cells in _padded_cells(rows, right_aligned_count)
    ]


def markdown_table(header: Row, rows: Sequence[Row]) -> list[str]:
    r"""Lines of a Markdown table with aligned columns; empty without rows.

    A bar in a cell is escaped, because a bar begins the next cell.

    Examples:
        >>> print(*markdown_table(["oil", "points"], [["4102", "70"]]), sep=chr(10))
        | oil  | points |
        |------|--------|
        | 4102 | 70     |
        >>> print(markdown_table(["oil"], [["A|B"]])[2])
        | A\|B |
    """
    if not rows:
        return []
    escaped_rows = [[cell.replace("|", r"\|") for cell in row] for row in [header, *rows]]
    padded_rows = _padded_cells(escaped_rows, right_aligned_count=0)
    lines = [f"| {' | '.join(cells)} |" for cells in padded_rows]
    separator = "|".join("-" * (width_of(cell) + 2) for cell in padded_rows[0])
    lines.insert(1, f"|{separator}|")
    return lines


def width_of(text: str) -> int:
    """Number of a terminal's columns that a text takes; a Chinese letter takes two.

    Examples:
        >>> width_of("oil"), width_of("\N{CJK UNIFIED IDEOGRAPH-6CB9}")
        (3, 2)
    """
    return sum(2 if unicodedata.east_asian_width(letter) in "WF" else 1 for letter in text)


def _padded_cells(rows: Sequence[Row], right_aligned_count: int) -> list[list[str]]:
    """Cells with blanks, so that all cells of a column have one width."""
    padded_rows = [[printable(cell) for cell in row] for row in rows]
    widths = [max(map(width_of, column)) for column in zip(*padded_rows, strict=True)]
    first_right_aligned_index = len(widths) - right_aligned_count
    for cells in padded_rows:
        for column_index, width in enumerate(widths):
            blanks = " " * (width - width_of(cells[column_index]))
            if column_index < first_right_aligned_index:
                cells[column_index] = cells[column_index] + blanks
            else:
                cells[column_index] = blanks + cells[column_index]
    return padded_rows
