"""Questions for the lines that `oilfilm init` cannot fill in, and the check of its own result.

Decides: which answers a line of the settings takes.
"""

import csv
import io
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from oilfilm.api.log_check import reports_on_logs, verdict_lines
from oilfilm.base.atomic_write import write_text
from oilfilm.base.errors import OilfilmError
from oilfilm.base.units import conversion
from oilfilm.cli.arguments import typed_quantity
from oilfilm.cli.settings_line import FILL_IN, settings_line
from oilfilm.logs.header import split_bracketed_unit
from oilfilm.logs.ingest import read_bytes
from oilfilm.logs.meaning import split_unit
from oilfilm.logs.raw_files import raw_log_names
from oilfilm.logs.sniff import VOCABULARY
from oilfilm.logs.text_rows import normalised
from oilfilm.settings.campaign import Semantics
from oilfilm.settings.messages import first_mistake
from oilfilm.settings.resolve import resolve
from oilfilm.settings.rig import Elasticity, Rig

# Function that asks a person: it takes the prompt and returns the answer, as `input` does.
Ask = Callable[[str], str]
# Function that shows a line of text, as `print` does.
Say = Callable[[str], None]

# Number of rounds of questions: each round asks for what the check of the last one lacked.
_MAX_ROUNDS = 4
# Number of different reasons for refusals that are shown, each with the first of its logs.
_MAX_SHOWN_REASONS = 3
_STEEL_ELASTICITY = {"youngs_modulus_pa": 206e9, "poisson_ratio": 0.3}


@dataclass(frozen=True)
class OpenLine:
    """A line of a settings file whose value only the laboratory knows.

    Attributes:
        file: Path of the file below the project.
        number: Number of the line in the file, from 1.
        text: The line, without its line end.
    """

    file: str
    number: int
    text: str

    @property
    def key(self) -> str:
        """The key of the line."""
        return self.text.partition(":")[0].strip()

    @property
    def value(self) -> Any:
        """The value that the line has already."""
        return yaml.safe_load(self.text.strip())[self.key]

    @property
    def column(self) -> dict[str, Any] | None:
        """Name and unit of a column, if the line is one of `columns`; else None."""
        value = self.value
        return value if isinstance(value, dict) and "name" in value else None

    @property
    def what_is_asked(self) -> str:
        """What is to be filled in, in words."""
        return self.text.partition(FILL_IN)[2].lstrip(": ")


@dataclass(frozen=True)
class ProjectCheck:
    """What `oilfilm check` finds in a new project.

    Attributes:
        mistake: The mistake in the settings, as a sentence; empty where logs were judged.
        log_reports: The reports on the logs, as `reports_on_logs` gives them.
        rig_names: Names of the rigs.
    """

    mistake: str
    log_reports: Sequence[dict[str, Any]] = ()
    rig_names: Sequence[str] = ()

    @property
    def refused_reports(self) -> list[dict[str, Any]]:
        """The reports on refused logs."""
        return [log_report for log_report in self.log_reports if log_report["verdict"] == "refused"]

    @property
    def missing_keys_by_rig(self) -> dict[str, list[str]]:
        """Keys of lengths that the files of rigs lack, by the name of the rig."""
        keys_by_rig: dict[str, dict[str, None]] = {}
        length_keys = [key for key in Rig.model_fields if key.endswith("_m")]
        for log_report in self.refused_reports:
            for refusal in log_report["refusals"]:
                if refusal["rule"] != "rig":
                    continue
                for rig_name in self.rig_names:
                    if repr(rig_name) in refusal["reason"]:
                        keys = [key for key in length_keys if key in refusal["reason"]]
                        keys_by_rig.setdefault(rig_name, {}).update(dict.fromkeys(keys))
        return {rig_name: list(keys) for rig_name, keys in keys_by_rig.items()}


def open_lines(folder: Path, file_names: Sequence[str]) -> list[OpenLine]:
    """The lines of a project's files that are to be filled in.

    Args:
        folder: The project.
        file_names: Paths of the files below the folder.
    """
    lines = []
    for file_name in file_names:
        text = (folder / file_name).read_text(encoding="utf-8-sig")
        for number, line in enumerate(text.splitlines(), start=1):
            if FILL_IN in line:
                lines.append(OpenLine(file_name, number, line))
    return lines


def check_project(folder: Path, campaign_name: str) -> ProjectCheck:
    """Check the logs of a new project as `oilfilm check` does."""
    raw_folder = folder / "data/raw"
    try:
        settings = resolve(folder / "config", {})
        logs_folder = raw_folder / campaign_name
        log_paths = [logs_folder / name for name in raw_log_names(logs_folder)]
        reader_by_path = {str(path): partial(read_bytes, path) for path in log_paths}
        log_reports = reports_on_logs(reader_by_path, settings, raw_folder)
        return ProjectCheck("", log_reports, list(settings.rigs))
    except OilfilmError as mistake:
        return ProjectCheck(str(mistake))


def outcome_lines(project_check: ProjectCheck, folder: Path) -> Iterator[str]:
    """Lines on what the check finds: a mistake, or the number of accepted logs and the reasons."""
    if project_check.mistake:
        yield f"check: {project_check.mistake}"
        return
    accepted_count = len(project_check.log_reports) - len(project_check.refused_reports)
    yield f"check: {accepted_count} of {len(project_check.log_reports)} logs are accepted"
    # data/raw may have a folder of the same name, which stays in its path
    paths_in_folder = re.compile(rf"(?<![\w/.-]){re.escape(str(folder))}/")
    reports_by_rule: dict[str, list[dict[str, Any]]] = {}
    for log_report in project_check.refused_reports:
        reports_by_rule.setdefault(_most_frequent_rule(log_report), []).append(log_report)
    for log_reports in list(reports_by_rule.values())[:_MAX_SHOWN_REASONS]:
        for line in verdict_lines(log_reports[0]):
            yield f"  {paths_in_folder.sub('', line)}"
        if len(log_reports) > 1:
            more_count = len(log_reports) - 1
            noun = "log" if more_count == 1 else "logs"
            yield f"  and {more_count} more {noun} for this reason"
    if len(reports_by_rule) > _MAX_SHOWN_REASONS:
        other_count = len(reports_by_rule) - _MAX_SHOWN_REASONS
        noun = "reason" if other_count == 1 else "reasons"
        yield f"  and {other_count} other {noun}: see `oilfilm check`"


def _most_frequent_rule(log_report: Mapping[str, Any]) -> str:
    """The rule by which most parts of a log are refused; empty if none is."""
    count_by_rule = Counter(refusal["rule"] for refusal in log_report["refusals"])
    for run in log_report["runs"]:
        count_by_rule.update(failure["gate"] for failure in run["failed_gates"])
    return count_by_rule.most_common(1)[0][0] if count_by_rule else ""


def ask_and_check(
    folder: Path,
    campaign_name: str,
    file_names: Sequence[str],
    unit_of_column: Mapping[str, str],
    ask: Ask,
    say: Say,
) -> ProjectCheck | None:
    """Ask for what is to be filled in, check, and ask again for what the check lacks.

    Args:
        folder: The project.
        campaign_name: Its campaign.
        file_names: Paths of its settings files, below the folder.
        unit_of_column: Name of each column of the logs -> the unit beside or below it, or empty.
        ask: Asks a person.
        say: Shows a line.

    Returns:
        The last check; None where a line was left open, so that nothing could be checked.
    """

    def ask_or_later(question: str) -> str:
        """The answer of the person; empty where the input has ended."""
        try:
            return ask(question)
        except EOFError:
            return ""

    project_check = None
    for _ in range(_MAX_ROUNDS):
        lines_to_fill_in = open_lines(folder, file_names)
        if not lines_to_fill_in and project_check is not None:
            break
        answered_texts = [
            _answered_line(line, unit_of_column, ask_or_later, say) for line in lines_to_fill_in
        ]
        _write_answers(folder, zip(lines_to_fill_in, answered_texts, strict=True))
        if open_lines(folder, file_names):
            return None
        project_check = check_project(folder, campaign_name)
        if _ask_about_settled_rows(folder, campaign_name, project_check, ask_or_later, say):
            project_check = check_project(folder, campaign_name)
        for rig_name, keys in project_check.missing_keys_by_rig.items():
            _add_to_rig(folder / f"config/rigs/{rig_name}.yaml", keys)
    return None if open_lines(folder, file_names) else project_check


def _ask_about_settled_rows(
    folder: Path, campaign_name: str, project_check: ProjectCheck, ask: Ask, say: Say
) -> bool:
    """Ask whether rows that look like settled readings are, and note it in the run sheet.

    Returns:
        Whether the run sheet has changed.
    """
    logs_folder = folder / "data/raw" / campaign_name
    sheet_file = logs_folder / "runs.csv"
    settled_log_names = {
        Path(log_report["file"]).relative_to(logs_folder).as_posix()
        for log_report in project_check.refused_reports
        if _most_frequent_rule(log_report) == "settled_readings"
    }
    if not settled_log_names or not sheet_file.is_file():
        return False
    # the sheet may be the laboratory's own
    text = normalised(sheet_file.read_bytes()).decode("utf-8")
    separator = max(",;\t", key=text.partition("\n")[0].count)
    cells_of_lines = list(csv.reader(io.StringIO(text), delimiter=separator)) or [[]]
    header, *rows = cells_of_lines
    if "log_kind" in header or "file" not in header:
        return False
    names = [dict(zip(header, row, strict=False)).get("file") for row in rows]
    if settled_log_names.isdisjoint(names):
        # its rows name logs by patterns
        return False
    say(f"{sheet_file.relative_to(folder)}, line 1: log_kind")
    counts = f"{len(settled_log_names)} of {len(project_check.log_reports)} logs"
    say(f"  {counts} have another slide-roll ratio in each row")
    answer = ask(
        "  Is each row a settled reading whose zero is removed? yes or no: (Enter: later) "
    )
    if answer.strip().casefold() not in ("yes", "y"):
        return False
    new_sheet = io.StringIO()
    writer = csv.writer(new_sheet, delimiter=separator, lineterminator="\n")
    writer.writerow([*header, "log_kind"])
    for row, name in zip(rows, names, strict=True):
        missing_cells = [""] * (len(header) - len(row))
        writer.writerow([*row, *missing_cells, "steps" if name in settled_log_names else ""])
    write_text(f"\ufeff{new_sheet.getvalue()}", sheet_file)
    return True


def _answered_line(line: OpenLine, unit_of_column: Mapping[str, str], ask: Ask, say: Say) -> str:
    """The text of a line with the answer of a person; as it is where the answer is empty."""
    say(f"{line.file}, line {line.number}: {line.key}")
    say(f"  {line.what_is_asked}")
    indent = line.text[: len(line.text) - len(line.text.lstrip())]
    while True:
        answer = ask(f"  {_prompt(line)} (Enter: later) ").strip()
        if not answer:
            return line.text
        try:
            value = _value_of_answer(line, answer, unit_of_column)
        except OilfilmError as mistake:
            say(f"  {mistake}")
            continue
        if isinstance(value, dict) and value.get("unit", "") is None:
            comment = f"{FILL_IN}: the unit of {value['name'][0]!r}, as the log does not say it"
            unit_line = OpenLine(
                line.file, line.number, indent + settings_line(line.key, value, comment)
            )
            return _answered_line(unit_line, unit_of_column, ask, say)
        return indent + settings_line(line.key, value)


def _prompt(line: OpenLine) -> str:
    """The question for the value of a line."""
    if line.column is not None:
        return "Unit:" if line.column["name"] else "Name of the column:"
    if line.key == "film_unjudged":
        return "Reason why points without a film thickness may be used:"
    if line.key == "zero":
        return "rolling_phases, opening_phase, standstill or already_removed:"
    if line.key.endswith("_m"):
        return "Length, as 38.5mm or 0.0385:"
    if isinstance(line.value, dict) and "youngs_modulus_pa" in line.value:
        return "Young's modulus in Pa and Poisson's ratio, as 206e9 0.3, or steel:"
    return "Value:"


def _value_of_answer(line: OpenLine, answer: str, unit_of_column: Mapping[str, str]) -> Any:
    """The answer as the value of a line.

    Raises:
        OilfilmError: The line cannot take it.
    """
    column = line.column
    if column is not None and column["name"]:
        _refuse_unit(line.key, answer)
        return {**column, "unit": answer}
    if column is not None:
        return _column_of_answer(line.key, answer, unit_of_column)
    if line.key == "film_unjudged":
        return {"accept": True, "reason": answer}
    if line.key in ("zero", "slide_roll_ratio"):
        _refuse_mistake(first_mistake({line.key: answer}, Semantics))
        return answer
    if line.key.endswith("_m"):
        length_m = typed_quantity(answer, "m", line.key)
        # a rig of steel, so that only the length can be a mistake
        rig_values = {
            "name": "-",
            "source": "-",
            "ball": _STEEL_ELASTICITY,
            "disc": _STEEL_ELASTICITY,
            line.key: length_m,
        }
        _refuse_mistake(first_mistake(rig_values, Rig))
        return length_m
    if isinstance(line.value, dict) and "youngs_modulus_pa" in line.value:
        return _elasticity_of_answer(answer)
    return _plain_value(answer)


def _plain_value(answer: str) -> Any:
    """The answer as YAML.

    Raises:
        OilfilmError: It is no YAML, or nothing.
    """
    try:
        value = yaml.safe_load(answer)
    except yaml.YAMLError:
        value = None
    if value is None:
        raise OilfilmError(f"found {answer!r}; expected a number or a word.")
    return value


def _refuse_mistake(mistake: str) -> None:
    """Raise a mistake, given as a sentence; an empty one is none."""
    if mistake:
        raise OilfilmError(mistake)


def _elasticity_of_answer(answer: str) -> dict[str, float]:
    """The elastic constants in an answer, as a group of keys.

    Raises:
        OilfilmError: It has no two numbers, or impossible ones.
    """
    if answer.casefold() in ("steel", "stahl", "acier", "acero", "acciaio"):
        return _STEEL_ELASTICITY
    try:
        modulus_pa, poisson_ratio = map(float, answer.replace(",", " ").split())
    except ValueError:
        raise OilfilmError(f"found {answer!r}; expected two numbers, as 206e9 0.3.") from None
    values = {"youngs_modulus_pa": modulus_pa, "poisson_ratio": poisson_ratio}
    _refuse_mistake(first_mistake(values, Elasticity))
    return values


def _column_of_answer(key: str, answer: str, unit_of_column: Mapping[str, str]) -> dict[str, Any]:
    """Name and unit of the column that an answer names, as a group of keys.

    The name is without the unit in its brackets, unless another column has the same name with
    another unit.

    Raises:
        OilfilmError: The logs have no such column, or several.
    """
    bare_name_of_column = {name: split_bracketed_unit(name)[0] for name in unit_of_column}
    matching_names = [name for name in unit_of_column if bare_name_of_column[name] == answer]
    if answer in unit_of_column:
        matching_names = [answer]
    if not matching_names:
        raise OilfilmError(
            f"no log has the column {answer!r}; there are {', '.join(unit_of_column)}."
        )
    if len(matching_names) > 1:
        raise OilfilmError(
            f"{answer!r} may be {' or '.join(matching_names)}. Give the name with its unit."
        )
    (column_name,) = matching_names
    bare_name = bare_name_of_column[column_name]
    if bare_name != column_name:
        is_only_one = list(bare_name_of_column.values()).count(bare_name) == 1
        return {"name": [bare_name if is_only_one else column_name]}
    if unit_of_column[column_name]:
        return {"name": [column_name]}
    _, unit = split_unit(column_name)
    is_known = unit != "" and VOCABULARY.is_convertible(key, unit)
    return {"name": [column_name], "unit": unit if is_known else None}


def _refuse_unit(key: str, unit: str) -> None:
    """Refuse a unit in which a quantity cannot be given.

    Raises:
        OilfilmError: It cannot.
    """
    usable_units = tuple(VOCABULARY.units_of_quantity[key])
    try:
        conversion(unit, usable_units).convert(np.array(1.0))
    except ValueError:
        expected = " or ".join(usable_units)
        raise OilfilmError(f"found {unit!r}; expected a unit such as {expected}.") from None


def _write_answers(folder: Path, answered_lines: Iterable[tuple[OpenLine, str]]) -> None:
    """Write the lines with their answers into the files, each file completely or not at all."""
    lines_by_file: dict[str, list[str]] = {}
    for line, answered_line in answered_lines:
        path = folder / line.file
        lines = lines_by_file.setdefault(line.file, path.read_text(encoding="utf-8").splitlines())
        lines[line.number - 1] = answered_line
    for file_name, lines in lines_by_file.items():
        write_text("\n".join([*lines, ""]), folder / file_name)


def _add_to_rig(rig_file: Path, keys: Sequence[str]) -> None:
    """Add keys to the file of a rig, to be filled in."""
    if not rig_file.is_file():
        # a rig that comes with oilfilm
        return
    lines = rig_file.read_text(encoding="utf-8").splitlines()
    for key in keys:
        line_indices = [
            index for index, line in enumerate(lines) if line.lstrip("# ").startswith(f"{key}:")
        ]
        meaning = Rig.model_fields[key].description
        line = settings_line(key, None, f"{FILL_IN}: m. {meaning} The logs need it.")
        if line_indices:
            lines[line_indices[0]] = line
        else:
            lines.append(line)
    write_text("\n".join([*lines, ""]), rig_file)
