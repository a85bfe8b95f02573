"""Headed sections, aligned tables and sentences of a plain text such as the summary."""

from collections.abc import Sequence

import numpy as np
import pandas as pd


def section(title: str, *blocks: Sequence[str]) -> list[str]:
    """A heading and the blocks that are not empty, with an empty line after each block."""
    lines = [title, "-" * len(title)]
    for block in filter(None, blocks):
        lines += [*block, ""]
    return lines


def text_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Lines of a table with aligned columns, which is Markdown too; empty without rows.

    Examples:
        >>> print(*text_table(["oil", "points"], [["4102", "70"]]), sep=chr(10))
        | oil  | points |
        |------|--------|
        | 4102 | 70     |
    """
    if not rows:
        return []
    widths = [max(map(len, column)) for column in zip(header, *rows, strict=True)]
    head, *body = (
        "| " + " | ".join(map(str.ljust, cells, widths)) + " |" for cells in (header, *rows)
    )
    return [head, "|" + "|".join("-" * (width + 2) for width in widths) + "|", *body]


def sentence(text: str) -> str:
    """A text as a sentence: with a capital letter and a full stop.

    Examples:
        >>> sentence("the log is cut")
        'The log is cut.'
    """
    return f"{text[:1].upper()}{text[1:].rstrip('.')}."


def bullet(text: str, advice: str = "") -> list[str]:
    """A point of a list, and what to do about it."""
    return [f"- {text}", *([f"  What to do: {sentence(advice)}"] if advice else [])]


def listed(counts: "pd.Series[int]", form: str = "{} {}") -> str:
    """Each value with its count, as `thin_film 3, drift 1`."""
    return ", ".join(form.format(value, count) for value, count in counts.items())


def percent(value: float, digits: int) -> str:
    """A share in percent without the sign, for a column that has it in its header."""
    return "not known" if np.isnan(value) else f"{100 * value:.{digits}f}"
