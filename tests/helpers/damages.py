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
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.torque_rig import TorqueRig
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.settings.resolved import Settings

Columns = dict[str, np.ndarray]


@dataclass(frozen=True)
class SoundLog:
    """A log that every gate accepts, with the names of its columns by their role."""

    kind: type[RigKind]
    config: Settings
    values: Columns
    units: Mapping[str, str]
    keys: Mapping[str, Any]
    sensor: str
    load: str
    temperature: str
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


SOUND = {
    "traction": SoundLog(
        TractionRig,
        bad_logs.CONFIG,
        bad_logs.good(),
        bad_logs.UNITS,
        bad_logs.KEYS,
        "traction_force",
        "load",
        "inlet_temperature",
        rest=80,
        held=slice(160, 240),
    ),
    "torque": SoundLog(
        TorqueRig,
        bad_logs.CONFIG,
        torque_logs.by_quantity(torque_logs.signals()),
        torque_logs.UNITS,
        {"oil": "4050"},
        "torque",
        "axial_load",
        "oil_temperature",
        rest=120,
        held=slice(280, 440),
    ),
}


def in_rows(
    log: SoundLog, name: str, rows: slice, change: Callable[[np.ndarray], np.ndarray | float]
) -> bytes:
    """One column changed in some rows."""

    def changed(column: np.ndarray) -> np.ndarray:
        column[rows] = change(column[rows])
        return column

    return log.column(name, changed)


def clock_set(log: SoundLog, by_s: float) -> bytes:
    """The clock is set by some seconds within the held level."""
    return in_rows(log, "time", slice(log.held.start + 9, None), lambda time: time + by_s)


def in_held_level(log: SoundLog, name: str, factor: Callable[[np.ndarray], np.ndarray]) -> bytes:
    """One column times a factor that depends on the position within one level, from 0 to 1."""
    return in_rows(log, name, log.held, lambda held: held * factor(np.linspace(0, 1, len(held))))


def stuck(log: SoundLog) -> bytes:
    """The sensor keeps its reading through the held level."""
    return in_rows(log, log.sensor, log.held, lambda held: held[0])


def stops_moving(log: SoundLog, name: str) -> bytes:
    """A signal repeats one reading from the middle of the run on."""
    half = slice(len(log.values["time"]) // 2, None)
    return in_rows(log, name, half, lambda rest: rest[0])


def without_readings(log: SoundLog) -> bytes:
    """The sensor gives no numbers for most of a level."""
    return in_rows(log, log.sensor, log.held, lambda held: np.nan)


def held_for_1_5_s(log: SoundLog) -> bytes:
    rows = np.arange(len(log.values["time"]))
    return log.rows((rows < log.held.start + 30) | (rows >= log.held.stop))


def without_ends(log: SoundLog, start: int, stop: int) -> bytes:
    """Without so many rows at the start and at the end."""
    rows = np.arange(len(log.values["time"]))
    return log.rows((rows >= start) & (rows < len(rows) - stop))


def saturated(log: SoundLog, name: str) -> bytes:
    """A tenth of the readings are cut off at the end of the range."""
    return log.column(name, lambda column: np.minimum(column, np.quantile(column, 0.9)))


def often_wild(log: SoundLog) -> bytes:
    """15 % of the readings times 30: three of every twenty."""
    wild = np.arange(len(log.values["time"])) % 20 < 3
    return log.column(log.sensor, lambda column: np.where(wild, 30 * column, column))


def drifting(log: SoundLog, name: str, total: float) -> bytes:
    return log.column(name, lambda column: column + np.linspace(0, total, len(column)))


@dataclass(frozen=True)
class Damage:
    """A damage and what must come of it.

    Attributes:
        logs: The damaged log or logs.
        rules: Rule by rig; one for both where they share it.
        sentence: A part of the sentence of the rule, where the rule refuses the run.
        spares: Whether the other levels of the run are accepted all the same.
    """

    name: str
    logs: Callable[[SoundLog], bytes | list[bytes]]
    rules: str | Mapping[str, str]
    sentence: str = ""
    spares: bool = False

    def rule(self, rig: str) -> str:
        return self.rules if isinstance(self.rules, str) else self.rules[rig]


NO_OPENING, NO_CLOSING = ("zero_missing", "opening phase"), ("zero_missing", "closing phase")

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
        lambda log: clock_set(log, 3600),
        "clock_jump",
        "3600.05 s pass between row",
    ),
    Damage(
        "clock_set_back",
        lambda log: clock_set(log, -1),
        "time_disorder",
        "the time stamp does not increase at 1 rows",
    ),
    Damage("clock_stands_still", lambda log: log.column("time", np.ones_like), "time_disorder"),
    # --- the sensor
    Damage("stuck_sensor", stuck, "stuck_sensor", "is exactly"),
    Damage("saturated_sensor", lambda log: saturated(log, log.sensor), "saturated", "at its"),
    Damage("saturated_load_cell", lambda log: saturated(log, log.load), "saturated", "load is at"),
    Damage(
        "cable_the_wrong_way_round",  # the zero turns too
        lambda log: log.column(log.sensor, np.negative),
        {"traction": "swapped_sign", "torque": "torque_not_positive"},
    ),
    Damage("often_wild_readings", often_wild, "spiky", "readings of a plateau are spikes"),
    Damage(
        "drift_within_a_level",
        lambda log: in_held_level(log, log.sensor, lambda position: 0.7 + 0.6 * position),
        {"traction": "not_steady", "torque": "torque_drifts"},
        spares=True,
    ),
    # --- the other signals
    Damage("stuck_load_cell", lambda log: stops_moving(log, log.load), "stuck_channel", "load is"),
    Damage("stuck_thermocouple", lambda log: stops_moving(log, log.temperature), "stuck_channel"),
    Damage("hole_in_the_readings", without_readings, "missing_readings", "no row from"),
    # --- the zero
    Damage("no_rest_at_the_start", lambda log: without_ends(log, log.rest, 0), *NO_OPENING),
    Damage("short_rest_at_the_start", lambda log: without_ends(log, log.rest - 12, 0), *NO_OPENING),
    Damage("no_rest_at_the_end", lambda log: without_ends(log, 0, log.rest), *NO_CLOSING),
    Damage("zero_drifts", lambda log: drifting(log, log.sensor, 0.5), "zero_drift", "moves by 0."),
    Damage(
        "rest_all_the_time",
        lambda log: log.rows(np.arange(len(log.values["time"])) < log.rest),
        {"traction": "zero_missing", "torque": "never_turns"},
    ),
    # --- load, temperature, steps
    Damage(
        "load_rises_by_half_within_a_level",
        lambda log: in_held_level(log, log.load, lambda position: 1 + 0.5 * position),
        "load_changes",
        spares=True,
    ),
    Damage(
        "no_load",
        lambda log: log.column(log.load, np.negative),
        {"traction": "traction_missing", "torque": "unloaded"},
    ),
    Damage(
        "warming_up",
        lambda log: drifting(log, log.temperature, log.values["time"][-1]),
        {"traction": "temperature_drift", "torque": "temperature_changes"},
    ),
    Damage(
        "temperature_jumps_within_a_level",
        lambda log: in_held_level(log, log.temperature, lambda position: 1 + (position > 0.6) / 50),
        "temperature_changes",
        spares=True,
    ),
    Damage("level_held_too_briefly", held_for_1_5_s, "too_short", spares=True),
)
