"""Tables as text, aligned for a terminal and for Markdown.

Decides: how a table looks as plain text, wherever the program writes one.
"""

import unicodedata
from collections.abc import Sequence

from oilfilm.errors import printable

Row = Sequence[str]


def text_table(rows: Sequence[Row], *, right: int = 0, indent: str = "") -> list[str]:
    """Lines of a table without rules; control characters in cells are escaped.

    Args:
        rows: Cells, each row with as many.
        right: So many of the last columns are aligned to the right.
        indent: Before each line.

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
    head, *body = _padded([header, *rows], right=0)
    lines = [f"| {' | '.join(cells)} |" for cells in (head, *body)]
    return [lines[0], f"|{'|'.join('-' * (width_of(cell) + 2) for cell in head)}|", *lines[1:]]


def width_of(text: str) -> int:
    """Columns of a terminal that a text takes: Chinese letters take two.

    Examples:
        >>> width_of("oil"), width_of("\N{CJK UNIFIED IDEOGRAPH-6CB9}")
        (3, 2)
    """
    return sum(2 if unicodedata.east_asian_width(letter) in "WF" else 1 for letter in text)


def _padded(rows: Sequence[Row], right: int) -> list[list[str]]:
    cells = [[printable(cell) for cell in row] for row in rows]
    widths = [max(map(width_of, column)) for column in zip(*cells, strict=True)]
    left = len(cells[0]) - right

    def padded(index: int, cell: str) -> str:
        blanks = " " * (widths[index] - width_of(cell))
        return cell + blanks if index < left else blanks + cell

    return [[padded(*each) for each in enumerate(row)] for row in cells]
