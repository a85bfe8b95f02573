"""Columns: what they are made of, and those that tables of several rooms share.

A column is declared once, beside the table that it belongs to: name, type, unit, meaning, caveat,
bounds. A table lists the names of its columns. It may narrow a column and add a note (`use`), but
it has no unit and no meaning of its own: the same name is the same quantity everywhere.

Decides: what a column of several modules means, and its unit.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from oilfilm.tables.declaration import BY_ROW, LARGEST, Check, Column, Table, by_name
from oilfilm.units import ABSOLUTE_ZERO_C

# Every column by name; modules of tables add their own.
COLUMNS: dict[str, Column] = {}


def declare_columns(*columns: Column) -> None:
    """Add the columns of a module of tables.

    Raises:
        ValueError: There is another column of this name.
    """
    new = by_name(columns)
    if twice := sorted(name for name in new if COLUMNS.get(name, new[name]) != new[name]):
        raise ValueError(f"declared twice: {', '.join(twice)}")
    COLUMNS.update(new)


def number(
    name: str,
    unit: str,
    meaning: str,
    caveat: str = "",
    *,
    required: bool = False,
    at_least: float = -LARGEST,
    at_most: float = LARGEST,
) -> Column:
    """A quantity, null where it is not known; infinity passes no bound."""
    return Column(name, "number", unit, meaning, caveat, not required, at_least, at_most)


def share(name: str, meaning: str, caveat: str = "", *, required: bool = False) -> Column:
    """A number from 0 to 1."""
    return number(name, "1", meaning, caveat, required=required, at_least=0, at_most=1)


def count(name: str, meaning: str, caveat: str = "") -> Column:
    """A whole number of things, or of a row; never null."""
    return Column(name, "integer", "1", meaning, caveat, at_least=0)


def text(name: str, meaning: str, caveat: str = "", *, allowed: tuple[str, ...] = ()) -> Column:
    """Words; empty rather than null."""
    return Column(name, "text", "", meaning, caveat, allowed=allowed)


def flag(name: str, meaning: str, caveat: str = "") -> Column:
    """True or false."""
    return Column(name, "flag", "", meaning, caveat)


# What a condition of a traction test is made of: end of a column's name, unit, quantity.
TEST_CONDITIONS = (
    ("max_hertz_pressure_gpa", "GPa", "maximum Hertz pressure"),
    ("entrainment_speed_m_s", "m/s", "entrainment speed"),
    ("inlet_temperature_c", "degC", "inlet temperature"),
)
SLIP = ("slide_roll_ratio", "1", "slide-roll ratio")

# fmt: off
declare_columns(
    text("campaign", "campaign, as named in config/campaigns"),
    text("run_id", "run: one log file, or one group of it as file:group"),
    text("oil", "oil, as named in config/oils"),
    text("rig", "rig, as named in config/rigs"),
    text("bearing", "bearing, as named in config/bearings"),
    text("file", "raw log, relative to the campaign's raw folder"),
    text("sha256", "SHA-256 of the raw log's bytes"),
    text("content_sha256", "SHA-256 of the log after unpacking, so that packed copies are known"),
    text("label", "the log's own name of the run; empty where it has none"),
    text("reader", "format that the log was read as"),
    text("encoding", "encoding that a text log was read in; empty for other formats"),
    text("delimiter", "what parts the cells of a text log: comma, semicolon, tab, bar or blanks; "
        "empty for other formats"),
    text("decimal_mark", "decimal mark of a text log: point or comma; empty for other formats"),
    text("log_kind", "continuous: a signal against time; steps: each row is already a settled "
        "reading", allowed=("continuous", "steps")),
    count("row", "data row in the raw log, counted from 1"),
    count("first_row", "first data row concerned, in the raw log"),
    count("last_row", "last data row concerned, in the raw log"),
)

declare_columns(
    number("time_s", "s", "time on the log's clock", required=True),
    number("duration_s", "s", "length of the settled part of a plateau", at_least=0),
    number("load_n", "N", "normal load of the contact"),
    number("max_hertz_pressure_gpa", "GPa", "maximum Hertz pressure of the contact", at_least=0),
    number("entrainment_speed_m_s", "m/s", "entrainment speed: mean of the two surface speeds"),
    number("slide_roll_ratio", "1", "slide-roll ratio: sliding speed over entrainment speed, "
        "positive where the slower body is slowed"),
    number("inlet_temperature_c", "degC", "oil temperature at the inlet"),
    number("ball_speed_m_s", "m/s", "surface speed of the ball at the contact"),
    number("disc_speed_m_s", "m/s", "surface speed of the disc at the contact"),
    number("nominal_load_n", "N", "set point of the normal load", at_least=0),
    number("nominal_max_hertz_pressure_gpa", "GPa", "set point of the maximum Hertz pressure",
        at_least=0),
    number("nominal_entrainment_speed_m_s", "m/s", "set point of the entrainment speed",
        at_least=0),
    number("nominal_inlet_temperature_c", "degC", "set point of the inlet temperature",
        at_least=ABSOLUTE_ZERO_C),
)

# Of tables in several modules.
declare_columns(
    *(
        number(
            f"worst_{name}",
            unit,
            f"{quantity} in the worst case; null where the case has none, or all",
        )
        for name, unit, quantity in (*TEST_CONDITIONS, SLIP)
    ),
    text("best_oil", "best oil of those with enough film; empty where there is none"),
    number("value", BY_ROW, "value of what the row names", "unit: that of the quantity in the row"),
    text("verdict", "verdict on what the row names"),
    text("figure", "figure of the paper that has the condition"),
    flag("accepted", "true where no gate refused the plateau"),
    text("failed_gates", "gates that refused the plateau, joined by ';'; empty where none did"),
    text("advice", "what to do about it"),
    text("defect", "defect planted by the rig twin; empty for a clean log"),
    number("law_misfit", "1", "root-mean-square difference between the traction behind the torque "
        "logs, averaged over the traction rig's contact, and the one behind the traction logs, "
        "over the campaign's matrix and slips, relative to the latter; 0 where a law is behind "
        "both",
        required=True),
    number("traction_coefficient", "1", "traction coefficient mu: traction force over normal load"),
    number("traction_coefficient_se", "1", "standard error of the traction coefficient",
        "random part only: calibration errors, which a whole run shares, are not included",
        at_least=0),
    count("n_samples", "rows averaged", "rows marked as spikes are not among them"),
    count("n_spikes", "rows left out of the mean as spikes"),
    number("lambda_ratio", "1", "film thickness over combined roughness"),
)
# fmt: on


def unit_of(name: str) -> str:
    """The unit of a column; "1" for plain numbers, empty for text and flags.

    Raises:
        KeyError: No table has such a column.
    """
    return COLUMNS[name].unit


def use(
    name: str,
    note: str = "",
    *,
    required: bool = False,
    at_least: float | None = None,
    at_most: float | None = None,
    allowed: tuple[str, ...] = (),
    dictionary: bool = False,
) -> Column:
    """A column as one table has it: same unit and meaning, narrower bounds, a note.

    Raises:
        ValueError: A bound or an allowed text is outside what the column allows.
    """
    column = COLUMNS[name]
    low = column.at_least if at_least is None else at_least
    high = column.at_most if at_most is None else at_most
    wider = (
        (column.at_least is not None and low is not None and low < column.at_least)
        or (column.at_most is not None and high is not None and high > column.at_most)
        or (column.allowed and not set(allowed) <= set(column.allowed))
    )
    if wider:
        raise ValueError(f"column {column.name!r} cannot be widened by a table")
    return replace(
        column,
        note=note,
        nullable=column.nullable and not required,
        at_least=low,
        at_most=high,
        allowed=allowed or column.allowed,
        dictionary=dictionary,
    )


def table(
    name: str,
    description: str,
    *,
    columns: str,
    uses: Sequence[Column] = (),
    key: tuple[str, ...] = (),
    no_key: str = "",
    references: Mapping[str, tuple[str, ...]] | None = None,
    caveats: str = "",
    checks: tuple[Check, ...] = (),
) -> Table:
    """A table by the names of its columns, in order, separated by blanks.

    Args:
        name: Of the table.
        description: What one row is.
        columns: Names of its columns.
        uses: The columns among them that this table narrows, or adds a note to.
        key: Columns that no two rows share.
        no_key: Why there is no key.
        references: Other tables that its rows belong to, with the columns that say so.
        caveats: What a user must know about the whole table.
        checks: Checks over several columns.

    Raises:
        KeyError: A name is not declared above.
        ValueError: A column of `uses` is not in the table.
    """
    adapted = by_name(uses)
    names = columns.split()
    if unknown := set(adapted) - set(names):
        raise ValueError(f"table {name!r} has no columns {sorted(unknown)}")
    return Table(
        name=name,
        description=description,
        columns=tuple(adapted.get(each) or COLUMNS[each] for each in names),
        key=key,
        no_key=no_key,
        references=references or {},
        caveats=caveats,
        checks=checks,
    )
