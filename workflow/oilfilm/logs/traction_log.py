"""Logs of a traction rig: their quantities, and the run made of their columns.

Decides: the signals of a traction log.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from oilfilm import tables
from oilfilm.base.units import PA_PER_GPA, FloatArray, IndexArray, conversion, rpm_to_surface_speed
from oilfilm.logs import base, header
from oilfilm.logs.log_schema import (
    HeaderProblems,
    ListedColumns,
    LoggedColumn,
    LogSchema,
    UsableRows,
    Vocabulary,
)
from oilfilm.logs.set_point_changes import row_indices_of_set_points
from oilfilm.physics.contact import Contact, max_hertz_pressure
from oilfilm.settings.campaign import Campaign, Semantics
from oilfilm.settings.config import LoggedTwiceSettings
from oilfilm.settings.resolved import Settings
from oilfilm.settings.rig import Rig

_REQUIRED_QUANTITIES = ("time", "load", "traction_force", "inlet_temperature")
# A rig that gives mu alone needs no force: mu of positive slip is positive.
_SUBSTITUTE_OF_QUANTITY = {"traction_force": "traction_coefficient"}
# Each pair gives both surface speeds.
_SPEED_PAIRS = (("ball_speed", "disc_speed"), ("entrainment_speed", "slide_roll_ratio"))
# On rigs that reverse the slip: the force with the disc faster, and with the ball faster.
_FORCES_OF_DIRECTIONS = ("traction_force_1", "traction_force_2")
# A pressure beside the load says what the rig file's radius and moduli must give.
_STATED_PRESSURE = "max_hertz_pressure"
# Largest relative difference of a stated pressure from the one of load and rig file: the pressure
# is a round number, and the moduli of steels differ by 5 %, which is 3 % of the pressure.
_PRESSURE_TOLERANCE = 0.05
# A sweep to a smaller slide-roll ratio shows no traction curve.
_SMALLEST_SWEEP = 0.005
# The unit of a force that is logged as the torque that it makes about an axis.
_TORQUE_UNIT = "N m"
# Rows that come more slowly than this, nearly each at another slip, are settled readings.
_INTERVAL_OF_READINGS_S = 5.0
_SHARE_OF_READINGS = 0.9
_FEWEST_READINGS = 5
_LARGEST_DIFFERENCE_OF_SAME_SLIP = 0.002
# Column name of the project, with its unit -> quantity and unit.
_QUANTITY_AND_UNIT_OF_COLUMN = {
    "time_s": ("time", "s"),
    "load_n": ("load", "N"),
    "max_hertz_pressure_gpa": ("load", "GPa"),
    "stated_max_hertz_pressure_gpa": (_STATED_PRESSURE, "GPa"),
    "traction_force_n": ("traction_force", "N"),
    "traction_torque_n_m": ("traction_force", _TORQUE_UNIT),
    "traction_coefficient": ("traction_coefficient", "1"),
    "traction_force_1_n": ("traction_force_1", "N"),
    "traction_force_2_n": ("traction_force_2", "N"),
    "inlet_temperature_c": ("inlet_temperature", "degC"),
    "ball_speed_rpm": ("ball_speed", "rpm"),
    "ball_speed_m_s": ("ball_speed", "m/s"),
    "disc_speed_rpm": ("disc_speed", "rpm"),
    "disc_speed_m_s": ("disc_speed", "m/s"),
    "entrainment_speed_m_s": ("entrainment_speed", "m/s"),
    "slide_roll_ratio": ("slide_roll_ratio", "1"),
}


# Quantity -> the column of samples that holds it as logged.
_SAMPLE_COLUMN_OF_QUANTITY = {
    "time": "time_s",
    "load": "load_n",
    "traction_force": "traction_force_n",
    "traction_force_1": "traction_force_1_n",
    "traction_force_2": "traction_force_2_n",
    "inlet_temperature": "inlet_temperature_c",
    "film_thickness": "measured_film_thickness_um",
}


def _header_problems(
    text_of_key: Mapping[str, str], columns: Sequence[LoggedColumn], settings: Settings
) -> HeaderProblems:
    """The problems of a header, one after the other. A later check relies on the earlier ones."""
    yield header.unknown_name_problem("oil", text_of_key, settings.oils)
    yield header.unknown_name_problem("rig", text_of_key, settings.rigs)
    yield header.simulation_problem(text_of_key, settings)
    log_kind = text_of_key.get("log_kind", "continuous")
    if log_kind not in ("continuous", base.SETTLED_LOG_KIND):
        reason = f"the header says log_kind: {log_kind[:120]!r}; expected continuous or steps"
        advice = "Nothing to do if this is not a slip sweep; otherwise correct the header."
        yield base.Refusal("not_a_sweep", reason, f"{advice} {header.FORMAT_ADVICE}")
    yield header.misspelt_key_problem(text_of_key, settings)
    for set_point_key in base.SET_POINT_KEYS:
        if (
            set_point_key in text_of_key
            and base.parse_set_point(set_point_key, text_of_key[set_point_key]) is None
        ):
            reason = (
                f"the header says {set_point_key}: {text_of_key[set_point_key][:60]!r}; expected "
                f"{header.expectation_in_words(set_point_key, text_of_key[set_point_key])}"
            )
            yield base.Refusal("header", reason, f"Correct the header. {header.FORMAT_ADVICE}")
    yield _missing_rig_values(text_of_key["rig"], columns, settings)


def _missing_rig_values(
    rig_name: str, columns: Sequence[LoggedColumn], settings: Settings
) -> base.Refusal | None:
    """A problem where the units of the columns need values that the rig file does not have."""
    rig = settings.rigs[rig_name]
    units = {column.quantity: column.conversion.unit for column in columns}
    missing_rig_keys = []
    if units.get("ball_speed") == "rpm" and rig.ball_track_radius_m is None:
        missing_rig_keys.append("ball_track_radius_m")
    if units.get("disc_speed") == "rpm" and rig.disc_track_radius_m is None:
        missing_rig_keys.append("disc_track_radius_m")
    if units.get("load") == "GPa" and rig.ball_radius_m is None:
        missing_rig_keys.append("ball_radius_m")
    if units.get("traction_force") == _TORQUE_UNIT and rig.torque_arm_m is None:
        missing_rig_keys.append("torque_arm_m")
    if not missing_rig_keys:
        return None
    return base.Refusal(
        "rig",
        "speeds in rpm, a load as pressure or a force as torque need "
        f"{', '.join(missing_rig_keys)} of the rig {rig_name!r}",
        f"Add it to config/rigs/{rig_name}.yaml.",
    )


def _make_run(rows: UsableRows, settings: Settings) -> base.LoggedRun:
    """The run with some rows, its loads as forces and its speeds as surface speeds."""
    rig_name = rows.text_of_key["rig"]
    rig = settings.rigs[rig_name]
    semantics = settings.campaign.semantics_for(rig_name)
    set_points = stated_set_points(rows.text_of_key, settings)
    row_count = len(rows.row_numbers)
    values_of_quantity = dict(rows.values_of_quantity)
    if rows.text_of_key.get("log_kind") == base.SETTLED_LOG_KIND:
        for quantity, value in _value_of_unneeded_quantity(set_points).items():
            if quantity not in values_of_quantity:
                values_of_quantity[quantity] = np.full(row_count, value)
    # `_missing_rig_values` has refused a pressure without a contact, a torque without a lever arm
    contact = rig.contact()
    if contact is not None and rows.unit_of_quantity.get("load") == "GPa":
        values_of_quantity["load"] = contact.load_n(values_of_quantity["load"])
    if rows.unit_of_quantity.get("traction_force") == _TORQUE_UNIT and rig.torque_arm_m is not None:
        values_of_quantity["traction_force"] = (
            values_of_quantity["traction_force"] / rig.torque_arm_m
        )
    if "traction_coefficient" in values_of_quantity:
        force_n = (
            semantics.sliding_sign
            * values_of_quantity["traction_coefficient"]
            * values_of_quantity["load"]
        )
        values_of_quantity["traction_force"] = force_n
    ball_m_s, disc_m_s = _surface_speeds(values_of_quantity, rows.unit_of_quantity, rig, semantics)
    # a broadcast number takes no memory
    unknown_values = np.broadcast_to(np.nan, row_count)
    samples: base.ColumnArrays = {name: unknown_values for name in tables.columns("samples")}
    del samples["run_id"]
    for quantity, column in _SAMPLE_COLUMN_OF_QUANTITY.items():
        if quantity in values_of_quantity:
            samples[column] = values_of_quantity[quantity]
    samples["row"] = rows.row_numbers
    samples["ball_speed_m_s"] = ball_m_s
    samples["disc_speed_m_s"] = disc_m_s
    refusal = _contradiction_refusal(
        rows.row_numbers, values_of_quantity, ball_m_s, disc_m_s, semantics, settings.logged_twice
    )
    refusal = refusal or _slip_unit_refusal(rows, values_of_quantity)
    if contact is not None:
        refusal = refusal or _rig_radius_refusal(values_of_quantity, set_points, contact, rig_name)
    if rows.text_of_key.get("log_kind") != base.SETTLED_LOG_KIND:
        refusal = refusal or _settled_readings_refusal(
            values_of_quantity["time"], ball_m_s, disc_m_s
        )
    return rows.logged_run(rig_name, samples, set_points, refusal)


def _rig_radius_refusal(
    values_of_quantity: Mapping[str, FloatArray],
    set_points: base.SetPoints,
    contact: Contact,
    rig_name: str,
) -> base.Refusal | None:
    """A refusal if load and pressure are both stated, and the rig file gives another pressure.

    Args:
        values_of_quantity: Quantity -> values, each of shape (rows,).
        set_points: Set points of the run.
        contact: The contact of the rig.
        rig_name: Name of the rig.
    """
    stated_gpa = set_points.get("max_hertz_pressure_gpa", np.nan)
    load_n = set_points.get("load_n", np.nan)
    if _STATED_PRESSURE in values_of_quantity and len(values_of_quantity["load"]):
        # without the rows before the load is applied
        is_loaded = values_of_quantity["load"] > values_of_quantity["load"].max() / 2
        if is_loaded.any():
            load_n = float(np.median(values_of_quantity["load"][is_loaded]))
            stated_gpa = float(np.median(values_of_quantity[_STATED_PRESSURE][is_loaded]))
    if not (load_n > 0 and stated_gpa > 0):
        return None
    pressure_pa = max_hertz_pressure(load_n, contact.radius_m, contact.reduced_modulus_pa)
    computed_gpa = float(pressure_pa) / PA_PER_GPA
    if abs(computed_gpa / stated_gpa - 1) <= _PRESSURE_TOLERANCE:
        return None
    # p^3 goes with 1/R^2
    radius_m = contact.radius_m * (computed_gpa / stated_gpa) ** 1.5
    return base.Refusal(
        "rig_radius",
        f"a load of {load_n:.4g} N and a Hertz pressure of {stated_gpa:.4g} GPa are stated; "
        f"with ball_radius_m {contact.radius_m:g} of the rig {rig_name!r} this load gives "
        f"{computed_gpa:.4g} GPa, and the stated pressure needs a radius of {radius_m:.4g} m",
    )


def _slip_unit_refusal(
    rows: UsableRows, values_of_quantity: Mapping[str, FloatArray]
) -> base.Refusal | None:
    """A refusal if the only slip of a log, in %, is so small that it may be a fraction."""
    column = next(
        (column for column in rows.columns if column.quantity == "slide_roll_ratio"), None
    )
    if column is None or column.is_spare or len(rows.row_numbers) == 0:
        return None
    if column.conversion != conversion("%", (column.conversion.unit,)):
        return None
    largest_slip = float(np.max(np.abs(values_of_quantity["slide_roll_ratio"])))
    if not 0 < largest_slip < _SMALLEST_SWEEP:
        return None
    return base.Refusal(
        "slip_unit",
        f"the column {column.name[:60]!r} goes up to {100 * largest_slip:.3g} % of slip, which "
        "shows no traction curve; it may be a fraction, whose unit is 1",
    )


def _settled_readings_refusal(
    time_s: FloatArray, ball_m_s: FloatArray, disc_m_s: FloatArray
) -> base.Refusal | None:
    """A refusal if each row has another slip, seconds after the row before.

    Args:
        time_s: Time of each row, shape (rows,).
        ball_m_s: Surface speed of the ball in m/s, shape (rows,).
        disc_m_s: Surface speed of the disc in m/s, shape (rows,).
    """
    if len(time_s) < _FEWEST_READINGS:
        return None
    interval_s = float(np.median(np.diff(time_s)))
    if interval_s < _INTERVAL_OF_READINGS_S:
        return None
    # at standstill any slip may be computed
    with np.errstate(all="ignore"):
        slip = 2 * (disc_m_s - ball_m_s) / (disc_m_s + ball_m_s)
        is_other_slip = np.abs(np.diff(slip)) > _LARGEST_DIFFERENCE_OF_SAME_SLIP
    if is_other_slip.mean() < _SHARE_OF_READINGS:
        return None
    return base.Refusal(
        "settled_readings",
        f"rows come every {interval_s:.3g} s, each at another slide-roll ratio: these look like "
        "settled readings, and the log is read as a signal against time",
    )


def _value_of_unneeded_quantity(set_points: base.SetPoints) -> dict[str, float]:
    """Quantities for which settled readings need no column, and their values: time is NaN."""
    value_of_quantity = {"time": np.nan}
    for set_point_key, value in set_points.items():
        # the load follows from the pressure
        if set_point_key != "max_hertz_pressure_gpa":
            quantity, _ = base.QUANTITY_AND_UNIT_OF_SET_POINT[set_point_key]
            value_of_quantity[quantity] = value
    return value_of_quantity


def _unneeded_quantities(text_of_key: Mapping[str, str], settings: Settings) -> frozenset[str]:
    """Quantities for which a log needs no column: of settled readings time and set points."""
    if text_of_key.get("log_kind") != base.SETTLED_LOG_KIND:
        return frozenset()
    return frozenset(_value_of_unneeded_quantity(stated_set_points(text_of_key, settings)))


def stated_set_points(text_of_key: Mapping[str, str], settings: Settings) -> base.SetPoints:
    """Set points of a run; those of its header replace those of the campaign file.

    The load follows from the pressure where the contact of the rig is known.
    """
    from_header: dict[str, float] = {}
    for set_point_key in base.SET_POINT_KEYS:
        value = (
            base.parse_set_point(set_point_key, text_of_key[set_point_key])
            if set_point_key in text_of_key
            else None
        )
        if value is not None:
            from_header[set_point_key] = value
    # the load has one set point, as force or as pressure
    replaced_keys = base.LOAD_KEYS if from_header.keys() & base.LOAD_KEYS else frozenset()
    from_campaign: dict[str, float] = settings.campaign.set_points.model_dump(
        include=set(base.SET_POINT_KEYS) - replaced_keys, exclude_none=True
    )
    set_points = from_campaign | from_header
    rig = settings.rigs.get(text_of_key.get("rig", ""))
    contact = rig.contact() if rig else None
    pressure_gpa = set_points.get("max_hertz_pressure_gpa")
    if contact is not None and pressure_gpa is not None and "load_n" not in set_points:
        set_points["load_n"] = float(contact.load_n(pressure_gpa))
    return set_points


def _surface_speeds(
    values_of_quantity: Mapping[str, FloatArray],
    unit_of_quantity: Mapping[str, str],
    rig: Rig,
    semantics: Semantics,
) -> tuple[FloatArray, FloatArray]:
    """Surface speeds of ball and disc in m/s, each of shape (rows,).

    They are logged, or follow from entrainment speed and slide-roll ratio.
    """
    if "ball_speed" in values_of_quantity:
        ball_m_s, disc_m_s = values_of_quantity["ball_speed"], values_of_quantity["disc_speed"]
        if unit_of_quantity["ball_speed"] == "rpm" and rig.ball_track_radius_m is not None:
            ball_m_s = rpm_to_surface_speed(ball_m_s, rig.ball_track_radius_m)
        if unit_of_quantity["disc_speed"] == "rpm" and rig.disc_track_radius_m is not None:
            disc_m_s = rpm_to_surface_speed(disc_m_s, rig.disc_track_radius_m)
        return ball_m_s, disc_m_s
    entrainment_m_s = values_of_quantity["entrainment_speed"]
    # a logged ratio is positive where the body `slower_body` of the campaign file is slowed
    slip = semantics.sliding_sign * semantics.over_mean(values_of_quantity["slide_roll_ratio"])
    sliding_m_s = slip * entrainment_m_s
    return entrainment_m_s - sliding_m_s / 2, entrainment_m_s + sliding_m_s / 2


class _LoggedTwice(NamedTuple):
    """A logged quantity that also follows from other columns.

    Attributes:
        quantity: The quantity.
        logged_values: Its column, shape (n,).
        expected_values: The values that follow from the other columns, shape (n,).
        scale: Divisor of the differences, shape (n,).
        largest_median: Largest median of the scaled differences.
        other_columns: The other columns in words.
    """

    quantity: str
    logged_values: FloatArray
    expected_values: FloatArray
    scale: FloatArray
    largest_median: float
    other_columns: str


def _contradiction_refusal(
    row_numbers: IndexArray,
    values_of_quantity: Mapping[str, FloatArray],
    ball_m_s: FloatArray,
    disc_m_s: FloatArray,
    semantics: Semantics,
    limits: LoggedTwiceSettings,
) -> base.Refusal | None:
    """A refusal if the logged entrainment speed, slip or force contradicts the other columns.

    Args:
        row_numbers: Row numbers, shape (rows,).
        values_of_quantity: Quantity -> values, each of shape (rows,).
        ball_m_s: Surface speed of the ball in m/s, shape (rows,).
        disc_m_s: Surface speed of the disc in m/s, shape (rows,).
        semantics: Definitions of the logged signals.
        limits: Largest differences.
    """
    if not values_of_quantity.keys() & {
        "entrainment_speed",
        "slide_roll_ratio",
        "traction_force_1",
    }:
        # nothing is logged twice
        return None
    turning_indices = np.arange(len(row_numbers))
    if "ball_speed" in values_of_quantity:
        # near standstill a slip is noise
        entrainment_m_s = np.abs(ball_m_s + disc_m_s) / 2
        fast_m_s = np.quantile(entrainment_m_s, 0.9) if len(row_numbers) else 0.0
        turning_indices = np.flatnonzero(entrainment_m_s > fast_m_s / 2)
    turning_values = {
        quantity: column[turning_indices] for quantity, column in values_of_quantity.items()
    }
    quantities_logged_twice = _quantities_logged_twice(
        turning_values, ball_m_s[turning_indices], disc_m_s[turning_indices], semantics, limits
    )
    for logged_twice in quantities_logged_twice:
        with np.errstate(divide="ignore", invalid="ignore"):  # no force in either direction
            scaled_difference = (
                np.abs(logged_twice.logged_values - logged_twice.expected_values)
                / logged_twice.scale
            )
        compared_indices = np.flatnonzero(np.isfinite(scaled_difference))
        if len(compared_indices) == 0:
            continue
        # the median row decides: a logged set point jumps before the rig follows
        median_difference = float(np.median(scaled_difference[compared_indices]))
        if median_difference > logged_twice.largest_median:
            worst_index = compared_indices[np.argmax(scaled_difference[compared_indices])]
            return base.Refusal(
                "columns_disagree",
                f"{logged_twice.quantity} is {logged_twice.logged_values[worst_index]:.4g} in row "
                f"{row_numbers[turning_indices][worst_index]}, but "
                f"{logged_twice.other_columns} give "
                f"{logged_twice.expected_values[worst_index]:.4g}; the median "
                "difference is "
                f"{median_difference:.2g}, allowed {logged_twice.largest_median:g}",
            )
    return None


def _quantities_logged_twice(
    values_of_quantity: Mapping[str, FloatArray],
    ball_m_s: FloatArray,
    disc_m_s: FloatArray,
    semantics: Semantics,
    limits: LoggedTwiceSettings,
) -> list[_LoggedTwice]:
    """The quantities of a log that also follow from other columns."""
    quantities_logged_twice: list[_LoggedTwice] = []
    if "ball_speed" in values_of_quantity:
        entrainment_m_s = (ball_m_s + disc_m_s) / 2
        sliding_m_s = semantics.sliding_sign * (disc_m_s - ball_m_s)
        speeds_in_words = "the speeds of ball and disc"
        if "entrainment_speed" in values_of_quantity:
            logged_values = values_of_quantity["entrainment_speed"]
            largest_median = limits.entrainment_speed
            quantities_logged_twice.append(
                _LoggedTwice(
                    "entrainment_speed",
                    logged_values,
                    entrainment_m_s,
                    np.abs(entrainment_m_s),
                    largest_median,
                    speeds_in_words,
                )
            )
        if "slide_roll_ratio" in values_of_quantity:
            logged_values = semantics.over_mean(values_of_quantity["slide_roll_ratio"])
            largest_median = limits.slide_roll_ratio
            slip = sliding_m_s / entrainment_m_s
            quantities_logged_twice.append(
                _LoggedTwice(
                    "slide_roll_ratio",
                    logged_values,
                    slip,
                    np.ones_like(slip),
                    largest_median,
                    speeds_in_words,
                )
            )
    if "traction_force" in values_of_quantity and values_of_quantity.keys() >= set(
        _FORCES_OF_DIRECTIONS
    ):
        force_disc_faster = values_of_quantity["traction_force_1"]
        force_ball_faster = values_of_quantity["traction_force_2"]
        quantities_logged_twice.append(
            _LoggedTwice(
                "traction_force",
                logged_values=values_of_quantity["traction_force"],
                expected_values=(force_disc_faster - force_ball_faster) / 2,
                scale=(np.abs(force_disc_faster) + np.abs(force_ball_faster)) / 2,
                largest_median=limits.traction_force,
                other_columns="the forces of both directions of the slip",
            )
        )
    return quantities_logged_twice


def _listed_columns(campaign: Campaign) -> ListedColumns:
    return campaign.columns


# Load, traction force, surface speeds and temperature against time.
TRACTION = LogSchema(
    Vocabulary(
        "traction",
        columns_key="columns",
        quantity_and_unit_of_column=_QUANTITY_AND_UNIT_OF_COLUMN,
        required_quantities=_REQUIRED_QUANTITIES,
        alternative_quantities=_SPEED_PAIRS,
        optional_quantities=(*_FORCES_OF_DIRECTIONS, _STATED_PRESSURE),
        substitute_of_quantity=_SUBSTITUTE_OF_QUANTITY,
    ),
    _listed_columns,
    _header_problems,
    _make_run,
    run_sheet_keys=("rig", "log_kind", *base.SET_POINT_KEYS),
    find_unneeded_quantities=_unneeded_quantities,
    find_rows_of_set_points=row_indices_of_set_points,
)
