"""Text of a log can start no formula in a spreadsheet."""

import csv
from pathlib import Path

import pandas as pd

from oilfilm.report.spreadsheet import write_csv

HOSTILE = ("=HYPERLINK(1)", "+1+cmd|' /C calc'!A0", "-2+3", "@SUM(A1:A9)", "\t=1", "\r=1", "\n=1")


def test_formula_of_a_log_is_text(tmp_path: Path) -> None:
    names = [*HOSTILE, "a,b \u8f7d\u8377"]
    write_csv(pd.DataFrame({"run_id": names, "drift_n": -1.5}), tmp_path / "table.csv")
    with (tmp_path / "table.csv").open(encoding="utf-8-sig", newline="") as file:
        _, *rows = csv.reader(file)
    assert rows == [*([f"'{name}", "-1.5"] for name in HOSTILE), [names[-1], "-1.5"]]
