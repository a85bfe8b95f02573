"""The command `oilfilm init`: a project folder whose settings contain guesses from the logs.

Decides: the files that `oilfilm init` writes.
"""

import argparse
import re
import shutil
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain
from pathlib import Path
from shlex import quote
from typing import NamedTuple

import pandas as pd
from jinja2 import Environment, PackageLoader, StrictUndefined

from oilfilm.base.atomic_write import atomic_folder
from oilfilm.base.errors import OilfilmError, printable
from oilfilm.base.home import CONFIG, HOME
from oilfilm.base.units import conversion
from oilfilm.cli.dialogue import Checked, check_project, converse, open_lines, outcome_lines
from oilfilm.cli.settings_line import FILL_IN, settings_line
from oilfilm.cli.sliding_rigs import does_not_roll
from oilfilm.curation.traction_rig import ZERO_SOURCES_BEST_FIRST, zero_source
from oilfilm.logs.base import SET_POINT_KEYS
from oilfilm.logs.ingest import read_bytes
from oilfilm.logs.meaning import concepts_in, meaning_of, stated_unit
from oilfilm.logs.raw_files import find_sheet, is_sheet, raw_files, unfit_name
from oilfilm.logs.sniff import (
    VOCABULARY,
    Findings,
    SniffedLog,
    rows_of_sheet,
    set_points,
    shipped_names,
    sniff,
)
from oilfilm.settings.messages import load
from oilfilm.settings.resolve import resolve, safe_name
from oilfilm.settings.rig import Rig

# Pages that messages and settings name, and the profile of snakemake.
_COPIED_FILES = (
    "data/raw/README.md",
    "docs/reference/configuration.md",
    "profiles/default/config.yaml",
)
# Marks a value that only the film thickness needs. The run does not stop without it.
FOR_FILM = "# for the film"
# Why a source of the zero of the force suits some runs.
_REASONS_FOR_ZERO = {
    "rolling_phases": "guess: {which} begin and end with pure rolling",
    "opening_phase": "guess: {which} begin with pure rolling and do not end with it",
    "standstill": "guess: {which} stand still before the first level and have no pure rolling; is "
    "that the sensor's zero?",
    None: f"{FILL_IN}: {{which}} have neither pure rolling nor standstill; already_removed if the "
    "logger took the zero of the force off",
}


class Line(NamedTuple):
    """A line of settings."""

    key: str
    value: object
    comment: str


@dataclass(frozen=True)
class NewProject:
    """A project folder that was written.

    Attributes:
        campaign: Name of the campaign.
        findings: Guesses from the logs.
        no_logs: Named files that are no logs; they are not copied.
        texts: The texts of the new files by their path below the folder, without logs and copies.
    """

    campaign: str
    findings: Findings
    no_logs: Sequence[SniffedLog]
    texts: Mapping[str, str]

    @property
    def column_names(self) -> list[str]:
        """Names of the columns of all logs."""
        return list(dict.fromkeys(chain.from_iterable(log.names for log in self.findings.logs)))

    @property
    def to_fill_in(self) -> list[tuple[str, int, str]]:
        """The lines that only the laboratory can fill in: file, line number, text."""
        marked_lines = []
        for file, text in self.texts.items():
            for number, line in enumerate(text.splitlines(), start=1):
                if FILL_IN in line:
                    marked_lines.append((file, number, line))
        return marked_lines


def run(options: argparse.Namespace) -> int:
    """Write the folder, report the guesses and the lines to fill in; 1 if a log cannot be read."""
    project = make_project(options.folder, options.logs)
    _print(_opening_lines(project, str(options.folder)))
    if is_terminal() and not options.no_questions:
        checked = converse(
            options.folder,
            project.campaign,
            list(project.texts),
            project.column_names,
            input,
            print,
        )
    else:
        checked = None
        if not project.to_fill_in:
            checked = check_project(options.folder, project.campaign)
    _print(_closing_lines(project, options.folder, checked))
    all_refused = checked is not None and len(checked.refused) == len(checked.logs)
    return int(all_refused or any(log.problem for log in project.findings.logs))


def is_terminal() -> bool:
    """Whether a person can read and answer questions."""
    return sys.stdin.isatty() and sys.stdout.isatty()


def _print(lines: Iterable[str]) -> None:
    print("\n".join(map(printable, lines)))


def _opening_lines(project: NewProject, folder: str) -> Iterator[str]:
    yield f"{folder}: a project with the campaign {project.campaign}"
    for line in lines_on_forms(project.findings):
        yield f"  {line}"
    for log in project.no_logs:
        yield f"  {log.file} is no log and was not copied: {log.problem}"
    for quantity, names in project.findings.column_names_of_quantity.items():
        yield f"  {quantity}: {', '.join(names)} (guess)"
    yield f"Written: {', '.join(project.texts)}"
    yield from lines_on_abilities(project.findings)


def _closing_lines(project: NewProject, folder: Path, checked: Checked | None) -> Iterator[str]:
    """What is left to fill in, what the check says, and the next commands."""
    lines_still_open = open_lines(folder, list(project.texts))
    if lines_still_open:
        yield f"To fill in, because only you can know it: {len(lines_still_open)}"
        for line in lines_still_open:
            yield f"  {line.file}, line {line.number}: {' '.join(line.text.split())}"
    files_for_film = [file for file, text in project.texts.items() if FOR_FILM in text]
    if files_for_film:
        yield f"For pressure and film thickness, fill in as well: {', '.join(files_for_film)}"
    if checked is not None:
        yield from outcome_lines(checked, folder)
    yield f"Then: cd {quote(str(folder))}; oilfilm check data/raw/{project.campaign}; oilfilm run"


def lines_on_abilities(findings: Findings) -> Iterator[str]:
    """What the logs can give and what they cannot give, as far as their columns show it."""
    unnamed_quantities = [quantity.replace("_", " ") for quantity in findings.names_to_choose_from]
    if unnamed_quantities:
        listed = ", ".join(unnamed_quantities)
        yield f"The logs give no curve until these columns are named: {listed}."
    else:
        yield "The logs can give traction coefficients over slip, with speed and temperature."
    runs = list(findings.runs)
    what_is_missing = []
    if runs and all(run.is_settled for run in runs):
        what_is_missing.append("whether a reading was steady (each row is one settled reading)")
    if None in findings.run_count_of_zero_source:
        what_is_missing.append("the zero of the force (neither pure rolling nor standstill)")
    if findings.needs_contact:
        what_is_missing.append("the pressure, without the ball's radius and the moduli")
    what_is_missing.append("the film thickness, without the files of oil and rig")
    yield f"They cannot give {'; '.join(what_is_missing)}."


def make_project(folder: Path, paths: Sequence[Path]) -> NewProject:
    """Write a project folder and copy logs into it; no existing file is changed.

    Args:
        folder: The folder, with the name of the campaign. It must not exist, or be empty.
        paths: Logs, and folders of logs.

    Raises:
        OilfilmError: The folder is not empty, its name cannot be that of a campaign, or no log can
            be read.
    """
    name = safe_name(folder.resolve().name, folder)
    if folder.exists() and not (folder.is_dir() and not any(folder.iterdir())):
        raise OilfilmError(
            f"{folder}: exists already and is not empty. Name a new or an empty folder."
        )
    logs, sheets = _logs_and_sheets(paths)
    findings, no_logs = _findings_and_no_logs(logs)
    raw = f"data/raw/{name}"
    texts = _texts(name, findings)
    if not sheets:
        texts[f"{raw}/runs.csv"] = run_sheet(findings)
    sources = {f"{raw}/{log.file}": logs[log.file] for log in findings.logs}
    for sheet in sheets:
        sources[f"{raw}/{sheet.name}"] = sheet
    for file in _COPIED_FILES:
        sources[file] = HOME / file
    # beside the settings, where editors find them
    for schema in sorted((HOME / "workflow/schemas").glob("*.schema.json")):
        sources[f"config/schemas/{schema.name}"] = schema
    _write(folder, texts, sources)
    return NewProject(name, findings, no_logs, texts)


def _write(folder: Path, texts: Mapping[str, str], sources: Mapping[str, Path]) -> None:
    """Write texts and copies into a new folder, all of them or nothing.

    Raises:
        OilfilmError: They cannot be written, for example because the disk is full.
    """
    # an empty folder that is there already may be the current one: it keeps its place
    target = folder.resolve()
    new_folder = target / "project" if target.exists() else target
    try:
        with atomic_folder(new_folder) as temporary:
            for file, text in texts.items():
                (temporary / file).parent.mkdir(parents=True, exist_ok=True)
                # a byte order mark, so that spreadsheets read umlauts
                encoding = "utf-8-sig" if file.endswith(".csv") else "utf-8"
                (temporary / file).write_text(text, encoding=encoding, newline="\n")
            for file, source in sources.items():
                (temporary / file).parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(source, temporary / file)
        if new_folder != target:
            for entry in new_folder.iterdir():
                entry.rename(target / entry.name)
            new_folder.rmdir()
    except OSError as error:
        raise OilfilmError(
            f"{folder}: cannot be written ({error.strerror}). Nothing was left behind: repeat the "
            "command where there is room and the right to write."
        ) from error


def _findings_and_no_logs(logs: dict[str, Path]) -> tuple[Findings, list[SniffedLog]]:
    """Guesses from the logs, and the files that are no logs.

    Raises:
        OilfilmError: No file can be understood as a log.
    """
    settings = resolve(CONFIG, {"campaign": "etm-slim"})
    settings_by_source = {
        source: settings.with_changes({"campaign": {"semantics": {"zero": source}}})
        for source in ZERO_SOURCES_BEST_FIRST
    }
    source_of_zero = partial(zero_source, settings_by_source=settings_by_source)
    sniffed = [sniff(file, read_bytes(path), source_of_zero) for file, path in logs.items()]
    findings = Findings([log for log in sniffed if log.is_log])
    _refuse_sliding_rigs(sniffed, logs)
    if not findings.logs_with_columns:
        problems = "\n".join(f"  {log.file}: {log.problem}" for log in sniffed)
        raise OilfilmError(
            "Nothing was written, because nothing can be understood as a log of a traction rig:\n"
            f"{problems}\n`oilfilm fit` takes a table of traction coefficients. data/raw/README.md "
            "of oilfilm says what logs need."
        )
    return findings, [log for log in sniffed if not log.is_log]


def _refuse_sliding_rigs(sniffed: Sequence[SniffedLog], logs: Mapping[str, Path]) -> None:
    """Refuse logs of which none is of a rig that rolls.

    Raises:
        OilfilmError: Every file is of a rig that does not roll.
    """
    reasons = {log.file: does_not_roll(log, read_bytes(logs[log.file])) for log in sniffed}
    if reasons and all(reasons.values()):
        file, reason = next(iter(reasons.items()))
        raise OilfilmError(f"{file}: {reason} Nothing was written.")


def _logs_and_sheets(paths: Iterable[Path]) -> tuple[dict[str, Path], list[Path]]:
    """The logs by their names in the project, and the run sheet if there is one.

    Raises:
        OilfilmError: A name cannot be used, two logs have one name, or there are two run sheets.
    """
    logs: dict[str, Path] = {}
    sheets: list[Path] = []
    for path in paths:
        logs_of_path: dict[str, Path] = {}
        if path.is_dir():
            logs_of_path = {name: path / name for name in raw_files(path)}
            sheet = find_sheet(path)
            if sheet:
                sheets.append(sheet)
        elif is_sheet(path, path.parent):
            sheets.append(path)
        else:
            logs_of_path = {path.name: path}
        for file, log in logs_of_path.items():
            fault = unfit_name(file, log)
            if fault:
                raise OilfilmError(fault)
            first_log = logs.setdefault(file, log)
            if first_log.resolve() != log.resolve():
                raise OilfilmError(
                    f"{log}: has the name of {first_log}. Rename one, or put both into one folder "
                    "with subfolders and name that folder."
                )
    if len(sheets) > 1:
        raise OilfilmError(f"{sheets[1]}: is a second run sheet beside {sheets[0]}. Leave one out.")
    return logs, sheets


def _texts(campaign: str, findings: Findings) -> dict[str, str]:
    """The texts of Snakefile and settings with the guesses, by their path below the folder."""
    files = {
        "Snakefile": template("Snakefile"),
        "config/config.yaml": template("config.yaml.jinja", name=campaign),
        f"config/campaigns/{campaign}.yaml": campaign_yaml(campaign, findings),
    }
    for rig in findings.rig_names:
        if rig not in shipped_names("rigs").values():
            text = template(
                "rig.yaml.jinja", name=rig, findings=findings, needs_radii=_needs_radii(findings)
            )
            files[f"config/rigs/{rig}.yaml"] = text
    for oil in findings.labels_of_oil:
        if oil not in shipped_names("oils").values():
            files[f"config/oils/{oil}.yaml"] = oil_yaml(oil, findings)
    return files


def _needs_radii(findings: Findings) -> bool:
    """Whether a speed is, or may be, that of a spindle: then the radii of the tracks are needed."""
    if findings.needs_radii:
        return True
    speeds = {"ball_speed", "disc_speed"}
    names: Iterable[str] = ()
    if speeds & findings.names_to_choose_from.keys():
        names = chain.from_iterable(log.names for log in findings.logs_with_columns)
    return any(_unit_as(name, "ball_speed") == "rpm" for name in names)


def _unit_as(name: str, quantity: str) -> str:
    """The unit into which that in a column's name converts for a quantity; empty without one."""
    _, unit = stated_unit(name)
    if not unit or not VOCABULARY.is_convertible(quantity, unit):
        return ""
    return conversion(unit, tuple(VOCABULARY.quantities[quantity])).unit


# ---------------------------------------------------------------- the files


def template(file: str, /, **values: object) -> str:
    """The text of a file from its template."""
    environment = Environment(
        loader=PackageLoader("oilfilm.cli"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # noqa: S701 - YAML, whose values and comments `settings_line` writes
    )
    return environment.get_template(file).render(line=settings_line, **values)


def campaign_yaml(name: str, findings: Findings) -> str:
    """`config/campaigns/<name>.yaml`."""
    shipped_oils = shipped_names("oils").values()
    own_oils = [oil for oil in findings.labels_of_oil if oil not in shipped_oils]
    aliases = {}
    for oil, labels in findings.labels_of_oil.items():
        if labels and labels != [oil]:
            aliases[oil] = labels
    return template(
        "campaign.yaml.jinja",
        name=name,
        findings=findings,
        # names come from logs: a line end among them would end the comment
        summary=[printable(line) for line in lines_on_forms(findings)],
        shipped=[oil for oil in findings.labels_of_oil if oil in shipped_oils],
        own=own_oils,
        unnamed="guess: no log names its oil; " if findings.labels_of_oil == {"my-oil": []} else "",
        aliases=aliases,
        no_film=bool(own_oils) or not all(_has_known_contact(rig) for rig in findings.rig_names),
        groups={
            "columns": list(_column_lines(findings)),
            "header": [
                Line(key, names, "guess") for key, names in findings.header_names_of_key.items()
            ],
            "semantics": list(_semantics_lines(findings)),
        },
    )


def _has_known_contact(rig: str) -> bool:
    """Whether a rig comes with oilfilm and its contact was recorded."""
    if rig not in shipped_names("rigs").values():
        return False
    return load(CONFIG / f"rigs/{rig}.yaml", Rig).contact() is not None


def lines_on_forms(findings: Findings) -> Iterator[str]:
    """The forms of the logs with their numbers, one line per form; then the unreadable logs."""
    forms = Counter((log.format_name, log.form) for log in findings.logs).most_common()
    for (name, form), count in forms:
        attributes = [name]
        if form.encoding:
            attributes.append(form.encoding)
        if form.delimiter:
            attributes += [f"delimiter {form.delimiter}", f"decimal {form.decimal_mark}"]
        yield f"{count} {'log' if count == 1 else 'logs'}: {', '.join(attributes)}"
    for log in findings.logs:
        if log.problem:
            yield f"{log.file} could not be read: {log.problem}"


def _column_lines(findings: Findings) -> Iterator[Line]:
    """Lines of the group `columns`."""
    for quantity in VOCABULARY.quantities:
        names = findings.column_names_of_quantity.get(quantity)
        unit, unit_is_unknown = findings.unit_for_campaign_file(quantity)
        if quantity in findings.names_to_choose_from:
            names_left = [
                _offered_name(name, quantity) for name in findings.names_to_choose_from[quantity]
            ]
            choice = ", ".join(names_left) or "no column is left"
            comment = f"{FILL_IN}: the name of the column; perhaps {choice}"
            yield Line(quantity, {"name": names}, comment)
        elif names and _question(findings, quantity):
            # a name that leaves its meaning open is confirmed, never taken
            question = _question(findings, quantity)
            comment = f"{FILL_IN}: the name of the column; perhaps {names[0]}: {question}"
            yield Line(quantity, {"name": None}, comment)
        elif names and unit_is_unknown:
            units = " or ".join(VOCABULARY.quantities[quantity])
            comment = f"{FILL_IN}: the unit, such as {units}; the logs do not say it"
            yield Line(quantity, {"name": names, "unit": None}, comment)
        elif names and unit:
            yield Line(quantity, {"name": names, "unit": unit}, "guess")
        elif names:
            yield Line(quantity, {"name": names}, "guess")


def _question(findings: Findings, quantity: str) -> str:
    """What names and units of a quantity's columns leave open; empty where it is nothing."""
    for log in findings.logs_with_columns:
        for name, unit in log.candidates.get(quantity, ()):
            meaning = meaning_of(name, unit)
            if meaning is not None and meaning.question:
                return meaning.question
    return ""


def _offered_name(name: str, quantity: str) -> str:
    """A column to choose; a torque is offered as a torque, never as a force."""
    if quantity == "traction_force" and "torque" in concepts_in(name):
        return f"{name} (a torque: the rig file needs torque_arm_m)"
    return name


def _semantics_lines(findings: Findings) -> Iterator[Line]:
    """Lines of the group `semantics`."""
    if findings.run_count_of_zero_source:
        ((source, count),) = findings.run_count_of_zero_source.most_common(1)
        total = findings.run_count_of_zero_source.total()
        which_runs = "the runs" if count == total else f"{count} of {total} runs"
        reason = _REASONS_FOR_ZERO[source].format(which=which_runs)
        if findings.needs_radii and source in ("rolling_phases", "opening_phase"):
            reason += "; true where the radii of the tracks make the beginning pure rolling"
        yield Line("zero", source, reason)
    if findings.slip_is_logged:
        names = findings.column_names_of_quantity.get("slide_roll_ratio", ["slide_roll_ratio"])
        meanings = [meaning_of(name) for name in names]
        if all(meaning is not None and meaning.definition == "over_mean" for meaning in meanings):
            yield Line("slide_roll_ratio", "over_mean", "as the name says")
        else:
            comment = f"{FILL_IN}: over_mean, over_sum or over_faster: the speed that divides it"
            yield Line("slide_roll_ratio", None, comment)


def oil_yaml(oil: str, findings: Findings) -> str:
    """`config/oils/<id>.yaml`: the shipped template without its numbers."""
    label = next(iter(findings.labels_of_oil[oil]), oil)
    values = {
        "id": oil,
        "name": label,
        "display_name": label,
        "note": "not documented yet",
        "source": "not documented yet",
    }

    def with_own_value(line: re.Match[str]) -> str:
        key, example = line.groups()
        if key in ("stand_in", "model"):
            return line[0]
        if key in values:
            return settings_line(key, values[key])
        return settings_line(key, None, f"{FOR_FILM}: as {' '.join(example.split())}")

    text = (CONFIG / "oils/template.yaml").read_text(encoding="utf-8")
    keys = re.sub(r"(?m)^( *\w+): +(.+)$", with_own_value, text[text.index("id:") :])
    return (
        "# yaml-language-server: $schema=../schemas/oil.schema.json\n"
        "# Read when the campaign file lists the oil under `oils`: fill in all of it before.\n"
        f"{keys}"
    )


def run_sheet(findings: Findings) -> str:
    """`data/raw/<name>/runs.csv`: what the headers of the logs do not contain."""
    rows = pd.DataFrame(chain.from_iterable(_rows_of_log(log, findings) for log in findings.logs))
    used = [name for name in ("run", "oil", "log_kind", *SET_POINT_KEYS) if name in rows]
    columns = ["file", *used, "exclude", "remarks"]
    return rows.reindex(columns=columns).to_csv(
        index=False,
        sep=";" if findings.uses_decimal_comma else ",",
        decimal="," if findings.uses_decimal_comma else ".",
        float_format="%g",
        lineterminator="\n",
    )


def _rows_of_log(log: SniffedLog, findings: Findings) -> Iterator[dict[str, object]]:
    """Rows of the run sheet for one log."""
    for run in rows_of_sheet(log):
        row: dict[str, object] = {"file": log.file}
        if run.name_in_file:
            row["run"] = run.name_in_file
        remarks = []
        medians = set_points(run)
        if medians:
            row |= medians
            remarks.append("guess: set points are medians of the log")
        if findings.lacks_oil_in_some_logs:
            row["oil"] = ""
            if not run.oil_name:
                remarks.append("FILL IN: the oil")
        if run.is_settled and not run.log_kind:
            # a table of mu does not say that its rows are settled readings
            row["log_kind"] = "steps"
        row["remarks"] = ". ".join(remarks)
        yield row
