"""Digests change with what they stand for, and with nothing else."""

import ast
from pathlib import Path

import pytest

from campaigns import ROOT
from oilfilm.base import digests

SCRIPTS = ROOT / "workflow/scripts"


def files_behind(script: str) -> set[str]:
    return {path.stem for path in digests.files_behind(SCRIPTS / script)}


def test_digest_follows_imports_to_the_formulas() -> None:
    assert {"film", "contact", "run_gates", "failed_gates"} <= files_behind("points.py")


@pytest.mark.parametrize(
    ("text", "behind"),
    [
        ("from oilfilm.physics import (\n    film,  # see (3)\n)", {"film"}),
        ("import json, oilfilm.physics.film as film", {"film"}),
        ("def late():\n\tfrom oilfilm.physics import film", {"film"}),
        ("try:\n    x()\nexcept E:\n    from oilfilm.physics import film", {"film"}),
        ("match x:\n    case 1:\n        import oilfilm.physics.film", {"film"}),
        ('"""from oilfilm.physics import film"""', set()),
    ],
)
def test_import_is_found_wherever_it_is(tmp_path: Path, text: str, behind: set[str]) -> None:
    script = tmp_path / "script.py"
    script.write_text(text, encoding="utf-8")
    names_behind = {path.stem for path in digests.files_behind(script)}
    assert (names_behind & {"film", "tanh"}) == behind


def test_digest_is_the_same_in_every_version_of_python() -> None:
    """Python 3.12 has added an empty list to each function and class, 3.8 a field to each text."""
    syntax_words: list[str] = []
    digests._walk(ast.parse("class C: ...\ndef f(): return 'a'"), "", syntax_words, [])
    assert " ".join(syntax_words) == (
        "Module body ClassDef name 'C' body Expr value Constant value Ellipsis ) ) ) "
        "FunctionDef name 'f' args arguments ) body Return value Constant value 'a' ) ) ) )"
    )


@pytest.mark.parametrize(
    ("name", "text", "comment", "other"),
    [
        ("words.yaml", "a: 1\nb: [x, '# y']\n", "# a word\n", "c: 2\n"),
        ("page.mplstyle", "font.size: 8\n", "# a word\n", "grid.color: e5e5e5\n"),
    ],
)
def test_comment_in_a_file_of_data_counts_for_nothing(
    tmp_path: Path, name: str, text: str, comment: str, other: str
) -> None:
    paths = [tmp_path / folder / name for folder in ("plain", "commented", "longer")]
    for path, content in zip(paths, (text, comment + text + comment, text + other), strict=True):
        path.parent.mkdir()
        path.write_text(content, encoding="utf-8")
    plain, commented, longer = (digests.code_digest(SCRIPTS / "enough.py", path) for path in paths)
    assert commented == plain
    assert longer != plain


def test_digest_of_a_folder_knows_names_and_contents(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("1")
    first_digest = digests.path_digest(tmp_path)
    (tmp_path / "a").rename(tmp_path / "b")
    assert digests.path_digest(tmp_path) != first_digest
    # sha256 of the empty message: FIPS 180-4 test vector
    (tmp_path / "empty").touch()
    assert digests.file_digest(tmp_path / "empty").startswith("e3b0c44298fc1c14")
