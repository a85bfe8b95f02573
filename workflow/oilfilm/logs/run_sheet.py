"""What the run sheet of a campaign says of the runs; it overrides the headers of the logs.

`sheet_file` reads the sheet and finds the logs of each row.

Decides: what the run sheet says of a log, and what wins over its header.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from fnmatch import fnmatchcase
from typing import Any, Self

from oilfilm.logs.base import LOAD_KEYS, READING_NOTE, SET_POINT_KEYS, Refusal, parse_set_point
from oilfilm.logs.header import header_keys, named_keys, oil_id
from oilfilm.settings.resolved import Settings

# Rules that refuse nothing: the runs that they name are used, or do not exist.
UNMATCHED = "sheet_row_unmatched"
UNLISTED = "logs_not_in_sheet"
CONTRADICTION = "sheet_contradicts_header"
REMARKS = frozenset({UNMATCHED, UNLISTED, CONTRADICTION, READING_NOTE})
EXCLUDED = "excluded"
EXCLUDED_ADVICE = "Nothing to do. To use the run, empty the cell `exclude` of its row."
UNMATCHED_ADVICE = "Correct the row or take it out; it has no effect."


@dataclass(frozen=True)
class SheetRow:
    """The content of a row of the run sheet on which results depend.

    The row number is no part of it: a row added above must not make other logs be read again.

    Attributes:
        file: Cell of the column `file`: a name or a pattern.
        run: Name or pattern of the run in a file with several; empty for every run.
        exclude: Why the runs are not to be used; empty where they are.
        keys: Header key -> text, numbers in the unit of the key.
    """

    file: str
    run: str = ""
    exclude: str = ""
    keys: Mapping[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        return repr(self.file) + (f", run {self.run!r}" if self.run else "")


@dataclass(frozen=True)
class Labels:
    """What header and run sheet say of a run.

    Attributes:
        run_id: Name of the run.
        keys: Header keys; those of the sheet replace those of the header.
        remarks: Contradictions between header and sheet.
        excluded: Why the run is not to be used; None where it is used.
        problem: Why the run sheet cannot be followed; None where it can.
        sources: Source of each key: `header` or `run sheet`.
    """

    run_id: str
    keys: dict[str, str]
    remarks: list[Refusal]
    excluded: Refusal | None = None
    problem: Refusal | None = None
    sources: Mapping[str, str] = field(default_factory=dict)

    def with_exclusion(self, problem: Refusal) -> Refusal:
        """The refusal of a run that cannot be read; an excluded run is refused as excluded."""
        if self.excluded is None:
            return problem
        reason = f"{self.excluded.reason}; besides, {problem.reason}"
        return Refusal(EXCLUDED, reason, EXCLUDED_ADVICE)


def matches(name: str, pattern: str) -> bool:
    """Whether a name matches a pattern, in which `*` is any text and `?` one letter.

    Examples:
        >>> [matches("4102_P1.csv", pattern) for pattern in ("4102_*.csv", "4102_P?.csv", "4050*")]
        [True, True, False]
        >>> matches("run[1].csv", "run[1].csv")
        True
    """
    return fnmatchcase(name, pattern.replace("[", "[[]"))


def _agree(key: str, in_sheet: str, in_header: str, settings: Settings) -> bool:
    """Whether the sheet and the header give a key the same value."""
    if key == "oil":
        return in_sheet == oil_id(in_header, settings)
    if key not in SET_POINT_KEYS:
        return in_sheet == in_header
    sheet_value = parse_set_point(key, in_sheet)
    header_value = parse_set_point(key, in_header)
    if sheet_value is None or header_value is None:
        return False
    tolerance = settings.same_set_point
    if key == "inlet_temperature_c":
        allowed = tolerance.temperature_c
    else:
        allowed = tolerance.relative * abs(header_value)
    return abs(sheet_value - header_value) <= allowed


@dataclass(frozen=True)
class RunSheet:
    """The run sheet of a campaign, or the part of it for some logs.

    Attributes:
        name: File name of the sheet; empty where there is none.
        rows: Name of a log -> its rows.
        remarks: Remarks on the sheet itself.
    """

    name: str = ""
    rows: Mapping[str, tuple[SheetRow, ...]] = field(default_factory=dict)
    remarks: tuple[Refusal, ...] = ()

    def rows_of_run(self, file: str, run_name: str) -> list[SheetRow]:
        """The rows for one run of a log.

        Args:
            file: Name of the log.
            run_name: The run's name in the log; empty where the log is one run.
        """
        rows = self.rows.get(file, ())
        if not run_name:
            return list(rows)
        return [row for row in rows if not row.run or matches(run_name, row.run)]

    def labels(
        self, file: str, run_name: str, logged: Mapping[str, str], settings: Settings
    ) -> Labels:
        """What header and run sheet say of one run of a log.

        Args:
            file: Name of the log.
            run_name: As for `rows_of_run`.
            logged: Header lines by the keys of the log, as `plain_key` makes them.
            settings: Settings of the campaign.
        """
        run_id = f"{file}:{run_name}" if run_name else file
        named = named_keys(logged, settings)
        header = header_keys(named, settings)
        rows = self.rows_of_run(file, run_name)
        from_sheet: dict[str, str] = {}
        # the first row counts
        for row in reversed(rows):
            from_sheet |= row.keys
        # the load has one set point, as force or as pressure
        replaced_keys = LOAD_KEYS if from_sheet.keys() & LOAD_KEYS else frozenset()
        from_header = {key: text for key, text in header.items() if key not in replaced_keys}
        sources = {key: "header" for key in named if key not in replaced_keys}
        sources |= dict.fromkeys(from_sheet, "run sheet")
        return Labels(
            run_id,
            keys=from_header | from_sheet,
            remarks=self._contradictions(run_id, header, from_sheet, settings),
            excluded=self._exclusion(rows),
            problem=self._disagreement(rows),
            sources=sources,
        )

    def unmatched_rows(self, file: str, run_names: Sequence[str]) -> list[Refusal]:
        """Remarks on the rows whose run is not in the log.

        Args:
            file: Name of the log.
            run_names: Names of its runs; empty where the log is one run.
        """
        if not run_names:
            return []
        matched = [row for run_name in run_names for row in self.rows_of_run(file, run_name)]
        listed_runs = ", ".join(repr(run_name) for run_name in run_names[:10])
        more = " ..." if len(run_names) > 10 else ""
        return [
            Refusal(
                UNMATCHED,
                f"{self.name} has a row for {row}, but the runs of the log are {listed_runs}{more}",
                UNMATCHED_ADVICE,
            )
            for row in self.rows.get(file, ())
            if row not in matched
        ]

    def _exclusion(self, rows: Sequence[SheetRow]) -> Refusal | None:
        reasons = dict.fromkeys(row.exclude for row in rows if row.exclude)
        if not reasons:
            return None
        return Refusal(EXCLUDED, f"{self.name} excludes it: {'; '.join(reasons)}")

    def _disagreement(self, rows: Sequence[SheetRow]) -> Refusal | None:
        """Why the rows of a run cannot be followed: they contradict each other."""
        for key in dict.fromkeys(key for row in rows for key in row.keys):
            # the first row of each value, the values in the order of their last row
            row_of_value: dict[str, SheetRow] = {}
            for row in reversed(rows):
                if key in row.keys:
                    row_of_value[row.keys[key]] = row
            if len(row_of_value) > 1:
                statements = [
                    f"{value!r} (row of {row})" for value, row in reversed(row_of_value.items())
                ]
                return Refusal(
                    "sheet_rows_disagree",
                    f"{self.name} has several rows for the run, which disagree in {key}: "
                    f"{', '.join(statements)}",
                    "Leave one of them, or make the pattern of a row narrower.",
                )
        return None

    def _contradictions(
        self,
        run_id: str,
        header: Mapping[str, str],
        from_sheet: Mapping[str, str],
        settings: Settings,
    ) -> list[Refusal]:
        """A remark on the keys in which header and sheet disagree."""
        differences: list[str] = []
        for key, value in from_sheet.items():
            if key in header and not _agree(key, value, header[key], settings):
                differences.append(f"{key} {value} (header: {key} {header[key][:60]!r})")
        if not differences:
            return []
        reason = f"{self.name} and the header disagree: {', '.join(differences)}"
        advice = "The run sheet is used. Correct the one that is wrong."
        return [Refusal(CONTRADICTION, reason, advice, run_id)]

    def plain(self, files: Iterable[str], *, remarks: bool) -> dict[str, Any]:
        """The part for some logs as Snakemake's params hold it; empty where nothing is in it.

        Args:
            files: The logs.
            remarks: Whether the part includes the remarks on the sheet itself.
        """
        plain_rows_by_file = {
            file: [asdict(row) for row in self.rows[file]] for file in files if file in self.rows
        }
        plain_remarks = [asdict(remark) for remark in self.remarks] if remarks else []
        if not plain_rows_by_file and not plain_remarks:
            return {}
        return {"name": self.name, "rows": plain_rows_by_file, "remarks": plain_remarks}

    @classmethod
    def of_plain(cls, plain: Mapping[str, Any]) -> Self:
        """The run sheet that `plain` was made of."""
        if not plain:
            return cls()
        rows = {
            file: tuple(SheetRow(**row) for row in plain_rows)
            for file, plain_rows in plain["rows"].items()
        }
        remarks = tuple(Refusal(**remark) for remark in plain["remarks"])
        return cls(plain["name"], rows, remarks)


NO_SHEET = RunSheet()
