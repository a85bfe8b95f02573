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
from oilfilm.curation.gate import fault
from oilfilm.curation.hypotheses import Hypothesis, setting_hypotheses, time_hypotheses
from oilfilm.curation.measure import find_steps, settled_parts
from oilfilm.curation.rig_kind import TORQUE_KIND as NAME
from oilfilm.curation.rig_kind import Channel, Division, RigKind, Signals
from oilfilm.curation.statistics import median
from oilfilm.logs.base import Columns, Refusal
from oilfilm.logs.log_kind import LogKind
from oilfilm.logs.torque_log import TORQUE
from oilfilm.settings.config import TorquePlateauSettings
from oilfilm.settings.resolved import Settings

_SIGNALS = (
    "inner_speed_rpm",
    "axial_load_n",
    "oil_temperature_c",
    "outer_ring_temperature_c",
    "torque_n_m",
)
# Names of columns with a radial load: "radial_load_n", "Radial force [N]", "F_r (N)", "Fr".
_RADIAL_LOAD = re.compile(
    r"radial\W*_?(load|force)|(load|force)\W*_?radial|(^|[^a-z])F_?r([^a-z]|$)", re.IGNORECASE
)


class TorqueRig(RigKind):
    """See `RigKind`."""

    name = NAME
    logs: LogKind = TORQUE
    table = "torque_runs"
    sensor = Channel("torque_n_m", "torque", "N m")
    channels = (
        Channel("axial_load_n", "axial load", "N"),
        Channel("inner_speed_rpm", "speed", "rpm"),
        Channel("oil_temperature_c", "oil temperature", "degC"),
    )
    means = _SIGNALS
    errors: tuple[str, ...] = ("torque_n_m",)
    changes: tuple[str, ...] = ("torque_n_m", "oil_temperature_c", "axial_load_n")
    transients: tuple[str, ...] = ()
    terms: Mapping[str, str] = {"sensor": sensor.name, "level": "speed"}
    carried: tuple[str, ...] = ("oil", "rig", "sha256", "reader")
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
        self.gates = settings.torque_logs.gates
        self.plateau_settings = settings.torque_logs.plateaus
        self.zero_settings = settings.torque_logs.tare
        self.zero_drift_max = settings.torque_logs.tare.max_drift_n_m

    @staticmethod
    def signals(samples: Columns, rig_name: str, settings: Settings) -> Signals:
        """See `RigKind.signals`."""
        columns = {name: samples[name] for name in _SIGNALS}
        return Signals(samples["row"], samples["time_s"], columns)

    def divide(self, signals: Signals, rig_name: str) -> Division:
        """Levels of speed between the first and the last sample at which the bearing turns."""
        is_turning = np.abs(signals["inner_speed_rpm"]) > self.zero_settings.max_speed_rpm
        if not is_turning.any():
            no_levels = np.array([], dtype=np.int64)
            return Division(signals, no_levels, no_levels, at_rest=signals, phases={})
        turning_rows = np.flatnonzero(is_turning)
        start = int(turning_rows[0])
        stop = int(turning_rows[-1]) + 1
        starts, stops, too_short = _levels(signals, start, stop, self.plateau_settings)
        return Division(
            signals,
            starts,
            stops,
            at_rest=signals,
            phases={"opening": slice(0, start), "closing": slice(stop, len(signals))},
            working=is_turning,
            too_short=too_short,
        )

    def derive(self, averages: Columns, zero: FloatArray, zero_se: FloatArray) -> Columns:
        """Torque above the zero, and how steady it is."""
        load = averages["axial_load_n"]
        torque = averages["torque_n_m"] - zero
        load_size = np.where(load == 0, np.nan, np.abs(load))
        torque_size = np.where(torque == 0, np.nan, np.abs(torque))
        return {
            **averages,
            "tare_n_m": zero,
            "torque_n_m": torque,
            "torque_n_m_se": np.hypot(averages["torque_n_m_se"], zero_se),
            "torque_change_n_m": averages["torque_n_m_change"],
            "torque_change": averages["torque_n_m_change"] / torque_size,
            "oil_temperature_change_c": averages["oil_temperature_c_change"],
            "temperature_change_c": averages["oil_temperature_c_change"],
            "load_change": averages["axial_load_n_change"] / load_size,
        }

    def complete(self, points: pd.DataFrame) -> pd.DataFrame:
        """The column `rig` becomes `bearing`: the rig of a torque log is its bearing."""
        return points.rename(columns={"rig": "bearing"})

    def hypotheses(self, rig_name: str) -> Iterator[Hypothesis]:
        """See `RigKind.hypotheses`."""
        yield from time_hypotheses()
        yield from setting_hypotheses("torque_logs", self.plateau_settings, "min_step_rpm")


def _levels(
    signals: Signals, turning_start: int, turning_stop: int, settings: TorquePlateauSettings
) -> tuple[IndexArray, IndexArray, list[Refusal]]:
    """Starts and stops of settled levels of speed, and the levels that were held too briefly.

    Args:
        signals: The run.
        turning_start: Index of the first sample at which the bearing turns.
        turning_stop: Index after the last such sample.
        settings: `plateaus` of config's torque_logs.
    """
    speed = signals["inner_speed_rpm"][turning_start:turning_stop]
    interval_s = signals.interval_s
    steps = find_steps(speed, interval_s, settings.min_step_rpm, settings)
    starts, stops = settled_parts(len(speed), steps, interval_s, settings)
    # the first level begins with the step out of rest, and the last one ends in a step
    starts[0] += round(settings.settle_s / interval_s)
    stops[-1] -= round(settings.guard_s / interval_s)
    for level, (start, stop) in enumerate(zip(starts, stops, strict=True)):
        if stop > start:
            # a slow ramp goes on beyond the rows that are cut off
            near_median = _near_median(speed[start:stop], settings)
            starts[level] += np.argmax(near_median)
            stops[level] -= np.argmax(near_median[::-1])
    # a single row gives no standard error
    is_settled_level = stops - starts > 1
    too_short: list[Refusal] = []
    edges = pairwise([0, *steps, len(speed)])
    for (start, stop), is_settled in zip(edges, is_settled_level, strict=True):
        if is_settled or stop <= start:
            continue
        # on a ramp hardly any row is near the median one
        if _near_median(speed[start:stop], settings).mean() > 1 / 3:
            too_short.append(
                _refusal_of_short_level(
                    signals, turning_start + start, turning_start + stop, settings
                )
            )
    return (
        turning_start + starts[is_settled_level],
        turning_start + stops[is_settled_level],
        too_short,
    )


def _near_median(speed: FloatArray, settings: TorquePlateauSettings) -> npt.NDArray[np.bool_]:
    """Where a speed is within the smallest step of its median."""
    return np.asarray(np.abs(speed - median(speed)) <= settings.min_step_rpm)


def _refusal_of_short_level(
    signals: Signals, start: int, stop: int, settings: TorquePlateauSettings
) -> Refusal:
    """The refusal of a level that ended before it settled."""
    speed_rpm = median(signals["inner_speed_rpm"][start:stop])
    held_s = (stop - start) * signals.interval_s
    least_s = settings.settle_s + settings.guard_s + settings.min_duration_s
    rows = signals.rows(start, stop - 1)
    return fault("too_short", "brief_level", speed=speed_rpm, held=held_s, least=least_s, **rows)


def radial_load_warnings(unread: Iterable[str]) -> list[str]:
    """Warnings about a radial load, which no calculation of the torque has.

    Args:
        unread: Names of the columns of a torque log that are not read.
    """
    names = [name for name in unread if _RADIAL_LOAD.search(name)]
    return [fault("radial_load", column=name).reason for name in names]
