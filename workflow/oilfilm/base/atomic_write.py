"""Write files and folders completely or not at all: write under a hidden name, then rename.

A killed run leaves a path that begins with a dot. The next run overwrites it. After a power failure
a file has its old content or all of the new content. For this the content is flushed to disk before
the rename, and the folder with the new name after it. A folder may also be missing then: the old
one is removed before the new one gets its name, because a rename replaces only an empty folder.

Decides: how a file is written completely or not at all.
"""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """Yield a temporary path to write to; rename it to `path` when no error occurred."""
    make_folder(path.parent)
    temporary = _temporary(path)
    try:
        yield temporary
        flush(temporary)
    except BaseException:
        temporary.unlink(missing_ok=True)  # a full disk needs the space
        raise
    rename_flushed(temporary, path)


@contextmanager
def atomic_folder(path: Path) -> Iterator[Path]:
    """Yield a temporary folder to fill; it replaces `path` when no error occurred."""
    temporary = _temporary(path)
    shutil.rmtree(temporary, ignore_errors=True)
    make_folder(temporary)
    try:
        yield temporary
        flush(temporary)
    except BaseException:
        shutil.rmtree(temporary, ignore_errors=True)
        raise
    shutil.rmtree(path, ignore_errors=True)
    rename_flushed(temporary, path)


def write_bytes(content: bytes, path: Path) -> None:
    """Write a file completely or not at all."""
    with atomic_file(path) as temporary:
        temporary.write_bytes(content)


def write_text(text: str, path: Path, encoding: str = "utf-8") -> None:
    """Write a text completely or not at all; line ends stay as they are."""
    with atomic_file(path) as temporary:
        temporary.write_text(text, encoding=encoding, newline="")


def _temporary(path: Path) -> Path:
    # programs that read all tables of a folder skip a name with a dot and another ending
    return path.with_name(f".{path.name}.part")


def flush(path: Path) -> None:
    """Force the content of a file, or of a folder and everything below it, to disk."""
    if path.is_dir():
        for entry in path.iterdir():
            if not entry.is_symlink():  # a link has no content of its own
                flush(entry)
    _flush_entry(path)


def rename_flushed(temporary: Path, path: Path) -> None:
    """Rename a flushed file, a flushed folder or a link in one step, and flush the new name."""
    temporary.replace(path)
    _flush_entry(path.parent)


def make_folder(folder: Path) -> None:
    """Make a folder and the missing folders above it, and flush their names."""
    missing = [path for path in (folder, *folder.parents) if not path.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    for path in missing:
        _flush_entry(path.parent)


def _flush_entry(path: Path) -> None:
    """Force the content of one file, or the names in one folder, to disk."""
    try:
        # Windows flushes no file that is open for reading only, and opens no folder
        descriptor = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    except PermissionError:
        return
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
