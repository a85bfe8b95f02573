"""A new project folder says of logs what is true of them, and asks for what is not known."""

import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import formats
import standstill
from blind_lab.bench import Bench, Recording
from blind_lab.dialects import NAMES, Dialect, draw_dialect
from campaigns import ETM, ROOT
from command_line import printed_objects
from foreign_logs import (
    CONDITIONS,
    GERMAN,
    bench_and_runs,
    exchanged_bodies,
    reversed_force,
    write_logs,
)
from oilfilm.cli import main
from oilfilm.cli.init import NewProject, make_project
from oilfilm.curation.curate import check_logs
from oilfilm.errors import OilfilmError
from oilfilm.logs.sheet_file import sheet_of_paths
from oilfilm.logs.traction_log import TRACTION
from oilfilm.settings.resolve import resolve

FILM = "film_unjudged: {accept: true, reason: thick by experience}"
METRES = GERMAN.with_units(ball="m/s", disc="m/s")


def edit(project: Path, made: NewProject, values: dict[str, float]) -> int:
    """Write values into the lines to fill in, as an editor would; how many lines were changed."""
    for file, number, line in made.to_fill_in:
        path = project / file
        lines = path.read_text(encoding="utf-8").splitlines()
        key = line.partition(":")[0].strip()
        lines[number - 1] = FILM if key == "film_unjudged" else f"{key}: {values[key]}"
        path.write_text("\n".join([*lines, ""]), encoding="utf-8")
    return len(made.to_fill_in)


def campaign_of(project: Path, made: NewProject) -> dict[str, Any]:
    text = (project / f"config/campaigns/{made.campaign}.yaml").read_text(encoding="utf-8")
    return dict(yaml.safe_load(text))


def made_of(
    tmp_path: Path, dialect: Dialect = GERMAN, runs: slice = slice(1), lines: slice = slice(None)
) -> NewProject:
    """The project `p` of some runs of the bench, with some of their header lines."""
    bench, recorded = bench_and_runs()
    logs = write_logs(tmp_path / "logs", bench, recorded[runs], dialect, lines)
    return make_project(tmp_path / "p", logs)


def sheet_of(project: Path, made: NewProject) -> list[str]:
    path = project / f"data/raw/{made.campaign}/runs.csv"
    return path.read_text(encoding="utf-8-sig").splitlines()


def accepted(
    project: Path,
    logs: list[Path],
    bench: Bench,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> list[dict[str, Any]]:
    """What `check` says of the three logs of a bench after at most three lines are filled in."""
    made, machine = make_project(project, logs), bench.machine
    tracks = {"ball": machine.ball_track, "disc": machine.disc_track}
    assert edit(project, made, {f"{body}_track_radius_m": r for body, r in tracks.items()}) <= 3
    monkeypatch.chdir(project)
    raw = Path("data/raw", project.name)
    checked = printed_objects(capsys, "check", *sorted(raw.rglob("M*.csv")))
    assert [log["verdict"] for log in checked] == ["accepted"] * 3
    return checked


def test_german_logs_are_accepted_after_three_lines(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """cp1252, semicolons, decimal commas, spindle speeds: only radii and film are the lab's."""
    bench, runs = bench_and_runs()
    logs = write_logs(tmp_path / "Prüfstand", bench, runs)
    checked = accepted(tmp_path / "juni", logs, bench, monkeypatch, capsys)
    for log, condition in zip(checked, CONDITIONS, strict=True):
        (run,) = log["runs"]
        assert (log["encoding"], run["oil"]) == ("cp1252", "oel-b-12")
        points = {name: point and point["value"] for name, point in run["set_points"].items()}
        assert points["max_hertz_pressure_gpa"] == condition.pressure
        assert points["entrainment_speed_m_s"] == condition.speed
        assert points["inlet_temperature_c"] == condition.celsius
        # the speed follows from the radii: it is the planted one
        fastest = run["measured"]["entrainment_speed_m_s"]["maximum"]
        assert fastest == pytest.approx(condition.speed, rel=0.005)


def test_english_french_and_chinese_logs_in_one_folder_are_accepted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    random = np.random.default_rng(3)
    bench, runs = bench_and_runs("Turbo 5 alt")
    drawn = [draw_dialect(random) for _ in range(50)]
    languages = {dialect.language: replace(dialect, packed=False) for dialect in drawn}
    del languages["german"]
    for run, (language, dialect) in zip(runs, languages.items(), strict=True):
        write_logs(tmp_path / "lab" / language, bench, [run], dialect)
    accepted(tmp_path / "blind", [tmp_path / "lab"], bench, monkeypatch, capsys)


@pytest.mark.parametrize("name", ["tdms", "lvm", "parquet"])
def test_columns_of_binary_formats_are_recognised(tmp_path: Path, name: str) -> None:
    german = {
        "time": "time" if name == "lvm" else "Zeit",
        "load": "Normalkraft",
        "traction_force": "Reibkraft",
        "ball_speed": "Drehzahl Kugel",
        "disc_speed": "Drehzahl Scheibe",
        "inlet_temperature": "Ölzulauf",
    }
    values = {german[key]: column for key, column in formats.columns(100).items()}
    units = {german[key]: unit for key, unit in formats.UNITS.items()}
    log = tmp_path / "log.dat"
    log.write_bytes(formats.WRITERS[name](values, units, {"Schmierstoff": "Öl B-12"}))
    made = make_project(tmp_path / "p", [log])
    campaign = campaign_of(tmp_path / "p", made)
    assert {key: column["name"] for key, column in campaign["columns"].items()} == {
        key: [own] for key, own in german.items() if own != "time"
    }
    assert campaign["header"]["oil"] == ["schmierstoff"]


def test_set_points_that_no_header_gives_are_those_of_the_bench(tmp_path: Path) -> None:
    bench, _ = bench_and_runs()
    made = made_of(tmp_path, METRES, slice(None), slice(1))
    names, *rows = sheet_of(tmp_path / "p", made)
    assert names == "file;load_n;entrainment_speed_m_s;inlet_temperature_c;exclude;remarks"
    for row, condition in zip(rows, CONDITIONS, strict=True):
        _, *cells, _, remarks = row.split(";")
        load, speed, celsius = (float(cell.replace(",", ".")) for cell in cells)
        # three standard deviations of the bench's control and calibration, and the rounding
        assert load == pytest.approx(bench.machine.load(condition.pressure * 1e9), rel=0.02)
        assert speed == pytest.approx(condition.speed, rel=0.005)
        assert celsius == pytest.approx(condition.celsius, abs=1)
        assert remarks.startswith("guess")


def test_header_in_another_unit_is_not_listed(tmp_path: Path) -> None:
    """`Pressung MPa: 1000` cannot be listed for a key in GPa."""
    bench, runs = bench_and_runs()
    (log,) = write_logs(tmp_path / "logs", bench, runs[:1])
    log.write_bytes(log.read_bytes().replace(b"Pressung GPa: 1,0", b"Pressung MPa: 1000"))
    made = make_project(tmp_path / "p", [log])
    assert "max_hertz_pressure_gpa" not in campaign_of(tmp_path / "p", made)["header"]


@pytest.mark.parametrize(
    ("changed", "semantics"),
    [
        (lambda run: run, {}),
        (reversed_force, {"traction_sign": -1}),
        (exchanged_bodies, {"slower_body": "disc"}),
    ],
)
def test_signs_are_those_of_the_rig(
    tmp_path: Path, changed: Callable[[Recording], Recording], semantics: dict[str, Any]
) -> None:
    bench, runs = bench_and_runs()
    logs = write_logs(tmp_path / "logs", bench, [changed(run) for run in runs], METRES)
    made = make_project(tmp_path / "p", logs)
    assert campaign_of(tmp_path / "p", made)["semantics"] == {"zero": "rolling_phases", **semantics}


def reversed_log(values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    return {**values, "traction_force": -values["traction_force"]}


@pytest.mark.parametrize(
    ("values", "source"),
    [
        (standstill.log((0.0, *standstill.LEVELS, 0.0)), "rolling_phases"),
        (standstill.log((0.0, *standstill.LEVELS)), "opening_phase"),
        # S = 0.002 is within the limit of pure rolling, but part of this curve
        (standstill.log(), "standstill"),
        (reversed_log(standstill.log()), "standstill"),
        (standstill.log(still_s=(0.0, 0.0), ramp_s=0.0), None),
    ],
)
def test_source_of_the_zero_is_the_one_that_the_log_has(
    tmp_path: Path, values: dict[str, np.ndarray], source: str | None
) -> None:
    log = tmp_path / "log.csv"
    log.write_bytes(formats.csv(values, standstill.UNITS, {"oil": "B-12"}))
    made = make_project(tmp_path / "p", [log])
    assert campaign_of(tmp_path / "p", made)["semantics"]["zero"] == source
    # a guess is no line that must be filled in
    assert any("  zero:" in line for _, _, line in made.to_fill_in) == (source is None)


@pytest.mark.parametrize("offset_n", [0.35, -1.2])
def test_log_with_standstill_is_right_after_one_line(tmp_path: Path, offset_n: float) -> None:
    (tmp_path / "log.csv").write_bytes(
        formats.csv(standstill.log(offset_n=offset_n), standstill.UNITS, {"oil": "B-12"})
    )
    project = tmp_path / "p"
    made = make_project(project, [tmp_path / "log.csv"])
    # levels of the rows that turn, although a third of the log is at standstill
    assert sheet_of(project, made)[1].startswith("log.csv,40,2,70,")
    assert edit(project, made, {}) == 1
    settings = resolve(project / "config", {})
    path = project / "data/raw/p/log.csv"
    sheet = sheet_of_paths([path], project / "data/raw", settings, TRACTION)
    points = check_logs([(str(path), path.read_bytes())], settings, sheet=sheet).points
    assert points["accepted"].tolist() == [True] * len(standstill.LEVELS)
    truth = standstill.planted(points["slide_roll_ratio"].to_numpy())
    # five standard errors of a mean of 0.01 N over 2 s at 20 Hz, twice, over 40 N
    np.testing.assert_allclose(points["traction_coefficient"], truth, atol=4e-4)


def test_files_that_are_no_logs_are_named_and_not_copied(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lab = tmp_path / "lab"
    bench, runs = bench_and_runs()
    write_logs(lab, bench, runs[:1])
    pictures = {"rig.jpg": b"\xff\xd8\xff\xe0\0\x10JFIF", "a.bin": bytes(range(250, 240, -1))}
    texts = {"LICENSE.txt": (ROOT / "LICENSE").read_bytes(), "notes.txt": b"Oil changed, 3 May."}
    for name, content in {**pictures, **texts}.items():
        (lab / name).write_bytes(content)
    # columns that nobody knows are those of a log all the same
    (lab / "unknown.csv").write_text("qa;qb;qc\n1,5;2,5;3,5\n1,6;2,6;3,6\n", encoding="utf-8")
    assert main(["init", str(tmp_path / "p"), str(lab)]) == 1  # for unknown.csv
    said = capsys.readouterr().out
    for name in (*pictures, *texts):
        assert f"{name} is no log and was not copied: " in said
    assert "the file is a JPEG picture" in said
    assert "\\x" not in said
    raw = tmp_path / "p/data/raw/p"
    assert {path.name for path in raw.iterdir()} == {"Messung_0.csv", "unknown.csv", "runs.csv"}
    sheet = (raw / "runs.csv").read_text("utf-8-sig")
    assert "LICENSE" not in sheet
    (lab / "unknown.csv").unlink()
    assert main(["init", str(tmp_path / "q"), str(lab)]) == 0
    assert main(["init", str(tmp_path / "r"), str(lab / "LICENSE.txt")]) == 2
    assert not (tmp_path / "r").exists()


def test_what_is_left_empty_is_named_with_file_line_and_key(tmp_path: Path) -> None:
    made = made_of(tmp_path)
    assert len(made.to_fill_in) == 3
    for file, number, line in made.to_fill_in:
        key = line.partition(":")[0]
        with pytest.raises(OilfilmError, match=rf"{file}, line {number}, `{key}`: found nothing"):
            resolve(tmp_path / "p/config", {})
        path = tmp_path / "p" / file
        value = FILM if key == "film_unjudged" else f"{key}: 0.01"
        path.write_text(path.read_text(encoding="utf-8").replace(line, value), encoding="utf-8")
    assert resolve(tmp_path / "p/config", {}).campaign.name == "p"
    # an oil that is moved to `oils` needs its own numbers
    path = tmp_path / "p/config/campaigns/p.yaml"
    text = path.read_text(encoding="utf-8").replace("oils: []\n", "")
    path.write_text(text.replace("oils_without_properties:", "oils:"), encoding="utf-8")
    with pytest.raises(OilfilmError, match=r"oel-b-12.yaml, line \d+, `nominal_kin.*, in cSt"):
        resolve(tmp_path / "p/config", {})


def test_unknown_names_and_units_are_asked_for(tmp_path: Path) -> None:
    bench, runs = bench_and_runs()
    (log,) = write_logs(tmp_path / "logs", bench, runs[:1], lines=slice(1))
    text = log.read_bytes()
    log.write_bytes(text.replace(b"Reibkraft [N]", b"Kanal 3").replace(b"Normalkraft [N]", b"Last"))
    made = make_project(tmp_path / "p", [log])
    asked = {line.partition(":")[0].strip(): line for _, _, line in made.to_fill_in}
    assert "Kanal 3" in asked["traction_force"]
    assert re.search(r"unit: *}", asked["load"])
    # the rest is known all the same, and nothing follows from a load in an unknown unit
    assert {"ball_track_radius_m", "disc_track_radius_m"} <= asked.keys()
    assert made.found.oils == {"oel-b-12": ["Öl B-12"]}
    assert "load_n" not in sheet_of(tmp_path / "p", made)[0]


def test_unit_without_brackets_is_read(tmp_path: Path) -> None:
    bench, runs = bench_and_runs()
    (log,) = write_logs(tmp_path / "logs", bench, runs[:1])
    text = log.read_bytes().decode("cp1252")
    for name in NAMES["german"].values():
        text = re.sub(rf"{name} \[(.*?)\]", rf"{name} in \1", text)
    log.write_bytes(text.encode("cp1252"))
    made = make_project(tmp_path / "p", [log])
    load = campaign_of(tmp_path / "p", made)["columns"]["load"]
    assert load == {"name": ["Normalkraft in N"], "unit": "N"}
    assert not made.found.logs[0].problem


def test_shipped_oil_and_rig_are_referred_to(tmp_path: Path) -> None:
    logs = [ETM / f"step{number:03}.csv.gz" for number in (3, 4)]
    made = make_project(tmp_path / "p", logs)
    campaign = campaign_of(tmp_path / "p", made)
    assert campaign["rigs"] == ["pcs-etm"]
    assert campaign["repeated_conditions"] == "accept"
    assert "config/rigs/pcs-etm.yaml" not in made.files
    bench, runs = bench_and_runs("Öl 4102")
    made = make_project(tmp_path / "q", write_logs(tmp_path / "logs", bench, runs))
    campaign = campaign_of(tmp_path / "q", made)
    assert (campaign["oils"], campaign["oil_aliases"]) == (["4102"], {"4102": ["Öl 4102"]})


def test_export_of_a_pcs_rig(tmp_path: Path, real_pcs: Path) -> None:
    """Three steps of film at 40, 60 and 80 degC, as the export's own text says; swept speed."""
    made = make_project(tmp_path / "p", [real_pcs / "demo_12.txt"])
    names, *rows = sheet_of(tmp_path / "p", made)
    assert names == "file,run,load_n,inlet_temperature_c,exclude,remarks"
    celsius = [float(row.split(",")[3]) for row in rows]
    assert celsius == pytest.approx([40, 60, 80], abs=1)
    assert made.found.rigs == ["pcs-rig"]


def test_logs_are_copied_and_a_given_run_sheet_is_kept(tmp_path: Path) -> None:
    bench, runs = bench_and_runs()
    logs = write_logs(tmp_path / "logs/day1", bench, runs)
    sheet = tmp_path / "logs/runs.csv"
    sheet.write_text("file;remarks\nMessung_0.csv;ours\n", encoding="utf-8")
    before = {path: path.read_bytes() for path in [*logs, sheet]}
    make_project(tmp_path / "p", [tmp_path / "logs"])
    raw = tmp_path / "p/data/raw/p"
    for path, content in before.items():
        assert path.read_bytes() == content
        assert (raw / path.relative_to(tmp_path / "logs")).read_bytes() == content


def test_nothing_is_overwritten_or_left_behind(tmp_path: Path) -> None:
    bench, runs = bench_and_runs()
    logs = write_logs(tmp_path / "logs", bench, runs[:1])
    with pytest.raises(OilfilmError, match="not empty"):
        make_project(tmp_path / "logs", [])
    again = write_logs(tmp_path / "other", bench, runs[1:2])
    with pytest.raises(OilfilmError, match=r"has the name of .*Rename one"):
        make_project(tmp_path / "p", [*logs, *again])
    unfit = tmp_path / "a{b}.csv"
    shutil.copy(logs[0], unfit)
    with pytest.raises(OilfilmError, match="cannot be in the name of a log"):
        make_project(tmp_path / "p", [unfit])
    for name in ("..", "a b", "x" * 200):
        with pytest.raises(OilfilmError, match=r"cannot be a name|Shorten it"):
            make_project(tmp_path / "p", logs, name)
    assert not (tmp_path / "p").exists()


def test_hostile_names_stay_text(tmp_path: Path) -> None:
    """The name of a column, an oil or a file cannot end a comment and write a key of its own."""
    bench, runs = bench_and_runs()
    oil = "a: [b] # \u2028seed: 1"
    run = replace(runs[0], oil=(oil,))
    (log,) = write_logs(tmp_path / "logs", bench, [run], replace(GERMAN, encoding="utf-8"))
    text = log.read_bytes().decode().replace("Reibkraft [N]", "'x', \u2028seed: 2 #")
    log.write_bytes(text.encode())
    damaged = tmp_path / "a\u2028seed: 3 #.csv"
    damaged.write_bytes(b"")
    made = make_project(tmp_path / "p", [log, damaged])
    campaign = campaign_of(tmp_path / "p", made)
    keys = "description data rigs oils columns figures header oil_aliases film_unjudged"
    assert set(campaign) <= {*keys.split(), "oils_without_properties"}


def test_damaged_and_foreign_files_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # what may be a damaged log is copied, so that the workflow refuses it by name
    damaged = {"a.gz": b"\x1f\x8bxx", "c.tdms": b"TDSm\0"}
    foreign = {"b.pdf": b"%PDF-1.4 \0\0", "d.csv": b""}
    for name, content in {**damaged, **foreign}.items():
        (tmp_path / name).write_bytes(content)
    logs = [str(tmp_path / name) for name in (*damaged, *foreign)]
    assert main(["init", str(tmp_path / "p"), *logs]) == 2
    printed = capsys.readouterr().err
    assert all(f"{name}: " in printed for name in (*damaged, *foreign))
    assert not (tmp_path / "p").exists()
    bench, runs = bench_and_runs()
    (good,) = write_logs(tmp_path / "good", bench, runs[:1])
    assert main(["init", str(tmp_path / "p"), str(good), *logs]) == 1
    printed = capsys.readouterr().out
    copied = {path.name for path in (tmp_path / "p/data/raw/p").iterdir()}
    assert copied == {*damaged, good.name, "runs.csv"}
    assert all(f"{name} could not be read: " in printed for name in damaged)
    assert all(f"{name} is no log and was not copied: " in printed for name in foreign)


def test_project_without_logs_says_what_to_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["init", str(tmp_path / "p")]) == 0
    assert "film_unjudged" in capsys.readouterr().out
    campaign = tmp_path / "p/config/campaigns/p.yaml"
    text = campaign.read_text(encoding="utf-8")
    campaign.write_text(re.sub("(?m)^film_unjudged:.*", FILM, text), encoding="utf-8")
    assert resolve(tmp_path / "p/config", {}).campaign.rigs == ["my-rig"]


def bodies_filled_in(project: Path, radius_m: float) -> None:
    """Radius and materials of steel on steel, without any roughness."""
    path = project / "config/rigs/my-rig.yaml"
    text = path.read_text(encoding="utf-8").replace("ball_radius_m:", f"ball_radius_m: {radius_m}")
    steel = "{youngs_modulus_pa: 206.0e+9, poisson_ratio: 0.3}"
    path.write_text(text.replace("{youngs_modulus_pa: , poisson_ratio: }", steel), "utf-8")


@pytest.mark.parametrize("stated", [False, True])
def test_pressure_needs_the_ball_but_no_roughness_unless_the_headers_state_it(
    tmp_path: Path, stated: bool
) -> None:
    """Runs at 1.0, 1.2 and 1.2 GPa, in the header or not."""
    # of the header the oil alone, or all of it
    made = made_of(tmp_path, METRES, slice(None), slice(None) if stated else slice(1))
    project, bench = tmp_path / "p", bench_and_runs()[0]
    asked = {line.partition(":")[0].strip() for _, _, line in made.to_fill_in}
    assert ({"ball_radius_m", "ball", "disc"} <= asked) == (not stated)
    if not stated:
        bodies_filled_in(project, float(bench.machine.ball_radius))
    campaign = project / "config/campaigns/p.yaml"
    text = campaign.read_text(encoding="utf-8")
    campaign.write_text(re.sub("(?m)^film_unjudged:.*", FILM, text), encoding="utf-8")
    settings = resolve(project / "config", {})
    paths = sorted((project / "data/raw/p").glob("M*.csv"))
    sheet = sheet_of_paths(paths, project / "data/raw", settings, TRACTION)
    logs = [(str(path), path.read_bytes()) for path in paths]
    points = check_logs(logs, settings, sheet=sheet).points
    pressure = points[points["accepted"]].groupby("run_id")["max_hertz_pressure_gpa"].median()
    planted = [condition.pressure for condition in CONDITIONS]
    # steel is near enough to what the bench has: pressure goes with E to the two thirds
    np.testing.assert_allclose(pressure, planted, rtol=1e-12 if stated else 0.1)
    assert points["lambda_ratio"].isna().all()


def test_repeats_are_accepted_only_where_whole_conditions_repeat(tmp_path: Path) -> None:
    """Runs at 16, 16 and 24 m/s: speeds in rpm are not known as speeds before the radii are."""
    bench, runs = bench_and_runs()
    logs = write_logs(tmp_path / "logs", bench, runs, lines=slice(1))
    made = make_project(tmp_path / "p", logs)
    assert not made.found.repeats
    assert "repeated_conditions" not in campaign_of(tmp_path / "p", made)
    twice = write_logs(tmp_path / "more", bench, [*runs[1:], runs[2]], METRES)
    assert make_project(tmp_path / "q", twice).found.repeats


@pytest.mark.parametrize(("step_s", "asked"), [(0.05, False), (50, True)])
def test_time_without_unit_is_seconds_and_one_missing_unit_loses_no_other_guess(
    tmp_path: Path, step_s: float, asked: bool
) -> None:
    names = "time,rpm ball,rpm disc,load,friction force N,oil temp degC"
    values = standstill.log()
    order = ["ball_speed", "disc_speed", "load", "traction_force", "inlet_temperature"]
    time = np.arange(len(values["time"])) * step_s
    rows = np.column_stack([time, *(values[name] for name in order)])
    text = "\n".join([names, *(",".join(map(str, row)) for row in rows.tolist())])
    (tmp_path / "log.csv").write_text(f"{text}\n", encoding="utf-8")
    made = make_project(tmp_path / "p", [tmp_path / "log.csv"])
    columns = campaign_of(tmp_path / "p", made)["columns"]
    assert columns["ball_speed"] == {"name": ["rpm ball"], "unit": "rpm"}
    assert columns["traction_force"]["unit"] == "N"
    assert columns["load"]["unit"] is None
    assert columns["time"]["unit"] == (None if asked else "s")
    keys = [line.partition(":")[0].strip() for _, _, line in made.to_fill_in]
    assert ("time" in keys) == asked
    assert {"load", "ball_track_radius_m", "disc_track_radius_m"} <= set(keys)
