"""Compare two releases: inputs, configuration, code, statements, constants and traction.

Decides: the drift gate of `oilfilm diff --gate`: when a refit has moved too far, or states
something else (the limits are `drift` of `config.yaml`).
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.base.errors import OilfilmError, printable
from oilfilm.base.text_table import text_table
from oilfilm.base.ties import exceeds, first_largest
from oilfilm.base.units import FloatArray
from oilfilm.fits.fitted import FittedLaw
from oilfilm.releases.manifest import Environment, FileRecord
from oilfilm.releases.statements import Statement, changed_lines, changed_statements
from oilfilm.releases.stored_release import StoredRelease
from oilfilm.settings.config import DriftSettings
from oilfilm.traction import LAWS

# A row of a table of texts: one text per column.
TextRow = tuple[str, ...]
# Largest change of a number by another kernel, in standard errors. A kernel is the set of routines
# that BLAS or NumPy chooses for the processor.
# `tests/workflow/test_kernels.py` compares all tables of a campaign.
KERNEL_CHANGE = 1e-6
# The text of a release whose lines are compared.
_SUMMARY_FILE = "summary.txt"


@dataclass(frozen=True)
class DiffSection:
    """What differs between two releases in one respect, as a table of texts; no rows if nothing."""

    title: str
    columns: TextRow
    rows: Sequence[TextRow]

    def text(self) -> str:
        """An aligned table; control characters are escaped."""
        lines = text_table([self.columns, *self.rows], indent="  ")
        return "\n".join([f"{self.title}: {len(self.rows)}", *lines])


@dataclass(frozen=True)
class Comparison:
    """Everything in which release B differs from release A.

    Attributes:
        release_names: Names of both releases.
        kernel_note: Kernels of both and their expected effect, as text; empty where they are known
            and the same.
        input_sections: Sections on inputs, configuration, packages, files and samples.
        statements: Verdicts, codes, counts, errors and nulls of tables that differ, as
            `statements.changed_statements` compares them.
        summary_lines: Lines of the summary that differ.
        summary_wording: Those of them that differ in words or counts, not in other numbers alone.
        same_logs: Whether both were made from the same raw logs. With other logs, rows, counts and
            sentences may be others, too.
        changes: oil, what, before, after, change and limit of each constant and of mu; NaN where
            there is none. The change of a constant is in standard errors of the first release. It
            is infinite where one release has no value, and NaN where there is no standard error
            (few curves); the change of mu counts then. The change of mu is relative, where it is
            largest (`where`) over the tested box of the first release. It is infinite where mu
            cannot be compared, and `where` has the reason.
    """

    release_names: tuple[str, str]
    kernel_note: str
    input_sections: Sequence[DiffSection]
    statements: Sequence[Statement]
    summary_lines: DiffSection
    summary_wording: DiffSection
    same_logs: bool
    changes: pd.DataFrame

    @property
    def sections(self) -> list[DiffSection]:
        """Every section that has rows."""
        section_on_changes = _section_on_changes(
            "Constants and traction", self.changes[self.changes["change"] != 0]
        )
        statements = _section_on_statements(self.statements)
        sections = (*self.input_sections, statements, self.summary_lines, section_on_changes)
        return [section for section in sections if section.rows]

    @property
    def beyond_limits(self) -> list[DiffSection]:
        """The drift gate: sections with the changes that it does not let pass; none if all pass.

        Where logs were added, rows, counts and sentences change with them and pass, and so does an
        oil that had no fit before.
        """
        is_too_far = exceeds(self.changes["change"], self.changes["limit"])
        if not self.same_logs:
            is_too_far &= self.changes.groupby("oil")["before"].transform("count") > 0
        moved_too_far = self.changes[is_too_far]
        section_on_changes = _section_on_changes(
            "Moved by more than the drift gate lets pass", moved_too_far
        )
        sections = [section_on_changes]
        if self.same_logs:
            sections += [_section_on_statements(self.statements), self.summary_wording]
        else:
            statements_on_results = [
                statement for statement in self.statements if not statement.changes_with_logs
            ]
            sections.append(_section_on_statements(statements_on_results))
        return [section for section in sections if section.rows]

    def text(self, sections: Sequence[DiffSection]) -> str:
        """Some sections for a terminal, below the names of both releases."""
        name_before, name_after = self.release_names
        blocks = [f"A {name_before}\nB {name_after}"]
        if self.kernel_note:
            blocks.append(self.kernel_note)
        blocks += [section.text() for section in sections] or ["no difference"]
        return "\n\n".join(blocks)


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
    values_before = _values_by_section(before)
    values_after = _values_by_section(after)
    input_sections = [
        DiffSection(
            title, ("what", "A", "B"), _different_values(values_before[title], values_after[title])
        )
        for title in values_before
    ]
    # `drift.errors` is the largest relative change of a standard error or a width of an interval
    statements = list(changed_statements(before.read_table, after.read_table, drift.errors))
    input_sections.append(
        DiffSection("Columns of tables", ("column", "A", "B"), _unshared_columns(before, after))
    )
    try:
        fits_before = _configured_fits(before)
        fits_after = _configured_fits(after)
        changes_of_constants = _changes_of_constants(fits_before, fits_after)
        changes_of_traction = _changes_of_traction(fits_before, fits_after, drift)
    except KeyError as error:
        raise OilfilmError(
            f"{before.name}, {after.name}: the constants cannot be compared, because the column "
            f"{error} is missing in coefficients or fit_quality. Compare with the version of "
            "oilfilm that made them."
        ) from error
    changes_of_constants = changes_of_constants.assign(limit=drift.standard_errors)
    changes_of_traction = changes_of_traction.assign(limit=drift.traction)
    return Comparison(
        release_names=(before.name, after.name),
        kernel_note=_kernel_note(
            before.manifest.made_from.environment, after.manifest.made_from.environment
        ),
        input_sections=input_sections,
        statements=statements,
        summary_lines=DiffSection(
            "Lines of the summary",
            ("in", "line"),
            _changed_lines_of_summary(before, after, with_numbers=True),
        ),
        summary_wording=DiffSection(
            "Lines of the summary with other words or counts",
            ("in", "line"),
            _changed_lines_of_summary(before, after, with_numbers=False),
        ),
        same_logs=before.manifest.made_from.raw == after.manifest.made_from.raw,
        changes=pd.concat([changes_of_constants, changes_of_traction], ignore_index=True),
    )


def _different_values(
    before_by_name: dict[str, str], after_by_name: dict[str, str]
) -> list[TextRow]:
    """Rows of name, first and second value where the two differ; empty where one has none."""
    different_names = {name for name, _ in before_by_name.items() ^ after_by_name.items()}
    return [
        (name, before_by_name.get(name, ""), after_by_name.get(name, ""))
        for name in sorted(different_names)
    ]


def _kernel_note(environment_before: Environment, environment_after: Environment) -> str:
    """The expected effect where two environments have different or unknown kernels, as text."""
    both_are_known = environment_before.blas is not None and environment_after.blas is not None
    if both_are_known and (environment_before.blas, environment_before.cpu) == (
        environment_after.blas,
        environment_after.cpu,
    ):
        return ""
    surely_differ = environment_before.cpu != environment_after.cpu or both_are_known
    lines = ["Made with another kernel:" if surely_differ else "Perhaps made with another kernel:"]
    for release_letter, environment in (("A", environment_before), ("B", environment_after)):
        blas = "BLAS unknown" if environment.blas is None else ", ".join(environment.blas)
        lines.append(printable(f"  {release_letter} {blas}; NumPy {environment.cpu or 'baseline'}"))
    lines.append(
        f"Differences of up to {KERNEL_CHANGE:g} standard errors are expected; of verdicts, none."
    )
    return "\n".join(lines)


def _section_on_statements(statements: Iterable[Statement]) -> DiffSection:
    """Changed statements of tables, one row per statement."""
    rows = [statement[:-1] for statement in statements]
    return DiffSection("Statements", ("table", "row", "column", "A", "B"), rows)


def _section_on_changes(title: str, changes: pd.DataFrame) -> DiffSection:
    """Changes of constants and of mu, with the limit of each kind."""
    rows = []
    for row in tables.rows(changes):
        limit = f"{row['limit']:.2%}" if row["what"] == "mu" else f"{row['limit']:g}"
        before, after = (
            "none" if np.isnan(row[name]) else f"{row[name]:.6g}" for name in ("before", "after")
        )
        rows.append((row["oil"], row["what"], before, after, _change_in_words(row), limit))
    return DiffSection(title, ("oil", "what", "A", "B", "largest change", "limit"), rows)


def _change_in_words(row: Mapping[str, Any]) -> str:
    """The change in a row of `Comparison.changes`; where it is no number, the reason."""
    change = row["change"]
    if row["what"] == "mu":
        if np.isfinite(change):
            return f"{100 * change:.3g}% at {row['where']}"
        if np.isnan(row["before"]) and np.isnan(row["after"]):
            return f"not comparable: {row['where']}"
        return f"mu is 0 or unknown in one release, at {row['where']}"
    if np.isnan(change):
        return "not judged: no standard error"
    if np.isinf(change):
        return "in one release only"
    return f"{change:.3g} standard errors"


# ---------------------------------------------------------------- inputs, files and verdicts


def _values_by_section(stored: StoredRelease) -> dict[str, dict[str, str]]:
    """Inputs and files of a release: by title of a section, the value or hash of each name."""
    made_from = stored.manifest.made_from
    packages = made_from.model_dump(exclude={"config", "code", "raw"})
    return {
        "Raw logs": _hash_by_path(made_from.raw),
        "Configuration": _value_by_key(stored.read_config()),
        "Packages": _value_by_key(packages),
        "Files": _hash_by_path(stored.manifest.files),
        "Samples": _hash_by_path(stored.manifest.samples),
    }


def _hash_by_path(records: Iterable[FileRecord]) -> dict[str, str]:
    """The beginning of the hash of each file, by path."""
    return {record.path: record.sha256[:12] for record in records}


def _value_by_key(tree: dict[str, Any]) -> dict[str, str]:
    """The values in nested mappings, by their keys joined by points; a list is one value."""
    return {str(name): str(value) for name, value in pd.json_normalize(tree).iloc[0].items()}


def _unshared_columns(before: StoredRelease, after: StoredRelease) -> list[TextRow]:
    """Columns that only one of two releases has, of the tables that both have.

    Versions of oilfilm add columns. Their values are not compared.
    """
    rows = []
    for table_name in sorted(tables.TABLES):
        names_before = before.column_names(table_name)
        names_after = after.column_names(table_name)
        if names_before is None or names_after is None:
            continue
        for name in sorted(set(names_before) ^ set(names_after)):
            presence_texts = [
                "there" if name in names else "" for names in (names_before, names_after)
            ]
            rows.append((f"{table_name}.{name}", *presence_texts))
    return rows


def _changed_lines_of_summary(
    before: StoredRelease, after: StoredRelease, *, with_numbers: bool
) -> list[TextRow]:
    """The lines of the summary that differ; none where a release has no summary."""
    lines_before = before.read_lines(_SUMMARY_FILE)
    lines_after = after.read_lines(_SUMMARY_FILE)
    if lines_before is None or lines_after is None:
        return []
    return list(changed_lines(lines_before, lines_after, with_numbers=with_numbers))


# ---------------------------------------------------------------- constants and traction


class _ConfiguredFits(NamedTuple):
    """Fits of the configured law of each oil; the tables are empty where there are none.

    Attributes:
        coefficients: Rows of the table `coefficients`.
        quality: Rows of the table `fit_quality`.
    """

    coefficients: pd.DataFrame
    quality: pd.DataFrame


def _configured_fits(stored: StoredRelease) -> _ConfiguredFits:
    """The fits of the configured law in a release."""
    coefficients = stored.read_table("coefficients")
    quality = stored.read_table("fit_quality")
    if coefficients is None or quality is None:
        return _ConfiguredFits(
            tables.empty_table("coefficients"), tables.empty_table("fit_quality")
        )
    lacks_a_fit = len(coefficients.merge(quality[["oil", "law"]])) != len(coefficients)
    quality = quality[quality["configured"]]
    has_unknown_law = not set(quality["law"]) <= set(LAWS)
    if lacks_a_fit or has_unknown_law or quality["oil"].duplicated().any():
        raise OilfilmError(
            f"{stored.folder}: tables/fit_quality.parquet lacks a fit, or has a configured law "
            "that is not known here, or more than one of an oil."
        )
    return _ConfiguredFits(coefficients.merge(quality[["oil", "law"]]), quality)


def _changes_of_constants(before: _ConfiguredFits, after: _ConfiguredFits) -> pd.DataFrame:
    """Changes of the constants in standard errors, as in `Comparison.changes`."""
    constants_before = before.coefficients
    standard_error = constants_before["standard_error"].fillna(
        constants_before["naive_standard_error"]
    )
    constants_before = constants_before.rename(columns={"value": "before"}).assign(
        error=standard_error.where(standard_error != 0)
    )
    constants_after = after.coefficients.rename(columns={"value": "after"})
    constants = constants_before.merge(constants_after, on=["oil", "law", "constant"], how="outer")
    lacks_before = constants["before"].isna()
    lacks_after = constants["after"].isna()
    is_same = (constants["before"] == constants["after"]) | (lacks_before & lacks_after)
    change = (constants["after"] - constants["before"]).abs() / constants["error"]
    change = change.mask(lacks_before != lacks_after, np.inf).mask(is_same, 0.0)
    constants = constants.assign(change=change, what=constants["constant"])
    return constants[["oil", "what", "before", "after", "change"]]


def _changes_of_traction(
    before: _ConfiguredFits, after: _ConfiguredFits, drift: DriftSettings
) -> pd.DataFrame:
    """Largest relative change of mu of each oil, as in `Comparison.changes`."""
    fits_before = _fits_by_oil(before)
    fits_after = _fits_by_oil(after)
    rows: list[dict[str, Any]] = []
    for oil in sorted(fits_before.keys() | fits_after.keys()):
        try:
            row = _largest_change(oil, fits_before.get(oil), fits_after.get(oil), drift)
        except ValueError as error:
            row = {"change": np.inf, "where": str(error)}
        row["oil"] = oil
        row["what"] = "mu"
        rows.append(row)
    return pd.DataFrame(rows, columns=["oil", "what", "before", "after", "change", "where"])


def _fits_by_oil(fits: _ConfiguredFits) -> dict[str, FittedLaw]:
    """The fit of the configured law of each oil."""
    oils = fits.coefficients["oil"].unique()
    return {
        oil: FittedLaw.from_tables(fits.coefficients, oil, quality=fits.quality) for oil in oils
    }


def _largest_change(
    oil: str, fit_before: FittedLaw | None, fit_after: FittedLaw | None, drift: DriftSettings
) -> dict[str, Any]:
    """The largest relative change of mu of one oil: before, after, change and where.

    Raises:
        ValueError: The fits cannot be compared.
    """
    if fit_before is None or fit_after is None:
        raise ValueError(f"{oil} is fitted in one release only")
    if fit_before.law.conditions != fit_after.law.conditions:
        raise ValueError(f"laws {fit_before.law.name} and {fit_after.law.name}")
    grid_points = _comparison_grid(fit_before.coefficients.tested_box, drift)
    slip = grid_points[:, -1]
    # where a condition is not followed, along its tested level or line
    conditions = fit_before.at_tested_levels(grid_points[:, :-1])
    mu_before = fit_before.predict(conditions, slip).traction_coefficient
    mu_after = fit_after.predict(conditions, slip).traction_coefficient
    with np.errstate(divide="ignore", invalid="ignore"):
        change = np.abs(mu_after - mu_before) / np.abs(mu_before)
    # missing in one release: infinite change
    change[np.isnan(change)] = np.inf
    change[(mu_after == mu_before) | (np.isnan(mu_before) & np.isnan(mu_after))] = 0.0
    worst_index = int(first_largest(change))
    texts_of_point = [
        f"{value:.4g} {tables.unit_of(name)}"
        for name, value in zip(fit_before.law.conditions, conditions[worst_index], strict=True)
        if np.isfinite(value)
    ]
    texts_of_point.append(f"S {slip[worst_index]:.4g}")
    return {
        "before": mu_before[worst_index],
        "after": mu_after[worst_index],
        "change": change[worst_index],
        "where": ", ".join(texts_of_point),
    }


def _comparison_grid(box: FloatArray, drift: DriftSettings) -> FloatArray:
    """All combinations of levels at which mu is compared: conditions and slide-roll ratio.

    Args:
        box: Lowest and highest tested level of each condition and of the slide-roll ratio, shape
            (conditions + 1, 2).
        drift: The numbers of levels, and the slide-roll ratios.
    """
    levels_by_axis = []
    for low, high in box[:-1]:
        levels = np.linspace(low, high, drift.levels)
        # a condition that was never recorded has no effect: one level
        levels_by_axis.append(np.unique(levels) if np.isfinite(levels).all() else np.ones(1))
    smallest_slip, largest_slip = box[-1]
    slips = [
        slip
        for slip in drift.slide_roll_ratio
        if not exceeds(slip, largest_slip) and not exceeds(smallest_slip, slip)
    ]
    levels_by_axis.append(np.array(slips or [largest_slip]))
    return np.stack(np.meshgrid(*levels_by_axis, indexing="ij"), axis=-1).reshape(
        -1, len(levels_by_axis)
    )
