"""Columns are declared once, with units that a program can read; every table has its key."""

from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pint
import pytest
import yaml

import oilfilm
from oilfilm import tables
from oilfilm.base import studies
from oilfilm.base.errors import OilfilmError
from oilfilm.tables import dictionary
from oilfilm.tables.declaration import PHYSICAL_UNITS
from oilfilm.tables.dictionary import COLUMNS, TABLES, declare
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
    for unit in PHYSICAL_UNITS:
        registry.parse_units(unit)
    for column in tables.COLUMNS.values():
        name = column.name.removesuffix("_se")
        endings = [ending for ending in ENDINGS if name.endswith(ending)]
        if column.type == "number" and endings:
            assert column.unit == ENDINGS[max(endings, key=len)], column.name


@pytest.mark.parametrize("model", tables.TABLES.values(), ids=tables.TABLES)
def test_table_has_a_key_or_says_why_not(model: tables.Table) -> None:
    assert bool(model.key) != bool(model.no_key)
    assert set(model.key) <= set(model.column_names)
    for other, columns in model.references.items():
        assert tables.TABLES[other].key == columns
        assert set(columns) <= set(model.column_names)


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


@pytest.mark.slow
@pytest.mark.parametrize("model", tables.TABLES.values(), ids=tables.TABLES)
def test_every_column_has_an_example_that_its_declaration_allows(model: tables.Table) -> None:
    """`make schemas RESULTS="results/demo results/thermal results/etm-slim"` renews them."""
    shown = read_examples().get(model.name, {})
    assert list(shown) == model.column_names
    # no example: no finished table had a value, so the column must be one that may be empty
    empty = {"text": "", "texts": []}
    row = {
        name: empty.get(model[name].type) if value is None else value
        for name, value in shown.items()
    }
    # a list of JSON is a tuple in a table; a text is none
    lists = {name: tuple(value) for name, value in row.items() if isinstance(value, list)}
    model.schema.validate(pd.DataFrame([row | lists]), lazy=True)


DECLARED = """columns:
  colour:
    type: text
    meaning: colour of the oil
tables:
  colours:
    description: One oil and its colour.
    key: [oil]
    columns:
      - oil
      - colour
    in_this_table:
      colour:
        note: by daylight
"""


@pytest.fixture
def declared_as(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Path]:
    """Write a declaration to a file; what it declares is forgotten after the test."""
    monkeypatch.setattr("oilfilm.tables.dictionary.COLUMNS", dict(COLUMNS))
    monkeypatch.setattr("oilfilm.tables.dictionary.TABLES", dict(TABLES))
    path = tmp_path / "declared.yaml"

    def write(text: str) -> Path:
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_column_of_a_table_has_its_declaration_and_what_the_table_adds(
    declared_as: Callable[[str], Path],
) -> None:
    declare(declared_as(DECLARED))
    colours = dictionary.TABLES["colours"]
    assert colours.column_names == ["oil", "colour"]
    assert colours["colour"].meaning_here == "colour of the oil; by daylight"
    assert colours["oil"] == COLUMNS["oil"]


@pytest.mark.parametrize(
    ("old", "new", "line", "named"),
    [
        ("meaning: colour", "meening: colour", 4, "meening"),
        ("type: text", "type: words", 3, "words"),
        ("type: text", "unit: ft", 3, "ft"),
        ("    type: text\n", "", 2, "unit"),
        ("type: text", "type: count\n    unit: N", 4, "unit"),
        ("      - colour", "      - color", 11, "color"),
        ("key: [oil]", "key: [run_id]", 8, "run_id"),
        ("      colour:\n        note", "      row:\n        note", 13, "row"),
        ("  colour:\n    type", "  oil:\n    type", 2, "oil"),
        ("  colours:\n", "  runs:\n", 6, "runs"),
        ("    key: [oil]", "    column_sets: [grease]", 8, "grease"),
    ],
)
def test_mistake_in_a_declaration_is_told_with_file_line_and_name(
    declared_as: Callable[[str], Path], old: str, new: str, line: int, named: str
) -> None:
    assert old in DECLARED
    path = declared_as(DECLARED.replace(old, new, 1))
    with pytest.raises(OilfilmError) as mistake:
        declare(path)
    assert str(mistake.value).startswith((f"{path}, line {line}:", f"{path}, line {line},"))
    assert named in str(mistake.value)
