"""The csv reader: every row is kept or refused, and a refusal says which row and why."""

import numpy as np
import pytest

from oilfilm.readers import find_reader
from oilfilm.readers.base import Reading, as_ranges
from oilfilm.readers.ingest import read_log
from oilfilm.settings.resolved import Settings

HEADER = b"# oil: 4102\n# max_hertz_pressure_gpa: 1.25\n# entrainment_speed_m_s: 30\n"
NAMES = b"time_s,load_n,traction_force_n,ball_speed_rpm,disc_speed_rpm,inlet_temperature_c\n"
ROW = b"0.02,82.2,0.5,28647.9,7161.97,70.0\n"


@pytest.fixture
def read(config: Settings):
    def read(content: bytes) -> Reading:
        return read_log(content, "log.csv", config)[1]

    return read


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


def test_last_row_without_line_end_is_not_trusted_but_the_rest_is(read) -> None:
    reading = read(HEADER + NAMES + 2 * ROW + ROW.strip())
    assert rules(reading) == ["unterminated_row"]
    assert reading.runs[0].flaw is None
    assert (reading.rows, len(reading.runs[0])) == (3, 2)


@pytest.mark.parametrize(
    "bad",
    [
        b"0.04,oops,0.5,28647.9,7161.97,70.0\n",
        b"0.04,,0.5,28647.9,7161.97,70.0\n",
        b"0.04,82.2,0.5\n",
        b"0.04,82.2,0.5,28647.9,7161.97,70.0,1,2\n",
        b"0.04,inf,0.5,28647.9,7161.97,70.0\n",
        b"0.04,nan,0.5,28647.9,7161.97,70.0\n",
        b"0.04,1e300,0.5,28647.9,7161.97,70.0\n",
        b"\x00\xff,82.2,0.5,28647.9,7161.97,70.0\n",
    ],
)
def test_bad_row_is_refused_by_number_and_its_neighbours_are_kept(read, bad: bytes) -> None:
    reading = read(HEADER + NAMES + 2 * ROW + bad + 3 * ROW)
    (refusal,) = reading.refusals
    assert (refusal.rule, refusal.first_row, refusal.last_row) == ("unreadable_row", 3, 3)
    assert reading.runs[0].samples["row"].tolist() == [1, 2, 4, 5, 6]


def test_blank_lines_and_crlf_are_no_rows(read) -> None:
    content = (HEADER + NAMES + ROW + b"\n" + 2 * ROW).replace(b"\n", b"\r\n")
    reading = read(content)
    assert (reading.rows, rules(reading), len(reading.runs[0])) == (3, [], 3)


@pytest.mark.parametrize(
    ("content", "rule", "words"),
    [
        (NAMES + ROW, "header", "no line `# oil"),
        (b"# oil: 9999\n" + NAMES + ROW, "unknown_oil", "'9999'; the campaign knows 4102"),
        (b"# oil: 4102\n# rig: moon\n" + NAMES + ROW, "unknown_rig", "'moon'"),
        (b"# oil: 4102\n# load_n: much\n" + NAMES + ROW, "header", "load_n: 'much'"),
        (b"# oil: 4102\n" + NAMES.replace(b"load_n", b"load"), "columns", "no unit"),
        (b"# oil: 4102\n" + NAMES.replace(b"load_n", b"weight"), "columns", "lacks the columns"),
        (b"# oil: 4102\n" + NAMES.replace(b"load_n", b"load [m]"), "columns", "'m' is none of N"),
        (b"# oil: 4102\n" + NAMES.replace(b"load_n", b"time_s,load_n"), "columns", "repeats"),
        (b"# oil: 4102\n", "columns", "no line names columns"),
    ],
)
def test_unusable_file_is_refused_whole(read, content: bytes, rule: str, words: str) -> None:
    reading = read(content)
    assert rules(reading) == [rule]
    assert words in reading.refusals[0].reason
    assert reading.refusals[0].refused_rows == reading.rows
    assert reading.runs == []


def test_simulated_log_cannot_pass_for_a_measured_one(config: Settings) -> None:
    content = b"# simulated: yes\n" + HEADER + NAMES + ROW
    measured = config.with_changes({"campaign": {"data": "measured"}})
    assert rules(read_log(content, "log.csv", measured)[1]) == ["simulated_log"]
    assert rules(read_log(content, "log.csv", config)[1]) == []


def test_unknown_content_is_quarantined_with_what_was_seen(read) -> None:
    assert find_reader(b"PK\x03\x04zip") is None
    reading = read(b"PK\x03\x04zip")
    assert rules(reading) == ["unknown_format"]
    assert "PK" in reading.refusals[0].reason
    assert "empty" in read(b"").refusals[0].reason


def test_ranges_join_neighbouring_rows() -> None:
    assert as_ranges(np.array([2, 3, 4, 7, 9, 10])) == [(2, 4), (7, 7), (9, 10)]
    assert as_ranges(np.array([], dtype=np.int64)) == []


def test_line_longer_than_a_block_is_one_refused_row(config: Settings) -> None:
    names = "time_s,load_n,traction_force_n,ball_speed_rpm,disc_speed_rpm,inlet_temperature_c"
    content = f"# oil: 4102\n{names}\n0,1,2,3,4,5\n{'9' * 3_000_000}\n1,1,2,3,4,5\n".encode()
    reading = read_log(content, "log", config)[1]
    assert [(r.rule, r.first_row) for r in reading.refusals] == [("unreadable_row", 2)]
    assert reading.runs[0].samples["row"].tolist() == [1, 3]


def test_rows_of_a_log_without_names_are_all_counted(config: Settings) -> None:
    reading = read_log(b"# oil: 4102\n" + 5000 * b"0,1,2,3,4,5\n", "log", config)[1]
    assert reading.rows == 5000
