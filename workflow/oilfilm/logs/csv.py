"""Text logs with one row per instant: a header, one line of column names, then the rows.

data/raw/README.md describes what may vary between logs; `layout` finds it out.
"""

import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as arrow
import pyarrow.csv as arrow_csv

from oilfilm.logs.base import Names, Reading, Refusal, as_ranges, refused_file
from oilfilm.logs.columns import (
    columns_advice,
    converted,
    understood_columns,
    unreadable_rows,
)
from oilfilm.logs.encoding import normalise
from oilfilm.logs.instants import seconds
from oilfilm.logs.layout import (
    Layout,
    LayoutError,
    count_rows,
    cut_row,
    find_layout,
    holds_rows_of_numbers,
    possible_names,
    truncated,
)
from oilfilm.logs.log_kind import ContinuousLog, FloatArray, IndexArray, LogKind
from oilfilm.logs.run_sheet import SheetOfLog
from oilfilm.logs.understood import Understood
from oilfilm.settings.resolved import Settings

# Marks between thousands that are no decimal mark anywhere.
_BLANK_GROUPS = r"(?<=\d)[ \u00a0\u202f'\u2019](?=\d{3}(?!\d))"
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
    count = count_rows(layout.table)
    labels = sheet.labels(file, layout.keys, settings)
    problem = labels.problem or kind.header_problem(labels.keys, layout.columns, settings)
    if problem:
        return Reading(
            count, [], [problem.of_rows("", 1, count), *labels.remarks], form=layout.form
        )
    complete_rows, _, tail = layout.table.rpartition(b"\n")
    values, rows, bad, understood = _parse(complete_rows, layout)
    lines = layout.table.split(b"\n") if len(bad) else []
    refusals = [
        _bad_range(file, first, last, lines[first - 1], layout) for first, last in as_ranges(bad)
    ]
    cells = tail.count(layout.delimiter.encode()) + 1 if tail else 0
    cut = cut_row(cells, len(layout.names), count, file)
    if cut is not None:
        refusals.append(cut)
    flaw = labels.excluded or truncated(cut)
    understood = understood.with_sources(labels.sources)
    log = ContinuousLog(file, labels.keys, layout.columns, rows, values, flaw, understood)
    refusals += labels.remarks
    return Reading(count, [kind.run(log, settings)], refusals, form=layout.form)


def names(content: bytes) -> Iterator[Names]:
    """See `Reader.names`."""
    return possible_names(content)


def _parse(
    table: bytes, layout: Layout
) -> tuple[dict[str, FloatArray], IndexArray, IndexArray, Understood]:
    """Values of the good rows by quantity, their numbers, those of bad rows, the columns."""
    misfits: list[int] = []
    names = [f"c{index}" for index in range(len(layout.names))]
    wanted = [names[column.index] for column in layout.columns]
    stamps = [] if layout.stamps is None else [names[index] for index in layout.stamps.places]

    def skip(row: arrow_csv.InvalidRow) -> str:
        misfits.append(row.number)
        return "skip"

    def parse(as_type: arrow.DataType, decimal_mark: str) -> arrow.Table:
        misfits.clear()
        types = {**dict.fromkeys(wanted, as_type), **dict.fromkeys(stamps, arrow.string())}
        return arrow_csv.read_csv(
            arrow.BufferReader(table),
            # one thread: only then are the rows that do not fit numbered
            read_options=arrow_csv.ReadOptions(
                use_threads=False,
                column_names=names,
                # one block: a line longer than a block could not be read
                block_size=len(table) + 1,
            ),
            parse_options=arrow_csv.ParseOptions(
                delimiter=layout.delimiter,
                # a stray quote must not swallow the lines up to the next one
                quote_char=False,
                invalid_row_handler=skip,
            ),
            convert_options=arrow_csv.ConvertOptions(
                include_columns=[*types],
                column_types=types,
                decimal_point=decimal_mark,
            ),
        )

    if not table:
        return _values([np.array([])] * len(wanted), np.array([], dtype=np.int64), layout)
    try:
        table_of_cells = parse(arrow.float64(), layout.decimal_mark)
        cells = {name: table_of_cells[name].to_numpy() for name in wanted if name not in stamps}
    except arrow.ArrowInvalid:
        table_of_cells = parse(arrow.binary(), ".")
        texts = table_of_cells.to_pandas()
        cells = {name: _numbers(texts[name], layout) for name in wanted if name not in stamps}
    if stamps:
        texts = [table_of_cells[name].to_pandas().str.strip(' "') for name in stamps]
        cells[stamps[0]] = seconds(*texts)
    return _values([cells[name] for name in wanted], np.array(misfits, dtype=np.int64), layout)


def _values(
    logged: list[FloatArray], misfits: IndexArray, layout: Layout
) -> tuple[dict[str, FloatArray], IndexArray, IndexArray, Understood]:
    """As `_parse`, from the numbers as logged and the numbers of the rows that do not fit."""
    rows = np.arange(1, len(logged[0]) + len(misfits) + 1)
    if len(misfits):
        rows = np.delete(rows, misfits - 1)
    understood = understood_columns(layout.columns, logged, layout.names)
    values, good = converted(layout.columns, logged)
    if good.all():
        return values, rows, misfits, understood
    good_values = {quantity: column[good] for quantity, column in values.items()}
    bad = np.sort(np.concatenate([rows[~good], misfits]))
    return good_values, rows[good], bad, understood


def _numbers(cells: "pd.Series[Any]", layout: Layout) -> FloatArray:
    """Numbers of raw cells; NaN where a cell holds anything else."""
    text = cells.map(lambda cell: cell.decode("utf-8", "replace").strip(' "'), na_action="ignore")
    text = text.str.replace(_BLANK_GROUPS, "", regex=True)
    other = "," if layout.decimal_mark == "." else "."
    if layout.group_mark:
        grouped = rf"[-+]?\d{{1,3}}(?:\{other}\d{{3}})+(?:\{layout.decimal_mark}\d*)?"
        ungrouped = text.str.replace(other, "", regex=False)
        text = text.where(~text.str.fullmatch(grouped, na=False), ungrouped)
    # the other mark would be a second decimal mark: such a cell is no number
    text = text.str.replace(other, "?", regex=False).str.replace(",", ".", regex=False)
    return pd.to_numeric(text, errors="coerce").to_numpy(dtype=np.float64)


def _bad_range(run_id: str, first: int, last: int, line: bytes, layout: Layout) -> Refusal:
    seen = line.decode("utf-8", "replace")
    where = f" (line {layout.first_line + first - 1} of the file)" if layout.first_line else ""
    refusal = unreadable_rows(run_id, first, last, seen, where)
    doubtful = next(filter(_DOUBTFUL.fullmatch, seen.split(layout.delimiter)), None)
    if doubtful is None:
        return refusal
    advice = f"{doubtful!r} may be a number of thousands: export without marks between thousands."
    return replace(refusal, advice=advice)
