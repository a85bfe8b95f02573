"""Write files and folders completely or not at all: write under a hidden name, then rename.

A killed run leaves a path that begins with a dot. The next run overwrites it.
"""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """Yield a temporary path to write to; rename it to `path` when no error occurred."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = _temporary(path)
    try:
        yield temporary
        _flush_to_disk(temporary)
    except BaseException:
        temporary.unlink(missing_ok=True)  # a full disk needs the space
        raise
    temporary.replace(path)


@contextmanager
def atomic_folder(path: Path) -> Iterator[Path]:
    """Yield a temporary folder to fill; it replaces `path` when no error occurred."""
    temporary = _temporary(path)
    shutil.rmtree(temporary, ignore_errors=True)
    temporary.mkdir(parents=True)
    try:
        yield temporary
        for file in temporary.rglob("*"):
            if file.is_file():
                _flush_to_disk(file)
    except BaseException:
        shutil.rmtree(temporary, ignore_errors=True)
        raise
    shutil.rmtree(path, ignore_errors=True)
    temporary.replace(path)


def write_bytes(content: bytes, path: Path) -> None:
    """Write a file completely or not at all."""
    with atomic_file(path) as temporary:
        temporary.write_bytes(content)


def write_text(text: str, path: Path, encoding: str = "utf-8") -> None:
    """Write a text completely or not at all; line ends stay as they are."""
    with atomic_file(path) as temporary:
        temporary.write_text(text, encoding=encoding, newline="")


def _temporary(path: Path) -> Path:
    # hidden and with another ending, so that reading all tables of a folder skips it
    return path.with_name(f".{path.name}.part")


def _flush_to_disk(file: Path) -> None:
    """Force the content to disk: a power failure after the rename must not leave an empty file."""
    with file.open("r+b") as written:  # Windows flushes no file that is open for reading only
        os.fsync(written.fileno())
