"""Digests are kept while a file is as it was, and taken anew whenever it may have changed."""

import os
from hashlib import sha256
from pathlib import Path

import pytest

from oilfilm import digest_cache
from oilfilm.digest_cache import DigestCache

LONG_AGO_NS = 1_600_000_000_000_000_000


@pytest.fixture
def reads(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """The files whose content was read."""
    read: list[Path] = []

    def counted(path: Path) -> str:
        read.append(path)
        return sha256(path.read_bytes()).hexdigest()

    monkeypatch.setattr(digest_cache, "file_digest", counted)
    # the change of a file a moment ago does not count as one
    monkeypatch.setattr(digest_cache, "_TICK_NS", -1)
    return read


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "a.csv"
    path.write_bytes(b"first")
    return path


def test_unchanged_file_is_read_once_over_several_starts(log: Path, reads: list[Path]) -> None:
    kept = log.with_name("digests.json")
    for _ in range(3):
        cache = DigestCache(kept)
        assert cache.digest(log) == sha256(b"first").hexdigest()
        cache.save()
    assert reads == [log]


def rewrite(path: Path) -> None:
    path.write_bytes(b"other")


def replace(path: Path) -> None:
    other = path.with_name("other")
    other.write_bytes(b"other")
    other.replace(path)


def rewrite_under_the_same_mtime(path: Path) -> None:
    before = path.stat()
    path.write_bytes(b"other")
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))


@pytest.mark.parametrize("change", [rewrite, replace, rewrite_under_the_same_mtime])
def test_changed_file_is_read_again(log: Path, reads: list[Path], change: object) -> None:
    os.utime(log, ns=(LONG_AGO_NS, LONG_AGO_NS))
    cache = DigestCache(log.with_name("digests.json"))
    cache.digest(log)
    change(log)  # type: ignore[operator]
    assert cache.digest(log) == sha256(b"other").hexdigest()
    assert len(reads) == 2


def test_file_of_this_moment_is_not_kept(
    log: Path, reads: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its next change might fall into the same tick of the file system's clock."""
    monkeypatch.setattr(digest_cache, "_TICK_NS", 10**12)
    cache = DigestCache(log.with_name("digests.json"))
    cache.digest(log)
    cache.digest(log)
    assert len(reads) == 2


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b'{"a": 1}', b'{"a": [1, 2, 3]}', b"\xff"])
def test_damaged_cache_is_none(log: Path, reads: list[Path], content: bytes) -> None:
    kept = log.with_name("digests.json")
    kept.write_bytes(content)
    assert DigestCache(kept).digest(log) == sha256(b"first").hexdigest()


def test_forgotten_digests_are_taken_anew(log: Path, reads: list[Path]) -> None:
    kept = log.with_name("digests.json")
    cache = DigestCache(kept)
    cache.digest(log)
    cache.save()
    cache.forget()
    assert not kept.exists()
    DigestCache(kept).digest(log)
    assert len(reads) == 2
