"""Tables for people with a spreadsheet, in which a cell of a log can start no formula."""

from pathlib import Path

import pandas as pd

# What a spreadsheet takes for the beginning of a formula or a command.
_FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")


def write_csv(frame: pd.DataFrame, path: Path) -> None:
    """Write a table as csv, whole or not at all.

    Text that a spreadsheet would run as a formula gets an apostrophe before it; numbers stay.
    The file is UTF-8 with a mark, without which some spreadsheets take it for another encoding.

    Reference: OWASP, CSV Injection.
    """
    safe = frame.copy()
    for name in frame.select_dtypes(exclude="number"):
        text = frame[name].astype(str)
        safe[name] = text.where(~text.str.startswith(_FORMULA_STARTS), "'" + text)
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = path.with_name(path.name + ".part")
    safe.to_csv(aside, index=False, encoding="utf-8-sig", lineterminator="\r\n")
    aside.replace(path)
