"""The command itself: help without waiting, version."""

import argparse
import re
import subprocess
import sys
from pathlib import Path

import pytest

from oilfilm import __version__
from oilfilm.cli import main
from oilfilm.cli.parser import CONDITION_OPTIONS, parser
from oilfilm.traction.law import QUANTITIES
from reference_pages.commands import page


def commands() -> dict[str, argparse.ArgumentParser]:
    (sub,) = (each for each in parser()._actions if isinstance(each.choices, dict))
    return dict(sub.choices)  # type: ignore[arg-type]


@pytest.mark.parametrize("command", [[], *([name] for name in commands())])
def test_help_imports_no_package_beside_the_standard_library(command: list[str]) -> None:
    script = (
        "import sys; before = set(sys.modules); from oilfilm.cli import main\n"
        "try: main([*sys.argv[1:], '--help'])\n"
        "except SystemExit: pass\n"
        "new = {name.partition('.')[0] for name in set(sys.modules) - before}\n"
        "print(sorted(new - sys.stdlib_module_names - {'oilfilm'}))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, *command], capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == "[]"
    assert "usage: oilfilm" in done.stdout


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


@pytest.mark.parametrize("arguments", [["--help"], ["check", "--help"], ["predict", "--version"]])
def test_reader_that_stops_early_sees_no_traceback(arguments: list[str]) -> None:
    """As `oilfilm --help | head -1`."""
    with subprocess.Popen(
        [sys.executable, "-m", "oilfilm", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert "Traceback" not in (errors := process.stderr.read())
        assert "Broken pipe" not in errors


@pytest.mark.parametrize(
    "arguments",
    [["--campaign", "june", "DIR", "a.csv"], ["DIR", "--campaign", "june", "a.csv"]],
)
def test_options_stand_before_or_between_files(arguments: list[str]) -> None:
    options = parser().parse_args(["init", *arguments])
    assert (options.folder, options.campaign) == (Path("DIR"), "june")
    assert options.logs == [Path("a.csv")]
