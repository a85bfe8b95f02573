"""Which changes of a declaration make a table again."""

from types import SimpleNamespace
from typing import Any

import pytest

from oilfilm.tables.contract import contract_digest
from oilfilm.tables.dictionary import TABLES

DECLARED = {
    **{"name": "load_n", "dtype": "float64", "unit": "N", "nullable": True},
    **{"at_least": 0.0, "at_most": None, "allowed": ()},
    **{"meaning": "normal load", "caveat": "", "note": ""},
}


def digest(monkeypatch: pytest.MonkeyPatch, *columns: dict[str, Any]) -> str:
    """Digest of a table with these columns."""
    declared = [SimpleNamespace(**DECLARED | column) for column in columns]
    monkeypatch.setitem(TABLES, "runs", SimpleNamespace(name="runs", columns=declared))
    return contract_digest(["runs"])


@pytest.mark.parametrize(
    ("change", "again"),
    [
        ({"name": "axial_load_n"}, True),
        ({"dtype": "int64"}, True),
        ({"unit": "kN"}, True),
        ({"nullable": False}, True),
        ({"at_least": None}, True),
        ({"at_most": 1e3}, True),
        ({"allowed": ("a", "b")}, True),
        ({"meaning": "load of the contact"}, False),
        ({"caveat": "calibration is not included"}, False),
        ({"note": "mean over the plateau"}, False),
    ],
)
def test_values_that_a_column_may_hold_count_and_words_do_not(
    monkeypatch: pytest.MonkeyPatch, change: dict[str, Any], again: bool
) -> None:
    assert (digest(monkeypatch, change) != digest(monkeypatch, {})) == again


def test_added_column_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    assert digest(monkeypatch, {}, {"name": "mu"}) != digest(monkeypatch, {})


def test_outputs_that_are_no_tables_do_not_count() -> None:
    assert contract_digest(["runs", "logs", "made"]) == contract_digest(["runs"])
    assert contract_digest(["torque_quarantine"]) == contract_digest(["quarantine"])
