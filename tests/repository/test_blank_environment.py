"""The wheel in a blank environment with an empty HOME: what the core gives, what it asks for."""

import os
import re
import sys
import tarfile
from pathlib import Path

import pytest

from campaigns import ROOT
from command_line import outcome, succeeded
from damages import SOUND
from oilfilm import __version__

pytestmark = pytest.mark.nightly

BUILD = [sys.executable, "-m", "hatchling", "build"]


def installed(folder: Path, *arguments: str) -> Path:
    """A new environment with the wheel, from the package registry; skips where none is reached."""
    succeeded([*BUILD, "-t", "wheel", "-d", folder], cwd=ROOT)
    (wheel,) = folder.glob("*.whl")
    uv = [sys.executable, "-m", "uv"]
    environment = folder / "environment"
    succeeded([*uv, "venv", "--quiet", "--python", sys.executable, environment])
    install = [*uv, "pip", "install", "--quiet", "--python", environment / "bin/python"]
    code, text = outcome([*install, *arguments, wheel])
    if code and ("connect" in text or "fetch" in text):
        pytest.skip("no package registry is reached, so that nothing can be installed")
    assert code == 0, text
    (folder / "home").mkdir()
    return environment


def run(environment: Path, program: str, *arguments: str) -> tuple[int, str]:
    """Exit code and output of a program of the environment, with nothing of this one."""
    home = environment.parent / "home"
    nothing = {"HOME": str(home), "PATH": os.defpath}
    return outcome([environment / "bin" / program, *arguments], cwd=home, env=nothing)


def asked_of_the_core(core: Path) -> None:
    """Check a log, predict, run the lines of the README."""
    assert run(core, "oilfilm", "--version") == (0, f"oilfilm {__version__}\n")
    (core.parent / "home/4102.csv").write_bytes(SOUND["traction"].text())
    code, text = run(core, "oilfilm", "check", "4102.csv")
    assert (code, "ACCEPTED" in text) == (0, True), text
    at = ("--stress", "1.2GPa", "--speed", "30m/s", "--temperature", "70degC", "--slip", "5%")
    code, text = run(core, "oilfilm", "predict", "--printed", "--oil", "4102", *at)
    assert (code, "mu = 0.01077" in text) == (0, True), text
    (code,) = re.findall(r"(?ms)^```python\n(.*?)^```", (ROOT / "README.md").read_text("utf-8"))
    (core.parent / "home/readme.txt").write_text(code, encoding="utf-8")
    assert run(core, "python", "-m", "doctest", "readme.txt") == (0, "")


def test_core_does_its_part_and_names_what_it_lacks(tmp_path: Path) -> None:
    core = installed(tmp_path)
    asked_of_the_core(core)
    pin = str(ROOT / "data/reference/pins/demo")
    code, text = run(core, "oilfilm", "diff", pin, pin)
    assert code == 0, text
    (tmp_path / "home/Snakefile").touch()
    code, text = run(core, "oilfilm", "run")
    assert (code, "pip install '.[workflow]'" in text) == (2, True)
    for package in ("snakemake", "matplotlib", "pytest"):
        code, text = run(core, "python", "-c", f"import {package}")
        assert f"No module named '{package}'" in text


def test_oldest_packages_serve_as_well(tmp_path: Path) -> None:
    """The floors of pyproject.toml, one after the other the oldest that each allows."""
    asked_of_the_core(installed(tmp_path, "--resolution", "lowest-direct"))


def test_wheel_of_the_source_archive_is_that_of_the_clone(tmp_path: Path) -> None:
    """What is published is built twice the same; the source has all that the wheel takes."""
    for target in ("wheel", "sdist"):
        succeeded([*BUILD, "--target", target, "--directory", tmp_path], cwd=ROOT)
    (wheel,), (source,) = tmp_path.glob("*.whl"), tmp_path.glob("*.tar.gz")
    with tarfile.open(source) as archive:
        archive.extractall(tmp_path / "source", filter="data")
    (unpacked,) = (tmp_path / "source").iterdir()
    succeeded([*BUILD, "--target", "wheel", "--directory", tmp_path / "again"], cwd=unpacked)
    assert (tmp_path / "again" / wheel.name).read_bytes() == wheel.read_bytes()
