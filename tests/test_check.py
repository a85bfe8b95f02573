"""`oilfilm check`: verdict first, then what was understood, for people and for machines."""

import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import torque_logs
from bad_logs import KEYS, UNITS, good
from bad_logs import csv as traction_text
from campaigns import ROOT, read_campaign, write_campaign
from command_line import printed_objects
from damages import SOUND, stuck
from oilfilm.cli import main
from oilfilm.cli.check import check_files
from oilfilm.cli.check_text import WIDTH, report
from oilfilm.curation.traction_rig import TRACTION_RIG
from oilfilm.settings.resolve import resolve

CONFIG = ["--config", str(ROOT / "config")]
N_PER_KGF = 9.80665


def checked(capsys: pytest.CaptureFixture[str], *arguments: object) -> list[dict[str, Any]]:
    """What `--json` prints, one object per log."""
    return printed_objects(capsys, "check", *arguments)


@pytest.fixture
def german(tmp_path: Path) -> tuple[Path, list[str]]:
    """A log in kgf, degF and 1/min with German names, in Windows-1252; a cell is missing."""
    values = good()
    names = {
        "time": "Zeit [s]",
        "load": "Prüfkraft [kgf]",
        "traction_force": "Reibkraft [N]",
        "ball_speed": "Kugel [1/min]",
        "disc_speed": "Scheibe [1/min]",
        "inlet_temperature": "Zulauf [degF]",
    }
    logged = {
        **values,
        "load": values["load"] / N_PER_KGF,
        "inlet_temperature": values["inlet_temperature"] * 9 / 5 + 32,
    }
    cells = np.char.mod("%.6f", np.stack([logged[quantity] for quantity in names], axis=1))
    cells = np.char.replace(cells, ".", ",")
    cells[100, 1] = ""
    lines = ["# oil: 4102", "# max_hertz_pressure_gpa: 1,25", ";".join([*names.values(), "Notiz"])]
    lines += [";".join([*row, "x"]) for row in cells]
    path = tmp_path / "lauf.csv"
    path.write_bytes(("\r\n".join(lines) + "\r\n").encode("cp1252"))
    config = tmp_path / "config"
    shutil.copytree(ROOT / "config", config)
    campaign = read_campaign(ROOT, "demo")
    campaign["columns"] = {
        quantity: {"name": name.partition(" ")[0]} for quantity, name in names.items()
    }
    campaign["set_points"] = {"inlet_temperature_c": 70.0}
    write_campaign(tmp_path, "deutsch", campaign)
    return path, ["--config", str(config), "--campaign", "deutsch"]


def test_columns_are_shown_as_logged_and_as_understood(
    german: tuple[Path, list[str]], capsys: pytest.CaptureFixture[str]
) -> None:
    path, options = german
    (log,) = checked(capsys, path, *options)
    assert (log["format"], log["encoding"]) == ("csv", "cp1252")
    assert (log["delimiter"], log["decimal_mark"]) == ("semicolon", "comma")
    assert (log["rows"], log["refused_rows"]) == (len(good()["time"]), 1)
    (run,) = log["runs"]
    columns = {column["quantity"]: column for column in run["columns"]}
    load, planted = columns["load"], np.delete(good()["load"], 100)
    assert (load["name"], load["logged_unit"], load["unit"]) == ("Prüfkraft [kgf]", "kgf", "N")
    assert (load["count"], load["missing"]) == (len(planted), 1)
    assert load["minimum"] == pytest.approx(planted.min(), abs=1e-4)
    assert load["maximum"] == pytest.approx(planted.max(), abs=1e-4)
    celsius = good()["inlet_temperature"]
    assert columns["inlet_temperature"]["unit"] == "degC"
    assert columns["inlet_temperature"]["minimum"] == pytest.approx(celsius.min(), abs=1e-4)
    assert columns["ball_speed"]["unit"] == "rpm"
    assert run["unused_columns"] == ["Notiz"]


def test_set_points_are_shown_with_their_source_and_gates_without_one_are_named(
    german: tuple[Path, list[str]], capsys: pytest.CaptureFixture[str]
) -> None:
    path, options = german
    (log,) = checked(capsys, path, *options)
    (run,) = log["runs"]
    assert (run["oil_source"], run["rig_source"]) == ("header", "campaign")
    points = run["set_points"]
    assert points["max_hertz_pressure_gpa"] == {"value": 1.25, "source": "header"}
    assert points["inlet_temperature_c"] == {"value": 70.0, "source": "campaign"}
    assert points["entrainment_speed_m_s"] is None
    # Hertz, steel ball of 10 mm on steel: 1.25 GPa (docs/physics.md gives the rig's 82 N)
    assert points["load_n"]["source"] == "by Hertz"
    lacking = {each["gate"]: each["reason"] for each in run["gates_not_applied"]}
    assert lacking["speed_off_nominal"] == "no set point of the entrainment speed is given"
    assert "set_points: slide_roll_ratio" in lacking["slip_off_set_point"]
    assert "load_off_nominal" not in lacking
    assert "temperature_off_nominal" not in lacking


def test_broken_file_gives_the_refusal_first(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.csv").write_text("time_s,load_n,x,y\n0,80,1,1\n")
    Path("b.csv").write_bytes(SOUND["traction"].text())
    assert main(["check", "a.csv", "b.csv", *CONFIG]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "a.csv: REFUSED"
    assert lines[1].startswith("  columns: the log lacks the columns traction_force")
    assert lines[-2:] == ["2 logs: 1 accepted, 1 refused", "  a.csv"]


@pytest.fixture
def two_kinds(tmp_path: Path) -> Mapping[str, Path]:
    """A traction log, a torque log, and one that has the columns of both."""
    torque = torque_logs.text(torque_logs.signals())
    (tmp_path / "torque.csv").write_bytes(torque)
    (tmp_path / "traction.csv").write_bytes(traction_text())
    both = {**good(), **{name: good()["load"] for name in torque_logs.UNITS if name != "time"}}
    units = {**UNITS, **torque_logs.UNITS}
    head = [f"# {key}: {value}" for key, value in KEYS.items()]
    names = ",".join(f"{name} [{units[name]}]" for name in both)
    rows = [",".join(f"{value:.4f}" for value in row) for row in zip(*both.values(), strict=True)]
    (tmp_path / "both.csv").write_text("\n".join([*head, names, *rows]) + "\n")
    return {path.stem: path for path in tmp_path.iterdir()}


def test_kind_of_a_log_is_found_by_its_columns(
    two_kinds: Mapping[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    logs = checked(capsys, two_kinds["torque"], two_kinds["traction"], *CONFIG)
    assert [log["rig_kind"] for log in logs] == ["torque", "traction"]
    assert [log["verdict"] for log in logs] == ["accepted", "accepted"]
    (run,) = logs[0]["runs"]
    # 3 000, 6 000 and 9 000 rpm with torques of 2, 3 and 5 N m (torque_logs.signals)
    assert run["measured"]["inner_speed_rpm"]["maximum"] == pytest.approx(9000, rel=1e-3)
    assert run["measured"]["torque_n_m"]["minimum"] == pytest.approx(2, abs=0.05)
    assert run["set_points"] == {}


def test_log_of_either_kind_needs_the_option(
    two_kinds: Mapping[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", str(two_kinds["both"]), *CONFIG]) == 2
    assert "Say which it is: --traction or --torque." in capsys.readouterr().err
    (log,) = checked(capsys, "--torque", two_kinds["both"], *CONFIG)
    assert log["rig_kind"] == "torque"


def test_folder_of_a_log_says_its_kind(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    # a project may have the name of its campaign
    folder = tmp_path / "demo/data/raw/demo-torque"
    folder.mkdir(parents=True)
    (folder / "a.csv").write_bytes(stuck(SOUND["torque"]))
    (folder / "b.csv").write_text("nothing that can be read\n")
    logs = checked(capsys, folder / "a.csv", folder / "b.csv", *CONFIG)
    assert [log["rig_kind"] for log in logs] == ["torque", "torque"]
    assert [log["verdict"] for log in logs] == ["refused", "refused"]
    assert logs[0]["refusals"][0]["rule"] == "stuck_sensor"


def test_logs_in_the_folder_of_a_campaign_are_judged_by_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(ROOT / "config", tmp_path / "config")
    write_campaign(tmp_path, "june", read_campaign(ROOT, "demo"))
    where = ["--config", str(tmp_path / "config")]
    for folder in ("june", "demo", "elsewhere"):
        (tmp_path / "data/raw" / folder).mkdir(parents=True)
        (tmp_path / "data/raw" / folder / "a.csv").write_bytes(traction_text())
        (log,) = checked(capsys, tmp_path / "data/raw" / folder / "a.csv", *where)
        assert log["campaign"] == ("june" if folder == "june" else "demo")
    both = [str(tmp_path / f"data/raw/{folder}/a.csv") for folder in ("june", "demo")]
    assert main(["check", *both, *where]) == 2
    assert "the logs are of the campaigns demo and june" in capsys.readouterr().err


def test_log_of_another_project_is_not_judged_by_the_settings_of_this_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    here, project = tmp_path / "here", tmp_path / "project of july"
    for folder in (here, project):
        shutil.copytree(ROOT / "config", folder / "config")
    write_campaign(project, "july", read_campaign(ROOT, "demo"))
    log = project / "data/raw/july/a.csv"
    log.parent.mkdir(parents=True)
    log.write_bytes(traction_text())
    monkeypatch.chdir(here)
    assert main(["check", str(log)]) == 2
    message = capsys.readouterr().err
    assert f"{log}: is of the campaign july in the project folder {project}" in message
    assert f"--config {project / 'config'}" in message
    assert main(["check", str(log), "--campaign", "demo"]) == 0
    assert main(["check", str(log), "--config", str(project / "config")]) == 0


def test_many_refused_runs_of_one_log_are_counted() -> None:
    settings = resolve(ROOT / "config", {"campaign": "demo"})
    (log,) = check_files([("a.csv", stuck(SOUND["traction"]))], settings, TRACTION_RIG)
    (run,), names = log["runs"], [f"run{number:02}" for number in range(12)]
    many = {
        **log,
        "runs": [{**run, "run_id": name} for name in names],
        "refusals": [{**each, "run_id": name} for each in log["refusals"] for name in names],
    }
    text = report([many])
    assert [name for name in names if f"{name}: REFUSED" in text] == names[:10]
    assert text.startswith("a.csv: 12 runs: 12 refused; --json shows all\n")


def test_page_shows_what_is_printed(
    demo: Any,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    page = (ROOT / "docs/how-to/check.md").read_text(encoding="utf-8")
    command, _, shown = page.partition("$ oilfilm ")[2].partition("```")[0].partition("\n")
    (tmp_path / "data/raw").mkdir(parents=True)
    (tmp_path / "data/raw/demo").symlink_to(demo.folder)
    monkeypatch.chdir(tmp_path)
    assert main([*command.split(), *CONFIG]) == 1
    assert capsys.readouterr().out.replace(os.sep, "/") == shown
    assert all(len(line) <= WIDTH for line in shown.splitlines())


def test_folder_is_checked_with_the_logs_of_its_subfolders(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "logs/april").mkdir(parents=True)
    for name in ("logs/a.csv", "logs/april/b.csv"):
        (tmp_path / name).write_bytes(traction_text())
    (tmp_path / "logs/README.md").write_text("two logs", encoding="utf-8")
    logs = checked(capsys, tmp_path / "logs", *CONFIG)
    assert [Path(log["file"]).name for log in logs] == ["a.csv", "b.csv"]
