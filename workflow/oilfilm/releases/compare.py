"""Compare two releases: inputs, configuration, code, verdicts, constants and traction.

Decides: the drift gate: when a refit has moved too far.
"""

import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import studies, tables
from oilfilm.errors import OilfilmError
from oilfilm.fits.fitted import FittedLaw
from oilfilm.releases.manifest import CODE
from oilfilm.releases.stored_release import StoredRelease
from oilfilm.settings.base import Group, key
from oilfilm.settings.config import DriftSettings
from oilfilm.text_table import text_table
from oilfilm.traction import LAWS
from oilfilm.units import FloatArray

Row = tuple[str, ...]
# Rows of a section that are printed.
_PRINTED_ROWS = 12
# Tables with verdicts: the column of the verdict, then those that explain it.
_JUDGED = {
    "runs": ["verdict", "rule", "reason"],
    "points": ["accepted", "failed_gates"],
    "coefficients": ["verdict"],
    "fit_quality": ["certified"],
    "sign_verdicts": ["verdict"],
    "claims": ["verdict"],
}


class Section(Group):
    """One aspect in which releases can differ: a table of text, empty where they agree."""

    title: str = key("The aspect.")
    columns: Row = key("Heads of the columns.")
    rows: list[Row] = key("Cells of each row.")

    def text(self, most: int = sys.maxsize) -> str:
        """An aligned table of so many rows; control characters are escaped."""
        lines = text_table([self.columns, *self.rows[:most]], indent="  ")
        if len(self.rows) > most:
            lines.append(f"  ... and {len(self.rows) - most} more; --json has all")
        return "\n".join([f"{self.title}: {len(self.rows)}", *lines])


@dataclass(frozen=True)
class Comparison:
    """Everything in which release B differs from release A.

    Attributes:
        before: Release A.
        after: Release B.
        of_inputs: Raw logs, configuration, code, packages, verdicts: what comes before numbers.
        constants: oil, constant, before, after and change of each constant; NaN where there is
            none. The change is in standard errors of the first release, infinite where one has no
            value, and NaN where there is no standard error (few curves): mu tells then.
        traction: Where mu of each oil changed most, relative, over the tested box of the first
            release: change, before, after and `where`. The change is infinite where mu cannot be
            compared; `where` then says why.
        files: All other files.
    """

    before: StoredRelease
    after: StoredRelease
    of_inputs: Sequence[Section]
    constants: pd.DataFrame
    traction: pd.DataFrame
    files: Section

    @property
    def sections(self) -> list[Section]:
        """All of it as tables of text."""
        constants, traction = (t[t["change"] != 0] for t in (self.constants, self.traction))
        columns = ("oil", "constant", "A", "B", "change")
        over_box = ("oil", "", "A", "B", "largest change")
        return [
            *self.of_inputs,
            Section(title="Constants", columns=columns, rows=_constant_rows(constants)),
            Section(
                title="Traction coefficient over the tested box",
                columns=over_box,
                rows=_traction_rows(traction),
            ),
            self.files,
        ]

    def text(self) -> str:
        """All differences for a terminal; long tables are cut, with a note."""
        texts = [section.text(_PRINTED_ROWS) for section in self.sections if section.rows]
        head = f"A {self.before.name}\nB {self.after.name}"
        return "\n\n".join([head, *(texts or ["no difference"])])


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
    both = before, after
    made_from = [
        each.manifest.made_from.model_dump(exclude={"config", "code", "raw"}) for each in both
    ]
    packages = Section(
        title="Packages", columns=("what", "A", "B"), rows=_changed_leaves(*made_from)
    )
    code, files = (_files(*both, of_code=of_code) for of_code in (True, False))
    return Comparison(
        before,
        after,
        of_inputs=[_inputs(*both), _config(*both), code, packages, _verdicts(*both)],
        constants=_constants(*both),
        traction=_traction(*both, drift),
        files=files,
    )


def drift_table(comparison: Comparison, drift: DriftSettings) -> Section:
    """The drift gate: every change of a constant or of mu beyond its limit; no rows if none.

    Args:
        comparison: The reference release compared with a newer one.
        drift: `drift` of the configuration.
    """
    constants, traction = comparison.constants, comparison.traction
    constants = constants[constants["change"] > drift.standard_errors]
    traction = traction[traction["change"] > drift.traction]
    rows = [(*row, f"{drift.standard_errors:g}") for row in _constant_rows(constants)]
    rows += [(*row, f"{100 * drift.traction:g} %") for row in _traction_rows(traction)]
    columns = ("oil", "what", "A", "B", "change", "limit")
    return Section(title="Moved by more than the drift gate lets pass", columns=columns, rows=rows)


# ---------------------------------------------------------------- inputs, files and verdicts


def changed(
    before: Mapping[str, Any], after: Mapping[str, Any]
) -> Iterator[tuple[str, Any | None, Any | None, str]]:
    """Names whose values differ: name, both values (None where there is none), what happened."""
    for name in sorted(before.keys() | after.keys()):
        old, new = before.get(name), after.get(name)
        if old != new:
            yield name, old, new, "new" if old is None else "gone" if new is None else "changed"


def _inputs(before: StoredRelease, after: StoredRelease) -> Section:
    logs = (
        {each.path: each.sha256[:12] for each in stored.manifest.made_from.raw}
        for stored in (before, after)
    )
    rows: list[Row] = [
        (path, state, old or "", new or "") for path, old, new, state in changed(*logs)
    ]
    return Section(title="Raw logs", columns=("raw log", "", "A", "B"), rows=rows)


def _config(before: StoredRelease, after: StoredRelease) -> Section:
    old, new = before.config(), after.config()
    if old is not None and new is not None:
        rows = _changed_leaves(old, new)
    else:
        same = before.manifest.made_from.config == after.manifest.made_from.config
        rows = [] if same else [("(not kept in the pin)", "", "")]
    return Section(title="Configuration", columns=("key", "A", "B"), rows=rows)


def _changed_leaves(old: Mapping[str, Any], new: Mapping[str, Any]) -> list[Row]:
    return [
        (name, *("" if leaf is None else str(leaf[0]) for leaf in leaves))
        for name, *leaves, _ in changed(dict(_leaves(old)), dict(_leaves(new)))
    ]


def _leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Keys of a tree, joined by points, and the values at their ends; lists are values."""
    if isinstance(value, Mapping) and value:
        for name, below in value.items():
            yield from _leaves(below, f"{path}.{name}" if path else str(name))
    else:
        yield path, [value]


def _files(before: StoredRelease, after: StoredRelease, *, of_code: bool) -> Section:
    rows: list[Row] = [
        (path, state)
        for path, _, _, state in changed(before.files, after.files)
        if path.startswith(f"{CODE}/") == of_code
    ]
    return Section(title="Code" if of_code else "Other files", columns=("file", ""), rows=rows)


def _verdicts(before: StoredRelease, after: StoredRelease) -> Section:
    studies.declare_tables(studies.available())
    rows: list[Row] = []
    for table, columns in _JUDGED.items():
        keys = list(tables.TABLES[table].key)
        old, new = before.table(table), after.table(table)
        if old is None or new is None:
            continue
        old, new = (frame.set_index(keys)[columns] for frame in (old, new))
        both = old.add_suffix(" A").join(new.add_suffix(" B"), how="outer")
        # the first column is the verdict, the others explain it
        of_a, of_b = (both[f"{columns[0]} {side}"].astype(object) for side in "AB")
        for index, row in both[of_a != of_b].iterrows():
            name = ", ".join(map(str, index)) if isinstance(index, tuple) else str(index)
            rows.append((table, name, *(_verdict_text(row, columns, side) for side in "AB")))
    return Section(title="Verdicts", columns=("table", "row", "A", "B"), rows=rows)


def _verdict_text(row: "pd.Series[Any]", columns: list[str], side: str) -> str:
    values = [row[f"{column} {side}"] for column in columns]
    return "" if pd.isna(values[0]) else ": ".join(str(value) for value in values if value != "")


# ---------------------------------------------------------------- constants and traction


def _constants(before: StoredRelease, after: StoredRelease) -> pd.DataFrame:
    (old, _), (new, _) = _configured_fits(before), _configured_fits(after)
    columns = ["oil", "constant", "before", "after", "change"]
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
        try:
            row = _largest_change(oil, old.get(oil), new.get(oil), drift)
        except ValueError as why:
            row = {"change": np.inf, "before": np.nan, "after": np.nan, "where": str(why)}
        rows.append({"oil": oil, **row})
    return pd.DataFrame(rows, columns=["oil", "change", "before", "after", "where"])


def _configured_fits(stored: StoredRelease) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Coefficients and quality of the configured law of each oil; none that a pin does not keep."""
    coefficients, quality = stored.table("coefficients"), stored.table("fit_quality")
    if coefficients is None or quality is None:
        return tables.empty("coefficients"), tables.empty("fit_quality")
    if len(coefficients.merge(quality[["oil", "law"]])) != len(coefficients):
        raise OilfilmError(f"{stored.folder}: tables/fit_quality.parquet lacks a fit.")
    quality = quality[quality["configured"]]
    if quality["oil"].duplicated().any() or not set(quality["law"]) <= set(LAWS):
        raise OilfilmError(
            f"{stored.folder}: tables/fit_quality.parquet has a configured law that is not known "
            "here, or more than one of an oil."
        )
    return coefficients.merge(quality[["oil", "law"]]), quality


def _fits(stored: StoredRelease) -> dict[str, FittedLaw]:
    coefficients, quality = _configured_fits(stored)
    oils = coefficients["oil"].unique()
    return {oil: FittedLaw.of(coefficients, oil, quality=quality) for oil in oils}


def _largest_change(
    oil: str, before: FittedLaw | None, after: FittedLaw | None, drift: DriftSettings
) -> dict[str, Any]:
    """Where mu of one oil changed most, relative.

    Raises:
        ValueError: The fits cannot be compared.
    """
    if before is None or after is None:
        raise ValueError(f"{oil} is fitted in one release only")
    if before.law.conditions != after.law.conditions:
        raise ValueError(f"laws {before.law.name} and {after.law.name}")
    *box, (_, slip_max) = before.coefficients.box
    slips = [slip for slip in drift.slide_roll_ratio if not slip > slip_max]
    axes = [_levels(low, high, drift.levels) for low, high in box]
    axes.append(np.array(slips or [slip_max]))
    conditions = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
    # where a condition is not followed, along its tested level or line
    at = before.on_line(conditions[:, :-1])
    old, new = (law.predict(at, conditions[:, -1]).traction_coefficient for law in (before, after))
    with np.errstate(divide="ignore", invalid="ignore"):
        change = np.abs(new - old) / np.abs(old)
    # missing in one release: infinite change
    change[np.isnan(change)] = np.inf
    change[(new == old) | (np.isnan(old) & np.isnan(new))] = 0.0
    worst = int(change.argmax())
    named = zip(before.law.conditions, at[worst], strict=True)
    where = [f"{value:.4g} {tables.unit_of(name)}" for name, value in named if np.isfinite(value)]
    where.append(f"S {conditions[worst, -1]:.4g}")
    of_worst = {"change": change[worst], "before": old[worst], "after": new[worst]}
    return {**of_worst, "where": ", ".join(where)}


def _levels(low: float, high: float, count: int) -> FloatArray:
    """Levels of a condition. A condition that was never recorded has no effect: one level."""
    known = np.isfinite(low) and np.isfinite(high)
    return np.unique(np.linspace(low, high, count)) if known else np.array([1.0])


def _constant_rows(constants: pd.DataFrame) -> list[Row]:
    return [
        (
            row["oil"],
            row["constant"],
            f"{row['before']:.6g}",
            f"{row['after']:.6g}",
            f"{row['change']:.2f} standard errors",
        )
        for row in tables.rows(constants)
    ]


def _traction_rows(traction: pd.DataFrame) -> list[Row]:
    return [
        (
            row["oil"],
            "mu",
            f"{row['before']:.5f}",
            f"{row['after']:.5f}",
            f"{100 * row['change']:.3g} % at {row['where']}",
        )
        for row in tables.rows(traction)
    ]
