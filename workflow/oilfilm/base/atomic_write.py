"""Write files and folders completely or not at all: write under a hidden name, then rename.

A killed run leaves a hidden file or folder: its name begins with a dot. The next run overwrites it.
After a power failure a file has its old content or all of the new content. For this the content is
flushed to disk before the rename, and the folder that holds the file after it. A folder may also be
missing after a power failure. A rename replaces only an empty folder, so the old folder is removed
before the new one gets its name.

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
    temporary_path = _temporary_path(path)
    try:
        yield temporary_path
        flush(temporary_path)
    except BaseException:
        temporary_path.unlink(missing_ok=True)  # a full disk needs the space
        raise
    rename_flushed(temporary_path, path)


@contextmanager
def atomic_folder(path: Path) -> Iterator[Path]:
    """Yield a temporary folder to fill; it replaces `path` when no error occurred."""
    temporary_path = _temporary_path(path)
    shutil.rmtree(temporary_path, ignore_errors=True)
    make_folder(temporary_path)
    try:
        yield temporary_path
        flush(temporary_path)
    except BaseException:
        shutil.rmtree(temporary_path, ignore_errors=True)
        raise
    shutil.rmtree(path, ignore_errors=True)
    rename_flushed(temporary_path, path)


def write_bytes(content: bytes, path: Path) -> None:
    """Write a file completely or not at all."""
    with atomic_file(path) as temporary_path:
        temporary_path.write_bytes(content)


def write_text(text: str, path: Path, encoding: str = "utf-8") -> None:
    """Write a text completely or not at all; line ends stay as they are."""
    with atomic_file(path) as temporary_path:
        temporary_path.write_text(text, encoding=encoding, newline="")


def _temporary_path(path: Path) -> Path:
    """The hidden path, in the same folder, under which `path` is written."""
    # programs that read all tables of a folder skip a hidden file with another ending
    return path.with_name(f".{path.name}.part")


def flush(path: Path) -> None:
    """Force the content of a file, or of a folder and everything below it, to disk."""
    if path.is_dir():
        for entry in path.iterdir():
            if not entry.is_symlink():  # a link has no content of its own
                flush(entry)
    _flush_entry(path)


def rename_flushed(temporary_path: Path, path: Path) -> None:
    """Rename a flushed file, a flushed folder or a link in one step, and flush the new name."""
    temporary_path.replace(path)
    _flush_entry(path.parent)


def make_folder(folder: Path) -> None:
    """Make a folder and the missing folders above it, and flush their names."""
    missing_folders = [path for path in (folder, *folder.parents) if not path.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    for path in missing_folders:
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
