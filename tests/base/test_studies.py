"""What a package beside oilfilm declares."""

import pytest

from oilfilm.base import studies


def test_tables_of_two_entries_with_the_same_needs_are_all_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    entries = [{"needs": ["twin"], "names": ["a"]}, {"needs": ["twin"], "names": ["b", "c"]}]
    monkeypatch.setattr(studies, "_package_declaration", lambda package_name: {"tables": entries})
    assert studies.table_names_by_need("own") == {("twin",): ("a", "b", "c")}
