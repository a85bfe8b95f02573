"""Which files count as logs, and that no path leads out of the raw folder."""

import errno
import os
import tempfile
from collections.abc import Callable
from itertools import chain
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nights import examples
from oilfilm.base.errors import OilfilmError
from oilfilm.logs import raw_files

LOGS = ["12:30 \u6cb9.csv", "a.csv", "a/z.csv", "june/a.csv", "june/runs.csv"]
OTHERS = ["README.md", "README", ".hidden.csv", "runs.csv", "~$a.xlsx", "june/.x"]


@examples(0.5)
@given(st.sets(st.sampled_from(LOGS), min_size=1), st.sets(st.sampled_from(OTHERS)))
def test_every_file_is_a_log_or_passed_over_by_its_name(logs: set[str], others: set[str]) -> None:
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for name in logs | others:
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_text("x")
        assert raw_files.raw_log_names(folder) == sorted(logs, key=lambda name: Path(name).parts)
        assert {
            name for name in logs | others if raw_files.is_passed_over(folder / name, folder)
        } == others


@pytest.mark.parametrize("name", [b"{a}.csv", b"a\\b.csv", b"a\nb.csv", b"\xe4.csv"])
def test_name_that_a_release_could_not_hold_is_refused(tmp_path: Path, name: bytes) -> None:
    try:
        (tmp_path / os.fsdecode(name)).write_text("x")
    except (OSError, ValueError):
        pytest.skip("this file system has no such names")
    with pytest.raises(OilfilmError, match="Rename it"):
        raw_files.raw_log_names(tmp_path)


def test_name_of_a_log_is_one_line_of_a_listing() -> None:
    all_characters = "".join(map(chr, range(1 << 16)))
    line_ends = {line[-1] for line in all_characters.splitlines(keepends=True)[:-1]}
    assert all(raw_files.name_fault(f"a{line_end}b.csv", "p") for line_end in line_ends)


def dangling(path: Path) -> None:
    path.symlink_to("not-fetched.csv")


def to_secret(path: Path) -> None:
    (path.parent.parent / "secret.csv").write_text("x")
    path.symlink_to(path.parent.parent / "secret.csv")


@pytest.mark.parametrize(
    ("make", "problem"),
    [
        (dangling, "is a link to a file that is not there"),
        (to_secret, "leads out of"),
        (lambda path: path.symlink_to(path.parent), "is a link to a folder"),
        (os.mkfifo, "is a pipe or a device"),
    ],
)
def test_log_that_cannot_be_reached_is_named_and_never_left_out(
    tmp_path: Path, make: Callable[[Path], None], problem: str
) -> None:
    folder = tmp_path / "raw"
    folder.mkdir()
    (folder / "good.csv").write_text("x")
    make(folder / "log.csv")
    make(folder / "other.csv")
    with pytest.raises(OilfilmError) as error:
        raw_files.raw_log_names(folder)
    assert [problem in line for line in str(error.value).splitlines()] == [True, True]


@pytest.mark.parametrize(
    ("owner", "operation", "denied", "named"),
    [
        (os, "scandir", "raw/june", "raw/june"),
        (os, "scandir", "raw", "raw"),
        # a folder that may be listed and not entered
        (Path, "stat", "raw/june/a.csv", "raw/june/a.csv"),
        (Path, "stat", "raw/runs.csv", "raw/runs.csv"),
    ],
    ids=["subfolder", "raw folder", "file of a folder", "run sheet"],
)
def test_path_without_rights_is_named(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    owner: Any,
    operation: str,
    denied: str,
    named: str,
) -> None:
    """As an ordinary user sees it: tests may run with the rights to read everything."""
    (tmp_path / "raw/june").mkdir(parents=True)
    for name in ("june/a.csv", "b.csv", "runs.csv"):
        (tmp_path / "raw" / name).write_text("x")
    unpatched = getattr(owner, operation)

    def denying(path: Any, *args: Any, **options: Any) -> Any:
        if Path(path) == tmp_path / denied:
            raise PermissionError(errno.EACCES, "Permission denied", str(path))
        return unpatched(path, *args, **options)

    monkeypatch.setattr(owner, operation, denying)
    with pytest.raises(OilfilmError) as error:
        raw_files.raw_log_names(tmp_path / "raw")
        raw_files.find_run_sheet(tmp_path / "raw")
    assert str(error.value).startswith(f"{tmp_path / named}: cannot be read (Permission denied)")


@pytest.mark.parametrize("make", [dangling, to_secret, Path.mkdir, os.mkfifo])
def test_run_sheet_that_is_no_file_of_its_folder_is_named(
    tmp_path: Path, make: Callable[[Path], None]
) -> None:
    folder = tmp_path / "raw"
    folder.mkdir()
    make(folder / "runs.tsv")
    with pytest.raises(OilfilmError, match=r"runs\.tsv: is a "):
        raw_files.find_run_sheet(folder)


def test_log_that_is_added_moves_no_other_one_to_another_share() -> None:
    logs = [f"4102_P1.00_U25_T{number:03d}.csv" for number in range(800)]
    before, after = (
        raw_files.logs_by_share(logs, 100),
        raw_files.logs_by_share([*logs, "x.csv"], 120),
    )
    # 8 shares; a twentieth more is within four standard deviations of chance
    assert all(60 < len(files) < 140 for files in before.values())
    assert sorted(chain.from_iterable(before.values())) == logs
    assert {n: [log for log in files if log != "x.csv"] for n, files in after.items()} == before


def test_shares_double_when_logs_are_more_than_a_share_takes() -> None:
    counts = [
        len(raw_files.logs_by_share([f"{n}.csv" for n in range(logs)], 250))
        for logs in (1, 250, 251, 501)
    ]
    assert counts == [1, 1, 2, 4]
    assert raw_files.logs_by_share([], 250) == {}


# sha256 of "abc", from FIPS 180-2, appendix B.1
ABC = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"


def test_listing_is_what_sha256sum_writes(tmp_path: Path) -> None:
    written = tmp_path / "logs.sha256"
    written.write_text(raw_files.listing_text({"two words.csv": ABC}))
    assert written.read_text() == f"{ABC}  two words.csv\n"
    assert raw_files.read_listings(written) == {"two words.csv": ABC}


def test_logs_are_read_with_the_digests_that_a_job_expects_or_the_twin_wrote(
    tmp_path: Path,
) -> None:
    log, inputs = tmp_path / "a.csv", {}
    log.write_text("abc")

    def logs(**options: Any) -> raw_files.RawLogs:
        folder, paths, expected = Path("data/raw/june"), {"a.csv": log}, {"a.csv": ABC}
        return raw_files.RawLogs(folder, paths, expected, **options)

    read = logs(provenance_digests=inputs)
    assert list(read) == [("a.csv", b"abc")]
    assert read.digest_of_path() == {"data/raw/june/a.csv": ABC}
    assert inputs == {"data/raw/june/a.csv": ABC[:16]}
    inputs.clear()
    assert list(read.select(["a.csv", "b.csv"])) == [("a.csv", b"abc")]
    assert inputs == {"data/raw/june/a.csv": ABC[:16]}
    assert list(logs(is_simulated=True)) == [("a.csv", b"abc")]
    log.write_text("abd")
    with pytest.raises(OilfilmError, match=r"june/a\.csv: "):
        list(logs())
    with pytest.raises(OilfilmError, match=r"a\.csv: .*Delete"):
        list(logs(is_simulated=True))
    log.unlink()
    with pytest.raises(OilfilmError, match=r"a\.csv: cannot be read .* put it back, or run"):
        list(logs())


def test_log_larger_than_any_is_listed_with_the_digest_of_all_of_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(raw_files, "LARGEST_LOG_BYTES", 1)
    log = tmp_path / "a.csv"
    log.write_text("abc")
    logs = raw_files.RawLogs(Path("data/raw/june"), {"a.csv": log}, {"a.csv": ABC})
    assert list(logs) == [("a.csv", b"ab")]
