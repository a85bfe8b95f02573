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
from typing import Any, Unpack

import numpy as np
import pandas as pd
import pyarrow
import pyarrow.parquet

from oilfilm import tables
from oilfilm.api.arrays import ArrayFit, fit_points, refuse_unknown_law
from oilfilm.api.fit_keys import FitKeys
from oilfilm.api.mu_columns import (
    ColumnsError,
    StatedColumn,
    TableColumn,
    chosen_columns,
    contradict,
    numbers_in_unit,
    numbers_of_table,
    slide_roll_ratio_of_speeds,
    stated_columns,
    stated_meaning_by_index,
)
from oilfilm.base.errors import OilfilmError, cut
from oilfilm.base.plain_key import plain_key
from oilfilm.base.units import PA_PER_GPA, BoolArray, FloatArray
from oilfilm.fits.fitted import in_column_unit
from oilfilm.logs import delimited_text, opendocument, workbook
from oilfilm.logs.base import UnreadableLogError
from oilfilm.logs.header import says_simulated
from oilfilm.logs.ingest import read_bytes, unpack
from oilfilm.logs.logged_table import LoggedTable
from oilfilm.logs.meaning import Meaning, WordVocabulary, label_kind_of, meaning_of
from oilfilm.logs.traction_log import TRACTION
from oilfilm.logs.workbook import SheetText, with_units_of_fractions
from oilfilm.physics.contact import max_hertz_pressure
from oilfilm.settings import quantities as q
from oilfilm.settings.base import Group, key
from oilfilm.settings.messages import validated
from oilfilm.settings.rig import Elasticity
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
    column: quantity_and_unit
    for column, quantity_and_unit in TRACTION.vocabulary.quantity_and_unit_of_column.items()
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
# Share of the points at negative slip, or at positive slip, that may have the wrong sign of mu, as
# after a typing error.
_MAX_WRONG_SIGN_SHARE = 0.2
# Noise may give mu the wrong sign where it is at most this share of the median mu of the table.
_NOISE_SHARE = 0.1
# Column of the points of a campaign: whether the gates accept the point.
_ACCEPTED = "accepted"
# Characters that separate or quote the cells of a text, and the characters of Unicode's private use
# that stand for them in the text of a data frame; and the way back. Both are for `str.translate`.
_PRIVATE_CHARACTERS = {ord(separator): 0xE000 + ord(separator) for separator in '\t\n\r"'}
_SEPARATORS = {private: separator for separator, private in _PRIVATE_CHARACTERS.items()}
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
    at: Mapping[str, Any] | None = None,
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
            Arrow interface. Units are in the names or in the row below them: `speed [mm/s]`. An
            index of pandas that has a name is a column.
        ball_radius_m: Radius of the ball on a flat disc, in m: load becomes pressure.
        materials: Materials of ball and disc: steel, silicon-nitride, glass, or 206GPa:0.3.
        law: Name of the law. If not given, a law of pressure, or of load where the pressure is not
            known.
        oil: The oil to fit where the table has several oils; else the name of the oil.
        at: Conditions that hold for all rows, by their columns' names (`inlet_temperature_c`):
            numbers in the unit of the column, or quantities of pint.
        columns: What columns mean where their names leave it open, as
            `{"slide_roll_ratio": "Schlupf [%], over_sum"}` or the text of `--columns`.
        simulated: Whether a program wrote the points. What is saved of the fit then says so. A
            Parquet table of oilfilm and the line `# simulated: yes` of a text say it themselves.
        settings: Keys of `fit` in config/config.yaml that differ, as `bootstrap=200`.

    Raises:
        OilfilmError: There is no such law; a column or a condition is missing or cannot be
            understood; or a number is impossible.

    Examples:
        A table on a known law gives its constants back:

        >>> import oilfilm
        >>> constants = [-0.01567792, 1.6654, -0.5014, -0.1065]
        >>> constants += [0.63482685, 1.2727, -0.4139, -1.2181]
        >>> constants += [24.43483717, 0.3964, 0.1591, -0.7121]
        >>> levels = [1.0, 1.25, 1.5], [25, 32, 40], [50, 80, 120], [0.01, 0.03, 0.1, 0.3]
        >>> names = ["p [GPa]", "U [m/s]", "T [degC]", "SRR"]
        >>> table = pd.MultiIndex.from_product(levels, names=names).to_frame(index=False)
        >>> columns = table.to_numpy().T
        >>> table["mu"] = oilfilm.predict("deng2026", constants, *columns).traction_coefficient
        >>> fitted = oilfilm.fit_table(table, searches=2, bootstrap=20)
        >>> fitted.constants["value"].round(3)[["A0", "A1"]].to_dict()
        {'A0': -0.016, 'A1': 1.665}
        >>> bool(fitted.soundness["sound"])
        True
    """
    if law is not None:
        refuse_unknown_law(law, LAWS)
    conditions_of_all_rows = _conditions_of_all_rows(at or {})
    pressure_of_load = None
    if ball_radius_m is not None:
        pressure_of_load = partial(
            pressure_gpa_of_load, ball_radius_m=ball_radius_m, materials=materials
        )
    stated_by_user = StatedByUser(
        stated_columns(columns), pressure_of_load, conditions_of_all_rows.get(SPEED)
    )
    mu_table = read_mu_table(table, stated_by_user)
    _refuse_conditions_given_twice(conditions_of_all_rows, mu_table)
    points = mu_table.points.assign(**conditions_of_all_rows)
    points, oil = _points_of_oil(points, oil, mu_table.name)
    if LOAD in points and pressure_of_load is not None:
        pressure_by_load_gpa = pressure_of_load(points[LOAD].to_numpy(float))
        if PRESSURE in points:
            _refuse_other_pressure(points, pressure_by_load_gpa, mu_table)
        else:
            points[PRESSURE] = pressure_by_load_gpa
            mu_table.notes.append(
                f"{PRESSURE} follows from load, ball radius and materials ({materials})"
            )
    if law is None:
        law = _LAW_NAME_OF_PRESSURE
        if LOAD in points and PRESSURE not in points:
            law = _LAW_NAME_OF_LOAD
            mu_table.notes.append(
                f"law of load, {law}, because the pressure is not known; with --ball-radius and "
                "--materials a law of pressure can be fitted"
            )
    conditions = LAWS[law].conditions
    _refuse_missing_condition(points, conditions, mu_table)
    # rows may have the load alone or the pressure alone
    points = _complete_rows(points, _has_numbers(points, conditions), mu_table)
    curve = points.pop("curve") if "curve" in points else None
    fitted = fit_points(points, conditions, law, curve, **settings)
    return replace(
        fitted,
        notes=(*mu_table.notes, *fitted.notes),
        source=mu_table.name,
        oil=oil,
        simulated=simulated or mu_table.says_simulated,
    )


def _conditions_of_all_rows(at: Mapping[str, Any]) -> dict[str, float]:
    """The conditions that the caller gives for all rows, by their columns' names.

    Raises:
        OilfilmError: A key is no condition, or a value is not one possible number.
    """
    value_by_column: dict[str, float] = {}
    for column, value in at.items():
        if column not in _OPTION_BY_COLUMN:
            names = ", ".join(_OPTION_BY_COLUMN)
            raise OilfilmError(f"at: found the key {column!r}; expected some of {names}.")
        numbers = in_column_unit(value, column)
        if numbers.size != 1 or not np.isfinite(numbers).all():
            raise OilfilmError(f"at: {column}: found {cut(repr(value))}; expected one number.")
        value_by_column[column] = float(numbers.item())
    return value_by_column


def _refuse_conditions_given_twice(
    conditions_of_all_rows: Mapping[str, float], mu_table: "MuTable"
) -> None:
    """Refuse a condition of all rows that the table has already.

    Raises:
        OilfilmError: There is such a condition.
    """
    for column in conditions_of_all_rows:
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
    for column in condition_names:
        if column not in points:
            columns_in_words = cut(", ".join(map(repr, mu_table.column_names)))
            sentence = (
                f"{mu_table.name}: no column is the {_QUANTITY_IN_WORDS[column]}; its columns "
                f"are {columns_in_words}. Add it, or give it for "
                f"all rows, as {_OPTION_BY_COLUMN[column]}."
            )
            if column == PRESSURE:
                sentence += " Where it has the load, give --ball-radius and --materials."
            raise OilfilmError(sentence)


def _refuse_other_pressure(
    points: pd.DataFrame, pressure_by_load_gpa: FloatArray, mu_table: "MuTable"
) -> None:
    """Refuse a maximum Hertz pressure that contradicts load, ball radius and materials.

    Raises:
        OilfilmError: It contradicts them.
    """
    pressure_gpa = points[PRESSURE].to_numpy(float)
    if contradict(pressure_gpa, pressure_by_load_gpa):
        factor = float(np.nanmedian(pressure_gpa / pressure_by_load_gpa))
        raise mu_table.error(
            f"the maximum Hertz pressure is {factor:.3g} times that of the load with this ball "
            "radius and these materials.",
            "Correct the radius, the materials, the load or the pressure.",
        )


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
        title: Title of its sheet; empty for all sheets together, and for another file.
    """

    name: str
    points: pd.DataFrame = field(default_factory=pd.DataFrame)
    notes: list[str] = field(default_factory=list)
    column_names: Sequence[str] = ()
    says_simulated: bool = False
    title: str = ""

    def without_rows(
        self, points: pd.DataFrame, is_left_out: BoolArray, reason: str
    ) -> pd.DataFrame:
        """Points without some rows; a note counts these.

        Args:
            points: Points of the table.
            is_left_out: Mask of the rows, shape (rows,).
            reason: Why they are left out.
        """
        if is_left_out.any():
            self.note_on_rows(
                f"{int(is_left_out.sum())} of {len(points)} rows are left out: {reason}"
            )
        return points.loc[~is_left_out].reset_index(drop=True)

    def note_on_rows(self, sentence: str) -> None:
        """Add a note on some rows; where the table is a sheet, it names the sheet."""
        self.notes.append(f"sheet {self.title!r}: {sentence}" if self.title else sentence)

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
    if isinstance(table, (str, Path)):
        table_name = str(table)
        sheets = _sheets_of_file(Path(table), MuTable(table_name))
    else:
        table_name = "the data frame"
        sheets = [SheetText("", _text_of_frame(table))]
    statements = stated_by_user or StatedByUser()
    read_tables: list[MuTable] = []
    fault_by_title: dict[str, OilfilmError] = {}
    for sheet in sheets:
        try:
            empty_table = MuTable(table_name, title=sheet.title)
            read_tables.append(_table_of_sheet(sheet, empty_table, statements))
        except OilfilmError as error:
            fault_by_title[sheet.title] = error
    if not read_tables:
        # no sheet is a table: the one with the most text comes nearest to one
        longest_sheet = max(sheets, key=lambda sheet: len(sheet.text))
        raise fault_by_title[longest_sheet.title]
    mu_table = read_tables[0]
    if len(read_tables) > 1:
        mu_table = _joined_sheets(read_tables, MuTable(table_name))
    elif fault_by_title:
        mu_table.notes.append(f"the sheet {mu_table.title!r} is read")
    for title, fault in fault_by_title.items():
        reason = str(fault).removeprefix(f"{table_name}: ")
        mu_table.notes.append(f"the sheet {title!r} is not read: {cut(reason)}")
    return mu_table


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


def _joined_sheets(sheets: Sequence[MuTable], joined_table: MuTable) -> MuTable:
    """One table of several sheets. Where a sheet names no oil, its title does.

    Args:
        sheets: The tables of the sheets.
        joined_table: An empty table, which is filled and returned.

    Raises:
        OilfilmError: The sheets have different columns.
    """
    columns_by_title: dict[str, set[str]] = {}
    for sheet in sheets:
        columns_by_title[sheet.title] = set(map(str, sheet.points)) - {"oil"}
    if len(set(map(frozenset, columns_by_title.values()))) > 1:
        columns_in_words = "; ".join(
            f"{title!r}: {', '.join(sorted(names))}" for title, names in columns_by_title.items()
        )
        raise joined_table.error(
            f"its sheets have different columns: {columns_in_words}.",
            "Give all sheets the same columns, or save the sheet to be fitted alone.",
        )
    frames: list[pd.DataFrame] = []
    for sheet in sheets:
        points = sheet.points
        if "oil" not in points:
            points = points.assign(oil=sheet.title)
        if "curve" in points:
            points = points.assign(curve=sheet.title + " " + points["curve"])
        frames.append(points)
        joined_table.notes += [note for note in sheet.notes if note not in joined_table.notes]
    joined_table.points = pd.concat(frames, ignore_index=True)
    joined_table.column_names = sheets[0].column_names
    joined_table.says_simulated = any(sheet.says_simulated for sheet in sheets)
    titles = ", ".join(repr(sheet.title) for sheet in sheets)
    joined_table.notes.append(f"the sheets {titles} are read")
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
        stated_meaning_of_name: dict[str, Meaning] = {}
        for column in stated_by_user.columns:
            stated_meaning_of_name |= column.meaning_by_name
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
    return _with_usable_rows(mu_table)


def _add_labels(mu_table: MuTable, logged_table: LoggedTable, read_names: Iterable[str]) -> None:
    """Add the columns of text, `oil`, `curve` and `accepted`, where the table has them.

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
        texts = logged_table.read_texts(column_index)
        labels = [text.translate(_SEPARATORS) for text in texts]
        if any(labels):
            mu_table.points[label_column] = labels
    if _ACCEPTED in logged_table.names:
        column_index = list(logged_table.names).index(_ACCEPTED)
        mu_table.points[_ACCEPTED] = logged_table.read_texts(column_index)


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
            return [SheetText("", _text_of_frame(pyarrow.parquet.read_table(io.BytesIO(content))))]
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


def _text_of_frame(table: Any) -> bytes:
    """A data frame as text with tabs between the cells, as a file would have it.

    Raises:
        OilfilmError: It is no data frame.
    """
    frame = _as_pandas(table)
    if any(name is not None for name in frame.index.names):
        frame = frame.reset_index(allow_duplicates=True)
    frame = frame.rename(columns=lambda name: " ".join(str(name).split()))
    for index, column_type in enumerate(frame.dtypes):
        if not pd.api.types.is_numeric_dtype(column_type):
            frame.isetitem(index, frame.iloc[:, index].map(_without_separators).array)
    text = frame.to_csv(sep="\t", index=False)
    if _is_simulated_by_footer(table):
        text = f"# simulated: yes\n{text}"
    return text.encode()


def _without_separators(cell: Any) -> Any:
    """A cell in which no character separates or quotes cells, or cannot be written as UTF-8."""
    if not isinstance(cell, str):
        return cell
    return cell.translate(_PRIVATE_CHARACTERS).encode(errors="backslashreplace").decode()


def _is_simulated_by_footer(table: Any) -> bool:
    """Whether a table is one of oilfilm whose footer says that its data are simulated."""
    if not isinstance(table, pyarrow.Table):
        return False
    with suppress(OilfilmError):
        return bool(tables.footer_of(table.schema, "the table").get("data") == "simulated")
    return False


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
        if index in stated_by_index or _is_needed(meaning_of(name, unit))
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
        table_numbers = numbers_of_table(
            column_by_quantity, notes, pressure_gpa, stated_by_user.speed_m_s
        )
    except ColumnsError as error:
        raise mu_table.error(error.sentence, error.advice) from None
    mu_table.notes = list(table_numbers.notes)
    points = mu_table.points
    for quantity, numbers in table_numbers.numbers_by_quantity.items():
        points[_COLUMN_BY_QUANTITY[quantity]] = numbers
    if {_BALL_SPEED, _DISC_SPEED} <= set(points):
        ball_m_s = points.pop(_BALL_SPEED)
        disc_m_s = points.pop(_DISC_SPEED)
        if SPEED not in points:
            points[SPEED] = (ball_m_s + disc_m_s) / 2
        if SLIP not in points:
            points[SLIP] = slide_roll_ratio_of_speeds(
                (disc_m_s - ball_m_s).to_numpy(), points[SPEED].to_numpy()
            )
    return dict(table_numbers.name_by_quantity)


def _is_needed(meaning: Meaning | None) -> bool:
    """Whether a column is a quantity of points; two columns of time, as an example, ask nothing."""
    return meaning is not None and meaning.quantity in _COLUMN_BY_QUANTITY


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


def _with_usable_rows(mu_table: MuTable) -> MuTable:
    """The table with its complete rows and positive slip; a note counts the other rows.

    A row is complete without load where it has the pressure, and without pressure where it has the
    load.

    Raises:
        OilfilmError: No row is complete.
    """
    points = mu_table.points
    if _ACCEPTED in points:
        is_rejected = points.pop(_ACCEPTED).str.casefold() == "false"
        points = mu_table.without_rows(points, is_rejected.to_numpy(), "they are not accepted")
    needed_columns = [column for column in (SLIP, MU, SPEED, TEMPERATURE) if column in points]
    is_complete = _has_numbers(points, needed_columns)
    load_columns = [column for column in (LOAD, PRESSURE) if column in points]
    if load_columns:
        is_complete &= np.any([_has_numbers(points, [column]) for column in load_columns], axis=0)
    points = _complete_rows(points, is_complete, mu_table)
    _refuse_unlabelled(points, mu_table)
    mu_table.points = _at_positive_slip(points, mu_table)
    return mu_table


def _complete_rows(points: pd.DataFrame, is_complete: BoolArray, mu_table: MuTable) -> pd.DataFrame:
    """The complete rows of points.

    Raises:
        OilfilmError: No row is complete.
    """
    if not is_complete.any():
        advice = "Look at decimal marks and empty cells."
        raise mu_table.error("no row has all its numbers.", advice)
    return mu_table.without_rows(points, ~is_complete, "a number is missing there")


def _has_numbers(points: pd.DataFrame, columns: Sequence[str]) -> BoolArray:
    """Mask of the rows with a number in each of some columns, shape (rows,)."""
    return np.asarray(np.isfinite(points[list(columns)].to_numpy(float)).all(axis=1))


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
    """The points with |S| and the mu that belongs to it: a law has mu(-S) = -mu(S).

    A table has mu with the sign of the slip, or without it. Most of its points at negative slip
    tell which. A point whose mu has the wrong sign

    - stays where mu is so small that noise explains it: without such points the mean is too large;
    - is left out otherwise, as a typing error.

    Notes count such points.

    Raises:
        OilfilmError: More than a few points at positive slip, or at negative slip, have the wrong
            sign.
    """
    is_negative_slip = points[SLIP] < 0
    is_negative_mu = points[MU] < 0
    is_beyond_noise = points[MU].abs() > _NOISE_SHARE * points[MU].abs().median()
    is_clearly_at_negative_slip = is_negative_slip & is_beyond_noise
    mu_has_sign = bool(
        (is_clearly_at_negative_slip & is_negative_mu).sum() > is_clearly_at_negative_slip.sum() / 2
    )
    expects_negative_mu = is_negative_slip & mu_has_sign
    has_wrong_sign = (
        (points[SLIP] != 0) & (points[MU] != 0) & (is_negative_mu != expects_negative_mu)
    )
    is_sign_error = has_wrong_sign & is_beyond_noise
    for direction, is_in_direction in (
        ("positive", points[SLIP] > 0),
        ("negative", is_negative_slip),
    ):
        row_count = int(is_in_direction.sum())
        if (is_sign_error & is_in_direction).sum() > _MAX_WRONG_SIGN_SHARE * row_count:
            raise mu_table.error(
                f"of {row_count} rows at {direction} slip "
                f"{int((is_in_direction & is_negative_mu).sum())} have a negative mu.",
                "Give mu the sign of the slip in all rows, or in none; or reverse the sign of the "
                "force.",
            )
    noisy_count = int((has_wrong_sign & ~is_beyond_noise).sum())
    if noisy_count:
        mu_table.note_on_rows(
            f"{noisy_count} of {len(points)} rows are used although mu has the other sign there: "
            f"it is at most {_NOISE_SHARE:.0%} of the median, as noise may be"
        )
    mirrored_points = points.assign(**{SLIP: points[SLIP].abs()})
    if mu_has_sign:
        mirrored_points.loc[is_negative_slip, MU] *= -1
    reason = ""
    if is_sign_error.any():
        first_error = points.loc[is_sign_error].iloc[0]
        convention = "has the sign of the slip" if mu_has_sign else "has no sign"
        reason = (
            f"mu {convention} in the other rows, and here it is {first_error[MU]:g} at S = "
            f"{first_error[SLIP]:g}"
        )
    return mu_table.without_rows(mirrored_points, is_sign_error.to_numpy(), reason)


class _BallOnDisc(Group):
    """A ball on a flat disc."""

    ball_radius_m: q.BallRadiusM = key("Radius of the ball.")
    ball: Elasticity = key("Elastic constants of the ball.")
    disc: Elasticity = key("Elastic constants of the disc.")


def pressure_gpa_of_load(load_n: FloatArray, ball_radius_m: float, materials: str) -> FloatArray:
    """Maximum Hertz pressure in GPa of loads in N on a ball and a flat disc, shape (rows,).

    Args:
        load_n: Loads, in N.
        ball_radius_m: Radius of the ball, in m.
        materials: Materials of ball and disc, as `steel,glass` or `206GPa:0.3,steel`.

    Raises:
        OilfilmError: A material is not known, or the radius or an elastic constant is impossible.

    Examples:
        20 N on a steel ball of 9.525 mm, against steel: 0.818 GPa by hand with E' = 226.4 GPa.

        >>> pressure_gpa_of_load(np.array([20.0]), 9.525e-3, "steel,steel").round(3)
        array([0.818])
    """
    try:
        ball_name, disc_name = materials.split(",")
        ball = _elastic_constants(ball_name.strip())
        disc = _elastic_constants(disc_name.strip())
    except (KeyError, ValueError):
        raise OilfilmError(
            f"--materials: found {materials!r}; expected ball,disc, as steel,glass, each one of "
            f"{', '.join(MATERIALS)}, or Young's modulus and Poisson's ratio, as 206GPa:0.3."
        ) from None
    contact = validated(
        {"ball_radius_m": ball_radius_m, "ball": ball, "disc": disc},
        _BallOnDisc,
        lambda _: f"--ball-radius {ball_radius_m}m --materials {materials}",
    )
    modulus_pa = contact.ball.reduced_modulus_with(contact.disc)
    pressure_pa = max_hertz_pressure(load_n, contact.ball_radius_m, modulus_pa)
    return np.asarray(pressure_pa / PA_PER_GPA)


def _elastic_constants(material: str) -> dict[str, float]:
    """Elastic constants of a material by their keys, by its name or from a text as 206GPa:0.3."""
    if ":" in material:
        modulus_gpa, _, poisson_ratio_text = material.partition(":")
        youngs_modulus_pa = float(modulus_gpa.removesuffix("GPa")) * PA_PER_GPA
        poisson_ratio = float(poisson_ratio_text)
    else:
        youngs_modulus_pa, poisson_ratio = MATERIALS[material]
    return {"youngs_modulus_pa": youngs_modulus_pa, "poisson_ratio": poisson_ratio}
