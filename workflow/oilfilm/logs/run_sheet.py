"""What the run sheet of a campaign says of the runs of its logs: it beats their headers.

`sheet_file` reads the sheet and finds the logs that each row is about.

Decides: what the run sheet says of a log, and what wins over its header.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from fnmatch import fnmatchcase
from typing import Any, Self

from oilfilm.logs.base import LOADS, SET_POINTS, Refusal, set_point
from oilfilm.logs.header import header_keys, named_keys, oil_id
from oilfilm.settings.resolved import Settings

# Rules that refuse nothing: what they name is used, or was never there.
UNMATCHED, UNLISTED = "sheet_row_unmatched", "logs_not_in_sheet"
CONTRADICTION = "sheet_contradicts_header"
REMARKS = frozenset({UNMATCHED, UNLISTED, CONTRADICTION})
EXCLUDED = "excluded"
EXCLUDED_ADVICE = "Nothing to do. To use the run, empty the cell `exclude` of its row."
UNMATCHED_ADVICE = "Correct the row or take it out; it has no effect."


@dataclass(frozen=True)
class SheetRow:
    """A row of the run sheet, as far as results depend on it.

    The number of the row is not part of it: a row added above must not read other logs again.

    Attributes:
        file: Cell of the column `file`: a name or a pattern.
        run: Name or pattern of the run in a file with several; empty for every run.
        exclude: Why the runs are not to be used; empty where they are.
        keys: What the row gives, by keys of headers, numbers in their units.
    """

    file: str
    run: str = ""
    exclude: str = ""
    keys: Mapping[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        return repr(self.file) + (f", run {self.run!r}" if self.run else "")


@dataclass(frozen=True)
class Labels:
    """What is known of a run, by its header and by the run sheet.

    Attributes:
        run_id: Name of the run.
        keys: Header keys, with those of the sheet over them.
        remarks: Contradictions between the two, of which the sheet is right.
        excluded: Why the run is not to be used, if so.
        problem: Why the run sheet cannot be followed, if so.
        sources: Where each key comes from: `header` or `run sheet`.
    """

    run_id: str
    keys: dict[str, str]
    remarks: list[Refusal]
    excluded: Refusal | None = None
    problem: Refusal | None = None
    sources: Mapping[str, str] = field(default_factory=dict)

    def whole(self, problem: Refusal) -> Refusal:
        """Why nothing of the run can be read; of an excluded run, that it is excluded as well."""
        if self.excluded is None:
            return problem
        reason = f"{self.excluded.reason}; besides, {problem.reason}"
        return Refusal(EXCLUDED, reason, EXCLUDED_ADVICE)


def matches(name: str, pattern: str) -> bool:
    """Whether a name fits a pattern, in which `*` is any text and `?` one letter.

    Examples:
        >>> [matches("4102_P1.csv", pattern) for pattern in ("4102_*.csv", "4102_P?.csv", "4050*")]
        [True, True, False]
        >>> matches("run[1].csv", "run[1].csv")
        True
    """
    return fnmatchcase(name, pattern.replace("[", "[[]"))


def _same(key: str, value: str, text: str, settings: Settings) -> bool:
    """Whether a value of the sheet says the same as the text of a header line."""
    if key not in SET_POINTS:
        return value == (oil_id(text, settings) if key == "oil" else text)
    in_sheet, in_header = set_point(key, value), set_point(key, text)
    if in_sheet is None or in_header is None:
        return False
    same = settings.same_set_point
    relative = same.relative * abs(in_header)
    allowed = same.temperature_c if key == "inlet_temperature_c" else relative
    return abs(in_sheet - in_header) <= allowed


@dataclass(frozen=True)
class RunSheet:
    """The run sheet of a campaign, or as much of it as concerns some logs.

    Attributes:
        name: File name of the sheet; empty where there is none.
        rows: The rows about each log, by its name.
        remarks: What was found about the sheet as a whole.
    """

    name: str = ""
    rows: Mapping[str, tuple[SheetRow, ...]] = field(default_factory=dict)
    remarks: tuple[Refusal, ...] = ()

    def about(self, file: str, part: str) -> list[SheetRow]:
        """The rows about a log, or about one run of it.

        Args:
            file: Name of the log.
            part: The run's own name in the log; empty where the log is one run.
        """
        rows = self.rows.get(file, ())
        return [row for row in rows if not (row.run and part) or matches(part, row.run)]

    def labels(self, file: str, part: str, logged: Mapping[str, str], settings: Settings) -> Labels:
        """What is known of one run of a log.

        Args:
            file: Name of the log.
            part: The run's own name in the log, as for `about`.
            logged: Header lines by the keys of the log, as `plain_key` makes them.
            settings: Settings of the campaign.
        """
        run_id = f"{file}:{part}" if part else file
        named = named_keys(logged, settings)
        header = header_keys(named, settings)
        rows = self.about(file, part)
        given = {key: value for row in reversed(rows) for key, value in row.keys.items()}
        # the load has one set point, as force or as pressure
        over = LOADS if given.keys() & LOADS else frozenset()
        keys = {key: text for key, text in header.items() if key not in over} | given
        remarks = self._contradictions(run_id, header, given, settings)
        sources = dict.fromkeys(named.keys() - over, "header") | dict.fromkeys(given, "run sheet")
        excluded, problem = self._exclusion(rows), self._disagreement(rows)
        return Labels(run_id, keys, remarks, excluded, problem, sources)

    def strays(self, file: str, parts: Sequence[str]) -> list[Refusal]:
        """The rows that name a run which the log does not have, by its own names of its runs."""
        known = ", ".join(map(repr, parts[:10])) + (" ..." if len(parts) > 10 else "")
        about = [row for part in parts for row in self.about(file, part)]
        rows = [row for row in self.rows.get(file, ()) if parts and row not in about]
        said, end = f"{self.name} has a row for", f"but the runs of the log are {known}"
        return [Refusal(UNMATCHED, f"{said} {row}, {end}", UNMATCHED_ADVICE) for row in rows]

    def _exclusion(self, rows: Sequence[SheetRow]) -> Refusal | None:
        reasons = dict.fromkeys(row.exclude for row in rows if row.exclude)
        reason = f"{self.name} excludes it: {'; '.join(reasons)}"
        return Refusal(EXCLUDED, reason) if reasons else None

    def _disagreement(self, rows: Sequence[SheetRow]) -> Refusal | None:
        """Why the rows about a run cannot be followed: they contradict each other."""
        for key in dict.fromkeys(key for row in rows for key in row.keys):
            given = {row.keys[key]: row for row in reversed(rows) if key in row.keys}
            if len(given) > 1:
                of_rows = (f"{value!r} (row of {row})" for value, row in reversed(given.items()))
                reason = f"{self.name} has several rows for the run, which disagree in {key}: "
                advice = "Leave one of them, or make the pattern of a row narrower."
                return Refusal("sheet_rows_disagree", reason + ", ".join(of_rows), advice)
        return None

    def _contradictions(
        self, run_id: str, header: Mapping[str, str], given: Mapping[str, str], settings: Settings
    ) -> list[Refusal]:
        differing: list[str] = []
        for key, value in given.items():
            if key in header and not _same(key, value, header[key], settings):
                differing.append(f"{key} {value} (header: {key} {header[key][:60]!r})")
        reason = f"{self.name} and the header disagree: {', '.join(differing)}"
        advice = "The run sheet is used. Correct the one that is wrong."
        return [Refusal(CONTRADICTION, reason, advice, run_id)] if differing else []

    def plain(self, files: Iterable[str], *, remarks: bool) -> dict[str, Any]:
        """The part about some logs as Snakemake's params hold it; empty where it says nothing.

        Args:
            files: The logs.
            remarks: Whether the remarks on the sheet as a whole belong to the part.
        """
        rows = {
            file: [asdict(row) for row in self.rows[file]] for file in files if file in self.rows
        }
        found = [asdict(remark) for remark in self.remarks] if remarks else []
        return {"name": self.name, "rows": rows, "remarks": found} if rows or found else {}

    @classmethod
    def of_plain(cls, plain: Mapping[str, Any]) -> Self:
        """What `plain` has made."""
        if not plain:
            return cls()
        rows = {file: tuple(SheetRow(**row) for row in of) for file, of in plain["rows"].items()}
        return cls(plain["name"], rows, tuple(Refusal(**each) for each in plain["remarks"]))


NO_SHEET = RunSheet()
