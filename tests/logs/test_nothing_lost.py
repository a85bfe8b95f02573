"""Rows written = samples + refused, files in a folder = logs + named as passed over.

What was written is counted while it is written: nothing here reads a log.
"""

import gzip

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import formats
from bad_logs import CONFIG, PCS_CONFIG, PCS_ROW, pcs
from nights import examples
from oilfilm.logs.ingest import ingest_logs
from oilfilm.settings.resolved import Settings

# What spreadsheets, loggers and people leave in the first cell of a row, and whole lines of theirs.
CELLS = ["#N/A", "#DIV/0!", "#VALUE!", "#REF!", "#BEZUG!", "N/A", "", "1_0", "inf", "0x1", '"', "#"]
LINES = ["End of test", "#N/A", "12", "a b c d e f", "0", "time load", "Step 2", "-"]
COMMENTS = ["# pause", "# end of test", "#", "# ok; 3 K warmer"]
WIDTH = 6
SPOILS = st.one_of(
    st.just(None),
    st.tuples(st.just("cell"), st.sampled_from(CELLS)),
    st.tuples(st.just("cells"), st.integers(1, WIDTH + 3)),
    st.tuples(st.just("all"), st.sampled_from(CELLS)),
)


def spoilt(cells: list[str], spoil: tuple[str, str | int] | None) -> list[str]:
    if spoil is None:
        return cells
    kind, what = spoil
    if kind == "cells":
        return (cells * 2)[: int(what)]
    return [str(what)] * len(cells) if kind == "all" else [str(what), *cells[1:]]


def assert_all_there(content: bytes, written: int, settings: Settings = CONFIG) -> None:
    ingested = ingest_logs([("log", content)], settings)
    rows = sum(map(len, ingested.samples_of_oil.values()))
    assert rows + ingested.quarantine["refused_rows"].sum() == written
    assert rows == ingested.runs["samples"].sum()


@pytest.mark.slow
@given(
    st.sampled_from([",", ";", "\t", "|"]),
    st.lists(SPOILS, min_size=4, max_size=12),
    st.lists(st.sampled_from(COMMENTS), max_size=2),
    st.sampled_from(["\n", "\r\n", "\r", "\n\n"]),
    st.booleans(),
)
def test_every_row_of_a_text_log_is_kept_or_refused(
    mark: str, spoils: list, comments: list[str], end: str, packed: bool
) -> None:
    names = [f"{name} [{formats.UNITS[name]}]" for name in formats.columns(1)]
    row = [f"{number:.1f}" for number in (0, 82, 0.5, 28650, 7160, 343)]
    # sound rows first: what a log is written like is known from most of them
    every = [*[row] * len(spoils), *(spoilt(row, spoil) for spoil in spoils)]
    lines = [mark.join(cells) for cells in every]
    # a line of nothing is none
    written = sum(bool(line) for line in lines)
    text = end.join(["# oil: 4102", mark.join(names), *lines, *comments, ""])
    content = text.encode()
    assert_all_there(gzip.compress(content) if packed else content, written)


@examples(0.5)
@given(st.lists(st.sampled_from(LINES), max_size=6))
def test_every_line_among_the_rows_is_a_refused_row(others: list[str]) -> None:
    content = formats.csv(formats.columns(20)).decode().splitlines()
    assert_all_there("\n".join([*content, *others, ""]).encode(), 20 + len(others))
    tabs = formats.lvm(formats.columns(20)).decode().removesuffix("\r\n").split("\r\n")
    assert_all_there("\n".join([*tabs, *others, ""]).encode(), 20 + len(others))


@given(st.lists(SPOILS, min_size=1, max_size=6), st.booleans())
def test_every_row_of_a_pcs_step_is_kept_or_refused(spoils: list, headless: bool) -> None:
    rows = [spoilt(PCS_ROW.split("\t"), spoil) for spoil in spoils]
    # the program ends a table by a line without cells: fewer than four are no row
    rows = [PCS_ROW.split("\t"), *(cells for cells in rows if len(cells) > 4)]
    content = pcs(*map("\t".join, rows))
    if headless:
        content = b"ETM Test Data File\n" + content.partition(b"\n")[2]
    assert_all_there(content, len(rows), PCS_CONFIG)


@examples(0.5)
@given(st.lists(st.integers(0, 30), min_size=6, max_size=6), st.integers(0, 29))
def test_every_row_of_a_binary_log_is_kept_or_refused(lengths: list[int], hole: int) -> None:
    values = formats.columns(30)
    values["load"][hole] = np.nan
    assert_all_there(formats.as_parquet(values), 30)
    cut = {name: values[name][:length] for name, length in zip(values, lengths, strict=True)}
    assert_all_there(formats.tdms(cut), max(lengths))
