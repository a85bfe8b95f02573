"""MATLAB files in the forms that laboratories save; what cannot be read says so at once."""

import io
import struct
import zlib
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat

import formats
from allocations import peak_bytes

ROWS = 30
VALUES = formats.columns(ROWS)
# names with the unit in them, as MATLAB allows them
NAMED = {
    "time_s": VALUES["time"],
    "load_n": VALUES["load"],
    "traction_force_n": VALUES["traction_force"],
    "ball_speed_rpm": VALUES["ball_speed"],
    "disc_speed_rpm": VALUES["disc_speed"],
    "inlet_temperature_c": VALUES["inlet_temperature"] - 273.15,
}
NAMES = np.array([f"{name} ({formats.UNITS[name]})" for name in VALUES], dtype=object)
MATRIX = np.column_stack(list(VALUES.values()))


def mat(variables: dict[str, Any], **options: Any) -> bytes:
    buffer = io.BytesIO()
    savemat(buffer, variables, **options)
    return buffer.getvalue()


FORMS = {
    "vectors": {**NAMED, "oil": "4102"},
    "rows": {"oil": "4102", **{name: column[np.newaxis] for name, column in NAMED.items()}},
    "structure": {"log": {**NAMED, "oil": "4102"}},
    "structure beside its oil": {"log": NAMED, "oil": "4102"},
    "integers": {**NAMED, "time_s": np.arange(ROWS), "oil": "4102"},
}


@pytest.mark.parametrize("compressed", [False, True])
@pytest.mark.parametrize("variables", FORMS.values(), ids=FORMS)
def test_form_of_a_log_is_read(read, variables: dict[str, Any], compressed: bool) -> None:
    reading = read(mat(variables, do_compression=compressed))
    (run,) = reading.runs
    assert (run.run_id, run.oil_name, len(run)) == ("log", "4102", ROWS)
    np.testing.assert_allclose(run.samples["load_n"], VALUES["load"])
    assert reading.refusals == []


def with_units(vectors: dict[str, Any], units: list[str]) -> bytes:
    beside = {"units": np.array(units, dtype=object), "oil": "4102"}
    return mat({**vectors, **beside}, oned_as="column")


RUNS = np.array(["A"] * 15 + ["B"] * 15, dtype=object)
HEATER = {"heater": np.arange(3.0)}
UNITS = list(formats.UNITS.values())


@pytest.mark.parametrize(
    ("vectors", "units"),
    [
        ({**VALUES, "Run": RUNS}, UNITS),
        ({"Run": RUNS, **VALUES}, ["", *UNITS]),
        ({**HEATER, **VALUES}, ["W", *UNITS]),
        ({**HEATER, **VALUES}, UNITS),
        ({**HEATER, "Run": RUNS, **VALUES}, ["W", "", *UNITS]),
        ({name: column[:6] for name, column in VALUES.items()}, UNITS),
    ],
    ids=["text", "text with a unit", "other length", "table only", "both", "rows as many as units"],
)
def test_units_are_those_of_the_vectors(read, vectors: dict[str, Any], units: list[str]) -> None:
    runs = read(with_units(vectors, units)).runs
    load = np.concatenate([run.samples["load_n"] for run in runs])
    np.testing.assert_allclose(load, vectors["load"] * 9.80665)


def test_units_that_may_be_those_of_two_sets_of_vectors_are_not_used(read) -> None:
    # those of the columns with the text, or of the vectors of numbers
    reading = read(with_units({**HEATER, **VALUES, "Run": RUNS}, ["W", *UNITS]))
    assert reading.runs == []
    assert all("has no unit" in refusal.reason for refusal in reading.refusals)


@pytest.mark.parametrize("name", ["colheaders", "names"])
def test_matrix_with_names_of_its_columns_is_read(read, name: str) -> None:
    for log in (
        {"data": MATRIX, name: NAMES, "oil": "4102"},
        {"log": {"data": MATRIX, name: NAMES, "oil": "4102"}},
        {
            "data": MATRIX,
            name: np.array(list(VALUES), dtype=object),
            "units": np.array([formats.UNITS[quantity] for quantity in VALUES], dtype=object),
            "oil": "4102",
        },
    ):
        (run,) = read(mat(log)).runs
        np.testing.assert_allclose(run.samples["load_n"], VALUES["load"] * 9.80665)


@pytest.mark.parametrize(
    "beside",
    [
        {"load_limits": [0.0, 50], "slip_range": [0, 0.5]},
        {f"limits_{number}": [0.0, 50] for number in range(7)},
        {"mu": MATRIX[:, 2] / MATRIX[:, 1], "slip": np.zeros(ROWS)},
    ],
    ids=["two short vectors", "more than columns", "two long vectors"],
)
def test_vectors_beside_a_larger_matrix_do_not_hide_it(read, beside: dict[str, Any]) -> None:
    (run,) = read(mat({**beside, "data": MATRIX, "colheaders": NAMES, "oil": "4102"})).runs
    np.testing.assert_allclose(run.samples["load_n"], VALUES["load"] * 9.80665)


def test_longest_of_equally_many_vectors_are_the_table(read) -> None:
    short = {f"limits_{number}": [0.0, 50] for number in range(len(NAMED))}
    logs = {**short, **NAMED}, {**NAMED, **short}
    assert [len(read(mat({**log, "oil": "4102"})).runs[0]) for log in logs] == [ROWS, ROWS]


def test_units_of_a_matrix_are_those_of_its_columns_whatever_cells_are_beside_it(read) -> None:
    # with the names there are as many cell arrays as columns
    cells = {f"textdata_{number}": ["a", "b"] for number in range(5)}
    cells |= {"colheaders": list(VALUES), "units": UNITS}
    beside = {name: np.array(texts, dtype=object) for name, texts in cells.items()}
    (run,) = read(mat({**beside, "data": MATRIX, "oil": "4102"})).runs
    np.testing.assert_allclose(run.samples["load_n"], VALUES["load"] * 9.80665)


@pytest.mark.parametrize("value", [np.nan, 1.25 + 0.1j])
def test_number_that_is_not_known_or_not_real_is_no_header_key(read, value: complex) -> None:
    (run,) = read(mat({**NAMED, "oil": "4102", "max_hertz_pressure_gpa": value})).runs
    assert run.set_points.get("max_hertz_pressure_gpa") is None


def test_structures_and_their_arrays_are_runs(read) -> None:
    first = {**NAMED, "oil": "4102", "load_n_set": 20}
    second = {**{name: column[:10] for name, column in NAMED.items()}, "oil": "4050"}
    runs = read(mat({"a": first, "b": second})).runs
    assert [(run.run_id, run.oil_name, len(run)) for run in runs] == [
        ("log:a", "4102", 30),
        ("log:b", "4050", 10),
    ]
    array = np.array([(NAMED["time_s"], "4102"), (NAMED["time_s"], "4050")], dtype=object)
    both = np.zeros(2, dtype=[(name, object) for name in [*NAMED, "oil"]])
    for index, oil in enumerate(array[:, 1]):
        for name, column in NAMED.items():
            both[name][index] = column
        both["oil"][index] = oil
    runs = read(mat({"run": both})).runs
    assert [(run.run_id, run.oil_name) for run in runs] == [
        ("log:run1", "4102"),
        ("log:run2", "4050"),
    ]


def test_column_of_runs_and_restart_of_time_divide_it(read) -> None:
    labelled = {**NAMED, "run": np.repeat([1, 2, 3], 10), "oil": "4102"}
    assert [run.run_id for run in read(mat(labelled)).runs] == ["log:1", "log:2", "log:3"]
    oils = np.array(["4102", "4050"] * 15, dtype=object)
    assert {run.oil_name for run in read(mat({**NAMED, "oil": oils})).runs} == {"4102", "4050"}
    again = {**NAMED, "time_s": np.tile(np.arange(15) / 50, 2), "oil": "4102"}
    assert [run.run_id for run in read(mat(again)).runs] == ["log:part1", "log:part2"]


def test_row_with_nan_is_refused_with_its_number(read) -> None:
    load = NAMED["load_n"].copy()
    load[4] = np.nan
    (refusal,) = read(mat({**NAMED, "load_n": load, "oil": "4102"})).refusals
    assert (refusal.rule, refusal.first_row, refusal.last_row) == ("unreadable_row", 5, 5)


def test_version_7_3_is_refused_with_what_to_do(read) -> None:
    content = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512, b" ") + b"\x89HDF\r\n\x1a\n"
    (refusal,) = read(content).refusals
    assert refusal.rule == "unknown_format"
    assert "-v7" in refusal.advice


@pytest.mark.parametrize("variables", [{}, {"x": 1.0}, {"picture": np.zeros((5, 7))}, {"t": "a"}])
def test_file_without_a_table_is_refused(read, variables: dict[str, Any]) -> None:
    reading = read(mat(variables))
    assert reading.runs == []
    assert "equal length" in reading.refusals[0].reason


@pytest.mark.slow
def test_small_file_that_would_fill_the_memory_is_refused_at_once(read) -> None:
    packed = zlib.compress(bytes(1 << 28), 9)
    content = mat({})[:128] + struct.pack("<II", 15, len(packed)) + packed
    with peak_bytes() as peak:
        (refusal,) = read(content).refusals
    assert refusal.rule == "too_large"
    assert peak() < 1 << 25


@pytest.mark.parametrize("share", [0.3, 0.6, 0.95])
def test_cut_file_is_refused(read, share: float) -> None:
    content = mat({**NAMED, "oil": "4102"})
    reading = read(content[: int(share * len(content))])
    assert reading.runs == []
    assert reading.refusals[0].rule == "damaged_file"
