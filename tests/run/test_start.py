"""Folders whose names mean something to a shell, to make or to Snakemake."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from campaigns import ROOT
from oilfilm.errors import OilfilmError
from oilfilm.run.start import (
    UNUSABLE,
    ask_machine,
    keep_a_cache,
    refuse_unusable,
    refuse_unwritable,
    start_python_by_name,
)

HARMLESS = ["My Lab", "Prüfstand", "it's", "a#b%c;d", "-x", "l" * 200]
# The shell that make asks loses a newline at the end.
UNUSABLE_NAMES = [f"a{character}b" for character in sorted(UNUSABLE - {"\x00"})]


@pytest.mark.parametrize("name", HARMLESS)
def test_harmless_folder_is_accepted(name: str) -> None:
    refuse_unusable(Path("/labs", name, "project"))


@pytest.mark.parametrize("name", UNUSABLE_NAMES)
def test_unusable_folder_is_refused_with_the_character(name: str) -> None:
    with pytest.raises(OilfilmError, match="Rename the folder") as refused:
        refuse_unusable(Path("/labs", name, "project"))
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


def test_folder_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    """A file in the place of a folder stops the administrator as well, whom no rights stop."""
    (tmp_path / "results").write_text("a file", encoding="utf-8")
    with pytest.raises(OilfilmError, match="results"):
        ask_machine([tmp_path / "results" / "demo"])
    ask_machine([tmp_path / "new" / "folder"])
    assert [path.name for path in tmp_path.iterdir()] == ["results"]


def test_little_address_space_is_told(tmp_path: Path) -> None:
    script = "from oilfilm.run.start import ask_machine; ask_machine([])"
    limited = ["sh", "-c", 'ulimit -v 2000000 && exec "$@"', "sh", sys.executable, "-c", script]
    done = subprocess.run(limited, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "limited to 1.9 GiB here; expected at least 4 GiB" in done.stderr


def test_cache_goes_elsewhere_only_where_the_usual_place_takes_no_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    keep_a_cache(tmp_path / "other")
    assert os.environ["XDG_CACHE_HOME"] == str(tmp_path / "cache")
    monkeypatch.setenv("XDG_CACHE_HOME", "/dev/null/cache")
    keep_a_cache(tmp_path / "other")
    assert os.environ["XDG_CACHE_HOME"] == str(tmp_path / "other")


@pytest.mark.skipif(os.name == "nt", reason="users of Windows have no entry in a password file")
def test_user_without_a_home_needs_none_for_the_cache(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As in a container that runs with a number for which it knows no user."""

    def unknown(_: int) -> None:
        raise KeyError("uid not found")

    for name in ("HOME", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("pwd.getpwuid", unknown)
    monkeypatch.chdir(tmp_path)
    keep_a_cache(tmp_path / "other")


def test_folder_below_one_that_may_not_be_entered_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The administrator may enter everywhere, so the system's answer is put in place here."""
    stat, locked = os.stat, str(tmp_path / "locked")

    def refusing(path: object, *args: object, **options: object) -> os.stat_result:
        if str(path).startswith(f"{locked}/"):
            raise PermissionError(13, "Permission denied", str(path))
        return stat(path, *args, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(os, "stat", refusing)
    (tmp_path / "locked").write_text("takes no file", encoding="utf-8")
    with pytest.raises(OilfilmError, match="locked: "):
        refuse_unwritable(tmp_path / "locked" / "results")
