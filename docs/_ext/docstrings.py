"""Docstrings as autodoc needs them: an indented equation of the description is a literal block."""

import re
from typing import Any

from sphinx.application import Sphinx

_SECTION = re.compile(r"(Args|Returns|Raises|Examples|Attributes|Validity|Reference)\b")


def literal(
    app: Sphinx, what: str, name: str, thing: object, options: Any, lines: list[str]
) -> None:
    """Mark the indented blocks above the first section."""
    done: list[str] = []
    head = True
    for line in lines:
        head = head and not _SECTION.match(line)
        begins = line.startswith("    ") and done and not done[-1]
        if head and begins and not _inside(done):
            done += ["::", ""]
        done.append(line)
    lines[:] = done


def _inside(lines: list[str]) -> bool:
    """Whether the last line with text is indented already."""
    return next((line for line in reversed(lines) if line), "").startswith("    ")


def setup(app: Sphinx) -> dict[str, bool]:
    """Sphinx calls it."""
    app.connect("autodoc-process-docstring", literal, priority=400)  # before napoleon
    return {"parallel_read_safe": True, "parallel_write_safe": True}
