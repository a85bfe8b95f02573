"""Questions for the lines that `oilfilm init` cannot fill in, and the check of its own result.

Decides: which answers a line of the settings takes.
"""

import csv
import io
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from oilfilm.api.log_check import check_files, verdict_lines
from oilfilm.base.atomic_write import write_text
from oilfilm.base.errors import OilfilmError
from oilfilm.base.units import conversion
from oilfilm.cli.arguments import quantity
from oilfilm.cli.settings_line import FILL_IN, settings_line
from oilfilm.logs.header import split_unit
from oilfilm.logs.ingest import read_bytes
from oilfilm.logs.meaning import stated_unit
from oilfilm.logs.raw_files import raw_files
from oilfilm.logs.sniff import VOCABULARY
from oilfilm.settings.campaign import Semantics
from oilfilm.settings.messages import first_mistake
from oilfilm.settings.resolve import resolve
from oilfilm.settings.rig import Elasticity, Rig

# Asks a person: takes the prompt and gives the answer, as `input`.
Ask = Callable[[str], str]
# Shows a line of text.
Say = Callable[[str], None]

# Rounds of questions: each round asks for what the check of the last one lacked.
_MOST_ROUNDS = 4
# Different reasons for refusals that are shown, each with the first of its logs.
_MOST_REASONS = 3
_STEEL = {"youngs_modulus_pa": 206e9, "poisson_ratio": 0.3}


@dataclass(frozen=True)
class OpenLine:
    """A line of a settings file whose value only the laboratory knows.

    Attributes:
        file: Path of the file below the project.
        number: Its number, from 1.
        text: Its text.
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
        """What the line has already."""
        return yaml.safe_load(self.text.strip())[self.key]

    @property
    def reason(self) -> str:
        """What is to be filled in, in words."""
        return self.text.partition(FILL_IN)[2].lstrip(": ")


@dataclass(frozen=True)
class Checked:
    """What `oilfilm check` says of a new project.

    Attributes:
        mistake: The mistake in the settings; empty where logs were judged.
        logs: The reports on the logs, as `check_files` gives them.
        rigs: Names of the rigs.
    """

    mistake: str
    logs: Sequence[dict[str, Any]] = ()
    rigs: Sequence[str] = ()

    @property
    def refused(self) -> list[dict[str, Any]]:
        """The reports on refused logs."""
        return [log for log in self.logs if log["verdict"] == "refused"]

    @property
    def missing_rig_keys(self) -> dict[str, list[str]]:
        """Lengths that the files of rigs lack, by rig."""
        missing: dict[str, dict[str, None]] = {}
        lengths = [key for key in Rig.model_fields if key.endswith("_m")]
        for log in self.refused:
            for refusal in log["refusals"]:
                if refusal["rule"] != "rig":
                    continue
                for rig in self.rigs:
                    if repr(rig) in refusal["reason"]:
                        keys = [key for key in lengths if key in refusal["reason"]]
                        missing.setdefault(rig, {}).update(dict.fromkeys(keys))
        return {rig: list(keys) for rig, keys in missing.items()}


def open_lines(folder: Path, files: Sequence[str]) -> list[OpenLine]:
    """The lines of a project's files that are to be filled in."""
    lines = []
    for file in files:
        text = (folder / file).read_text(encoding="utf-8-sig")
        for number, line in enumerate(text.splitlines(), start=1):
            if FILL_IN in line:
                lines.append(OpenLine(file, number, line))
    return lines


def check_project(folder: Path, campaign: str) -> Checked:
    """Check the logs of a new project as `oilfilm check` does."""
    raw = folder / "data/raw"
    try:
        settings = resolve(folder / "config", {})
        paths = [raw / campaign / name for name in raw_files(raw / campaign)]
        logs = {str(path): partial(read_bytes, path) for path in paths}
        return Checked("", check_files(logs, settings, raw), list(settings.rigs))
    except OilfilmError as mistake:
        return Checked(str(mistake))


def outcome_lines(checked: Checked, folder: Path) -> Iterator[str]:
    """Lines on what the check says: a mistake, or numbers and the reasons for refusals."""
    if checked.mistake:
        yield f"check: {checked.mistake}"
        return
    accepted = len(checked.logs) - len(checked.refused)
    yield f"check: {accepted} of {len(checked.logs)} logs are accepted"
    logs_by_reason: dict[str, list[dict[str, Any]]] = {}
    for log in checked.refused:
        logs_by_reason.setdefault(_first_reason(log), []).append(log)
    for logs in list(logs_by_reason.values())[:_MOST_REASONS]:
        for line in verdict_lines(logs[0]):
            yield f"  {line}".replace(f"{folder}/", "")
        if len(logs) > 1:
            yield f"  and {len(logs) - 1} more logs for this reason"
    if len(logs_by_reason) > _MOST_REASONS:
        yield f"  and {len(logs_by_reason) - _MOST_REASONS} other reasons: see `oilfilm check`"


def _first_reason(log: Mapping[str, Any]) -> str:
    """The rule that refuses most runs of a log."""
    rules = Counter(refusal["rule"] for refusal in log["refusals"])
    for run in log["runs"]:
        rules.update(failure["gate"] for failure in run["failed_gates"])
    return rules.most_common(1)[0][0] if rules else ""


def converse(
    folder: Path,
    campaign: str,
    files: Sequence[str],
    column_names: Sequence[str],
    ask: Ask,
    say: Say,
) -> Checked | None:
    """Ask for what is to be filled in, check, and ask again for what the check lacks.

    Args:
        folder: The project.
        campaign: Its campaign.
        files: Its settings files, below the folder.
        column_names: Names of the columns of the logs.
        ask: Asks a person.
        say: Shows a line.

    Returns:
        The last check; None where a line was left open, so that nothing could be checked.
    """
    checked = None
    try:
        for _ in range(_MOST_ROUNDS):
            lines = open_lines(folder, files)
            if not lines and checked is not None:
                break
            answers = [_filled_in(line, column_names, ask, say) for line in lines]
            _write_answers(folder, zip(lines, answers, strict=True))
            if open_lines(folder, files):
                return None
            checked = check_project(folder, campaign)
            if _settled_rows(folder, campaign, checked, ask, say):
                checked = check_project(folder, campaign)
            for rig, keys in checked.missing_rig_keys.items():
                _add_to_rig(folder / f"config/rigs/{rig}.yaml", keys)
    except EOFError:
        return None
    return None if open_lines(folder, files) else checked


def _settled_rows(folder: Path, campaign: str, checked: Checked, ask: Ask, say: Say) -> bool:
    """Ask whether rows that look like settled readings are, and note it in the run sheet.

    Returns:
        Whether the run sheet has changed.
    """
    raw = folder / "data/raw" / campaign
    sheet = raw / "runs.csv"
    refused = {
        Path(log["file"]).relative_to(raw).as_posix()
        for log in checked.refused
        if _first_reason(log) == "settled_readings"
    }
    if not refused or not sheet.is_file():
        return False
    text = sheet.read_text(encoding="utf-8-sig")
    separator = ";" if ";" in text.partition("\n")[0] else ","
    header, *rows = csv.reader(io.StringIO(text), delimiter=separator)
    if "log_kind" in header or "file" not in header:
        return False
    say(f"{sheet.relative_to(folder)}, line 1: log_kind")
    say(f"  {len(refused)} of {len(checked.logs)} logs have another slide-roll ratio in each row")
    answer = ask(
        "  Is each row a settled reading whose zero is removed? yes or no: (Enter: later) "
    )
    if answer.strip().casefold() not in ("yes", "y"):
        return False
    file_column = header.index("file")
    written = io.StringIO()
    writer = csv.writer(written, delimiter=separator, lineterminator="\n")
    writer.writerow([*header, "log_kind"])
    writer.writerows([*row, "steps" if row[file_column] in refused else ""] for row in rows)
    write_text(f"\ufeff{written.getvalue()}", sheet)
    return True


def _filled_in(line: OpenLine, column_names: Sequence[str], ask: Ask, say: Say) -> str:
    """A line with the answer of a person; as it is where the answer is empty."""
    say(f"{line.file}, line {line.number}: {line.key}")
    say(f"  {line.reason}")
    indent = line.text[: len(line.text) - len(line.text.lstrip())]
    while True:
        answer = ask(f"  {_prompt(line)} (Enter: later) ").strip()
        if not answer:
            return line.text
        try:
            value = _value_of_answer(line, answer, column_names)
        except OilfilmError as mistake:
            say(f"  {mistake}")
            continue
        if isinstance(value, dict) and value.get("unit", "") is None:
            comment = f"{FILL_IN}: the unit of {value['name'][0]!r}, as the log does not say it"
            unit_line = OpenLine(
                line.file, line.number, indent + settings_line(line.key, value, comment)
            )
            return _filled_in(unit_line, column_names, ask, say)
        return indent + settings_line(line.key, value)


def _prompt(line: OpenLine) -> str:
    """What a line expects."""
    if line.key == "film_unjudged":
        return "Reason why points without a film thickness may be used:"
    if line.key == "zero":
        return "rolling_phases, opening_phase, standstill or already_removed:"
    if line.key.endswith("_m"):
        return "Length, as 38.5mm or 0.0385:"
    if isinstance(line.value, dict) and "youngs_modulus_pa" in line.value:
        return "Young's modulus in Pa and Poisson's ratio, as 206e9 0.3, or steel:"
    if isinstance(line.value, dict) and line.value.get("name"):
        return "Unit:"
    if isinstance(line.value, dict) and "name" in line.value:
        return "Name of the column:"
    return "Value:"


def _value_of_answer(line: OpenLine, answer: str, column_names: Sequence[str]) -> Any:
    """The value of an answer.

    Raises:
        OilfilmError: The line cannot take it.
    """
    if line.key == "film_unjudged":
        return {"accept": True, "reason": answer}
    if line.key == "zero":
        _refuse_mistake(first_mistake({"zero": answer}, Semantics))
        return answer
    if line.key.endswith("_m"):
        length_m = quantity(answer, "m", line.key)
        values = {"name": "-", "source": "-", "ball": _STEEL, "disc": _STEEL, line.key: length_m}
        _refuse_mistake(first_mistake(values, Rig))
        return length_m
    if isinstance(line.value, dict) and "youngs_modulus_pa" in line.value:
        return _elasticity_of_answer(answer)
    if isinstance(line.value, dict) and line.value.get("name"):
        _check_unit(line.key, answer)
        return {**line.value, "unit": answer}
    if isinstance(line.value, dict) and "name" in line.value:
        return _column_of_answer(line.key, answer, column_names)
    return yaml.safe_load(answer)


def _refuse_mistake(mistake: str) -> None:
    """Refuse a mistake; an empty one is none."""
    if mistake:
        raise OilfilmError(mistake)


def _elasticity_of_answer(answer: str) -> dict[str, float]:
    """Elastic constants of an answer.

    Raises:
        OilfilmError: It has no two numbers, or impossible ones.
    """
    if answer.casefold() in ("steel", "stahl", "acier", "acero", "acciaio"):
        return _STEEL
    try:
        modulus_pa, poisson_ratio = map(float, answer.replace(",", " ").split())
    except ValueError:
        raise OilfilmError(f"found {answer!r}; expected two numbers, as 206e9 0.3.") from None
    values = {"youngs_modulus_pa": modulus_pa, "poisson_ratio": poisson_ratio}
    _refuse_mistake(first_mistake(values, Elasticity))
    return values


def _column_of_answer(key: str, answer: str, column_names: Sequence[str]) -> dict[str, Any]:
    """Name and unit of a column.

    Raises:
        OilfilmError: The logs have no such column.
    """
    matching = [name for name in column_names if answer in (name, split_unit(name)[0])]
    if not matching:
        raise OilfilmError(
            f"no log has the column {answer!r}; there are {', '.join(column_names)}."
        )
    name, unit = split_unit(matching[0])
    if unit:
        return {"name": [name]}
    _, unit = stated_unit(name)
    is_known = unit != "" and VOCABULARY.is_convertible(key, unit)
    return {"name": [name], "unit": unit if is_known else None}


def _check_unit(key: str, unit: str) -> None:
    """Check that a quantity can be given in a unit.

    Raises:
        OilfilmError: It cannot.
    """
    units = tuple(VOCABULARY.quantities[key])
    try:
        conversion(unit, units).convert(np.array(1.0))
    except ValueError:
        expected = " or ".join(units)
        raise OilfilmError(f"found {unit!r}; expected a unit such as {expected}.") from None


def _write_answers(folder: Path, answers: Iterable[tuple[OpenLine, str]]) -> None:
    """Write the answers into the files, each file completely or not at all."""
    lines_by_file: dict[str, list[str]] = {}
    for line, answer in answers:
        path = folder / line.file
        lines = lines_by_file.setdefault(line.file, path.read_text(encoding="utf-8").splitlines())
        lines[line.number - 1] = answer
    for file, lines in lines_by_file.items():
        write_text("\n".join([*lines, ""]), folder / file)


def _add_to_rig(path: Path, keys: Sequence[str]) -> None:
    """Add keys to the file of a rig, to be filled in."""
    if not path.is_file():
        # a rig that comes with oilfilm
        return
    lines = path.read_text(encoding="utf-8").splitlines()
    for key in keys:
        numbers_of_lines = [
            number for number, line in enumerate(lines) if line.lstrip("# ").startswith(f"{key}:")
        ]
        meaning = Rig.model_fields[key].description
        line = settings_line(key, None, f"{FILL_IN}: m. {meaning} The logs need it.")
        if numbers_of_lines:
            lines[numbers_of_lines[0]] = line
        else:
            lines.append(line)
    write_text("\n".join([*lines, ""]), path)
