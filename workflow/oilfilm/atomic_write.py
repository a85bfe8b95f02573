"""Files and folders that are there whole or not at all: written beside, then renamed.

What a killed run leaves beside begins with a dot and is overwritten by the next run.
"""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give the path to write to; what was written gets its name when all went well."""
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = _aside(path)
    try:
        yield aside
        _to_disk(aside)
    except BaseException:
        aside.unlink(missing_ok=True)  # a full disk needs the room
        raise
    aside.replace(path)


@contextmanager
def whole_folder(path: Path) -> Iterator[Path]:
    """The same for a folder of files; one that is there already is replaced."""
    aside = _aside(path)
    shutil.rmtree(aside, ignore_errors=True)
    aside.mkdir(parents=True)
    try:
        yield aside
        for file in aside.rglob("*"):
            if file.is_file():
                _to_disk(file)
    except BaseException:
        shutil.rmtree(aside, ignore_errors=True)
        raise
    shutil.rmtree(path, ignore_errors=True)
    aside.replace(path)


def write_text(text: str, path: Path, encoding: str = "utf-8") -> None:
    """Write a text whole or not at all, its line ends as they are."""
    with whole_file(path) as aside:
        aside.write_text(text, encoding=encoding, newline="")


def _aside(path: Path) -> Path:
    # hidden, and with another ending: nobody who reads all tables of a folder reads this
    return path.with_name(f".{path.name}.part")


def _to_disk(file: Path) -> None:
    """Without this a loss of power could leave the name with nothing behind it."""
    with file.open("rb") as written:
        os.fsync(written.fileno())
