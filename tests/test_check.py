"""`oilfilm check`: verdict first, then what was understood, for people and for machines."""

import os
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import oilfilm
import torque_logs
from allocations import peak_bytes
from bad_logs import csv, good
from campaigns import LABORATORY, ROOT, laboratory_campaign, write_campaign
from command_line import printed_objects
from damages import SOUND
from oilfilm.api.log_check import CONSEQUENCES_BY_CAUSE, TEXT_WIDTH, verdict_lines
from oilfilm.cli import main
from oilfilm.curation.gate import RULES
from oilfilm.logs.first_seen import FirstSeenDigests
from oilfilm.logs.ingest import read_bytes

CONFIG = ["--config", str(ROOT / "config")]
N_PER_KGF = 9.80665


def checked(capsys: pytest.CaptureFixture[str], *arguments: object) -> list[dict[str, Any]]:
    """What `--json` prints, one object per log."""
    return printed_objects(capsys, "check", *arguments)


def test_columns_and_set_points_are_shown(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A log in kgf, degF and 1/min with German names, in Windows-1252; a cell is missing."""
    planted, campaign = good(), laboratory_campaign()
    name_and_values = {
        "time": ("Zeit [s]", planted["time"]),
        "load": ("Prüfkraft [kgf]", planted["load"] / N_PER_KGF),
        "traction_force": ("Reibkraft [N]", planted["traction_force"]),
        "ball_speed": ("Kugel [1/min]", planted["ball_speed"]),
        "disc_speed": ("Scheibe [1/min]", planted["disc_speed"]),
        "inlet_temperature": ("Zulauf [degF]", planted["inlet_temperature"] * 9 / 5 + 32),
    }
    name_by_quantity = {quantity: name for quantity, (name, _) in name_and_values.items()}
    cells = np.char.mod(
        "%.6f", np.stack([values for _, values in name_and_values.values()], axis=1)
    )
    cells = np.char.replace(cells, ".", ",")
    cells[100, 1] = ""
    lines = [
        "# oil: 4102",
        "# max_hertz_pressure_gpa: 1,25",
        ";".join([*name_by_quantity.values(), "Notiz"]),
    ]
    text = "\r\n".join([*lines, *(";".join([*row, "x"]) for row in cells), ""])
    (tmp_path / "lauf.csv").write_bytes(text.encode("cp1252"))
    shutil.copytree(ROOT / "config", tmp_path / "config")
    columns = {
        quantity: {"name": name.partition(" ")[0]} for quantity, name in name_by_quantity.items()
    }
    campaign |= {"columns": columns, "set_points": {"inlet_temperature_c": 70.0}}
    write_campaign(tmp_path, "deutsch", campaign)
    options = "--config", tmp_path / "config", "--campaign", "deutsch"

    (log,) = checked(capsys, tmp_path / "lauf.csv", *options)
    assert (log["format"], log["encoding"]) == ("csv", "cp1252")
    assert (log["delimiter"], log["decimal_mark"]) == ("semicolon", "comma")
    assert (log["rows"], log["refused_rows"]) == (len(cells), 1)
    (run,) = log["runs"]
    column_by_quantity = {column["quantity"]: column for column in run["columns"]}
    load, load_n = column_by_quantity["load"], np.delete(planted["load"], 100)
    assert (load["name"], load["logged_unit"], load["unit"]) == ("Prüfkraft [kgf]", "kgf", "N")
    assert (load["count"], load["missing"]) == (len(load_n), 1)
    assert load["minimum"] == pytest.approx(load_n.min(), abs=1e-4)
    assert load["maximum"] == pytest.approx(load_n.max(), abs=1e-4)
    assert (
        column_by_quantity["inlet_temperature"]["unit"],
        column_by_quantity["ball_speed"]["unit"],
    ) == ("degC", "rpm")
    assert run["unused_columns"] == ["Notiz"]

    assert (run["oil_source"], run["rig_source"]) == ("header", "campaign")
    set_points = run["set_points"]
    assert set_points["max_hertz_pressure_gpa"] == {"value": 1.25, "source": "header"}
    assert set_points["inlet_temperature_c"] == {"value": 70.0, "source": "campaign"}
    assert set_points["entrainment_speed_m_s"] is None
    # Hertz, steel ball of 10 mm on steel: 1.25 GPa (docs/physics.md gives the rig's 82 N)
    assert set_points["load_n"]["source"] == "by Hertz"
    reason_by_gate = {
        unapplied_gate["gate"]: unapplied_gate["reason"]
        for unapplied_gate in run["gates_not_applied"]
    }
    assert "entrainment speed" in reason_by_gate["speed_off_nominal"]
    assert "set_points: slide_roll_ratio" in reason_by_gate["slip_off_set_point"]
    assert not {"load_off_nominal", "temperature_off_nominal"} & set(reason_by_gate)


def test_load_follows_by_hertz_from_the_pressure_of_the_campaign_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(ROOT / "config", tmp_path / "config")
    stated = {"max_hertz_pressure_gpa": 1.25}
    write_campaign(tmp_path, "pressure", laboratory_campaign() | {"set_points": stated})
    (tmp_path / "log.csv").write_bytes(csv(max_hertz_pressure_gpa=None))
    options = "--config", tmp_path / "config", "--campaign", "pressure"
    (log,) = checked(capsys, tmp_path / "log.csv", *options)
    set_points = log["runs"][0]["set_points"]
    assert set_points["max_hertz_pressure_gpa"] == {"value": 1.25, "source": "campaign"}
    assert set_points["load_n"]["source"] == "by Hertz"


def test_nothing_is_read_of_a_file_of_unknown_format(tmp_path: Path) -> None:
    (tmp_path / "photo.csv").write_bytes(b"\xff\xd8\xff\xe0" + bytes(range(256)) * 4)
    text = oilfilm.check(tmp_path / "photo.csv", config=LABORATORY).summary()
    assert "REFUSED" in text
    assert "Read as" not in text


def test_folder_of_a_log_says_its_kind(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    # a project may have the name of its campaign
    project = tmp_path / "laboratory"
    logs = {"traction": project / "april/a.csv", "torque": project / "laboratory-torque/b.csv"}
    for kind, path in logs.items():
        path.parent.mkdir(parents=True)
        path.write_bytes(SOUND[kind].text())
    # a folder is checked with all its subfolders
    traction, torque = checked(capsys, project, "--config", LABORATORY)
    assert (traction["rig_kind"], torque["rig_kind"]) == ("traction", "torque")
    assert (traction["verdict"], torque["verdict"]) == ("accepted", "accepted")
    (run,) = torque["runs"]
    # 3 000, 6 000 and 9 000 rpm with torques of 2, 3 and 5 N m (torque_logs.signals)
    assert run["measured"]["inner_speed_rpm"]["maximum"] == pytest.approx(9000, rel=1e-3)
    assert run["measured"]["torque_n_m"]["minimum"] == pytest.approx(2, abs=0.05)
    assert run["set_points"] == {}


@pytest.mark.parametrize("name", ["radial_load_n", "Radial force [N]", "F_r (N)"])
def test_a_radial_load_is_warned_about(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    path = tmp_path / "laboratory-torque/b.csv"
    path.parent.mkdir(parents=True)
    signals = torque_logs.signals()
    path.write_bytes(torque_logs.text(signals.assign(**{name: 2000.0, "friction": 1.0})))
    (log,) = checked(capsys, tmp_path, "--config", LABORATORY)
    (run,) = log["runs"]
    assert log["verdict"] == "accepted"
    assert name in run["warning"]
    assert "friction" not in run["warning"]


def test_folder_says_the_campaign_of_logs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(ROOT / "config", tmp_path / "config")
    for name in ("june", "july"):
        write_campaign(tmp_path, name, laboratory_campaign())
    (tmp_path / "config/config.yaml").write_text("campaign: july\n", encoding="utf-8")
    config_option = ["--config", str(tmp_path / "config")]
    logs = {name: tmp_path / f"data/raw/{name}/a.csv" for name in ("june", "july", "elsewhere")}
    for path in logs.values():
        path.parent.mkdir(parents=True)
        path.write_bytes(b"no log")
    for name, campaign in (("june", "june"), ("elsewhere", "july")):
        (log,) = checked(capsys, logs[name], *config_option)
        assert log["campaign"] == campaign
    seen = FirstSeenDigests("june", folder=tmp_path / "data/first_seen")
    seen.check_and_add(dict.fromkeys(["data/raw/june/a.csv", "data/raw/june/b.csv"], "0" * 64), [])
    assert main(["check", str(logs["june"]), *config_option]) == 1
    assert "data/raw/june/b.csv" in capsys.readouterr().err
    assert main(["check", str(logs["june"]), str(logs["july"]), *config_option]) == 2
    assert "july and june" in capsys.readouterr().err


def test_a_campaign_whose_name_ends_as_a_torque_folder_judges_its_own_logs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(ROOT / "config", tmp_path / "config")
    for name in ("june", "june-torque"):
        write_campaign(tmp_path, name, laboratory_campaign())
    path = tmp_path / "data/raw/june-torque/a.csv"
    path.parent.mkdir(parents=True)
    path.write_bytes(b"no log")
    (log,) = checked(capsys, path, "--config", str(tmp_path / "config"))
    assert log["campaign"] == "june-torque"


def test_a_raw_folder_that_does_not_exist_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["check", "data/raw"]) == 2
    assert "data/raw: cannot be read" in capsys.readouterr().err


def test_page_shows_what_is_printed(
    demo: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    page = (ROOT / "docs/how-to/check.md").read_text(encoding="utf-8")
    command, _, printed_text = page.partition("$ oilfilm ")[2].partition("```")[0].partition("\n")
    (tmp_path / "data/raw").mkdir(parents=True)
    (tmp_path / "data/raw/demo").symlink_to(demo.folder)
    monkeypatch.chdir(tmp_path)
    assert main([*command.split(), *CONFIG]) == 1
    assert capsys.readouterr().out.replace(os.sep, "/") == printed_text
    assert all(len(line) <= TEXT_WIDTH for line in printed_text.splitlines())


def _log_in_project(folder: Path, campaign_name: str, text: str) -> Path:
    """A log in the raw folder of a project that has the configuration of the repository."""
    shutil.copytree(ROOT / "config", folder / "config")
    campaign = laboratory_campaign()
    if campaign_name == "june":
        campaign["columns"] = {"load": {"name": "Andruck"}}
        text = text.replace("load [N]", "Andruck [N]")
    write_campaign(folder, campaign_name, campaign)
    raw_folder = folder / "data/raw" / campaign_name
    raw_folder.mkdir(parents=True)
    (raw_folder / "own.csv").write_text(text, "utf-8")
    return raw_folder / "own.csv"


def test_log_is_judged_by_the_project_in_whose_folder_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    log = _log_in_project(tmp_path / "lab", "june", csv().decode())
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert main(["check", str(log)]) == 0
    output = capsys.readouterr()
    assert "campaign june" in output.out
    assert "oilfilm init" not in output.err


def test_logs_of_two_projects_are_not_judged_together(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    logs = [str(_log_in_project(tmp_path / lab, "june", csv().decode())) for lab in ("a", "b")]
    assert main(["check", *logs]) == 2
    message = capsys.readouterr().err
    assert str(tmp_path / "a") in message
    assert str(tmp_path / "b") in message
    assert "--config" in message


def test_stranger_is_told_of_init_and_where_the_names_seem_to_be(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = "".join(f"{row}\t{row + 1}.5\t{row + 2}\t{row * 3}\n" for row in range(20))
    text = f"Tribometer 7\nMonday\nZeit\tKraft\tWeg\tDrehung\ns\tN\tmm\t1\n{rows}"
    (tmp_path / "strange.txt").write_text(text, "utf-8")
    monkeypatch.chdir(tmp_path)
    assert main(["check", "strange.txt"]) == 1
    output = capsys.readouterr()
    lines = " ".join(output.out.split())
    assert "line 3" in lines
    assert "Drehung" in lines
    assert "oilfilm init" in output.err


def test_cause_is_shown_first_and_its_consequences_below_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The clock begins anew in each of three blocks; 5 other findings follow from it."""
    refusals = [
        refusal("not_steady", 4),
        refusal("unreadable_row", 11),
        refusal("time_disorder", 16),
        refusal("unreadable_row", 26),
        refusal("truncated", 90),
    ]
    log_report = {
        "file": "blocks.txt",
        "verdict": "refused",
        "run_sheet_rows": None,
        "refusals": refusals,
        "runs": [
            {
                "run_id": "blocks.txt",
                "verdict": "refused",
                "warning": "",
                "plateaus": 6,
                "accepted_plateaus": 0,
                "rows": 60,
                "failed_gates": [],
            }
        ],
    }
    lines = list(verdict_lines(log_report))
    assert "time_disorder" in lines[1]
    consequence_lines = [line.strip() for line in lines if line.startswith(" " * 6)]
    assert [line.partition(":")[0] for line in consequence_lines] == [
        "not_steady",
        "unreadable_row",
    ]
    assert "1 more of this kind" in consequence_lines[1]
    # what is no consequence stands on its own
    assert any(line.startswith("  truncated") for line in lines)


def refusal(rule: str, row: int) -> dict[str, Any]:
    return {
        "run_id": "blocks.txt",
        "rule": rule,
        "reason": "found",
        "advice": "",
        "first_row": row,
        "last_row": row,
        "refused_rows": 1,
    }


def test_every_cause_and_consequence_is_a_rule() -> None:
    consequences = frozenset().union(*CONSEQUENCES_BY_CAUSE.values())
    known_rules = {*RULES["gates"], *RULES["warnings"], *RULES["others"], *RULES["mistakes"]}
    known_rules |= {*RULES["traction"], *RULES["torque"]}
    # rules of readers, which no table lists
    reader_rules = {"unreadable_row", "slip_unit"}
    assert consequences | CONSEQUENCES_BY_CAUSE.keys() <= known_rules | reader_rules


def test_small_log_takes_no_memory_for_the_largest_one(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(csv())
    with peak_bytes() as peak:
        assert read_bytes(path) == csv()
    assert peak() < 8e6


@pytest.mark.slow
def test_a_note_that_several_logs_have_is_said_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for number in range(3):
        (tmp_path / f"{number}.csv").write_bytes(csv().rstrip())
    # the same bytes thrice: two of them are refused, which does not matter here
    assert main(["check", str(tmp_path), *CONFIG]) == 1
    text = capsys.readouterr().out
    assert text.count("reading_note") == 1
    assert "reading_note of 3 logs: the last row has no line end" in " ".join(text.split())
    # alone, a log has its own note
    assert main(["check", str(tmp_path / "0.csv"), *CONFIG]) == 0
    assert "reading_note: the last row" in capsys.readouterr().out


@pytest.mark.slow
def test_a_program_gets_the_verdicts_of_the_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "good.csv").write_bytes(csv())
    (tmp_path / "short.csv").write_bytes(csv()[:300])
    from_command = checked(capsys, tmp_path, *CONFIG)
    result = oilfilm.check(tmp_path, config=ROOT / "config")
    assert len(result.points) == result.to_frame()["accepted_plateaus"].sum() > 0
    assert [log["verdict"] for log in result.logs] == [log["verdict"] for log in from_command]
    assert not result.accepted
    # a log that is named by two paths is no copy of itself
    two_paths = str(tmp_path / "good.csv"), tmp_path / ".." / tmp_path.name / "good.csv"
    (log,) = oilfilm.check(*two_paths, config=ROOT / "config").logs
    assert log["verdict"] == "accepted"
    frame = result.to_frame().set_index("file")
    assert frame.loc[str(tmp_path / "good.csv"), "verdict"] == "accepted"
    assert frame.loc[str(tmp_path / "short.csv"), "verdict"] == "refused"
    assert "REFUSED" in repr(result) and "folder of no campaign" in result.notes[0]
    with pytest.raises(oilfilm.OilfilmError, match=r"missing\.csv: cannot be read"):
        oilfilm.check(tmp_path / "missing.csv")


def test_too_little_memory_ends_in_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(csv())

    def no_memory(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr("oilfilm.api.log_check.ingest_logs", no_memory)
    assert main(["check", str(path), *CONFIG]) == 2
    assert "memory" in capsys.readouterr().err
