"""After a power failure at any system call a file, table or release is old or new, never torn.

The idea is that of SQLite's crash tests: the calls of a real program are replayed against a disk
at its worst. Content that was not flushed since it was written may be lost or torn. A name that was
made, changed or removed may be there or not until its folder is flushed. A name with a dot in
front, or below such a one, is no promise to anybody.
"""

import re
import sys
from collections.abc import Iterable
from pathlib import Path, PurePosixPath

import pytest

from campaigns import ROOT
from command_line import succeeded
from reproduce import succeeds

pytestmark = pytest.mark.skipif(
    not succeeds(["strace", "-o", "/dev/null", "true"]), reason="strace is missing or may not trace"
)

CALLS = (
    "openat,write,pwrite64,writev,ftruncate,sendfile,copy_file_range,fsync,fdatasync,"
    "rename,renameat,renameat2,unlink,unlinkat,mkdir,mkdirat,symlink,symlinkat"
)
_CALL = re.compile(r"^\d+ +(?P<name>\w+)\((?P<arguments>.*)\) += (?P<result>\d+)")
_OPENED = re.compile(r"(?:\d+|AT_FDCWD)<(?P<path>[^>]*)>")
_QUOTED = re.compile(r'"(?P<path>[^"]*)"')
_WRITES = {"write", "pwrite64", "writev", "ftruncate", "sendfile"}


def replay(calls: list[str], root: PurePosixPath) -> tuple[list[str], int]:
    """Follow a program, with a power failure after each of its calls.

    Args:
        calls: As strace lists them.
        root: The folder that somebody relies on, below the one that the program ran in.

    Returns:
        What a power failure would break; how many names below the folder were given by a rename.
    """
    # files with content, and names made or removed, of which the disk may not know
    torn_paths: set[PurePosixPath] = set()
    unflushed_paths: set[PurePosixPath] = set()
    faults: list[str] = []
    rename_count = 0

    def visible(paths: Iterable[PurePosixPath]) -> list[PurePosixPath]:
        paths_below = (path for path in paths if path.is_relative_to(root))
        return [
            path
            for path in paths_below
            if not any(part.startswith(".") for part in path.relative_to(root).parts)
        ]

    for line in calls:
        if not (call := _CALL.match(line)):
            continue
        name, arguments = call["name"], call["arguments"]
        opened_paths = [PurePosixPath(match["path"]) for match in _OPENED.finditer(arguments)]
        folder = opened_paths[0] if opened_paths else root.parent
        named_paths = [folder / match["path"] for match in _QUOTED.finditer(arguments)]
        if name in _WRITES:
            torn_paths.add(opened_paths[0])
        elif name == "copy_file_range":
            torn_paths.add(opened_paths[1])
        elif name == "openat" and "O_CREAT" in arguments:
            unflushed_paths.add(named_paths[0])
            torn_paths |= {named_paths[0]} if "O_TRUNC" in arguments else set()
        elif name in {"fsync", "fdatasync"}:
            torn_paths.discard(opened_paths[0])
            unflushed_paths = {path for path in unflushed_paths if path.parent != opened_paths[0]}
        elif name.startswith("rename"):
            old_path, new_path = named_paths
            rename_count += new_path.is_relative_to(root)
            if visible([new_path]):
                paths_inside = (
                    path
                    for path in unflushed_paths
                    if path != old_path and path.is_relative_to(old_path)
                )
                paths_beside = (
                    path
                    for path in visible(unflushed_paths)
                    if path.parent == new_path.parent and path != old_path
                )
                faults += [f"renamed with {path} not flushed" for path in paths_inside]
                faults += [f"{new_path} may be there without {path}" for path in paths_beside]
            torn_paths, unflushed_paths = (
                {
                    new_path / path.relative_to(old_path) if path.is_relative_to(old_path) else path
                    for path in paths
                }
                for paths in (torn_paths, unflushed_paths)
            )
            unflushed_paths.add(new_path)
        elif name.startswith(("mkdir", "symlink")):
            unflushed_paths.add(named_paths[-1])
        elif name.startswith("unlink"):
            torn_paths, unflushed_paths = (
                {path for path in paths if not path.is_relative_to(named_paths[0])}
                for paths in (torn_paths, unflushed_paths)
            )
        faults += [f"torn: {path} after {line}" for path in visible(torn_paths)]
    return faults + [f"may be missing: {path}" for path in visible(unflushed_paths)], rename_count


BEGIN = f"""
import sys
sys.path[:0] = [{str(ROOT / "workflow")!r}, {str(ROOT / "tests/helpers")!r}]
from pathlib import Path
from oilfilm.base import atomic_write
"""
TABLES = """
from oilfilm import tables
for text in ("first\\n", "second\\n"):
    atomic_write.write_text(text, Path("promised/listing.txt"))
    tables.write(tables.empty_table("runs"), "runs", Path("promised/tables/runs.parquet"), {})
    with atomic_write.atomic_folder(Path("promised/exports")) as folder:
        (folder / "inner").mkdir()
        (folder / "inner" / "law.h").write_text(text)
"""
RELEASE = """
from oilfilm.releases.release import make_release
from oilfilm.settings.resolve import resolve
from oilfilm import tables
from releases import finished_run, list_files_as_made, project
from campaigns import LABORATORY
settings = resolve(LABORATORY, {})
no_runs = {"runs": tables.empty_table("runs")}
run = finished_run(project(Path("project")), settings, {"a.csv": b"1"}, no_runs)
list_files_as_made(run)
make_release(run, Path("promised"))
"""


def after_failures(program: str, folder: Path) -> tuple[list[str], int]:
    strace_command = [
        "strace",
        "-f",
        "-y",
        "-s",
        "4096",
        "-e",
        f"trace={CALLS}",
        "-o",
        folder / "calls",
    ]
    succeeded([*strace_command, sys.executable, "-c", BEGIN + program], cwd=folder)
    calls = (folder / "calls").read_text(encoding="utf-8", errors="replace").splitlines()
    return replay(calls, PurePosixPath(folder / "promised"))


@pytest.mark.slow
def test_files_tables_and_releases_are_old_or_new(tmp_path: Path) -> None:
    faults, rename_count = after_failures(TABLES + RELEASE, tmp_path)
    assert faults == []
    assert rename_count >= 8
    assert (tmp_path / "promised/latest/manifest.json").is_file()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("program", "fault"),
    [
        ("atomic_write._flush_entry = lambda path: None\n" + TABLES, "may be missing: "),
        ("Path('promised').mkdir(); Path('promised/a').write_text('a')\n", "torn: .*promised/a"),
    ],
    ids=["names are not flushed", "written in place"],
)
def test_what_is_not_flushed_is_found(tmp_path: Path, program: str, fault: str) -> None:
    faults, _ = after_failures(program, tmp_path)
    assert any(re.match(fault, found_fault) for found_fault in faults)
