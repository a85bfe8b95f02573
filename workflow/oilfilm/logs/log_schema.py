"""What the logs of one kind of rig may hold, and what the names of their columns mean.

A column of the project has the name that oilfilm uses itself, as `load_n`.

Decides: how the name of a column becomes a quantity and a unit (the names themselves are in
`traction_log.py`, `torque_log.py` and, for another laboratory or language, under `columns` of the
campaign file, where `oilfilm init` puts what it recognises by `words.yaml`).
"""

import unicodedata
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from oilfilm.base.plain_key import plain_key
from oilfilm.base.units import Conversion, FloatArray, IndexArray, conversion, possible_conversion
from oilfilm.logs import base
from oilfilm.logs.header import FULL_WIDTH_TO_ASCII, split_bracketed_unit
from oilfilm.settings import campaign as campaign_file
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.resolved import Settings


class QuantityAndUnit(NamedTuple):
    """What a column measures, and its unit, by its name.

    Attributes:
        quantity: What it measures, as `inlet_temperature`.
        unit: Unit of its numbers; empty where something else must give it.
    """

    quantity: str
    unit: str


# Index of a column of a log -> its quantity and unit. Columns of no known quantity are left out.
QuantitiesAndUnits = Mapping[int, QuantityAndUnit]
# Quantity -> the names and the unit of its column, as the campaign file lists them.
ListedColumns = Mapping[str, campaign_file.Column]
# Problems of a header, one per check. None where the check finds no problem.
HeaderProblems = Iterator[base.Refusal | None]


@dataclass(frozen=True)
class LoggedColumn:
    """A column of a log that is read, and its conversion to the reader's unit.

    Attributes:
        quantity: What it measures.
        index: Its index among the columns of the log.
        conversion: Conversion of its numbers to the reader's unit.
        name: Name in the log.
        logged_unit: Unit of its numbers, by the log or by the campaign file.
        is_spare: Whether a row can be used without it: other columns give the same quantity, or the
            format leaves its cells blank. A spare column is compared with the others.
    """

    quantity: str
    index: int
    conversion: Conversion
    name: str
    logged_unit: str
    is_spare: bool = False

    def summary(self, logged_numbers: FloatArray) -> base.ColumnSummary:
        """The range of the column's numbers and their count.

        Args:
            logged_numbers: Numbers as logged, shape (rows,); NaN where a cell has none.
        """
        # the extremes are tested first: they are NaN or infinite where a number is
        are_all_finite = len(logged_numbers) > 0 and bool(
            np.isfinite([logged_numbers.min(), logged_numbers.max()]).all()
        )
        numbers = logged_numbers if are_all_finite else logged_numbers[np.isfinite(logged_numbers)]
        extremes = np.array([np.nan, np.nan])
        if len(numbers):
            extremes = np.array([numbers.min(), numbers.max()])
        # a conversion with a negative factor exchanges them
        minimum, maximum = np.sort(self.conversion.convert(extremes))
        return base.ColumnSummary(
            name=self.name,
            logged_unit=self.logged_unit,
            quantity=self.quantity,
            unit=self.conversion.unit,
            minimum=float(minimum),
            maximum=float(maximum),
            count=len(numbers),
            missing=len(logged_numbers) - len(numbers),
        )


@dataclass(frozen=True)
class Vocabulary:
    """What the logs of one kind of rig may hold.

    Attributes:
        name: Kind of log, in one word.
        columns_key: Key of the campaign file that lists other names of columns.
        quantity_and_unit_of_column: Quantity and unit of each column of the project, by the name of
            the column, which ends in the unit.
        required_quantities: Quantities that every log must have.
        alternative_quantities: Sets of quantities of which a log must have one. A message about
            missing columns names the first set. A log may have quantities of later sets too: they
            are spare columns.
        optional_quantities: Quantities that a log may have. Where a log has one, every row needs
            it.
        substitute_of_quantity: Quantity -> the quantity that replaces it in a log without it.
        listed_columns: Quantity -> names and unit of its column, from the campaign file.
    """

    name: str
    columns_key: str
    quantity_and_unit_of_column: Mapping[str, tuple[str, str]]
    required_quantities: tuple[str, ...]
    alternative_quantities: tuple[tuple[str, ...], ...] = ((),)
    optional_quantities: tuple[str, ...] = ()
    substitute_of_quantity: Mapping[str, str] = field(default_factory=dict)
    listed_columns: ListedColumns = field(default_factory=dict)

    @cached_property
    def units_of_quantity(self) -> Mapping[str, tuple[str, ...]]:
        """Quantity -> the units to which it can be converted."""
        units_of_quantity: dict[str, tuple[str, ...]] = {}
        for quantity, unit in self.quantity_and_unit_of_column.values():
            units_of_quantity[quantity] = (*units_of_quantity.get(quantity, ()), unit)
        return units_of_quantity

    @property
    def advice(self) -> str:
        """What to do about a log whose columns cannot be understood."""
        names = f"Other names: see `{self.columns_key}` of the campaign file."
        return f"data/raw/README.md describes the format. {names}"

    def is_convertible(self, quantity: str, unit: str) -> bool:
        """Whether a quantity can be given in that unit."""
        return possible_conversion(unit, self.units_of_quantity[quantity]) is not None

    def quantity_and_unit(self, name: str) -> QuantityAndUnit | None:
        """Quantity and unit of a column by its name; None where the name is not known."""
        bare_name, unit = split_bracketed_unit(name)
        for quantity, listed_column in self.listed_columns.items():
            if _is_listed(name, listed_column):
                return QuantityAndUnit(quantity, listed_column.unit or unit)
        key = plain_key(bare_name)
        if key in self.quantity_and_unit_of_column:
            quantity, unit_in_name = self.quantity_and_unit_of_column[key]
            return QuantityAndUnit(quantity, unit or unit_in_name)
        if key in self.units_of_quantity:
            return QuantityAndUnit(key, unit)
        return None

    def quantities_and_units(
        self, names: Sequence[str], units: Sequence[str]
    ) -> dict[int, QuantityAndUnit]:
        """Quantity and unit of each column with a known quantity, by its index.

        Where the campaign file lists a column of the log, other columns of the same quantity are
        left out. The unit beside a name is taken, unless only that of the name can be used.

        Args:
            names: All column names, in the order of the columns.
            units: Unit that the log gives beside each name; empty where there is none.
        """
        quantity_and_unit_of_index: dict[int, QuantityAndUnit] = {}
        for index, name in enumerate(names):
            quantity_and_unit = self.quantity_and_unit(name)
            if quantity_and_unit is not None:
                quantity_and_unit_of_index[index] = quantity_and_unit
        listed_quantity_of_index: dict[int, str] = {}
        for index, (quantity, _) in quantity_and_unit_of_index.items():
            if quantity in self.listed_columns and _is_listed(
                names[index], self.listed_columns[quantity]
            ):
                listed_quantity_of_index[index] = quantity
        quantities_and_units: dict[int, QuantityAndUnit] = {}
        for index, (quantity, unit_of_name) in quantity_and_unit_of_index.items():
            if (
                index not in listed_quantity_of_index
                and quantity in listed_quantity_of_index.values()
            ):
                continue
            unit = units[index]
            is_usable = unit and self.is_convertible(quantity, unit)
            if unit_of_name and not is_usable:
                unit = unit_of_name
            quantities_and_units[index] = QuantityAndUnit(quantity, unit)
        return quantities_and_units

    def columns_of_run(
        self,
        names: Sequence[str],
        units: Sequence[str],
        unneeded_quantities: Set[str] = frozenset(),
    ) -> tuple[LoggedColumn, ...]:
        """The columns that make a run, each with its conversion, then the spare ones.

        Args:
            names: All column names.
            units: Unit beside each name.
            unneeded_quantities: Quantities for which the log needs no column.

        Raises:
            ValueError: A quantity is missing or doubled, or has no unit or an impossible one. The
                message is a sentence for the user.
        """
        quantities_and_units = self.quantities_and_units(names, units)
        count_of_quantity = Counter(quantity for quantity, _ in quantities_and_units.values())
        for quantity, count in count_of_quantity.items():
            if count > 1:
                names_of_quantity = [
                    names[index]
                    for index, quantity_and_unit in quantities_and_units.items()
                    if quantity_and_unit.quantity == quantity
                ]
                logged_in_words = " and ".join(repr(name[:60]) for name in names_of_quantity)
                raise ValueError(
                    f"the columns {logged_in_words} are the same quantity {quantity!r} and hold "
                    f"different numbers; list the one that counts under `{self.columns_key}` of "
                    "the campaign file, or rename the others"
                )
        chosen_alternative = self._chosen_alternative(
            count_of_quantity.keys() | unneeded_quantities
        )
        needed_quantities = self._needed_quantities(
            chosen_alternative, count_of_quantity.keys(), unneeded_quantities
        )
        # before the units: a log of another kind gets the message that columns are missing
        missing_quantities = [
            quantity for quantity in needed_quantities if quantity not in count_of_quantity
        ]
        if missing_quantities:
            raise ValueError(self._sentence_on_missing(missing_quantities, names))
        column_by_quantity = {
            quantity: self._column_with_conversion(
                index, quantity, unit, names[index], units[index]
            )
            for index, (quantity, unit) in quantities_and_units.items()
        }
        needed_quantities += [
            quantity for quantity in self.optional_quantities if quantity in column_by_quantity
        ]
        needed_columns = [column_by_quantity[quantity] for quantity in needed_quantities]
        spare_columns: list[LoggedColumn] = []
        chosen_index = self.alternative_quantities.index(chosen_alternative)
        for alternative in self.alternative_quantities[chosen_index + 1 :]:
            for quantity in alternative:
                if quantity in column_by_quantity:
                    spare_columns.append(replace(column_by_quantity[quantity], is_spare=True))
        return (*needed_columns, *spare_columns)

    def _chosen_alternative(self, quantities: Set[str]) -> tuple[str, ...]:
        """The first set of quantities that a log has completely; without one the first set."""
        for alternative in self.alternative_quantities:
            if quantities >= set(alternative):
                return alternative
        return self.alternative_quantities[0]

    def _needed_quantities(
        self,
        chosen_alternative: tuple[str, ...],
        quantities: Set[str],
        unneeded_quantities: Set[str],
    ) -> list[str]:
        """Quantities that a log with some quantities needs, substitutes in place of missing ones.

        Args:
            chosen_alternative: The set of `alternative_quantities` that counts.
            quantities: The quantities of the log.
            unneeded_quantities: As for `columns_of_run`.
        """
        needed_quantities: list[str] = []
        for quantity in (*self.required_quantities, *chosen_alternative):
            if quantity in quantities:
                needed_quantities.append(quantity)
            elif quantity not in unneeded_quantities:
                substitute = self.substitute_of_quantity.get(quantity, "")
                needed_quantities.append(substitute if substitute in quantities else quantity)
        return needed_quantities

    def _column_with_conversion(
        self, index: int, quantity: str, unit: str, name: str, unit_beside_name: str
    ) -> LoggedColumn:
        """A column of the log with its conversion.

        Raises:
            ValueError: As in `columns_of_run`.
        """
        if not unit:
            raise ValueError(
                f"the column {name[:60]!r} has no unit; write it in brackets, in a row below "
                f"the names or under `{self.columns_key}` of the campaign file"
            )
        try:
            conversion_used = conversion(unit, self.units_of_quantity[quantity])
        except ValueError as error:
            raise ValueError(f"the column {name[:60]!r}: {error}") from error
        # time stamps are in seconds; a unit in their name does not count
        if not (quantity == "time" and unit_beside_name == "s"):
            self._refuse_contradictory_units(quantity, name, unit_beside_name)
        return LoggedColumn(quantity, index, conversion_used, name, logged_unit=unit)

    def _refuse_contradictory_units(self, quantity: str, name: str, unit_beside_name: str) -> None:
        """Refuse a column of which the name, the log and the campaign file state different units.

        Raises:
            ValueError: Two of these are units of the quantity, and differ.
        """
        bare_name, unit_in_brackets = split_bracketed_unit(name)
        key = plain_key(bare_name)
        # the name of a ratio, which is that of its quantity, states no unit
        _, unit_in_key = (
            self.quantity_and_unit_of_column.get(key, ("", "")) if key != quantity else ("", "")
        )
        unit_by_log = unit_beside_name or unit_in_brackets
        for unit_in_name in (unit_in_brackets, unit_in_key):
            if self._are_contradictory(quantity, unit_in_name, unit_by_log):
                raise ValueError(
                    f"the column {name[:60]!r} is in {unit_in_name!r} by its name and in "
                    f"{unit_by_log!r} by the unit beside or below it; correct the one that is "
                    "wrong"
                )
        listed_column = self.listed_columns.get(quantity)
        if listed_column is None or not _is_listed(name, listed_column):
            return
        if self._are_contradictory(quantity, unit_by_log, listed_column.unit or ""):
            raise ValueError(
                f"the column {name[:60]!r} is in {unit_by_log!r} by the log itself and in "
                f"{listed_column.unit!r} by `{self.columns_key}` of the campaign file; take out "
                "the one that is wrong"
            )

    def _are_contradictory(self, quantity: str, unit: str, other_unit: str) -> bool:
        """Whether both are units of a quantity, and differ."""
        conversions = [
            possible_conversion(stated_unit, self.units_of_quantity[quantity])
            for stated_unit in (unit, other_unit)
        ]
        return None not in conversions and conversions[0] != conversions[1]

    def _sentence_on_missing(self, missing_quantities: Sequence[str], names: Sequence[str]) -> str:
        """The sentence about missing quantities, with what a log may have in their place."""
        other_alternatives = " or ".join(
            " and ".join(quantities) for quantities in self.alternative_quantities[1:]
        )
        quantities_of_alternatives = {
            quantity for alternative in self.alternative_quantities for quantity in alternative
        }
        # alternatives are pairs of speeds that give both surface speeds
        alternatives_in_words = ""
        if other_alternatives and quantities_of_alternatives & set(missing_quantities):
            alternatives_in_words = f" (or {other_alternatives}: without both speeds nothing rolls)"
        logged_in_words = ", ".join(names)[:200]
        missing_in_words = ", ".join(missing_quantities)
        return (
            f"the log lacks the columns {missing_in_words}{alternatives_in_words}; its own are "
            f"{logged_in_words!r}"
        )


def _is_listed(name: str, listed_column: campaign_file.Column) -> bool:
    """Whether the campaign file lists a column's name, with or without its unit in brackets."""
    name = _comparable_name(name)
    bare_name, _ = split_bracketed_unit(name)
    listed_names = {_comparable_name(listed_name) for listed_name in listed_column.name}
    return name in listed_names or bare_name in listed_names


@lru_cache(maxsize=4096)
def _comparable_name(name: str) -> str:
    """A name as it is compared with those of the campaign file; the case is kept: n is not N."""
    return " ".join(unicodedata.normalize("NFC", name).translate(FULL_WIDTH_TO_ASCII).split())


@dataclass(frozen=True)
class UsableRows:
    """The usable rows of a run whose header has no problem.

    Attributes:
        run_id: Unique name of the run.
        text_of_key: Header key -> its text.
        columns: Columns of the run, without spare ones that hold no numbers.
        row_numbers: Row numbers in the log, shape (n,).
        values_of_quantity: Quantity -> numbers in the units of `columns`, each of shape (n,).
        refusal: Why the run cannot be used: by what its rows show, or because the run sheet leaves
            it out; None where it can.
        interpretation: How its columns and header were interpreted.
    """

    run_id: str
    text_of_key: Mapping[str, str]
    columns: Sequence[LoggedColumn]
    row_numbers: IndexArray
    values_of_quantity: Mapping[str, FloatArray]
    refusal: base.Refusal | None = None
    interpretation: base.RunInterpretation = base.NO_INTERPRETATION

    @property
    def unit_of_quantity(self) -> dict[str, str]:
        """Unit of the values of each quantity."""
        return {column.quantity: column.conversion.unit for column in self.columns}

    def logged_run(
        self,
        rig_name: str,
        samples: base.ColumnArrays,
        set_points: base.SetPoints,
        refusal: base.Refusal | None,
    ) -> base.LoggedRun:
        """The run with these samples; it is refused by its own refusal or by `refusal`."""
        return base.LoggedRun(
            run_id=self.run_id,
            oil_name=self.text_of_key.get("oil", ""),
            rig_name=rig_name,
            log_kind=self.text_of_key.get("log_kind", "continuous"),
            set_points=set_points,
            samples=samples,
            refusal=self.refusal or refusal,
            label=self.text_of_key.get("run", ""),
            interpretation=self.interpretation,
        )


def _no_unneeded_quantities(text_of_key: Mapping[str, str], settings: Settings) -> Set[str]:
    return frozenset()


def _all_rows_together(run: base.LoggedRun) -> list[IndexArray]:
    return [np.arange(len(run))]


@dataclass(frozen=True)
class LogSchema:
    """What the logs of one kind of rig (traction or torque) hold, and how they become runs.

    Attributes:
        vocabulary: Names, quantities and units of their columns.
        get_listed_columns: Function that gives the columns that a campaign file lists.
        find_header_problems: Function that gives why a log with these header lines and columns
            cannot be used. A later check relies on the earlier ones.
        make_run: Function that makes a run of its rows.
        run_sheet_keys: Header keys that the run sheet may give beside the oil.
        find_unneeded_quantities: Function that gives the quantities for which a log with these
            header lines needs no column.
        find_rows_of_set_points: Function that gives the row indices of each set point of a run.
            The rows of each set point become a run of their own.
    """

    vocabulary: Vocabulary
    get_listed_columns: Callable[[Campaign], ListedColumns]
    find_header_problems: Callable[
        [Mapping[str, str], Sequence[LoggedColumn], Settings], HeaderProblems
    ]
    make_run: Callable[[UsableRows, Settings], base.LoggedRun]
    run_sheet_keys: tuple[str, ...]
    find_unneeded_quantities: Callable[[Mapping[str, str], Settings], Set[str]] = (
        _no_unneeded_quantities
    )
    find_rows_of_set_points: Callable[[base.LoggedRun], list[IndexArray]] = _all_rows_together

    def campaign_vocabulary(self, campaign: Campaign) -> Vocabulary:
        """The vocabulary with the names that a campaign file lists."""
        return replace(self.vocabulary, listed_columns=self.get_listed_columns(campaign))
