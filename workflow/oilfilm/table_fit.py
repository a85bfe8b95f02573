"""A law fitted to a table of mu, as a rig exports it or as it is typed from a paper.

One row is one settled reading: slide-roll ratio, speed, load or pressure, temperature and mu. No
time, no force and no zero: nothing of it can be checked as a log is. In Python it is
`oilfilm.fit_table`, on the command line `oilfilm fit`.

Decides: what the columns of a table of mu mean, and what is assumed where it does not say so;
which law a table is fitted with.
"""

import io
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.arrays import ArrayFit, fit_points
from oilfilm.errors import OilfilmError, cut
from oilfilm.logs import delimited_text
from oilfilm.logs.base import UnreadableLogError
from oilfilm.logs.columns import LoggedTable
from oilfilm.logs.header import split_unit
from oilfilm.logs.ingest import read_bytes, unpack
from oilfilm.logs.sheet_file import checked_workbook
from oilfilm.logs.sniff import Guesses, has_word, unit_in_name
from oilfilm.logs.traction_log import TRACTION
from oilfilm.physics.contact import max_hertz_pressure, reduced_modulus
from oilfilm.settings.base import plain_key
from oilfilm.traction import LAWS, PAPER_LAW
from oilfilm.units import PA_PER_GPA, FloatArray, possible_conversion

PRESSURE, LOAD, SPEED = "max_hertz_pressure_gpa", "load_n", "entrainment_speed_m_s"
TEMPERATURE, SLIP, MU = "inlet_temperature_c", "slide_roll_ratio", "traction_coefficient"
# Young's modulus in Pa and Poisson's ratio. Steel and silicon nitride as bearing steel and balls
# have them (Harris and Kotzalas, Rolling Bearing Analysis, 5th ed., 2007); glass: Schott N-BK7.
MATERIALS = {"steel": (206e9, 0.3), "silicon-nitride": (310e9, 0.26), "glass": (82e9, 0.206)}
_COLUMNS = {PRESSURE, LOAD, SPEED, "ball_speed_m_s", "disc_speed_m_s", TEMPERATURE, SLIP, MU}
_OWN_NAMES = {n: of for n, of in TRACTION.vocabulary.project_names.items() if n in _COLUMNS}
VOCABULARY = Guesses("traction", "columns", _OWN_NAMES, (), symbols=True)
# Columns of text by the words of their names; a time or temperature is none of them.
_LABELS = {
    "oil": "oil öl oel lubric schmierstoff huile aceite olio lube масл 油",
    "curve": "curve kurve run test versuch messung courbe essai curva ensayo prueba prova кривая "
    "曲线",
}
_NO_LABEL = "temp time zeit"
# A slide-roll ratio is 2 at most, and a hot oil colder than this.
_LARGEST_SLIP, _HOTTEST_C = 2.0, 300.0
_MARKS = {"comma": ",", "semicolon": ";", "tab": "\t", "bar": "|"}
_EXCEL, _PARQUET = b"PK\x03\x04", b"PAR1"
# Of laws of load and of pressure, the one that a table is fitted with unless another is named.
_OF_LOAD, _OF_PRESSURE = "wang-deng-load", PAPER_LAW.name
_OPTIONS = {PRESSURE: "--stress 1.2GPa", SPEED: "--speed 2m/s", LOAD: "--load 50N"}
_OPTIONS |= {TEMPERATURE: "--temperature 40degC"}


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
        materials: Of ball and disc: steel, silicon-nitride, glass, or 206GPa:0.3.
        law: Name of the law; if not given one of pressure, or of load where the pressure is not
            known.
        oil: Which oil, where the table has a column of oils with several; else its name.
        at: Conditions that hold for all rows, by their columns' names (`inlet_temperature_c`).
        settings: Keys of `fit` in config/config.yaml that differ, as `bootstrap=200`.

    Raises:
        OilfilmError: A column or a condition is missing or cannot be understood, or a number is
            impossible.

    Examples:
        A table on the printed law of 4102 gives its constants back:

        >>> import oilfilm
        >>> levels = [1.0, 1.25, 1.5], [25, 40], [50, 120], [0.01, 0.03, 0.1, 0.3]
        >>> names = ["p [GPa]", "U [m/s]", "T [degC]", "SRR"]
        >>> table = pd.MultiIndex.from_product(levels, names=names).to_frame(index=False)
        >>> at = table.to_numpy().T
        >>> table["mu"] = oilfilm.printed("4102").predict_at(*at).traction_coefficient
        >>> fitted = oilfilm.fit_table(table, searches=2, bootstrap=20)
        >>> fitted.constants["value"].round(3)[["A0", "A1"]].to_dict()
        {'A0': -0.016, 'A1': 1.665}
    """
    found = read_mu_table(table)
    points, notes = found.points.assign(**(at or {})), list(found.notes)
    points, oil = _of_oil(points, oil, found.name)
    if LOAD in points and PRESSURE not in points and ball_radius_m is not None:
        points = with_pressure(points, ball_radius_m, materials)
        notes.append(f"{PRESSURE} follows from load, ball radius and materials ({materials})")
    of_load = LOAD in points and PRESSURE not in points
    if law is None:
        law = _OF_LOAD if of_load else _OF_PRESSURE
        if of_load:
            notes.append(
                f"law of load, {law}, because the pressure is not known; with --ball-radius and "
                "--materials a law of pressure can be fitted"
            )
    conditions = LAWS[law].conditions if law in LAWS else (PRESSURE, SPEED, TEMPERATURE)
    _refuse_missing(points, conditions, found.name)
    curve = points.pop("curve") if "curve" in points else None
    fitted = fit_points(points, conditions, law, curve, **settings)
    notes += fitted.notes
    return replace(fitted, notes=tuple(notes), source=found.name, oil=oil)


def _of_oil(points: pd.DataFrame, oil: str | None, name: str) -> tuple[pd.DataFrame, str]:
    """The points of one oil, and its name."""
    if "oil" not in points:
        return points, oil or "oil"
    oils = sorted(points["oil"].unique())
    if oil not in (None, *oils) or (oil is None and len(oils) > 1):
        asked = "has several oils" if oil is None else f"has no oil {oil!r}"
        raise OilfilmError(f"{name}: {asked}. Name one with --oil: {', '.join(oils)}.")
    chosen = oil or str(oils[0])
    return points[points["oil"] == chosen].drop(columns="oil"), chosen


def _refuse_missing(points: pd.DataFrame, conditions: tuple[str, ...], name: str) -> None:
    """Refuse a table without a condition that the law needs.

    Raises:
        OilfilmError: It lacks one.
    """
    for column in (*conditions, MU):
        if column not in points:
            radius = " Where it has the load, give --ball-radius and --materials."
            raise OilfilmError(
                f"{name}: no column is the {column.rpartition('_')[0].replace('_', ' ')}. Add it, "
                f"or give it for all rows, as {_OPTIONS.get(column, '')}."
                + (radius if column == PRESSURE else "")
            )


# ---------------------------------------------------------------- the table


@dataclass
class MuTable:
    """A table as it was read.

    Attributes:
        name: What it is called in messages.
        points: Conditions, slip and mu by their columns' names; `oil` and `curve` where the table
            has them. Pressure or load may be missing.
        notes: What each column was taken for, and what was assumed.
    """

    name: str
    points: pd.DataFrame = field(default_factory=pd.DataFrame)
    notes: list[str] = field(default_factory=list)

    def refuse(self, found: str, advice: str) -> OilfilmError:
        """The error of a table that cannot be used."""
        return OilfilmError(f"{self.name}: {found} {advice}")


def read_mu_table(table: Path | str | pd.DataFrame) -> MuTable:
    """Read csv, tsv, xlsx or Parquet, or a data frame.

    Raises:
        OilfilmError: A column is missing, doubtful or without a unit, or a number is impossible.
    """
    found = MuTable("the data frame" if isinstance(table, pd.DataFrame) else str(table))
    try:
        text = _text_of(table) if isinstance(table, pd.DataFrame) else _content(Path(table), found)
        form, (logged,) = delimited_text.tables(text, VOCABULARY)
    except UnreadableLogError as error:
        advice = "Write one line of names above the rows: slide_roll_ratio and mu among them."
        raise found.refuse(f"{error.refusal.reason}.", advice) from None
    columns = _columns(logged, found)
    _fill(found, logged, columns)
    taken = {plain_key(name) for name, _ in columns.values()} | {""}
    for label, words in _LABELS.items():
        for place, name in enumerate(logged.names):
            known = has_word(name, words) and not has_word(name, _NO_LABEL)
            if known and plain_key(name) not in taken and logged.show and label not in found.points:
                rows = (
                    logged.show(n).split(_MARKS.get(form.delimiter)) for n in range(logged.rows)
                )
                texts = [row[place].strip(' "') if row[place:] else "" for row in rows]
                found.points[label] = texts
    return _without_gaps(found)


def _content(path: Path, found: MuTable) -> bytes:
    """The table as text: a workbook's first sheet and Parquet as tab-separated values."""
    content = unpack(read_bytes(path))
    try:
        if content.startswith(_PARQUET):
            return _text_of(pd.read_parquet(io.BytesIO(content)))
        if content.startswith(_EXCEL):
            # a sheet may have lines above the names
            sheet = pd.read_excel(checked_workbook(content), header=None, dtype=object)
            return sheet.to_csv(sep="\t", index=False, header=False).encode()
    except Exception as error:
        reason = f"cannot be read ({cut(' '.join(str(error).split()))})."
        raise found.refuse(reason, "Export it again, or as csv.") from error
    return content


def _text_of(frame: pd.DataFrame) -> bytes:
    return frame.to_csv(sep="\t", index=False).encode()


def _columns(logged: LoggedTable, found: MuTable) -> dict[str, tuple[str, str]]:
    """The one column that means each quantity, with its unit."""
    names = [*zip(logged.names, logged.units, strict=True)]
    meant = VOCABULARY.columns_by_quantity(names)
    known: dict[str, tuple[str, str]] = {}
    for quantity, columns in meant.items():
        (name, unit), *others = columns
        if others:
            several = " and ".join(repr(name) for name, _ in columns)
            raise found.refuse(
                f"the columns {several} could both be the {quantity.replace('_', ' ')}.",
                "Rename the one that is not.",
            )
        known[quantity] = name, unit or unit_in_name(split_unit(name)[0], quantity, VOCABULARY)
    needed = [MU] if {"ball_speed", "disc_speed"} <= known.keys() else [MU, SLIP]
    if lacking := [name.replace("_", " ") for name in needed if name not in known]:
        own = ", ".join(repr(name) for name, _ in names) or "none that can be told"
        raise found.refuse(
            f"no column is the {' and the '.join(lacking)}; its columns are {cut(own)}.",
            "Name the columns slide_roll_ratio and traction_coefficient, or SRR and mu.",
        )
    return known


def _fill(found: MuTable, logged: LoggedTable, columns: Mapping[str, tuple[str, str]]) -> None:
    """The points of a table, converted, and the notes on what was taken for what."""
    names = [*logged.names]
    places = {quantity: names.index(name) for quantity, (name, _) in columns.items()}
    values = dict(zip(places, logged.values([*places.values()]), strict=True))
    for quantity, numbers in values.items():
        name, unit = columns[quantity]
        unit = unit or _assumed_unit(quantity, name, numbers, found)
        units = VOCABULARY.quantities[quantity]
        to = possible_conversion(unit, units)
        if to is None:
            sentence = f"the column {name!r} is in {unit!r}; expected {' or '.join(units)}."
            raise found.refuse(sentence, "Correct the unit, or the name.")
        column = next(n for n, known in _OWN_NAMES.items() if known == (quantity, to.unit))
        found.points[column] = to.of(numbers)
        found.notes.append(f"{column} is {name!r}" + (f", in {unit}" if unit != "1" else ""))
    points = found.points
    if {"ball_speed_m_s", "disc_speed_m_s"} <= set(points):
        ball, disc = points.pop("ball_speed_m_s"), points.pop("disc_speed_m_s")
        mean = (ball + disc) / 2
        found.points = points.assign(**{SPEED: mean, SLIP: points.get(SLIP, (disc - ball) / mean)})


def _assumed_unit(quantity: str, name: str, numbers: FloatArray, found: MuTable) -> str:
    """The unit of a column that states none, where the numbers leave no doubt."""
    largest = float(np.nanmax(np.abs(numbers), initial=0))
    if quantity == MU or (quantity == SLIP and largest <= _LARGEST_SLIP):
        return "1"
    if quantity == SLIP:
        found.notes.append(f"assumed: {name!r} goes up to {largest:g}, so it is in %")
        return "%"
    if quantity == "inlet_temperature" and largest < _HOTTEST_C:
        found.notes.append(f"assumed: {name!r} is in degC")
        return "degC"
    units = " or ".join(VOCABULARY.quantities[quantity])
    raise found.refuse(
        f"the column {name!r} has no unit; it could be in {units} or another one.",
        f"Write the unit behind the name, as `{name} [{VOCABULARY.quantities[quantity][0]}]`.",
    )


def _without_gaps(found: MuTable) -> MuTable:
    """The rows that are complete, with positive slip; the others are counted."""
    numbers = found.points.select_dtypes("number").to_numpy(dtype=float)
    good = np.isfinite(numbers).all(axis=1)
    if lost := int(np.sum(~good)):
        found.notes.append(f"{lost} of {len(good)} rows are left out: a number is missing there")
    points = found.points.loc[good].reset_index(drop=True)
    if points.empty:
        raise found.refuse("no row has all its numbers.", "Look at decimal marks and empty cells.")
    # the law is odd: both signs say the same
    backwards = points[SLIP] < 0
    if (points.loc[backwards, MU] < 0).any():
        points.loc[backwards, MU] *= -1
    points[SLIP] = points[SLIP].abs()
    found.points = points
    return found


def with_pressure(points: pd.DataFrame, ball_radius_m: float, materials: str) -> pd.DataFrame:
    """Points with the maximum Hertz pressure of their load on a ball and a flat disc.

    Args:
        points: With `load_n`.
        ball_radius_m: Radius of the ball, in m.
        materials: Of ball and disc, as `steel,glass` or `206GPa:0.3,steel`.

    Raises:
        OilfilmError: A material is not known.

    Examples:
        20 N on a steel ball of 9.525 mm, against steel: 0.818 GPa by hand with E' = 226.4 GPa.

        >>> points = pd.DataFrame({"load_n": [20.0]})
        >>> with_pressure(points, 9.525e-3, "steel,steel")["max_hertz_pressure_gpa"].round(3)[0]
        np.float64(0.818)
    """
    try:
        (e1, nu1), (e2, nu2) = (_elastic(name.strip()) for name in materials.split(","))
    except (KeyError, ValueError):
        raise OilfilmError(
            f"--materials: found {materials!r}; expected ball,disc, as steel,glass, each one of "
            f"{', '.join(MATERIALS)}, or Young's modulus and Poisson's ratio, as 206GPa:0.3."
        ) from None
    modulus_pa = reduced_modulus(e1, nu1, e2, nu2)
    pressure_pa = max_hertz_pressure(points[LOAD].to_numpy(), ball_radius_m, modulus_pa)
    return points.assign(**{PRESSURE: pressure_pa / PA_PER_GPA})


def _elastic(name: str) -> tuple[float, float]:
    modulus, mark, ratio = name.partition(":")
    if mark:
        return float(modulus.removesuffix("GPa")) * PA_PER_GPA, float(ratio)
    return MATERIALS[name]
