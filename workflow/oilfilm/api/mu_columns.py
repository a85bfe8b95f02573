"""The columns of a table of mu: which is taken for what, how that is known, and what is asked.

A meaning comes from the name of a column, from the user, or from the numbers of other columns.
A meaning that none of them gives is asked, with the line that answers it.

Decides: which of several columns is taken, which numbers decide a definition or a unit, and when
two columns contradict each other.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from oilfilm.base.errors import OilfilmError, cut
from oilfilm.base.units import FloatArray, possible_conversion
from oilfilm.logs.header import split_unit
from oilfilm.logs.meaning import (
    DEFINITION_IN_WORDS,
    DEFINITIONS_OF_QUANTITY,
    UNIT_BY_QUANTITY,
    Meaning,
    meaning_of,
    rank_of,
    stated_unit,
)

# A slide-roll ratio is at most 2 while both surfaces move in one direction: more is in %.
_LARGEST_RATIO = 2.0
# A sweep to a larger ratio is rare. Without a unit it may as well be one in %.
_USUAL_RATIO = 0.5
# A ratio that the speeds of both bodies confirm is within this of theirs, relative.
_CONFIRMED = 0.02
# Another definition is so many times as far from what the speeds say.
_CLEARLY_FARTHER = 3.0
# Two columns that say the same differ by less: digits and moduli of one material make 2 %.
_CONTRADICTS = 0.05
# Speeds of three digits leave so much of the ratio open, as `logged_twice` of logs has it.
_OPEN_BY_DIGITS = 0.005
# Maximum over mean pressure of a circular contact (Hertz 1881).
_MAXIMUM_OVER_MEAN = 1.5
# Steel of bearings is indented by more than this.
_LARGEST_PRESSURE_GPA = 5.0
# What the user may say of a column that is none of the quantities.
NOTHING = "nothing"


@dataclass(frozen=True)
class TableColumn:
    """A column of a table of mu.

    Attributes:
        name: Its name in the table.
        meaning: What the name or the user says it is.
        numbers: Its numbers as the table has them, shape (rows,).
        by_user: Whether the user says what it is.
    """

    name: str
    meaning: Meaning
    numbers: FloatArray
    by_user: bool = False


@dataclass(frozen=True)
class TableReading:
    """What the columns of a table say.

    Attributes:
        values: Quantity -> numbers in its unit of `UNIT_OF` and its first definition.
        names: Quantity -> name of its column.
        notes: How each is known, in sentences.
    """

    values: Mapping[str, FloatArray]
    names: Mapping[str, str]
    notes: Sequence[str]


class AskedError(ValueError):
    """A meaning that is not known: the sentence, and the line that answers it."""

    def __init__(self, sentence: str, advice: str) -> None:
        super().__init__(f"{sentence} {advice}")
        self.sentence = sentence
        self.advice = advice


# ---------------------------------------------------------------- what the user states


def stated_columns(text: str | Mapping[str, str]) -> dict[str, Meaning]:
    """What a user says of columns: name of the column -> its meaning.

    Args:
        text: `quantity=name [unit], definition`, several separated by semicolons; or the same as a
            dictionary of quantities. Unit and definition may be left out: then they are those that
            the table says, else the definition of the project. The quantity `nothing` is for a
            column that is none of them.

    Raises:
        OilfilmError: A quantity is not known.

    Examples:
        >>> stated_columns("slide_roll_ratio=Schlupf [%], over_sum")["Schlupf"].definition
        'over_sum'
    """
    entries: list[tuple[str, str]] = []
    if isinstance(text, str):
        for entry in filter(None, map(str.strip, text.split(";"))):
            quantity, separator, column = entry.partition("=")
            if not separator:
                raise OilfilmError(f"--columns: found {entry!r}; expected {_FORM}.")
            entries.append((quantity.strip(), column.strip()))
    else:
        entries = [(str(quantity), str(column)) for quantity, column in text.items()]
    meaning_by_name: dict[str, Meaning] = {}
    for quantity, column in entries:
        if quantity not in (*UNIT_BY_QUANTITY, NOTHING):
            expected = ", ".join((*UNIT_BY_QUANTITY, NOTHING))
            raise OilfilmError(f"--columns: found {quantity!r}; expected one of {expected}.")
        definitions = DEFINITIONS_OF_QUANTITY.get(quantity, ())
        name_and_unit, separator, last_part = column.rpartition(",")
        definition = last_part.strip() if separator and last_part.strip() in definitions else ""
        # only a unit in brackets: the user types the name as the table has it
        name, unit = split_unit(name_and_unit.strip() if definition else column)
        meaning_by_name[name] = Meaning(quantity, definition, unit)
    return meaning_by_name


_FORM = '"quantity=name [unit], definition", as "slide_roll_ratio=Schlupf [%], over_sum"'


# ---------------------------------------------------------------- which column


def columns_of(
    names: Sequence[str],
    units: Sequence[str],
    numbers: Mapping[int, FloatArray],
    stated: Mapping[str, Meaning],
) -> tuple[dict[str, TableColumn], list[str]]:
    """The column of each quantity, and notes on columns that were not taken.

    Args:
        names: Names of all columns.
        units: Unit beside each; empty where there is none.
        numbers: Numbers of the columns that hold numbers, by index.
        stated: What the user says, by name.

    Raises:
        AskedError: Two columns may be one quantity, or a column that the user names is missing.
    """
    candidates: dict[str, list[TableColumn]] = {}
    not_found = dict(stated)
    for index, name in enumerate(names):
        key = key_of_stated(name, not_found)
        if key is None:
            meaning = meaning_of(name, units[index])
        else:
            meaning = _completed(not_found[key], name, units[index])
        is_nothing = meaning is None or meaning.quantity == NOTHING
        if key is not None and (index in numbers or is_nothing):
            del not_found[key]
        if meaning is None or is_nothing or index not in numbers:
            continue
        column = TableColumn(name, meaning, numbers[index], by_user=key is not None)
        candidates.setdefault(meaning.quantity, []).append(column)
    if not_found:
        missing = next(iter(not_found))
        raise AskedError(
            f"--columns names {missing!r}, which the table has not, or which holds no numbers; its "
            f"columns are {cut(', '.join(map(repr, names)))}.",
            "Write the name as the table has it.",
        )
    chosen: dict[str, TableColumn] = {}
    notes: list[str] = []
    for quantity, columns in candidates.items():
        ranks = [_rank(column) for column in columns]
        best_rank = min(ranks)
        best_columns = [
            column for column, rank in zip(columns, ranks, strict=True) if rank == best_rank
        ]
        if len(best_columns) > 1:
            names_of_best = " and ".join(repr(column.name) for column in best_columns)
            raise AskedError(
                f"the columns {names_of_best} could both be the {quantity.replace('_', ' ')}.",
                _line_to_paste(best_columns[0]),
            )
        chosen[quantity] = best_columns[0]
        names_not_taken = [column.name for column in columns if column is not best_columns[0]]
        if names_not_taken:
            quoted_names = ", ".join(map(repr, names_not_taken))
            notes.append(f"not read as the {quantity.replace('_', ' ')}: {quoted_names}")
    return chosen, notes


def key_of_stated(name: str, stated: Mapping[str, Meaning]) -> str | None:
    """The name under which the user states a column: with its unit or without; None if not."""
    for key in (name, split_unit(name)[0], stated_unit(name)[0]):
        if key in stated:
            return key
    return None


def _completed(stated: Meaning, name: str, unit_beside: str) -> Meaning:
    """What the user says of a column, with unit and definition of its name where none is said."""
    unit = stated.unit or unit_beside or stated_unit(name)[1]
    definition = stated.definition
    definitions = DEFINITIONS_OF_QUANTITY.get(stated.quantity, ())
    if not definition and definitions:
        definition = definitions[0]
        likely_meaning = meaning_of(name, unit_beside)
        if likely_meaning is not None and likely_meaning.quantity == stated.quantity:
            definition = likely_meaning.definition or definition
    return replace(stated, unit=unit, definition=definition)


def _rank(column: TableColumn) -> int:
    """The smaller, the sooner a column is taken; what the user says comes first."""
    return 0 if column.by_user else rank_of(column.meaning)


def _line_to_paste(column: TableColumn) -> str:
    """The line that states what a column is."""
    meaning = column.meaning
    bare_name, unit_of_name = stated_unit(column.name)
    usual_unit = (
        "m/s" if meaning.definition == "sliding_speed" else UNIT_BY_QUANTITY[meaning.quantity]
    )
    unit = meaning.unit or unit_of_name or usual_unit
    in_brackets = "" if unit == "1" else f" [{unit}]"
    definitions = DEFINITIONS_OF_QUANTITY.get(meaning.quantity, ())
    definition = f", {meaning.definition or definitions[0]}" if definitions else ""
    line = f'--columns "{meaning.quantity}={bare_name}{in_brackets}{definition}"'
    if len(definitions) > 1 and not meaning.definition:
        other_definitions = " or ".join(definitions[1:])
        return (
            f"State which: {line}; {other_definitions} in place of {definitions[0]}; "
            f"{_line_for_no_quantity(bare_name)}."
        )
    return f"State it: {line}; {_line_for_no_quantity(bare_name)}."


def _line_for_no_quantity(name: str) -> str:
    """How to say that a column is none of the quantities."""
    return f'--columns "{NOTHING}={name}" if it is something else'


# ---------------------------------------------------------------- what the numbers say


def reading_of(
    chosen: Mapping[str, TableColumn],
    notes: Sequence[str],
    pressure_of_load: FloatArray | None,
    speed_m_s: float | None = None,
) -> TableReading:
    """The numbers of a table in the units and definitions of the project.

    Args:
        chosen: The column of each quantity.
        notes: Notes so far.
        pressure_of_load: Maximum Hertz pressure of the load in GPa, shape (rows,), where load,
            radius and materials are known.
        speed_m_s: Mean speed of all rows, where the user gives it.

    Raises:
        AskedError: A definition or a unit is open, and no other column decides it; or two columns
            contradict each other.
    """
    notes = list(notes)
    values: dict[str, FloatArray] = {}
    names = {quantity: column.name for quantity, column in chosen.items()}
    # speeds first: they decide what a slip is
    quantities_in_order = sorted(chosen, key=lambda quantity: quantity == "slide_roll_ratio")
    for quantity in quantities_in_order:
        column = chosen[quantity]
        numbers: FloatArray | None
        if quantity == "slide_roll_ratio":
            numbers, how_known = _slide_roll_ratio(column, values, speed_m_s)
        elif quantity == "max_hertz_pressure":
            numbers, how_known = _maximum_pressure(column, pressure_of_load)
        elif quantity == "entrainment_speed":
            numbers, how_known = _mean_speed(column, chosen)
        else:
            numbers, how_known = numbers_in_unit(column), ""
        if numbers is None:
            continue
        values[quantity] = numbers
        notes.append(_note_on_column(quantity, column, how_known))
    _refuse_contradictions(values, names)
    pressure = values.get("max_hertz_pressure")
    if pressure is not None and pressure_of_load is not None:
        if _relative_difference(pressure, pressure_of_load) > _CONTRADICTS:
            raise AskedError(
                f"the column {names['max_hertz_pressure']!r} is not the maximum Hertz pressure of "
                f"{names['load']!r} with this ball radius and these materials: it is "
                f"{np.nanmedian(pressure / pressure_of_load):.3g} times as much.",
                "Correct the radius, the materials or the column that is wrong.",
            )
    return TableReading(values, names, notes)


def _note_on_column(quantity: str, column: TableColumn, how_known: str) -> str:
    unit = column.meaning.unit
    unit_note = f", in {unit}" if unit and unit != "1" else ""
    user_note = ", as --columns says" if column.by_user else ""
    return f"{quantity} is {column.name!r}{unit_note}{user_note}{how_known}"


def numbers_in_unit(column: TableColumn) -> FloatArray:
    """The numbers of a column in the unit of its quantity.

    Raises:
        AskedError: It has no unit, or an impossible one.
    """
    meaning = column.meaning
    if meaning.question:
        raise _asked(column)
    target = UNIT_BY_QUANTITY[meaning.quantity]
    if meaning.definition == "sliding_speed":
        target = "m/s"
    unit = meaning.unit
    if not unit and target == "1":
        unit = "1"
    if not unit:
        quantity = meaning.quantity.replace("_", " ")
        raise AskedError(
            f"the column {column.name!r}, the {quantity}, has no unit.", _line_to_paste(column)
        )
    to_unit = possible_conversion(unit, (target,))
    if to_unit is None:
        raise AskedError(
            f"the column {column.name!r} is in {unit!r}; expected {target}.",
            "Correct the unit, or the name.",
        )
    return to_unit.convert(column.numbers)


def _asked(column: TableColumn) -> AskedError:
    quantity = column.meaning.quantity.replace("_", " ")
    return AskedError(
        f"the column {column.name!r} would be the {quantity}, but {column.meaning.question}.",
        _line_to_paste(column),
    )


def _relative_difference(values: FloatArray, reference: FloatArray) -> float:
    """Median difference of two columns over the largest value of the second; else infinite."""
    is_known = np.isfinite(values) & np.isfinite(reference)
    size = float(np.max(np.abs(reference[is_known]), initial=0.0))
    if size == 0:
        return np.inf
    return float(np.median(np.abs(values[is_known] - reference[is_known]))) / size


def _maximum_pressure(
    column: TableColumn, pressure_of_load: FloatArray | None
) -> tuple[FloatArray, str]:
    """The maximum Hertz pressure, and how it is known."""
    meaning = column.meaning
    if meaning.question and pressure_of_load is not None:
        numbers = numbers_in_unit(replace(column, meaning=replace(meaning, question="")))
        for definition, factor in (("maximum", 1.0), ("mean", _MAXIMUM_OVER_MEAN)):
            if _relative_difference(factor * numbers, pressure_of_load) <= _CONTRADICTS:
                return factor * numbers, f", the {definition}: load and ball radius give it"
    numbers = numbers_in_unit(column)
    if meaning.definition == "mean":
        how_known = (
            f", the mean: the maximum is {_MAXIMUM_OVER_MEAN:g} times it in a circular contact"
        )
        return _MAXIMUM_OVER_MEAN * numbers, how_known
    return numbers, ""


def _mean_speed(
    column: TableColumn, chosen: Mapping[str, TableColumn]
) -> tuple[FloatArray | None, str]:
    """The mean of both surface speeds, and how it is known; None where ball and disc give it."""
    meaning = column.meaning
    if meaning.question and {"ball_speed", "disc_speed"} <= chosen.keys():
        return None, ""
    numbers = numbers_in_unit(column)
    if meaning.definition == "sum":
        return numbers / 2, f", {DEFINITION_IN_WORDS['sum']}: halved"
    return numbers, ""


def _slide_roll_ratio(
    column: TableColumn, values: Mapping[str, FloatArray], speed_m_s: float | None
) -> tuple[FloatArray, str]:
    """The slide-roll ratio over the mean speed, and how unit and definition are known."""
    meaning = column.meaning
    ratio_by_speeds = _ratio_of_speeds(values)
    if meaning.definition == "sliding_speed":
        mean_speed: FloatArray | float | None = values.get("entrainment_speed", speed_m_s)
        if mean_speed is None and ratio_by_speeds is not None:
            mean_speed = (values["ball_speed"] + values["disc_speed"]) / 2
        if mean_speed is None:
            raise AskedError(
                f"the column {column.name!r} is a sliding speed; the slide-roll ratio needs the "
                "speed of rolling as well.",
                "Add it, or give it for all rows, as --speed 2m/s.",
            )
        how_known = ", a sliding speed: divided by the mean speed"
        return numbers_in_unit(column) / mean_speed, how_known
    if ratio_by_speeds is not None:
        confirmed = _definition_by_speeds(column, ratio_by_speeds)
        if confirmed is not None:
            return confirmed
        _refuse_other_ratio(column, ratio_by_speeds)
    if meaning.question:
        raise _asked(column)
    largest = float(np.nanmax(np.abs(column.numbers), initial=0))
    how_known = ""
    if not meaning.unit:
        if largest > _LARGEST_RATIO:
            how_known = f", in %: as a ratio it is at most 2, and it goes up to {largest:g}"
            meaning = replace(meaning, unit="%")
        elif largest > _USUAL_RATIO:
            question = f"it goes up to {largest:g} and has no unit: it may be a ratio or in %"
            open_unit = replace(column, meaning=replace(meaning, question=question))
            bare_name, _ = stated_unit(column.name)
            line = f'--columns "slide_roll_ratio={bare_name} [%], {meaning.definition}"'
            raise AskedError(_asked(open_unit).sentence, f"State it: {line}, or [1] for a ratio.")
    ratio = over_mean(numbers_in_unit(replace(column, meaning=meaning)), meaning.definition)
    if meaning.definition != "over_mean":
        how_known += f", {DEFINITION_IN_WORDS[meaning.definition]}: converted to that over the mean"
    return ratio, how_known


def over_mean(ratio: FloatArray, definition: str) -> FloatArray:
    """A slip over the sum or the faster speed as the slide-roll ratio over the mean speed.

    With sliding speed v and speeds u1, u2: over the sum s = v/(u1 + u2), S = 2 s; over the faster
    one s = v/max(u1, u2), S = 2 s/(2 - |s|).
    """
    if definition == "over_sum":
        return 2 * ratio
    if definition == "over_faster":
        # more than 2 is no ratio of this kind
        size = np.where(np.abs(ratio) < 2, np.abs(ratio), np.nan)
        return 2 * ratio / (2 - size)
    return ratio


def _ratio_of_speeds(values: Mapping[str, FloatArray]) -> FloatArray | None:
    """The slide-roll ratio by the speeds of ball and disc; None where one is not known."""
    if not {"ball_speed", "disc_speed"} <= values.keys():
        return None
    mean = (values["ball_speed"] + values["disc_speed"]) / 2
    return np.asarray((values["disc_speed"] - values["ball_speed"]) / mean)


class _RatioCandidate(NamedTuple):
    """A slide-roll ratio by one definition and unit, and how far it is from that of the speeds."""

    misfit: float
    definition: str
    unit: str
    ratio: FloatArray


def _definition_by_speeds(
    column: TableColumn, ratio_by_speeds: FloatArray
) -> tuple[FloatArray, str] | None:
    """The ratio in the unit and definition that the speeds of both bodies confirm; None if none."""
    meaning = column.meaning
    definitions = [meaning.definition]
    if meaning.question:
        definitions = ["over_mean", "over_sum", "over_faster"]
    units = [meaning.unit] if meaning.unit else ["1", "%"]
    candidates: list[_RatioCandidate] = []
    for definition in definitions:
        for unit in units:
            to_unit = possible_conversion(unit, ("1",))
            if to_unit is not None:
                ratio = over_mean(to_unit.convert(column.numbers), definition)
                misfit = _misfit(ratio, ratio_by_speeds)
                candidates.append(_RatioCandidate(misfit, definition, unit, ratio))
    if not candidates:
        return None
    nearest, *others = sorted(candidates, key=lambda candidate: candidate.misfit)
    is_clear = all(other.misfit > _CLEARLY_FARTHER * nearest.misfit for other in others)
    if nearest.misfit > _CONFIRMED or not is_clear:
        return None
    in_percent = ", in %" if nearest.unit == "%" and not meaning.unit else ""
    definition_in_words = DEFINITION_IN_WORDS[nearest.definition]
    return nearest.ratio, f"{in_percent}, {definition_in_words}: both speeds confirm it"


def _misfit(ratio: FloatArray, ratio_by_speeds: FloatArray) -> float:
    """How far a ratio is from that of the speeds, as the factor between them less 1.

    The factor is that of least squares, with the error in the speeds: their digits, which at a low
    slip are as large as the slip, hardly move it. The sign of the slip is a matter of convention.
    """
    is_known = np.isfinite(ratio) & np.isfinite(ratio_by_speeds)
    squares = float(np.sum(ratio[is_known] ** 2))
    if squares == 0:
        return np.inf
    factor = float(np.sum(np.abs(ratio[is_known] * ratio_by_speeds[is_known]))) / squares
    return abs(factor - 1)


def _refuse_other_ratio(column: TableColumn, ratio_by_speeds: FloatArray) -> None:
    """Refuse a stated ratio that the speeds contradict in every unit that it may have.

    Raises:
        AskedError: They contradict it.
    """
    meaning = column.meaning
    if meaning.question:
        return
    for unit in [meaning.unit] if meaning.unit else ["1", "%"]:
        to_unit = possible_conversion(unit, ("1",))
        if to_unit is None:
            return
        ratio = over_mean(to_unit.convert(column.numbers), meaning.definition)
        difference = float(np.nanmedian(np.abs(np.abs(ratio) - np.abs(ratio_by_speeds))))
        if _misfit(ratio, ratio_by_speeds) <= _CONTRADICTS or difference <= _OPEN_BY_DIGITS:
            return
    raise AskedError(
        f"the column {column.name!r} contradicts the speeds of ball and disc.",
        "Correct the column that is wrong, or leave it out.",
    )


def _refuse_contradictions(values: Mapping[str, FloatArray], names: Mapping[str, str]) -> None:
    """Refuse columns that contradict each other, or whose numbers are those of another quantity.

    Raises:
        AskedError: Two columns contradict each other.
    """
    if {"ball_speed", "disc_speed", "entrainment_speed"} <= values.keys():
        mean = (values["ball_speed"] + values["disc_speed"]) / 2
        if _relative_difference(values["entrainment_speed"], mean) > _CONTRADICTS:
            raise AskedError(
                f"the column {names['entrainment_speed']!r} is not the mean of "
                f"{names['ball_speed']!r} and {names['disc_speed']!r}.",
                "Correct the column that is wrong, or leave it out.",
            )
    pressure = values.get("max_hertz_pressure")
    speed = values.get("entrainment_speed")
    if pressure is not None and speed is not None:
        median_gpa = float(np.nanmedian(pressure))
        median_m_s = float(np.nanmedian(speed))
        if median_gpa > _LARGEST_PRESSURE_GPA and median_m_s < _LARGEST_PRESSURE_GPA:
            raise AskedError(
                f"{names['max_hertz_pressure']!r} is {median_gpa:g} GPa in the median and "
                f"{names['entrainment_speed']!r} is {median_m_s:g} m/s: their columns or units may "
                "be swapped.",
                "Correct the names.",
            )
