"""Compare two releases: inputs, configuration, code, verdicts, constants and traction."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import studies, tables
from oilfilm.errors import OilfilmError
from oilfilm.fits.fitted import FittedLaw
from oilfilm.releases.logs import logs_read
from oilfilm.releases.manifest import CODE, FileRecord
from oilfilm.releases.stored_release import StoredRelease
from oilfilm.settings.config import DriftSettings
from oilfilm.traction import LAWS
from oilfilm.units import FloatArray

Row = tuple[str, ...]


@dataclass(frozen=True)
class Section:
    """One aspect in which releases can differ: a table of text, empty where they agree."""

    title: str
    columns: Row
    rows: Sequence[Row]


@dataclass(frozen=True)
class Comparison:
    """Everything in which release B differs from release A.

    Attributes:
        before: Release A.
        after: Release B.
        inputs: Raw logs.
        config: Keys of the configuration.
        code: Files of the code.
        environment: Packages, and what else a release was made with.
        verdicts: Verdicts on runs, points, constants, fits and claims.
        constants: oil, constant, before, after and change of each constant; NaN where there is
            none. The change is in standard errors of the first release, infinite where one has no
            value, and NaN where there is no standard error (few curves): mu tells then.
        traction: Where mu of each oil changed most over the tested box of the first release, by
            each `measure` (relative, absolute): change, before, after and `where`. The change is
            infinite where mu cannot be compared; `where` then says why.
        files: All other files.
    """

    before: StoredRelease
    after: StoredRelease
    inputs: Section
    config: Section
    code: Section
    environment: Section
    verdicts: Section
    constants: pd.DataFrame
    traction: pd.DataFrame
    files: Section

    @property
    def sections(self) -> list[Section]:
        """All of it as tables of text."""
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


def compare(before: StoredRelease, after: StoredRelease, drift: DriftSettings) -> Comparison:
    """Compare two releases, or a pin with a release.

    Tables that a pin does not keep are not compared.

    Args:
        before: The first release; changes are in its standard errors and over its tested box.
        after: The second.
        drift: `drift` of the configuration: levels and slips at which mu is compared.

    Raises:
        OilfilmError: A file of one of them is missing or damaged.
    """
    return Comparison(
        before,
        after,
        inputs=_inputs(before, after),
        config=_config(before, after),
        code=_files(before, after, of_code=True),
        environment=_environment(before, after),
        verdicts=_verdicts(before, after),
        constants=_constants(before, after),
        traction=_traction(before, after, drift),
        files=_files(before, after, of_code=False),
    )


def _changed(
    before: Mapping[str, Any], after: Mapping[str, Any]
) -> Iterator[tuple[str, Any | None, Any | None]]:
    for key in sorted(before.keys() | after.keys()):
        old, new = before.get(key), after.get(key)
        if old != new:
            yield key, old, new


def _state(old: object, new: object) -> str:
    return "new" if old is None else "gone" if new is None else "changed"


def _inputs(before: StoredRelease, after: StoredRelease) -> Section:
    oils = _oils(after) | _oils(before)
    old, new = (
        {record.path: record for record in stored.manifest.raw} for stored in (before, after)
    )
    rows = [
        (oils.get(path, ""), path, _state(was, now), _hash(was), _hash(now))
        for path, was, now in _changed(old, new)
    ]
    counts = sorted(Counter(row[0] for row in rows).items())
    of_oils = ", ".join(f"{count} of {oil or 'no run'}" for oil, count in counts)
    title = f"Raw logs ({of_oils})" if rows else "Raw logs"
    return Section(title, ("oil", "raw log", "", "A", "B"), sorted(rows))


def _hash(record: FileRecord | None) -> str:
    return record.sha256[:12] if record else ""


def _oils(stored: StoredRelease) -> dict[str, str]:
    """The oil of each raw log that has a run in the release."""
    raw = {record.path for record in stored.manifest.raw}
    logs = logs_read(stored.manifest.made_from["campaign"], stored.table, raw)
    return {path: log.oil for path, log in logs.items()}


def _config(before: StoredRelease, after: StoredRelease) -> Section:
    old, new = before.config(), after.config()
    if old is not None and new is not None:
        leaves = _changed(dict(_leaves(old)), dict(_leaves(new)))
        rows = [(key, _leaf_text(was), _leaf_text(now)) for key, was, now in leaves]
    elif before.manifest.made_from["config"] != after.manifest.made_from["config"]:
        rows = [("(not kept in the pin)", "", "")]
    else:
        rows = []
    return Section("Configuration", ("key", "A", "B"), rows)


def _leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Keys of a tree, joined by points, and the values at their ends; lists are values."""
    if isinstance(value, Mapping) and value:
        for key, below in value.items():
            yield from _leaves(below, f"{path}.{key}" if path else str(key))
    else:
        yield path, [value]


def _leaf_text(leaf: list[Any] | None) -> str:
    return "" if leaf is None else str(leaf[0])


def _files(before: StoredRelease, after: StoredRelease, *, of_code: bool) -> Section:
    old, new = (
        {
            path: file
            for path, file in stored.files.items()
            if path.startswith(f"{CODE}/") == of_code
        }
        for stored in (before, after)
    )
    rows = [(path, _state(was, now)) for path, was, now in _changed(old, new)]
    return Section("Code" if of_code else "Other files", ("file", ""), rows)


def _environment(before: StoredRelease, after: StoredRelease) -> Section:
    old, new = (_made_with(stored.manifest.made_from) for stored in (before, after))
    rows = [(key, was or "", now or "") for key, was, now in _changed(old, new)]
    return Section("Packages", ("what", "A", "B"), rows)


def _made_with(made_from: Mapping[str, Any]) -> dict[str, str]:
    environment = made_from["environment"]
    return {
        **{key: made_from[key] for key in ("tag", "campaign", "data")},
        "schema version of the tables": str(made_from["schema_version"]),
        "Python": environment["python"],
        "platform": environment["platform"],
        "C library": environment["c_library"],
        "CPU": environment["cpu"],
        "requirements.lock": made_from["lock"][:12],
        **environment["packages"],
    }


# Tables with verdicts: the column of the verdict, then those that explain it.
_JUDGED = {
    "runs": ["verdict", "rule", "reason"],
    "points": ["accepted", "failed_gates"],
    "coefficients": ["verdict"],
    "fit_quality": ["certified"],
    "law_fit_quality": ["certified"],
    "sign_verdicts": ["verdict"],
    "claims": ["verdict"],
}


def _verdicts(before: StoredRelease, after: StoredRelease) -> Section:
    studies.declare_tables(studies.available())
    rows: list[Row] = []
    for table, columns in _JUDGED.items():
        key = list(tables.TABLES[table].key)
        old, new = before.table(table), after.table(table)
        if old is not None and new is not None:
            rows += [
                (table, *row)
                for row in _verdicts_of(old.set_index(key), new.set_index(key), columns)
            ]
    return Section("Verdicts", ("table", "row", "A", "B"), rows)


def _verdicts_of(old: pd.DataFrame, new: pd.DataFrame, columns: list[str]) -> Iterator[Row]:
    """Rows with different verdicts; the first column is the verdict, the others explain it."""
    verdict = columns[0]
    both = old[columns].add_suffix(" A").join(new[columns].add_suffix(" B"), how="outer")
    differs = both[f"{verdict} A"].astype(object) != both[f"{verdict} B"].astype(object)
    for index, row in both[differs].iterrows():
        name = ", ".join(map(str, index)) if isinstance(index, tuple) else str(index)
        yield (name, *(_verdict_text(row, columns, side) for side in "AB"))


def _verdict_text(row: "pd.Series[Any]", columns: list[str], side: str) -> str:
    values = [row[f"{column} {side}"] for column in columns]
    return "" if pd.isna(values[0]) else ": ".join(str(value) for value in values if value != "")


def _constants(before: StoredRelease, after: StoredRelease) -> pd.DataFrame:
    old, new = before.table("coefficients"), after.table("coefficients")
    columns = ["oil", "constant", "before", "after", "change"]
    if old is None or new is None:
        return pd.DataFrame(columns=columns)
    error = old["standard_error"].fillna(old["naive_standard_error"])
    both = old.rename(columns={"value": "before"}).assign(error=error.where(error != 0))
    both = both.merge(
        new.rename(columns={"value": "after"}), on=["oil", "law", "constant"], how="outer"
    )
    lost = both["before"].isna() != both["after"].isna()
    same = (both["before"] == both["after"]) | (both["before"].isna() & both["after"].isna())
    change = (both["after"] - both["before"]).abs() / both["error"]
    return both.assign(change=change.mask(lost, np.inf).mask(same, 0.0))[columns]


def _traction(before: StoredRelease, after: StoredRelease, drift: DriftSettings) -> pd.DataFrame:
    old, new = _fits(before), _fits(after)
    rows: list[dict[str, Any]] = []
    for oil in sorted(old.keys() | new.keys()):
        if oil not in old or oil not in new:
            rows += _incomparable(oil, f"{oil} is fitted in one release only")
        elif old[oil].law.conditions != new[oil].law.conditions:
            names = f"{old[oil].law.name} and {new[oil].law.name}"
            rows += _incomparable(oil, f"laws {names}")
        else:
            rows += _traction_of(oil, old[oil], new[oil], drift)
    columns = ["oil", "measure", "change", "before", "after", "where"]
    return pd.DataFrame(rows, columns=columns)


def _fits(stored: StoredRelease) -> dict[str, FittedLaw]:
    coefficients, quality = stored.table("coefficients"), stored.table("fit_quality")
    if coefficients is None or quality is None:
        return {}
    fits = coefficients[["oil", "law"]].drop_duplicates()
    if fits["oil"].duplicated().any() or not set(fits["law"]) <= set(LAWS):
        raise OilfilmError(
            f"{stored.folder}: tables/coefficients.parquet has laws that are not known here, or "
            "more than one of an oil."
        )
    if len(fits.merge(quality, on=["oil", "law"])) != len(fits):
        raise OilfilmError(f"{stored.folder}: tables/fit_quality.parquet lacks a fit.")
    return {oil: FittedLaw.of(coefficients, oil, quality=quality) for oil in fits["oil"]}


def _traction_of(
    oil: str, before: FittedLaw, after: FittedLaw, drift: DriftSettings
) -> list[dict[str, Any]]:
    """Where mu of one oil changed most, relative and absolute."""
    *box, (_, slip_max) = before.coefficients.box
    slips = [slip for slip in drift.slide_roll_ratio if not slip > slip_max]
    axes = [_levels(low, high, drift.levels) for low, high in box]
    axes.append(np.array(slips or [slip_max]))
    conditions = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
    try:
        # where a condition is not followed, along its tested level or line
        at = before.on_line(conditions[:, :-1])
        old, new = (
            law.predict(at, conditions[:, -1]).traction_coefficient for law in (before, after)
        )
    except ValueError as error:
        return _incomparable(oil, f"its fits cannot be compared: {error}")
    change = np.abs(new - old)
    # missing in both releases: no change; missing in one: infinite change
    change[np.isnan(change)] = np.inf
    change[np.isnan(old) & np.isnan(new)] = 0.0
    with np.errstate(divide="ignore"):
        relative = np.divide(change, np.abs(old), out=np.zeros_like(change), where=change > 0)
    relative[np.isnan(relative)] = np.inf

    rows = []
    for measure, size in (("relative", relative), ("absolute", change)):
        worst = int(size.argmax())
        slip = conditions[worst, -1]
        named = zip(before.law.conditions, at[worst], strict=True)
        known = [(name, value) for name, value in named if np.isfinite(value)]
        where = ", ".join(f"{value:.4g} {tables.unit_of(name)}" for name, value in known)
        row = {"change": size[worst], "before": old[worst], "after": new[worst]}
        rows.append({"oil": oil, "measure": measure, **row, "where": f"{where}, S {slip:.4g}"})
    return rows


def _incomparable(oil: str, why: str) -> list[dict[str, Any]]:
    row = {"oil": oil, "change": np.inf, "before": np.nan, "after": np.nan, "where": why}
    return [{**row, "measure": measure} for measure in ("relative", "absolute")]


def _levels(low: float, high: float, count: int) -> FloatArray:
    """Levels of a condition. A condition that was never recorded has no effect: one level."""
    known = np.isfinite(low) and np.isfinite(high)
    return np.unique(np.linspace(low, high, count)) if known else np.array([1.0])


def _constants_section(constants: pd.DataFrame) -> Section:
    rows = [
        (
            row["oil"],
            row["constant"],
            f"{row['before']:.6g}",
            f"{row['after']:.6g}",
            f"{row['change']:.2f}",
        )
        for row in tables.rows(constants[constants["change"] != 0])
    ]
    return Section("Constants", ("oil", "constant", "A", "B", "standard errors"), rows)


def _traction_section(traction: pd.DataFrame) -> Section:
    rows = []
    for row in tables.rows(traction[traction["change"] != 0]):
        relative = row["measure"] == "relative"
        change = f"{100 * row['change']:.3g} %" if relative else f"{row['change']:.2g}"
        mu = f"{row['before']:.5f}", f"{row['after']:.5f}"
        rows.append((row["oil"], change, *mu, row["where"]))
    columns = ("oil", "largest change of mu", "A", "B", "at")
    return Section("Traction coefficient over the tested box", columns, rows)
