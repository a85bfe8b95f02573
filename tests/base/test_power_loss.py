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
from reproduce import works

pytestmark = pytest.mark.skipif(
    not works(["strace", "-o", "/dev/null", "true"]), reason="strace is missing or may not trace"
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
    torn: set[PurePosixPath] = set()
    loose: set[PurePosixPath] = set()
    faults: list[str] = []
    renames = 0

    def visible(paths: Iterable[PurePosixPath]) -> list[PurePosixPath]:
        below = (path for path in paths if path.is_relative_to(root))
        return [p for p in below if not any(x.startswith(".") for x in p.relative_to(root).parts)]

    for line in calls:
        if not (call := _CALL.match(line)):
            continue
        name, arguments = call["name"], call["arguments"]
        opened = [PurePosixPath(each["path"]) for each in _OPENED.finditer(arguments)]
        above = opened[0] if opened else root.parent
        named = [above / each["path"] for each in _QUOTED.finditer(arguments)]
        if name in _WRITES:
            torn.add(opened[0])
        elif name == "copy_file_range":
            torn.add(opened[1])
        elif name == "openat" and "O_CREAT" in arguments:
            loose.add(named[0])
            torn |= {named[0]} if "O_TRUNC" in arguments else set()
        elif name in {"fsync", "fdatasync"}:
            torn.discard(opened[0])
            loose = {path for path in loose if path.parent != opened[0]}
        elif name.startswith("rename"):
            old, new = named
            renames += new.is_relative_to(root)
            if visible([new]):
                inside = (path for path in loose if path != old and path.is_relative_to(old))
                beside = (p for p in visible(loose) if p.parent == new.parent and p != old)
                faults += [f"renamed with {path} not flushed" for path in inside]
                faults += [f"{new} may be there without {path}" for path in beside]
            torn, loose = (
                {new / p.relative_to(old) if p.is_relative_to(old) else p for p in known}
                for known in (torn, loose)
            )
            loose.add(new)
        elif name.startswith(("mkdir", "symlink")):
            loose.add(named[-1])
        elif name.startswith("unlink"):
            torn, loose = (
                {path for path in known if not path.is_relative_to(named[0])}
                for known in (torn, loose)
            )
        faults += [f"torn: {path} after {line}" for path in visible(torn)]
    return faults + [f"may be missing: {path}" for path in visible(loose)], renames


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
    tables.write(tables.empty("runs"), "runs", Path("promised/tables/runs.parquet"), {})
    with atomic_write.atomic_folder(Path("promised/exports")) as folder:
        (folder / "inner").mkdir()
        (folder / "inner" / "law.h").write_text(text)
"""
RELEASE = """
from oilfilm.releases.release import make_release
from oilfilm.settings.resolve import resolve
from oilfilm import tables
from releases import made, made_now, project
from campaigns import LABORATORY
settings = resolve(LABORATORY, {})
run = made(project(Path("project")), settings, {"a.csv": b"1"}, {"runs": tables.empty("runs")})
made_now(run)
make_release(run, Path("promised"))
"""


def after_failures(program: str, folder: Path) -> tuple[list[str], int]:
    strace = ["strace", "-f", "-y", "-s", "4096", "-e", f"trace={CALLS}", "-o", folder / "calls"]
    succeeded([*strace, sys.executable, "-c", BEGIN + program], cwd=folder)
    calls = (folder / "calls").read_text(encoding="utf-8", errors="replace").splitlines()
    return replay(calls, PurePosixPath(folder / "promised"))


def test_files_tables_and_releases_are_old_or_new(tmp_path: Path) -> None:
    faults, renames = after_failures(TABLES + RELEASE, tmp_path)
    assert faults == []
    assert renames >= 8
    assert (tmp_path / "promised/latest/manifest.json").is_file()


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
    assert any(re.match(fault, each) for each in faults)
