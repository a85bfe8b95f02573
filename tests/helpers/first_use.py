"""Laboratories that use oilfilm for the first time: their logs, their answers, and the true mu.

Each writes runs of the blind bench in its own way. A person at a terminal answers what `oilfilm
init` asks, from the drawing of the rig. The true mu is that of the oil at the true slip.
"""

import io
from collections.abc import Callable, Iterator
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass, replace
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pandas as pd

from blind_lab.bench import Bench, Recording, draw_bench
from blind_lab.truth import Oil, draw_machine, draw_oil
from foreign_logs import CONDITIONS
from oilfilm.cli import main
from oilfilm.curation.curate import curate_logs
from oilfilm.logs.ingest import read_bytes
from oilfilm.logs.raw_files import raw_log_names
from oilfilm.logs.sheet_file import sheet_of_paths
from oilfilm.logs.traction_log import TRACTION
from oilfilm.settings.resolve import resolve

_SEED = 5
# Lever arm of the torque.
_ARM_M = 0.035
_RPM_PER_RAD_S = 60 / (2 * np.pi)
ENGLISH = ("Time [s]", "Load [N]", "Traction force [N]", "Ball speed [rpm]", "Disc speed [rpm]")
GERMAN = ("Zeit [s]", "Normalkraft [N]", "Reibkraft [N]", "Kugel [1/min]", "Scheibe [1/min]")
JAPANESE = ("時間(s)", "荷重(N)", "摩擦力(N)", "ボール回転数(rpm)", "ディスク回転数(rpm)")
CHINESE = ("时间 [s]", "载荷 [N]", "摩擦力 [N]", "球转速 [rpm]", "盘转速 [rpm]")
# Writes the runs of a bench into a folder.
Write = Callable[[Path, Bench, list[Recording]], None]


@dataclass(frozen=True)
class FirstUse:
    """A laboratory.

    Attributes:
        name: What is special about it.
        write: Writes its logs.
        rate_hz: Sampling rate; that of the bench where it is 0.
        hold_s: Time at each slip, and of rolling; that of the bench where it is 0.
        log_every: Only every n-th row is logged, with this n.
        answers: Answers by key, beside those that every rig has.
    """

    name: str
    write: Write
    rate_hz: float = 0.0
    hold_s: float = 0.0
    log_every: int = 1
    answers: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Outcome:
    """What became of a laboratory.

    Attributes:
        questions: Questions that were asked.
        left_open: Number of keys that the person could not answer.
        accepted: Accepted points.
        error: Relative root mean square error of mu.
        inside: Share of points whose error is within two standard errors and the calibration.
        printed: What `init` printed.
    """

    questions: int
    left_open: int
    accepted: int
    error: float
    inside: float
    printed: str


def _frame(bench: Bench, run: Recording, names: tuple[str, ...], celsius: str) -> pd.DataFrame:
    """A run with speeds of spindles, as a table."""
    signals = run.signals
    machine = bench.machine
    columns = (
        signals["time"],
        signals["load"],
        signals["force"],
        signals["ball"] / machine.ball_track * _RPM_PER_RAD_S,
        signals["disc"] / machine.disc_track * _RPM_PER_RAD_S,
        signals["celsius"],
    )
    table = dict(zip((*names, celsius), columns, strict=True))
    return pd.DataFrame(table).round(5)


def csv_logs(
    names: tuple[str, ...], celsius: str, encoding: str, sep: str = ",", decimal: str = "."
) -> Write:
    """A text per run."""

    def write(folder: Path, bench: Bench, runs: list[Recording]) -> None:
        for number, run in enumerate(runs):
            table = _frame(bench, run, names, celsius)
            text = table.to_csv(index=False, sep=sep, decimal=decimal)
            (folder / f"run{number}.csv").write_bytes(text.encode(encoding))

    return write


def workbooks(folder: Path, bench: Bench, runs: list[Recording]) -> None:
    """A workbook per run."""
    for number, run in enumerate(runs):
        table = _frame(bench, run, ENGLISH, "Oil temperature [degC]")
        table.to_excel(folder / f"run{number}.xlsx", index=False)


def one_workbook(folder: Path, bench: Bench, runs: list[Recording]) -> None:
    """A workbook with a sheet per run."""
    with pd.ExcelWriter(folder / "all.xlsx") as book:
        for number, run in enumerate(runs):
            table = _frame(bench, run, GERMAN, "Öltemperatur [°C]")
            table.to_excel(book, sheet_name=f"Messung {number}", index=False)


def torque_logs(name: str) -> Write:
    """A text per run, with a torque in place of the force."""

    def write(folder: Path, bench: Bench, runs: list[Recording]) -> None:
        for number, run in enumerate(runs):
            table = _frame(bench, run, ENGLISH, "Oil temperature [degC]")
            table[ENGLISH[2]] *= _ARM_M
            table = table.rename(columns={ENGLISH[2]: name})
            table.to_csv(folder / f"run{number}.csv", index=False)

    return write


def one_table(folder: Path, bench: Bench, runs: list[Recording]) -> None:
    """One text with a column that numbers the runs."""
    frames = []
    for number, run in enumerate(runs, start=1):
        table = _frame(bench, run, ENGLISH, "Oil temperature [degC]")
        table.insert(0, "Run", number)
        frames.append(table)
    pd.concat(frames).to_csv(folder / "all.csv", index=False)


def blocks(folder: Path, bench: Bench, runs: list[Recording]) -> None:
    """One text with a header per run."""
    text = "Rig protocol\n"
    for number, run in enumerate(runs, start=1):
        table = _frame(bench, run, ENGLISH, "Oil temperature [degC]")
        text += f"\nTest {number}\n{table.to_csv(index=False, sep=chr(9))}"
    (folder / "all.txt").write_text(text, "utf-8")


LABORATORIES = (
    FirstUse("German, cp1252", csv_logs(GERMAN, "Öltemperatur [°C]", "cp1252", ";", ",")),
    FirstUse("Japanese, Shift-JIS", csv_logs(JAPANESE, "油温(℃)", "cp932")),
    FirstUse("Chinese, GB18030", csv_logs(CHINESE, "油温 [°C]", "gb18030", "\t")),
    FirstUse("English, UTF-16", csv_logs(ENGLISH, "Oil temperature [degC]", "utf-16", "\t")),
    FirstUse("a workbook per run", workbooks),
    FirstUse("a sheet per run", one_workbook),
    FirstUse(
        "torque in N m",
        torque_logs("Disc torque [N.m]"),
        answers=(("traction_force", "Disc torque"), ("torque_arm_m", f"{_ARM_M} m")),
    ),
    FirstUse(
        "torque in mN m without an arm",
        torque_logs("Disc torque [mN.m]"),
        answers=(("traction_force", "Disc torque"),),
    ),
    FirstUse("runs in one table", one_table),
    FirstUse("repeated headers", blocks),
    FirstUse("0.5 Hz", csv_logs(ENGLISH, "Oil temperature [degC]", "utf-8"), 20.0, 60.0, 40),
    FirstUse("400 Hz", csv_logs(ENGLISH, "Oil temperature [degC]", "utf-8"), 400.0, 3.0),
)


class Person:
    """Answers by the key that is asked for; what is not known is left open."""

    def __init__(self, answers: dict[str, str]) -> None:
        self.questions = 0
        self.printed = io.StringIO()
        self._answers = answers

    def answer(self, prompt: str) -> str:
        """The answer to a question: the key is in the last line that names a line of a file."""
        self.questions += 1
        named = [line for line in self.printed.getvalue().splitlines() if ", line " in line]
        key = named[-1].rpartition(": ")[2] if named else ""
        # an answer that was refused is given once only
        return self._answers.pop(key, "")


def bench_and_oil(laboratory: FirstUse) -> tuple[Bench, Oil, list[Recording]]:
    """The bench of a laboratory, its oil, and one run at each condition."""
    random = np.random.default_rng(_SEED)
    bench = draw_bench(random, draw_machine(random))
    oil = draw_oil(random, ("B-12",))
    if laboratory.rate_hz:
        hold_s = laboratory.hold_s
        bench = replace(bench, rate=laboratory.rate_hz, hold=hold_s, rolling=hold_s)
    runs = [bench.run(oil, condition, random) for condition in CONDITIONS]
    return bench, oil, [run.rows(np.arange(0, len(run), laboratory.log_every)) for run in runs]


def first_use(laboratory: FirstUse, folder: Path) -> Outcome:
    """Let a laboratory make a project, and compare its accepted points with the truth."""
    bench, oil, runs = bench_and_oil(laboratory)
    logs = folder / "logs"
    logs.mkdir(parents=True)
    laboratory.write(logs, bench, runs)
    machine = bench.machine
    answers = {
        "film_unjudged": "thick by experience",
        "ball_track_radius_m": repr(float(machine.ball_track)),
        "disc_track_radius_m": repr(float(machine.disc_track)),
        "ball_radius_m": repr(float(machine.ball_radius)),
        "ball": "206e9 0.3",
        "disc": "206e9 0.3",
        "zero": "rolling_phases",
    }
    person = Person({**answers, **dict(laboratory.answers)})
    project = folder / "june"
    with (
        redirect_stdout(person.printed),
        redirect_stderr(person.printed),
        patch("builtins.input", person.answer),
        patch("oilfilm.cli.init.is_terminal", lambda: True),
    ):
        main(["init", str(project), str(logs)])
    printed = person.printed.getvalue()
    left_open = printed.count("# FILL IN")
    if not project.is_dir() or left_open:
        return Outcome(person.questions, left_open, 0, np.nan, np.nan, printed)
    points = _accepted(project)
    errors = _errors(points, oil, machine.pressure) if len(points) else np.array([])
    allowed = 2 * points["traction_coefficient_se"] / points["traction_coefficient"] + 0.01
    return Outcome(
        person.questions,
        left_open,
        len(points),
        float(np.sqrt(np.mean(errors**2))) if len(errors) else np.nan,
        float(np.mean(np.abs(errors) <= allowed)) if len(errors) else np.nan,
        printed,
    )


def _accepted(project: Path) -> pd.DataFrame:
    """Accepted points of the campaign `june` of a project."""
    settings = resolve(project / "config", {})
    raw = project / "data/raw"
    paths = [raw / "june" / name for name in raw_log_names(raw / "june")]
    sheet = sheet_of_paths(paths, raw, settings, TRACTION)
    logs = [(str(path), read_bytes(path)) for path in paths]
    points = curate_logs(logs, settings, sheet=sheet).points
    accepted = points[points["accepted"]]
    # below that the zero of the force is most of the error
    return accepted[accepted["slide_roll_ratio"] > 0.01]


def _errors(
    points: pd.DataFrame, oil: Oil, pressure_pa: Callable[[np.ndarray], np.ndarray]
) -> np.ndarray:
    """Relative errors of mu at the measured conditions."""
    true = oil.traction(
        pressure_pa(points["load_n"].to_numpy()) / 1e9,
        points["entrainment_speed_m_s"].to_numpy(),
        points["inlet_temperature_c"].to_numpy(),
        points["slide_roll_ratio"].to_numpy(),
    )
    return np.asarray(points["traction_coefficient"].to_numpy() / true - 1)


def outcomes(folder: Path) -> Iterator[tuple[FirstUse, Outcome]]:
    """All laboratories, one after the other."""
    for number, laboratory in enumerate(LABORATORIES):
        yield laboratory, first_use(laboratory, folder / str(number))
