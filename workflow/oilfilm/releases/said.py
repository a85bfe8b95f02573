"""Comparisons in words, for a terminal."""

from oilfilm.releases.compare import Comparison, Section
from oilfilm.releases.manifest import shown

# Rows of a section that a terminal gets to see.
_ROWS = 12


def said(comparison: Comparison) -> str:
    """A comparison as text; long tables are cut and say so."""
    found = [section for section in comparison.sections if section.rows]
    head = f"A {comparison.before.name}\nB {comparison.after.name}"
    texts = [section_text(section, _ROWS) for section in found]
    return "\n\n".join([head, *(texts or ["no difference"])])


def section_text(section: Section, rows_max: int) -> str:
    """A section as an aligned table; content of a stranger's release cannot steer the terminal."""
    rows = section.rows[:rows_max]
    cells = [[shown(cell) for cell in row] for row in (section.columns, *rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = [
        "  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        for row in cells
    ]
    if left := len(section.rows) - len(rows):
        lines.append(f"  ... and {left} more; --html shows all")
    head = f"{section.title}: {len(section.rows)}"
    return "\n".join([head, *(line.rstrip() for line in lines)])
