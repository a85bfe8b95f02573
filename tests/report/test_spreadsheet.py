"""Text of a log can start no formula in a spreadsheet."""

import csv
from pathlib import Path

import pandas as pd
import pytest

from oilfilm.report.spreadsheet import write_csv


@pytest.mark.parametrize(
    "hostile",
    [
        '=HYPERLINK("http://example.invalid";"open")',
        "+1+cmd|' /C calc'!A0",
        "-2+3",
        "@SUM(A1:A9)",
        "\t=1+1",
        "\r=1+1",
    ],
)
def test_formula_of_a_log_is_text(tmp_path: Path, hostile: str) -> None:
    frame = pd.DataFrame({"run_id": [hostile, "a,b \u8f7d\u8377"], "drift_n": [-1.5, 2.0]})
    write_csv(frame, tmp_path / "table.csv")
    with (tmp_path / "table.csv").open(encoding="utf-8-sig", newline="") as file:
        rows = list(csv.reader(file))
    assert rows[1] == ["'" + hostile, "-1.5"]
    assert rows[2] == ["a,b \u8f7d\u8377", "2.0"]
