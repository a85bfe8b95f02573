"""Docstrings as autodoc needs them: an indented equation of the description is a literal block."""

import re
from typing import Any

from sphinx.application import Sphinx

_SECTION = re.compile(r"(Args|Returns|Raises|Examples|Attributes|Validity|Reference)\b")


def mark_equations(
    app: Sphinx, what: str, name: str, thing: object, options: Any, lines: list[str]
) -> None:
    """Mark the indented blocks above the first section; Sphinx calls it with each docstring."""
    marked_lines: list[str] = []
    is_above_sections = True
    for line in lines:
        is_above_sections = is_above_sections and not _SECTION.match(line)
        follows_empty_line = bool(marked_lines) and not marked_lines[-1]
        is_block_start = line.startswith("    ") and follows_empty_line
        if is_above_sections and is_block_start and not _is_in_block(marked_lines):
            marked_lines += ["::", ""]
        marked_lines.append(line)
    lines[:] = marked_lines


def _is_in_block(lines: list[str]) -> bool:
    """Whether the last line with text is indented already."""
    return next((line for line in reversed(lines) if line), "").startswith("    ")


def setup(app: Sphinx) -> dict[str, bool]:
    """Sphinx calls it."""
    app.connect("autodoc-process-docstring", mark_equations, priority=400)  # before napoleon
    return {"parallel_read_safe": True, "parallel_write_safe": True}
