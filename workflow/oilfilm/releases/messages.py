"""Comparisons as text for a terminal."""

from oilfilm.errors import printable
from oilfilm.releases.compare import Comparison, Section

# Rows of a section that are printed.
_PRINTED_ROWS = 12


def comparison_text(comparison: Comparison) -> str:
    """A comparison as text; long tables are cut, with a note."""
    head = f"A {comparison.before.name}\nB {comparison.after.name}"
    texts = [
        section_text(section, _PRINTED_ROWS) for section in comparison.sections if section.rows
    ]
    return "\n\n".join([head, *(texts or ["no difference"])])


def section_text(section: Section, rows_max: int) -> str:
    """A section as an aligned table; control characters are escaped."""
    rows = section.rows[:rows_max]
    cells = [[printable(cell) for cell in row] for row in (section.columns, *rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = [
        "  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        for row in cells
    ]
    if left := len(section.rows) - len(rows):
        lines.append(f"  ... and {left} more; --html shows all")
    head = f"{section.title}: {len(section.rows)}"
    return "\n".join([head, *(line.rstrip() for line in lines)])
