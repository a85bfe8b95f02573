"""A saved fit whose tables somebody altered ends in a result or in a sentence."""

import shutil
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as arrow
import pytest
from pyarrow import parquet

import oilfilm
from known_laws import known_law

Alter = Callable[[arrow.Table], arrow.Table]
# Values of each type that no fit has, or has elsewhere.
NUMBERS = [0.0, -1.0, 1.0, 2.0, 1e-300, 1e-9, 5e3, -1e9, 1e300, np.nan, np.inf, -np.inf]
INTEGERS = [0, -1, 1, 2, 7, 2**62, -(2**63)]
TEXTS = ["", "x", "\x1b[31m", "deng2026", "tanh", "A" * 100_000, "steady", "[]", "{}", "first"]
LISTS: list[list[str]] = [[], ["x"], ["deng2026", "tanh"]]
TYPES = [
    *(arrow.string(), arrow.float32(), arrow.int8(), arrow.bool_(), arrow.binary(), arrow.null()),
    *(arrow.list_(arrow.float64()), arrow.timestamp("ns"), arrow.decimal128(10)),
    arrow.dictionary(arrow.int32(), arrow.string()),
]


@pytest.fixture(scope="module")
def june(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A saved fit with a surface: 18 curves with noise on the printed law of 4102."""
    grids = np.meshgrid([1.0, 1.25, 1.5], [25, 32, 40], [50, 120], np.linspace(0.01, 0.3, 9))
    pressure, speed, temperature, slip = (level.ravel() for level in grids)
    law = known_law("4102")
    mu = oilfilm.predict(law.law, law.coefficients, pressure, speed, temperature, slip)
    noise = 1 + 3e-3 * np.random.default_rng(7).standard_normal(len(slip))
    readings = mu.traction_coefficient * noise
    fit = oilfilm.fit(pressure, speed, temperature, slip, readings, searches=2, bootstrap=20)
    folder = tmp_path_factory.mktemp("saved") / "june"
    fit.save(folder)
    return folder


def predicted(folder: Path) -> pd.DataFrame:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        law = oilfilm.read_fit(folder)
        return law.predict_at(1.25, 30, 70, [0.01, 0.05]).to_frame()


def rewritten(file: Path, alter: Alter) -> None:
    parquet.write_table(alter(parquet.read_table(file)), file)


def with_column(column_name: str, values: Callable[[list[Any]], list[Any]]) -> Alter:
    """A table with one column altered; its schema and footer stay."""

    def alter(table: arrow.Table) -> arrow.Table:
        column_index = table.schema.get_field_index(column_name)
        field = table.schema.field(column_index)
        altered_values = arrow.array(values(table.column(column_name).to_pylist()), field.type)
        return table.set_column(column_index, field, altered_values)

    return alter


def all_set_to(name: str, value: Any) -> Alter:
    return with_column(name, lambda old: [value] * len(old))


def without_rows(table: arrow.Table) -> arrow.Table:
    return table.slice(0, 0)


def with_last_row_twice(table: arrow.Table) -> arrow.Table:
    return arrow.concat_tables([table, table.slice(table.num_rows - 1)])


ALTERED: dict[str, tuple[str, Alter]] = {
    "no constants": ("coefficients", without_rows),
    "a constant twice": ("coefficients", with_last_row_twice),
    "two configured laws": ("fit_quality", with_last_row_twice),
    "no verdict": ("soundness", without_rows),
    "two surfaces": ("surfaces", with_last_row_twice),
    "surface of no law": ("surfaces", all_set_to("law", "x")),
    "constant of zero": ("coefficients", all_set_to("value", 0.0)),
    "tiny constant": ("coefficients", all_set_to("value", 1e-320)),
    "constant of the other sign": ("coefficients", all_set_to("value", -1.0)),
    "refit of the other sign": ("refits", all_set_to("value", -1.0)),
    "unknown constant": ("coefficients", all_set_to("constant", "x")),
    "limit of zero": ("surfaces", all_set_to("largest_spread", 0.0)),
    "sizes out of range": ("surface_sizes", all_set_to("logarithm", 5e3)),
    "no sizes": ("surface_sizes", without_rows),
    "no points": ("points", without_rows),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", ALTERED)
def test_tables_that_contradict_each_other_end_in_a_sentence_of_their_folder(
    case: str, june: Path, tmp_path: Path
) -> None:
    table_name, alter = ALTERED[case]
    copied_fit = Path(shutil.copytree(june, tmp_path / "copy"))
    rewritten(copied_fit / f"tables/{table_name}.parquet", alter)
    with pytest.raises(oilfilm.OilfilmError) as refused:
        predicted(copied_fit)
    assert str(copied_fit) in str(refused.value)
    assert len(str(refused.value)) < 3000
    assert str(refused.value).isprintable()


def values_of(column_type: arrow.DataType) -> list[Any]:
    if arrow.types.is_floating(column_type):
        return NUMBERS
    if arrow.types.is_integer(column_type):
        return INTEGERS
    if arrow.types.is_boolean(column_type):
        return [True, False]
    return LISTS if arrow.types.is_list(column_type) else TEXTS


def other_form(table: arrow.Table, rng: np.random.Generator) -> arrow.Table:
    """The table with a column of another name, of another type or twice, or with another footer."""
    index = int(rng.integers(table.num_columns))
    name = table.column_names[index]
    kind = rng.integers(4)
    if kind == 0:
        names = [*table.column_names]
        names[index] = TEXTS[int(rng.integers(len(TEXTS)))]
        return table.rename_columns(names)
    if kind == 1:
        other = TYPES[int(rng.integers(len(TYPES)))]
        return table.set_column(index, name, arrow.nulls(table.num_rows, other))
    if kind == 2:
        return table.append_column(name, table.column(index))
    return table.replace_schema_metadata({b"oilfilm": rng.bytes(20)})


def some_alteration(table: arrow.Table, rng: np.random.Generator) -> arrow.Table:
    """The table with rows left out, repeated or in another order, or with a column altered."""
    row_count = table.num_rows
    alteration = rng.integers(15)
    if alteration >= 12:
        return other_form(table, rng)
    if alteration == 0:
        return table.take(arrow.array(rng.permutation(row_count)))
    if alteration == 1:
        return table.take(arrow.array(np.flatnonzero(rng.random(row_count) < 0.5)))
    if alteration == 2:
        return arrow.concat_tables([table, table.slice(int(rng.integers(max(row_count, 1))), 1)])
    column_index = int(rng.integers(table.num_columns))
    field = table.schema.field(column_index)
    if alteration == 3:
        return table.remove_column(column_index)
    choices = [None, *values_of(field.type)]
    value = choices[int(rng.integers(len(choices)))]
    share = rng.choice([0.1, 1.0])
    values = table.column(column_index).to_pylist()
    for row in np.flatnonzero(rng.random(row_count) <= share):
        values[row] = value
    return table.set_column(column_index, field, arrow.array(values, field.type))


def alter_and_predict(june: Path, folder: Path, alterations: range) -> int:
    """Alter one table after the other; how many ended in a sentence."""
    copied_fit = Path(shutil.copytree(june, folder / "copy"))
    table_files = sorted((june / "tables").glob("*.parquet"))
    refused_count = 0
    for seed in alterations:
        rng = np.random.default_rng(seed)
        original_file = table_files[int(rng.integers(len(table_files)))]
        altered_file = copied_fit / "tables" / original_file.name
        parquet.write_table(some_alteration(parquet.read_table(original_file), rng), altered_file)
        try:
            predicted(copied_fit)
        except oilfilm.OilfilmError:
            refused_count += 1
        shutil.copy(original_file, altered_file)
    return refused_count


@pytest.mark.slow
def test_altered_schema_ends_in_a_result_or_a_sentence(june: Path, tmp_path: Path) -> None:
    assert alter_and_predict(june, tmp_path, range(10))


@pytest.mark.nightly
def test_a_thousand_altered_schemas_end_in_a_result_or_a_sentence(
    june: Path, tmp_path: Path
) -> None:
    assert alter_and_predict(june, tmp_path, range(1000, 2000))
