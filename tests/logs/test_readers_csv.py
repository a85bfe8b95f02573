"""The csv reader: every row is kept or refused, and a refusal says which row and why."""

import numpy as np

from oilfilm.logs.base import as_ranges

HEADER = b"# oil: 4102\n"
NAMES = b"time_s,load_n,traction_force_n,ball_speed_rpm,disc_speed_rpm,inlet_temperature_c\n"
ROW = b"0.02,82.2,0.5,28647.9,7161.97,70.0\n"


def test_log_cut_in_mid_row_is_flawed_and_tells_its_last_good_row(read) -> None:
    reading = read(HEADER + NAMES + 2 * ROW + b"0.04,82.")
    (refusal,) = reading.refusals
    assert refusal.rule == "cut_row"
    assert "last good row is 2" in refusal.reason
    assert reading.runs[0].flaw.rule == "truncated"
    assert len(reading.runs[0]) == 2


def test_blank_lines_and_crlf_are_no_rows(read) -> None:
    reading = read((HEADER + NAMES + ROW + b"\n" + 2 * ROW).replace(b"\n", b"\r\n"))
    assert (reading.rows, reading.refusals, len(reading.runs[0])) == (3, [], 3)


def test_ranges_join_neighbouring_rows() -> None:
    assert as_ranges(np.array([2, 3, 4, 7, 9, 10])) == [(2, 4), (7, 7), (9, 10)]
    assert as_ranges(np.array([], dtype=np.int64)) == []


def test_rows_of_a_log_without_names_are_all_counted(read) -> None:
    assert read(b"# oil: 4102\n" + 5000 * b"0,1,2,3,4,5\n").rows == 5000
