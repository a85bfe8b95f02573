"""Digests change with what they stand for, and with nothing else."""

from pathlib import Path

from oilfilm import digests

SCRIPTS = Path(__file__).parents[2] / "workflow/scripts"


def modules_behind(script: str) -> set[str]:
    return {path.stem for path in digests._with_imports([SCRIPTS / script])}


def test_digest_follows_imports_to_the_formulas() -> None:
    assert {"film", "contact", "run_gates", "store"} <= modules_behind("curate.py")


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
