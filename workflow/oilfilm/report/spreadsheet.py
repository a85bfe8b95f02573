"""Tables for spreadsheets, in which no text of a log becomes a formula."""

from pathlib import Path

import pandas as pd

from oilfilm.base.atomic_write import write_text

# A spreadsheet may run a text that begins with one of these.
_FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r", "\n")


def write_csv(frame: pd.DataFrame, path: Path) -> None:
    """Write a table as csv (see `csv_text`), completely or not at all.

    The file is UTF-8 with a byte-order mark. Without it some spreadsheets assume another encoding.
    """
    write_text(csv_text(frame), path, encoding="utf-8-sig")


def _joined(value: object) -> object:
    """The texts of a tuple in one cell; other values as they are."""
    return "; ".join(value) if isinstance(value, tuple) else value


def csv_text(frame: pd.DataFrame) -> str:
    """A table as csv, numbers with all their digits.

    Text that a spreadsheet would run as a formula gets an apostrophe before it; numbers stay.

    Reference: OWASP, CSV Injection.
    """
    safe = frame.copy()
    for name in frame.select_dtypes(exclude="number"):
        texts = frame[name].map(_joined).astype(str)
        safe[name] = texts.where(~texts.str.startswith(_FORMULA_STARTS), "'" + texts)
    return safe.to_csv(index=False, lineterminator="\r\n")
