"""What the logs of one kind of rig may hold, and what the names of their columns mean.

Decides: how the name of a column becomes a quantity and a unit (the names themselves are in
`traction_log.py`, `torque_log.py` and the campaign file).
"""

import unicodedata
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np

from oilfilm.logs import base
from oilfilm.logs.header import FULL_WIDTH, apart
from oilfilm.settings import campaign as campaign_file
from oilfilm.settings.base import plain_key
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.resolved import Settings
from oilfilm.units import Conversion, FloatArray, conversion, possible_conversion

Renamed = Mapping[str, campaign_file.Column]
Problems = Iterator[base.Refusal | None]


@dataclass(frozen=True)
class Column:
    """Place of a quantity in a row and its conversion to the reader's unit.

    A `spare` column repeats what others give: it is compared, and no row needs it. `name` and
    `logged_unit` are those of the log.
    """

    quantity: str
    index: int
    to: Conversion
    name: str
    logged_unit: str
    spare: bool = False

    def read(self, logged: FloatArray) -> base.LogColumn:
        """The column with the range of its numbers, given as logged; NaN where a cell has none."""
        # extremes first: a number that is not finite is, or hides, one of them
        finite = len(logged) > 0 and np.isfinite(logged.min() + logged.max())
        known = logged if finite else logged[np.isfinite(logged)]
        ends = self.to.of(np.array([known.min(), known.max()] if len(known) else [np.nan, np.nan]))
        least, most = map(float, np.sort(ends))
        about = self.name, self.logged_unit, self.quantity, self.to.unit
        return base.LogColumn(*about, least, most, len(known), len(logged) - len(known))


@dataclass(frozen=True)
class Vocabulary:
    """What the logs of one kind of rig may hold.

    Attributes:
        name: Kind of log, in a word.
        columns_key: Key of the campaign file that says which columns have names of their own.
        own_names: Column names that carry their unit -> quantity and unit.
        always: Quantities that every log must have.
        either: Sets of quantities of which one must be there; the first is what a log is asked for,
            what a log has of those after its own is compared with it.
        optional: Quantities that a log may have; where it does, every row needs them.
        instead: Quantity -> the one that serves where a log does not have it.
        renamed: Quantity -> `name` (as the log writes it) and `unit`, of the columns that the
            campaign file names.
    """

    name: str
    columns_key: str
    own_names: Mapping[str, tuple[str, str]]
    always: tuple[str, ...]
    either: tuple[tuple[str, ...], ...] = ((),)
    optional: tuple[str, ...] = ()
    instead: Mapping[str, str] = field(default_factory=dict)
    renamed: Renamed = field(default_factory=dict)

    @cached_property
    def quantities(self) -> Mapping[str, tuple[str, ...]]:
        """Quantity -> the units that can be used of it."""
        known = self.own_names.values()
        return {name: tuple(unit for each, unit in known if each == name) for name, _ in known}

    @property
    def advice(self) -> str:
        """What to do about a log whose columns cannot be understood."""
        names = f"Other names: see `{self.columns_key}` of the campaign file."
        return f"data/raw/README.md describes the format. {names}"

    def fits(self, quantity: str, unit: str) -> bool:
        """True where a quantity can be given in that unit."""
        return possible_conversion(unit, self.quantities[quantity]) is not None

    def meaning(self, name: str) -> tuple[str, str | None] | None:
        """Quantity and unit (None where something else must give it) of a column's name."""
        bare, unit = apart(name)
        for quantity, given in self.renamed.items():
            if _is_listed(name, given):
                return quantity, given.unit or unit
        plain = plain_key(bare)
        if plain in self.own_names:
            quantity, own_unit = self.own_names[plain]
            return quantity, unit or own_unit
        return (plain, unit) if plain in self.quantities else None

    def meanings(self, names: Sequence[str], units: Sequence[str]) -> dict[int, tuple[str, str]]:
        """Quantity and unit of each column that means something, by its place.

        Where the campaign file lists a column of the log, others of the project's name mean
        nothing. The unit beside a name is taken, unless only that of the name can be used.

        Args:
            names: All column names, in the order of the columns.
            units: Unit that the log gives for each, beside its name; empty where none.
        """
        known = {place: of for place, name in enumerate(names) if (of := self.meaning(name))}
        renamed = [(place, of) for place, (of, _) in known.items() if of in self.renamed]
        listed = {place: of for place, of in renamed if _is_listed(names[place], self.renamed[of])}
        found: dict[int, tuple[str, str]] = {}
        for place, (quantity, named) in known.items():
            if place in listed or quantity not in listed.values():
                beside = units[place]
                use_named = named and not (beside and self.fits(quantity, beside))
                found[place] = quantity, named if named and use_named else beside
        return found

    def columns(
        self, names: Sequence[str], units: Sequence[str], spared: Set[str] = frozenset()
    ) -> tuple[Column, ...]:
        """The columns that make a run, each with its conversion, then the spare ones.

        Args:
            names: All column names.
            units: Unit beside each.
            spared: Quantities that the log need not have a column of.

        Raises:
            ValueError: A quantity is missing or doubled, or has no unit or an impossible one; the
                message is a sentence for the user.
        """
        known = self.meanings(names, units)
        counts = Counter(quantity for quantity, _ in known.values())
        if doubled := next((quantity for quantity, count in counts.items() if count > 1), ""):
            raise ValueError(f"the log repeats the column {doubled!r}")
        there = counts.keys() | spared
        either = self.either
        chosen = next((some for some in either if there >= set(some)), either[0])
        served = {each for each in self.instead.keys() - counts if self.instead[each] in counts}
        asked = (q for q in (*self.always, *chosen) if q in counts or q not in spared)
        needed = [self.instead[q] if q in served else q for q in asked]
        # before their units: a log of something else is told what it is not
        if missing := [quantity for quantity in needed if quantity not in counts]:
            raise ValueError(self._lacking(missing, names))
        columns: dict[str, Column] = {}
        for index, (quantity, unit) in known.items():
            name = names[index]
            if not unit:
                raise ValueError(
                    f"the column {name[:60]!r} has no unit; write it in brackets, in a row below "
                    f"the names or under `{self.columns_key}` of the campaign file"
                )
            try:
                to = conversion(unit, self.quantities[quantity])
            except ValueError as error:
                raise ValueError(f"the column {name[:60]!r}: {error}") from error
            own = units[index] or apart(name)[1] or unit
            if self.fits(quantity, own) and conversion(own, self.quantities[quantity]) != to:
                raise ValueError(
                    f"the column {name[:60]!r} is in {own!r} by the log itself and in {unit!r} by "
                    f"`{self.columns_key}` of the campaign file; take out the one that is wrong"
                )
            columns[quantity] = Column(quantity, index, to, name, unit)
        others = either[either.index(chosen) + 1 :]
        spare = [quantity for some in others for quantity in some if quantity in columns]
        needed += [quantity for quantity in self.optional if quantity in columns]
        compared = (replace(columns[quantity], spare=True) for quantity in spare)
        return (*(columns[quantity] for quantity in needed), *compared)

    def _lacking(self, missing: Sequence[str], names: Sequence[str]) -> str:
        """That quantities are missing, with what a log may have in their place."""
        others = " or ".join(" and ".join(some) for some in self.either[1:])
        no_speeds = others and any({*some} & {*missing} for some in self.either)
        or_else = f" (or {others}: without both speeds nothing rolls)" if no_speeds else ""
        own = ", ".join(names)[:200]
        return f"the log lacks the columns {', '.join(missing)}{or_else}; its own are {own!r}"


def _is_listed(name: str, given: campaign_file.Column) -> bool:
    plain = _plain(name)
    return bool({plain, apart(plain)[0]} & {*map(_plain, given.name)})


@lru_cache(maxsize=4096)
def _plain(name: str) -> str:
    """A name as it is compared with those of the campaign file, its case kept: n is not N."""
    return " ".join(unicodedata.normalize("NFC", name).translate(FULL_WIDTH).split())


@dataclass(frozen=True)
class ContinuousLog:
    """The usable rows of a log whose header has no problem.

    Attributes:
        run_id: Unique name of the run.
        keys: Header keys.
        columns: As `Vocabulary.columns` gave them.
        rows: Row numbers in the log, shape (n,).
        values: Quantity -> numbers in the units of `columns`, each of shape (n,).
        flaw: Why the run cannot be used, if so.
        understood: What its columns were taken for.
    """

    run_id: str
    keys: Mapping[str, str]
    columns: Sequence[Column]
    rows: base.IndexArray
    values: Mapping[str, FloatArray]
    flaw: base.Refusal | None = None
    understood: base.Understood = base.NOTHING_UNDERSTOOD

    @property
    def units(self) -> dict[str, str]:
        """Unit of the values of each quantity."""
        return {column.quantity: column.to.unit for column in self.columns}

    def run(
        self, rig: str, samples: base.Columns, nominal: base.Nominal, flaw: base.Refusal | None
    ) -> base.LoggedRun:
        """The run that has these samples; `flaw` counts where the log itself has none."""
        keys, flaw = self.keys, self.flaw or flaw
        about = keys.get("oil", ""), rig, keys.get("log_kind", "continuous"), nominal
        own_name = keys.get("run", "")
        return base.LoggedRun(self.run_id, *about, samples, flaw, own_name, self.understood)


@dataclass(frozen=True)
class LogKind:
    """A kind of log: formats find names, units, keys and numbers, and it makes a run of them.

    Attributes:
        vocabulary: What such logs may hold.
        renamed: The columns with names of their own in a campaign.
        header_problems: Why a log with these header keys and columns cannot be used; later ones
            take the absence of earlier ones for granted.
        run: The run that a log makes.
        spared: Quantities that a log with these header keys needs no column of.
        sheet_keys: Header keys that the run sheet may give beside the oil.
    """

    vocabulary: Vocabulary
    renamed: Callable[[Campaign], Renamed]
    header_problems: Callable[[Mapping[str, str], Sequence[Column], Settings], Problems]
    run: Callable[[ContinuousLog, Settings], base.LoggedRun]
    sheet_keys: tuple[str, ...]
    spared: Callable[[Mapping[str, str], Settings], Set[str]] = lambda *about: frozenset()

    def vocabulary_of(self, campaign: Campaign) -> Vocabulary:
        """What such logs may hold in a campaign, with the names of its own."""
        return replace(self.vocabulary, renamed=self.renamed(campaign))
