"""Comparisons as text for a terminal."""

from oilfilm.releases.compare import Comparison, Section
from oilfilm.text_table import text_table

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
    lines = text_table([section.columns, *rows], indent="  ")
    if left := len(section.rows) - len(rows):
        lines.append(f"  ... and {left} more; --html shows all")
    head = f"{section.title}: {len(section.rows)}"
    return "\n".join([head, *lines])
