"""`oilfilm init` asks for what only the laboratory knows until `oilfilm check` accepts the logs."""

import errno
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import standstill
from bad_logs import UNITS, good, pcs
from formats import csv
from oilfilm.base.errors import OilfilmError
from oilfilm.cli import main
from oilfilm.cli.dialogue import (
    FILL_IN,
    OpenLine,
    ProjectCheck,
    check_project,
    open_lines,
    outcome_lines,
)
from oilfilm.cli.dialogue import _ask_about_settled_rows as ask_about_settled_rows
from oilfilm.cli.dialogue import _value_of_answer as value_of_answer
from oilfilm.cli.init import _semantics_lines as semantics_lines
from oilfilm.cli.init import make_project
from oilfilm.logs.base import NO_DIALECT
from oilfilm.logs.sniff import Findings, SniffedLog, SniffedRun

# Names in Japanese, but that of the ball, which is Finnish: no list of words has it.
FOREIGN = {
    "time": "時間(s)",
    "load": "荷重(N)",
    "traction_force": "摩擦力(N)",
    "ball_speed": "Kuula(rpm)",
    "disc_speed": "ディスク回転数(rpm)",
    "inlet_temperature": "油温(℃)",
}
# Track radii of the rig of the good log: docs/physics.md.
TRACKS = {"ball_track_radius_m": "10 mm", "disc_track_radius_m": "0.04"}
REASON = "thick by experience"


class Person:
    """Answers by the key that is asked for; a key with several answers gives one after the other.

    Attributes:
        asked: The keys that were asked for.
    """

    def __init__(self, answers: dict[str, str | list[str]]) -> None:
        self.asked: list[str] = []
        self._answers: dict[str, Iterator[str]] = {}
        for key, answer in answers.items():
            self._answers[key] = iter([answer] if isinstance(answer, str) else answer)
        self._key = ""

    def hear(self, line: object = "") -> None:
        """What the program prints."""
        text = str(line)
        if ", line " in text:
            self._key = text.rpartition(": ")[2]

    def answer(self, prompt: str) -> str:
        """The answer to a question."""
        self.asked.append(self._key)
        return next(self._answers.get(self._key, iter([])), "")


def foreign_log(folder: Path) -> Path:
    path = folder / "log.csv"
    text = csv({name: np.round(values, 4) for name, values in good().items()}, UNITS, {})
    lines = text.decode().splitlines()
    name_line_index = next(index for index, line in enumerate(lines) if line.startswith("time"))
    lines[name_line_index] = ",".join(FOREIGN[name] for name in good())
    path.write_text("\n".join([*lines, ""]), "utf-8")
    return path


@pytest.fixture
def person(monkeypatch: pytest.MonkeyPatch) -> Person:
    """A person at a terminal who knows the rig."""
    someone = Person({"film_unjudged": REASON, "ball_speed": "Kuula", **TRACKS})
    at_terminal(monkeypatch, someone)
    return someone


def at_terminal(monkeypatch: pytest.MonkeyPatch, someone: Person) -> None:
    real_print = print

    def hear(*values: object, **options: object) -> None:
        for value in values:
            someone.hear(value)
        real_print(*values, **options)

    monkeypatch.setattr("builtins.input", someone.answer)
    monkeypatch.setattr("builtins.print", hear)
    monkeypatch.setattr("oilfilm.cli.init.is_terminal", lambda: True)


def test_conversation_ends_when_check_passes(
    tmp_path: Path, person: Person, capsys: pytest.CaptureFixture[str]
) -> None:
    """The ball's column has a name that no list of words has: its radius is asked for, too."""
    folder = tmp_path / "june"
    assert main(["init", str(folder), str(foreign_log(tmp_path))]) == 0
    assert sorted(person.asked) == sorted([*TRACKS, "ball_speed", "film_unjudged"])
    assert "check: 1 of 1 logs are accepted" in capsys.readouterr().out
    assert main(["check", str(folder / "data/raw/june")]) == 0


@pytest.mark.slow
@pytest.mark.parametrize(("answer", "accepted"), [("yes", 1), ("no", 0), ("", 0)])
def test_rows_that_look_settled_are_asked_about(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    answer: str,
    accepted: int,
) -> None:
    percent = np.array([0.8, 1.5, 2.5, 4, 6, 9, 13, 18, 24, 30])
    mu = 0.067 * np.tanh(0.6 * percent) * np.exp(-0.015 * percent)
    readings = zip(np.arange(10) * 11, percent, mu, strict=True)
    rows = [f"{time},{slip},2.0,{value:.4f},45.6,60" for time, slip, value in readings]
    head = "Time (s),SRR (%),Rolling Speed (m/s),Traction Coeff (-),Ball Load (N),Lube Temp (C)"
    (tmp_path / "log.csv").write_text("\n".join([head, *rows, ""]), encoding="utf-8")
    answers = {"film_unjudged": REASON, "zero": "already_removed", "ball_radius_m": "12.7mm"}
    someone = Person({**answers, "ball": "steel", "disc": "steel", "log_kind": answer})
    at_terminal(monkeypatch, someone)
    assert main(["init", str(tmp_path / "june"), str(tmp_path / "log.csv")]) == 1 - accepted
    assert someone.asked.count("log_kind") == 1
    assert f"check: {accepted} of 1 logs are accepted" in capsys.readouterr().out


def test_impossible_answers_are_asked_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    answers: dict[str, str | list[str]] = {
        "film_unjudged": REASON,
        "ball_speed": ["ball", "Kuula"],
        "ball_track_radius_m": ["10 kg", "ten", "-3", "0.01"],
        "disc_track_radius_m": ["400", "40mm"],
    }
    someone = Person(answers)
    at_terminal(monkeypatch, someone)
    assert main(["init", str(tmp_path / "june"), str(foreign_log(tmp_path))]) == 0
    assert [someone.asked.count(key) for key in answers] == [1, 2, 4, 2]


def test_empty_answer_leaves_a_line_to_fill_in(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    at_terminal(monkeypatch, Person({"film_unjudged": REASON, **TRACKS}))
    assert main(["init", str(tmp_path / "june"), str(foreign_log(tmp_path))]) == 0
    printed = capsys.readouterr().out
    assert "To fill in, because only you can know it: 1" in printed
    assert "Kuula" in printed


def test_answers_before_the_end_of_input_are_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    someone = Person({"film_unjudged": REASON, **TRACKS})
    at_terminal(monkeypatch, someone)

    def answer_until_ctrl_d(prompt: str) -> str:
        if answer := someone.answer(prompt):
            return answer
        raise EOFError

    monkeypatch.setattr("builtins.input", answer_until_ctrl_d)
    assert main(["init", str(tmp_path / "june"), str(foreign_log(tmp_path))]) == 0
    assert "To fill in, because only you can know it: 1" in capsys.readouterr().out


@pytest.mark.parametrize("answer", ["[", "a: b: c", "null"])
def test_an_answer_that_is_no_value_is_refused(answer: str) -> None:
    line = OpenLine("config/rigs/june.yaml", 3, f"  bench_number: # {FILL_IN}: the number")
    with pytest.raises(OilfilmError, match="expected a number or a word"):
        value_of_answer(line, answer, {})


def test_a_definition_of_slip_that_is_none_is_refused() -> None:
    line = OpenLine("config/rigs/june.yaml", 3, f"  slide_roll_ratio: # {FILL_IN}: over_mean")
    with pytest.raises(OilfilmError, match="over_mean"):
        value_of_answer(line, "over_everything", {})
    assert value_of_answer(line, "over_sum", {}) == "over_sum"


@pytest.mark.parametrize(
    ("content", "expected_lines"),
    [
        # a blank line is left out
        (
            b"file,oil\nlog.csv,4102\n\nother.csv,4102\n",
            ["file,oil,log_kind", "log.csv,4102,steps", "other.csv,4102,"],
        ),
        # as Excel writes it on a German and on any Windows
        (
            "oil;file\r\n\u00d6l;log.csv\r\n".encode("cp1252"),
            ["oil;file;log_kind", "\u00d6l;log.csv;steps"],
        ),
        (
            "file\toil\nlog.csv\t\u00d6l\n".encode("utf-16"),
            ["file\toil\tlog_kind", "log.csv\t\u00d6l\tsteps"],
        ),
        # short rows
        (
            b"oil,file,remarks\nx\ny,log.csv\n",
            ["oil,file,remarks,log_kind", "x,,,", "y,log.csv,,steps"],
        ),
        # a pattern names the logs
        (b"file,oil\n*.csv,4102\n", None),
        (b"", None),
    ],
)
def test_settled_readings_are_noted_in_a_run_sheet_of_any_form(
    tmp_path: Path, content: bytes, expected_lines: list[str] | None
) -> None:
    sheet = tmp_path / "data/raw/june/runs.csv"
    sheet.parent.mkdir(parents=True)
    sheet.write_bytes(content)
    refusals = [{"rule": "settled_readings", "reason": ""}]
    log_file = str(sheet.with_name("log.csv"))
    check = ProjectCheck(
        "", [{"file": log_file, "verdict": "refused", "refusals": refusals, "runs": []}]
    )
    is_changed = ask_about_settled_rows(tmp_path, "june", check, lambda _: "yes", lambda _: None)
    assert is_changed == (expected_lines is not None)
    if expected_lines is None:
        assert sheet.read_bytes() == content
    else:
        assert sheet.read_text(encoding="utf-8-sig").splitlines() == expected_lines


@pytest.mark.slow
def test_what_the_check_lacks_is_asked_for_again(
    tmp_path: Path, person: Person, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Even where the first questions forget the radii."""
    monkeypatch.setattr("oilfilm.cli.init._needs_radii", lambda found: False)
    folder = tmp_path / "june"
    assert main(["init", str(folder), str(foreign_log(tmp_path))]) == 0
    assert set(TRACKS) <= set(person.asked)
    assert main(["check", str(folder / "data/raw/june")]) == 0


@pytest.mark.parametrize("options", [["--no-questions"], []])
def test_nothing_is_asked_without_a_terminal_or_a_wish(
    tmp_path: Path, person: Person, monkeypatch: pytest.MonkeyPatch, options: list[str]
) -> None:
    if not options:
        monkeypatch.setattr("oilfilm.cli.init.is_terminal", lambda: False)
    assert main(["init", *options, str(tmp_path / "june"), str(foreign_log(tmp_path))]) == 0
    assert person.asked == []


def test_radii_are_asked_for_whatever_the_language_of_the_ball(tmp_path: Path) -> None:
    new_project = make_project(tmp_path / "june", [foreign_log(tmp_path)])
    keys = [line.key for line in open_lines(tmp_path / "june", list(new_project.text_by_path))]
    assert set(TRACKS) <= set(keys)


def test_full_disk_leaves_nothing_and_init_can_be_repeated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    log = foreign_log(tmp_path)
    folder = tmp_path / "lab" / "june"
    folder.parent.mkdir()
    copy_file = shutil.copyfile

    def full(source: Path, target: Path) -> None:
        if target.suffix == ".csv":
            target.write_bytes(b"cut")
            raise OSError(errno.ENOSPC, "No space left on device", str(source))
        copy_file(source, target)

    for exists in (False, True):
        if exists:
            folder.mkdir()
        with monkeypatch.context() as disk:
            disk.setattr(shutil, "copyfile", full)
            assert main(["init", "--no-questions", str(folder), str(log)]) == 2
        message = capsys.readouterr().err
        assert str(folder) in message
        assert str(log) not in message
        leftover_paths = [path for path in folder.parent.rglob("*") if path != folder]
        assert leftover_paths == []
        assert main(["init", "--no-questions", str(folder), str(log)]) == 0
        shutil.rmtree(folder)


SLIDING = {
    "srv": "Time [s]\tLoad [N]\tFriction force [N]\tFrequency [Hz]\tStroke [mm]\tCOF",
    "pin on disc": "Zeit [s]\tKraft [N]\tReibkraft [N]\tGleitgeschwindigkeit\tGleitweg\tVerschleiß",
    "rtec": "Step\tTimestamp\tDAQ.Fz (N)\tDAQ.Fx (N)\tDAQ.COF ()\tRotary.Velocity (rpm)",
    "speed of sliding": "time\tload [N]\tforce [N]\tsliding velocity\tsliding distance\tT [degC]",
}


@pytest.mark.parametrize("names", SLIDING.values(), ids=SLIDING)
def test_rig_that_does_not_roll_is_told_at_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], names: str
) -> None:
    rows = [f"{row}\t50.{row}\t5.{row}\t200\t1.{row}\t0.1" for row in range(10, 40)]
    (tmp_path / "log.txt").write_text("\n".join([names, *rows, ""]), "utf-8")
    assert main(["init", str(tmp_path / "p"), str(tmp_path / "log.txt")]) == 2
    message = capsys.readouterr().err
    assert "does not roll" in message
    assert not (tmp_path / "p").exists()


def test_rolling_rig_with_a_column_of_wear_is_no_sliding_rig(tmp_path: Path) -> None:
    values = standstill.log()
    units = {**standstill.UNITS, "wear": "um", "frequency": "Hz"}
    extra = {"wear": np.zeros(len(values["time"])), "frequency": np.ones(len(values["time"]))}
    (tmp_path / "log.csv").write_bytes(csv({**values, **extra}, units, {"oil": "B-12"}))
    new_project = make_project(tmp_path / "p", [tmp_path / "log.csv"])
    assert new_project.findings.logs_with_columns


def test_export_of_a_traction_rig_rolls_whatever_its_columns(tmp_path: Path) -> None:
    """Exports of PCS rigs have a column of the sliding speed, as pin-on-disc rigs have."""
    (tmp_path / "export.txt").write_bytes(pcs())
    new_project = make_project(tmp_path / "p", [tmp_path / "export.txt"])
    assert new_project.findings.logs[0].format_name == "pcs"


def test_meaning_that_a_name_leaves_open_is_confirmed_never_taken(tmp_path: Path) -> None:
    """A Hertz pressure may be the maximum or the mean, which is 2/3 of it."""
    values = standstill.log()
    text = csv(values, standstill.UNITS, {"oil": "B-12"}).decode()
    text = text.replace("load [N]", "Hertz pressure [GPa]")
    (tmp_path / "log.csv").write_text(text, "utf-8")
    new_project = make_project(tmp_path / "p", [tmp_path / "log.csv"])
    (line,) = [
        line
        for line in open_lines(tmp_path / "p", list(new_project.text_by_path))
        if line.key == "load"
    ]
    assert "maximum or the mean" in line.what_is_asked


COLUMN = OpenLine("june.yaml", 3, f"  slide_roll_ratio: {{name: }}  {FILL_IN}: the name")


def test_a_column_of_the_slip_is_asked_for_by_its_name() -> None:
    # its definition is a line of the same key
    assert value_of_answer(COLUMN, "Schlupf", {"Schlupf": "%"}) == {"name": ["Schlupf"]}
    with pytest.raises(OilfilmError, match="no log has the column 'over_mean'"):
        value_of_answer(COLUMN, "over_mean", {"Schlupf": "%"})


def test_a_unit_in_the_row_below_the_names_is_not_asked_for() -> None:
    # a column without any unit is
    assert value_of_answer(COLUMN, "Slip", {"Slip": "%"}) == {"name": ["Slip"]}
    assert value_of_answer(COLUMN, "Slip", {"Slip": ""}) == {"name": ["Slip"], "unit": None}


def test_columns_that_differ_by_their_unit_are_told_apart() -> None:
    line = OpenLine("june.yaml", 3, f"  disc_speed: {{name: }}  {FILL_IN}: the name")
    columns = {"Speed [rpm]": "", "Speed [m/s]": "", "Disc [rpm]": ""}
    assert value_of_answer(line, "Speed [rpm]", columns) == {"name": ["Speed [rpm]"]}
    assert value_of_answer(line, "Disc [rpm]", columns) == {"name": ["Disc"]}
    with pytest.raises(OilfilmError, match=r"Speed \[rpm\] or Speed \[m/s\]"):
        value_of_answer(line, "Speed", columns)


def test_path_of_a_log_keeps_the_folder_that_is_called_as_the_project() -> None:
    refusal = {"rule": "load", "reason": "no load", "advice": "Ask june/config", "run_id": ""}
    refused = {"verdict": "refused", "file": "june/data/raw/june/a.csv", "runs": [], "notes": []}
    refused["run_sheet_rows"] = 1
    project_check = ProjectCheck("", [{**refused, "refusals": [refusal]}])
    text = "\n".join(outcome_lines(project_check, Path("june")))
    assert "data/raw/june/a.csv" in text
    assert "june/data" not in text


def test_definition_of_the_slip_is_asked_for_where_its_column_is_not_known() -> None:
    settled = SniffedRun(unit_of_quantity={"load": "N", "traction_force": "N"})
    unnamed = ["slide_roll_ratio"]
    log = SniffedLog("a", "csv", NO_DIALECT, {}, {}, unnamed, {"Kanal 3": ""}, "", [settled], True)
    (line,) = [line for line in semantics_lines(Findings([log])) if line.key != "zero"]
    assert (line.key, line.value) == ("slide_roll_ratio", None)
    # nor is anything asked where two speeds give the slip
    other = ["ball_speed", "disc_speed"]
    log = SniffedLog("a", "csv", NO_DIALECT, {}, {}, other, {"Kanal 3": ""}, "", [settled], True)
    assert [line for line in semantics_lines(Findings([log])) if line.key != "zero"] == []


def test_own_check_is_that_of_the_command(tmp_path: Path) -> None:
    make_project(tmp_path / "june", [foreign_log(tmp_path)])
    checked = check_project(tmp_path / "june", "june")
    # a line is open: the settings have a mistake
    assert "found nothing" in checked.mistake
