"""Digests change with what they stand for, and with nothing else."""

import ast
from pathlib import Path

import pytest

from oilfilm import digests

WORKFLOW = Path(__file__).parents[2] / "workflow"
SCRIPTS = WORKFLOW / "scripts"


def modules_behind(script: str) -> set[str]:
    return {path.stem for path in digests._with_imports([SCRIPTS / script])}


def test_digest_follows_imports_to_the_formulas() -> None:
    assert {"film", "contact", "run_gates", "store"} <= modules_behind("curate.py")


def imports_that_python_sees(text: str) -> set[str]:
    names = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            package = "." * node.level + (node.module or "")
            stem = package if package.endswith(".") else f"{package}."
            names |= {stem + alias.name for alias in node.names} | {package}
    return names


def test_no_import_of_any_module_is_missed() -> None:
    for path in WORKFLOW.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        missed = imports_that_python_sees(text) - digests._imported_names(text)
        assert not missed, path


@pytest.mark.parametrize(
    "text",
    [
        "from oilfilm.physics import (\n    film,  # see (3)\n    contact as c,\n)",
        "from oilfilm.physics import film, \\\n    contact",
        "from oilfilm import(film)",
        "import json, oilfilm.physics.film as film",
        "import json; import oilfilm.physics",
        "from json import load; import oilfilm.physics",
        "from json import load; from oilfilm.physics import film  # (4)",
        "x = '#fff'; import oilfilm.physics",
        '"""Lines\nfrom the import (of values"""\nimport oilfilm.physics\nx = (1)',
        "\fimport oilfilm.physics",
        "from .deng2026 import LAW",
        "from . import deng2026, tanh",
        "from.. import(law)",
        "if True: from oilfilm.physics import film",
        "def late():\n\tfrom oilfilm.physics import film",
        "from  oilfilm.physics  import  film",
        "from \\\n oilfilm.physics import film",
    ],
)
def test_import_is_found_however_it_is_written(text: str) -> None:
    assert imports_that_python_sees(text) <= digests._imported_names(text)


def test_import_of_a_neighbour_by_its_own_name_alone_is_followed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    laws = tmp_path / "oilfilm/laws"
    laws.mkdir(parents=True)
    monkeypatch.setattr(digests, "_PACKAGE", tmp_path / "oilfilm")
    words = b'"""Words\nfrom .... import nothing"""\n'
    (laws / "mine.py").write_bytes(b"\xef\xbb\xbffrom .near import a\nfrom .. import far\n" + words)
    for file in (laws / "near.py", tmp_path / "oilfilm/far.py"):
        file.touch()
    digests._module_files.cache_clear()
    names = {path.stem for path in digests._imported(laws / "mine.py")}
    digests._module_files.cache_clear()
    assert names == {"near", "far"}


def test_digest_of_a_fit_does_not_depend_on_figures_or_readers() -> None:
    assert not {"style", "pcs", "csv", "simulate"} & modules_behind("fit.py")


def test_nothing_but_the_twins_rules_imports_the_twin() -> None:
    for script in SCRIPTS.glob("*.py"):
        if script.name not in {"twin.py", "truth.py", "torque_twin.py"}:
            behind = modules_behind(script.name)
            assert not {"simulate", "truth", "torque_logs"} & behind, script.name


def test_settings_digest_does_not_depend_on_order() -> None:
    one = digests.settings_digest({"a": 1, "b": {"c": 2, "d": 3}})
    assert one == digests.settings_digest({"b": {"d": 3, "c": 2}, "a": 1})
    assert one != digests.settings_digest({"a": 1, "b": {"c": 2, "d": 4}})


def test_digest_of_a_folder_knows_names_and_contents(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("1")
    first = digests.input_digest(tmp_path)
    (tmp_path / "a").rename(tmp_path / "b")
    assert digests.input_digest(tmp_path) != first
    # sha256 of the empty message: FIPS 180-4 test vector
    (tmp_path / "empty").touch()
    assert digests.file_digest(tmp_path / "empty").startswith("e3b0c44298fc1c14")
