"""A run sheet whose form somebody altered is read, or ends in a sentence."""

import io
from pathlib import Path
from typing import Any

import numpy as np
import openpyxl
import pytest

from alterations import alter
from bad_logs import CONFIG
from oilfilm.base.errors import OilfilmError
from oilfilm.logs.sheet_file import read_run_sheet
from oilfilm.logs.traction_log import TRACTION

FILES = ("a.csv", "b.csv", "c.csv")
NAMES = [
    *("file", "oil", "rig", "run", "log_kind", "exclude", "max_hertz_pressure_gpa", "load_n"),
    *("entrainment_speed_m_s", "inlet_temperature_c"),
]
ROWS = [[file, "4102", "", "", "", "", 1.25, "", 30, 70] for file in FILES]
# What a workbook cannot hold is written as text.
CELLS = int | float | str | bool | None


def as_text(rows: Any) -> bytes:
    """The rows as a table of comma-separated values."""
    lines = []
    for row in rows:
        cells = row if isinstance(row, list) else [row]
        lines.append(",".join("" if cell is None else str(cell) for cell in cells))
    return "\n".join(lines).encode()


def as_workbook(rows: Any) -> bytes:
    """The rows as a workbook, without the characters that no workbook has."""
    workbook = openpyxl.Workbook()
    for row in rows:
        cells = row if isinstance(row, list) else [row]
        texts = [cell if isinstance(cell, CELLS) else str(cell) for cell in cells]
        is_possible = [not isinstance(t, str) or t.isprintable() for t in texts]
        workbook.active.append([t for t, can in zip(texts, is_possible, strict=True) if can])
    content = io.BytesIO()
    workbook.save(content)
    return content.getvalue()


def alter_and_read(seeds: range) -> int:
    """Alter the sheet again and again; how many ended in a sentence."""
    refused = 0
    for seed in seeds:
        random = np.random.default_rng(seed)
        rows: list[Any] = [[*NAMES], *([*row] for row in ROWS)]
        alter(rows, random)
        content = (as_text, as_workbook)[int(random.integers(2))](rows)
        try:
            read_run_sheet(content, Path("runs.csv"), FILES, CONFIG, TRACTION)
        except OilfilmError as error:
            refused += 1
            assert str(error).replace("\n", "").isprintable()
            assert len(str(error)) < 3000
    return refused


def test_altered_run_sheet_is_read_or_ends_in_a_sentence() -> None:
    assert 0 < alter_and_read(range(20)) < 20


@pytest.mark.nightly
def test_a_thousand_altered_run_sheets_are_read_or_end_in_a_sentence() -> None:
    assert alter_and_read(range(1000, 2000))
