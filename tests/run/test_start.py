"""What a machine refuses is told in a sentence before the first step, and nothing is written."""

import fcntl
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import IO

import pytest

from oilfilm.base.errors import OilfilmError
from oilfilm.run.start import (
    UNUSABLE_CHARACTERS,
    check_image,
    check_machine,
    lock_run,
    make_python_findable_by_name,
    reset_future_dates,
)

# The shell that make asks loses a newline at the end.
UNUSABLE_NAMES = [f"a{character}b" for character in sorted(UNUSABLE_CHARACTERS - {"\x00"})]


def test_unusable_folder_name_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in UNUSABLE_NAMES:
        (tmp_path / name).mkdir()
        monkeypatch.chdir(tmp_path / name)
        with pytest.raises(OilfilmError, match="Rename the folder") as refused:
            check_machine([])
        assert repr(name[1]) in str(refused.value)


def test_python_in_a_folder_with_a_blank(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    python = tmp_path / "My Lab" / "python"
    python.parent.mkdir()
    python.write_text("#!/bin/sh\necho found\n", encoding="utf-8")
    python.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(python))
    monkeypatch.setenv("PATH", "/usr/bin")
    make_python_findable_by_name()
    assert sys.executable == "python"
    found = subprocess.run(sys.executable, shell=True, capture_output=True, text=True, check=True)
    assert found.stdout == "found\n"


def test_file_in_the_place_of_a_folder_is_told(tmp_path: Path) -> None:
    (tmp_path / "results").write_text("a file", encoding="utf-8")
    with pytest.raises(OilfilmError, match="results: is a file"):
        check_machine([tmp_path / "results" / "demo"])
    check_machine([tmp_path / "new" / "folder"])
    assert [path.name for path in tmp_path.iterdir()] == ["results"]


def test_link_to_nothing_is_told(tmp_path: Path) -> None:
    (tmp_path / "results").symlink_to(tmp_path / "unmounted")
    with pytest.raises(OilfilmError, match=r"results: is a link to .*unmounted, which does not"):
        check_machine([tmp_path / "results" / "demo"])


def test_second_run_that_takes_the_lock_first_refuses_this_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Changing the kind of a lock is not atomic: flock(2)."""
    system_flock = fcntl.flock
    with (tmp_path / "oilfilm.lock").open("a+b") as second_run:

        def flock(file: IO[bytes], operation: int) -> None:
            if operation & fcntl.LOCK_SH:
                assert operation & fcntl.LOCK_NB, "waits, and then runs beside the second run"
                system_flock(file, fcntl.LOCK_UN)
                system_flock(second_run, fcntl.LOCK_EX)
            system_flock(file, operation)

        monkeypatch.setattr(fcntl, "flock", flock)
        with pytest.raises(OilfilmError, match="Another run is active"):
            lock_run(tmp_path)


def test_image_that_is_not_here_is_told(tmp_path: Path) -> None:
    image = tmp_path / "oilfilm.sif"
    with pytest.raises(OilfilmError, match=r"oilfilm\.sif: there is no such image"):
        check_image(str(image))
    image.touch()
    for usable in (str(image), "docker://registry.example/oilfilm:1", "none"):
        check_image(usable)


def test_full_disk_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    full = shutil.disk_usage(tmp_path)._replace(free=0)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: full)
    with pytest.raises(OilfilmError, match="The disk is full"):
        check_machine([tmp_path])


def test_dates_in_the_future_become_now_and_others_stay(tmp_path: Path) -> None:
    now = time.time()
    for name, stamp in (("future", now + 86_400), ("past", now - 86_400)):
        (tmp_path / name).touch()
        os.utime(tmp_path / name, (stamp, stamp))
    reset_future_dates([tmp_path, tmp_path / "nothing"])
    assert abs((tmp_path / "future").stat().st_mtime - now) < 60
    assert (tmp_path / "past").stat().st_mtime == pytest.approx(now - 86_400)
