"""Logs of a traction rig: what they hold, and the run that their columns make.

Decides: the signals of a traction log.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from oilfilm import tables
from oilfilm.logs import base, header
from oilfilm.logs.log_kind import Column, ContinuousLog, LogKind, Problems, Vocabulary
from oilfilm.settings.campaign import Semantics
from oilfilm.settings.config import LoggedTwiceSettings
from oilfilm.settings.resolved import Settings
from oilfilm.settings.rig import Rig
from oilfilm.units import FloatArray, rpm_to_surface_speed

_ALWAYS = ("time", "load", "traction_force", "inlet_temperature")
# A rig that gives mu alone needs no force: mu of positive slip is positive.
_INSTEAD = {"traction_force": "traction_coefficient"}
# Either pair gives both surface speeds; the first is what a log is asked for.
_SPEEDS = (("ball_speed", "disc_speed"), ("entrainment_speed", "slide_roll_ratio"))
# On rigs that reverse the slip: the force with the disc faster, and with the ball faster.
_BOTH_WAYS = ("traction_force_1", "traction_force_2")
_BODIES = ("ball", "disc")
# No law of traction can be seen at less slip than this.
_LEAST_SLIP = 0.005
# Column names that carry their unit, as the project writes them.
_OWN_NAMES = {
    "time_s": ("time", "s"),
    "load_n": ("load", "N"),
    "max_hertz_pressure_gpa": ("load", "GPa"),
    "traction_force_n": ("traction_force", "N"),
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


# Columns of samples that are as they were logged, by quantity: the project's names in these units.
_SAMPLED = {of: name for name, (of, unit) in _OWN_NAMES.items() if unit in ("s", "N", "degC")}
_SAMPLED["film_thickness"] = "measured_film_thickness_um"


def _header_problems(
    keys: Mapping[str, str], columns: Sequence[Column], settings: Settings
) -> Problems:
    """What is wrong with a header, one after the other: later ones take the earlier for granted."""
    yield header.unknown("oil", keys, settings.oils)
    yield header.unknown("rig", keys, settings.rigs)
    yield header.simulation_problem(keys, settings)
    if (kind := keys.get("log_kind", "continuous")) not in ("continuous", "steps"):
        reason = f"the header says log_kind: {kind[:120]!r}; expected continuous or steps"
        advice = "Nothing to do if this is not a slip sweep; otherwise correct the header."
        yield base.Refusal("not_a_sweep", reason, f"{advice} {header.FORMAT_ADVICE}")
    yield header.misspelt_key(keys, settings)
    for name in base.SET_POINTS:
        if name in keys and base.set_point(name, keys[name]) is None:
            said = f"the header says {name}: {keys[name][:60]!r}"
            reason = f"{said}; expected {base.expected_set_point(name)}"
            yield base.Refusal("header", reason, f"Correct the header. {header.FORMAT_ADVICE}")
    rig, units = settings.rigs[keys["rig"]], {each.quantity: each.to.unit for each in columns}
    needed = [f"{body}_track_radius_m" for body in _BODIES if units.get(f"{body}_speed") == "rpm"]
    needed += ["ball_radius_m"] if units.get("load") == "GPa" else []
    if missing := [key for key in needed if getattr(rig, key) is None]:
        needed_of = f"{', '.join(missing)} of the rig {keys['rig']!r}"
        reason = f"speeds in rpm or a load as pressure need {needed_of}"
        yield base.Refusal("rig", reason, f"Add it to config/rigs/{keys['rig']}.yaml.")


def _run(log: ContinuousLog, settings: Settings) -> base.LoggedRun:
    keys, given = log.keys, nominal(log.keys, settings)
    rig, semantics = settings.rigs[keys["rig"]], settings.campaign.semantics_for(keys["rig"])
    held = {"time": np.nan, **_held(given)}
    left_out = held.keys() & _spared(keys, settings) - log.values.keys()
    values = dict(log.values) | {name: np.full(len(log.rows), held[name]) for name in left_out}
    # a load as maximum Hertz pressure is refused of a rig whose contact is not known
    contact = rig.contact() if log.units.get("load") == "GPa" else None
    if contact is not None:
        values["load"] = contact.load_n(values["load"])
    if "traction_coefficient" in values:
        force = semantics.direction * values["traction_coefficient"] * values["load"]
        values["traction_force"] = force
    ball, disc = _surface_speeds(values, log.units, rig, semantics)
    # a column of one number, that takes no memory, where the log has none
    empty = dict.fromkeys(tables.columns("samples"), np.broadcast_to(np.nan, len(log.rows)))
    del empty["run_id"]
    logged = {column: values[name] for name, column in _SAMPLED.items() if name in values}
    samples = empty | logged | {"row": log.rows, "ball_speed_m_s": ball, "disc_speed_m_s": disc}
    flaw = _contradiction(log.rows, values, (ball, disc), semantics, settings.logged_twice)
    return log.run(keys["rig"], samples, given, flaw or _fraction_in_percent(log, values))


def _fraction_in_percent(
    log: ContinuousLog, values: Mapping[str, FloatArray]
) -> base.Refusal | None:
    """Whether the only slip of a log is so small that its %, not the slip, is in doubt."""
    column = next((each for each in log.columns if each.quantity == "slide_roll_ratio"), None)
    if column is None or column.spare or column.logged_unit != "%" or not len(log.rows):
        return None
    largest = float(np.max(np.abs(values["slide_roll_ratio"])))
    if not 0 < largest < _LEAST_SLIP:
        return None
    return base.Refusal(
        "slip_unit",
        f"the column {column.name[:60]!r} goes up to {100 * largest:.3g} % of slip, which shows no "
        "traction curve; it may be a fraction, whose unit is 1",
    )


def _held(given: base.Nominal) -> dict[str, float]:
    """What set points say of the quantities that a table of settled readings may leave out."""
    # the load follows from the pressure
    held = given.keys() - {"max_hertz_pressure_gpa"}
    return {base.SET_POINT_UNITS[name][0]: given[name] for name in held}


def _spared(keys: Mapping[str, str], settings: Settings) -> frozenset[str]:
    """Readings that have settled need no time, and no column of what a set point says."""
    if keys.get("log_kind") != "steps":
        return frozenset()
    return frozenset({"time", *_held(nominal(keys, settings))})


def nominal(keys: Mapping[str, str], settings: Settings) -> base.Nominal:
    """Set points of a run: those of its header keys before those of the campaign file.

    The load follows from the pressure where the contact of the rig is known.
    """
    given = {name: base.set_point(name, keys[name]) for name in base.SET_POINTS if name in keys}
    known = {name: value for name, value in given.items() if value is not None}
    # the load has one set point, as force or as pressure
    over = base.LOADS if known.keys() & base.LOADS else frozenset()
    values = settings.campaign.set_points.model_dump(
        include=set(base.SET_POINTS) - over, exclude_none=True
    )
    values |= known
    rig, pressure = settings.rigs.get(keys.get("rig", "")), values.get("max_hertz_pressure_gpa")
    contact = rig.contact() if rig else None
    if contact is not None and pressure is not None and "load_n" not in values:
        values["load_n"] = float(contact.load_n(pressure))
    return values


def _surface_speeds(
    values: Mapping[str, FloatArray], units: Mapping[str, str], rig: Rig, log: Semantics
) -> tuple[FloatArray, FloatArray]:
    """Surface speeds of ball and disc in m/s, from theirs or from entrainment speed and slip."""
    if "ball_speed" in values:
        ball, disc = (values[f"{body}_speed"] for body in _BODIES)
        radii = rig.ball_track_radius_m, rig.disc_track_radius_m
        if units["ball_speed"] == "rpm" and radii[0] is not None:
            ball = rpm_to_surface_speed(ball, radii[0])
        if units["disc_speed"] == "rpm" and radii[1] is not None:
            disc = rpm_to_surface_speed(disc, radii[1])
        return ball, disc
    mean = values["entrainment_speed"]
    # a logged ratio is positive with the slower body slowed
    sliding = log.direction * log.over_mean(values["slide_roll_ratio"]) * mean
    return mean - sliding / 2, mean + sliding / 2


def _contradiction(
    rows: base.IndexArray,
    values: Mapping[str, FloatArray],
    speeds: tuple[FloatArray, FloatArray],
    log: Semantics,
    limits: LoggedTwiceSettings,
) -> base.Refusal | None:
    """How a log's own entrainment speed, slip or force contradicts its other columns, if so."""
    (ball, disc), turning, given = speeds, np.arange(len(rows)), []
    if not values.keys() & {"entrainment_speed", "slide_roll_ratio", _BOTH_WAYS[0]}:
        return None  # nothing is logged twice
    if "ball_speed" in values:
        mean, sliding = (ball + disc) / 2, log.direction * (disc - ball)
        fast = np.quantile(np.abs(mean), 0.9) if len(mean) else 0.0
        # near standstill a slip is noise
        turning = np.flatnonzero(np.abs(mean) > fast / 2)
        mean, sliding = mean[turning], sliding[turning]
        others = "the speeds of ball and disc"
        given += [
            ("entrainment_speed", mean, np.abs(mean), others),
            ("slide_roll_ratio", sliding / mean, np.ones_like(mean), others),
        ]
    if set(_BOTH_WAYS) <= values.keys():
        first, second = (values[name][turning] for name in _BOTH_WAYS)
        size = (np.abs(first) + np.abs(second)) / 2
        others = "the forces of both directions of the slip"
        given.append(("traction_force", (first - second) / 2, size, others))
    for name, expected, unit, others in given:
        if name not in values:
            continue
        logged = values[name][turning]
        logged = log.over_mean(logged) if name == "slide_roll_ratio" else logged
        with np.errstate(divide="ignore", invalid="ignore"):  # no force in either direction
            apart = np.abs(logged - expected) / unit
        # the median row decides: a logged set point jumps before the rig follows
        known = np.flatnonzero(np.isfinite(apart))
        if len(known) and (median := float(np.median(apart[known]))) > getattr(limits, name):
            worst = known[np.argmax(apart[known])]
            return base.Refusal(
                "columns_disagree",
                f"{name} is {logged[worst]:.4g} in row {rows[turning][worst]}, but {others} "
                f"give {expected[worst]:.4g}; the median difference is {median:.2g}, allowed "
                f"{getattr(limits, name):g}",
            )
    return None


# Load, traction force, surface speeds and temperature against time.
TRACTION = LogKind(
    Vocabulary("traction", "columns", _OWN_NAMES, _ALWAYS, _SPEEDS, _BOTH_WAYS, _INSTEAD),
    lambda campaign: campaign.columns,
    _header_problems,
    _run,
    sheet_keys=("rig", "log_kind", *base.SET_POINTS),
    spared=_spared,
)
