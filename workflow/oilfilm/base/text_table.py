"""Tables as text, aligned for a terminal and for Markdown.

Decides: how a table looks as plain text, wherever the program writes one.
"""

import unicodedata
from collections.abc import Sequence

from oilfilm.base.errors import printable

Row = Sequence[str]


def text_table(rows: Sequence[Row], *, right: int = 0, indent: str = "") -> list[str]:
    """Lines of a table without rules; control characters in cells are escaped.

    Args:
        rows: Cells; each row has the same number of them.
        right: Number of columns at the end that are aligned to the right.
        indent: Text before each line.

    Examples:
        >>> print(*text_table([["oil", "points"], ["4102", "70"]], right=1), sep=chr(10))
        oil   points
        4102      70
    """
    return [f"{indent}{'  '.join(cells)}".rstrip() for cells in _padded(rows, right)]


def markdown_table(header: Row, rows: Sequence[Row]) -> list[str]:
    """Lines of a Markdown table with aligned columns; empty without rows.

    Examples:
        >>> print(*markdown_table(["oil", "points"], [["4102", "70"]]), sep=chr(10))
        | oil  | points |
        |------|--------|
        | 4102 | 70     |
    """
    if not rows:
        return []
    padded = _padded([header, *rows], right=0)
    lines = [f"| {' | '.join(cells)} |" for cells in padded]
    separator = "|".join("-" * (width_of(cell) + 2) for cell in padded[0])
    lines.insert(1, f"|{separator}|")
    return lines


def width_of(text: str) -> int:
    """Number of a terminal's columns that a text takes; a Chinese letter takes two.

    Examples:
        >>> width_of("oil"), width_of("\N{CJK UNIFIED IDEOGRAPH-6CB9}")
        (3, 2)
    """
    return sum(2 if unicodedata.east_asian_width(letter) in "WF" else 1 for letter in text)


def _padded(rows: Sequence[Row], right: int) -> list[list[str]]:
    """Cells with blanks, so that all cells of a column have one width."""
    padded_rows = [[printable(cell) for cell in row] for row in rows]
    widths = [max(map(width_of, column)) for column in zip(*padded_rows, strict=True)]
    first_right = len(widths) - right
    for cells in padded_rows:
        for column, width in enumerate(widths):
            blanks = " " * (width - width_of(cells[column]))
            if column < first_right:
                cells[column] = cells[column] + blanks
            else:
                cells[column] = blanks + cells[column]
    return padded_rows
