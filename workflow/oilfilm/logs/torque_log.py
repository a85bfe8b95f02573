"""Logs of a torque rig: their quantities, and the run made of their columns.

Decides: the signals of a torque log, and the names of its columns.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from oilfilm.base.errors import OilfilmError
from oilfilm.logs.base import ColumnArrays, LoggedRun, Refusal
from oilfilm.logs.header import simulation_problem, unknown_name_problem
from oilfilm.logs.log_schema import (
    HeaderProblems,
    ListedColumns,
    LoggedColumn,
    LogSchema,
    UsableRows,
    Vocabulary,
)
from oilfilm.settings.campaign import Campaign, Torque
from oilfilm.settings.resolved import Settings

# Column name of the project, with its unit -> quantity and unit. Every log must have all of them.
_QUANTITY_AND_UNIT_OF_COLUMN = {
    "time_s": ("time", "s"),
    "axial_load_n": ("axial_load", "N"),
    "inner_speed_rpm": ("inner_speed", "rpm"),
    "oil_temperature_c": ("oil_temperature", "degC"),
    "outer_ring_temperature_c": ("outer_ring_temperature", "degC"),
    "torque_n_m": ("torque", "N m"),
}


def _header_problems(
    text_of_key: Mapping[str, str], columns: Sequence[LoggedColumn], settings: Settings
) -> HeaderProblems:
    """The problems of a header: unknown oil, other bearing, simulated log among measured ones."""
    yield unknown_name_problem("oil", text_of_key, settings.oils)
    bearing = torque_section(settings.campaign).bearing
    logged_bearing = text_of_key.get("bearing", bearing)
    if logged_bearing != bearing:
        reason = f"the header says bearing {logged_bearing[:60]!r}; the campaign's is {bearing!r}"
        advice = "Correct the header, or put the log into a campaign of its own."
        yield Refusal("other_bearing", reason, advice)
    yield simulation_problem(text_of_key, settings)


def _make_run(rows: UsableRows, settings: Settings) -> LoggedRun:
    """The run with some rows. Its samples have `row` and the columns of the project.

    Its `rig_name` is the name of the bearing.
    """
    samples: ColumnArrays = {"row": rows.row_numbers}
    for name, (quantity, _) in _QUANTITY_AND_UNIT_OF_COLUMN.items():
        samples[name] = rows.values_of_quantity[quantity]
    bearing = torque_section(settings.campaign).bearing
    # the rows of a torque log are never settled readings, even if its header says so
    rows = replace(rows, text_of_key={**rows.text_of_key, "log_kind": "continuous"})
    return rows.logged_run(bearing, samples, set_points={}, refusal=None)


def torque_section(campaign: Campaign) -> Torque:
    """What the campaign file says of its torque logs.

    Raises:
        OilfilmError: The campaign file says nothing of torque logs.
    """
    if campaign.torque is None:
        advice = "Add `torque` to its file, or choose another campaign."
        raise OilfilmError(f"campaign {campaign.name!r}: has no torque logs. {advice}")
    return campaign.torque


def _listed_columns(campaign: Campaign) -> ListedColumns:
    return torque_section(campaign).columns


# Axial load, speed, temperatures and friction torque of a bearing against time.
TORQUE = LogSchema(
    Vocabulary(
        "torque",
        columns_key="torque: columns",
        quantity_and_unit_of_column=_QUANTITY_AND_UNIT_OF_COLUMN,
        required_quantities=tuple(
            quantity for quantity, _ in _QUANTITY_AND_UNIT_OF_COLUMN.values()
        ),
    ),
    _listed_columns,
    _header_problems,
    _make_run,
    run_sheet_keys=("bearing",),
)
