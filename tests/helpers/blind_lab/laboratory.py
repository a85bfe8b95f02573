"""A laboratory's project folder: configuration, sound logs, and one log with each fault."""

import json
import shutil
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np
import yaml

from blind_lab.bench import Bench, Condition, draw_bench
from blind_lab.defects import FAULTS, Draft, faulty
from blind_lab.dialects import HEADER, NAMES, Dialect, draw_dialect, suffix
from blind_lab.truth import Oil, draw_machine, draw_oil

CAMPAIGN, RIG = "blind", "our-rig"
_HEAT = {"specific_heat_j_kgk": 2000.0, "thermal_conductivity_w_mk": 0.15}
# Names of each oil: in the laboratory's own script, and in one that every encoding can write.
_OILS = (("Turbo 5 alt",), ("Öl B-12", "Oil B-12"), ("合成油 3", "Synthetic 3"))
_SETTING_KEYS = "oil max_hertz_pressure_gpa entrainment_speed_m_s inlet_temperature_c".split()
_COLUMNS = "time load traction_force ball_speed disc_speed inlet_temperature".split()
_QUANTITIES = dict(zip("time load force ball disc celsius".split(), _COLUMNS, strict=True))


@dataclass(frozen=True)
class FiledLog:
    """A log in the folder.

    Attributes:
        file: Name of the file.
        oil: Key of the oil.
        fault: The fault; empty where the log is sound.
        rules: Rules of which one must name the fault.
        rows: Number of rows of a sound log.
    """

    file: str
    oil: str
    fault: str = ""
    rules: tuple[str, ...] = ()
    rows: int = 0


@dataclass(frozen=True)
class Laboratory:
    """What was built, and what is true.

    Attributes:
        oils: The true oils, by key.
        bench: The rig.
        logs: All logs in the folder.
    """

    oils: dict[str, Oil]
    bench: Bench
    logs: tuple[FiledLog, ...]

    @property
    def sound(self) -> list[FiledLog]:
        """Logs that nothing is wrong with."""
        return [log for log in self.logs if not log.fault]

    @property
    def faulty(self) -> list[FiledLog]:
        """Logs that something is wrong with."""
        return [log for log in self.logs if log.fault]


def build(
    project: Path, config: Path, seed: int, faults: bool = True, levels: int = 3
) -> Laboratory:
    """Write a campaign `blind` into a project folder.

    Args:
        project: Folder to write into.
        config: The configuration folder whose thresholds are used.
        seed: Every choice follows from it.
        faults: Also file the logs with faults.
        levels: Number of levels of pressure, of speed and of temperature.
    """
    random = np.random.default_rng(seed)
    bench = draw_bench(random, draw_machine(random))
    oils = {f"oil-{index}": draw_oil(random, names) for index, names in enumerate(_OILS, start=1)}
    _write_config(project, config, bench, oils)
    raw = project / "data" / "raw" / CAMPAIGN
    raw.mkdir(parents=True)
    logs: list[FiledLog] = []

    def file(content: bytes, dialect: Dialect, name: str, about: FiledLog) -> None:
        path = raw / f"{name}{suffix(dialect)}"
        path.write_bytes(content)
        logs.append(replace(about, file=path.name))

    levels_of_conditions = _levels(random)
    used_levels = [all_levels[:levels] for all_levels in levels_of_conditions]
    for name, oil in oils.items():
        for number, condition in enumerate(product(*used_levels)):
            dialect = draw_dialect(random)
            sound = Draft.sound(bench.run(oil, Condition(*condition), random), dialect, bench)
            about = FiledLog("", name, rows=len(sound.recording))
            file(sound.bytes(), dialect, f"{name}_{number:03}", about)
    for number, (kind, fault) in enumerate(FAULTS.items() if faults else ()):
        name = str(random.choice(list(oils)))
        dialect = replace(draw_dialect(random), packed=False)
        # a condition of its own, so that no other run of the campaign takes its place
        content = faulty(
            fault, oils[name], _between(levels_of_conditions, random), bench, dialect, random
        )
        about = FiledLog("", name, kind, (*fault.rules.split(),))
        file(content, dialect, f"fault_{number:03}", about)
    return Laboratory(oils, bench, tuple(logs))


def _levels(random: np.random.Generator) -> tuple[list[float], list[float], list[float]]:
    """Levels of pressure, speed and temperature."""
    pressure = np.round(random.uniform(0.9, 1.0) + np.array([0.0, 0.25, 0.5]), 2)
    speed = np.round(random.uniform(14, 18) * np.array([1.0, 1.5, 2.2]), 1)
    celsius = np.round(random.uniform(35, 45) + np.array([0.0, 25.0, 50.0]))
    return pressure.tolist(), speed.tolist(), celsius.tolist()


def _between(levels: tuple[list[float], ...], random: np.random.Generator) -> Condition:
    """A condition between the levels."""
    pressure, speed, celsius = (
        round(random.uniform(min(levels_of_one), max(levels_of_one)), 3) for levels_of_one in levels
    )
    return Condition(pressure, speed, celsius)


def _write_config(project: Path, config: Path, bench: Bench, oils: dict[str, Oil]) -> None:
    folder = project / "config"
    for name in ("campaigns", "rigs", "oils", "bearings"):
        (folder / name).mkdir(parents=True)
    shutil.copy(config / "config.yaml", folder)
    names = {
        quantity: {"name": [NAMES[language][name] for language in NAMES]}
        for name, quantity in _QUANTITIES.items()
    }
    header = {
        key: [HEADER[language][index] for language in HEADER]
        for index, key in enumerate(_SETTING_KEYS)
    }
    fixed = yaml.safe_load(Path(__file__).with_name("settings.yaml").read_text("utf-8"))
    campaign = {"rigs": [RIG], "oils": list(oils), "columns": names, "header": header}
    _write(folder / "campaigns" / f"{CAMPAIGN}.yaml", fixed["campaign"] | campaign)
    machine = bench.machine
    body = {"youngs_modulus_pa": machine.youngs_modulus, "poisson_ratio": machine.poisson}
    rig = {
        "ball_radius_m": machine.ball_radius,
        "ball_track_radius_m": machine.ball_track,
        "disc_track_radius_m": machine.disc_track,
        "ball": body,
        "disc": body,
        "ball_roughness_ra_um": machine.roughness * 1e6,
        "disc_roughness_ra_um": machine.roughness * 1e6,
    }
    _write(folder / "rigs" / f"{RIG}.yaml", fixed["rig"] | rig)
    for key, oil in oils.items():
        intercept, slope = oil.astm_d341
        constants = {"density_kg_m3": oil.density, **_HEAT}
        drawn = {
            "id": key,
            "name": f"turbine oil {oil.names[-1]}",
            "display_name": oil.names[-1],
            "aliases": list(oil.names),
            "nominal_kinematic_viscosity_100c_cst": oil.cst_100,
            "coefficients": {
                "viscosity_intercept": intercept,
                "viscosity_slope": slope,
                "pressure_viscosity_exponent": 1.15607,
                "pressure_viscosity_offset": 17.496,
            },
            # at 25 and at 150 degC
            **{name: [[298.15, value], [423.15, value]] for name, value in constants.items()},
        }
        _write(folder / "oils" / f"{key}.yaml", fixed["oil"] | drawn)


def _write(path: Path, values: dict) -> None:
    # JSON is YAML; NumPy's numbers as Python's
    path.write_text(json.dumps(values, default=np.generic.item), encoding="utf-8")
