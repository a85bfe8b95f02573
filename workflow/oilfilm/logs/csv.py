"""Text logs with one row per instant: a header, one line of column names, then the rows.

data/raw/README.md describes what may vary between logs; `layout` finds it out.
"""

import re
from collections.abc import Iterator
from dataclasses import replace

from oilfilm.logs.base import Names, Reading, Refusal, refused_file
from oilfilm.logs.columns import LoggedTable, columns_advice, read_tables, unreadable_rows
from oilfilm.logs.encoding import normalise
from oilfilm.logs.layout import (
    LayoutError,
    find_layout,
    holds_rows_of_numbers,
    possible_names,
)
from oilfilm.logs.log_kind import LogKind
from oilfilm.logs.run_sheet import SheetOfLog
from oilfilm.logs.text_rows import count_rows, cut_row
from oilfilm.settings.resolved import Settings

# With a decimal mark of the other kind elsewhere in the log.
_DOUBTFUL = re.compile(r"[-+]?[1-9]\d{0,2}(?:\.\d{3})+|[-+]?[1-9]\d{0,2}(?:,\d{3})+")


def recognises(head: bytes) -> bool:
    """True for text with a `#` comment or a line of several cells near its top."""
    text = normalise(head).decode("utf-8", "replace").lstrip("\ufeff \n")
    if not text or "\0" in text[:200]:
        return False
    lines = text.splitlines()[:100]
    return (
        text.startswith("#")
        or any(line.count(mark) >= 3 for line in lines for mark in ",;\t|")
        or holds_rows_of_numbers(lines)
    )


def read(
    content: bytes, file: str, settings: Settings, kind: LogKind, sheet: SheetOfLog
) -> Reading:
    """See `Reader.read`."""
    try:
        layout = find_layout(content, kind.renamed(settings.campaign), kind.vocabulary)
    except LayoutError as error:
        return refused_file(error.rows, "columns", str(error), columns_advice(kind.vocabulary))
    whole, _, tail = layout.table.rows.rpartition(b"\n")
    cells, count = replace(layout.table, rows=whole), count_rows(whole)
    behind = flaw = None
    if tail:
        width = tail.count(cells.delimiter.encode()) + 1
        behind, flaw = cut_row(width, cells.width, count + 1, file)

    def bad_rows(first: int, last: int) -> Refusal:
        seen = cells.lines[first - 1].decode("utf-8", "replace")
        line = layout.first_line and layout.first_line + first - 1
        where = f" (line {line} of the file)" if line else ""
        refusal = unreadable_rows(file, first, last, seen, where)
        doubtful = next(filter(_DOUBTFUL.fullmatch, seen.split(cells.delimiter)), None)
        if doubtful is None:
            return refusal
        advice = f"{doubtful!r} may be a number of thousands: export without marks between them."
        return replace(refusal, advice=advice)

    table = LoggedTable(
        file,
        layout.keys,
        layout.names,
        layout.units,
        cells.numbers,
        count,
        flaw=flaw,
        behind=behind,
        bad_rows=bad_rows,
    )
    return read_tables([table], settings, kind, sheet, layout.form)


def names(content: bytes) -> Iterator[Names]:
    """See `Reader.names`."""
    return possible_names(content)
