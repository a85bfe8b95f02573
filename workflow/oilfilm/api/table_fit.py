"""A law fitted to a table of mu, as a rig exports it or as it is typed from a paper.

One row is one settled reading: slide-roll ratio, speed, load or pressure, temperature and mu. There
is no time, no force and no zero, so that the gates of logs cannot check it. The Python function is
`oilfilm.fit_table`, the command `oilfilm fit`.

Decides: what the columns of a table of mu mean, and what is assumed where a unit is missing; which
law a table is fitted with.
"""

import io
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, Unpack

import numpy as np
import pandas as pd
import pyarrow

from oilfilm import tables
from oilfilm.api.arrays import ArrayFit, fit_points
from oilfilm.api.fit_keys import FitKeys
from oilfilm.api.mu_columns import (
    ColumnsError,
    StatedColumn,
    TableColumn,
    chosen_columns,
    numbers_in_unit,
    ratio_to_mean_speed,
    reading_of,
    stated_columns,
    stated_meaning_by_index,
)
from oilfilm.base.errors import OilfilmError, cut
from oilfilm.base.plain_key import plain_key
from oilfilm.base.units import PA_PER_GPA, FloatArray
from oilfilm.logs import delimited_text, opendocument, workbook
from oilfilm.logs.base import UnreadableLogError
from oilfilm.logs.header import says_simulated
from oilfilm.logs.ingest import read_bytes, unpack
from oilfilm.logs.logged_table import LoggedTable
from oilfilm.logs.meaning import WordVocabulary, label_kind_of, meaning_of
from oilfilm.logs.traction_log import TRACTION
from oilfilm.logs.workbook import SheetText, with_units_of_fractions
from oilfilm.physics.contact import max_hertz_pressure, reduced_modulus
from oilfilm.traction import LAWS, PAPER_LAW

PRESSURE = "max_hertz_pressure_gpa"
LOAD = "load_n"
SPEED = "entrainment_speed_m_s"
TEMPERATURE = "inlet_temperature_c"
SLIP = "slide_roll_ratio"
MU = "traction_coefficient"
_BALL_SPEED = "ball_speed_m_s"
_DISC_SPEED = "disc_speed_m_s"
# Young's modulus in Pa and Poisson's ratio. Steel and silicon nitride are those of bearings (Harris
# and Kotzalas, Rolling Bearing Analysis, 5th ed., 2007); the glass is Schott N-BK7.
MATERIALS = {"steel": (206e9, 0.3), "silicon-nitride": (310e9, 0.26), "glass": (82e9, 0.206)}
_POINT_COLUMNS = {PRESSURE, LOAD, SPEED, _BALL_SPEED, _DISC_SPEED, TEMPERATURE, SLIP, MU}
# Quantity and unit of each column that a table of mu may have under the project's own name.
_QUANTITY_AND_UNIT_BY_COLUMN = {
    column: quantity
    for column, quantity in TRACTION.vocabulary.quantity_and_unit_of_column.items()
    if column in _POINT_COLUMNS
}
VOCABULARY = WordVocabulary("traction", "columns", _QUANTITY_AND_UNIT_BY_COLUMN, ())
# Column of the points by the quantity that a name means.
_COLUMN_BY_QUANTITY = {
    "max_hertz_pressure": PRESSURE,
    "load": LOAD,
    "entrainment_speed": SPEED,
    "ball_speed": _BALL_SPEED,
    "disc_speed": _DISC_SPEED,
    "inlet_temperature": TEMPERATURE,
    "slide_roll_ratio": SLIP,
    "traction_coefficient": MU,
}
# Share of the points at negative slip that may have the other sign of mu: a slip of the pen.
_MAX_ODD_SIGN_SHARE = 0.2
# First bytes of a file.
_PARQUET_SIGNATURE = b"PAR1"
# Names of the laws that are fitted to a table of load or of pressure if none is named.
_LAW_NAME_OF_LOAD = "wang-deng-load"
_LAW_NAME_OF_PRESSURE = PAPER_LAW.name
_QUANTITY_IN_WORDS = {
    PRESSURE: "maximum Hertz pressure",
    LOAD: "load",
    SPEED: "entrainment speed",
    TEMPERATURE: "inlet temperature",
    MU: "traction coefficient",
}
# Example of the option of the command that gives a condition for all rows.
_OPTION_BY_COLUMN = {
    PRESSURE: "--stress 1.2GPa",
    SPEED: "--speed 2m/s",
    LOAD: "--load 50N",
    TEMPERATURE: "--temperature 40degC",
}


def fit_table(
    table: Path | str | pd.DataFrame | Any,
    *,
    ball_radius_m: float | None = None,
    materials: str = "steel,steel",
    law: str | None = None,
    oil: str | None = None,
    at: Mapping[str, float] | None = None,
    columns: str | Mapping[str, str] = "",
    simulated: bool = False,
    **settings: Unpack[FitKeys],
) -> ArrayFit:
    """Fit a traction law to a table of mu: csv, tsv, xlsx, ods, Parquet or a data frame.

    Columns are found by name and unit, in the languages that logs may have: slide-roll ratio (as
    fraction or %), mean speed or speeds of ball and disc, mu, load or maximum Hertz pressure,
    temperature; and, where there are such columns, oil and curve.

    Args:
        table: The table: a file, or a data frame of pandas, polars or another library that has the
            Arrow interface. Units are in the names or in the row below them: `speed [mm/s]`.
        ball_radius_m: Radius of the ball on a flat disc, in m: load becomes pressure.
        materials: Materials of ball and disc: steel, silicon-nitride, glass, or 206GPa:0.3.
        law: Name of the law. If not given, a law of pressure, or of load where the pressure is not
            known.
        oil: The oil to fit where the table has several oils; else the name of the oil.
        at: Conditions that hold for all rows, by their columns' names (`inlet_temperature_c`).
        columns: What columns mean where their names leave it open, as
            `{"slide_roll_ratio": "Schlupf [%], over_sum"}` or the text of `--columns`.
        simulated: Whether a program wrote the points. What is saved of the fit then says so. A
            table of oilfilm and the line `# simulated: yes` of a text say it themselves.
        settings: Keys of `fit` in config/config.yaml that differ, as `bootstrap=200`.

    Raises:
        OilfilmError: A column or a condition is missing or cannot be understood, or a number is
            impossible.

    Examples:
        A table on a known law gives its constants back:

        >>> import oilfilm
        >>> constants = [-0.01567792, 1.6654, -0.5014, -0.1065]
        >>> constants += [0.63482685, 1.2727, -0.4139, -1.2181]
        >>> constants += [24.43483717, 0.3964, 0.1591, -0.7121]
        >>> levels = [1.0, 1.25, 1.5], [25, 32, 40], [50, 80, 120], [0.01, 0.03, 0.1, 0.3]
        >>> names = ["p [GPa]", "U [m/s]", "T [degC]", "SRR"]
        >>> table = pd.MultiIndex.from_product(levels, names=names).to_frame(index=False)
        >>> at = table.to_numpy().T
        >>> table["mu"] = oilfilm.predict("deng2026", constants, *at).traction_coefficient
        >>> fitted = oilfilm.fit_table(table, searches=2, bootstrap=20)
        >>> fitted.constants["value"].round(3)[["A0", "A1"]].to_dict()
        {'A0': -0.016, 'A1': 1.665}
        >>> bool(fitted.soundness["sound"])
        True
    """
    conditions_of_all_rows = dict(at or {})
    pressure_of_load = None
    if ball_radius_m is not None:
        pressure_of_load = partial(
            pressure_gpa_of_load, ball_radius_m=ball_radius_m, materials=materials
        )
    stated_by_user = StatedByUser(
        stated_columns(columns), pressure_of_load, conditions_of_all_rows.get(SPEED)
    )
    mu_table = read_mu_table(table, stated_by_user)
    _refuse_contradiction(conditions_of_all_rows, mu_table)
    points = mu_table.points.assign(**conditions_of_all_rows)
    notes = list(mu_table.notes)
    points, oil = _points_of_oil(points, oil, mu_table.name)
    if LOAD in points and PRESSURE not in points and ball_radius_m is not None:
        points = with_pressure(points, ball_radius_m, materials)
        notes.append(f"{PRESSURE} follows from load, ball radius and materials ({materials})")
    if law is None:
        law = _LAW_NAME_OF_PRESSURE
        if LOAD in points and PRESSURE not in points:
            law = _LAW_NAME_OF_LOAD
            notes.append(
                f"law of load, {law}, because the pressure is not known; with --ball-radius and "
                "--materials a law of pressure can be fitted"
            )
    conditions = LAWS[law].conditions if law in LAWS else (PRESSURE, SPEED, TEMPERATURE)
    _refuse_missing_condition(points, conditions, mu_table)
    curve = points.pop("curve") if "curve" in points else None
    fitted = fit_points(points, conditions, law, curve, **settings)
    notes += fitted.notes
    return replace(
        fitted,
        notes=tuple(notes),
        source=mu_table.name,
        oil=oil,
        simulated=simulated or mu_table.says_simulated,
    )


def _refuse_contradiction(conditions_of_all_rows: Mapping[str, float], mu_table: "MuTable") -> None:
    """Refuse a condition of all rows that is none, or that the table has already.

    Raises:
        OilfilmError: There is such a condition.
    """
    for column in conditions_of_all_rows:
        if column not in _OPTION_BY_COLUMN:
            names = ", ".join(_OPTION_BY_COLUMN)
            raise OilfilmError(f"at: found the key {column!r}; expected some of {names}.")
        if column in mu_table.points:
            raise mu_table.error(
                f"it has the {_QUANTITY_IN_WORDS[column]}, and another one is given for all rows.",
                "Remove one of the two.",
            )


def _points_of_oil(
    points: pd.DataFrame, oil_name: str | None, table_name: str
) -> tuple[pd.DataFrame, str]:
    """The points of one oil, and its name.

    Raises:
        OilfilmError: The table lacks the oil, or has several oils and none is named.
    """
    if "oil" not in points:
        return points, oil_name or "oil"
    oil_names = sorted(points["oil"].unique())
    advice = f"Name one with --oil: {', '.join(oil_names)}."
    if oil_name is None and len(oil_names) > 1:
        raise OilfilmError(f"{table_name}: has several oils. {advice}")
    if oil_name is not None and oil_name not in oil_names:
        raise OilfilmError(f"{table_name}: has no oil {oil_name!r}. {advice}")
    oil_name = oil_name or str(oil_names[0])
    return points[points["oil"] == oil_name].drop(columns="oil"), oil_name


def _refuse_missing_condition(
    points: pd.DataFrame, condition_names: tuple[str, ...], mu_table: "MuTable"
) -> None:
    """Refuse a table without a condition that the law needs.

    Raises:
        OilfilmError: A column is missing.
    """
    for column in (*condition_names, MU):
        if column not in points:
            columns_in_words = cut(", ".join(map(repr, mu_table.column_names)))
            sentence = (
                f"{mu_table.name}: no column is the {_QUANTITY_IN_WORDS[column]}; its columns "
                f"are {columns_in_words}. Add it, or give it for "
                f"all rows, as {_OPTION_BY_COLUMN.get(column, '')}."
            )
            if column == PRESSURE:
                sentence += " Where it has the load, give --ball-radius and --materials."
            raise OilfilmError(sentence)


# ---------------------------------------------------------------- the table


@dataclass
class MuTable:
    """A table of mu after reading.

    Attributes:
        name: Name of the table in messages.
        points: Conditions, slip and mu by their columns' names; `oil` and `curve` where the table
            has them. Pressure or load may be missing.
        notes: Meaning of each column, and how it is known, in sentences.
        column_names: Names of all columns.
        says_simulated: Whether the table says that a program wrote it.
    """

    name: str
    points: pd.DataFrame = field(default_factory=pd.DataFrame)
    notes: list[str] = field(default_factory=list)
    column_names: Sequence[str] = ()
    says_simulated: bool = False

    def error(self, problem: str, advice: str) -> OilfilmError:
        """The error of a table that cannot be used.

        Args:
            problem: What was found and what was expected, as a sentence after the name.
            advice: What to do.
        """
        return OilfilmError(f"{self.name}: {problem} {advice}")


@dataclass(frozen=True)
class StatedByUser:
    """What the user says beside a table of mu.

    Attributes:
        columns: The columns of which the user says what they are.
        pressure_of_load: Function of loads in N, which returns their maximum Hertz pressure in GPa;
            None where the contact is not known.
        speed_m_s: Mean speed of all rows; None where the table has it.
    """

    columns: Sequence[StatedColumn] = ()
    pressure_of_load: Callable[[FloatArray], FloatArray] | None = None
    speed_m_s: float | None = None


def read_mu_table(
    table: Path | str | pd.DataFrame | Any, stated_by_user: StatedByUser | None = None
) -> MuTable:
    """Read csv, tsv, xlsx, ods or Parquet, or a data frame.

    Args:
        table: The table.
        stated_by_user: What the user says of it; None if nothing.

    Raises:
        OilfilmError: A column is missing, doubtful or without a unit, or a number is impossible.
    """
    if not isinstance(table, (str, Path)):
        table_name = "the data frame"
        sheets = [SheetText("", _tab_separated(_as_pandas(table)))]
    else:
        table_name = str(table)
        sheets = _sheets_of_file(Path(table), MuTable(table_name))
    statements = stated_by_user or StatedByUser()
    read_sheets: list[_TitledTable] = []
    fault_by_title: dict[str, OilfilmError] = {}
    for sheet in sheets:
        try:
            sheet_table = _table_of_sheet(sheet, MuTable(table_name), statements)
            read_sheets.append(_TitledTable(sheet.title, sheet_table))
        except OilfilmError as error:
            fault_by_title[sheet.title] = error
    if not read_sheets:
        # no sheet is a table: the one with the most text comes nearest to one
        longest_sheet = max(sheets, key=lambda sheet: len(sheet.text))
        raise fault_by_title[longest_sheet.title]
    mu_table = read_sheets[0].table
    if len(read_sheets) > 1:
        mu_table = _joined_sheets(read_sheets, MuTable(table_name))
    elif fault_by_title:
        mu_table.notes.append(f"the sheet {read_sheets[0].title!r} is read")
    mu_table.says_simulated = _is_simulated_by_footer(table) or any(
        read_sheet.table.says_simulated for read_sheet in read_sheets
    )
    for title, fault in fault_by_title.items():
        reason = str(fault).removeprefix(f"{table_name}: ")
        mu_table.notes.append(f"the sheet {title!r} is not read: {cut(reason)}")
    return mu_table


def _is_simulated_by_footer(table: Any) -> bool:
    """Whether a table is a file of oilfilm whose footer says that its data are simulated."""
    if not isinstance(table, (str, Path)):
        return False
    with suppress(OilfilmError):
        return bool(tables.read_footer(Path(table)).get("data") == "simulated")
    return False


def _as_pandas(table: Any) -> pd.DataFrame:
    """A data frame of any library as one of pandas.

    Raises:
        OilfilmError: It is no data frame.
    """
    if isinstance(table, pd.DataFrame):
        return table
    # the interface by which polars, pyarrow, DuckDB and others hand over tables
    if not hasattr(table, "__arrow_c_stream__"):
        raise OilfilmError(
            f"fit_table: found a {type(table).__name__}; expected the path of a file, or a data "
            "frame of pandas or polars. For arrays use `oilfilm.fit`."
        )
    converted: pd.DataFrame = pyarrow.table(table).to_pandas()
    return converted


class _TitledTable(NamedTuple):
    """A sheet of a workbook as a table, or another file, whose title is empty."""

    title: str
    table: MuTable


def _joined_sheets(sheets: Sequence[_TitledTable], joined_table: MuTable) -> MuTable:
    """One table of several sheets. Where a sheet names no oil, its title does.

    Args:
        sheets: The tables of the sheets.
        joined_table: An empty table, which is filled and returned.

    Raises:
        OilfilmError: The sheets have different columns.
    """
    columns_by_title: dict[str, set[str]] = {}
    for title, sheet in sheets:
        columns_by_title[title] = set(map(str, sheet.points)) - {"oil"}
    if len(set(map(frozenset, columns_by_title.values()))) > 1:
        columns_in_words = "; ".join(
            f"{title!r}: {', '.join(sorted(names))}" for title, names in columns_by_title.items()
        )
        raise joined_table.error(
            f"its sheets have different columns: {columns_in_words}.",
            "Give all sheets the same columns, or save the sheet to be fitted alone.",
        )
    frames: list[pd.DataFrame] = []
    for title, sheet in sheets:
        points = sheet.points
        if "oil" not in points:
            points = points.assign(oil=title)
        if "curve" in points:
            points = points.assign(curve=title + " " + points["curve"])
        frames.append(points)
    joined_table.points = pd.concat(frames, ignore_index=True)
    titles = ", ".join(repr(title) for title, _ in sheets)
    joined_table.column_names = sheets[0].table.column_names
    joined_table.notes = [*sheets[0].table.notes, f"the sheets {titles} are read"]
    for _, sheet in sheets[1:]:
        joined_table.notes += [note for note in sheet.notes if note not in joined_table.notes]
    return joined_table


def _table_of_sheet(sheet: SheetText, mu_table: MuTable, stated_by_user: StatedByUser) -> MuTable:
    """The table in a sheet, of all blocks that repeat the line of names.

    Args:
        sheet: The sheet; a file that is no workbook is one.
        mu_table: An empty table, which is filled and returned.
        stated_by_user: What the user says of the columns.

    Raises:
        OilfilmError: As by `read_mu_table`.
    """
    try:
        stated_meaning_of_name = dict(
            reading for column in stated_by_user.columns for reading in column.readings
        )
        vocabulary = replace(VOCABULARY, stated_meaning_of_name=stated_meaning_of_name)
        _, logged_tables = delimited_text.tables(sheet.text, vocabulary)
    except UnreadableLogError as error:
        advice = "Write one line of names above the rows: slide_roll_ratio and mu among them."
        raise mu_table.error(f"{error.refusal.reason}.", advice) from None
    frames: list[pd.DataFrame] = []
    notes: list[str] = []
    for table_as_text in logged_tables:
        logged_table = with_units_of_fractions(table_as_text, sheet.fraction_columns)
        mu_table.notes = list(logged_table.notes)
        mu_table.column_names = logged_table.names
        mu_table.says_simulated |= says_simulated(logged_table.text_of_key)
        mu_table.points = pd.DataFrame()
        name_by_quantity = _add_points(mu_table, logged_table, stated_by_user)
        _add_labels(mu_table, logged_table, name_by_quantity.values())
        frames.append(mu_table.points)
        notes += [note for note in mu_table.notes if note not in notes]
    mu_table.points = pd.concat(frames, ignore_index=True)
    mu_table.notes = notes
    return _without_gaps(mu_table)


def _add_labels(mu_table: MuTable, logged_table: LoggedTable, read_names: Iterable[str]) -> None:
    """Add the columns of text, `oil` and `curve`, where the table has them.

    Args:
        mu_table: The table, which gets the columns.
        logged_table: What was read.
        read_names: Names of the columns that are quantities.
    """
    if logged_table.read_texts is None:
        return
    # columns without a name are no labels
    names_in_use = {plain_key(name) for name in read_names} | {""}
    for label_column in ("oil", "curve"):
        column_index = _index_of_label(logged_table.names, label_column, names_in_use)
        if column_index is None:
            continue
        labels = logged_table.read_texts(column_index)
        if any(labels):
            mu_table.points[label_column] = labels


def _index_of_label(
    column_names: Sequence[str], label_column: str, names_in_use: set[str]
) -> int | None:
    """Index of the first free column whose name is that of a label; None if there is none."""
    for index, column_name in enumerate(column_names):
        if (
            label_kind_of(column_name) == label_column
            and plain_key(column_name) not in names_in_use
        ):
            return index
    return None


def _sheets_of_file(path: Path, mu_table: MuTable) -> list[SheetText]:
    """Each sheet of a workbook; another file is one sheet without a title.

    Raises:
        OilfilmError: The file cannot be read.
    """
    content = unpack(read_bytes(path))
    try:
        if content.startswith(_PARQUET_SIGNATURE):
            return [SheetText("", _tab_separated(pd.read_parquet(io.BytesIO(content))))]
        if content.startswith(workbook.ZIP_SIGNATURE):
            is_opendocument = opendocument.recognises(content)
            reader = opendocument if is_opendocument else workbook
            sheets = reader.sheet_texts(content)
            if not sheets:
                raise ValueError("no sheet has a cell")
            return sheets
    except Exception as error:
        reason = f"cannot be read ({cut(' '.join(str(error).split()))})."
        raise mu_table.error(reason, "Export it again, or as csv.") from error
    return [SheetText("", content)]


def _tab_separated(frame: pd.DataFrame) -> bytes:
    """A data frame as text with tabs between the cells, as a file would have it."""
    return frame.to_csv(sep="\t", index=False).encode()


def _add_points(
    mu_table: MuTable, logged_table: LoggedTable, stated_by_user: StatedByUser
) -> dict[str, str]:
    """Add the numbers of what was read to a table, and notes on the meaning of its columns.

    Returns:
        The name of the column of each quantity.

    Raises:
        OilfilmError: A meaning is not known, or mu or the slide-roll ratio is missing.
    """
    names, units = logged_table.names, logged_table.units
    try:
        stated_by_index = stated_meaning_by_index(names, units, stated_by_user.columns)
    except ColumnsError as error:
        raise mu_table.error(error.sentence, error.advice) from None
    column_indices = [
        index
        for index, (name, unit) in enumerate(zip(names, units, strict=True))
        if index in stated_by_index or meaning_of(name, unit) is not None
    ]
    values_of_columns = zip(column_indices, logged_table.read_values(column_indices), strict=True)
    numbers_by_index = {
        index: np.asarray(values, dtype=float)
        for index, values in values_of_columns
        if values.dtype.kind in "iuf"
    }
    try:
        column_by_quantity, notes = chosen_columns(names, units, numbers_by_index, stated_by_index)
        column_by_quantity = {
            quantity: column
            for quantity, column in column_by_quantity.items()
            if quantity in _COLUMN_BY_QUANTITY
        }
        has_mean_speed = (
            "entrainment_speed" in column_by_quantity or stated_by_user.speed_m_s is not None
        )
        notes += _remove_blank(column_by_quantity, has_mean_speed=has_mean_speed)
        notes += _remove_doubtful(column_by_quantity)
        _refuse_without_mu_or_slip(mu_table, names, column_by_quantity)
        pressure_gpa = None
        if "load" in column_by_quantity and stated_by_user.pressure_of_load is not None:
            load_n = numbers_in_unit(column_by_quantity["load"])
            pressure_gpa = stated_by_user.pressure_of_load(load_n)
        notes = [*mu_table.notes, *notes]
        reading = reading_of(column_by_quantity, notes, pressure_gpa, stated_by_user.speed_m_s)
    except ColumnsError as error:
        raise mu_table.error(error.sentence, error.advice) from None
    mu_table.notes = list(reading.notes)
    points = mu_table.points
    for quantity, numbers in reading.numbers_by_quantity.items():
        points[_COLUMN_BY_QUANTITY[quantity]] = numbers
    if {_BALL_SPEED, _DISC_SPEED} <= set(points):
        ball_m_s = points.pop(_BALL_SPEED)
        disc_m_s = points.pop(_DISC_SPEED)
        if SPEED not in points:
            points[SPEED] = (ball_m_s + disc_m_s) / 2
        if SLIP not in points:
            points[SLIP] = ratio_to_mean_speed(
                (disc_m_s - ball_m_s).to_numpy(), points[SPEED].to_numpy()
            )
    return dict(reading.name_by_quantity)


def _remove_blank(column_by_quantity: dict[str, TableColumn], *, has_mean_speed: bool) -> list[str]:
    """Remove blank columns of speed or slip that follow from the others.

    These are mean speed and slip where the speeds of ball and disc hold numbers, and the speeds of
    ball and disc where slip and mean speed are given. Other blank columns stay: a message then says
    that no row has all its numbers.

    Returns:
        Notes on the removed columns.
    """
    both_speeds = ("ball_speed", "disc_speed")
    removable_quantities: tuple[str, ...] = ()
    if all(
        quantity in column_by_quantity and not column_by_quantity[quantity].is_blank
        for quantity in both_speeds
    ):
        removable_quantities = ("entrainment_speed", "slide_roll_ratio")
    elif has_mean_speed and "slide_roll_ratio" in column_by_quantity:
        removable_quantities = both_speeds
    notes: list[str] = []
    for quantity in removable_quantities:
        column = column_by_quantity.get(quantity)
        if column is not None and column.is_blank:
            del column_by_quantity[quantity]
            notes.append(f"not read: {column.name!r}: it holds no numbers")
    return notes


def _remove_doubtful(column_by_quantity: dict[str, TableColumn]) -> list[str]:
    """Remove columns that only may be a quantity that the table has in another way.

    A force that may be the load is not asked about beside a pressure, nor a speed beside those of
    both bodies.

    Returns:
        Notes on the removed columns.
    """
    quantities_in_place_of = {
        "load": {"max_hertz_pressure"},
        "entrainment_speed": {"ball_speed", "disc_speed"},
    }
    notes: list[str] = []
    for quantity, other_quantities in quantities_in_place_of.items():
        column = column_by_quantity.get(quantity)
        has_others = other_quantities <= column_by_quantity.keys()
        if column is not None and column.meaning.question and has_others:
            del column_by_quantity[quantity]
            notes.append(f"not read: {column.name!r}: {column.meaning.question}")
    return notes


def _refuse_without_mu_or_slip(
    mu_table: MuTable, column_names: Sequence[str], column_by_quantity: Mapping[str, TableColumn]
) -> None:
    """Refuse a table without mu or without a slide-roll ratio.

    Raises:
        OilfilmError: One of them is missing.
    """
    needed_quantities = ["traction_coefficient"]
    if not {"ball_speed", "disc_speed"} <= column_by_quantity.keys():
        needed_quantities.append("slide_roll_ratio")
    missing_quantities = [
        quantity for quantity in needed_quantities if quantity not in column_by_quantity
    ]
    if missing_quantities:
        quantities_in_words = " and the ".join(
            quantity.replace("_", " ") for quantity in missing_quantities
        )
        columns_in_words = ", ".join(map(repr, column_names)) or "not known"
        raise mu_table.error(
            f"no column is the {quantities_in_words}; its columns are {cut(columns_in_words)}.",
            f'Name it in the table, or here: --columns "{missing_quantities[0]}=NAME".',
        )


def _without_gaps(mu_table: MuTable) -> MuTable:
    """The table with its complete rows and positive slip; a note counts the other rows.

    Raises:
        OilfilmError: No row is complete.
    """
    numbers = mu_table.points.select_dtypes("number").to_numpy(dtype=float)
    is_complete = np.isfinite(numbers).all(axis=1)
    incomplete_count = int(np.sum(~is_complete))
    if incomplete_count:
        mu_table.notes.append(
            f"{incomplete_count} of {len(is_complete)} rows are left out: a number is missing there"
        )
    points = mu_table.points.loc[is_complete].reset_index(drop=True)
    if points.empty:
        advice = "Look at decimal marks and empty cells."
        raise mu_table.error("no row has all its numbers.", advice)
    _refuse_unlabelled(points, mu_table)
    mu_table.points = _at_positive_slip(points, mu_table)
    return mu_table


def _refuse_unlabelled(points: pd.DataFrame, mu_table: MuTable) -> None:
    """Refuse rows without an oil or a curve where other rows have one.

    Raises:
        OilfilmError: There is such a row.
    """
    for label_column in ("oil", "curve"):
        if label_column not in points:
            continue
        is_unlabelled = points[label_column].isna() | (points[label_column] == "")
        if is_unlabelled.any():
            first_row = points.loc[is_unlabelled].iloc[0]
            raise mu_table.error(
                f"{int(is_unlabelled.sum())} of {len(points)} rows name no {label_column}, the "
                f"first is that of S = {first_row[SLIP]:g} and mu = {first_row[MU]:g}.",
                f"Write the {label_column} into each row, also below merged cells; or remove the "
                "column.",
            )


def _at_positive_slip(points: pd.DataFrame, mu_table: MuTable) -> pd.DataFrame:
    """The points at positive slip: the law is odd. A point of the rarer sign of mu is left out.

    A table has mu with the sign of the slip, or without it. Most of its points at negative slip
    tell which. The sign of the others contradicts them.

    Raises:
        OilfilmError: Both signs are frequent, or mu is negative at positive slip.
    """
    is_backwards = points[SLIP] < 0
    is_forwards = points[SLIP] > 0
    is_negative = points[MU] < 0
    reversed_count = int((is_forwards & is_negative).sum())
    if 2 * reversed_count > is_forwards.sum():
        raise mu_table.error(
            f"of {int(is_forwards.sum())} rows at positive slip {reversed_count} have a negative "
            "mu.",
            "Reverse the sign of the force, or that of the slip.",
        )
    backwards_count = int(is_backwards.sum())
    negative_count = int((is_backwards & is_negative).sum())
    if backwards_count == 0:
        return points
    mu_has_sign = 2 * negative_count > backwards_count
    has_odd_sign = is_backwards & (is_negative != mu_has_sign) & (points[MU] != 0)
    odd_count = int(has_odd_sign.sum())
    if odd_count > _MAX_ODD_SIGN_SHARE * backwards_count:
        raise mu_table.error(
            f"of {backwards_count} rows at negative slip {negative_count} have a negative mu.",
            "Give mu the sign of the slip in all rows, or in none.",
        )
    if odd_count:
        odd_point = points.loc[has_odd_sign].iloc[0]
        convention = "has the sign of the slip" if mu_has_sign else "has no sign"
        mu_table.notes.append(
            f"{odd_count} of {len(points)} rows are left out: at negative slip mu "
            f"{convention} in the other rows, and here it is {odd_point[MU]:g} "
            f"at S = {odd_point[SLIP]:g}"
        )
    turned_points = points.assign(**{SLIP: points[SLIP].abs()})
    if mu_has_sign:
        turned_points.loc[is_backwards, MU] *= -1
    return turned_points.loc[~has_odd_sign].reset_index(drop=True)


def with_pressure(points: pd.DataFrame, ball_radius_m: float, materials: str) -> pd.DataFrame:
    """Points with the maximum Hertz pressure of their load on a ball and a flat disc.

    Args:
        points: Points with the column `load_n`.
        ball_radius_m: Radius of the ball, in m.
        materials: Materials of ball and disc, as `steel,glass` or `206GPa:0.3,steel`.

    Raises:
        OilfilmError: A material is not known.

    Examples:
        20 N on a steel ball of 9.525 mm, against steel: 0.818 GPa by hand with E' = 226.4 GPa.

        >>> points = pd.DataFrame({"load_n": [20.0]})
        >>> with_pressure(points, 9.525e-3, "steel,steel")["max_hertz_pressure_gpa"].round(3)[0]
        np.float64(0.818)
    """
    pressure_gpa = pressure_gpa_of_load(points[LOAD].to_numpy(), ball_radius_m, materials)
    return points.assign(**{PRESSURE: pressure_gpa})


def pressure_gpa_of_load(load_n: FloatArray, ball_radius_m: float, materials: str) -> FloatArray:
    """Maximum Hertz pressure in GPa of loads in N on a ball and a flat disc, shape (rows,).

    Raises:
        OilfilmError: A material is not known.
    """
    try:
        ball_material, disc_material = materials.split(",")
        ball_modulus_pa, ball_poisson_ratio = _elastic_constants(ball_material.strip())
        disc_modulus_pa, disc_poisson_ratio = _elastic_constants(disc_material.strip())
    except (KeyError, ValueError):
        raise OilfilmError(
            f"--materials: found {materials!r}; expected ball,disc, as steel,glass, each one of "
            f"{', '.join(MATERIALS)}, or Young's modulus and Poisson's ratio, as 206GPa:0.3."
        ) from None
    modulus_pa = reduced_modulus(
        ball_modulus_pa, ball_poisson_ratio, disc_modulus_pa, disc_poisson_ratio
    )
    return np.asarray(max_hertz_pressure(load_n, ball_radius_m, modulus_pa) / PA_PER_GPA)


def _elastic_constants(material: str) -> tuple[float, float]:
    """Young's modulus in Pa and Poisson's ratio of a material, by name or as 206GPa:0.3."""
    if ":" in material:
        modulus_gpa, _, poisson_ratio = material.partition(":")
        return float(modulus_gpa.removesuffix("GPa")) * PA_PER_GPA, float(poisson_ratio)
    return MATERIALS[material]
