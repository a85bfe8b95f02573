"""Compare two releases: inputs, configuration, code, verdicts, constants and traction.

Decides: the drift gate of `oilfilm diff --gate`: when a refit has moved too far (the limits are
`drift` of `config.yaml`).
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import studies, tables
from oilfilm.errors import OilfilmError, printable
from oilfilm.fits.fitted import FittedLaw
from oilfilm.releases.manifest import Environment, FileRecord
from oilfilm.releases.stored_release import StoredRelease
from oilfilm.settings.config import DriftSettings
from oilfilm.text_table import text_table
from oilfilm.ties import exceeds, first_largest
from oilfilm.traction import LAWS

Row = tuple[str, ...]
# Most that another kernel moves a number, in its standard errors: `tests/workflow/test_kernels.py`
# compares all tables of a campaign.
KERNEL_CHANGE = 1e-6
# Tables with verdicts: the column of the verdict, then those that explain it.
_JUDGED = {
    "runs": ["verdict", "rule", "reason"],
    "points": ["accepted", "failed_gates"],
    "coefficients": ["verdict"],
    "fit_quality": ["certified"],
    "sign_verdicts": ["verdict"],
    "claims": ["verdict"],
}


@dataclass(frozen=True)
class Section:
    """One aspect in which releases can differ, as a table of text; no rows where they agree."""

    title: str
    columns: Row
    rows: Sequence[Row]

    def text(self) -> str:
        """An aligned table; control characters are escaped."""
        lines = text_table([self.columns, *self.rows], indent="  ")
        return "\n".join([f"{self.title}: {len(self.rows)}", *lines])


@dataclass(frozen=True)
class Comparison:
    """Everything in which release B differs from release A.

    Attributes:
        names: Of both releases.
        kernels: Kernels of both and what to expect of them; empty where they are known and the
            same.
        inputs: What comes before numbers, and the other files.
        moved: oil, what, before, after, change and limit of each constant and of mu; NaN where
            there is none. The change of a constant is in standard errors of the first release,
            infinite where one has no value, and NaN where there is no standard error (few curves):
            mu tells then. That of mu is relative, where it is largest (`where`) over the tested box
            of the first release; infinite where mu cannot be compared, and `where` says why.
    """

    names: tuple[str, str]
    kernels: str
    inputs: Sequence[Section]
    moved: pd.DataFrame

    @property
    def sections(self) -> list[Section]:
        """What differs, as tables of text."""
        moved = _moved("Constants and traction", self.moved[self.moved["change"] != 0])
        return [section for section in (*self.inputs, moved) if section.rows]

    @property
    def beyond_limits(self) -> Section:
        """The drift gate: every change of a constant or of mu beyond its limit; no rows if none."""
        too_far = self.moved[exceeds(self.moved["change"], self.moved["limit"])]
        return _moved("Moved by more than the drift gate lets pass", too_far)

    def text(self, sections: Sequence[Section]) -> str:
        """Some sections for a terminal, below the names of both releases."""
        texts = [section.text() for section in sections]
        head = "A {}\nB {}".format(*self.names)
        return "\n\n".join([head, *filter(None, [self.kernels]), *(texts or ["no difference"])])


def compare(before: StoredRelease, after: StoredRelease, drift: DriftSettings) -> Comparison:
    """Compare two releases, or a pin with a release.

    Tables that a pin does not keep are not compared.

    Args:
        before: The first release; changes are in its standard errors and over its tested box.
        after: The second.
        drift: `drift` of the configuration: limits, and levels and slips at which mu is compared.

    Raises:
        OilfilmError: A file of one of them is missing or damaged.
    """
    both = before, after
    old, new = map(_parts, both)
    sections = [
        Section(
            title,
            ("what", "A", "B"),
            [
                (name, old[title].get(name, ""), new[title].get(name, ""))
                for name in sorted({name for name, _ in old[title].items() ^ new[title].items()})
            ],
        )
        for title in old
    ]
    verdicts = Section("Verdicts", ("row", "A", "B"), list(_verdicts(*both)))
    moved = [
        _constants(*both).assign(limit=drift.standard_errors),
        _traction(*both, drift).assign(limit=drift.traction),
    ]
    return Comparison(
        (before.name, after.name),
        _kernels(*(stored.manifest.made_from.environment for stored in both)),
        [*sections, verdicts],
        pd.concat(moved, ignore_index=True),
    )


def _kernels(before: Environment, after: Environment) -> str:
    """What to expect where two environments have different kernels, or one that is not known."""
    known = before.blas is not None and after.blas is not None
    if known and (before.blas, before.cpu) == (after.blas, after.cpu):
        return ""
    differ = before.cpu != after.cpu or known
    lines = ["Made with another kernel:" if differ else "Perhaps made with another kernel:"]
    for side, environment in (("A", before), ("B", after)):
        blas = "BLAS unknown" if environment.blas is None else ", ".join(environment.blas)
        lines.append(printable(f"  {side} {blas}; NumPy {environment.cpu or 'baseline'}"))
    lines.append(
        f"Differences of up to {KERNEL_CHANGE:g} standard errors are expected; of verdicts, none."
    )
    return "\n".join(lines)


def _moved(title: str, moved: pd.DataFrame) -> Section:
    """Changes of constants and of mu, with the limit of each kind."""
    rows = []
    for row in tables.rows(moved):
        change, limit = f"{row['change']:.3g} standard errors", f"{row['limit']:g}"
        if row["what"] == "mu":
            change, limit = f"{100 * row['change']:.3g}% at {row['where']}", f"{row['limit']:.2%}"
        ends = (f"{row[side]:.6g}" for side in ("before", "after"))
        rows.append((row["oil"], row["what"], *ends, change, limit))
    return Section(title, ("oil", "what", "A", "B", "largest change", "limit"), rows)


# ---------------------------------------------------------------- inputs, files and verdicts


def _parts(stored: StoredRelease) -> dict[str, dict[str, str]]:
    """What a release was made from and its files: section -> name -> value or hash."""
    made_from = stored.manifest.made_from
    packages = made_from.model_dump(exclude={"config", "code", "raw"})
    return {
        "Raw logs": _hashes(made_from.raw),
        "Configuration": _leaves(stored.config()),
        "Packages": _leaves(packages),
        "Files": _hashes(stored.manifest.files),
        "Samples": _hashes(stored.manifest.samples),
    }


def _hashes(records: Iterable[FileRecord]) -> dict[str, str]:
    return {record.path: record.sha256[:12] for record in records}


def _leaves(tree: dict[str, Any]) -> dict[str, str]:
    """Keys of a tree, joined by points, and the values at their ends; lists are values."""
    return {str(name): str(value) for name, value in pd.json_normalize(tree).iloc[0].items()}


def _verdicts(*both: StoredRelease) -> Iterator[Row]:
    """Rows whose verdict, the first of the columns, is another one."""
    studies.declare_tables(studies.available())
    for table, columns in _JUDGED.items():
        keys = list(tables.TABLES[table].key)
        frames = [each.table(table) for each in both]
        known = [frame.set_index(keys)[columns] for frame in frames if frame is not None]
        if len(known) < len(both):
            continue
        old, new = (frame.astype(object) for frame in known)
        joined = old.add_suffix(" A").join(new.add_suffix(" B"), how="outer")
        other = joined[f"{columns[0]} A"] != joined[f"{columns[0]} B"]
        for index, row in joined[other].iterrows():
            name = ", ".join(map(str, index)) if isinstance(index, tuple) else str(index)
            texts = row[row.notna() & (row != "")].astype(str)
            sides = (": ".join(texts.filter(regex=f" {side}$")) for side in "AB")
            yield f"{table}: {name}", *sides


# ---------------------------------------------------------------- constants and traction


def _configured_fits(stored: StoredRelease) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Coefficients and quality of the configured law of each oil; empty where there are none."""
    coefficients, quality = stored.table("coefficients"), stored.table("fit_quality")
    if coefficients is None or quality is None:
        return tables.empty("coefficients"), tables.empty("fit_quality")
    lacking = len(coefficients.merge(quality[["oil", "law"]])) != len(coefficients)
    quality = quality[quality["configured"]]
    if lacking or quality["oil"].duplicated().any() or not set(quality["law"]) <= set(LAWS):
        raise OilfilmError(
            f"{stored.folder}: tables/fit_quality.parquet lacks a fit, or has a configured law "
            "that is not known here, or more than one of an oil."
        )
    return coefficients.merge(quality[["oil", "law"]]), quality


def _constants(before: StoredRelease, after: StoredRelease) -> pd.DataFrame:
    (old, _), (new, _) = _configured_fits(before), _configured_fits(after)
    error = old["standard_error"].fillna(old["naive_standard_error"])
    both = old.rename(columns={"value": "before"}).assign(error=error.where(error != 0))
    new = new.rename(columns={"value": "after"})
    both = both.merge(new, on=["oil", "law", "constant"], how="outer")
    lost = both["before"].isna() != both["after"].isna()
    same = (both["before"] == both["after"]) | (both["before"].isna() & both["after"].isna())
    change = (both["after"] - both["before"]).abs() / both["error"]
    both = both.assign(change=change.mask(lost, np.inf).mask(same, 0.0), what=both["constant"])
    return both[["oil", "what", "before", "after", "change"]]


def _traction(before: StoredRelease, after: StoredRelease, drift: DriftSettings) -> pd.DataFrame:
    fits = []
    for coefficients, quality in map(_configured_fits, (before, after)):
        oils = coefficients["oil"].unique()
        fits.append({oil: FittedLaw.of(coefficients, oil, quality=quality) for oil in oils})
    rows: list[dict[str, Any]] = []
    for oil in sorted(fits[0].keys() | fits[1].keys()):
        try:
            row = _largest_change(oil, fits[0].get(oil), fits[1].get(oil), drift)
        except ValueError as why:
            row = {"change": np.inf, "where": str(why)}
        rows.append({"oil": oil, "what": "mu", **row})
    return pd.DataFrame(rows, columns=["oil", "what", "before", "after", "change", "where"])


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
    slips = [slip for slip in drift.slide_roll_ratio if not exceeds(slip, slip_max)]
    # a condition that was never recorded has no effect: one level
    levels = (np.linspace(low, high, drift.levels) for low, high in box)
    axes = [np.unique(level) if np.isfinite(level).all() else np.ones(1) for level in levels]
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
    worst = int(first_largest(change))
    named = zip(before.law.conditions, at[worst], strict=True)
    where = [f"{value:.4g} {tables.unit_of(name)}" for name, value in named if np.isfinite(value)]
    where.append(f"S {conditions[worst, -1]:.4g}")
    of_worst = {"change": change[worst], "before": old[worst], "after": new[worst]}
    return {**of_worst, "where": ", ".join(where)}
