"""The torque rig: a bearing of which one ring turns.

A log is one run of one oil at one axial load: the bearing stands still, runs at one speed after
another, and stands still again. A step is a step of speed, and rest is standstill.

Decides: how a torque log is curated.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pandas as pd

from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.curation.gate import refusal_by, sentence_named
from oilfilm.curation.hypotheses import Hypothesis, setting_hypotheses, time_hypotheses
from oilfilm.curation.measure import find_steps, settled_parts
from oilfilm.curation.rig_kind import TORQUE_KIND, Channel, Division, RigKind, Signals
from oilfilm.curation.statistics import median
from oilfilm.logs.base import ColumnArrays, Refusal
from oilfilm.logs.log_schema import LogSchema
from oilfilm.logs.torque_log import TORQUE
from oilfilm.settings.config import TorquePlateauSettings
from oilfilm.settings.resolved import Settings

_SIGNAL_COLUMNS = (
    "inner_speed_rpm",
    "axial_load_n",
    "oil_temperature_c",
    "outer_ring_temperature_c",
    "torque_n_m",
)
# Names of columns with a radial load: "radial_load_n", "Radial force [N]", "F_r (N)", "Fr".
_RADIAL_LOAD_NAME = re.compile(
    r"radial\W*_?(load|force)|(load|force)\W*_?radial|(^|[^a-z])F_?r([^a-z]|$)", re.IGNORECASE
)


class TorqueRig(RigKind):
    """See `RigKind`."""

    name = TORQUE_KIND
    log_schema: LogSchema = TORQUE
    table_name = "torque_runs"
    sensor = Channel("torque_n_m", "torque", "N m")
    channels = (
        Channel("axial_load_n", "axial load", "N"),
        Channel("inner_speed_rpm", "speed", "rpm"),
        Channel("oil_temperature_c", "oil temperature", "degC"),
    )
    mean_columns = _SIGNAL_COLUMNS
    columns_with_error: tuple[str, ...] = ("torque_n_m",)
    columns_with_change: tuple[str, ...] = ("torque_n_m", "oil_temperature_c", "axial_load_n")
    columns_with_transient: tuple[str, ...] = ()
    terms: Mapping[str, str] = {"sensor": sensor.name, "level": "speed"}
    run_columns: tuple[str, ...] = ("file", "oil", "rig", "sha256", "reader")
    keeps_refused_runs = False
    shown_signals: Mapping[str, str] = {
        "torque_n_m": "Torque (N m)",
        "axial_load_n": "Axial load\n(N)",
        "inner_speed_rpm": "Speed (rpm)",
        "oil_temperature_c": "Oil temp.\n(\N{DEGREE SIGN}C)",
    }

    plateau_settings: TorquePlateauSettings

    def __init__(self, settings: Settings) -> None:
        super().__init__(settings)
        self.gate_limits = settings.torque_logs.gates
        self.plateau_settings = settings.torque_logs.plateaus
        self.zero_settings = settings.torque_logs.tare
        self.zero_drift_max = settings.torque_logs.tare.max_drift_n_m

    @staticmethod
    def make_signals(samples: ColumnArrays, rig_name: str, settings: Settings) -> Signals:
        """See `RigKind.make_signals`."""
        columns = {name: samples[name] for name in _SIGNAL_COLUMNS}
        return Signals(samples["row"], samples["time_s"], columns)

    def divide_run(self, signals: Signals, rig_name: str) -> Division:
        """Levels of speed between the first and the last sample at which the bearing turns."""
        is_turning = np.abs(signals["inner_speed_rpm"]) > self.zero_settings.max_speed_rpm
        if not is_turning.any():
            no_levels = np.array([], dtype=np.int64)
            return Division(signals, no_levels, no_levels, phase_signals=signals, phases={})
        turning_indices = np.flatnonzero(is_turning)
        start = int(turning_indices[0])
        stop = int(turning_indices[-1]) + 1
        starts, stops, short_level_refusals = _levels(
            signals, start, stop, self.plateau_settings, self.zero_settings.max_speed_rpm
        )
        return Division(
            signals,
            starts,
            stops,
            phase_signals=signals,
            phases={"opening": slice(0, start), "closing": slice(stop, len(signals))},
            running_selection=is_turning,
            short_level_refusals=short_level_refusals,
        )

    def derive_plateaus(
        self, averages: ColumnArrays, zero_of_plateau: FloatArray, zero_of_plateau_se: FloatArray
    ) -> ColumnArrays:
        """Torque above the zero, and how steady it is."""
        load_n = averages["axial_load_n"]
        torque_n_m = averages["torque_n_m"] - zero_of_plateau
        load_size_n = np.where(load_n == 0, np.nan, np.abs(load_n))
        torque_size_n_m = np.where(torque_n_m == 0, np.nan, np.abs(torque_n_m))
        return {
            **averages,
            "tare_n_m": zero_of_plateau,
            "torque_n_m": torque_n_m,
            "torque_n_m_se": np.hypot(averages["torque_n_m_se"], zero_of_plateau_se),
            "torque_change_n_m": averages["torque_n_m_change"],
            "torque_change": averages["torque_n_m_change"] / torque_size_n_m,
            "oil_temperature_change_c": averages["oil_temperature_c_change"],
            "temperature_change_c": averages["oil_temperature_c_change"],
            "load_change": averages["axial_load_n_change"] / load_size_n,
        }

    def with_rig_and_oil_columns(self, points: pd.DataFrame) -> pd.DataFrame:
        """The column `rig` becomes `bearing`: the rig of a torque log is its bearing."""
        return points.rename(columns={"rig": "bearing"})

    def hypotheses(self, rig_name: str) -> Iterator[Hypothesis]:
        """See `RigKind.hypotheses`."""
        yield from time_hypotheses()
        yield from setting_hypotheses("torque_logs", self.plateau_settings, "min_step_rpm")


def _levels(
    signals: Signals,
    turning_start: int,
    turning_stop: int,
    plateau_settings: TorquePlateauSettings,
    standstill_rpm: float,
) -> tuple[IndexArray, IndexArray, list[Refusal]]:
    """Starts and stops of settled levels of speed, and the levels that were held too briefly.

    A stop between two levels is no level: static friction may hold any torque there.

    Args:
        signals: The run.
        turning_start: Index of the first sample at which the bearing turns.
        turning_stop: Index after the last such sample.
        plateau_settings: `plateaus` of config's torque_logs.
        standstill_rpm: Largest speed of a bearing that stands still.
    """
    speed_rpm = signals["inner_speed_rpm"][turning_start:turning_stop]
    interval_s = signals.interval_s
    steps = find_steps(speed_rpm, interval_s, plateau_settings.min_step_rpm, plateau_settings)
    starts, stops = settled_parts(len(speed_rpm), steps, interval_s, plateau_settings)
    # the first level begins with the step out of rest, and the last one ends in a step
    starts[0] += round(plateau_settings.settle_s / interval_s)
    stops[-1] -= round(plateau_settings.guard_s / interval_s)
    for level_index, (start, stop) in enumerate(zip(starts, stops, strict=True)):
        if stop > start:
            # a slow ramp goes on beyond the rows that are cut off
            is_near_median = _is_near_median(speed_rpm[start:stop], plateau_settings)
            starts[level_index] += np.argmax(is_near_median)
            stops[level_index] -= np.argmax(is_near_median[::-1])
    # a single row gives no standard error
    has_settled = stops - starts > 1
    short_level_refusals: list[Refusal] = []
    level_edges = pairwise([0, *steps, len(speed_rpm)])
    is_turning = np.ones(len(starts), dtype=bool)
    for level_index, (start, stop) in enumerate(level_edges):
        is_turning[level_index] = median(np.abs(speed_rpm[start:stop])) > standstill_rpm
        if has_settled[level_index] or not is_turning[level_index]:
            continue
        # on a ramp hardly any row is near the median one
        if _is_near_median(speed_rpm[start:stop], plateau_settings).mean() > 1 / 3:
            short_level_refusals.append(
                _refusal_of_short_level(
                    signals, turning_start + start, turning_start + stop, plateau_settings
                )
            )
    return (
        turning_start + starts[has_settled & is_turning],
        turning_start + stops[has_settled & is_turning],
        short_level_refusals,
    )


def _is_near_median(
    speed_rpm: FloatArray, plateau_settings: TorquePlateauSettings
) -> npt.NDArray[np.bool_]:
    """Mask of the samples at which a speed is within the smallest step of its median."""
    return np.asarray(np.abs(speed_rpm - median(speed_rpm)) <= plateau_settings.min_step_rpm)


def _refusal_of_short_level(
    signals: Signals, start: int, stop: int, plateau_settings: TorquePlateauSettings
) -> Refusal:
    """The refusal of a level that ended before it settled."""
    speed_rpm = median(signals["inner_speed_rpm"][start:stop])
    held_s = (stop - start) * signals.interval_s
    least_s = plateau_settings.settle_s + plateau_settings.guard_s + plateau_settings.min_duration_s
    row_range = signals.row_range(start, stop - 1)
    return refusal_by(
        "too_short", "brief_level", speed=speed_rpm, held=held_s, least=least_s, **row_range
    )


def radial_load_warnings(unread_names: Iterable[str]) -> list[str]:
    """Warnings about a radial load, which no calculation of the torque has.

    Args:
        unread_names: Names of the columns of a torque log that are not read.
    """
    radial_load_names = [name for name in unread_names if _RADIAL_LOAD_NAME.search(name)]
    return [sentence_named("radial_load", column=name) for name in radial_load_names]
