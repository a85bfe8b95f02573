"""Two releases held against each other: what went in, what was judged, what came out."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.errors import OilfilmError
from oilfilm.fitting.fitted import FittedLaw
from oilfilm.releases.logs import logs_read
from oilfilm.releases.manifest import CODE, FileRecord
from oilfilm.releases.opened import Opened
from oilfilm.tables import unit_of
from oilfilm.traction import LAWS
from oilfilm.units import FloatArray

Row = tuple[str, ...]


@dataclass(frozen=True)
class Section:
    """One aspect in which releases can differ: a table of words, empty where they do not."""

    title: str
    columns: Row
    rows: Sequence[Row]


@dataclass(frozen=True)
class Constant:
    """One constant in both releases; NaN where there is none."""

    oil: str
    law: str
    name: str
    before: float
    after: float
    standard_error: float

    @property
    def change(self) -> float:
        """In standard errors of the first release; infinite where one release has no value."""
        if (np.isnan(self.before) and np.isnan(self.after)) or self.before == self.after:
            return 0.0
        if np.isnan(self.before) or np.isnan(self.after):
            return np.inf
        # without an error, as with few curves, there is no measure: mu judges then
        return (
            abs(self.after - self.before) / self.standard_error if self.standard_error else np.nan
        )


@dataclass(frozen=True)
class Extreme:
    """The place where mu has changed most: by how much, from what to what, and where in words."""

    change: float
    before: float
    after: float
    where: str


@dataclass(frozen=True)
class Traction:
    """How mu of one oil differs over the tested box of the first release.

    Both changes are infinite where mu cannot be compared: one release has no fit of the oil, or
    its law takes other conditions.
    """

    oil: str
    relative: Extreme
    absolute: Extreme


@dataclass(frozen=True)
class Comparison:
    """Everything in which release B differs from release A."""

    before: Opened
    after: Opened
    inputs: Section
    config: Section
    code: Section
    environment: Section
    verdicts: Section
    constants: list[Constant]
    traction: list[Traction]
    files: Section

    @property
    def sections(self) -> list[Section]:
        """All of it as tables of words."""
        return [
            self.inputs,
            self.config,
            self.code,
            self.environment,
            self.verdicts,
            _constants_section(self.constants),
            _traction_section(self.traction),
            self.files,
        ]


def compare(before: Opened, after: Opened, drift: Mapping[str, Any]) -> Comparison:
    """Compare two releases, or a pin with a release.

    What only one of them can tell, because the other is a pin, is not compared.

    Args:
        before: The first release; changes are in its standard errors and over its tested box.
        after: The second.
        drift: `drift` of the configuration: levels and slips at which mu is compared.

    Raises:
        OilfilmError: A file of one of them is missing or damaged.
    """
    return Comparison(
        before=before,
        after=after,
        inputs=_inputs(before, after),
        config=_config(before, after),
        code=_files(before, after, "code", lambda path: path.startswith(f"{CODE}/")),
        environment=_environment(before, after),
        verdicts=_verdicts(before, after),
        constants=_constants(before, after),
        traction=_tractions(before, after, drift),
        files=_files(before, after, "other files", lambda path: not path.startswith(f"{CODE}/")),
    )


def _changed(
    before: Mapping[str, Any], after: Mapping[str, Any]
) -> Iterator[tuple[str, Any | None, Any | None]]:
    for key in sorted(before.keys() | after.keys()):
        old, new = before.get(key), after.get(key)
        if old != new:
            yield key, old, new


def _word(old: object, new: object) -> str:
    return "new" if old is None else "gone" if new is None else "changed"


def _inputs(before: Opened, after: Opened) -> Section:
    oils = _oils(after) | _oils(before)
    old, new = ({each.path: each for each in one.manifest.raw} for one in (before, after))
    rows = [
        (oils.get(path, ""), path, _word(was, now), _hash(was), _hash(now))
        for path, was, now in _changed(old, new)
    ]
    counts = sorted(Counter(row[0] for row in rows).items())
    of_oils = ", ".join(f"{count} of {oil or 'no run'}" for oil, count in counts)
    title = f"Raw logs ({of_oils})" if rows else "Raw logs"
    return Section(title, ("oil", "raw log", "", "A", "B"), sorted(rows))


def _hash(record: FileRecord | None) -> str:
    return record.sha256[:12] if record else ""


def _oils(opened: Opened) -> dict[str, str]:
    """The oil of each raw log, as far as the release knows it."""
    raw = {record.path for record in opened.manifest.raw}
    logs = logs_read(opened.manifest.made_from["campaign"], opened.table, raw)
    return {path: log.oil for path, log in logs.items()}


def _config(before: Opened, after: Opened) -> Section:
    title, columns = "Configuration", ("key", "A", "B")
    old, new = before.config(), after.config()
    if old is None or new is None:
        same = before.manifest.made_from["config"] == after.manifest.made_from["config"]
        return Section(title, columns, [] if same else [("(not kept in the pin)", "", "")])
    leaves = _changed(dict(_leaves(old)), dict(_leaves(new)))
    return Section(title, columns, [(key, _plain(was), _plain(now)) for key, was, now in leaves])


def _leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Keys of a tree, joined by points, and the values at their ends; lists are values."""
    if isinstance(value, Mapping) and value:
        for key, below in value.items():
            yield from _leaves(below, f"{path}.{key}" if path else str(key))
    else:
        yield path, [value]


def _plain(leaf: list[Any] | None) -> str:
    return "" if leaf is None else str(leaf[0])


def _files(before: Opened, after: Opened, what: str, chosen: Callable[[str], bool]) -> Section:
    old, new = (
        {path: file for path, file in one.files.items() if chosen(path)} for one in (before, after)
    )
    rows = [(path, _word(was, now)) for path, was, now in _changed(old, new)]
    return Section(what.capitalize(), ("file", ""), rows)


def _environment(before: Opened, after: Opened) -> Section:
    old, new = (_facts(one.manifest.made_from) for one in (before, after))
    rows = [(key, was or "", now or "") for key, was, now in _changed(old, new)]
    return Section("Packages", ("what", "A", "B"), rows)


def _facts(made_from: Mapping[str, Any]) -> dict[str, str]:
    environment = made_from["environment"]
    return {
        "tag": made_from["tag"],
        "campaign": made_from["campaign"],
        "data": made_from["data"],
        "schema version of the tables": str(made_from["schema_version"]),
        "Python": environment["python"],
        "platform": environment["platform"],
        "C library": environment["c_library"],
        "CPU": environment["cpu"],
        "requirements.lock": made_from["lock"][:12],
        **environment["packages"],
    }


# Tables that judge: their key, and the columns that hold the verdict.
_JUDGED = {
    "runs": (["run_id"], ["verdict", "rule", "reason"]),
    "points": (["run_id", "first_row"], ["accepted", "failed_gates"]),
    "coefficients": (["oil", "law", "constant"], ["verdict"]),
    "fit_quality": (["oil", "law"], ["certified"]),
    "law_fit_quality": (["oil", "law"], ["certified"]),
    "sign_verdicts": (["oil", "constant"], ["verdict"]),
    "claims": (["claim", "basis"], ["verdict"]),
}


def _verdicts(before: Opened, after: Opened) -> Section:
    rows: list[Row] = []
    for table, (key, columns) in _JUDGED.items():
        old, new = before.table(table), after.table(table)
        if old is not None and new is not None:
            rows += [
                (table, *row)
                for row in _verdicts_of(old.set_index(key), new.set_index(key), columns)
            ]
    return Section("Verdicts", ("table", "row", "A", "B"), rows)


def _verdicts_of(old: pd.DataFrame, new: pd.DataFrame, columns: list[str]) -> Iterator[Row]:
    """Rows of which one release says otherwise; the first column decides, others explain."""
    verdict = columns[0]
    both = old[columns].add_suffix(" A").join(new[columns].add_suffix(" B"), how="outer")
    differs = both[f"{verdict} A"].astype(object) != both[f"{verdict} B"].astype(object)
    for index, row in both[differs].iterrows():
        name = ", ".join(map(str, index)) if isinstance(index, tuple) else str(index)
        yield (name, *(_said(row, columns, side) for side in "AB"))


def _said(row: "pd.Series[Any]", columns: list[str], side: str) -> str:
    values = [row[f"{column} {side}"] for column in columns]
    return "" if pd.isna(values[0]) else ": ".join(str(value) for value in values if value != "")


def _constants(before: Opened, after: Opened) -> list[Constant]:
    old, new = before.table("coefficients"), after.table("coefficients")
    if old is None or new is None:
        return []
    key = ["oil", "law", "constant"]
    error = old["standard_error"].fillna(old["naive_standard_error"])
    both = old.assign(error=error).merge(new, on=key, how="outer", suffixes=(" A", " B"))
    return [
        Constant(
            oil=row["oil"],
            law=row["law"],
            name=row["constant"],
            before=row["value A"],
            after=row["value B"],
            standard_error=row["error"],
        )
        for row in both.to_dict("records")
    ]


def _tractions(before: Opened, after: Opened, drift: Mapping[str, Any]) -> list[Traction]:
    old, new = _fits(before), _fits(after)
    # a release without fits has lost them all
    return [
        _traction(oil, old.get(oil), new.get(oil), drift) for oil in sorted(old.keys() | new.keys())
    ]


def _fits(opened: Opened) -> dict[str, FittedLaw]:
    coefficients, quality = opened.table("coefficients"), opened.table("fit_quality")
    if coefficients is None or quality is None:
        return {}
    fits = coefficients[["oil", "law"]].drop_duplicates()
    if fits["oil"].duplicated().any() or not set(fits["law"]) <= set(LAWS):
        raise OilfilmError(
            f"{opened.folder}: tables/coefficients.parquet has laws that are not known here, or "
            "more than one of an oil."
        )
    if len(fits.merge(quality, on=["oil", "law"])) != len(fits):
        raise OilfilmError(f"{opened.folder}: tables/fit_quality.parquet lacks a fit.")
    return {oil: FittedLaw.of(coefficients, oil, quality=quality) for oil in fits["oil"]}


def _traction(
    oil: str, before: FittedLaw | None, after: FittedLaw | None, drift: Mapping[str, Any]
) -> Traction:
    if before is None or after is None:
        return _incomparable(oil, f"{oil} is fitted in one release only")
    if before.law.conditions != after.law.conditions:
        return _incomparable(oil, f"laws {before.law.name} and {after.law.name}")
    *box, (_, slip_max) = before.coefficients.box
    slips = [slip for slip in drift["slide_roll_ratio"] if not slip > slip_max]
    axes = [_levels(low, high, drift["levels"]) for low, high in box]
    axes.append(np.array(slips or [slip_max]))
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
    try:
        old, new = (
            law.predict(places[:, :-1], places[:, -1]).traction_coefficient
            for law in (before, after)
        )
    except ValueError as error:
        raise OilfilmError(f"{oil}: its fits cannot be compared ({error}).") from error
    change = np.abs(new - old)
    # mu that neither release has is no change; mu that only one has is one without measure
    change[np.isnan(change)] = np.inf
    change[np.isnan(old) & np.isnan(new)] = 0.0
    with np.errstate(divide="ignore"):
        relative = np.divide(change, np.abs(old), out=np.zeros_like(change), where=change > 0)
    relative[np.isnan(relative)] = np.inf

    def extreme(size: FloatArray) -> Extreme:
        worst = int(size.argmax())
        *at, slip = places[worst]
        levels = zip(before.law.conditions, at, strict=True)
        where = ", ".join(f"{value:.4g} {unit_of(name)}" for name, value in levels)
        mu = float(old[worst]), float(new[worst])
        return Extreme(float(size[worst]), *mu, f"{where}, S {slip:.4g}")

    return Traction(oil, extreme(relative), extreme(change))


def _incomparable(oil: str, why: str) -> Traction:
    nowhere = Extreme(np.inf, np.nan, np.nan, why)
    return Traction(oil, nowhere, nowhere)


def _levels(low: float, high: float, count: int) -> FloatArray:
    """Levels of a condition; one that was never known has no effect, and any level will do."""
    known = np.isfinite(low) and np.isfinite(high)
    return np.unique(np.linspace(low, high, count)) if known else np.array([1.0])


def _constants_section(constants: list[Constant]) -> Section:
    rows = [
        (one.oil, one.name, f"{one.before:.6g}", f"{one.after:.6g}", f"{one.change:.2f}")
        for one in constants
        if one.change != 0
    ]
    return Section("Constants", ("oil", "constant", "A", "B", "standard errors"), rows)


def _traction_section(tractions: list[Traction]) -> Section:
    rows = [
        (one.oil, size, f"{place.before:.5f}", f"{place.after:.5f}", place.where)
        for one in tractions
        for size, place in (
            (f"{100 * one.relative.change:.3g} %", one.relative),
            (f"{one.absolute.change:.2g}", one.absolute),
        )
        if place.change
    ]
    columns = ("oil", "largest change of mu", "A", "B", "at")
    return Section("Traction coefficient over the tested box", columns, rows)
