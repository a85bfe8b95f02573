"""After a power failure at any system call a file, table or release is old or new, never torn.

The idea is that of SQLite's crash tests: the calls of a real program are replayed against a disk
that keeps no more than it must (tests/helpers/power_loss.py).
"""

import re
from pathlib import Path, PurePosixPath

import pytest

from campaigns import ROOT
from power_loss import replay, trace, traceable

pytestmark = pytest.mark.skipif(
    not traceable(), reason="system calls cannot be listed: strace is missing or may not trace"
)

BEGIN = f"""
import sys
sys.path[:0] = [{str(ROOT / "workflow")!r}, {str(ROOT / "tests/helpers")!r}]
from pathlib import Path
from oilfilm import atomic_write
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
from campaigns import ROOT
settings = resolve(ROOT / "config", {"campaign": "demo"})
run = made(project(Path("project")), settings, {"a.csv": b"1"}, {"runs": tables.empty("runs")})
made_now(run)
make_release(run, Path("promised"))
"""


def after_failures(program: str, folder: Path) -> tuple[list[str], int]:
    calls = trace(BEGIN + program, folder, folder / "calls")
    return replay(calls, PurePosixPath(folder / "promised"))


def test_files_tables_and_folders_are_old_or_new(tmp_path: Path) -> None:
    assert after_failures(TABLES, tmp_path) == ([], 6)


def test_release_and_the_link_to_it_are_whole(tmp_path: Path) -> None:
    faults, renames = after_failures(RELEASE, tmp_path)
    assert faults == []
    assert renames >= 2
    assert (tmp_path / "promised/latest/manifest.json").is_file()


@pytest.mark.parametrize(
    ("program", "fault"),
    [
        ("atomic_write._flush = lambda path: None\n" + TABLES, "may be missing: "),
        ("Path('promised').mkdir(); Path('promised/a').write_text('a')\n", "torn: .*promised/a"),
    ],
    ids=["names are not flushed", "written in place"],
)
def test_what_is_not_flushed_is_found(tmp_path: Path, program: str, fault: str) -> None:
    faults, _ = after_failures(program, tmp_path)
    assert any(re.match(fault, each) for each in faults)
