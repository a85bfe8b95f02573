"""A log that changed has another digest, whatever its date; one that did not is not read again."""

import os
import shutil
import time
from pathlib import Path

import pytest

from oilfilm.base.digests import file_digest
from oilfilm.logs import log_digests
from oilfilm.logs.log_digests import LogDigests


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the logs a.csv and b.csv, whose states a run has kept."""
    # so that no test waits until a state counts as settled
    monkeypatch.setattr(log_digests, "_COARSEST_CLOCK_NS", 0)
    folder = tmp_path / "logs"
    folder.mkdir()
    for name in "ab":
        (folder / f"{name}.csv").write_text(f"log {name}", encoding="utf-8")
    of_run(folder, keep=True)
    time.sleep(0.05)  # a few steps of the clock of the file system
    return folder


def of_run(folder: Path, keep: bool = False) -> dict[str, str]:
    """The digests that one run finds."""
    digests = LogDigests(folder.with_name("kept.json"))
    found = digests.digest_of_name(folder, ["a.csv", "b.csv"])
    if keep:
        digests.save()
    return found


def digests_of(folder: Path) -> dict[str, str]:
    return {path.name: file_digest(path) for path in folder.iterdir()}


def read_by(monkeypatch: pytest.MonkeyPatch, folder: Path) -> list[str]:
    """Names of the logs that a run reads for their digests."""
    read: list[str] = []

    def digest(path: Path) -> str:
        read.append(path.name)
        return file_digest(path)

    with monkeypatch.context() as patch:
        patch.setattr(log_digests, "file_digest", digest)
        of_run(folder)
    return read


def test_log_of_other_bytes_with_its_old_date_and_size_has_another_digest(folder: Path) -> None:
    log, before = folder / "a.csv", of_run(folder)
    status = log.stat()
    log.write_text("LOG a", encoding="utf-8")
    os.utime(log, ns=(status.st_atime_ns, status.st_mtime_ns))
    assert (log.stat().st_size, log.stat().st_mtime_ns) == (status.st_size, status.st_mtime_ns)
    assert of_run(folder) == digests_of(folder) != before


def test_restored_copy_of_an_older_date_has_another_digest(folder: Path) -> None:
    log, copy = folder / "a.csv", folder.with_name("copy.csv")
    copy.write_text("other", encoding="utf-8")
    os.utime(copy, (0, 0))
    shutil.copy2(copy, log)
    assert log.stat().st_mtime == 0
    assert of_run(folder) == digests_of(folder)


def test_log_in_the_place_of_another_has_its_own_digest(folder: Path) -> None:
    log, other = folder / "a.csv", folder / "b.csv"
    os.utime(other, ns=(log.stat().st_atime_ns, log.stat().st_mtime_ns))
    other.replace(log)
    assert of_run(folder)["a.csv"] == file_digest(log)


def test_touched_log_alone_is_read_again_and_has_its_digest(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = of_run(folder)
    assert read_by(monkeypatch, folder) == []
    (folder / "b.csv").touch()
    assert read_by(monkeypatch, folder) == ["b.csv"]
    assert of_run(folder) == before


def test_log_that_changed_a_moment_ago_is_read_by_the_next_run_too(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A second change within one step of the clock would leave its state as it is."""
    monkeypatch.setattr(log_digests, "_COARSEST_CLOCK_NS", 3_600_000_000_000)
    of_run(folder, keep=True)
    assert read_by(monkeypatch, folder) == ["a.csv", "b.csv"]


def test_log_that_another_workflow_brings_during_a_run_has_its_digest(folder: Path) -> None:
    digests = LogDigests(folder.with_name("kept.json"))
    digests.digest_of_name(folder, ["a.csv"])
    (folder / "a.csv").write_text("log a, and more", encoding="utf-8")
    assert digests.digest_of_name(folder, ["a.csv"]) == {"a.csv": file_digest(folder / "a.csv")}


@pytest.mark.parametrize("kept", ["", "{", "[]", '{"a.csv": 1}', "\udcff"])
def test_damaged_record_of_digests_has_all_logs_read_again(folder: Path, kept: str) -> None:
    folder.with_name("kept.json").write_bytes(kept.encode(errors="surrogateescape"))
    assert of_run(folder) == digests_of(folder)


def test_log_that_cannot_be_read_has_no_digest(folder: Path) -> None:
    (folder / "a.csv").unlink()
    assert of_run(folder)["a.csv"] == ""
