"""Damages planted in a sound log of either rig, and the rule that must refuse each.

`DAMAGES` is the one list. A damage changes a sound log in the same way whatever the rig: it knows
the sensor, the load, the temperature and the rows of one held level by their roles.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

import bad_logs
import formats
import torque_logs
from campaigns import ROOT
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.torque_rig import TORQUE_RIG
from oilfilm.curation.traction_rig import TRACTION_RIG
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings

Columns = dict[str, np.ndarray]


@dataclass(frozen=True)
class SoundLog:
    """A log that every gate accepts, with the names of its columns by their role."""

    kind: RigKind
    config: Settings
    values: Columns
    units: Mapping[str, str]
    keys: Mapping[str, Any]
    sensor: str
    load: str
    temperature: str
    level: str
    rest: int  # rows of the opening phase at rest, and of the closing one
    held: slice  # rows of one level in the middle of the run

    def written(self, name: str) -> bytes:
        """The log in one of the formats."""
        return formats.WRITERS[name](self.values, self.units, self.keys)

    def text(self, values: Columns | None = None, **keys: Any) -> bytes:
        rounded = {name: np.round(column, 4) for name, column in (values or self.values).items()}
        return formats.csv(rounded, self.units, {**self.keys, **keys})

    def column(self, name: str, change: Callable[[np.ndarray], np.ndarray]) -> bytes:
        return self.text({**self.values, name: change(self.values[name].copy())})

    def rows(self, kept: np.ndarray) -> bytes:
        """Only these rows, the clock running through."""
        values = {name: column[kept] for name, column in self.values.items()}
        return self.text({**values, "time": self.values["time"][: kept.sum()]})


def sound_logs() -> dict[str, SoundLog]:
    traction = SoundLog(
        TRACTION_RIG,
        bad_logs.CONFIG,
        bad_logs.good(),
        bad_logs.UNITS,
        bad_logs.KEYS,
        "traction_force",
        "load",
        "inlet_temperature",
        "slide_roll_ratio",
        rest=80,
        held=slice(160, 240),
    )
    torque = SoundLog(
        TORQUE_RIG,
        resolve(ROOT / "config", {"campaign": "demo"}),
        torque_logs.by_quantity(torque_logs.signals()),
        torque_logs.UNITS,
        {"oil": "4050"},
        "torque",
        "axial_load",
        "oil_temperature",
        "inner_speed",
        rest=120,
        held=slice(280, 440),
    )
    return {"traction": traction, "torque": torque}


SOUND = sound_logs()


def later(start: int, by_s: float) -> Callable[[np.ndarray], np.ndarray]:
    """The clock is set by some seconds from a row on."""
    return lambda time: time + np.where(np.arange(len(time)) >= start, by_s, 0.0)


def in_held_level(log: SoundLog, name: str, factor: Callable[[np.ndarray], np.ndarray]) -> bytes:
    """One column times a factor that depends on the place within one level, from 0 to 1."""

    def change(column: np.ndarray) -> np.ndarray:
        column[log.held] *= factor(np.linspace(0, 1, len(column[log.held])))
        return column

    return log.column(name, change)


def wild(column: np.ndarray) -> np.ndarray:
    """15 % of the readings times 30: three of every twenty."""
    return np.where(np.arange(len(column)) % 20 < 3, 30 * column, column)


def drifting(total: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda column: column + np.linspace(0, total, len(column))


def shortened(log: SoundLog) -> bytes:
    """The level is held for 1.5 s."""
    kept = np.ones(len(log.values["time"]), dtype=bool)
    kept[log.held.start + 30 : log.held.stop] = False
    return log.rows(kept)


def between(log: SoundLog, start: int, stop: int) -> bytes:
    rows = np.arange(len(log.values["time"]))
    return log.rows((rows >= start) & (rows < len(rows) - stop))


def stuck(log: SoundLog) -> bytes:
    """The sensor keeps its reading through the held level."""

    def change(column: np.ndarray) -> np.ndarray:
        column[log.held] = column[log.held.start]
        return column

    return log.column(log.sensor, change)


def saturated(name: Callable[[SoundLog], str]) -> Callable[[SoundLog], bytes]:
    def plant(log: SoundLog) -> bytes:
        top = np.quantile(log.values[name(log)], 0.9)
        return log.column(name(log), lambda column: np.minimum(column, top))

    return plant


def reversed_sensor(log: SoundLog) -> bytes:
    """The cable is plugged in the wrong way round; the zero turns too."""
    return log.column(log.sensor, np.negative)


def warming(log: SoundLog) -> bytes:
    seconds = log.values["time"]
    return log.column(log.temperature, lambda column: column + 1.0 * seconds)


@dataclass(frozen=True)
class Damage:
    """A damage, the rule that must refuse it on each rig, words of the sentence, what it spares.

    Attributes:
        logs: The damaged log or logs.
        rules: Rule by rig; one for both where they share it.
        words: What the sentence of the rule must hold, where the rule refuses the run.
        spares: Whether the other levels of the run are accepted all the same.
    """

    name: str
    logs: Callable[[SoundLog], bytes | list[bytes]]
    rules: str | Mapping[str, str]
    words: str = ""
    spares: bool = False

    def rule(self, rig: str) -> str:
        return self.rules if isinstance(self.rules, str) else self.rules[rig]


DAMAGES = (
    # --- the file
    Damage("truncated", lambda log: log.text()[:-30], "truncated", "in the middle of row"),
    Damage("copied", lambda log: [log.text(), log.text()], "duplicate_log", "which is kept", True),
    Damage("no_rows", lambda log: log.rows(log.values["time"] < 0), "no_rows", "no readable row"),
    Damage("unknown_oil", lambda log: log.text(oil="4120"), "unknown_oil", "'4120'"),
    Damage("simulated_as_measured", lambda log: log.text(simulated="yes"), "simulated_log"),
    # --- the clock
    Damage(
        "clock_gap_of_an_hour",
        lambda log: log.column("time", later(log.held.start + 9, 3600)),
        "clock_jump",
        "3600.05 s pass between row",
    ),
    Damage(
        "clock_set_back",
        lambda log: log.column("time", later(log.held.start + 9, -1)),
        "time_disorder",
        "the time stamp does not increase at 1 rows",
    ),
    Damage(
        "clock_stands_still",
        lambda log: log.column("time", np.ones_like),
        "time_disorder",
        "does not increase",
    ),
    # --- the sensor
    Damage("stuck_sensor", stuck, "stuck_sensor", "is exactly"),
    Damage("saturated_sensor", saturated(lambda log: log.sensor), "saturated", "at its extreme"),
    Damage("saturated_load_cell", saturated(lambda log: log.load), "saturated", "load is at its"),
    Damage(
        "swapped_sign",
        reversed_sensor,
        {"traction": "swapped_sign", "torque": "torque_not_positive"},
    ),
    Damage(
        "15_percent_of_the_readings_times_30",
        lambda log: log.column(log.sensor, wild),
        "spiky",
        "readings of a plateau are spikes",
    ),
    Damage(
        "drift_within_a_level",
        lambda log: in_held_level(log, log.sensor, lambda place: 0.7 + 0.6 * place),
        {"traction": "not_steady", "torque": "torque_drifts"},
        spares=True,
    ),
    # --- the zero
    Damage(
        "no_rest_at_the_start",
        lambda log: between(log, log.rest, 0),
        "zero_missing",
        "opening phase",
    ),
    Damage(
        "short_rest_at_the_start",
        lambda log: between(log, log.rest - 12, 0),
        "zero_missing",
        "opening phase",
    ),
    Damage(
        "no_rest_at_the_end", lambda log: between(log, 0, log.rest), "zero_missing", "closing phase"
    ),
    Damage(
        "zero_drifts",
        lambda log: log.column(log.sensor, drifting(0.5)),
        "zero_drift",
        "moves by 0.",
    ),
    Damage(
        "rest_all_the_time",
        lambda log: log.rows(np.arange(len(log.values["time"])) < log.rest),
        {"traction": "zero_missing", "torque": "never_turns"},
    ),
    # --- load, temperature, steps
    Damage(
        "load_rises_by_half_within_a_level",
        lambda log: in_held_level(log, log.load, lambda place: 1 + 0.5 * place),
        "load_changes",
        spares=True,
    ),
    Damage(
        "no_load",
        lambda log: log.column(log.load, np.negative),
        {"traction": "traction_missing", "torque": "unloaded"},
    ),
    Damage(
        "warming_up", warming, {"traction": "temperature_drift", "torque": "temperature_changes"}
    ),
    Damage(
        "temperature_jumps_within_a_level",
        lambda log: in_held_level(log, log.temperature, lambda place: 1 + 0.02 * (place > 0.6)),
        "temperature_changes",
        spares=True,
    ),
    Damage("level_held_too_briefly", shortened, "too_short", spares=True),
)
