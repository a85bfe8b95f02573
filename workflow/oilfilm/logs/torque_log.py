"""Logs of a torque rig: what they hold, and the run that their columns make.

Decides: the signals of a torque log, and the names of its columns.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from oilfilm.errors import OilfilmError
from oilfilm.logs.base import LoggedRun, Refusal
from oilfilm.logs.header import simulation_problem, unknown
from oilfilm.logs.log_kind import Column, ContinuousLog, LogKind, Problems, Vocabulary
from oilfilm.settings.campaign import Campaign, Torque
from oilfilm.settings.resolved import Settings

# Column names that carry their unit, as the project writes them: every log must have them all.
_OWN_NAMES = {
    "time_s": ("time", "s"),
    "axial_load_n": ("axial_load", "N"),
    "inner_speed_rpm": ("inner_speed", "rpm"),
    "oil_temperature_c": ("oil_temperature", "degC"),
    "outer_ring_temperature_c": ("outer_ring_temperature", "degC"),
    "torque_n_m": ("torque", "N m"),
}


def _header_problems(
    keys: Mapping[str, str], columns: Sequence[Column], settings: Settings
) -> Problems:
    yield unknown("oil", keys, settings.oils)
    bearing = torque_of(settings.campaign).bearing
    if (named := keys.get("bearing", bearing)) != bearing:
        reason = f"the header says bearing {named[:60]!r}; the campaign's is {bearing!r}"
        advice = "Correct the header, or put the log into a campaign of its own."
        yield Refusal("other_bearing", reason, advice)
    yield simulation_problem(keys, settings)


def _run(log: ContinuousLog, settings: Settings) -> LoggedRun:
    """Samples have the columns of the project's own names and `row`; the `rig` is the bearing."""
    samples = {name: log.values[quantity] for name, (quantity, _) in _OWN_NAMES.items()}
    bearing = torque_of(settings.campaign).bearing
    # whatever a header says, the rows of a torque log are no settled readings
    log = replace(log, keys={**log.keys, "log_kind": "continuous"})
    return log.run(bearing, {"row": log.rows, **samples}, {}, None)


def torque_of(campaign: Campaign) -> Torque:
    """What the campaign file says of its torque logs.

    Raises:
        OilfilmError: It has none.
    """
    if campaign.torque is None:
        advice = "Add `torque` to its file, or choose another campaign."
        raise OilfilmError(f"campaign {campaign.name!r}: has no torque logs. {advice}")
    return campaign.torque


_ALL = tuple(quantity for quantity, _ in _OWN_NAMES.values())
# Axial load, speed, temperatures and friction torque of a bearing against time.
TORQUE = LogKind(
    Vocabulary("torque", "torque: columns", _OWN_NAMES, _ALL),
    lambda campaign: torque_of(campaign).columns,
    _header_problems,
    _run,
    sheet_keys=("bearing",),
)
