"""A law fitted to a table of mu, as a rig exports it or as it is typed from a paper.

One row is one settled reading: slide-roll ratio, speed, load or pressure, temperature and mu. There
is no time, no force and no zero, so that the gates of logs cannot check it. The Python function is
`oilfilm.fit_table`, the command `oilfilm fit`.

Decides: what the columns of a table of mu mean, and what is assumed where a unit is missing; which
law a table is fitted with.
"""

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.api.arrays import ArrayFit, fit_points
from oilfilm.base.errors import OilfilmError, cut
from oilfilm.base.plain_key import plain_key
from oilfilm.base.units import PA_PER_GPA, FloatArray, possible_conversion
from oilfilm.logs import delimited_text, workbook
from oilfilm.logs.base import UnreadableLogError
from oilfilm.logs.header import split_unit
from oilfilm.logs.ingest import read_bytes, unpack
from oilfilm.logs.logged_table import LoggedTable
from oilfilm.logs.sniff import Guesses, has_word, unit_in_name
from oilfilm.logs.traction_log import TRACTION
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
_COLUMNS = {PRESSURE, LOAD, SPEED, _BALL_SPEED, _DISC_SPEED, TEMPERATURE, SLIP, MU}
# Quantity and unit of each column.
_QUANTITY_OF_COLUMN = {
    column: quantity
    for column, quantity in TRACTION.vocabulary.project_names.items()
    if column in _COLUMNS
}
VOCABULARY = Guesses("traction", "columns", _QUANTITY_OF_COLUMN, (), symbols=True)
# Words in the names of columns of text. A column with a word for time or temperature is no label.
_WORDS_OF_LABEL = {
    "oil": "oil öl oel lubric schmierstoff huile aceite olio lube масл 油",
    "curve": "curve kurve run test versuch messung courbe essai curva ensayo prueba prova кривая "
    "曲线",
}
_WORDS_OF_NO_LABEL = "temp time zeit"
# A slide-roll ratio above this is in %.
_LARGEST_SLIP = 2.0
# A temperature above this is not in degC.
_HOTTEST_C = 300.0
_DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t", "bar": "|"}
# First bytes of a file.
_PARQUET_SIGNATURE = b"PAR1"
# Laws that are fitted to a table of load or of pressure if none is named.
_LAW_OF_LOAD = "wang-deng-load"
_LAW_OF_PRESSURE = PAPER_LAW.name
# Options of the command that give a condition for all rows, as examples.
_OPTIONS = {
    PRESSURE: "--stress 1.2GPa",
    SPEED: "--speed 2m/s",
    LOAD: "--load 50N",
    TEMPERATURE: "--temperature 40degC",
}


def fit_table(
    table: Path | str | pd.DataFrame,
    *,
    ball_radius_m: float | None = None,
    materials: str = "steel,steel",
    law: str | None = None,
    oil: str | None = None,
    at: Mapping[str, float] | None = None,
    **settings: Any,
) -> ArrayFit:
    """Fit a traction law to a table of mu: csv, tsv, xlsx, Parquet or a data frame.

    Columns are found by name and unit, in the languages that logs may have: slide-roll ratio (as
    fraction or %), mean speed or speeds of ball and disc, mu, load or maximum Hertz pressure,
    temperature; and, where there are such columns, oil and curve.

    Args:
        table: The table. Units are in the names or in the row below them: `speed [mm/s]`.
        ball_radius_m: Radius of the ball on a flat disc, in m: load becomes pressure.
        materials: Materials of ball and disc: steel, silicon-nitride, glass, or 206GPa:0.3.
        law: Name of the law. If not given, a law of pressure, or of load where the pressure is not
            known.
        oil: The oil to fit where the table has several oils; else the name of the oil.
        at: Conditions that hold for all rows, by their columns' names (`inlet_temperature_c`).
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
        >>> levels = [1.0, 1.25, 1.5], [25, 40], [50, 120], [0.01, 0.03, 0.1, 0.3]
        >>> names = ["p [GPa]", "U [m/s]", "T [degC]", "SRR"]
        >>> table = pd.MultiIndex.from_product(levels, names=names).to_frame(index=False)
        >>> at = table.to_numpy().T
        >>> table["mu"] = oilfilm.predict("deng2026", constants, *at).traction_coefficient
        >>> fitted = oilfilm.fit_table(table, searches=2, bootstrap=20)
        >>> fitted.constants["value"].round(3)[["A0", "A1"]].to_dict()
        {'A0': -0.016, 'A1': 1.665}
    """
    read_table = read_mu_table(table)
    points = read_table.points.assign(**(at or {}))
    notes = list(read_table.notes)
    points, oil = _points_of_oil(points, oil, read_table.name)
    if LOAD in points and PRESSURE not in points and ball_radius_m is not None:
        points = with_pressure(points, ball_radius_m, materials)
        notes.append(f"{PRESSURE} follows from load, ball radius and materials ({materials})")
    if law is None:
        law = _LAW_OF_PRESSURE
        if LOAD in points and PRESSURE not in points:
            law = _LAW_OF_LOAD
            notes.append(
                f"law of load, {law}, because the pressure is not known; with --ball-radius and "
                "--materials a law of pressure can be fitted"
            )
    conditions = LAWS[law].conditions if law in LAWS else (PRESSURE, SPEED, TEMPERATURE)
    _refuse_missing(points, conditions, read_table.name)
    curve = points.pop("curve") if "curve" in points else None
    fitted = fit_points(points, conditions, law, curve, **settings)
    notes += fitted.notes
    return replace(fitted, notes=tuple(notes), source=read_table.name, oil=oil)


def _points_of_oil(points: pd.DataFrame, oil: str | None, name: str) -> tuple[pd.DataFrame, str]:
    """The points of one oil, and its name.

    Raises:
        OilfilmError: The table lacks the oil, or has several oils and none is named.
    """
    if "oil" not in points:
        return points, oil or "oil"
    oils = sorted(points["oil"].unique())
    advice = f"Name one with --oil: {', '.join(oils)}."
    if oil is None and len(oils) > 1:
        raise OilfilmError(f"{name}: has several oils. {advice}")
    if oil is not None and oil not in oils:
        raise OilfilmError(f"{name}: has no oil {oil!r}. {advice}")
    oil = oil or str(oils[0])
    return points[points["oil"] == oil].drop(columns="oil"), oil


def _refuse_missing(points: pd.DataFrame, conditions: tuple[str, ...], name: str) -> None:
    """Refuse a table without a condition that the law needs.

    Raises:
        OilfilmError: A column is missing.
    """
    for column in (*conditions, MU):
        if column not in points:
            quantity, _, _ = column.rpartition("_")
            sentence = (
                f"{name}: no column is the {quantity.replace('_', ' ')}. Add it, or give it for "
                f"all rows, as {_OPTIONS.get(column, '')}."
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
        notes: Meaning of each column, and assumptions, in sentences.
    """

    name: str
    points: pd.DataFrame = field(default_factory=pd.DataFrame)
    notes: list[str] = field(default_factory=list)

    def error(self, problem: str, advice: str) -> OilfilmError:
        """The error of a table that cannot be used.

        Args:
            problem: What was found and what was expected, as a sentence after the name.
            advice: What to do.
        """
        return OilfilmError(f"{self.name}: {problem} {advice}")


def read_mu_table(table: Path | str | pd.DataFrame) -> MuTable:
    """Read csv, tsv, xlsx or Parquet, or a data frame.

    Raises:
        OilfilmError: A column is missing, doubtful or without a unit, or a number is impossible.
    """
    if isinstance(table, pd.DataFrame):
        name = "the data frame"
        texts = [("", _tab_separated(table))]
    else:
        name = str(table)
        texts = _file_texts(Path(table), MuTable(name))
    parts: list[tuple[str, MuTable]] = []
    faults: dict[str, OilfilmError] = {}
    for title, text in texts:
        try:
            parts.append((title, _table_of_text(text, MuTable(name))))
        except OilfilmError as error:
            faults[title] = error
    if not parts:
        # the sheet that comes nearest to a table has the most text
        raise faults[max(texts, key=lambda title_and_text: len(title_and_text[1]))[0]]
    mu_table = parts[0][1] if len(parts) == 1 else _joined_sheets(parts, MuTable(name))
    if faults and len(parts) == 1:
        mu_table.notes.append(f"the sheet {parts[0][0]!r} is read")
    for title, fault in faults.items():
        reason = str(fault).removeprefix(f"{name}: ")
        mu_table.notes.append(f"the sheet {title!r} is not read: {cut(reason)}")
    return mu_table


def _joined_sheets(parts: Sequence[tuple[str, MuTable]], joined: MuTable) -> MuTable:
    """One table of several sheets. Where a sheet names no oil, its title does.

    Raises:
        OilfilmError: The sheets have different conditions.
    """
    columns = {title: set(map(str, part.points)) - {"oil", "curve"} for title, part in parts}
    if len(set(map(frozenset, columns.values()))) > 1:
        listed = "; ".join(f"{title!r}: {', '.join(sorted(of))}" for title, of in columns.items())
        raise joined.error(
            f"its sheets have different conditions: {listed}.",
            "Give all sheets the same columns, or save the sheet to be fitted alone.",
        )
    frames: list[pd.DataFrame] = []
    for title, part in parts:
        points = part.points
        if "oil" not in points:
            points = points.assign(oil=title)
        if "curve" in points:
            points = points.assign(curve=title + " " + points["curve"].astype(str))
        frames.append(points)
    joined.points = pd.concat(frames, ignore_index=True)
    titles = ", ".join(repr(title) for title, _ in parts)
    joined.notes = [*parts[0][1].notes, f"the sheets {titles} are read"]
    for _, part in parts[1:]:
        joined.notes += [note for note in part.notes if note not in joined.notes]
    return joined


def _table_of_text(text: bytes, mu_table: MuTable) -> MuTable:
    """The table in a text: of all blocks that repeat the line of names.

    Raises:
        OilfilmError: As by `read_mu_table`.
    """
    try:
        form, blocks = delimited_text.tables(text, VOCABULARY)
    except UnreadableLogError as error:
        advice = "Write one line of names above the rows: slide_roll_ratio and mu among them."
        raise mu_table.error(f"{error.refusal.reason}.", advice) from None
    frames: list[pd.DataFrame] = []
    notes: list[str] = []
    for logged in blocks:
        mu_table.notes = list(logged.notes)
        mu_table.points = pd.DataFrame()
        columns = _columns(logged, mu_table)
        _add_points(mu_table, logged, columns)
        _add_labels(mu_table, logged, columns, _DELIMITERS.get(form.delimiter))
        frames.append(mu_table.points)
        notes += [note for note in mu_table.notes if note not in notes]
    mu_table.points = pd.concat(frames, ignore_index=True)
    mu_table.notes = notes
    return _without_gaps(mu_table)


def _add_labels(
    mu_table: MuTable,
    logged: LoggedTable,
    columns: Mapping[str, tuple[str, str]],
    delimiter: str | None,
) -> None:
    """Add the columns of text, `oil` and `curve`, where the table has them."""
    if logged.show is None:
        return
    # columns without a name are no labels
    names_in_use = {plain_key(name) for name, _ in columns.values()} | {""}
    for label, words in _WORDS_OF_LABEL.items():
        index = _index_of_label(logged.names, words, names_in_use)
        if index is None:
            continue
        texts = []
        for number in range(logged.rows):
            cells = logged.show(number).split(delimiter)
            texts.append(cells[index].strip(' "') if index < len(cells) else "")
        mu_table.points[label] = texts


def _index_of_label(names: Sequence[str], words: str, names_in_use: set[str]) -> int | None:
    """Index of the first free column that one of the words names; None if there is none."""
    for index, name in enumerate(names):
        is_label = has_word(name, words) and not has_word(name, _WORDS_OF_NO_LABEL)
        if is_label and plain_key(name) not in names_in_use:
            return index
    return None


def _file_texts(path: Path, mu_table: MuTable) -> list[tuple[str, bytes]]:
    """Title and text of each sheet of a workbook; another file is one text without a title.

    Raises:
        OilfilmError: The file cannot be read.
    """
    content = unpack(read_bytes(path))
    try:
        if content.startswith(_PARQUET_SIGNATURE):
            return [("", _tab_separated(pd.read_parquet(io.BytesIO(content))))]
        if content.startswith(workbook.SIGNATURE):
            sheets = workbook.sheet_texts(content)
            if not sheets:
                raise ValueError("no sheet has a cell")
            return sheets
    except Exception as error:
        reason = f"cannot be read ({cut(' '.join(str(error).split()))})."
        raise mu_table.error(reason, "Export it again, or as csv.") from error
    return [("", content)]


def _tab_separated(frame: pd.DataFrame) -> bytes:
    return frame.to_csv(sep="\t", index=False).encode()


def _columns(logged: LoggedTable, mu_table: MuTable) -> dict[str, tuple[str, str]]:
    """Name and unit of the one column of each quantity; the unit is empty where none is stated.

    Raises:
        OilfilmError: Two columns may be one quantity, or mu or the slide-roll ratio is missing.
    """
    names_and_units = list(zip(logged.names, logged.units, strict=True))
    columns: dict[str, tuple[str, str]] = {}
    for quantity, candidates in VOCABULARY.columns_by_quantity(names_and_units).items():
        if len(candidates) > 1:
            names = " and ".join(repr(name) for name, _ in candidates)
            raise mu_table.error(
                f"the columns {names} could both be the {quantity.replace('_', ' ')}.",
                "Rename the one that is not.",
            )
        ((name, unit),) = candidates
        if not unit:
            name_without_unit, _ = split_unit(name)
            unit = unit_in_name(name_without_unit, quantity, VOCABULARY)
        columns[quantity] = (name, unit)
    needed = [MU]
    if not {"ball_speed", "disc_speed"} <= columns.keys():
        needed.append(SLIP)
    missing = [quantity.replace("_", " ") for quantity in needed if quantity not in columns]
    if missing:
        names = ", ".join(map(repr, logged.names)) or "not known"
        raise mu_table.error(
            f"no column is the {' and the '.join(missing)}; its columns are {cut(names)}.",
            "Name the columns slide_roll_ratio and traction_coefficient, or SRR and mu.",
        )
    return columns


def _add_points(
    mu_table: MuTable, logged: LoggedTable, columns: Mapping[str, tuple[str, str]]
) -> None:
    """Add the numbers of a table, converted, and notes on the meaning of its columns."""
    names = list(logged.names)
    indices = [names.index(name) for name, _ in columns.values()]
    for quantity, numbers in zip(columns, logged.values(indices), strict=True):
        name, stated_unit = columns[quantity]
        unit = stated_unit or _assumed_unit(quantity, name, numbers, mu_table)
        units = VOCABULARY.quantities[quantity]
        to_unit = possible_conversion(unit, units)
        if to_unit is None:
            sentence = f"the column {name!r} is in {unit!r}; expected {' or '.join(units)}."
            raise mu_table.error(sentence, "Correct the unit, or the name.")
        column = _column_in(quantity, to_unit.unit)
        mu_table.points[column] = to_unit.convert(numbers)
        in_unit = "" if unit == "1" else f", in {unit}"
        mu_table.notes.append(f"{column} is {name!r}{in_unit}")
    points = mu_table.points
    if {_BALL_SPEED, _DISC_SPEED} <= set(points):
        ball_m_s = points.pop(_BALL_SPEED)
        disc_m_s = points.pop(_DISC_SPEED)
        points[SPEED] = (ball_m_s + disc_m_s) / 2
        if SLIP not in points:
            points[SLIP] = (disc_m_s - ball_m_s) / points[SPEED]


def _column_in(quantity: str, unit: str) -> str:
    """Name of the column of a quantity in a unit."""
    for column, quantity_and_unit in _QUANTITY_OF_COLUMN.items():
        if quantity_and_unit == (quantity, unit):
            return column
    raise KeyError((quantity, unit))


def _assumed_unit(quantity: str, name: str, numbers: FloatArray, mu_table: MuTable) -> str:
    """The unit of a column that states none, where the numbers leave no doubt.

    Raises:
        OilfilmError: Several units are possible.
    """
    largest = float(np.nanmax(np.abs(numbers), initial=0))
    if quantity == MU or (quantity == SLIP and largest <= _LARGEST_SLIP):
        return "1"
    if quantity == SLIP:
        mu_table.notes.append(f"assumed: {name!r} goes up to {largest:g}, so it is in %")
        return "%"
    if quantity == "inlet_temperature" and largest < _HOTTEST_C:
        mu_table.notes.append(f"assumed: {name!r} is in degC")
        return "degC"
    units = VOCABULARY.quantities[quantity]
    raise mu_table.error(
        f"the column {name!r} has no unit; it could be in {' or '.join(units)} or another one.",
        f"Write the unit behind the name, as `{name} [{units[0]}]`.",
    )


def _without_gaps(mu_table: MuTable) -> MuTable:
    """The table with its complete rows and positive slip; a note counts the other rows.

    Raises:
        OilfilmError: No row is complete.
    """
    numbers = mu_table.points.select_dtypes("number").to_numpy(dtype=float)
    is_complete = np.isfinite(numbers).all(axis=1)
    n_incomplete = int(np.sum(~is_complete))
    if n_incomplete:
        mu_table.notes.append(
            f"{n_incomplete} of {len(is_complete)} rows are left out: a number is missing there"
        )
    points = mu_table.points.loc[is_complete].reset_index(drop=True)
    if points.empty:
        advice = "Look at decimal marks and empty cells."
        raise mu_table.error("no row has all its numbers.", advice)
    # the law is odd: slip and mu with both signs turned are the same point
    is_backwards = points[SLIP] < 0
    if (points.loc[is_backwards, MU] < 0).any():
        points.loc[is_backwards, MU] *= -1
    points[SLIP] = points[SLIP].abs()
    mu_table.points = points
    return mu_table


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
    try:
        ball, disc = materials.split(",")
        ball_modulus_pa, ball_poisson_ratio = _elastic_constants(ball.strip())
        disc_modulus_pa, disc_poisson_ratio = _elastic_constants(disc.strip())
    except (KeyError, ValueError):
        raise OilfilmError(
            f"--materials: found {materials!r}; expected ball,disc, as steel,glass, each one of "
            f"{', '.join(MATERIALS)}, or Young's modulus and Poisson's ratio, as 206GPa:0.3."
        ) from None
    modulus_pa = reduced_modulus(
        ball_modulus_pa, ball_poisson_ratio, disc_modulus_pa, disc_poisson_ratio
    )
    pressure_pa = max_hertz_pressure(points[LOAD].to_numpy(), ball_radius_m, modulus_pa)
    return points.assign(**{PRESSURE: pressure_pa / PA_PER_GPA})


def _elastic_constants(material: str) -> tuple[float, float]:
    """Young's modulus in Pa and Poisson's ratio of a material, by name or as 206GPa:0.3."""
    if ":" in material:
        modulus_gpa, _, poisson_ratio = material.partition(":")
        return float(modulus_gpa.removesuffix("GPa")) * PA_PER_GPA, float(poisson_ratio)
    return MATERIALS[material]
