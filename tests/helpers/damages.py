"""Damages planted in a sound log of either rig, and the rule that must refuse each.

`DAMAGES` is the one list. A damage changes a sound log in the same way whatever the rig: it knows
the sensor, the load, the temperature and the rows of one held level by their roles.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

import bad_logs
import formats
import torque_logs
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.torque_rig import TorqueRig
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.settings.resolved import Settings

Columns = dict[str, np.ndarray]
Change = Callable[[np.ndarray], np.ndarray | float]


@dataclass(frozen=True)
class SoundLog:
    """A log that every gate accepts, with the names of its columns by their role.

    Attributes:
        kind: The kind of rig.
        config: Settings of the campaign.
        values: Its columns, by name.
        units: Units of the columns.
        keys: Header keys.
        sensor: Column of the traction force or of the torque.
        load: Column of the load.
        temperature: Column of the oil's temperature.
        rest: Number of rows of the opening phase at rest; the closing phase has as many.
        held: Rows of one level in the middle of the run.
    """

    kind: type[RigKind]
    config: Settings
    values: Columns
    units: Mapping[str, str]
    keys: Mapping[str, Any]
    sensor: str
    load: str
    temperature: str
    rest: int
    held: slice

    def written(self, name: str) -> bytes:
        """The log in one of the formats."""
        return formats.WRITERS[name](self.values, self.units, self.keys)

    def text(self, values: Columns | None = None, **keys: Any) -> bytes:
        """The log as CSV, with other columns or other header keys."""
        rounded = {name: np.round(column, 4) for name, column in (values or self.values).items()}
        return formats.csv(rounded, self.units, {**self.keys, **keys})

    def column(self, name: str, change: Change, rows: slice = slice(None)) -> bytes:
        """The log with one column changed in some rows."""
        values = self.values[name].copy()
        values[rows] = change(values[rows])
        return self.text({**self.values, name: values})

    @property
    def row_index(self) -> np.ndarray:
        """Index of each row."""
        return np.arange(len(self.values["time"]))

    def rows(self, kept: np.ndarray) -> bytes:
        """Only these rows, the clock running through."""
        values = {name: column[kept] for name, column in self.values.items()}
        return self.text({**values, "time": self.values["time"][: kept.sum()]})


_TRACTION = TractionRig, bad_logs.CONFIG, bad_logs.good(), bad_logs.UNITS, bad_logs.KEYS
_TORQUE_VALUES = torque_logs.by_quantity(torque_logs.signals())
_TORQUE = TorqueRig, bad_logs.CONFIG, _TORQUE_VALUES, torque_logs.UNITS, {"oil": "4050"}
# Names of the columns of sensor, load and temperature.
_FORCE = "traction_force", "load", "inlet_temperature"
_MOMENT = "torque", "axial_load", "oil_temperature"
SOUND = {
    "traction": SoundLog(*_TRACTION, *_FORCE, rest=80, held=slice(160, 240)),
    "torque": SoundLog(*_TORQUE, *_MOMENT, rest=120, held=slice(280, 440)),
}


def clock_set(log: SoundLog, by_s: float) -> bytes:
    """The clock is set by some seconds within the held level."""
    return log.column("time", lambda time: time + by_s, slice(log.held.start + 9, None))


def held_at(log: SoundLog, change: Change, name: str = "") -> bytes:
    """The sensor, or another column, changed within the held level."""
    return log.column(name or log.sensor, change, log.held)


def temperature_jump(log: SoundLog) -> bytes:
    """By 2 % within the held level."""
    start, stop = log.held.start, log.held.stop
    later = slice(start + 3 * (stop - start) // 5, stop)
    return log.column(log.temperature, lambda held: 1.02 * held, later)


def stops_moving(log: SoundLog, name: str) -> bytes:
    """A signal repeats one reading from the middle of the run on."""
    return log.column(name, lambda rest: rest[0], slice(len(log.row_index) // 2, None))


def without_ends(log: SoundLog, start: int, stop: int) -> bytes:
    """Without so many rows at the start and at the end."""
    return log.rows((log.row_index >= start) & (log.row_index < len(log.row_index) - stop))


def saturated(log: SoundLog, name: str) -> bytes:
    """A tenth of the readings are cut off at the end of the range."""
    return log.column(name, lambda column: np.minimum(column, np.quantile(column, 0.9)))


def often_wild(log: SoundLog) -> bytes:
    """15 % of the readings times 30: three of every twenty."""
    wild = log.row_index % 20 < 3
    return log.column(log.sensor, lambda column: np.where(wild, 30 * column, column))


def held_readings(log: SoundLog) -> bytes:
    """Each reading of the sensor is repeated for a third of a level."""
    rows = (log.held.stop - log.held.start) // 3
    return log.column(log.sensor, lambda column: column[log.row_index // rows * rows])


def turned_back(log: SoundLog) -> bytes:
    """Everything that turns does so in the other direction."""
    turned = {name: -column for name, column in log.values.items() if "speed" in name}
    return log.text({**log.values, **turned})


def drifting(log: SoundLog, name: str, total: float) -> bytes:
    """A column drifts by so much over the run."""
    return log.column(name, lambda column: column + np.linspace(0, total, len(column)))


class Damage(NamedTuple):
    """A damage and what must come of it.

    Attributes:
        logs: The damaged log or logs.
        rule: The rule that refuses it.
        of_torque: The rule of torque rigs, where it is another one.
        spares: Whether the other levels of the run are still accepted.
    """

    logs: Callable[[SoundLog], bytes | list[bytes]]
    rule: str
    of_torque: str = ""
    spares: bool = False

    def rule_of(self, rig: str) -> str:
        """The rule that refuses the log of a rig, `traction` or `torque`."""
        return (self.of_torque if rig == "torque" else "") or self.rule


DAMAGES = {
    # --- the file
    "truncated": Damage(lambda log: log.text()[:-30], "truncated"),
    "copied": Damage(lambda log: [log.text(), log.text()], "duplicate_log", spares=True),
    "no_rows": Damage(lambda log: log.rows(log.row_index < 0), "no_rows"),
    "unknown_oil": Damage(lambda log: log.text(oil="4120"), "unknown_oil"),
    "simulated_as_measured": Damage(lambda log: log.text(simulated="yes"), "simulated_log"),
    # --- the clock
    "clock_gap_of_an_hour": Damage(lambda log: clock_set(log, 3600), "clock_jump"),
    "clock_set_back": Damage(lambda log: clock_set(log, -1), "time_disorder"),
    "clock_stands_still": Damage(lambda log: log.column("time", np.ones_like), "time_disorder"),
    # --- the sensor
    "stuck_sensor": Damage(lambda log: held_at(log, lambda held: held[0]), "stuck_sensor"),
    "saturated_sensor": Damage(lambda log: saturated(log, log.sensor), "saturated"),
    "saturated_load_cell": Damage(lambda log: saturated(log, log.load), "saturated"),
    "cable_the_wrong_way_round": Damage(  # the zero turns too
        lambda log: log.column(log.sensor, np.negative), "swapped_sign", "torque_not_positive"
    ),
    "often_wild_readings": Damage(often_wild, "spiky"),
    "drift_within_a_level": Damage(
        lambda log: held_at(log, lambda held: held * np.linspace(0.7, 1.3, len(held))),
        *("not_steady", "torque_drifts", True),
    ),
    "sensor_read_three_times_a_level": Damage(held_readings, "held_readings"),
    # --- the other signals
    "turned_the_wrong_way": Damage(turned_back, "speed_off_nominal", "turns_backwards"),
    "stuck_load_cell": Damage(lambda log: stops_moving(log, log.load), "stuck_channel"),
    "stuck_thermocouple": Damage(lambda log: stops_moving(log, log.temperature), "stuck_channel"),
    "hole_in_the_readings": Damage(
        lambda log: held_at(log, lambda held: np.nan), "missing_readings"
    ),
    # --- the zero
    "no_rest_at_the_start": Damage(lambda log: without_ends(log, log.rest, 0), "zero_missing"),
    "short_rest_at_the_start": Damage(
        lambda log: without_ends(log, log.rest - 12, 0), "zero_missing"
    ),
    "no_rest_at_the_end": Damage(lambda log: without_ends(log, 0, log.rest), "zero_missing"),
    "zero_drifts": Damage(lambda log: drifting(log, log.sensor, 0.5), "zero_drift"),
    "rest_all_the_time": Damage(
        lambda log: log.rows(log.row_index < log.rest), "zero_missing", "never_turns"
    ),
    # --- load, temperature, steps
    "load_rises_by_half_within_a_level": Damage(
        lambda log: held_at(log, lambda held: held * np.linspace(1, 1.5, len(held)), log.load),
        "load_changes",
        spares=True,
    ),
    "no_load": Damage(
        lambda log: log.column(log.load, np.negative), "traction_missing", "unloaded"
    ),
    "warming_up": Damage(
        lambda log: drifting(log, log.temperature, log.values["time"][-1]),
        *("temperature_drift", "temperature_changes"),
    ),
    "temperature_jumps_within_a_level": Damage(
        temperature_jump, "temperature_changes", spares=True
    ),
    "level_held_for_1_5_s": Damage(
        lambda log: log.rows(
            (log.row_index < log.held.start + 30) | (log.row_index >= log.held.stop)
        ),
        "too_short",
        spares=True,
    ),
}

# Slips that are planned, and one plateau of a traction rig that every gate then accepts. A plateau
# of the other direction of slip has a positive slip.
PLANNED_SLIPS = [-0.05, 0.15, 0.32]
GOOD_POINT = {
    **dict.fromkeys(("slip_change", "traction_change", "slip_transient"), 0.0),
    **dict.fromkeys(("traction_transient", "load_change", "temperature_change_c"), 0.0),
    **dict.fromkeys(("load_n", "nominal_load_n"), 82.2),
    **dict.fromkeys(("entrainment_speed_m_s", "nominal_entrainment_speed_m_s"), 30.0),
    **dict.fromkeys(("inlet_temperature_c", "nominal_inlet_temperature_c"), 70.0),
    **dict.fromkeys(("measured_film_thickness_um", "force_asymmetry"), np.nan),
    **{"run_id": "run", "direction": 1.0, "n_samples": 50, "n_spikes": 0, "duration_s": 1.2},
    **{"slide_roll_ratio": 0.15, "traction_coefficient": 0.02, "traction_force_n": 1.6},
    **{"film_judgement": "full film", "lambda_ratio": 5.0},
}
# What is changed of that plateau, and the gate that then refuses it; None where none does.
AT_A_LIMIT = [
    ({}, None),
    ({"load_n": 82.2 * 1.029}, None),
    ({"load_n": 82.2 * 1.031}, "load_off_nominal"),
    ({"entrainment_speed_m_s": 30.7}, "speed_off_nominal"),
    ({"entrainment_speed_m_s": 30.5}, None),
    ({"inlet_temperature_c": 72.1}, "temperature_off_nominal"),
    ({"inlet_temperature_c": 71.9}, None),
    ({"nominal_load_n": np.nan, "load_n": 1.0}, None),
    ({"slide_roll_ratio": 0.32}, "slip_out_of_range"),
    ({"slide_roll_ratio": 0.1531}, "slip_off_set_point"),
    ({"slide_roll_ratio": 0.1529}, None),
    ({"traction_coefficient": 0.16}, "traction_unphysical"),
    ({"traction_coefficient": -0.003}, "traction_unphysical"),
    ({"traction_coefficient": np.nan}, "traction_missing"),
    ({"slip_change": -0.0031}, "not_steady"),
    ({"traction_change": 0.0016}, "not_steady"),
    ({"slip_transient": 0.0031}, "transient_not_ended"),
    ({"traction_transient": -0.0016}, "transient_not_ended"),
    ({"load_change": -0.031}, "load_changes"),
    ({"load_change": 0.029}, None),
    ({"temperature_change_c": 1.1}, "temperature_changes"),
    ({"duration_s": 0.98}, "too_short"),
    ({"duration_s": np.nan}, None),
    ({"n_spikes": 2}, None),
    ({"n_spikes": 3}, "spiky"),
    ({"n_spikes": 1, "n_samples": 15}, None),
    ({"force_asymmetry": 0.26}, "force_not_reversed"),
    ({"force_asymmetry": 0.24}, None),
    ({"force_asymmetry": 0.9, "slide_roll_ratio": 0.05}, None),
    ({"film_judgement": "below limit", "lambda_ratio": 2.9}, "thin_film"),
    ({"film_judgement": "cannot be judged"}, "film_not_judged"),
]
