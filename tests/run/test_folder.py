"""Folders whose names mean something to a shell, to make or to Snakemake."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from campaigns import ROOT
from oilfilm.errors import OilfilmError
from oilfilm.run.folder import UNUSABLE, refuse_unusable, start_python_by_name

HARMLESS = ["My Lab", "Prüfstand", "it's", "a#b%c;d", "-x", "l" * 200]
# The shell that make asks loses a newline at the end.
UNUSABLE_NAMES = [f"a{character}b" for character in sorted(UNUSABLE - {"\x00"})]


@pytest.mark.parametrize("name", HARMLESS)
def test_harmless_folder_is_accepted(name: str) -> None:
    refuse_unusable(Path("/home/x", name, "project"))


@pytest.mark.parametrize("name", UNUSABLE_NAMES)
def test_unusable_folder_is_refused_with_the_character(name: str) -> None:
    with pytest.raises(OilfilmError, match="Rename the folder") as refused:
        refuse_unusable(Path("/home/x", name, "project"))
    assert repr(name[1]) in str(refused.value)


@pytest.mark.parametrize("name", [*UNUSABLE_NAMES, "a$(touch X)b"])
def test_make_refuses_the_same_folders_before_anything_is_installed(
    name: str, tmp_path: Path
) -> None:
    folder = tmp_path / name
    folder.mkdir()
    shutil.copy(ROOT / "Makefile", folder)
    made = subprocess.run(
        ["make", "setup"], cwd=folder, capture_output=True, text=True, check=False
    )
    assert made.returncode != 0
    assert "Rename the folder" in made.stderr
    assert [path.name for path in folder.iterdir()] == ["Makefile"]


@pytest.mark.parametrize("name", HARMLESS)
def test_make_works_in_harmless_folders(name: str, tmp_path: Path) -> None:
    folder = tmp_path / name
    folder.mkdir()
    shutil.copy(ROOT / "Makefile", folder)
    made = subprocess.run(["make", "help"], cwd=folder, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    assert "set up .venv" in made.stdout


def test_python_in_a_folder_with_a_blank_is_found_by_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    python = tmp_path / "My Lab" / "python"
    monkeypatch.setattr(sys, "executable", str(python))
    monkeypatch.setenv("PATH", "/usr/bin")
    start_python_by_name()
    assert sys.executable == "python"
    assert shutil.which("ls") == "/usr/bin/ls"
    python.parent.mkdir()
    python.write_text("#!/bin/sh\necho found\n", encoding="utf-8")
    python.chmod(0o755)
    # as Snakemake starts a job: without quotes
    found = subprocess.run(sys.executable, shell=True, capture_output=True, text=True, check=True)
    assert found.stdout == "found\n"
