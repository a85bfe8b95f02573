"""LVM: segments, clocks, decimal marks, and files that were cut or edited."""

import lvm_read
import numpy as np
import pytest

import formats
from oilfilm.logs.base import Refusal

VALUES = formats.columns(40)


@pytest.mark.parametrize("mark", [".", ","])
def test_rows_are_read_as_the_package_lvm_read_reads_them(read, mark: str) -> None:
    text = formats.lvm(VALUES, mark=mark)
    (run,) = read(text).runs
    time, load, force, *_ = lvm_read.read_lines(text.decode().splitlines(True))[0]["data"].T
    np.testing.assert_array_equal(run.samples["time_s"], time)
    np.testing.assert_allclose(run.samples["load_n"], load * 9.80665, rtol=1e-15)
    np.testing.assert_array_equal(run.samples["traction_force_n"], force)


def test_comma_as_separator_is_read(read) -> None:
    text = formats.lvm(VALUES).decode().replace("Separator\tTab", "Separator\tComma")
    (run,) = read(text.replace("\t", ",")).runs
    assert len(run) == 40


def test_segments_are_runs_with_set_points_in_their_notes(read) -> None:
    lines = formats.lvm_header({"oil": "4102"})
    lines += formats.lvm_segment(VALUES, formats.UNITS, ".", "inlet_temperature_c: 25")
    lines += formats.lvm_segment(VALUES, formats.UNITS, ".", "inlet_temperature_c: 70")
    reading = read("\n".join(lines))
    assert [run.run_id for run in reading.runs] == ["log:segment1", "log:segment2"]
    assert [run.set_points["inlet_temperature_c"] for run in reading.runs] == [25, 70]
    assert reading.runs[1].samples["row"].tolist() == list(range(41, 81))


def test_header_keys_may_be_fields_of_their_own(read) -> None:
    text = formats.lvm(VALUES, keys={}).decode()
    (run,) = read(text.replace("Time_Pref", "oil\t4102\r\nTime_Pref")).runs
    assert run.oil_name == "4102"


@pytest.mark.parametrize("between", ["; ", ", ", ","])
def test_decimal_comma_in_a_description_does_not_end_a_number(read, between: str) -> None:
    keys = between.join(["oil: 4102", "max_hertz_pressure_gpa: 1,25", "entrainment_speed_m_s: 30"])
    text = formats.lvm(VALUES, keys={}).decode().replace("Description\t", f"Description\t{keys}")
    (run,) = read(text).runs
    assert run.oil_name == "4102"
    assert run.set_points["max_hertz_pressure_gpa"] == 1.25
    assert run.set_points["entrainment_speed_m_s"] == 30


def test_without_an_x_column_time_follows_from_the_sampling_interval(read) -> None:
    text = formats.lvm(VALUES).decode().replace("X_Columns\tOne", "X_Columns\tNo")
    head, names, rows = text.partition("X_Value")
    lines = rows.split("\r\n")
    lines[1:-1] = ["\t" + line.split("\t", 1)[1] for line in lines[1:-1]]
    (run,) = read(head + names + "\r\n".join(lines)).runs
    np.testing.assert_allclose(run.samples["time_s"], VALUES["time"], rtol=1e-12)
    assert len(run) == 40


def multi(clock: np.ndarray) -> str:
    """A file in which each channel has an X column; `clock` is the one of the last."""
    names = [name for name in VALUES if name != "time"]
    clocks = [*4 * [VALUES["time"]], clock]
    cells = [column for name, x in zip(names, clocks, strict=True) for column in (x, VALUES[name])]
    lines = formats.lvm_header(formats.KEYS, x_columns="Multi")
    lines += [
        "Channels\t5",
        "Y_Unit_Label\t" + "\t\t".join(formats.UNITS[name] for name in names),
        "***End_of_Header***",
        "\t".join(f"X_Value\t{name}" for name in names) + "\tComment",
        *("\t".join(map(repr, row)) for row in np.column_stack(cells).tolist()),
        "",
    ]
    return "\n".join(lines)


def test_x_column_of_each_channel_is_read_where_the_clocks_agree(read) -> None:
    (run,) = read(multi(VALUES["time"])).runs
    np.testing.assert_allclose(run.samples["load_n"], VALUES["load"] * 9.80665, rtol=1e-12)
    # half an interval later: the last channel has no reading at the first row
    (later,) = read(multi(VALUES["time"] + 0.01)).runs
    np.testing.assert_allclose(later.samples["load_n"], VALUES["load"][1:] * 9.80665, rtol=1e-12)


@pytest.mark.parametrize("decimals", ["", ".25", ".8190984725952148437"])
@pytest.mark.parametrize("gap", ["\t\t", "\t"], ids=["as LabVIEW", "no empty cells"])
def test_channel_that_starts_later_by_its_header_has_later_times(
    read, gap: str, decimals: str
) -> None:
    # LabVIEW leaves the cell below each X column empty
    clock_times = [*4 * [f"16:29:04{decimals}"], f"16:29:05{decimals}"]
    dates = gap.join(5 * ["2026/01/10"])
    lines = ["Channels\t5", f"Date\t{dates}\t", f"Time\t{gap.join(clock_times)}\t"]
    text = multi(VALUES["time"] - 1.0).replace("Channels\t5", "\n".join(lines))
    (run,) = read(text).runs
    expected = VALUES["inlet_temperature"] - 273.15
    np.testing.assert_allclose(run.samples["inlet_temperature_c"], expected)


def with_cells(text: str, cells: dict[tuple[int, int], str]) -> str:
    """A text with other cells: (row from 0, column) -> text."""
    lines = text.split("\n")
    first_row = next(number for number, line in enumerate(lines) if line.startswith("X_Value")) + 1
    for (row, column), cell in cells.items():
        cells_of_line = lines[first_row + row].split("\t")
        cells_of_line[column] = cell
        lines[first_row + row] = "\t".join(cells_of_line)
    return "\n".join(lines)


# half an interval later than the clock of the other channels
LATER = VALUES["time"] + 0.01


@pytest.mark.parametrize("row", [12, 38])
def test_channels_with_clocks_of_their_own_are_refused_where_time_falls(read, row: int) -> None:
    clock = VALUES["time"].copy()
    clock[row:] -= clock[row]
    shift = {
        (index, column): f"{clock[index]:.2f}" for index in range(row, 40) for column in (0, 2)
    }
    reading = read(with_cells(multi(LATER), shift))
    (refusal,) = reading.refusals
    assert (reading.runs, refusal.rule, refusal.refused_rows) == ([], "clocks", 40)
    assert f"falls from {clock[row - 1]:g} to 0 in row {row + 1}" in refusal.reason


def test_bad_rows_of_channels_with_clocks_of_their_own_are_refused_by_number(read) -> None:
    # the force stops before the end, in one row the load has no time, and one row has no time
    cells = {(row, 3): "OVL" for row in (37, 38, 39)} | {(20, 0): "OVL"}
    cells |= {(10, column): "--" for column in range(10)}
    reading = read(with_cells(multi(LATER), cells))
    refused = [(found.first_row, found.last_row) for found in reading.refusals if found.first_row]
    # the last channel has no reading at row 1, and none beside its gap in row 11
    assert refused == [(1, 1), (11, 12), (21, 21), (38, 40)]
    (run,) = reading.runs
    kept = run.samples["row"] - 1
    assert (reading.row_count, len(kept)) == (40, 33)
    np.testing.assert_array_equal(run.samples["traction_force_n"], VALUES["traction_force"][kept])
    np.testing.assert_allclose(run.samples["time_s"], VALUES["time"][kept])


def test_half_written_file_with_clocks_of_their_own_is_truncated(read) -> None:
    whole = multi(LATER)
    cut = whole[: whole.rindex("\t") - 20]
    reading = read(cut)
    assert reading.runs[0].refusal.rule == "truncated"
    assert reading.row_count == 40
    reading = read(whole.removesuffix("\n"))
    assert "unterminated_row" in {refusal.rule for refusal in reading.refusals}
    assert reading.runs[0].refusal is None


def test_file_cut_in_mid_row_is_flawed_and_keeps_its_good_rows(read) -> None:
    content = formats.lvm(VALUES)
    cut = content[: content.rindex(b"\t") - 60]
    reading = read(cut)
    assert [refusal.rule for refusal in reading.refusals] == ["cut_row"]
    assert reading.runs[0].refusal.rule == "truncated"
    assert reading.row_count == len(reading.runs[0]) + 1


def test_file_cut_at_a_line_end_is_noticed_by_the_announced_samples(read) -> None:
    content = formats.lvm(VALUES)
    (run,) = read(b"".join(content.splitlines(keepends=True)[:-3])).runs
    assert run.refusal == Refusal("truncated", "the segment announces 40 samples and holds 37")


@pytest.mark.parametrize(
    "bad", ["oops", "1.0\t2.0", "\t\t\t", "***End_of_Header***", "1_0\t1\t1\t1\t1\t1", 9 * "1\t"]
)
def test_bad_row_is_refused_by_number_and_its_neighbours_are_kept(read, bad: str) -> None:
    lines = formats.lvm(VALUES).decode().split("\r\n")
    lines.insert(-3, bad)
    reading = read("\n".join(lines))
    (refusal,) = reading.refusals
    assert (refusal.rule, refusal.first_row, refusal.last_row) == ("unreadable_row", 39, 39)
    assert (reading.row_count, len(reading.runs[0])) == (41, 40)


@pytest.mark.parametrize("beside", ["\n", "\ta note"])
def test_empty_lines_and_comments_beside_rows_do_no_harm(read, beside: str) -> None:
    lines = formats.lvm(VALUES).decode().split("\r\n")
    lines[-3] += beside
    reading = read("\n".join(lines))
    assert (reading.row_count, reading.refusals, len(reading.runs[0])) == (40, [], 40)
