"""A file with several runs gives each of them, with its own oil, rig and set points."""

from collections.abc import Callable

import numpy as np
import pyarrow as arrow
import pytest
from nptdms import ChannelObject

import formats
from bad_logs import CONFIG
from oilfilm.logs import set_point_changes
from oilfilm.logs.base import READING_NOTE, LoggedRun, ParsedLog, distinct_names
from oilfilm.logs.ingest import read_log
from oilfilm.logs.set_point_changes import row_indices_of_set_points

ROWS = 40
VALUES = formats.columns(ROWS)
HALF = ROWS // 2


def read(content: bytes | str, reader: str = "csv") -> ParsedLog:
    content = content.encode() if isinstance(content, str) else content
    name, reading = read_log(content, "log", CONFIG)
    assert name == reader
    return reading


def csv(labels: dict[str, list[str]], header: str = "", **changed: np.ndarray) -> str:
    """A csv log with columns of labels in front of those of numbers."""
    values = VALUES | changed
    names = [*labels, *(f"{name} [{formats.UNITS[name]}]" for name in values)]
    lines = [header, ",".join(names)] if header else [",".join(names)]
    for row in range(ROWS):
        cells = [texts[row] for texts in labels.values()]
        cells += [repr(float(numbers[row])) for numbers in values.values()]
        lines.append(",".join(cells))
    return "\n".join(lines) + "\n"


def lvm(labels: dict[str, list[str]]) -> bytes:
    """An LVM log; its labels are columns of numbers as LabVIEW writes them."""
    names = [*list(VALUES)[1:], *labels]
    units = [*(formats.UNITS[name] for name in list(VALUES)[1:]), *("" for _ in labels)]
    tabs = "\t" * len(names)
    lines = ["LabVIEW Measurement\t", "Separator\tTab", "Decimal_Separator\t.", "X_Columns\tOne"]
    lines += ["Description\toil: 4102", "***End_of_Header***\t", "Channels\t1" + tabs]
    lines += ["Y_Unit_Label\t" + "\t".join(units), "***End_of_Header***" + tabs]
    lines += ["X_Value\t" + "\t".join(names)]
    for row in range(ROWS):
        numbers = [f"{column[row]:.6f}" for column in VALUES.values()]
        lines.append("\t".join([*numbers, *(texts[row] for texts in labels.values())]))
    return ("\n".join(lines) + "\n").encode()


def tdms(labels: dict[str, list[str]]) -> bytes:
    channels = formats.tdms_channels("run", VALUES)
    for name, texts in labels.items():
        numeric = all(text.isdigit() for text in texts)
        channels.append(
            ChannelObject("run", name, np.array(texts, dtype=int) if numeric else texts)
        )
    return formats.tdms_file([formats.RootObject(formats.KEYS), *channels])


def parquet(labels: dict[str, list[str]]) -> bytes:
    table = formats.table(VALUES)
    for name, texts in labels.items():
        table = table.append_column(name, arrow.array(texts))
    return formats.parquet_file(table)


def blocks(name: str, *texts: str) -> dict[str, list[str]]:
    """A column with equally long blocks of labels."""
    rows = np.array_split(np.arange(ROWS), len(texts))
    return {name: [text for text, part in zip(texts, rows, strict=True) for _ in part]}


WRITERS: dict[str, Callable[[dict[str, list[str]]], bytes]] = {
    "csv": lambda labels: csv(labels, "# oil: 4102").encode(),
    "lvm": lvm,
    "tdms": tdms,
    "parquet": parquet,
}


@pytest.mark.parametrize("format_name", WRITERS)
def test_column_of_runs_divides_the_rows_in_every_format(format_name: str) -> None:
    content = WRITERS[format_name](blocks("Run", "1", "2", "3", "4"))
    reading = read(content, format_name)
    assert [run.run_id for run in reading.runs] == ["log:1", "log:2", "log:3", "log:4"]
    assert [len(run) for run in reading.runs] == [10, 10, 10, 10]
    together = np.concatenate([run.samples["load_n"] for run in reading.runs])
    np.testing.assert_allclose(together, VALUES["load"] * 9.80665, rtol=1e-6)
    numbers = np.concatenate([run.samples["row"] for run in reading.runs])
    np.testing.assert_array_equal(numbers, np.arange(1, ROWS + 1))


@pytest.mark.parametrize("name", ["Oil", "oil", "Lubricant", "Öl", "油"])
def test_column_of_oils_never_makes_one_oil_of_two(name: str) -> None:
    # rows of both oils alternate, as in a sorted table of readings
    labels = {name: ["4102", "4050"] * HALF}
    first, second = read(csv(labels)).runs
    assert (first.oil_name, second.oil_name) == ("4102", "4050")
    np.testing.assert_array_equal(first.samples["row"], np.arange(1, ROWS + 1, 2))
    np.testing.assert_allclose(second.samples["load_n"], VALUES["load"][1::2] * 9.80665)


@pytest.mark.parametrize("column", ["Oil", "Lubricant"])
def test_oil_in_a_column_and_the_same_in_the_header_is_used(column: str) -> None:
    (run,) = read(csv(blocks(column, "4102"), "# oil: 4102")).runs
    assert run.oil_name == "4102"


def test_column_with_very_many_oils_is_refused() -> None:
    rows = 3000
    names = ",".join(f"{name} [{formats.UNITS[name]}]" for name in VALUES)
    lines = [f"Oil,{names}", *(f"oil {row},{row / 50},80,1,28000,7000,343" for row in range(rows))]
    reading = read("\n".join(lines) + "\n")
    (refusal,) = reading.refusals
    assert (reading.runs, refusal.refused_rows) == ([], rows)
    assert "3000 runs" in refusal.reason


@pytest.mark.parametrize("in_header", ["oil", "lubricant"])
@pytest.mark.parametrize("column", ["Oil", "Lubricant", "Öl"])
def test_oil_in_a_column_and_another_in_the_header_is_refused(in_header: str, column: str) -> None:
    reading = read(csv(blocks(column, "4102"), f"# {in_header}: 4050"))
    assert reading.runs == []
    assert [refusal.rule for refusal in reading.refusals] == ["unknown_oil"]


def test_run_without_a_label_is_not_part_of_another() -> None:
    # as NumPy writes it
    reading = read(csv(blocks("Run", "a", "nan"), "# oil: 4102"))
    assert [len(run) for run in reading.runs] == [HALF, HALF]


def test_empty_cells_of_a_label_are_as_the_cell_above() -> None:
    labels = {"Run": ["a", *[""] * (HALF - 1), "b", *[""] * (HALF - 1)]}
    assert [len(run) for run in read(csv(labels, "# oil: 4102")).runs] == [HALF, HALF]


@pytest.mark.parametrize(
    "labels",
    [
        {"Run": [str(row) for row in range(ROWS)]},
        {"Run": ["0"] * 5 + ["1"] * 30 + ["0"] * 5},
        {"Step": [str(row // 5) for row in range(ROWS)]},
        {"Oil": [f"{60 + row / 10:.1f}" for row in range(ROWS)]},
        {"Test": ["7"] * ROWS},
    ],
    ids=["counter", "flag", "levels of slip", "a temperature", "one test"],
)
def test_column_that_names_no_runs_divides_nothing(labels: dict[str, list[str]]) -> None:
    (run,) = read(csv(labels, "# oil: 4102")).runs
    assert run.run_id == "log"
    assert len(run) == ROWS


def test_step_with_a_sweep_of_its_own_is_a_run() -> None:
    # each of two steps changes the speed of the disc over the same range
    disc = np.tile(np.linspace(7000.0, 9000.0, HALF), 2)
    runs = read(csv(blocks("Step", "1", "2"), "# oil: 4102", disc_speed=disc)).runs
    assert [run.run_id for run in runs] == ["log:1", "log:2"]


def test_steps_without_slip_are_no_runs() -> None:
    # both bodies run at one speed throughout
    ball, disc = np.full(ROWS, 8000.0), np.full(ROWS, 2000.0)
    (run,) = read(
        csv(blocks("Step", "1", "2"), "# oil: 4102", ball_speed=ball, disc_speed=disc)
    ).runs
    assert len(run) == ROWS


@pytest.mark.parametrize("format_name", WRITERS)
def test_restart_of_time_begins_a_run_in_every_format(
    format_name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(VALUES, "time", np.tile(np.arange(HALF) / 50, 2))
    runs = read(WRITERS[format_name]({}), format_name).runs
    assert [run.run_id for run in runs] == ["log:part1", "log:part2"]
    assert [len(run) for run in runs] == [HALF, HALF]


@pytest.mark.parametrize("fault", [{20: 0.0}, {20: -1.0, 21: -1.0}], ids=["zero", "two rows"])
def test_wrong_time_in_a_row_or_two_begins_no_run(fault: dict[int, float]) -> None:
    time = VALUES["time"].copy()
    time[list(fault)] = list(fault.values())
    (run,) = read(csv({}, "# oil: 4102", time=time)).runs
    assert len(run) == ROWS


def block(load: float, step: int, rows: int = 6) -> str:
    lines = [f"Step {step}\tTraction curve", f"Load (N)\t{load}", "\t".join(VALUES)]
    lines[-1] = "\t".join(f"{name} [{formats.UNITS[name]}]" for name in VALUES)
    lines += ["\t".join(f"{column[row]:.4f}" for column in VALUES.values()) for row in range(rows)]
    return "\n".join(lines) + "\n"


def test_repeated_header_blocks_are_runs_with_their_own_set_points() -> None:
    above = "Traction test\nLubricant\t4102\n\n"
    reading = read(above + "\n".join(block(load, step) for step, load in enumerate((20, 40, 60))))
    assert [run.run_id for run in reading.runs] == ["log:block1", "log:block2", "log:block3"]
    assert [run.set_points["load_n"] for run in reading.runs] == [20.0, 40.0, 60.0]
    assert {run.oil_name for run in reading.runs} == {"4102"}
    assert reading.refusals == []
    assert reading.row_count == 18


@pytest.mark.parametrize("first", ["oil: 4102", "lubricant: 4102"])
def test_oil_of_a_block_is_its_own_whatever_its_line_is_called(first: str) -> None:
    text = f"# {first}\n" + block(20, 1) + "# Lube\t4050\n" + block(40, 2)
    assert [run.oil_name for run in read(text).runs] == ["4102", "4050"]


@pytest.mark.parametrize("write", [formats.lvm, formats.tdms, formats.as_parquet])
def test_keys_of_one_meaning_and_two_oils_refuse_the_log(write: Callable[..., bytes]) -> None:
    _, reading = read_log(write(VALUES, keys={"oil": "4102", "Oil": "4050"}), "log", CONFIG)
    assert (reading.runs, [refusal.rule for refusal in reading.refusals]) == ([], ["unknown_oil"])


@pytest.mark.parametrize("header", ["# oil: 4102\n# lubricant: 4050", "# lube: 4050\n# Öl: 4102"])
def test_header_lines_that_name_two_oils_of_the_campaign_refuse_the_log(header: str) -> None:
    reading = read(csv({}, header))
    assert (reading.runs, [refusal.rule for refusal in reading.refusals]) == ([], ["unknown_oil"])


def test_empty_header_lines_name_no_oil_and_no_rig() -> None:
    (run,) = read(csv({}, "# oil:\n# rig:\n# lubricant: 4102")).runs
    assert (run.oil_name, run.rig_name) == ("4102", next(iter(CONFIG.rigs)))
    groups = [formats.GroupObject("a", {"oil": ""}), formats.GroupObject("b", {"Oil": "4050"})]
    channels = [channel for name in "ab" for channel in formats.tdms_channels(name, VALUES)]
    content = formats.tdms_file([formats.RootObject({"oil": "4102"}), *groups, *channels])
    assert [run.oil_name for run in read(content, "tdms").runs] == ["4102", "4050"]


def test_header_line_that_describes_the_oil_contradicts_nothing() -> None:
    (run,) = read(csv({}, "# oil: 4102\n# oil_type: mineral\n# lubricant: 4102")).runs
    assert run.oil_name == "4102"


def test_oil_of_a_segment_or_group_is_its_own_whatever_its_line_is_called() -> None:
    lines = formats.lvm_header({"oil": "4102"})
    lines += formats.lvm_segment(VALUES, formats.UNITS, ".", "lubricant: 4050")
    lines += formats.lvm_segment(VALUES, formats.UNITS, ".")
    assert [run.oil_name for run in read("\n".join(lines), "lvm").runs] == ["4050", "4102"]
    groups = [formats.GroupObject("a", {"lubricant": "4050"}), formats.GroupObject("b")]
    channels = [channel for name in "ab" for channel in formats.tdms_channels(name, VALUES)]
    content = formats.tdms_file([formats.RootObject({"oil": "4102"}), *groups, *channels])
    assert [run.oil_name for run in read(content, "tdms").runs] == ["4050", "4102"]


def test_set_point_of_the_first_block_is_not_that_of_a_block_without_one() -> None:
    without = block(0, 2).replace("Load (N)\t0\n", "")
    runs = read("Lubricant\t4102\n" + block(20, 1) + without + block(60, 3)).runs
    assert [run.set_points.get("load_n") for run in runs] == [20.0, None, 60.0]


def test_names_that_a_logger_repeats_while_time_goes_on_begin_no_run() -> None:
    log = csv({}, "# oil: 4102")
    lines = log.splitlines(keepends=True)
    reading = read("".join([*lines[:22], lines[1], *lines[22:]]))
    (run,) = reading.runs
    assert len(run) == ROWS
    assert [refusal.rule for refusal in reading.refusals] == ["unreadable_row"]


DAMAGED_ROWS = ["0.36,--,--,--,--,--\n", "0.36,,,,,\n", "--,--,--,--,10.1,70.0\n"]


@pytest.mark.parametrize("damaged", DAMAGED_ROWS)
def test_damaged_row_above_repeated_names_is_refused_and_begins_no_run(damaged: str) -> None:
    lines = csv({}, "# oil: 4102").splitlines(keepends=True)
    reading = read("".join([*lines[:20], damaged, lines[1], *lines[21:]]))
    (run,) = reading.runs
    (refusal,) = reading.refusals
    # rows 19 and 20: the damaged row and the names
    assert (refusal.rule, refusal.first_row, refusal.last_row) == ("unreadable_row", 19, 20)
    assert (len(run), reading.row_count) == (ROWS - 1, ROWS + 1)


@pytest.mark.parametrize("damaged", DAMAGED_ROWS)
def test_damaged_row_at_the_end_of_a_block_is_refused(damaged: str) -> None:
    log = csv({}, "# oil: 4102")
    names = log.splitlines(keepends=True)[1]
    reading = read(log + damaged + log[log.index(names) :])
    assert [len(run) for run in reading.runs] == [ROWS, ROWS]
    assert reading.row_count == 2 * ROWS + 1
    refused = [refusal for refusal in reading.refusals if refusal.refused_rows]
    assert [(refusal.first_row, refusal.last_row) for refusal in refused] == [(ROWS + 1, ROWS + 1)]


@pytest.mark.parametrize(
    "names", [["A", "A", "A-2"], ["A-2", "A", "A"], ["A"] * 4, ["A", "A-2", "A-2", "A"]]
)
def test_repeated_names_of_runs_become_distinct(names: list[str]) -> None:
    distinct = distinct_names(names)
    assert len(set(distinct)) == len(names)
    assert distinct_names(["A"] * 3) == ["A", "A-2", "A-3"]
    # the first run of a name keeps it
    assert all(distinct[names.index(name)] == name for name in names)


# ---------------------------------------------------------------- last row, doubled columns


def with_decimals(above: str = "# oil: 4102") -> str:
    lines = [above, ",".join(f"{name} [{formats.UNITS[name]}]" for name in VALUES)]
    rows = np.column_stack(list(VALUES.values()))
    lines += [",".join(f"{number:.3f}" for number in row) for row in rows]
    return "\n".join(lines)


def test_complete_last_row_without_a_line_end_is_used_with_a_note() -> None:
    reading = read(with_decimals())
    assert len(reading.runs[0]) == ROWS
    assert [refusal.rule for refusal in reading.refusals] == [READING_NOTE]


@pytest.mark.parametrize("cut", [1, 2, 3, 4, 5])
def test_last_row_whose_number_is_cut_is_refused(cut: int) -> None:
    reading = read(with_decimals()[:-cut])
    assert len(reading.runs[0]) == ROWS - 1
    assert reading.refusals[-1].rule in ("unterminated_row", "cut_row")


def test_last_row_of_settled_readings_is_used() -> None:
    # numbers without trailing zeros: the last one is no shorter than the shortest above it
    log = csv({}, "# oil: 4102\n# log_kind: steps").removesuffix("\n")
    assert len(read(log).runs[0]) == ROWS


def test_column_that_is_there_twice_is_used_once() -> None:
    log = with_decimals() + "\n"
    lines = log.splitlines()
    twice = [line if line.startswith("#") else f"{line},{line.split(',')[1]}" for line in lines]
    reading = read("\n".join(twice) + "\n")
    assert len(reading.runs[0]) == ROWS
    assert "same numbers" in reading.refusals[0].reason
    different = "\n".join([*twice[:-1], twice[-1] + "1"]) + "\n"
    assert "hold different numbers" in read(different).refusals[0].reason


@pytest.mark.parametrize(
    ("row_counts", "run_count"), [((4, 2, 4), 3), ((4, 1, 4), 3), ((1, 1, 1, 1), 1), ((2, 2), 1)]
)
def test_short_run_of_settled_readings_is_a_run(
    row_counts: tuple[int, ...], run_count: int
) -> None:
    """A column that counts the readings names no runs."""
    names = "Run,load_n,traction_coefficient,entrainment_speed_m_s,slide_roll_ratio"
    log = f"# oil: 4102\n# log_kind: steps\n{names},inlet_temperature_c\n"
    for number, row_count in enumerate(row_counts):
        log += "".join(
            f"R{number},50.0,{0.01 * row},2.0,{0.01 * row},{40 + 30 * number}\n"
            for row in range(row_count)
        )
    assert len({run.run_id.partition(" ")[0] for run in read(log).runs if "R" in run.run_id}) == (
        run_count if run_count > 1 else 0
    )


def test_column_that_is_there_in_two_units_is_used_once() -> None:
    lines = with_decimals().splitlines()
    start = next(index for index, line in enumerate(lines) if not line.startswith("#"))
    loads = [line.split(",")[1] for line in lines[start + 1 :]]
    in_gf = ["Load [gf]", *(f"{1000 * float(load):.12g}" for load in loads)]
    twice = [f"{line},{cell}" for line, cell in zip(lines[start:], in_gf, strict=True)]
    reading = read("\n".join([*lines[:start], *twice]) + "\n")
    assert len(reading.runs[0]) == ROWS
    assert "same numbers" in reading.refusals[0].reason
    other = "\n".join([*lines[:start], *twice[:-1], twice[-1] + "1"]) + "\n"
    assert "hold different numbers" in read(other).refusals[0].reason


def test_parquet_columns_of_one_name_and_different_numbers_are_refused() -> None:
    table = formats.table(VALUES)
    field = table.schema.field("load")
    other = table.append_column(field, arrow.array(VALUES["load"] + 1))
    (refusal,) = read(formats.parquet_file(other), "parquet").refusals
    assert "hold different numbers" in refusal.reason


def test_rows_of_a_log_with_zeros_near_its_top_are_counted() -> None:
    content = with_decimals().encode() + b"\n"
    damaged = content[:150] + bytes(64) + content[214:]
    reading = read(damaged)
    assert reading.row_count >= ROWS - 2
    kept = sum(len(run) for run in reading.runs)
    assert kept + sum(refusal.refused_rows for refusal in reading.refusals) == reading.row_count


def test_short_last_number_is_cut_even_where_a_cell_above_it_is_empty() -> None:
    log = with_whole_numbers(["12345"] * 9 + [""] + ["12345"] * 9 + ["123"])
    reading = read(log)
    assert len(reading.runs[0]) == 18
    assert [refusal.first_row for refusal in reading.refusals] == [10, 20]
    assert reading.refusals[1].rule == "unterminated_row"


def with_whole_numbers(last_cells: list[str]) -> str:
    """A csv log without a last line end, whose last column has these cells."""
    names = list(VALUES)
    names.append(names.pop(names.index("ball_speed")))
    lines = ["# oil: 4102", ",".join(f"{name} [{formats.UNITS[name]}]" for name in names)]
    for row, cell in enumerate(last_cells):
        lines.append(",".join([*(f"{VALUES[name][row]:.3f}" for name in names[:-1]), cell]))
    return "\n".join(lines)


# ---------------------------------------------------------------- change of set point

RATE_HZ = 10
HOLD_S = 3


def sweep(load_n: float, speed_m_s: float) -> dict[str, np.ndarray]:
    """A sweep of slip at one load and speed, with pure rolling before and after it."""
    slip = np.repeat([0.0, 0.0, 0.02, 0.06, 0.12, 0.2, 0.0, 0.0], HOLD_S * RATE_HZ)
    random = np.random.default_rng(int(load_n))
    load = load_n * (1 + 0.003 * random.standard_normal(len(slip)))
    return {
        "load": load,
        "traction_force": load * 0.05 * np.tanh(slip / 0.02),
        "entrainment_speed": np.full(len(slip), speed_m_s),
        "slide_roll_ratio": slip,
        "inlet_temperature": np.full(len(slip), 60.0),
    }


def swept(*sweeps: dict[str, np.ndarray]) -> str:
    joined = {name: np.concatenate([part[name] for part in sweeps]) for name in sweeps[0]}
    units = ["s", "N", "N", "m/s", "1", "degC"]
    time = np.arange(len(joined["load"])) / RATE_HZ
    names = [f"{name} [{unit}]" for name, unit in zip(["time", *joined], units, strict=True)]
    rows = np.column_stack([time, *joined.values()])
    return (
        "\n".join(
            ["# oil: 4102", ",".join(names), *(",".join(map(repr, row.tolist())) for row in rows)]
        )
        + "\n"
    )


SET_POINTS = {
    "two loads": ((20, 10), (32, 10)),
    "two speeds": ((20, 12), (20, 21.6)),
    "three loads": ((20, 10), (32, 10), (50, 10)),
    "both": ((20, 5), (30, 8)),
}


@pytest.mark.parametrize("set_points", SET_POINTS.values(), ids=SET_POINTS)
def test_each_set_point_of_a_log_is_a_run(set_points: tuple[tuple[float, float], ...]) -> None:
    parts = [sweep(*set_point) for set_point in set_points]
    reading = read(swept(*parts))
    assert [run.run_id for run in reading.runs] == [
        f"log:setpoint{number}" for number in range(1, 1 + len(parts))
    ]
    for run, (load, speed) in zip(reading.runs, set_points, strict=True):
        assert len(run) == len(parts[0]["load"])
        assert np.median(run.samples["load_n"]) == pytest.approx(load, rel=0.01)
        mean_speed = (run.samples["ball_speed_m_s"] + run.samples["disc_speed_m_s"]) / 2
        assert np.median(mean_speed) == pytest.approx(speed, rel=0.01)
    assert {refusal.rule for refusal in reading.refusals} == {READING_NOTE}


@pytest.mark.parametrize("row_count", [60, 1000, 30_000])
@pytest.mark.parametrize("shift", [0, 1, 42, 57, 99])
def test_set_point_changes_at_its_row_however_long_the_log_is(row_count: int, shift: int) -> None:
    change = row_count // 2 + min(shift, row_count // 10)
    random = np.random.default_rng(shift)
    slip = np.concatenate([np.linspace(0, 0.1, change), np.linspace(0, 0.1, row_count - change)])
    load = np.where(np.arange(row_count) < change, 50.0, 56.0)
    load *= 1 + 0.005 * random.standard_normal(row_count)
    samples = {
        "row": np.arange(1, row_count + 1),
        "load_n": load,
        "ball_speed_m_s": 10 * (1 - slip / 2),
        "disc_speed_m_s": 10 * (1 + slip / 2),
    }
    run = LoggedRun("run", "4102", "rig", "continuous", {}, samples)
    first, second = row_indices_of_set_points(run)
    assert (len(first), len(second)) == (change, row_count - change)


@pytest.mark.parametrize("rows_at_once", [1, 150, 10**6])
def test_set_points_are_the_same_in_parts_of_any_length(
    monkeypatch: pytest.MonkeyPatch, rows_at_once: int
) -> None:
    # 30 040 rows in blocks of 101 rows: 150 is no multiple of it, and the last block is shorter
    monkeypatch.setattr(set_point_changes, "_ROWS_AT_ONCE", rows_at_once)
    rows_of_set_points = [9_000, 12_000, 9_040]
    slip = np.concatenate([np.linspace(0, 0.1, rows) for rows in rows_of_set_points])
    samples = {
        "load_n": np.repeat([50.0, 60.0, 40.0], rows_of_set_points),
        "ball_speed_m_s": 10 * (1 - slip / 2),
        "disc_speed_m_s": 10 * (1 + slip / 2),
    }
    run = LoggedRun("run", "4102", "rig", "continuous", {}, samples | {"row": np.arange(len(slip))})
    assert list(map(len, row_indices_of_set_points(run))) == rows_of_set_points


def speed_by_slip(part: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The disc at constant speed, the ball slowed: the mean speed falls with the slip."""
    return part | {"entrainment_speed": 10 / (1 + part["slide_roll_ratio"] / 2)}


def loaded_at_first(part: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The contact is loaded within the first second."""
    load = part["load"].copy()
    load[:RATE_HZ] *= np.linspace(0.1, 1, RATE_HZ)
    return part | {"load": load}


def drifting(part: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    return part | {"load": part["load"] * np.linspace(1, 1.3, len(part["load"]))}


@pytest.mark.parametrize("change", [dict, speed_by_slip, loaded_at_first, drifting])
def test_log_at_one_set_point_stays_one_run(
    change: Callable[[dict[str, np.ndarray]], dict[str, np.ndarray]],
) -> None:
    (run,) = read(swept(change(sweep(20, 10)))).runs
    assert run.run_id == "log"


def test_settled_readings_at_several_loads_are_several_runs() -> None:
    slips = np.array([0.8, 1.5, 2.5, 4, 6, 9, 13, 18, 24, 30])
    names = "load [N],traction_coefficient,entrainment_speed [m/s],slide_roll_ratio [%]"
    lines = ["# oil: 4102", "# log_kind: steps", f"{names},inlet_temperature [degC]"]
    for load in (40, 80):
        lines += [f"{load},{0.04 + slip / 1e4:.4f},8,{slip:g},65" for slip in slips]
    runs = read("\n".join(lines) + "\n").runs
    assert [run.samples["load_n"].tolist() for run in runs] == [[40.0] * 10, [80.0] * 10]


@pytest.mark.parametrize(("interval_s", "is_named"), [(11.0, True), (0.02, False)])
def test_settled_readings_that_are_not_called_so_are_named(
    interval_s: float, is_named: bool
) -> None:
    slips = np.array([0.8, 1.5, 2.5, 4, 6, 9, 13, 18, 24, 30])
    names = "time [s],load [N],traction_coefficient [1],entrainment_speed [m/s]"
    lines = ["# oil: 4102", f"{names},slide_roll_ratio [%],inlet_temperature [degC]"]
    for row, slip in enumerate(slips):
        lines.append(f"{interval_s * row:g},40,{0.04 + slip / 1e4:.4f},8,{slip:g},65")
    (run,) = read("\n".join(lines) + "\n").runs
    assert (run.refusal is not None and run.refusal.rule == "settled_readings") == is_named
    (steps,) = read("\n".join(["# log_kind: steps", *lines]) + "\n").runs
    assert steps.refusal is None


def test_names_in_a_comment_are_shown_where_they_are_not_known() -> None:
    reading = read("# load_N,rolling_coefficient\n80,0.05\n81,0.06\n")
    assert "load_N,rolling_coefficient" in reading.refusals[0].reason
