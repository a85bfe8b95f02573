"""The command itself: help without waiting, version."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from oilfilm import __version__
from oilfilm.cli import main
from oilfilm.cli.parser import COMMANDS, CONDITION_OPTIONS, parser
from oilfilm.traction.law import QUANTITIES
from reference_pages.commands import page


def test_help_imports_no_package_beside_the_standard_library() -> None:
    script = (
        "import sys; before = set(sys.modules); from oilfilm.cli import main\n"
        "for command in [[], *([name] for name in sys.argv[1:])]:\n"
        "    try: main([*command, '--help'])\n"
        "    except SystemExit: pass\n"
        "new = {name.partition('.')[0] for name in set(sys.modules) - before}\n"
        "print(sorted(new - sys.stdlib_module_names - {'oilfilm'}))"
    )
    names = [declare.__name__ for declare in COMMANDS]
    done = subprocess.run(
        [sys.executable, "-c", script, *names], capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == "[]"
    assert done.stdout.count("usage: oilfilm") == len(names) + 1


def test_what_only_the_workflow_has_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "Snakefile").touch()
    monkeypatch.setattr("oilfilm.cli.arguments.find_spec", lambda name: None)
    assert main(["run", str(tmp_path)]) == 2
    assert "pip install 'oilfilm[workflow]'" in capsys.readouterr().err


def test_version_is_that_of_the_package(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["--version"])
    assert stop.value.code == 0
    assert capsys.readouterr().out == f"oilfilm {__version__}\n"


def test_options_say_what_the_law_calls_its_conditions() -> None:
    for name, meaning, _ in CONDITION_OPTIONS.values():
        assert QUANTITIES[name].meaning == meaning


def test_every_argument_and_key_has_a_meaning() -> None:
    assert not re.findall(r"(?m)^\| `.*` \| *\|$", page())


@pytest.mark.parametrize(
    "arguments",
    [["--campaign", "june", "DIR", "a.csv"], ["DIR", "--campaign", "june", "a.csv"]],
)
def test_options_stand_before_or_between_files(arguments: list[str]) -> None:
    options = parser().parse_args(["init", *arguments])
    assert (options.folder, options.campaign) == (Path("DIR"), "june")
    assert options.logs == [Path("a.csv")]
