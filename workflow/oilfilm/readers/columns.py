"""What the columns of a log mean, and the run that they make: shared by all formats in columns.

A format finds names, units, header keys and numbers; everything that follows from them is here.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from oilfilm.contact import load_for_max_hertz_pressure
from oilfilm.readers.base import (
    LARGEST_READING,
    SET_POINTS,
    LoggedRun,
    Nominal,
    Refusal,
    as_ranges,
    number,
    samples_of_run,
)
from oilfilm.rigs import contact_of
from oilfilm.semantics import Semantics, semantics_of
from oilfilm.units import ABSOLUTE_ZERO_C, PA_PER_GPA, Conversion, conversion, rpm_to_surface_speed

FloatArray = npt.NDArray[np.float64]
IndexArray = npt.NDArray[np.int64]
Renamed = Mapping[str, Mapping[str, str]]

# What a log may hold -> the units that can be used of it.
QUANTITIES = {
    "time": ("s",),
    "load": ("N", "GPa"),
    "traction_force": ("N",),
    "inlet_temperature": ("degC",),
    "ball_speed": ("rpm", "m/s"),
    "disc_speed": ("rpm", "m/s"),
    "entrainment_speed": ("m/s",),
    "slide_roll_ratio": ("1",),
}
_ALWAYS = ("time", "load", "traction_force", "inlet_temperature")
# Either pair gives both surface speeds; the first is what a log is asked for.
_SPEEDS = (("ball_speed", "disc_speed"), ("entrainment_speed", "slide_roll_ratio"))
# Column names that carry their unit, as the project writes them.
_OWN_NAMES = {
    "time_s": ("time", "s"),
    "load_n": ("load", "N"),
    "max_hertz_pressure_gpa": ("load", "GPa"),
    "traction_force_n": ("traction_force", "N"),
    "inlet_temperature_c": ("inlet_temperature", "degC"),
    "ball_speed_rpm": ("ball_speed", "rpm"),
    "ball_speed_m_s": ("ball_speed", "m/s"),
    "disc_speed_rpm": ("disc_speed", "rpm"),
    "disc_speed_m_s": ("disc_speed", "m/s"),
    "entrainment_speed_m_s": ("entrainment_speed", "m/s"),
    "slide_roll_ratio": ("slide_roll_ratio", "1"),
}


@dataclass(frozen=True)
class Vocabulary:
    """What the logs of one kind of rig may hold.

    Attributes:
        name: Kind of log, in a word.
        quantities: Quantity -> the units that can be used of it.
        own_names: Column names that carry their unit -> quantity and unit.
        always: Quantities that every log must have.
        either: Sets of quantities of which one must be there; the first is what a log is asked for.
    """

    name: str
    quantities: Mapping[str, tuple[str, ...]]
    own_names: Mapping[str, tuple[str, str]]
    always: tuple[str, ...]
    either: tuple[tuple[str, ...], ...]


TRACTION = Vocabulary("traction", QUANTITIES, _OWN_NAMES, _ALWAYS, _SPEEDS)
# No material bears more; the load that goes with the cube of it would be no number of a table.
_HARDEST_GPA = 1e3
# No oil is liquid there; its properties have no meaning.
_HOTTEST_C = 1000.0
FORMAT_ADVICE = "data/raw/README.md describes the format."
COLUMNS_ADVICE = f"{FORMAT_ADVICE} Other names: see `columns` of the campaign file."


@dataclass(frozen=True)
class Column:
    """Where a quantity stands in a row and what makes the reader's unit of it."""

    quantity: str
    place: int
    to: Conversion


def meaning(
    name: str, renamed: Renamed, vocabulary: Vocabulary = TRACTION
) -> tuple[str, str | None] | None:
    """Quantity and unit (None where something else must give it) of a column's name.

    Args:
        name: Column name as the log writes it.
        renamed: Quantity -> `name` and `unit`, for columns with names of their own.
        vocabulary: What such logs may hold.
    """
    for quantity, given in renamed.items():
        if name == given["name"]:
            return quantity, given.get("unit")
    bare, unit = _apart(name)
    plain = plain_key(bare)
    if plain in vocabulary.own_names:
        quantity, own_unit = vocabulary.own_names[plain]
        return quantity, unit or own_unit
    return (plain, unit) if plain in vocabulary.quantities else None


def _apart(name: str) -> tuple[str, str | None]:
    """A name and the unit in brackets at its end; None where there are none.

    No regular expression: names come out of files, and one of many brackets would take hours.
    """
    if not name.endswith(("]", ")")):
        return name, None
    inside = 1 + max(name.rfind(mark, 0, -1) for mark in "])")
    opened = [place for mark in "[(" if (place := name.find(mark, inside)) >= 0]
    if not opened:
        return name, None
    return name[: min(opened)].rstrip(" \t_"), name[min(opened) + 1 : -1]


def plain_key(text: str) -> str:
    """A key or name in lower case, its words joined by underscores."""
    return "_".join(text.lower().split())


def fits(quantity: str, unit: str, vocabulary: Vocabulary = TRACTION) -> bool:
    """True where a quantity can be given in that unit."""
    try:
        conversion(unit, vocabulary.quantities[quantity])
    except ValueError:
        return False
    return True


def find_columns(
    names: Sequence[str],
    units: Sequence[str | None],
    renamed: Renamed,
    vocabulary: Vocabulary = TRACTION,
) -> tuple[Column, ...]:
    """The columns that make a run, each with its conversion.

    Args:
        names: All column names, in the order of the columns.
        units: Unit that the log gives for each, beside its name; empty or None where none.
        renamed: As for `meaning`.
        vocabulary: As for `meaning`.

    Raises:
        ValueError: A quantity is missing or doubled, or has no unit or an impossible one; the
            message is a sentence for the user.
    """
    found: dict[str, Column] = {}
    for place, (name, own_unit) in enumerate(zip(names, units, strict=True)):
        known = meaning(name, renamed, vocabulary)
        if known is None:
            continue
        quantity, unit = known[0], own_unit or known[1]
        if quantity in found:
            raise ValueError(f"the log repeats the column {quantity!r}")
        if not unit:
            raise ValueError(
                f"the column {name[:60]!r} has no unit; write it in brackets, in a row below the "
                "names or under `columns` of the campaign file"
            )
        try:
            found[quantity] = Column(
                quantity, place, conversion(unit, vocabulary.quantities[quantity])
            )
        except ValueError as error:
            raise ValueError(f"the column {name[:60]!r}: {error}") from error
    either = vocabulary.either
    chosen = next((some for some in either if all(name in found for name in some)), either[0])
    needed = [*vocabulary.always, *chosen]
    missing = [quantity for quantity in needed if quantity not in found]
    if missing:
        raise ValueError(
            f"the log lacks the columns {', '.join(missing)}; its own are "
            f"{', '.join(names)[:200]!r}"
        )
    return tuple(found[quantity] for quantity in needed)


def header_problem(
    keys: Mapping[str, str], columns: Sequence[Column], config: Mapping[str, Any]
) -> tuple[str, str, str] | None:
    """Why a log with these header keys and columns cannot be used: rule, reason, advice."""
    oil, rig = keys.get("oil"), _rig_name(keys, config)
    if oil is None:
        reason = "the header has no line `# oil: ...` and no property `oil`"
        return ("header", reason, f"Add it. {FORMAT_ADVICE}")
    for kind, name, known in (("oil", oil, config["oils"]), ("rig", rig, config["rigs"])):
        if name not in known:
            return (
                f"unknown_{kind}",
                f"the header says {kind} {name[:60]!r}; the campaign knows {', '.join(known)}",
                f"Correct the header, or add the {kind} to the campaign file.",
            )
    if keys.get("simulated", "no") != "no" and config["campaign"]["data"] == "measured":
        return (
            "simulated_log",
            "the header says that the log is simulated; the campaign file says data: measured",
            "Take the log out, or say data: simulated in the campaign file.",
        )
    for name in SET_POINTS:
        if name in keys and _set_point(name, keys[name]) is None:
            return (
                "header",
                f"the header says {name}: {keys[name][:60]!r}; expected a number above "
                f"{_least(name):g}, below {_most(name):g}",
                f"Correct the header. {FORMAT_ADVICE}",
            )
    return _rig_problem(columns, rig, config["rigs"][rig])


def _set_point(name: str, text: str) -> float | None:
    """The number that a header gives, with a decimal point or comma; None where it gives none."""
    try:
        value = number(text if "." in text else text.replace(",", ".", 1))
    except ValueError:
        return None
    return value if _least(name) < value < _most(name) else None


def _least(name: str) -> float:
    return ABSOLUTE_ZERO_C if name == "inlet_temperature_c" else 0.0


def _most(name: str) -> float:
    return _HARDEST_GPA if name == "max_hertz_pressure_gpa" else LARGEST_READING


def _rig_problem(
    columns: Sequence[Column], name: str, rig: Mapping[str, Any]
) -> tuple[str, str, str] | None:
    """What the columns need of the rig and its file does not say."""
    units = {column.quantity: column.to.unit for column in columns}
    needed = [
        f"{body}_track_radius_m" for body in ("ball", "disc") if units.get(f"{body}_speed") == "rpm"
    ]
    needed += ["ball_radius_m"] if units["load"] == "GPa" else []
    missing = [key for key in needed if key not in rig]
    if not missing:
        return None
    return (
        "rig",
        f"speeds in rpm or a load as pressure need {', '.join(missing)} of the rig {name!r}",
        f"Add it to config/rigs/{name}.yaml.",
    )


@dataclass(frozen=True)
class LoggedTable:
    """One run as a format with typed columns found it.

    Attributes:
        run_id: Unique name of the run.
        keys: Header keys, as `plain_key` makes them.
        names: All column names.
        units: Unit beside each name; empty where none.
        values: A column each; those that mean something to a run have a number a row.
        rows: How many rows there are, good and bad.
        first_row: Number of the first row in the file.
        flaw: What is wrong with the run as a whole, if anything.
    """

    run_id: str
    keys: Mapping[str, str]
    names: Sequence[str]
    units: Sequence[str]
    values: Sequence[npt.NDArray[Any]]
    rows: int
    first_row: int = 1
    flaw: str = ""


def read_table(
    table: LoggedTable, config: Mapping[str, Any]
) -> tuple[list[LoggedRun], list[Refusal]]:
    """The run that a table makes, and what had to be refused of it."""
    try:
        columns = find_columns(table.names, table.units, config["campaign"].get("columns", {}))
        logged = [_numbers(table, column.place) for column in columns]
    except ValueError as error:
        return [], [refused_table(table, "columns", str(error), COLUMNS_ADVICE)]
    problem = header_problem(table.keys, columns, config)
    if problem:
        return [], [refused_table(table, *problem)]
    every, good = converted(columns, logged)
    rows = np.arange(table.first_row, table.first_row + table.rows)
    values = {quantity: numbers[good] for quantity, numbers in every.items()}
    refusals = []
    for first, last in as_ranges(rows[~good]):
        seen = ", ".join(f"{numbers[first - table.first_row]:g}" for numbers in logged)
        refusals.append(unreadable_rows(table.run_id, first, last, seen))
    run = logged_run(table.run_id, rows[good], values, columns, table.keys, config, table.flaw)
    return [run], refusals


def refused_table(table: LoggedTable, rule: str, reason: str, advice: str) -> Refusal:
    """All rows of a table refused for one reason."""
    last = table.first_row + table.rows - 1
    first = min(table.first_row, last)
    return Refusal(rule, reason, advice, table.run_id, first, last, table.rows)


def _numbers(table: LoggedTable, place: int) -> FloatArray:
    column = table.values[place]
    if column.dtype.kind not in "iuf":
        raise ValueError(f"the column {table.names[place][:60]!r} does not hold numbers")
    if len(column) != table.rows:
        raise ValueError(f"the column {table.names[place][:60]!r} has {len(column)} rows")
    return column.astype(np.float64)


# Time may be counted from 1970, in milliseconds too.
_LARGEST_TIME = 1e13


def converted(
    columns: Sequence[Column], logged: Sequence[FloatArray]
) -> tuple[dict[str, FloatArray], npt.NDArray[np.bool_]]:
    """Logged numbers in the units of `columns`, by quantity, and which rows can be used.

    A row can be used where every number is finite and below what any rig measures.
    """
    good = np.logical_and.reduce(
        [
            np.abs(numbers) < (_LARGEST_TIME if column.quantity == "time" else LARGEST_READING)
            for column, numbers in zip(columns, logged, strict=True)
        ]
    )
    whole = bool(good.all())
    values = {
        column.quantity: column.to.of(numbers if whole else np.where(good, numbers, np.nan))
        for column, numbers in zip(columns, logged, strict=True)
    }
    for quantity, numbers in values.items():
        if quantity.endswith("temperature"):
            good = good & (numbers > ABSOLUTE_ZERO_C) & (numbers < _HOTTEST_C)
    return values, good


def unreadable_rows(run_id: str, first: int, last: int, seen: str, where: str = "") -> Refusal:
    """Rows refused for a cell; `seen` is what the first of them holds, `where` its line."""
    return Refusal(
        "unreadable_row",
        f"rows {first} to {last}: cells are missing, too many, not numbers or absurdly large; row "
        f"{first}{where} reads {seen[:80]!r}",
        "Look at these rows of the raw log; the rows around them are used.",
        run_id,
        first,
        last,
        last - first + 1,
    )


def header_text(value: object) -> str:
    """A property of a binary format as a text log would write it."""
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, float) and value.is_integer():
        return str(int(value))
    return str(value).strip()


def logged_run(
    run_id: str,
    rows: IndexArray,
    values: Mapping[str, FloatArray],
    columns: Sequence[Column],
    keys: Mapping[str, str],
    config: Mapping[str, Any],
    flaw: str = "",
) -> LoggedRun:
    """A continuous run out of the numbers of a log whose header has no problem.

    Args:
        run_id: Unique name of the run.
        rows: Row numbers in the log, shape (n,).
        values: Quantity -> numbers in the units of `columns`, each of shape (n,).
        columns: As `find_columns` gave them.
        keys: Header keys.
        config: The resolved configuration.
        flaw: What is wrong with the run as a whole, if anything.
    """
    rig_name = _rig_name(keys, config)
    rig = config["rigs"][rig_name]
    units = {column.quantity: column.to.unit for column in columns}
    log = semantics_of(config["campaign"], rig_name)
    ball, disc = _surface_speeds(values, units, rig, log)
    samples = samples_of_run(
        row=rows,
        time_s=values["time"],
        load_n=_load_n(values["load"], units["load"], rig),
        traction_force_n=values["traction_force"],
        ball_speed_m_s=ball,
        disc_speed_m_s=disc,
        inlet_temperature_c=values["inlet_temperature"],
    )
    given = {name: _set_point(name, keys[name]) for name in SET_POINTS if name in keys}
    header = {name: value for name, value in given.items() if value is not None}
    nominal = Nominal.planned(config["campaign"], header)
    return LoggedRun(
        run_id, keys["oil"], rig_name, "continuous", nominal, samples, flaw, keys.get("run", "")
    )


def _rig_name(keys: Mapping[str, str], config: Mapping[str, Any]) -> str:
    return keys.get("rig", next(iter(config["rigs"])))


def _load_n(values: FloatArray, unit: str, rig: Mapping[str, Any]) -> FloatArray:
    """Load in N; a load logged as maximum Hertz pressure by way of the rig's contact."""
    contact = contact_of(rig)
    if unit == "N" or contact is None:
        return values
    return load_for_max_hertz_pressure(
        values * PA_PER_GPA, contact.radius_m, contact.reduced_modulus_pa
    )


def _surface_speeds(
    values: Mapping[str, FloatArray],
    units: Mapping[str, str],
    rig: Mapping[str, Any],
    log: Semantics,
) -> tuple[FloatArray, FloatArray]:
    """Surface speeds of ball and disc in m/s, from theirs or from entrainment speed and slip."""
    if "ball_speed" in values:
        ball, disc = (
            values[f"{body}_speed"]
            if units[f"{body}_speed"] == "m/s"
            else rpm_to_surface_speed(values[f"{body}_speed"], rig[f"{body}_track_radius_m"])
            for body in ("ball", "disc")
        )
        return ball, disc
    mean = values["entrainment_speed"]
    # a logged ratio is positive with the slower body slowed
    sliding = log.direction * log.over_mean(values["slide_roll_ratio"]) * mean
    return mean - sliding / 2, mean + sliding / 2
