"""`oilfilm watch`: a verdict on every finished log, found again from the files at each start."""

import errno
import os
import subprocess
import sys
import time
from datetime import datetime
from pathlib import Path

import pytest
import yaml

from bad_logs import changed, csv, good
from campaigns import ROOT
from oilfilm.cli import main, watch
from oilfilm.cli.watch import Watcher
from oilfilm.settings.resolve import resolve

CAMPAIGN = {
    **{"description": "a rig in June", "data": "measured", "rigs": ["ball-on-disc-20mm"]},
    **{"oils": ["4102"], "figures": ["curves"]},
}
GOOD = csv()
# the good run has levels at slips of 0, 5, 10 and 20 %
ACCEPTED = f"ACCEPTED, 4 of 4 plateaus, {len(good()['time'])} rows"
REVERSED = csv(changed("traction_force", lambda force: -force))


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A project folder with the campaign `june`, whose logs are to come."""
    (tmp_path / "config/campaigns").mkdir(parents=True)
    (tmp_path / "config/config.yaml").write_bytes(b"campaign: june\r\n")
    write_campaign(tmp_path, CAMPAIGN)
    (tmp_path / "data/raw/june").mkdir(parents=True)
    return tmp_path


def write_campaign(project: Path, campaign: dict[str, object]) -> None:
    text = yaml.safe_dump(campaign).replace("\n", "\r\n")
    (project / "config/campaigns/june.yaml").write_bytes(text.encode())


def put(project: Path, name: str, content: bytes, minute: int = 0) -> Path:
    """A log that was written some minutes after 14:05."""
    path = project / "data/raw/june" / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    written = datetime(2026, 6, 2, 14, 5 + minute).timestamp()
    os.utime(path, (written, written))
    return path


def watcher_of(project: Path) -> Watcher:
    return Watcher(resolve(project / "config", {}), project / "data/raw", settle_s=0.01)


def looked(watcher: Watcher) -> list[str]:
    """What two looks give, between which every file has settled."""
    first_verdicts = list(watcher.look())
    time.sleep(0.02)
    return first_verdicts + list(watcher.look())


@pytest.mark.slow
def test_verdict_is_that_of_check(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    put(project, "a.csv", GOOD)
    refused_log = put(project, "b.csv", REVERSED, minute=1)
    newest_verdict, older_verdict = looked(watcher_of(project))
    assert older_verdict == f"{project}/data/raw/june/a.csv: {ACCEPTED}"
    assert main(["check", "--config", str(project / "config"), str(refused_log)]) == 1
    assert capsys.readouterr().out.startswith(newest_verdict)
    assert "  swapped_sign: " in newest_verdict


def test_folder_without_a_project_is_not_watched_by_the_demonstration(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["watch"]) == 2
    assert "oilfilm init" in capsys.readouterr().err


def test_growing_log_waits_and_a_changed_one_is_judged_again(project: Path) -> None:
    watcher, half = watcher_of(project), len(GOOD) // 2
    for minute, end in enumerate((half, half + 1000)):
        put(project, "a.csv", GOOD[:end], minute)
        assert list(watcher.look()) == []
        time.sleep(0.02 * (minute == 0))
    (line,) = looked(watcher)
    assert "truncated" in line
    put(project, "a.csv", GOOD, minute=2)
    (line,) = looked(watcher)
    assert ACCEPTED in line
    assert looked(watcher) == []


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such names")
def test_hostile_names_and_contents_are_shown_as_text(
    project: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    name = "a\x1b[2J.csv"
    put(project, name, csv(oil="4102\N{RIGHT-TO-LEFT OVERRIDE}\x1b]0;title\x07"))
    waits, sleep = iter([0.02, 0.02]), time.sleep

    def wait(_: float) -> None:
        if (seconds := next(waits, None)) is None:
            raise KeyboardInterrupt
        sleep(seconds)

    monkeypatch.setattr(time, "sleep", wait)
    monkeypatch.chdir(project)
    assert main(["watch", "--settle", "0.01"]) == 130
    out = capsys.readouterr().out
    assert "REFUSED" in out
    assert not {"\x1b", "\x07", "\N{RIGHT-TO-LEFT OVERRIDE}"} & set(out)


@pytest.mark.slow
def test_run_sheet_judges_anew_the_logs_that_it_is_about(project: Path) -> None:
    put(project, "a.csv", GOOD)
    put(project, "b.csv", b"no log", minute=1)
    watcher = watcher_of(project)
    assert len(looked(watcher)) == 2
    put(project, "runs.csv", b"file;oil;exclude\r\na.csv;4102;wrong ball\r\n")
    excluded, _ = sorted(looked(watcher))
    assert "june/a.csv: REFUSED" in excluded
    put(project, "runs.csv", b"nothing;known\r\n1;2\r\n", minute=2)
    (mistake,) = looked(watcher)
    assert "runs.csv" in mistake
    put(project, "runs.csv", b"file;oil;exclude\r\na.csv;4102;\r\n", minute=4)
    (line,) = looked(watcher)
    assert ACCEPTED in line


def test_locked_log_does_not_end_the_watch(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As on Windows while the program of the rig holds the file."""

    def denied(path: Path) -> None:
        raise PermissionError(errno.EACCES, "Permission denied", str(path))

    put(project, "a.csv", GOOD)
    watcher = watcher_of(project)
    with monkeypatch.context() as patch:
        patch.setattr(watch, "read_bytes", denied)
        (line,) = looked(watcher)
        assert "a.csv: NOT JUDGED: PermissionError(13, 'Permission denied')" in line
        assert looked(watcher) == []  # tried again, said once
    (line,) = looked(watcher)
    assert ACCEPTED in line
    # a new verdict is due: that it is not possible is said again
    put(project, "a.csv", GOOD + b"\n", minute=2)
    with monkeypatch.context() as patch:
        patch.setattr(watch, "read_bytes", denied)
        (line,) = looked(watcher)
        assert "a.csv: NOT JUDGED" in line


WITHOUT_UNIX = """
import sys
for name in ("fcntl", "grp", "pwd", "resource", "termios"):
    sys.modules[name] = None
from oilfilm.cli import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.nightly
@pytest.mark.parametrize("code_page", ["cp437", "cp1252", "cp850"])
def test_check_needs_no_unix_and_prints_in_any_code_page(project: Path, code_page: str) -> None:
    """As on Windows, with a console and files in its code page."""
    lines = csv(bemerkung="Öl für Prüfstand 3, 70 °C").decode().splitlines()
    put(project, "Öl λ.csv", "".join(f"{line}\r\n" for line in lines).encode("cp1252"))
    # no file may be read in whatever encoding the system has
    python = [sys.executable, "-X", "warn_default_encoding", "-W", "error::EncodingWarning"]
    environment = {"PYTHONIOENCODING": code_page, "PYTHONPATH": str(ROOT / "workflow")}
    done = subprocess.run(
        [*python, "-c", WITHOUT_UNIX, "check", str(Path("data/raw/june/Öl λ.csv"))],
        cwd=project,
        env={**os.environ, **environment},
        capture_output=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, b"")
    # no code page of them has a lambda
    assert f"l \\u03bb.csv: {ACCEPTED}" in done.stdout.decode(code_page)
