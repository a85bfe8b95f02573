"""Assign table columns to quantities, and say what is ambiguous.

A meaning comes from the name of a column, from the user, or from the numbers of other columns. If
none of them gives it, the message asks for it and has the option `--columns` to be pasted.

Decides: which of several columns is taken, which numbers decide a definition or a unit, and when
two columns contradict each other.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from oilfilm.base.errors import OilfilmError, cut
from oilfilm.base.units import FloatArray, possible_conversion
from oilfilm.logs.header import split_bracketed_unit
from oilfilm.logs.meaning import (
    DEFINITION_IN_WORDS,
    DEFINITIONS_OF_QUANTITY,
    UNIT_BY_QUANTITY,
    Meaning,
    is_unit_of,
    meaning_of,
    rank_of,
    split_unit,
)

# A slide-roll ratio is at most 2 while both surfaces move in one direction: more is in %.
_MAX_RATIO = 2.0
# A sweep to a larger ratio is rare. Without a unit it may as well be one in %.
_MAX_USUAL_RATIO = 0.5
# The speeds of both bodies confirm a ratio whose relative difference from theirs is at most this.
_CONFIRMED_WITHIN = 0.02
# Any other definition or unit must be this factor farther from the ratio of the speeds.
_CLEARLY_FARTHER_FACTOR = 3.0
# Two columns contradict each other if their relative difference is more than this. Digits and the
# moduli of one material make 2 %.
_CONTRADICTS_BEYOND = 0.05
# Largest median error of slide-roll ratios from two speeds of three digits; `logged_twice` of
# config/config.yaml allows the same for logs.
_ERROR_OF_DIGITS = 0.005
# Maximum over mean pressure of a circular contact (Hertz 1881).
_MAXIMUM_OVER_MEAN = 1.5
# Steel of bearings is indented by more than this.
_MAX_PRESSURE_GPA = 5.0
# Numbers below this may be pressures in GPa that are in the column of a speed in m/s.
_MAX_SWAPPED_SPEED_M_S = 5.0
# Units to which those of columns are converted to compare them. Units of time are left out, because
# `(min)` and `(h)` in a name may mean something else, such as a minimum.
_UNITS_OF_TABLES = (
    *dict.fromkeys(unit for unit in UNIT_BY_QUANTITY.values() if unit != "s"),
    "rpm",
)
# Advice on columns that have the same name and unit: no line of the user tells them apart.
_RENAME_ADVICE = "Rename one of the columns in the table."
# The word by which a user says that a column is none of the quantities.
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

    @property
    def is_blank(self) -> bool:
        """Whether no row has a number."""
        return not np.isfinite(self.numbers).any()


@dataclass(frozen=True)
class TableNumbers:
    """The numbers of a table by what its columns are.

    Attributes:
        numbers_by_quantity: Numbers of each quantity in its unit of `UNIT_BY_QUANTITY` and its
            first definition, shape (rows,).
        name_by_quantity: Name of the column of each quantity.
        notes: How each meaning is known, in sentences.
    """

    numbers_by_quantity: Mapping[str, FloatArray]
    name_by_quantity: Mapping[str, str]
    notes: Sequence[str]


class ColumnsError(ValueError):
    """A column cannot be used: what is wrong as a sentence, and what to do about it."""

    def __init__(self, sentence: str, advice: str) -> None:
        super().__init__(f"{sentence} {advice}")
        self.sentence = sentence
        self.advice = advice


# ---------------------------------------------------------------- what the user states


@dataclass(frozen=True)
class StatedColumn:
    """A column of which the user says what it is.

    Attributes:
        text: Name, unit and definition as the user writes them.
        meaning_by_name: Name that the text may mean -> the meaning of its column then. The longest
            name is first: `Speed, mean` is the name of a column, or `Speed` with a definition.
    """

    text: str
    meaning_by_name: Mapping[str, Meaning]

    @property
    def quantity(self) -> str:
        """The quantity that the column is."""
        return self.meaning_by_name[self.text].quantity


def stated_columns(text: str | Mapping[str, str]) -> list[StatedColumn]:
    """What a user says of columns.

    Args:
        text: `quantity=name [unit], definition`, several separated by semicolons; or the same as a
            dictionary of quantities. Unit and definition may be left out: then they are those that
            the table says, else the definition of the project. The quantity `nothing` is for a
            column that is none of them.

    Raises:
        OilfilmError: A quantity is not known.

    Examples:
        >>> (column,) = stated_columns("slide_roll_ratio=Schlupf [%], over_sum")
        >>> list(column.meaning_by_name)
        ['Schlupf [%], over_sum', 'Schlupf [%]', 'Schlupf']
    """
    entries: list[tuple[str, str]] = []
    if isinstance(text, str):
        for entry in filter(None, map(str.strip, text.split(";"))):
            quantity, separator, column_text = entry.partition("=")
            if not separator:
                raise OilfilmError(f"--columns: found {entry!r}; expected {_EXPECTED_FORM}.")
            entries.append((quantity.strip(), column_text.strip()))
    else:
        entries = [(str(quantity), str(column_text)) for quantity, column_text in text.items()]
    for quantity, _ in entries:
        if quantity not in (*UNIT_BY_QUANTITY, NOTHING):
            expected = ", ".join((*UNIT_BY_QUANTITY, NOTHING))
            raise OilfilmError(f"--columns: found {quantity!r}; expected one of {expected}.")
    return [_stated_column(quantity, column_text) for quantity, column_text in entries]


def _stated_column(quantity: str, text: str) -> StatedColumn:
    """A column by its quantity and by the text of name, unit and definition."""
    name_and_unit, separator, last_part = text.rpartition(",")
    definition = last_part.strip()
    if not separator or definition not in DEFINITIONS_OF_QUANTITY.get(quantity, ()):
        name_and_unit, definition = text, ""
    name_and_unit = name_and_unit.strip()
    # only a unit in brackets: the user types the name as the table has it
    name, unit = split_bracketed_unit(name_and_unit)
    # a name with its unit needs no other unit
    meaning_by_name = {
        text: Meaning(quantity, definition),
        name_and_unit: Meaning(quantity, definition),
        name: Meaning(quantity, definition, unit),
    }
    return StatedColumn(text, meaning_by_name)


def stated_meaning_by_index(
    column_names: Sequence[str], units: Sequence[str], stated: Sequence[StatedColumn]
) -> dict[int, Meaning]:
    """What the user says of the columns of a table, by the index of the column.

    Args:
        column_names: Names of all columns.
        units: Unit beside the name of each; empty where there is none.
        stated: What the user says.

    Raises:
        ColumnsError: The table has not the column, or has several, or it is stated twice.
    """
    stated_by_index: dict[int, StatedColumn] = {}
    meaning_by_index: dict[int, Meaning] = {}
    for column in stated:
        index, meaning = _index_and_meaning(column, column_names, units)
        if index in stated_by_index:
            first_quantity = stated_by_index[index].quantity
            if first_quantity == column.quantity:
                name_with_unit = _name_with_unit(column_names[index], units[index])
                raise ColumnsError(f"--columns states {name_with_unit!r} twice.", "State it once.")
            quantities = f"{first_quantity} and {column.quantity}"
            raise ColumnsError(
                f"--columns says of {column_names[index]!r} that it is {quantities}.",
                "State one of them.",
            )
        stated_by_index[index] = column
        meaning_by_index[index] = _completed_meaning(meaning, column_names[index], units[index])
    return meaning_by_index


def _index_and_meaning(
    column: StatedColumn, column_names: Sequence[str], units: Sequence[str]
) -> tuple[int, Meaning]:
    """Index of the column that the user states, and its meaning by the user.

    Raises:
        ColumnsError: The table has not the column, or has several.
    """
    for name, meaning in column.meaning_by_name.items():
        indices = _indices_of_name(name, meaning.unit, column_names, units)
        if len(indices) > 1:
            names = [_name_with_unit(column_names[index], units[index]) for index in indices]
            raise ColumnsError(
                f"--columns names {column.text!r}, which may be {' and '.join(map(repr, names))}.",
                _RENAME_ADVICE
                if len(set(names)) < len(names)
                else "Write the name with its unit, as the table has it.",
            )
        if indices:
            return indices[0], meaning
    raise _missing_column_error(column.text, column_names)


def _missing_column_error(text: str, column_names: Sequence[str]) -> ColumnsError:
    """The error for a column that the user states and the table has not."""
    return ColumnsError(
        f"--columns names {text!r}, which the table has not, or which holds no "
        f"numbers; its columns are {cut(', '.join(map(repr, column_names)))}.",
        "Write the name as the table has it.",
    )


def _indices_of_name(
    name: str, unit: str, column_names: Sequence[str], units: Sequence[str]
) -> list[int]:
    """Indices of the columns with a name; of several, those that most likely are meant by the unit.

    Args:
        name: The name, or the name without its unit.
        unit: The unit that the user states; empty without one.
        column_names: Names of all columns.
        units: Unit beside the name of each; empty where there is none.
    """
    if not unit and column_names.count(name) == 1:
        return [column_names.index(name)]
    indices = [
        index
        for index, column_name in enumerate(column_names)
        if name in (column_name, split_bracketed_unit(column_name)[0], split_unit(column_name)[0])
    ]
    if len(indices) < 2:
        return indices
    unit_by_index = {index: units[index] or _unit_in_name(column_names[index]) for index in indices}
    indices_by_likelihood = (
        [index for index in indices if unit_by_index[index] == unit],
        [index for index in indices if _is_same_unit(unit_by_index[index], unit)],
        # the user may give a column its unit
        [index for index in indices if not unit_by_index[index]],
    )
    return next(filter(None, indices_by_likelihood), indices)


def _is_same_unit(unit: str, other_unit: str) -> bool:
    """Whether two units are one by factor and offset, as degC and °C."""
    if unit == other_unit:
        return True
    to_common_unit = possible_conversion(unit, _UNITS_OF_TABLES)
    other_to_common_unit = possible_conversion(other_unit, _UNITS_OF_TABLES)
    if to_common_unit is None or other_to_common_unit is None:
        return False
    return (
        to_common_unit.unit == other_to_common_unit.unit
        and math.isclose(to_common_unit.scale, other_to_common_unit.scale)
        and math.isclose(to_common_unit.offset, other_to_common_unit.offset, abs_tol=1e-9)
    )


_EXPECTED_FORM = '"quantity=name [unit], definition", as "slide_roll_ratio=Schlupf [%], over_sum"'


# ---------------------------------------------------------------- which column


def chosen_columns(
    column_names: Sequence[str],
    units: Sequence[str],
    numbers_by_index: Mapping[int, FloatArray],
    stated_by_index: Mapping[int, Meaning],
) -> tuple[dict[str, TableColumn], list[str]]:
    """The column that is taken for each quantity, and notes on columns that were not taken.

    Args:
        column_names: Names of all columns.
        units: Unit beside the name of each; empty where there is none.
        numbers_by_index: Numbers of the columns that hold numbers, by index.
        stated_by_index: Meaning of the columns that the user states, by index.

    Raises:
        ColumnsError: Two columns may be one quantity, or a stated column holds no numbers.
    """
    candidates_by_quantity: dict[str, list[TableColumn]] = {}
    for index, column_name in enumerate(column_names):
        meaning = stated_by_index.get(index) or meaning_of(column_name, units[index])
        if meaning is None or meaning.quantity == NOTHING:
            continue
        if index not in numbers_by_index:
            if index in stated_by_index:
                raise _missing_column_error(column_name, column_names)
            continue
        column = TableColumn(
            column_name, meaning, numbers_by_index[index], by_user=index in stated_by_index
        )
        candidates_by_quantity.setdefault(meaning.quantity, []).append(column)
    column_by_quantity: dict[str, TableColumn] = {}
    notes: list[str] = []
    for quantity, all_candidates in candidates_by_quantity.items():
        # a blank column is taken only where there is no other
        candidates = [
            column for column in all_candidates if column.by_user or not column.is_blank
        ] or all_candidates
        ranks = [_rank_of_column(column) for column in candidates]
        best_rank = min(ranks)
        best_columns = [
            column for column, rank in zip(candidates, ranks, strict=True) if rank == best_rank
        ]
        if len(best_columns) > 1:
            names = [_name_with_unit(column.name, column.meaning.unit) for column in best_columns]
            raise ColumnsError(
                f"the columns {' and '.join(map(repr, names))} could both be the "
                f"{quantity.replace('_', ' ')}.",
                _RENAME_ADVICE
                if len(set(names)) < len(names)
                else _option_to_paste(best_columns[0]),
            )
        column_by_quantity[quantity] = best_columns[0]
        names_not_taken = [
            column.name for column in all_candidates if column is not best_columns[0]
        ]
        if names_not_taken:
            quoted_names = ", ".join(map(repr, names_not_taken))
            notes.append(f"not read as the {quantity.replace('_', ' ')}: {quoted_names}")
    return column_by_quantity, notes


def _completed_meaning(stated_meaning: Meaning, column_name: str, unit_beside: str) -> Meaning:
    """What the user says of a column, completed by unit and definition from its name.

    Raises:
        ColumnsError: The unit of the user contradicts that of the table.
    """
    _refuse_other_unit(stated_meaning, column_name, unit_beside)
    unit = stated_meaning.unit or unit_beside or _unit_in_name(column_name)
    definition = stated_meaning.definition
    definitions = DEFINITIONS_OF_QUANTITY.get(stated_meaning.quantity, ())
    if not definition and definitions:
        definition = definitions[0]
        likely_meaning = meaning_of(column_name, unit_beside)
        if likely_meaning is not None and likely_meaning.quantity == stated_meaning.quantity:
            definition = likely_meaning.definition or definition
    return replace(stated_meaning, unit=unit, definition=definition)


def _refuse_other_unit(stated_meaning: Meaning, column_name: str, unit_beside: str) -> None:
    """Refuse a unit of the user that is not that of the name, or that beside the name.

    A text that is no known unit contradicts nothing: `Speed (drive)`. Nor does a word at an end of
    a name that is no unit of the quantity: `rev speed`.

    Raises:
        ColumnsError: The units differ by factor or offset.
    """
    unit_in_name = _unit_in_name(column_name)
    is_in_brackets = split_bracketed_unit(column_name)[1] != ""
    quantity = stated_meaning.quantity
    if not is_in_brackets and (quantity == NOTHING or not is_unit_of(unit_in_name, quantity)):
        unit_in_name = ""
    for unit in (unit_beside, unit_in_name):
        is_known_unit = possible_conversion(unit, _UNITS_OF_TABLES) is not None
        if stated_meaning.unit and is_known_unit and not _is_same_unit(unit, stated_meaning.unit):
            raise ColumnsError(
                f"the column {column_name!r} has the unit {unit!r}, and --columns says "
                f"{stated_meaning.unit!r}.",
                "Leave the unit out of --columns, or correct it in the table.",
            )


def _rank_of_column(column: TableColumn) -> int:
    """Rank of a column among those of one quantity; the smallest is taken, the user's first."""
    return 0 if column.by_user else rank_of(column.meaning)


def _option_to_paste(column: TableColumn) -> str:
    """The option `--columns` that states what a column is, to be pasted into the command."""
    meaning = column.meaning
    usual_unit = (
        "m/s" if meaning.definition == "sliding_speed" else UNIT_BY_QUANTITY[meaning.quantity]
    )
    likely_unit = meaning.unit or usual_unit
    name_with_unit = _name_with_unit(column.name, "" if likely_unit == "1" else likely_unit)
    definitions = DEFINITIONS_OF_QUANTITY.get(meaning.quantity, ())
    definition_part = f", {meaning.definition or definitions[0]}" if definitions else ""
    line = f'--columns "{meaning.quantity}={name_with_unit}{definition_part}"'
    if len(definitions) > 1 and not meaning.definition:
        other_definitions = " or ".join(definitions[1:])
        return (
            f"State which: {line}; {other_definitions} in place of {definitions[0]}; "
            f"{_option_for_no_quantity(column)}."
        )
    return f"State it: {line}; {_option_for_no_quantity(column)}."


def _option_for_no_quantity(column: TableColumn) -> str:
    """How to say that a column is none of the quantities."""
    name_with_unit = _name_with_unit(column.name, column.meaning.unit)
    return f'--columns "{NOTHING}={name_with_unit}" if it is something else'


def _name_with_unit(column_name: str, unit: str) -> str:
    """A name with its unit: as it is where it states one, else with the unit in brackets."""
    if not unit or _unit_in_name(column_name):
        return column_name
    return f"{column_name} [{unit}]"


def _unit_in_name(column_name: str) -> str:
    """The unit that a name states; empty where it states none, as the symbol `F_n`."""
    meaning = meaning_of(column_name)
    return split_unit(column_name)[1] if meaning is None else meaning.unit


# ---------------------------------------------------------------- what the numbers say


def numbers_of_table(
    column_by_quantity: Mapping[str, TableColumn],
    notes: Sequence[str],
    hertz_pressure_gpa: FloatArray | None,
    speed_m_s: float | None = None,
) -> TableNumbers:
    """The numbers of a table in the units and definitions of the project.

    Args:
        column_by_quantity: The column of each quantity.
        notes: Notes so far.
        hertz_pressure_gpa: Maximum Hertz pressure of the load in GPa, shape (rows,), where load,
            radius and materials are known.
        speed_m_s: Mean speed of all rows, where the user gives it.

    Raises:
        ColumnsError: A definition or a unit is open, and no other column decides it; or two columns
            contradict each other.
    """
    notes = list(notes)
    numbers_by_quantity: dict[str, FloatArray] = {}
    name_by_quantity = {quantity: column.name for quantity, column in column_by_quantity.items()}
    # speeds first: they decide what a slip is
    quantities_in_order = sorted(
        column_by_quantity, key=lambda quantity: quantity == "slide_roll_ratio"
    )
    for quantity in quantities_in_order:
        column = column_by_quantity[quantity]
        numbers: FloatArray | None
        if quantity == "slide_roll_ratio":
            numbers, how_known = _slide_roll_ratio(column, numbers_by_quantity, speed_m_s)
        elif quantity == "max_hertz_pressure":
            numbers, how_known = _max_hertz_pressure(column, hertz_pressure_gpa)
        elif quantity == "entrainment_speed":
            numbers, how_known = _mean_speed(column, column_by_quantity)
        else:
            numbers, how_known = numbers_in_unit(column), ""
        if numbers is None:
            continue
        numbers_by_quantity[quantity] = numbers
        notes.append(_note_on_column(quantity, column, how_known))
    _refuse_contradictions(numbers_by_quantity, name_by_quantity)
    return TableNumbers(numbers_by_quantity, name_by_quantity, notes)


def _note_on_column(quantity: str, column: TableColumn, how_known: str) -> str:
    """A sentence on which column is a quantity, and how that is known."""
    unit = column.meaning.unit
    unit_note = f", in {unit}" if unit and unit != "1" else ""
    user_note = ", as --columns says" if column.by_user else ""
    return f"{quantity} is {column.name!r}{unit_note}{user_note}{how_known}"


def numbers_in_unit(column: TableColumn) -> FloatArray:
    """The numbers of a column in the unit of its quantity.

    Raises:
        ColumnsError: It has no unit, or an impossible one.
    """
    meaning = column.meaning
    if meaning.question:
        raise _question_error(column)
    target_unit = UNIT_BY_QUANTITY[meaning.quantity]
    if meaning.definition == "sliding_speed":
        target_unit = "m/s"
    unit = meaning.unit
    if not unit and target_unit == "1":
        unit = "1"
    if not unit:
        quantity = meaning.quantity.replace("_", " ")
        raise ColumnsError(
            f"the column {column.name!r}, the {quantity}, has no unit.", _option_to_paste(column)
        )
    to_unit = possible_conversion(unit, (target_unit,))
    if to_unit is None:
        raise ColumnsError(
            f"the column {column.name!r} is in {unit!r}; expected {target_unit}.",
            "Correct the unit, or the name.",
        )
    return to_unit.convert(column.numbers)


def _question_error(column: TableColumn) -> ColumnsError:
    """The error for a column whose meaning is open, with the line that answers it."""
    quantity = column.meaning.quantity.replace("_", " ")
    return ColumnsError(
        f"the column {column.name!r} would be the {quantity}, but {column.meaning.question}.",
        _option_to_paste(column),
    )


def contradict(numbers: FloatArray, reference: FloatArray) -> bool:
    """Whether two columns of one quantity contradict each other: digits and moduli explain less."""
    return _relative_difference(numbers, reference) > _CONTRADICTS_BEYOND


def _relative_difference(numbers: FloatArray, reference: FloatArray) -> float:
    """Median difference of two columns over the largest number of the reference.

    Infinite if the reference is zero in all rows. NaN without a row in which both are known: then
    no column confirms or contradicts the other.
    """
    is_known = np.isfinite(numbers) & np.isfinite(reference)
    if not is_known.any():
        return np.nan
    largest_reference = float(np.max(np.abs(reference[is_known]), initial=0.0))
    if largest_reference == 0:
        return np.inf
    return float(np.median(np.abs(numbers[is_known] - reference[is_known]))) / largest_reference


def _max_hertz_pressure(
    column: TableColumn, hertz_pressure_gpa: FloatArray | None
) -> tuple[FloatArray, str]:
    """The maximum Hertz pressure, and how it is known."""
    meaning = column.meaning
    if meaning.question and hertz_pressure_gpa is not None:
        numbers = numbers_in_unit(replace(column, meaning=replace(meaning, question="")))
        for definition, factor in (("maximum", 1.0), ("mean", _MAXIMUM_OVER_MEAN)):
            if _relative_difference(factor * numbers, hertz_pressure_gpa) <= _CONTRADICTS_BEYOND:
                return factor * numbers, f", the {definition}: load and ball radius give it"
    numbers = numbers_in_unit(column)
    if meaning.definition == "mean":
        how_known = (
            f", the mean: the maximum is {_MAXIMUM_OVER_MEAN:g} times it in a circular contact"
        )
        return _MAXIMUM_OVER_MEAN * numbers, how_known
    return numbers, ""


def _mean_speed(
    column: TableColumn, column_by_quantity: Mapping[str, TableColumn]
) -> tuple[FloatArray | None, str]:
    """The mean of both surface speeds, and how it is known; None where ball and disc give it."""
    meaning = column.meaning
    if meaning.question and {"ball_speed", "disc_speed"} <= column_by_quantity.keys():
        return None, ""
    numbers = numbers_in_unit(column)
    if meaning.definition == "sum":
        return numbers / 2, f", {DEFINITION_IN_WORDS['sum']}: halved"
    return numbers, ""


def _slide_roll_ratio(
    column: TableColumn, numbers_by_quantity: Mapping[str, FloatArray], speed_m_s: float | None
) -> tuple[FloatArray, str]:
    """The slide-roll ratio over the mean speed, and how unit and definition are known."""
    meaning = column.meaning
    ratio_of_speeds = _ratio_of_speeds(numbers_by_quantity)
    if meaning.definition == "sliding_speed":
        mean_speed: FloatArray | float | None
        mean_speed = numbers_by_quantity.get("entrainment_speed", speed_m_s)
        if mean_speed is None and ratio_of_speeds is not None:
            mean_speed = (numbers_by_quantity["ball_speed"] + numbers_by_quantity["disc_speed"]) / 2
        if mean_speed is None:
            raise ColumnsError(
                f"the column {column.name!r} is a sliding speed; the slide-roll ratio needs the "
                "speed of rolling as well.",
                "Add it, or give it for all rows, as --speed 2m/s.",
            )
        ratio = slide_roll_ratio_of_speeds(numbers_in_unit(column), mean_speed)
        if ratio_of_speeds is not None and _contradicts_speeds(ratio, ratio_of_speeds):
            raise _contradiction_error(column)
        return ratio, ", a sliding speed: divided by the mean speed"
    if ratio_of_speeds is not None:
        ratio_and_how_known = _ratio_confirmed_by_speeds(column, ratio_of_speeds)
        if ratio_and_how_known is not None:
            return ratio_and_how_known
        _refuse_ratio_against_speeds(column, ratio_of_speeds)
    if meaning.question:
        raise _question_error(column)
    # a ratio that was divided by zero is infinite, and tells no unit
    known_numbers = column.numbers[np.isfinite(column.numbers)]
    largest_number = float(np.max(np.abs(known_numbers), initial=0))
    how_known = ""
    if not meaning.unit:
        if largest_number > _MAX_RATIO:
            how_known = f", in %: as a ratio it is at most 2, and it goes up to {largest_number:g}"
            meaning = replace(meaning, unit="%")
        elif largest_number > _MAX_USUAL_RATIO:
            question = (
                f"it goes up to {largest_number:g} and has no unit: it may be a ratio or in %"
            )
            column_in_doubt = replace(column, meaning=replace(meaning, question=question))
            line = f'--columns "slide_roll_ratio={column.name} [%], {meaning.definition}"'
            sentence = _question_error(column_in_doubt).sentence
            raise ColumnsError(sentence, f"State it: {line}, or [1] for a ratio.")
    ratio = converted_to_over_mean(
        numbers_in_unit(replace(column, meaning=meaning)), meaning.definition
    )
    if meaning.definition != "over_mean":
        how_known += f", {DEFINITION_IN_WORDS[meaning.definition]}: converted to that over the mean"
    return ratio, how_known


def converted_to_over_mean(ratio: FloatArray, definition: str) -> FloatArray:
    """The slide-roll ratio over the mean speed, from a ratio by any definition.

    With sliding speed v and speeds u1, u2: over the sum s = v/(u1 + u2), S = 2 s; over the faster
    one s = v/max(u1, u2), S = 2 s/(2 - |s|).

    Args:
        ratio: Logged ratio, as a fraction, shape (rows,).
        definition: `over_mean`, `over_sum` or `over_faster`.
    """
    if definition == "over_sum":
        return 2 * ratio
    if definition == "over_faster":
        # a ratio of 2 or more is impossible by this definition
        absolute_ratio = np.where(np.abs(ratio) < 2, np.abs(ratio), np.nan)
        return 2 * ratio / (2 - absolute_ratio)
    return ratio


def _ratio_of_speeds(numbers_by_quantity: Mapping[str, FloatArray]) -> FloatArray | None:
    """The slide-roll ratio by the speeds of ball and disc; None where one is not known."""
    if not {"ball_speed", "disc_speed"} <= numbers_by_quantity.keys():
        return None
    ball_m_s = numbers_by_quantity["ball_speed"]
    disc_m_s = numbers_by_quantity["disc_speed"]
    return slide_roll_ratio_of_speeds(disc_m_s - ball_m_s, (ball_m_s + disc_m_s) / 2)


def slide_roll_ratio_of_speeds(sliding_m_s: FloatArray, mean_m_s: FloatArray | float) -> FloatArray:
    """S: sliding speed over mean speed; NaN where the mean is 0, as at standstill."""
    known_mean_m_s = np.where(np.equal(mean_m_s, 0), np.nan, mean_m_s)
    return np.asarray(sliding_m_s / known_mean_m_s)


class _RatioCandidate(NamedTuple):
    """A slide-roll ratio by one definition and unit, and how far it is from that of the speeds."""

    misfit: float
    definition: str
    unit: str
    ratio: FloatArray


def _ratio_confirmed_by_speeds(
    column: TableColumn, ratio_of_speeds: FloatArray
) -> tuple[FloatArray, str] | None:
    """The ratio in the unit and definition that the speeds confirm, and how it is known.

    None if they confirm none, or not clearly.
    """
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
                ratio = converted_to_over_mean(to_unit.convert(column.numbers), definition)
                misfit = _misfit(ratio, ratio_of_speeds)
                candidates.append(_RatioCandidate(misfit, definition, unit, ratio))
    if not candidates:
        return None
    nearest_candidate, *others = sorted(candidates, key=lambda candidate: candidate.misfit)
    clearly_farther = _CLEARLY_FARTHER_FACTOR * nearest_candidate.misfit
    is_clear = all(other.misfit > clearly_farther for other in others)
    if nearest_candidate.misfit > _CONFIRMED_WITHIN or not is_clear:
        return None
    percent_note = ", in %" if nearest_candidate.unit == "%" and not meaning.unit else ""
    definition_in_words = DEFINITION_IN_WORDS[nearest_candidate.definition]
    return nearest_candidate.ratio, f"{percent_note}, {definition_in_words}: both speeds confirm it"


def _misfit(ratio: FloatArray, ratio_of_speeds: FloatArray) -> float:
    """How far a ratio is from that of the speeds: |f - 1| with the factor f between them.

    f minimises the sum of (|ratio_of_speeds| - f |ratio|)^2. At a low slip the last digits of the
    speeds are as large as the slip; such rows hardly move f. Signs are ignored, because the sign of
    the slip is a matter of convention.
    """
    is_known = np.isfinite(ratio) & np.isfinite(ratio_of_speeds)
    sum_of_squares = float(np.sum(ratio[is_known] ** 2))
    if sum_of_squares == 0:
        return np.inf
    factor = float(np.sum(np.abs(ratio[is_known] * ratio_of_speeds[is_known]))) / sum_of_squares
    return abs(factor - 1)


def _refuse_ratio_against_speeds(column: TableColumn, ratio_of_speeds: FloatArray) -> None:
    """Refuse a stated ratio that the speeds contradict in every unit that it may have.

    Raises:
        ColumnsError: They contradict it.
    """
    meaning = column.meaning
    is_known = np.isfinite(column.numbers) & np.isfinite(ratio_of_speeds)
    if meaning.question or not is_known.any():
        return
    for unit in [meaning.unit] if meaning.unit else ["1", "%"]:
        to_unit = possible_conversion(unit, ("1",))
        if to_unit is None:
            return
        ratio = converted_to_over_mean(to_unit.convert(column.numbers), meaning.definition)
        # in a unit in which all numbers are impossible, the column is no ratio
        is_possible = np.isfinite(ratio[is_known]).any()
        if is_possible and not _contradicts_speeds(ratio, ratio_of_speeds):
            return
    raise _contradiction_error(column)


def _contradicts_speeds(ratio: FloatArray, ratio_of_speeds: FloatArray) -> bool:
    """Whether a slide-roll ratio is not that of the speeds, nor within the error of their digits.

    False without a row in which both are known.
    """
    is_known = np.isfinite(ratio) & np.isfinite(ratio_of_speeds)
    if not is_known.any():
        return False
    differences = np.abs(np.abs(ratio[is_known]) - np.abs(ratio_of_speeds[is_known]))
    return (
        _misfit(ratio, ratio_of_speeds) > _CONTRADICTS_BEYOND
        and float(np.median(differences)) > _ERROR_OF_DIGITS
    )


def _contradiction_error(column: TableColumn) -> ColumnsError:
    """The error for a slip that the speeds of ball and disc contradict."""
    return ColumnsError(
        f"the column {column.name!r} contradicts the speeds of ball and disc.",
        "Correct the column that is wrong, or leave it out.",
    )


def _refuse_contradictions(
    numbers_by_quantity: Mapping[str, FloatArray], name_by_quantity: Mapping[str, str]
) -> None:
    """Refuse columns that contradict each other, or whose numbers are those of another quantity.

    Raises:
        ColumnsError: Two columns contradict each other.
    """
    if {"ball_speed", "disc_speed", "entrainment_speed"} <= numbers_by_quantity.keys():
        mean_m_s = (numbers_by_quantity["ball_speed"] + numbers_by_quantity["disc_speed"]) / 2
        if contradict(numbers_by_quantity["entrainment_speed"], mean_m_s):
            raise ColumnsError(
                f"the column {name_by_quantity['entrainment_speed']!r} is not the mean of "
                f"{name_by_quantity['ball_speed']!r} and {name_by_quantity['disc_speed']!r}.",
                "Correct the column that is wrong, or leave it out.",
            )
    pressure_gpa = numbers_by_quantity.get("max_hertz_pressure")
    speed_m_s = numbers_by_quantity.get("entrainment_speed")
    if pressure_gpa is not None and speed_m_s is not None:
        median_gpa = _median_of_known(pressure_gpa)
        median_m_s = _median_of_known(speed_m_s)
        if median_gpa > _MAX_PRESSURE_GPA and median_m_s < _MAX_SWAPPED_SPEED_M_S:
            raise ColumnsError(
                f"{name_by_quantity['max_hertz_pressure']!r} is {median_gpa:g} GPa in the median "
                f"and {name_by_quantity['entrainment_speed']!r} is {median_m_s:g} m/s: their "
                "columns or units may be swapped.",
                "Correct the names.",
            )


def _median_of_known(numbers: FloatArray) -> float:
    """Median of the numbers that are known; NaN without one."""
    known_numbers = numbers[np.isfinite(numbers)]
    return float(np.median(known_numbers)) if len(known_numbers) else np.nan
