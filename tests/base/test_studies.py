"""What a package beside oilfilm declares."""

from argparse import Namespace
from pathlib import Path
from types import SimpleNamespace

import pytest

from oilfilm.base import home, studies
from oilfilm.base.errors import OilfilmError
from oilfilm.base.figure_catalogue import figures
from oilfilm.cli import export


def test_tables_of_two_entries_with_the_same_needs_are_all_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    entries = [{"needs": ["twin"], "names": ["a"]}, {"needs": ["twin"], "names": ["b", "c"]}]
    monkeypatch.setattr(studies, "_package_declaration", lambda package_name: {"tables": entries})
    assert studies.table_names_by_need("own") == {("twin",): ("a", "b", "c")}


def test_published_law_is_that_of_the_study_that_has_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    content_by_package = {"own_study": "", "printing_study": "def printed(oil):\n    return oil\n"}
    for package, content in content_by_package.items():
        (tmp_path / package).mkdir()
        (tmp_path / package / "__init__.py").write_text(content)
    monkeypatch.syspath_prepend(tmp_path)
    files = [tmp_path / package / "study.py" for package in content_by_package]
    monkeypatch.setattr(studies, "study_files", lambda package_names: files)
    assert studies.published_law("4102") == "4102"
    del files[1]
    with pytest.raises(OilfilmError, match="no study has published constants"):
        studies.published_law("4102")


def test_published_constants_of_every_study_are_exported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "constants.yaml").write_text("a: 1\n")

    def study(*oils: str) -> SimpleNamespace:
        descriptions = [SimpleNamespace(oil=oil) for oil in oils]
        return SimpleNamespace(
            describe_published=lambda: (descriptions, tmp_path / "constants.yaml")
        )

    without_constants = SimpleNamespace(describe_published=None)
    loaded = [without_constants, study("4102"), study("4050", "4010")]
    monkeypatch.setattr(studies, "load_studies", lambda package_names: loaded)
    monkeypatch.setattr(
        export, "export_oils", lambda described, provenance: {one.oil: b"" for one in described}
    )
    export.run(Namespace(oil=None, folder=tmp_path / "exported"))
    names = sorted(file.name for file in (tmp_path / "exported").iterdir())
    assert names == ["4010", "4050", "4102"]


def test_every_reference_file_of_a_figure_is_found_and_read() -> None:
    pytest.importorskip("deng2026_study")
    names = {name for figure in figures().values() for name in figure.references}
    content_by_name = studies.read_references(home.reference_file(name) for name in names)
    assert content_by_name.keys() == names
    # data/reference is shared, and in no folder of a study
    printed = content_by_name["printed_coefficients"].constants_by_oil()
    assert printed["4102"][0] == -0.01567792
