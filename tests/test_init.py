"""A new project folder says of logs what is true of them, and asks for what is not known."""

import re
import shutil
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml

import formats
import standstill
from blind_lab.bench import Recording
from blind_lab.dialects import Dialect, draw_dialect
from campaigns import ETM, ROOT
from command_line import printed_objects
from foreign_logs import CONDITIONS, GERMAN, bench_and_runs, write_logs
from oilfilm.base.errors import OilfilmError
from oilfilm.cli import main
from oilfilm.cli.init import NewProject, lines_on_abilities, make_project
from oilfilm.cli.settings_line import settings_line
from oilfilm.curation.curate import curate_logs
from oilfilm.logs.base import NO_DIALECT
from oilfilm.logs.sheet_file import sheet_of_paths
from oilfilm.logs.sniff import Findings, SniffedLog, SniffedRun
from oilfilm.logs.traction_log import TRACTION
from oilfilm.settings.resolve import resolve

FILM = "film_unjudged: {accept: true, reason: thick by experience}"
METRES = GERMAN.with_units(ball="m/s", disc="m/s")
BENCH, RUNS = bench_and_runs()
MACHINE = BENCH.machine


@dataclass(frozen=True)
class Project:
    """A folder that `init` has made."""

    folder: Path
    new_project: NewProject

    @property
    def campaign_file(self) -> Path:
        return self.folder / f"config/campaigns/{self.new_project.campaign_name}.yaml"

    @property
    def campaign_values(self) -> dict[str, Any]:
        return dict(yaml.safe_load(self.campaign_file.read_text(encoding="utf-8")))

    @property
    def raw_folder(self) -> Path:
        return self.folder / "data/raw" / self.new_project.campaign_name

    @property
    def sheet_lines(self) -> list[str]:
        return (self.raw_folder / "runs.csv").read_text(encoding="utf-8-sig").splitlines()

    @property
    def lines_by_key(self) -> dict[str, str]:
        """The lines to fill in, by their key."""
        return {
            line.partition(":")[0].strip(): line for _, _, line in self.new_project.lines_to_fill_in
        }

    def fill_in(self, **values: float) -> int:
        """Write values into the lines to fill in, as an editor would; how many were changed."""
        for file, number, line in self.new_project.lines_to_fill_in:
            path, key = self.folder / file, line.partition(":")[0].strip()
            lines = path.read_text(encoding="utf-8").splitlines()
            lines[number - 1] = FILM if key == "film_unjudged" else f"{key}: {values[key]}"
            path.write_text("\n".join([*lines, ""]), encoding="utf-8")
        return len(self.new_project.lines_to_fill_in)

    def points(self) -> pd.DataFrame:
        """The accepted points of all logs by the settings as they are."""
        settings = resolve(self.folder / "config", {})
        paths = sorted(path for path in self.raw_folder.glob("*.csv") if path.name != "runs.csv")
        run_sheet = sheet_of_paths(paths, self.folder / "data/raw", settings, TRACTION)
        logs = [(str(path), path.read_bytes()) for path in paths]
        points = curate_logs(logs, settings, sheet=run_sheet).points
        return points[points["accepted"]]


def project_of(folder: Path, logs: list[Path]) -> Project:
    return Project(folder, make_project(folder, logs))


def project(
    tmp_path: Path,
    runs: list[Recording] | None = None,
    dialect: Dialect = GERMAN,
    lines: slice = slice(None),
    change: Callable[[bytes], bytes] = bytes,
) -> Project:
    """The project `p` of runs of the bench, with some of their header lines, changed as bytes."""
    logs = write_logs(tmp_path / "logs", BENCH, runs or RUNS[:1], dialect, lines)
    for log in logs:
        log.write_bytes(change(log.read_bytes()))
    return project_of(tmp_path / "p", logs)


def project_of_bytes(tmp_path: Path, content: bytes) -> Project:
    (tmp_path / "log.csv").write_bytes(content)
    return project_of(tmp_path / "p", [tmp_path / "log.csv"])


def accepted(
    made_project: Project, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> list[dict[str, Any]]:
    """What `check` says of the three logs of a bench after at most three lines are filled in."""
    tracks = {"ball": MACHINE.ball_track, "disc": MACHINE.disc_track}
    assert made_project.fill_in(**{f"{body}_track_radius_m": r for body, r in tracks.items()}) <= 3
    monkeypatch.chdir(made_project.folder)
    raw = Path("data/raw", made_project.new_project.campaign_name)
    checked = printed_objects(capsys, "check", *sorted(raw.rglob("M*.csv")))
    assert [log["verdict"] for log in checked] == ["accepted"] * 3
    return checked


def test_german_logs_are_accepted_after_three_lines(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """cp1252, semicolons, decimal commas, spindle speeds: only radii and film are the lab's."""
    checked = accepted(project(tmp_path, RUNS), monkeypatch, capsys)
    for log, at in zip(checked, CONDITIONS, strict=True):
        (run,) = log["runs"]
        assert (log["encoding"], run["oil"]) == ("cp1252", "oel-b-12")
        points = {name: point and point["value"] for name, point in run["set_points"].items()}
        assert points["max_hertz_pressure_gpa"] == at.pressure
        assert points["entrainment_speed_m_s"] == at.speed
        assert points["inlet_temperature_c"] == at.celsius
        # the speed follows from the radii: it is the planted one
        fastest = run["measured"]["entrainment_speed_m_s"]["maximum"]
        assert fastest == pytest.approx(at.speed, rel=0.005)


def test_english_french_and_chinese_logs_in_one_folder_are_accepted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    random = np.random.default_rng(3)
    runs = bench_and_runs("Turbo 5 alt")[1]
    drawn = [draw_dialect(random) for _ in range(50)]
    languages = {dialect.language: replace(dialect, packed=False) for dialect in drawn}
    del languages["german"]
    for run, (language, dialect) in zip(runs, languages.items(), strict=True):
        write_logs(tmp_path / "lab" / language, BENCH, [run], dialect)
    accepted(project_of(tmp_path / "blind", [tmp_path / "lab"]), monkeypatch, capsys)


def test_set_points_that_no_header_gives_are_those_of_the_bench(tmp_path: Path) -> None:
    names, *rows = project(tmp_path, RUNS, METRES, slice(1)).sheet_lines
    assert names == "file;load_n;entrainment_speed_m_s;inlet_temperature_c;exclude;remarks"
    for row, condition in zip(rows, CONDITIONS, strict=True):
        _, *cells, _, remarks = row.split(";")
        load, speed, celsius = (float(cell.replace(",", ".")) for cell in cells)
        # three standard deviations of the bench's control and calibration, and the rounding
        assert load == pytest.approx(MACHINE.load(condition.pressure * 1e9), rel=0.02)
        assert speed == pytest.approx(condition.speed, rel=0.005)
        assert celsius == pytest.approx(condition.celsius, abs=1)
        assert remarks.startswith("guess")


def test_header_in_another_unit_is_not_listed_for_a_key_in_gpa(tmp_path: Path) -> None:
    made_project = project(
        tmp_path, change=lambda text: text.replace(b"Pressung GPa: 1,0", b"Pressung MPa: 1000")
    )
    assert "max_hertz_pressure_gpa" not in made_project.campaign_values["header"]


def rig_log(values: dict[str, np.ndarray]) -> bytes:
    return formats.csv(values, standstill.UNITS, {"oil": "B-12"})


REVERSED = {**standstill.log(), "traction_force": -standstill.log()["traction_force"]}


@pytest.mark.parametrize(
    ("values", "source"),
    [
        (standstill.log((0.0, *standstill.LEVELS, 0.0)), "rolling_phases"),
        (standstill.log((0.0, *standstill.LEVELS)), "opening_phase"),
        # S = 0.002 is within the limit of pure rolling, but part of this curve
        (standstill.log(), "standstill"),
        (REVERSED, "standstill"),
        (standstill.log(still_s=(0.0, 0.0), ramp_s=0.0), None),
    ],
)
def test_source_of_the_zero_is_the_one_that_the_log_has(
    tmp_path: Path, values: dict[str, np.ndarray], source: str | None
) -> None:
    made_project = project_of_bytes(tmp_path, rig_log(values))
    assert made_project.campaign_values["semantics"]["zero"] == source
    # a guess is no line that must be filled in
    assert ("zero" in made_project.lines_by_key) == (source is None)


@pytest.mark.parametrize("offset_n", [0.35, -1.2])
def test_log_with_standstill_is_right_after_one_line(tmp_path: Path, offset_n: float) -> None:
    made_project = project_of_bytes(tmp_path, rig_log(standstill.log(offset_n=offset_n)))
    # levels of the rows that turn, although a third of the log is at standstill
    assert made_project.sheet_lines[1].startswith("log.csv,40,2,70,")
    assert made_project.fill_in() == 1
    points = made_project.points()
    assert len(points) == len(standstill.LEVELS)
    truth = standstill.planted_mu(points["slide_roll_ratio"].to_numpy())
    # five standard errors of a mean of 0.01 N over 2 s at 20 Hz, twice, over 40 N
    np.testing.assert_allclose(points["traction_coefficient"], truth, atol=4e-4)


def test_other_files_are_not_copied(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lab, raw = tmp_path / "lab", tmp_path / "p/data/raw/p"
    (good,) = write_logs(lab, BENCH, RUNS[:1])
    foreign = {
        **{"rig.jpg": b"\xff\xd8\xff\xe0\0\x10JFIF", "a.bin": bytes(range(250, 240, -1))},
        **{"LICENSE.txt": (ROOT / "LICENSE").read_bytes(), "notes.txt": b"Oil changed, 3 May."},
        **{"b.pdf": b"%PDF-1.4 \0\0", "d.csv": b"", "unknown.csv": b"qa;qb;qc\n1,5;2,5;3,5\n"},
    }
    # what may be a damaged log is copied, so that the workflow refuses it by name
    unusable = {"a.gz": b"\x1f\x8bxx", "c.tdms": b"TDSm\0"}
    for name, content in {**foreign, **unusable}.items():
        (lab / name).write_bytes(content)
    others = [str(lab / name) for name in (*foreign, *unusable)]
    assert main(["init", str(tmp_path / "p"), *others]) == 2
    assert not (tmp_path / "p").exists()
    printed = capsys.readouterr().err
    assert all(f"{name}: " in printed for name in (*foreign, *unusable))
    assert main(["init", str(tmp_path / "p"), str(lab)]) == 1
    printed = capsys.readouterr().out
    assert all(f"{name} is no log and was not copied: " in printed for name in foreign)
    assert all(f"{name} could not be read: " in printed for name in unusable)
    assert {path.name for path in raw.iterdir()} == {good.name, *unusable, "runs.csv"}
    assert "LICENSE" not in (raw / "runs.csv").read_text("utf-8-sig")
    for name in unusable:
        (lab / name).unlink()
    assert main(["init", str(tmp_path / "q"), str(lab)]) == 0


def test_what_is_left_empty_is_named_with_file_line_and_key(tmp_path: Path) -> None:
    made_project = project(tmp_path)
    config = made_project.folder / "config"
    assert len(made_project.new_project.lines_to_fill_in) == 3
    for file, number, line in made_project.new_project.lines_to_fill_in:
        key = line.partition(":")[0]
        with pytest.raises(
            OilfilmError, match=rf"{file}, line {number}, `{key}`: found nothing; fill in"
        ):
            resolve(config, {})
        path, value = made_project.folder / file, FILM if key == "film_unjudged" else f"{key}: 0.01"
        path.write_text(path.read_text(encoding="utf-8").replace(line, value), encoding="utf-8")
    assert resolve(config, {}).campaign.name == "p"
    # an oil that is moved to `oils` needs its own numbers
    text = made_project.campaign_file.read_text(encoding="utf-8").replace("oils: []\n", "")
    text = text.replace("oils_without_properties:", "oils:")
    made_project.campaign_file.write_text(text, encoding="utf-8")
    with pytest.raises(OilfilmError, match=r"oel-b-12.yaml, line \d+, `nominal_kinematic"):
        resolve(config, {})


def test_unknown_names_and_units_are_asked_for(tmp_path: Path) -> None:
    made_project = project(
        tmp_path,
        lines=slice(1),
        change=lambda text: text.replace(b"Reibkraft [N]", b"Kanal 3").replace(
            b"Normalkraft [N]", b"Last"
        ),
    )
    assert "Kanal 3" in made_project.lines_by_key["traction_force"]
    assert re.search(r"unit: *}", made_project.lines_by_key["load"])
    # the rest is known all the same, and nothing follows from a load in an unknown unit
    assert {"ball_track_radius_m", "disc_track_radius_m"} <= made_project.lines_by_key.keys()
    assert made_project.new_project.findings.labels_of_oil == {"oel-b-12": ["Öl B-12"]}
    assert "load_n" not in made_project.sheet_lines[0]


def test_shipped_oil_and_rig_are_referred_to(tmp_path: Path) -> None:
    made_project = project_of(
        tmp_path / "q", [ETM / f"step{number:03}.csv.gz" for number in (3, 4)]
    )
    assert made_project.campaign_values["rigs"] == ["pcs-etm"]
    assert made_project.campaign_values["repeated_conditions"] == "accept"
    assert "config/rigs/pcs-etm.yaml" not in made_project.new_project.text_by_path
    campaign = project(tmp_path, bench_and_runs("Öl 4102")[1]).campaign_values
    assert (campaign["oils"], campaign["oil_aliases"]) == (["4102"], {"4102": ["Öl 4102"]})


@pytest.mark.parametrize(
    ("labels", "labels_of_oil"),
    [
        (
            ["4102 fresh", "4102 aged", "Oil 4102", "4102"],
            {
                "4102-fresh": ["4102 fresh"],
                "4102-aged": ["4102 aged"],
                "4102": ["Oil 4102", "4102"],
            },
        ),
        (["A+", "A-"], {"a": ["A+"], "a-2": ["A-"]}),
        (["油", "PAO 4", "pao  4"], {"oil-1": ["油"], "pao-4": ["PAO 4", "pao  4"]}),
    ],
)
def test_names_are_of_one_oil_where_they_differ_in_nothing_but_the_word_oil(
    labels: list[str], labels_of_oil: dict[str, list[str]]
) -> None:
    runs = [SniffedRun(oil_name=label) for label in labels]
    log = SniffedLog("a.xlsx", "xlsx", NO_DIALECT, {}, {}, [], {}, "", runs, may_be_log=True)
    assert Findings([log]).labels_of_oil == labels_of_oil


def test_export_of_a_pcs_rig(tmp_path: Path, real_pcs: Path) -> None:
    """Three steps of film at 40, 60 and 80 degC, as the export's own text says; swept speed."""
    made_project = project_of(tmp_path / "p", [real_pcs / "demo_12.txt"])
    names, *rows = made_project.sheet_lines
    assert names == "file,run,load_n,inlet_temperature_c,exclude,remarks"
    celsius = [float(row.split(",")[3]) for row in rows]
    assert celsius == pytest.approx([40, 60, 80], abs=1)
    assert made_project.new_project.findings.rig_names == ["pcs-rig"]


def test_logs_are_copied_and_a_given_run_sheet_is_kept(tmp_path: Path) -> None:
    logs = write_logs(tmp_path / "logs/day1", BENCH, RUNS)
    sheet = tmp_path / "logs/runs.csv"
    sheet.write_text("file;remarks\nMessung_0.csv;ours\n", encoding="utf-8")
    before = {path: path.read_bytes() for path in [*logs, sheet]}
    made_project = project_of(tmp_path / "p", [tmp_path / "logs"])
    for path, content in before.items():
        assert path.read_bytes() == content
        assert (
            made_project.raw_folder / path.relative_to(tmp_path / "logs")
        ).read_bytes() == content


def test_a_run_sheet_that_is_named_beside_its_folder_is_one(tmp_path: Path) -> None:
    write_logs(tmp_path / "logs", BENCH, RUNS[:1])
    sheet = tmp_path / "logs/runs.csv"
    sheet.write_text("file;remarks\nMessung_0.csv;ours\n", encoding="utf-8")
    made_project = project_of(tmp_path / "p", [tmp_path / "logs", sheet])
    assert (made_project.raw_folder / "runs.csv").read_bytes() == sheet.read_bytes()


def test_a_project_is_not_called_as_the_patterns_of_settings(tmp_path: Path) -> None:
    logs = write_logs(tmp_path / "logs", BENCH, RUNS[:1])
    with pytest.raises(OilfilmError, match="Choose another name"):
        make_project(tmp_path / "template", logs)
    assert not (tmp_path / "template").exists()


def test_film_is_not_called_unknown_where_oil_and_rig_come_with_oilfilm() -> None:
    def abilities(oil_name: str) -> str:
        run = SniffedRun(oil_name=oil_name, rig_name="ball-on-disc-20mm")
        log = SniffedLog("a", "csv", NO_DIALECT, {}, {}, [], {}, "", [run], may_be_log=True)
        return " ".join(lines_on_abilities(Findings([log])))

    assert "film thickness" in abilities("B-12")
    assert "film thickness" not in abilities("4102")


def test_runs_without_an_oil_in_the_sheet_are_counted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    logs = write_logs(tmp_path / "logs", BENCH, RUNS[:3])
    logs[0].write_bytes(logs[0].read_bytes().replace(b"B-12", b"C-12"))
    with_oil = logs[1].read_bytes()
    logs[1].write_bytes(re.sub(rb"(?m)^.*B-12.*\n", b"", with_oil))
    assert with_oil != logs[1].read_bytes()
    main(["init", "--no-questions", str(tmp_path / "p"), *map(str, logs)])
    assert "data/raw/p/runs.csv: fill in the column oil of 1 run" in capsys.readouterr().out


def test_nothing_is_overwritten_or_left_behind(tmp_path: Path) -> None:
    logs = write_logs(tmp_path / "logs", BENCH, RUNS[:1])
    again = write_logs(tmp_path / "other", BENCH, RUNS[1:2])
    unfit = Path(shutil.copy(logs[0], tmp_path / "a{b}.csv"))
    for folder, given, sentence in (
        ("logs", logs, "not empty"),
        ("p", [*logs, *again], r"has the name of .*Rename one"),
        ("p", [unfit], "cannot be in the name of a log"),
        ("a b", logs, "cannot be a name"),
        ("2026.03", logs, "read it as a number"),
        ("007", logs, "read it as a number"),
        ("no", logs, "or another value"),
    ):
        with pytest.raises(OilfilmError, match=sentence):
            make_project(tmp_path / folder, given)
    assert not (tmp_path / "p").exists()


def test_hostile_names_stay_text(tmp_path: Path) -> None:
    """The name of a column, an oil or a file cannot end a comment and write a key of its own."""
    run = replace(RUNS[0], oil=("a: [b] # \u2028seed: 1",))
    (log,) = write_logs(tmp_path / "logs", BENCH, [run], replace(GERMAN, encoding="utf-8"))
    text = log.read_bytes().decode().replace("Reibkraft [N]", "'x', \u2028seed: 2 #")
    log.write_bytes(text.encode())
    damaged = tmp_path / "a # seed: 3.csv"
    damaged.write_bytes(b"")
    campaign = project_of(tmp_path / "p", [log, damaged]).campaign_values
    keys = "description data rigs oils columns figures header oil_aliases film_unjudged"
    assert set(campaign) <= {*keys.split(), "oils_without_properties"}


def test_settings_files_begin_with_the_schema_by_which_editors_check_them(tmp_path: Path) -> None:
    """Those of the clone, which the wheel holds in the same folders, and those of a new project."""
    made_project = project(tmp_path)
    for config in (ROOT / "config", made_project.folder / "config"):
        files = list(config.rglob("*.yaml"))
        assert len(files) >= 4
        for file in files:
            kind = "config" if file.parent == config else file.parent.name.removesuffix("s")
            mark, schema = file.read_text(encoding="utf-8").split("\n", 1)[0].split("$schema=")
            assert mark == "# yaml-language-server: "
            assert (file.parent / schema).resolve().name == f"{kind}.schema.json"
            assert (file.parent / schema).is_file()


@pytest.mark.slow
@pytest.mark.parametrize("stated", [False, True])
def test_pressure_needs_the_ball_unless_the_headers_state_it(tmp_path: Path, stated: bool) -> None:
    """Runs at 1.0, 1.2 and 1.2 GPa, in the header or not."""
    # of the header the oil alone, or all of it
    made_project = project(tmp_path, RUNS, METRES, slice(None) if stated else slice(1))
    assert ({"ball_radius_m", "ball", "disc"} <= made_project.lines_by_key.keys()) == (not stated)
    if not stated:
        rig = made_project.folder / "config/rigs/my-rig.yaml"
        steel = "{youngs_modulus_pa: 206.0e+9, poisson_ratio: 0.3}"
        unknown = "{youngs_modulus_pa: , poisson_ratio: }"
        text = rig.read_text(encoding="utf-8").replace(unknown, steel)
        radius = f"ball_radius_m: {MACHINE.ball_radius}"
        rig.write_text(text.replace("ball_radius_m:", radius), encoding="utf-8")
    text = re.sub(
        "(?m)^film_unjudged:.*", FILM, made_project.campaign_file.read_text(encoding="utf-8")
    )
    made_project.campaign_file.write_text(text, encoding="utf-8")
    points = made_project.points()
    pressure = points.groupby("run_id")["max_hertz_pressure_gpa"].median()
    planted = [condition.pressure for condition in CONDITIONS]
    # steel is near enough to what the bench has: pressure goes with E to the two thirds
    np.testing.assert_allclose(pressure, planted, rtol=1e-12 if stated else 0.1)
    assert points["lambda_ratio"].isna().all()


def test_repeats_are_accepted_only_where_whole_conditions_repeat(tmp_path: Path) -> None:
    """Runs at 16, 16 and 24 m/s: speeds in rpm are not known as speeds before the radii are."""
    assert "repeated_conditions" not in project(tmp_path, RUNS, lines=slice(1)).campaign_values
    twice = write_logs(tmp_path / "more", BENCH, [*RUNS[1:], RUNS[2]], METRES)
    assert project_of(tmp_path / "q", twice).campaign_values["repeated_conditions"] == "accept"


@pytest.mark.parametrize(("step_s", "asked"), [(0.05, False), (50, True)])
def test_time_without_unit_is_seconds_if_it_may_be(
    tmp_path: Path, step_s: float, asked: bool
) -> None:
    names = "time,rpm ball,rpm disc,load,friction force N,oil temp degC"
    values = standstill.log()
    order = ["ball_speed", "disc_speed", "load", "traction_force", "inlet_temperature"]
    time = np.arange(len(values["time"])) * step_s
    rows = np.column_stack([time, *(values[name] for name in order)])
    text = "\n".join([names, *(",".join(map(str, row)) for row in rows.tolist()), ""])
    made_project = project_of_bytes(tmp_path, text.encode())
    columns = made_project.campaign_values["columns"]
    assert columns["ball_speed"] == {"name": ["rpm ball"], "unit": "rpm"}
    assert columns["traction_force"]["unit"] == "N"
    assert columns["load"]["unit"] is None
    assert columns["time"]["unit"] == (None if asked else "s")
    assert ("time" in made_project.lines_by_key) == asked
    assert {
        "load",
        "ball_track_radius_m",
        "disc_track_radius_m",
    } <= made_project.lines_by_key.keys()


@pytest.mark.parametrize("names", [("time", "total time"), ("Time [s]", "Total Time [s]")])
def test_a_time_beside_a_total_time_is_asked_for(tmp_path: Path, names: tuple[str, str]) -> None:
    time_name, total_name = names
    header = f"{time_name},{total_name},rpm ball,rpm disc,load N,friction force N,oil temp degC"
    values = standstill.log()
    order = ["ball_speed", "disc_speed", "load", "traction_force", "inlet_temperature"]
    total_s = np.arange(len(values["time"])) * 0.05
    # restarts in every step
    rows = np.column_stack([total_s % 10, total_s, *(values[name] for name in order)])
    text = "\n".join([header, *(",".join(map(str, row)) for row in rows.tolist()), ""])
    made_project = project_of_bytes(tmp_path, text.encode())
    assert f"perhaps {time_name}, {total_name}" in made_project.lines_by_key["time"]


def test_only_a_key_without_a_value_is_left_empty() -> None:
    assert (
        settings_line("oil", {"name": "4010", "density": None}) == "oil: {name: '4010', density: }"
    )
    assert settings_line("oil", {"name": "not null"}) == "oil: {name: not null}"
