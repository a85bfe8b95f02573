"""The csv reader: every row is kept or refused, and a refusal says which row and why."""

import numpy as np

from oilfilm.readers.base import Reading, as_ranges
from oilfilm.readers.ingest import read_log
from oilfilm.settings.resolved import Settings

HEADER = b"# oil: 4102\n# max_hertz_pressure_gpa: 1.25\n# entrainment_speed_m_s: 30\n"
NAMES = b"time_s,load_n,traction_force_n,ball_speed_rpm,disc_speed_rpm,inlet_temperature_c\n"
ROW = b"0.02,82.2,0.5,28647.9,7161.97,70.0\n"


def rules(reading: Reading) -> list[str]:
    return [refusal.rule for refusal in reading.refusals]


def test_good_log_is_one_run_in_si_units(read) -> None:
    reading = read(HEADER + NAMES + 3 * ROW)
    (run,) = reading.runs
    assert (run.oil, run.kind, len(run), reading.rows) == ("4102", "continuous", 3, 3)
    assert run.nominal.entrainment_speed_m_s == 30
    assert run.nominal.inlet_temperature_c is None
    # 28 647.9 rpm at 10 mm and 7 161.97 rpm at 40 mm are both 30 m/s
    np.testing.assert_allclose(run.samples["ball_speed_m_s"], 30, rtol=1e-5)
    np.testing.assert_allclose(run.samples["disc_speed_m_s"], 30, rtol=1e-5)


def test_columns_may_come_in_any_order_with_others_between(read) -> None:
    content = b"# oil: 4102\nnote,inlet_temperature_c,disc_speed_rpm,ball_speed_rpm,"
    content += b"traction_force_n,load_n,time_s\nx,70,3,2,0.5,82.2,0.02\n"
    (run,) = read(content).runs
    assert run.samples["load_n"].tolist() == [82.2]
    assert run.samples["inlet_temperature_c"].tolist() == [70]


def test_log_cut_in_mid_row_is_flawed_and_tells_its_last_good_row(read) -> None:
    reading = read(HEADER + NAMES + 2 * ROW + b"0.04,82.")
    assert rules(reading) == ["cut_row"]
    assert "last good row is 2" in reading.refusals[0].reason
    assert reading.runs[0].flaw.rule == "truncated"
    assert len(reading.runs[0]) == 2


def test_blank_lines_and_crlf_are_no_rows(read) -> None:
    content = (HEADER + NAMES + ROW + b"\n" + 2 * ROW).replace(b"\n", b"\r\n")
    reading = read(content)
    assert (reading.rows, rules(reading), len(reading.runs[0])) == (3, [], 3)


def test_ranges_join_neighbouring_rows() -> None:
    assert as_ranges(np.array([2, 3, 4, 7, 9, 10])) == [(2, 4), (7, 7), (9, 10)]
    assert as_ranges(np.array([], dtype=np.int64)) == []


def test_rows_of_a_log_without_names_are_all_counted(config: Settings) -> None:
    reading = read_log(b"# oil: 4102\n" + 5000 * b"0,1,2,3,4,5\n", "log", config)[1]
    assert reading.rows == 5000
