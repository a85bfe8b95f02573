"""The command itself: help without waiting, version, and a sentence for every mistake."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from bad_logs import csv
from campaigns import ROOT
from command_line import succeeded
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


@pytest.mark.slow
def test_no_command_imports_matplotlib_before_it_draws() -> None:
    """The core has no matplotlib."""
    stems = [path.stem for path in (ROOT / "workflow/oilfilm/cli").glob("*.py")]
    modules = ", ".join(f"oilfilm.cli.{stem}" for stem in stems if stem != "compare_plot")
    script = f"import sys; sys.modules['matplotlib'] = None; import {modules}"
    succeeded([sys.executable, "-c", script])


@pytest.mark.slow
def test_check_of_a_log_loads_no_slow_module_that_it_does_not_use(tmp_path: Path) -> None:
    log = tmp_path / "a.csv"
    log.write_bytes(csv())
    unused = ["scipy.optimize", "scipy.signal", "scipy.stats", "matplotlib"]
    arguments = ["check", str(log), "--config", str(ROOT / "config")]
    # a module that is None cannot be imported
    script = (
        f"import sys; sys.modules.update(dict.fromkeys({unused})); "
        f"from oilfilm.cli import main; sys.exit(main({arguments}))"
    )
    succeeded([sys.executable, "-c", script])


def test_what_only_the_workflow_has_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "Snakefile").touch()
    monkeypatch.setattr("oilfilm.cli.run.find_spec", lambda name: None)
    assert main(["run", str(tmp_path)]) == 2
    assert "pip install '.[workflow]'" in capsys.readouterr().err


def test_options_say_what_the_law_calls_its_conditions() -> None:
    for name, meaning, _ in CONDITION_OPTIONS.values():
        assert QUANTITIES[name].meaning == meaning


def test_every_argument_and_key_has_a_meaning() -> None:
    assert not re.findall(r"(?m)^\| `.*` \| *\|$", page())


AT = "--oil 4102 --stress 1.2GPa --speed 30m/s --temperature 70degC --slip 0.05"
# The command, in a folder with the files that `mistakes` makes, and a part of what it says.
MISTAKES = {
    "check missing.csv": "missing.csv: cannot be read (No such file or directory).",
    "check folder": "folder: holds no logs",
    "check loop": "loop: cannot be read (Too many levels of symbolic links). Check the path",
    "check good.csv --config folder": "folder/config.yaml: there is no such file",
    f"predict {AT}": ": has no results of a campaign",
    f"predict {AT} --results damaged": "coefficients.parquet: cannot be read as Parquet",
    f"predict {AT.replace('30m/s', 'fast')}": "--speed: found 'fast'; expected a number in m/s",
    f"predict {AT.replace('1.2GPa', '1.2kg')}": "--stress: found '1.2kg': the unit 'kg' is none",
    f"predict {AT.replace('1.2GPa', '1e999')}": "--stress: found '1e999': no quantity is 1e+09",
    "check pipe.csv": "pipe.csv: is a pipe or a device; expected a file",
    "init made pipe.csv": "pipe.csv: is a pipe or a device",
    "verify missing": "missing: is not a release",
    "diff empty_manifest binary_manifest": "manifest.json",
    "chekc good.csv": "'chekc' is no command. Did you mean 'check'?",
    "watch --settle soon": "invalid float value: 'soon'",
    "watch --settle nan": "--settle: found nan; expected 0 seconds or more",
    "watch --settle=-1": "--settle: found -1; expected 0 seconds or more",
    f"predict {AT.replace('0.05', 'much')}": "--slip: found 'much'; expected a number",
    "good.csv": "'good.csv' is no command. Write `oilfilm check` before logs, `oilfilm fit` before",
    "make": "'make' is no command. Expected one of init, run, check, ",
    "\u00e9" * 200: "is no command. Expected one of init, run, check, ",
}


@pytest.fixture(scope="module")
def mistakes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with all kinds of files that no command can use, and one good log."""
    folder = tmp_path_factory.mktemp("mistakes")
    (folder / "config").symlink_to(ROOT / "config")
    contents = {
        "good.csv": csv(),
        "damaged/tables/coefficients.parquet": b"PAR1",
        "empty_manifest/manifest.json": b"",
        "binary_manifest/manifest.json": bytes(range(256)),
    }
    for name, content in contents.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    (folder / "folder").mkdir()
    (folder / "loop").symlink_to("loop")
    os.mkfifo(folder / "pipe.csv")
    return folder


@pytest.mark.parametrize(("command", "sentence"), MISTAKES.items(), ids=range(len(MISTAKES)))
def test_mistake_ends_in_a_sentence(
    mistakes: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    command: str,
    sentence: str,
) -> None:
    monkeypatch.chdir(mistakes)
    try:
        code = main(command.split())
    except SystemExit as end:
        code = int(str(end.code))
    output = "".join(capsys.readouterr())
    assert re.sub(r"\s+", " ", sentence) in re.sub(r"\s+", " ", output)
    assert code == 2


@pytest.mark.slow
def test_reader_of_the_output_may_go_away_or_know_ascii_only(tmp_path: Path) -> None:
    log = tmp_path / "a.csv"
    log.write_bytes(csv(oil="油"))
    command = [sys.executable, "-m", "oilfilm", "check", str(log), "--config", str(ROOT / "config")]
    ascii_only = {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"}
    environment = {**os.environ, **ascii_only, "PYTHONPATH": str(ROOT / "workflow")}
    in_ascii = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert in_ascii.returncode == 1
    assert r"'\u6cb9'" in in_ascii.stdout
    read, write = os.pipe()
    os.close(read)
    without_reader = subprocess.run(
        command, env=environment, stdout=write, stderr=subprocess.PIPE, text=True, check=False
    )
    os.close(write)
    assert (without_reader.returncode, without_reader.stderr) == (2, "")


@pytest.mark.parametrize("command", ["check", "fit", "verify", ""])
def test_endless_path_is_cut_in_messages(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*filter(None, [command]), "x" * 6000]) == 2
    message = capsys.readouterr().err
    assert "(6" in message
    assert len(message) < 1000


def test_help_of_every_command_ends_with_a_good_example(capsys: pytest.CaptureFixture[str]) -> None:
    for declare_command in COMMANDS:
        with pytest.raises(SystemExit, match="0"):
            main([declare_command.__name__, "--help"])
        example = " ".join(capsys.readouterr().out.partition("Example: oilfilm ")[2].split())
        assert parser().parse_args(example.split()).command == declare_command.__name__
