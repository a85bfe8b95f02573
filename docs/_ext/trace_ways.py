"""Prints which files four things pass in the library: a row, a limit, a law's name, a load.

A small campaign is carried through the functions that the scripts of the workflow call. The result
is JSON: the ways, the steps of each, and the files of each step in the order in which they are
first entered. A process of its own does this, because caches that are filled already hide files.
"""

import importlib
import json
import os
import pkgutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
import pandas as pd

import oilfilm
from oilfilm.api.log_check import reports_on_logs, reports_text
from oilfilm.base.digests import file_digest
from oilfilm.base.home import HOME
from oilfilm.curation.curate import collect, curate_ingested, curate_share
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.exports.campaign import export_campaign
from oilfilm.fits.fit import fit_law
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.soundness import finished_fit_tables
from oilfilm.logs.ingest import ingest_logs
from oilfilm.logs.raw_files import RawLogs
from oilfilm.logs.run_sheet import NO_SHEET
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.bearing_torque import cage_slip_table, oils_in_bearings
from oilfilm.traction import LAWS

_LIBRARY = str(Path(oilfilm.__file__).parent)
_OIL, _LAW = "4102", "tanh"
_CAMPAIGN = """\
description: eight runs of one oil
data: simulated
simulated_by: trace_ways.py
rigs: [ball-on-disc-20mm]
oils: ["4102"]
figures: [curves]
torque:
  bearing: mainshaft-167
  calibration: {torque_relative: 0.003, torque_n_m: 0.01}
settings:
  gates: {lambda_limit: 5.0}
  fit: {law: tanh, bootstrap: 20, searches: 2}
  compare: {laws: [tanh]}
  bearing:
    uncertainty: {draws: 40}
    cage_slip: {pitch_speed_mm_rpm: [5.0e+5, 1.0e+6], axial_load_n: [3000, 5000]}
"""
_RAW = Path("data/raw/way")
_NAMES = "time_s,load_n,traction_force_n,ball_speed_rpm,disc_speed_rpm,inlet_temperature_c"
# Loads that give these pressures (GPa) in the contact of the rig.
_LOAD_N = {1.0: 42.1, 1.5: 142.1}
# What a table or an export says of its origin; nobody reads it here.
_PROVENANCE = {
    "campaign": "way",
    "data": "simulated",
    "rule": "",
    "code": "",
    "settings": "",
    "inputs": {},
}


@dataclass
class Step:
    """A step of a way.

    Attributes:
        text: What is done.
        script: The file of the workflow that does it.
        files: Files of the library, in the order in which they are first entered.
    """

    text: str
    script: str
    files: list[str] = field(default_factory=list)

    def enter(self, file: str) -> None:
        """Add a module, if it is one of the library and not yet among the files."""
        is_module = file.startswith(_LIBRARY) and file.endswith(".py")  # and no template
        if is_module and file not in self.files:
            self.files.append(file)

    def plain(self) -> dict[str, Any]:
        """The step for JSON; paths of files are relative to the project."""
        files = [Path(file).relative_to(HOME).as_posix() for file in self.files]
        return {"text": self.text, "script": self.script, "files": files}


@contextmanager
def traced(step: Step) -> Iterator[None]:
    """Add every file to the step in which a function is called."""

    def enter(frame: FrameType, event: str, _: object) -> None:
        code = frame.f_code
        # when pydantic builds a model is its own affair
        if event == "call" and not code.co_name.startswith("__get_pydantic"):
            step.enter(code.co_filename)

    sys.setprofile(enter)
    try:
        yield
    finally:
        sys.setprofile(None)


def begin_where_read(step: Step, section: Any, key: str) -> None:
    """Let a step begin where a key is first read: files that are entered before it are left out.

    Args:
        step: The step, which is traced later.
        section: The section of the settings that has the key.
        key: The key.
    """
    was_read = False

    class Watched(type(section)):  # type: ignore[misc]
        def __getattribute__(self, name: str) -> Any:
            nonlocal was_read
            if name == key and not was_read:
                was_read = True
                step.files.clear()
                step.enter(sys._getframe(1).f_code.co_filename)
            return super().__getattribute__(name)

    object.__setattr__(section, "__class__", Watched)


def settings_of_campaign() -> Settings:
    """The settings, read anew: a key is watched in one way only."""
    return resolve(Path("config"), {"campaign": "way"})


def way_of_limit() -> list[Step]:
    """The limit of lambda, from `config/config.yaml` to the verdict that `oilfilm check` prints."""
    read = Step("The YAML files of a campaign become settings.", "workflow/rules/common.smk")
    with traced(read):
        settings = settings_of_campaign()
    passed_on = Step("The rule passes the section to its script.", "workflow/rules/points.smk")
    with traced(passed_on):
        Settings.from_plain_values(settings.plain_part("gates"))
    judged = Step(
        "The limit is read, and each plateau gets its verdict.", "workflow/scripts/points.py"
    )
    log = _RAW / "0.csv"
    logs = [(str(log), log.read_bytes())]
    ingested = ingest_logs(logs, settings)
    begin_where_read(judged, settings.gates, "lambda_limit")
    with traced(judged):
        curate_ingested(ingested, TractionRig(settings))
    shown = Step("`oilfilm check` prints the verdicts.", "workflow/oilfilm/api/log_check.py")
    checked = reports_on_logs({str(log): log.read_bytes}, settings_of_campaign(), _RAW.parent)
    with traced(shown):
        reports_text(checked)
    return [read, passed_on, judged, shown]


def way_of_row() -> tuple[list[Step], CampaignTables]:
    """A row of a log, from the file to the constants of a law; and the tables at the end."""
    settings = settings_of_campaign()
    paths = {path.name: path for path in sorted(_RAW.iterdir())}
    digests = {name: file_digest(path) for name, path in paths.items()}
    logs = RawLogs(_RAW, paths, digests, True, {})
    points = Step(
        "The row becomes a sample. The samples become points, each with a verdict.",
        "workflow/scripts/points.py",
    )
    with traced(points):
        share = curate_share(logs, settings, NO_SHEET, {_OIL: Path("samples")}, _PROVENANCE)
    collected = Step("The runs are compared with each other.", "workflow/scripts/collect.py")
    with traced(collected):
        campaign = collect(share, settings)
    fitted = Step("A law is fitted to the points of an oil.", "workflow/scripts/fit.py")
    with traced(fitted):
        fit = fit_law(campaign.points, _OIL, _LAW, settings)
    judged = Step("The fit is judged.", "workflow/scripts/fits.py")
    tables = fit.replace(points=campaign.points, runs=campaign.runs)
    with traced(judged):
        finished = finished_fit_tables(tables, settings)
    return [points, collected, fitted, judged], tables.replace(**finished)


def way_of_law_name(of_row: list[Step], tables: CampaignTables) -> list[Step]:
    """The name of a law, from its declaration to an export.

    Args:
        of_row: The steps of the way of a row.
        tables: The tables at its end.
    """
    declared = Step("The law is declared.", f"workflow/oilfilm/traction/laws/{_LAW}.py")
    # the file of the law, its folder, its room
    for module in sorted(_modules_with(LAWS[_LAW]), key=lambda name: -name.count(".")):
        declared.enter(str(sys.modules[module].__file__))
    fits = [step for step in of_row if step.script.startswith("workflow/scripts/fit")]
    predicted = Step("The fit gives a traction coefficient.", "workflow/oilfilm/fits/fitted.py")
    with traced(predicted):
        FittedLaw.from_results(tables, _OIL).predict_at(1.2, 30.0, 60.0, 0.05)
    exported = Step("The law is written in other languages.", "workflow/scripts/exports.py")
    settings = settings_of_campaign()
    with traced(exported):
        export_campaign(tables, settings, _PROVENANCE)
    return [declared, *fits, predicted, exported]


def _modules_with(law: object) -> list[str]:
    """Names of the modules of the room of laws that have the law, alone or in a dictionary."""
    names = []
    for name, module in sys.modules.items():
        if name.startswith("oilfilm.traction"):
            values = list(vars(module).values())
            for value in vars(module).values():
                if isinstance(value, dict):
                    values += value.values()
            if any(value is law for value in values):
                names.append(name)
    return names


def way_of_load(tables: CampaignTables) -> list[Step]:
    """The axial load of a bearing, from the settings to cage slip and torque."""
    settings = settings_of_campaign()
    script = "workflow/scripts/bearing_maps.py"
    prepared = Step("The fitted law is prepared for bearings.", script)
    with traced(prepared):
        oils = oils_in_bearings(tables.coefficients, tables.fit_quality, settings, tables.refits)
    solved = Step("The load is read. Motion, torque and their uncertainty follow.", script)
    begin_where_read(solved, settings.bearing.cage_slip, "axial_load_n")
    with traced(solved):
        cage_slip_table(oils, settings)
    return [prepared, solved]


def write_campaign() -> None:
    """Write the settings and eight logs into the working folder."""
    for folder in ("config/campaigns", str(_RAW)):
        Path(folder).mkdir(parents=True)
    Path("config/config.yaml").write_text("campaign: way\n", encoding="utf-8")
    Path("config/campaigns/way.yaml").write_text(_CAMPAIGN, encoding="utf-8")
    conditions = product(_LOAD_N, (25.0, 40.0), (40.0, 70.0))
    for number, (pressure, speed, temperature) in enumerate(conditions):
        text = _log(pressure, speed, temperature, number)
        Path(_RAW, f"{number}.csv").write_text(text, encoding="utf-8")


def _log(pressure_gpa: float, speed_m_s: float, temperature_c: float, seed: int) -> str:
    """The text of a log: rolling, nine levels of slip, rolling."""
    random = np.random.default_rng(seed)
    slip = np.repeat([0.0, *np.linspace(0.0, 0.3, 9), 0.0], 160)  # 3.2 s each
    load = _LOAD_N[pressure_gpa]
    height = 0.04 * pressure_gpa**0.5 * (25 / speed_m_s) ** 0.3 * (40 / temperature_c) ** 0.2
    signals = {
        "load": (load, 0.1),
        "force": (load * height * np.tanh(slip / 0.03) + 0.05, 0.004),
        "ball": (speed_m_s * (1 - slip / 2) / 0.010 * 30 / np.pi, 3.0),
        "disc": (speed_m_s * (1 + slip / 2) / 0.040 * 30 / np.pi, 1.0),
        "temperature": (temperature_c, 0.1),
    }
    columns = [mean + random.normal(0, noise, len(slip)) for mean, noise in signals.values()]
    rows = np.column_stack([np.arange(len(slip)) / 50, *columns])
    table = pd.DataFrame(rows, columns=_NAMES.split(",")).round(4)
    return f"# oil: {_OIL}\n" + table.to_csv(index=False, lineterminator="\n")


def ways() -> dict[str, list[Step]]:
    """The four ways by name. The working folder must be empty."""
    # files that are imported late are seen by their calls, as the others
    for module in pkgutil.walk_packages(oilfilm.__path__, "oilfilm."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    write_campaign()
    limit = way_of_limit()  # first, because reading settings fills caches
    row, tables = way_of_row()
    return {
        "row": row,
        "limit": limit,
        "law": way_of_law_name(row, tables),
        "load": way_of_load(tables),
    }


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        steps_by_way = ways()
        os.chdir(HOME)
    print(
        json.dumps({way: [step.plain() for step in steps] for way, steps in steps_by_way.items()})
    )
