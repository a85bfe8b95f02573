"""`oilfilm watch`: a verdict on every finished log, found again from the files at each start."""

import errno
import os
import re
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from datetime import datetime
from pathlib import Path

import pytest
import yaml

from bad_logs import changed, csv
from campaigns import ROOT
from nights import nightly
from oilfilm.cli import main, watch, watching
from oilfilm.cli.watch_page import watch_page
from oilfilm.cli.watching import Verdict, Watcher
from oilfilm.settings.resolve import resolve

NOW = datetime(2026, 6, 2, 14, 5)
CAMPAIGN = {
    "description": "a rig in June",
    "data": "measured",
    "rigs": ["ball-on-disc-20mm"],
    "oils": ["4102"],
    "figures": ["curves"],
    # not in ascending order, in which a table would be
    "matrix": {
        "max_hertz_pressure_gpa": [1.25, 1.0],
        "entrainment_speed_m_s": [30],
        "inlet_temperature_c": [70, 50],
    },
}
GOOD = csv()
REVERSED = csv(changed("traction_force", lambda force: -force))
# As Windows has it: without modules of Unix, with a console and files in its code page. A Ctrl-C
# comes when the file `stop` is there, because one process cannot send it to another on Windows.
AS_ON_WINDOWS = """
import _thread, pathlib, signal, sys, threading, time
# a shell starts what runs in the background without Ctrl-C
signal.signal(signal.SIGINT, signal.default_int_handler)
for name in ("fcntl", "grp", "pwd", "resource", "termios"):
    sys.modules[name] = None
stop = pathlib.Path("stop")
def interrupt():
    while not stop.exists():
        time.sleep(0.05)
    _thread.interrupt_main()
threading.Thread(target=interrupt, daemon=True).start()
from oilfilm.cli import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A project folder with the campaign `june`, whose logs are to come."""
    # a slow machine must not divide a look
    monkeypatch.setattr(watching, "_LONGEST_LOOK_S", 1e9)
    (tmp_path / "config/campaigns").mkdir(parents=True)
    (tmp_path / "config/config.yaml").write_bytes(b"campaign: june\r\n")
    write_campaign(tmp_path, CAMPAIGN)
    (tmp_path / "data/raw/june").mkdir(parents=True)
    return tmp_path


def write_campaign(project: Path, campaign: dict[str, object]) -> None:
    text = yaml.safe_dump(campaign).replace("\n", "\r\n")
    (project / "config/campaigns/june.yaml").write_bytes(text.encode())


def put(project: Path, name: str, content: bytes, minute: int = 0) -> Path:
    """A log that was written at 14:00 and some minutes."""
    path = project / "data/raw/june" / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    written = NOW.replace(minute=minute).timestamp()
    os.utime(path, (written, written))
    return path


def watcher_of(project: Path) -> Watcher:
    return Watcher(resolve(project / "config", {}), project / "data/raw", settle_s=0.01)


def looked(watcher: Watcher) -> list[Verdict]:
    """The verdicts of two looks, between which every file has settled."""
    first = list(watcher.look())
    time.sleep(0.02)
    return first + list(watcher.look())


def page_of(watcher: Watcher) -> str:
    return watch_page(watcher, watcher.notes, NOW)


def next_steps(watcher: Watcher) -> list[str]:
    """What the page says to do, in its order."""
    page = page_of(watcher)
    first = re.findall(r'class="what">(.*?)<', page)
    return first + re.findall(r"<li>(.*?)<br>", page[: page.index("<h2>Coverage")])


def test_verdict_is_that_of_check_with_reason_and_advice(
    project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    put(project, "a.csv", GOOD)
    refused = put(project, "b.csv", REVERSED, minute=1)
    lines = [str(verdict) for verdict in looked(watcher_of(project))]
    # the newest first; the good run has levels at slips of 0, 5, 10 and 20 %
    assert lines[1] == "june/a.csv: ACCEPTED, 4 of 4 plateaus"
    assert lines[0].startswith("june/b.csv: REFUSED, 0 of ")
    assert main(["check", "--config", str(project / "config"), str(refused)]) == 1
    shown = " ".join(capsys.readouterr().out.split())
    first, _, more = lines[0].partition("; ")[2].partition(" (and ")
    assert more == "1 more)"  # plateaus of a reversed force have an impossible traction as well
    reason, _, advice = first.partition(" -> ")
    assert "swapped_sign" in reason
    assert f"{reason} -> {advice}" in shown


def test_refused_conditions_come_first_then_missing_ones_in_the_order_of_the_matrix(
    project: Path,
) -> None:
    watcher = watcher_of(project)
    looked(watcher)
    assert next_steps(watcher) == [
        f"Run oil 4102 at P = {p} GPa, U = 30 m/s, T = {t} degC"
        for p, t in (("1.25", 70), ("1.25", 50), ("1", 70), ("1", 50))
    ]
    put(project, "bad.csv", REVERSED)
    put(project, "cut.bin", bytes(range(256)), minute=1)
    looked(watcher)
    assert next_steps(watcher) == [
        "Repeat oil 4102 at P = 1.25 GPa, U = 30 m/s, T = 70 degC",
        "Mend or repeat june/cut.bin",
        "Run oil 4102 at P = 1.25 GPa, U = 30 m/s, T = 50 degC",
        "Run oil 4102 at P = 1 GPa, U = 30 m/s, T = 70 degC",
        "Run oil 4102 at P = 1 GPa, U = 30 m/s, T = 50 degC",
    ]
    put(project, "again.csv", GOOD, minute=2)
    looked(watcher)
    assert next_steps(watcher)[0] == "Mend or repeat june/cut.bin"
    page = page_of(watcher)
    assert page.count('<td class="accepted">') == 1
    assert page.count('<td class="missing">') == 3
    assert page.index("june/again.csv") < page.rindex("june/cut.bin") < page.rindex("june/bad.csv")


def test_growing_log_waits_and_a_changed_one_is_judged_again(project: Path) -> None:
    watcher = watcher_of(project)
    half = len(GOOD) // 2
    put(project, "a.csv", GOOD[:half])
    assert list(watcher.look()) == []
    assert watcher.writing == ["june/a.csv"]
    assert "being written</span> june/a.csv" in page_of(watcher)
    time.sleep(0.02)
    put(project, "a.csv", GOOD[: half + 1000], minute=1)
    assert list(watcher.look()) == []
    (verdict,) = looked(watcher)
    assert "truncated" in str(verdict)
    put(project, "a.csv", GOOD, minute=2)
    assert list(watcher.look()) == []
    assert not watcher.verdicts
    (verdict,) = looked(watcher)
    assert verdict.verdict == "accepted"
    assert looked(watcher) == []


def test_many_old_logs_do_not_keep_a_new_one_waiting(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(watching, "_LONGEST_LOOK_S", 0)
    for minute in range(3):
        put(project, f"{minute}.csv", b"no log", minute)
    watcher = watcher_of(project)
    assert [each.log for each in looked(watcher)] == ["june/2.csv"]
    put(project, "new.csv", b"no log", minute=3)
    assert [each.log for each in looked(watcher)] == ["june/1.csv", "june/new.csv"]
    assert [each.log for each in looked(watcher)] == ["june/0.csv"]
    assert not watcher.waiting


def test_restart_finds_the_same_and_lost_logs_disappear(project: Path) -> None:
    put(project, "a.csv", GOOD)
    moved = put(project, "b.csv", REVERSED, minute=1)
    gone = put(project, "c.csv", b"no log", minute=2)
    watcher, again = watcher_of(project), watcher_of(project)
    looked(watcher)
    looked(again)
    assert len(watcher.verdicts) == 3
    assert page_of(again) == page_of(watcher)
    gone.unlink()
    moved.rename(moved.with_name("d.csv"))
    assert [verdict.log for verdict in looked(watcher)] == ["june/d.csv"]
    page = page_of(watcher)
    assert "c.csv" not in page
    assert "b.csv" not in page
    assert "2 logs judged" in page


def test_hostile_names_and_contents_are_text(project: Path) -> None:
    if os.name != "nt":  # Windows has no such names
        put(project, "<img src=x onerror=alert(1)>.csv", GOOD)
    put(project, "a&b.csv", csv(oil="<script>alert(2)</script>\N{RIGHT-TO-LEFT OVERRIDE}"))
    watcher = watcher_of(project)
    verdicts = {each.log: each for each in looked(watcher)}
    assert {each.verdict for each in verdicts.values()} == {"refused"}
    page = page_of(watcher)
    assert "<img" not in page
    assert page.count("<script>") == 1  # the page's own
    assert "&lt;script&gt;alert(2)" in page
    assert "a&amp;b.csv" in page
    assert "\N{RIGHT-TO-LEFT OVERRIDE}" not in page + "".join(map(str, verdicts.values()))


def test_run_sheet_judges_anew_the_logs_that_it_is_about(project: Path) -> None:
    put(project, "a.csv", GOOD)
    put(project, "b.csv", GOOD, minute=1)
    watcher = watcher_of(project)
    assert len(looked(watcher)) == 2
    put(project, "runs.csv", b"file;oil;exclude\r\na.csv;4102;wrong ball\r\nb.csv;4102;\r\n")
    assert {each.log: each.verdict for each in looked(watcher)} == {"june/a.csv": "refused"}
    put(project, "runs.csv", b"file;oil;exclude\r\na.csv;4102;\r\nb.csv;4102;\r\n", minute=1)
    assert [each.log for each in looked(watcher)] == ["june/a.csv"]
    put(project, "runs.csv", b"nothing;known\r\n1;2\r\n", minute=2)
    put(project, "c.csv", GOOD, minute=3)
    assert looked(watcher) == []
    (note,) = watcher.notes
    assert "runs.csv" in note
    put(project, "runs.csv", b"file;oil\r\nc.csv;4102\r\n", minute=4)
    assert "june/c.csv" in {each.log for each in looked(watcher)}
    assert not watcher.notes


def test_log_that_cannot_be_read_is_tried_again(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As on Windows while the program of the rig holds the file."""
    path, usual = put(project, "a.csv", GOOD), Path.open

    def held(self: Path, *arguments: object) -> object:
        if self == path:
            raise PermissionError(errno.EACCES, "Permission denied", str(self))
        return usual(self, *arguments)

    watcher = watcher_of(project)
    with monkeypatch.context() as patch:
        patch.setattr(Path, "open", held)
        (verdict,) = looked(watcher)
        assert (verdict.verdict, watcher.waiting) == ("not judged", True)
        assert "a.csv: cannot be read (Permission denied)" in str(verdict)
        assert looked(watcher) == []
        assert "? </span>" not in page_of(watcher)
    (verdict,) = looked(watcher)
    assert verdict.verdict == "accepted"


def test_defect_in_one_log_does_not_end_the_watch(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise ZeroDivisionError("planted")

    put(project, "a.csv", GOOD)
    monkeypatch.setattr("oilfilm.cli.watching.check_logs", fail)
    (verdict,) = looked(watcher_of(project))
    assert "a defect of oilfilm: ZeroDivisionError: planted -> Run `oilfilm check`" in str(verdict)


def test_missing_folder_is_named_until_it_is_there(project: Path) -> None:
    (project / "data/raw/june").rmdir()
    watcher = watcher_of(project)
    assert looked(watcher) == []
    assert "there is no such folder" in page_of(watcher)
    put(project, "a.csv", GOOD)
    assert len(looked(watcher)) == 1
    assert not watcher.notes


def test_campaign_without_a_matrix_names_refused_logs_only(project: Path) -> None:
    write_campaign(project, {key: CAMPAIGN[key] for key in CAMPAIGN if key != "matrix"})
    put(project, "a.csv", GOOD)
    watcher = watcher_of(project)
    looked(watcher)
    assert "has no <code>matrix</code>, and no log is refused" in page_of(watcher)
    put(project, "b.csv", csv(inlet_temperature_c=20), minute=1)
    looked(watcher)
    assert next_steps(watcher) == ["Mend or repeat june/b.csv"]


def run_steps(monkeypatch: pytest.MonkeyPatch, project: Path, *steps: Callable[[], object]) -> int:
    """Exit code of `oilfilm watch`, which meets each step where it would wait; then Ctrl-C."""

    def waits() -> Iterator[None]:
        for step in steps:
            step()
            yield
            time.sleep(0.02)
            yield
        raise KeyboardInterrupt

    wait = waits()
    monkeypatch.setattr(watch, "_wait", lambda _: next(wait))
    monkeypatch.chdir(project)
    return main(["watch", "--settle", "0.01", "--page", "page/watch.html"])


def test_settings_are_read_again_when_they_change(
    project: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    put(project, "a.csv", csv(lubricant="4010", oil=None))
    more = {**CAMPAIGN, "oils": ["4102", "4010"], "header": {"oil": "lubricant"}}
    code = run_steps(
        monkeypatch,
        project,
        lambda: None,
        lambda: write_campaign(project, {**CAMPAIGN, "oils": 7}),
        lambda: write_campaign(project, more),
        lambda: None,
    )
    out = capsys.readouterr().out
    assert code == 130
    before, _, after = out.partition("All logs are judged again.")
    assert "june/a.csv: REFUSED" in before
    assert before.count("Until then the settings before count.") == 1
    assert "june/a.csv: ACCEPTED" in after
    page = (project / "page/watch.html").read_text(encoding="utf-8")
    assert "Stopped." in page


def test_page_that_cannot_be_written_is_named_once_and_later_written(
    project: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    fsync = os.fsync
    monkeypatch.setattr(os, "fsync", fail)
    code = run_steps(
        monkeypatch,
        project,
        lambda: put(project, "a.csv", GOOD),
        lambda: monkeypatch.setattr(os, "fsync", fsync),
    )
    out = capsys.readouterr().out
    assert code == 130
    assert out.count("the page cannot be written (No space left on device)") == 1
    assert "june/a.csv: ACCEPTED" in out
    assert [path.name for path in (project / "page").iterdir()] == ["watch.html"]


@pytest.mark.parametrize("text", ["0", "-1", "nan", "soon"])
def test_settling_time_must_be_positive(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["watch", "--settle", text])
    assert f"found {text!r}; expected seconds above 0" in capsys.readouterr().err


def as_on_windows(*arguments: str) -> list[str]:
    # no file may be read in whatever encoding the system has
    python = [sys.executable, "-X", "warn_default_encoding", "-W", "error::EncodingWarning"]
    return [*python, "-c", AS_ON_WINDOWS, *arguments]


def environment(code_page: str) -> dict[str, str]:
    return {**os.environ, "PYTHONIOENCODING": code_page, "PYTHONPATH": str(ROOT / "workflow")}


def german() -> bytes:
    """A log as a German Windows program writes it: its code page, its line ends, a Greek name."""
    lines = csv(bemerkung="Öl für Prüfstand 3, 70 °C").decode().splitlines()
    return "".join(f"{line}\r\n" for line in lines).encode("cp1252")


@pytest.mark.parametrize("code_page", ["cp437", nightly("cp1252"), nightly("cp850")])
def test_check_needs_nothing_of_unix_and_prints_in_any_code_page(
    project: Path, code_page: str
) -> None:
    put(project, "Öl λ.csv", german())
    done = subprocess.run(
        as_on_windows("check", str(Path("data/raw/june/Öl λ.csv"))),
        cwd=project,
        env=environment(code_page),
        capture_output=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, b"")
    out = done.stdout.decode(code_page)
    # no code page of them has a lambda
    assert "l \\u03bb.csv: ACCEPTED, 4 of 4 plateaus" in out


def test_log_that_is_written_slowly_gets_one_verdict_when_it_is_finished(project: Path) -> None:
    """The command as it is used, in a process of its own, without any module of Unix."""
    put(project, "before.csv", REVERSED)
    page, out = project / "results/june/watch.html", project / "out.txt"
    finished = threading.Event()

    def log() -> None:
        content = german()
        pieces = 20
        with (project / "data/raw/june/Öl λ.csv").open("wb") as file:
            for piece in range(pieces):
                file.write(content[piece * len(content) // pieces :][: len(content) // pieces + 1])
                file.seek((piece + 1) * len(content) // pieces)
                file.flush()
                time.sleep(0.1)
        finished.set()

    def until(found: Callable[[], bool]) -> None:
        end = time.monotonic() + 120
        while not found():
            assert process.poll() is None, out.read_text(encoding="cp1252")
            assert time.monotonic() < end, out.read_text(encoding="cp1252")
            time.sleep(0.05)

    def printed() -> str:
        return out.read_text(encoding="cp1252")

    with out.open("wb") as output:
        process = subprocess.Popen(
            as_on_windows("watch", "--campaign", "june"),
            cwd=project,
            env=environment("cp1252"),
            stdout=output,
            stderr=subprocess.STDOUT,
        )
    try:
        until(lambda: "june/before.csv: REFUSED" in printed())
        writer = threading.Thread(target=log)
        writer.start()
        until(lambda: "being written" in page.read_text(encoding="utf-8").partition("Verdicts")[2])
        until(lambda: "\\u03bb.csv: " in printed())
        assert finished.is_set()
        writer.join()
        until(lambda: "1 accepted" in page.read_text(encoding="utf-8").replace("</span>", ""))
    finally:
        (project / "stop").touch()
        try:
            code = process.wait(60)
        finally:
            process.kill()
            process.wait()
    assert code == 130
    lines = [line for line in printed().splitlines() if "03bb" in line]
    assert [line.partition(" ")[2] for line in lines] == [
        "june/Öl \\u03bb.csv: ACCEPTED, 4 of 4 plateaus"
    ]
    assert "Stopped." in page.read_text(encoding="utf-8")
    assert "Öl λ.csv" in page.read_text(encoding="utf-8")
