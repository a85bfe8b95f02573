"""Digests change with what they stand for, and with nothing else."""

import ast
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from campaigns import ROOT
from oilfilm.base import digests, studies

SCRIPTS = ROOT / "workflow/scripts"


def files_behind(script: str) -> set[str]:
    return {path.stem for path in digests.files_behind(SCRIPTS / script)}


def test_digest_follows_imports_to_the_formulas() -> None:
    assert {"film", "contact", "run_gates", "failed_gates"} <= files_behind("points.py")


# A formula of each module of settings and tables that computes, and a script that uses it.
FORMULAS = {
    "settings/campaign.py": ("return 2 * logged_ratio", "return 3 * logged_ratio", "points.py"),
    "settings/ranges.py": (".scaled(factor)", ".scaled(2 * factor)", "torque.py"),
    "settings/resolved.py": ("if len(radii_and_moduli) == 1", "if contacts", "fit.py"),
    "settings/rig.py": ("return rq_um * M_PER_UM", "return 2 * rq_um * M_PER_UM", "points.py"),
    "tables/failed_gates.py": ("<= {gate_name}", "< {gate_name}", "points.py"),
    "tables/samples_content.py": ("row_count += ", "row_count -= ", "release.py"),
    "tables/set_points.py": ("pressure_pa / PA_PER_GPA", "pressure_pa", "collect.py"),
    "tables/sorted_rows.py": ('["run_id", "first_row"]', '["first_row", "run_id"]', "collect.py"),
}


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A copy of the library behind the scripts, in which a test may change one file."""
    packages = tmp_path_factory.mktemp("packages")
    shutil.copytree(ROOT / "workflow/oilfilm", packages / "oilfilm")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(studies, "PACKAGES", packages)
        forget_files()
        yield packages / "oilfilm"
    forget_files()


def forget_files() -> None:
    for cached in (digests._module_files, digests._file_code):
        cached.cache_clear()


def digest_of_changed_code(file: Path, old: str, new: str, script: str) -> tuple[str, str]:
    """Digest of a script before and after a text in a module behind it is replaced."""
    digest_before = digests.code_digest(SCRIPTS / script)
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new, 1), encoding="utf-8")
    cached = digests._file_code

    def with_the_changed_file(path: Path) -> digests._FileCode:
        return cached.__wrapped__(path) if path == file else cached(path)

    try:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(digests, "_file_code", with_the_changed_file)
            return digest_before, digests.code_digest(SCRIPTS / script)
    finally:
        file.write_text(text, encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("module", FORMULAS)
def test_changed_formula_in_settings_or_tables_reruns_the_rules_that_use_it(
    library: Path, module: str
) -> None:
    old, new, script = FORMULAS[module]
    before, after = digest_of_changed_code(library / module, old, new, script)
    assert before != after


@pytest.mark.parametrize(
    ("module", "old", "new"),
    [
        ("settings/campaign.py", '"What it is."', '"The title."'),
        ("settings/campaign.py", '"Slip steps.", ge=2', '"Steps of slip.", ge=3'),
        ("settings/rig.py", '"Radius of the ball."', '"Of the ball."'),
        ("settings/config.py", "drag_coefficient: float", "drag: float"),
    ],
)
def test_meaning_and_limits_of_a_key_rerun_no_rule(
    library: Path, module: str, old: str, new: str
) -> None:
    before, after = digest_of_changed_code(library / module, old, new, "points.py")
    assert before == after


def test_default_of_a_key_reruns_the_rules(library: Path) -> None:
    old, new = 'default="rolling_phases"', 'default="standstill"'
    before, after = digest_of_changed_code(library / "settings/campaign.py", old, new, "points.py")
    assert before != after


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
    digests._collect_syntax(ast.parse("class C: ...\ndef f(): return 'a'"), "", syntax_words, [])
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
