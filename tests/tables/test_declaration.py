"""Columns are declared once, with units that a program can read; every table has its key."""

from pathlib import Path

import pandas as pd
import pint
import pytest
import yaml

import oilfilm
from oilfilm import tables
from oilfilm.base import studies
from reference_pages.table_examples import read_examples

studies.declare_tables(studies.available())
USED = {column.name: column for model in tables.TABLES.values() for column in model.columns}
# What the end of a name says to a human; the longest that fits counts.
ENDINGS = {
    **{"_s": "s", "_n": "N", "_m_s": "m/s", "_gpa": "GPa", "_um": "um", "_mm": "mm"},
    **{"_deg": "deg", "_rpm": "rpm", "_mm_rpm": "mm rpm", "_w": "W", "_n_m": "N m"},
    **{"_c": "degC", "_change_c": "K", "_systematic_c": "K"},
}


def test_every_column_is_declared_and_used() -> None:
    assert set(USED) == set(tables.COLUMNS)
    assert all(column.meaning for column in tables.COLUMNS.values())


def test_every_number_has_a_unit_of_the_list() -> None:
    for column in tables.COLUMNS.values():
        if column.type in ("number", "integer"):
            assert column.unit in tables.UNITS, column.name
        else:
            assert column.unit == "", column.name
        if column.unit == tables.BY_ROW:
            assert "unit" in column.caveat, f"{column.name}: its caveat must say which unit"


def test_units_are_of_the_quantity_that_the_name_says() -> None:
    registry = pint.UnitRegistry()
    for unit in tables.UNITS - {"1", tables.BY_ROW}:
        registry.parse_units(unit)
    for column in tables.COLUMNS.values():
        name = column.name.removesuffix("_se")
        endings = [ending for ending in ENDINGS if name.endswith(ending)]
        if column.type == "number" and endings:
            assert column.unit == ENDINGS[max(endings, key=len)], column.name


@pytest.mark.parametrize("model", tables.TABLES.values(), ids=tables.TABLES)
def test_table_has_a_key_or_says_why_not(model: tables.Table) -> None:
    assert bool(model.key) != bool(model.no_key)
    assert set(model.key) <= set(model.names)
    for other, columns in model.references.items():
        assert tables.TABLES[other].key == columns
        assert set(columns) <= set(model.names)


@pytest.mark.parametrize("path", sorted(Path(oilfilm.__file__).parent.glob("*/*.yaml")), ids=str)
def test_no_key_is_given_twice_in_a_declaration(path: Path) -> None:
    nodes = [yaml.compose(path.read_bytes())]
    for node in nodes:
        if isinstance(node, yaml.MappingNode):
            keys = [key.value for key, _ in node.value]
            assert sorted(keys) == sorted({*keys}), path
            nodes += [value for _, value in node.value]
        elif isinstance(node, yaml.SequenceNode):
            nodes += node.value


@pytest.mark.parametrize("model", tables.TABLES.values(), ids=tables.TABLES)
def test_every_column_has_an_example_that_its_declaration_allows(model: tables.Table) -> None:
    """`make schemas RESULTS="results/demo results/thermal results/etm-slim"` renews them."""
    shown = read_examples().get(model.name, {})
    assert list(shown) == model.names
    # no example: no finished table had a value, so the column must be one that may be empty
    row = {
        name: "" if value is None and model[name].type == "text" else value
        for name, value in shown.items()
    }
    model.schema.validate(pd.DataFrame([row]), lazy=True)
