"""What the run sheet of a campaign says of the runs; it overrides the headers of the logs.

`sheet_file` reads the sheet and finds the logs of each row.

Decides: what the run sheet says of a log, and what wins over its header.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from fnmatch import fnmatchcase
from typing import Any, Self

from oilfilm.logs.base import LOAD_KEYS, READING_NOTE, SET_POINT_KEYS, Refusal, parse_set_point
from oilfilm.logs.header import oil_id, project_header, with_default_rig_and_oil
from oilfilm.settings.resolved import Settings

# Names of rules. The `REMARK_RULES` refuse nothing: the runs that they name are used, or do not
# exist.
UNMATCHED = "sheet_row_unmatched"
UNLISTED = "logs_not_in_sheet"
CONTRADICTION = "sheet_contradicts_header"
REMARK_RULES = frozenset({UNMATCHED, UNLISTED, CONTRADICTION, READING_NOTE})
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
        text_of_key: Header key -> its text, numbers in the unit of the key.
    """

    file: str
    run: str = ""
    exclude: str = ""
    text_of_key: Mapping[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        return repr(self.file) + (f", run {self.run!r}" if self.run else "")


@dataclass(frozen=True)
class RunMetadata:
    """What header and run sheet say of a run.

    Attributes:
        run_id: Name of the run.
        text_of_key: Key of the project -> its text. The texts of the sheet replace those of the
            header.
        remarks: Contradictions between header and sheet.
        exclusion: Why the run is not to be used; None where it is used.
        problem: Why the run sheet cannot be followed; None where it can.
        source_of_key: Source of each key: `header` or `run sheet`.
    """

    run_id: str
    text_of_key: dict[str, str]
    remarks: list[Refusal]
    exclusion: Refusal | None = None
    problem: Refusal | None = None
    source_of_key: Mapping[str, str] = field(default_factory=dict)

    def with_exclusion(self, problem: Refusal) -> Refusal:
        """The refusal of a run that cannot be read; an excluded run is refused as excluded."""
        if self.exclusion is None:
            return problem
        reason = f"{self.exclusion.reason}; besides, {problem.reason}"
        return Refusal(EXCLUDED, reason, EXCLUDED_ADVICE)


def matches(name: str, pattern: str) -> bool:
    """Whether a name matches a pattern, in which `*` is any text and `?` one character.

    Examples:
        >>> [matches("4102_P1.csv", pattern) for pattern in ("4102_*.csv", "4102_P?.csv", "4050*")]
        [True, True, False]
        >>> matches("run[1].csv", "run[1].csv")
        True
    """
    return fnmatchcase(name, pattern.replace("[", "[[]"))


def _agree(key: str, sheet_text: str, header_text: str, settings: Settings) -> bool:
    """Whether the texts of a key in sheet and header have the same meaning."""
    if key == "oil":
        return sheet_text == oil_id(header_text, settings)
    if key not in SET_POINT_KEYS:
        return sheet_text == header_text
    sheet_value = parse_set_point(key, sheet_text)
    header_value = parse_set_point(key, header_text)
    if sheet_value is None or header_value is None:
        return False
    same_set_point = settings.same_set_point
    if key == "inlet_temperature_c":
        largest_difference = same_set_point.temperature_c
    else:
        largest_difference = same_set_point.relative * abs(header_value)
    return abs(sheet_value - header_value) <= largest_difference


@dataclass(frozen=True)
class RunSheet:
    """The run sheet of a campaign, or the part of it for some logs.

    Attributes:
        name: File name of the sheet; empty where there is none.
        rows_of_log: Name of a log -> its rows.
        remarks: Remarks on the sheet itself.
    """

    name: str = ""
    rows_of_log: Mapping[str, tuple[SheetRow, ...]] = field(default_factory=dict)
    remarks: tuple[Refusal, ...] = ()

    def rows_of_run(self, file: str, run_names: Sequence[str]) -> list[SheetRow]:
        """The rows for one run of a log.

        Args:
            file: Name of the log.
            run_names: The run's name in the log, then those of the runs that it is a part of; empty
                where the log is one run.
        """
        rows = self.rows_of_log.get(file, ())
        if not run_names:
            return list(rows)
        return [
            row
            for row in rows
            if not row.run or any(matches(run_name, row.run) for run_name in run_names)
        ]

    def run_metadata(
        self,
        file: str,
        run_names: Sequence[str],
        text_of_logged_key: Mapping[str, str],
        settings: Settings,
        decimal_mark: str = ".",
    ) -> RunMetadata:
        """What header and run sheet say of one run of a log.

        Args:
            file: Name of the log.
            run_names: As for `rows_of_run`.
            text_of_logged_key: Key of the log, as `plain_key` makes it -> text of the header line.
            settings: Settings of the campaign.
            decimal_mark: Decimal mark of the log.
        """
        run_id = f"{file}:{run_names[0]}" if run_names else file
        text_of_stated_key = project_header(text_of_logged_key, settings, decimal_mark)
        text_of_header_key = with_default_rig_and_oil(text_of_stated_key, settings)
        rows = self.rows_of_run(file, run_names)
        text_of_sheet_key: dict[str, str] = {}
        # the first row counts
        for row in reversed(rows):
            text_of_sheet_key |= row.text_of_key
        # the load has one set point, as force or as pressure
        replaced_keys = LOAD_KEYS if text_of_sheet_key.keys() & LOAD_KEYS else frozenset()
        kept_text_of_header_key = {
            key: text for key, text in text_of_header_key.items() if key not in replaced_keys
        }
        source_of_key = {key: "header" for key in text_of_stated_key if key not in replaced_keys}
        source_of_key |= dict.fromkeys(text_of_sheet_key, "run sheet")
        return RunMetadata(
            run_id,
            text_of_key=kept_text_of_header_key | text_of_sheet_key,
            remarks=self._contradictions(run_id, text_of_header_key, text_of_sheet_key, settings),
            exclusion=self._exclusion(rows),
            problem=self._disagreement(rows),
            source_of_key=source_of_key,
        )

    def unmatched_rows(self, file: str, names_of_runs: Sequence[Sequence[str]]) -> list[Refusal]:
        """Remarks on the rows whose run is not in the log.

        Args:
            file: Name of the log.
            names_of_runs: Names of each of its runs, as for `rows_of_run`; empty where the log is
                one run.
        """
        if not names_of_runs:
            return []
        matched_rows = [
            row for run_names in names_of_runs for row in self.rows_of_run(file, run_names)
        ]
        runs_in_words = ", ".join(repr(run_names[0]) for run_names in names_of_runs[:10])
        more = " ..." if len(names_of_runs) > 10 else ""
        return [
            Refusal(
                UNMATCHED,
                f"{self.name} has a row for {row}, but the runs of the log are "
                f"{runs_in_words}{more}",
                UNMATCHED_ADVICE,
            )
            for row in self.rows_of_log.get(file, ())
            if row not in matched_rows
        ]

    def _exclusion(self, rows: Sequence[SheetRow]) -> Refusal | None:
        reasons = dict.fromkeys(row.exclude for row in rows if row.exclude)
        if not reasons:
            return None
        return Refusal(EXCLUDED, f"{self.name} excludes it: {'; '.join(reasons)}")

    def _disagreement(self, rows: Sequence[SheetRow]) -> Refusal | None:
        """Why the rows of a run cannot be followed: they contradict each other."""
        for key in dict.fromkeys(key for row in rows for key in row.text_of_key):
            first_row_of_value: dict[str, SheetRow] = {}
            for row in rows:
                if key in row.text_of_key:
                    first_row_of_value.setdefault(row.text_of_key[key], row)
            if len(first_row_of_value) > 1:
                statements = [
                    f"{value!r} (row of {row})" for value, row in first_row_of_value.items()
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
        text_of_header_key: Mapping[str, str],
        text_of_sheet_key: Mapping[str, str],
        settings: Settings,
    ) -> list[Refusal]:
        """A remark on the keys in which header and sheet disagree."""
        differences: list[str] = []
        for key, sheet_text in text_of_sheet_key.items():
            if key in text_of_header_key and not _agree(
                key, sheet_text, text_of_header_key[key], settings
            ):
                differences.append(
                    f"{key} {sheet_text} (header: {key} {text_of_header_key[key][:60]!r})"
                )
        if not differences:
            return []
        reason = f"{self.name} and the header disagree: {', '.join(differences)}"
        advice = "The run sheet is used. Correct the one that is wrong."
        return [Refusal(CONTRADICTION, reason, advice, run_id)]

    def to_params(self, files: Iterable[str], *, with_remarks: bool) -> dict[str, Any]:
        """The rows for some logs as Snakemake's params, in plain types; empty without any.

        Args:
            files: The logs.
            with_remarks: Whether the part includes the remarks on the sheet itself.
        """
        rows_of_log = {
            file: [asdict(row) for row in self.rows_of_log[file]]
            for file in files
            if file in self.rows_of_log
        }
        remarks_as_params = [asdict(remark) for remark in self.remarks] if with_remarks else []
        if not rows_of_log and not remarks_as_params:
            return {}
        return {"name": self.name, "rows": rows_of_log, "remarks": remarks_as_params}

    @classmethod
    def from_params(cls, params: Mapping[str, Any]) -> Self:
        """The run sheet from which `to_params` made these params."""
        if not params:
            return cls()
        rows_of_log = {
            file: tuple(SheetRow(**row) for row in rows_as_params)
            for file, rows_as_params in params["rows"].items()
        }
        remarks = tuple(Refusal(**remark) for remark in params["remarks"])
        return cls(params["name"], rows_of_log, remarks)


NO_SHEET = RunSheet()
