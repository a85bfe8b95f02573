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
from oilfilm.cli.dialogue import (
    ProjectCheck,
    ask_and_check,
    check_project,
    open_lines,
    outcome_lines,
)
from oilfilm.cli.settings_line import FILL_IN, settings_line
from oilfilm.cli.sliding_rigs import why_not_rolling
from oilfilm.curation.traction_rig import ZERO_SOURCES_BEST_FIRST, find_zero_source
from oilfilm.logs.base import SET_POINT_KEYS
from oilfilm.logs.ingest import read_bytes
from oilfilm.logs.meaning import concepts_in, meaning_of, split_unit
from oilfilm.logs.raw_files import find_run_sheet, is_run_sheet_of, name_fault, raw_log_names
from oilfilm.logs.sniff import (
    VOCABULARY,
    Findings,
    SniffedLog,
    measured_set_points,
    runs_for_run_sheet,
    shipped_names,
    sniff,
)
from oilfilm.settings.messages import load
from oilfilm.settings.resolve import TEMPLATE_NAME, resolve, safe_name
from oilfilm.settings.rig import Rig

# Pages that messages and settings name, and the profile of snakemake.
_COPIED_FILES = (
    "data/raw/README.md",
    "docs/reference/configuration.md",
    "profiles/default/config.yaml",
)
# Marks a value that only the film thickness needs. The run does not stop without it.
FOR_FILM = "# for the film"
# The remark in the run sheet on a run whose log names no oil, where other logs name theirs.
OIL_TO_FILL_IN = "FILL IN: the oil"
# The comment on a source of the zero of the force: why it suits some runs.
_COMMENT_BY_ZERO_SOURCE = {
    "rolling_phases": "guess: {which} begin and end with pure rolling",
    "opening_phase": "guess: {which} begin with pure rolling and do not end with it",
    "standstill": "guess: {which} stand still before the first level and have no pure rolling; is "
    "that the sensor's zero?",
    None: f"{FILL_IN}: {{which}} have neither pure rolling nor standstill; already_removed if the "
    "logger took the zero of the force off",
}


class DraftLine(NamedTuple):
    """A line of settings before it is written: key, value and comment."""

    key: str
    value: object
    comment: str


@dataclass(frozen=True)
class NewProject:
    """A project folder that was written.

    Attributes:
        campaign_name: Name of the campaign.
        findings: Guesses from the logs.
        other_files: Files that the user named and that are no logs; they are not copied.
        text_by_path: The texts of the new files by their path below the folder, without logs and
            copies.
    """

    campaign_name: str
    findings: Findings
    other_files: Sequence[SniffedLog]
    text_by_path: Mapping[str, str]

    @property
    def unit_of_column(self) -> dict[str, str]:
        """Name of each column -> the unit beside or below it; empty where some log has none."""
        unit_of_column: dict[str, str] = {}
        for log in self.findings.logs:
            for name, unit in log.unit_of_column.items():
                # logs that disagree are read by the unit that the campaign file states
                if unit_of_column.setdefault(name, unit) != unit:
                    unit_of_column[name] = ""
        return unit_of_column

    @property
    def lines_to_fill_in(self) -> list[tuple[str, int, str]]:
        """The lines that only the laboratory can fill in: file, line number, text."""
        marked_lines = []
        for file_name, text in self.text_by_path.items():
            for number, line in enumerate(text.splitlines(), start=1):
                if FILL_IN in line:
                    marked_lines.append((file_name, number, line))
        return marked_lines


def run(options: argparse.Namespace) -> int:
    """Write the folder, report the guesses and the lines to fill in.

    Returns:
        1 if a log cannot be read, or if the check refuses all logs; else 0.
    """
    project = make_project(options.folder, options.logs)
    _print(_opening_lines(project, str(options.folder)))
    if is_terminal() and not options.no_questions:
        project_check = ask_and_check(
            options.folder,
            project.campaign_name,
            list(project.text_by_path),
            project.unit_of_column,
            input,
            print,
        )
    else:
        project_check = None
        if not project.lines_to_fill_in:
            project_check = check_project(options.folder, project.campaign_name)
    _print(_closing_lines(project, options.folder, project_check))
    all_refused = False
    if project_check is not None:
        all_refused = len(project_check.refused_reports) == len(project_check.log_reports)
    return int(all_refused or any(log.problem for log in project.findings.logs))


def is_terminal() -> bool:
    """Whether a person can read and answer questions."""
    return sys.stdin.isatty() and sys.stdout.isatty()


def _print(lines: Iterable[str]) -> None:
    print("\n".join(map(printable, lines)))


def _opening_lines(project: NewProject, folder: str) -> Iterator[str]:
    """What was understood of the logs, and what was written."""
    yield f"{folder}: a project with the campaign {project.campaign_name}"
    for line in lines_on_forms(project.findings):
        yield f"  {line}"
    for log in project.other_files:
        yield f"  {log.file} is no log and was not copied: {log.problem}"
    for quantity, names in project.findings.column_names_of_quantity.items():
        yield f"  {quantity}: {', '.join(names)} (guess)"
    yield f"Written: {', '.join(project.text_by_path)}"
    yield from lines_on_abilities(project.findings)


def _closing_lines(
    project: NewProject, folder: Path, project_check: ProjectCheck | None
) -> Iterator[str]:
    """What is left to fill in, what the check says, and the next commands."""
    lines_still_open = open_lines(folder, list(project.text_by_path))
    if lines_still_open:
        yield f"To fill in, because only you can know it: {len(lines_still_open)}"
        for line in lines_still_open:
            yield f"  {line.file}, line {line.number}: {' '.join(line.text.split())}"
    sheet_file = f"data/raw/{project.campaign_name}/runs.csv"
    run_count_without_oil = project.text_by_path.get(sheet_file, "").count(OIL_TO_FILL_IN)
    if run_count_without_oil:
        noun = "run" if run_count_without_oil == 1 else "runs"
        yield f"{sheet_file}: fill in the column oil of {run_count_without_oil} {noun}"
    files_for_film = [path for path, text in project.text_by_path.items() if FOR_FILM in text]
    if files_for_film:
        yield f"For pressure and film thickness, fill in as well: {', '.join(files_for_film)}"
    if project_check is not None:
        yield from outcome_lines(project_check, folder)
    check_command = f"oilfilm check data/raw/{project.campaign_name}"
    yield f"Then: cd {quote(str(folder))}; {check_command}; oilfilm run"


def lines_on_abilities(findings: Findings) -> Iterator[str]:
    """What the logs can give and what they cannot give, by their columns."""
    unnamed_quantities = [quantity.replace("_", " ") for quantity in findings.names_to_choose_from]
    if unnamed_quantities:
        quantities_in_words = ", ".join(unnamed_quantities)
        yield f"The logs give no curve until these columns are named: {quantities_in_words}."
    else:
        yield "The logs can give traction coefficients over slip, with speed and temperature."
    runs = list(findings.runs)
    if runs and all(run.is_settled for run in runs):
        yield "They do not show whether a reading was steady: each row is one settled reading."
    what_is_missing = []
    count_without_zero = findings.run_count_of_zero_source[None]
    if count_without_zero:
        run_count = findings.run_count_of_zero_source.total()
        of_runs = "" if count_without_zero == run_count else f" of {count_without_zero} runs"
        what_is_missing.append(
            f"the zero of the force{of_runs} (neither pure rolling nor standstill)"
        )
    if findings.needs_contact:
        what_is_missing.append("the pressure, without the ball's radius and the moduli")
    if _film_is_unknown(findings):
        what_is_missing.append("the film thickness, without the files of oil and rig")
    if what_is_missing:
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
    campaign_name = safe_name(folder.resolve().name, folder)
    if campaign_name == TEMPLATE_NAME:
        raise OilfilmError(
            f"{folder}: a file called {TEMPLATE_NAME}.yaml is a pattern and no campaign. Choose "
            "another name for the folder."
        )
    if folder.exists() and not (folder.is_dir() and not any(folder.iterdir())):
        raise OilfilmError(
            f"{folder}: exists already and is not empty. Name a new or an empty folder."
        )
    path_by_log_name, sheet_files = _logs_and_sheets(paths)
    findings, other_files = _findings_and_other_files(path_by_log_name)
    raw_path = f"data/raw/{campaign_name}"
    text_by_path = _text_by_path(campaign_name, findings)
    if not sheet_files:
        text_by_path[f"{raw_path}/runs.csv"] = run_sheet_text(findings)
    source_by_path = {f"{raw_path}/{log.file}": path_by_log_name[log.file] for log in findings.logs}
    for sheet_file in sheet_files:
        source_by_path[f"{raw_path}/{sheet_file.name}"] = sheet_file
    for file_name in _COPIED_FILES:
        source_by_path[file_name] = HOME / file_name
    # beside the settings, where editors find them
    for schema_file in sorted((HOME / "workflow/schemas").glob("*.schema.json")):
        source_by_path[f"config/schemas/{schema_file.name}"] = schema_file
    _write_project(folder, text_by_path, source_by_path)
    return NewProject(campaign_name, findings, other_files, text_by_path)


def _write_project(
    folder: Path, text_by_path: Mapping[str, str], source_by_path: Mapping[str, Path]
) -> None:
    """Write texts and copies into a new folder, all of them or nothing.

    Args:
        folder: The folder.
        text_by_path: Text of each new file, by its path below the folder.
        source_by_path: File of which a copy is made, by the path of the copy below the folder.

    Raises:
        OilfilmError: They cannot be written, for example because the disk is full.
    """
    # an empty folder that is there already may be the current one: it keeps its place
    target_folder = folder.resolve()
    new_folder = target_folder / "project" if target_folder.exists() else target_folder
    try:
        with atomic_folder(new_folder) as temporary_folder:
            for file_name, text in text_by_path.items():
                (temporary_folder / file_name).parent.mkdir(parents=True, exist_ok=True)
                # a byte order mark, so that spreadsheets read umlauts
                encoding = "utf-8-sig" if file_name.endswith(".csv") else "utf-8"
                (temporary_folder / file_name).write_text(text, encoding=encoding, newline="\n")
            for file_name, source in source_by_path.items():
                (temporary_folder / file_name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(source, temporary_folder / file_name)
        if new_folder != target_folder:
            for entry in new_folder.iterdir():
                entry.rename(target_folder / entry.name)
            new_folder.rmdir()
    except OSError as error:
        raise OilfilmError(
            f"{folder}: cannot be written ({error.strerror}). Nothing was left behind: repeat the "
            "command where there is room and the right to write."
        ) from error


def _findings_and_other_files(
    path_by_log_name: dict[str, Path],
) -> tuple[Findings, list[SniffedLog]]:
    """Guesses from the logs, and the other files, which are no logs.

    Raises:
        OilfilmError: No file can be understood as a log.
    """
    settings = resolve(CONFIG, {"campaign": "etm-slim"})
    settings_by_source = {
        source: settings.with_changes({"campaign": {"semantics": {"zero": source}}})
        for source in ZERO_SOURCES_BEST_FIRST
    }
    source_of_zero = partial(find_zero_source, settings_by_source=settings_by_source)
    sniffed_files = [
        sniff(log_name, read_bytes(path), source_of_zero)
        for log_name, path in path_by_log_name.items()
    ]
    findings = Findings([log for log in sniffed_files if log.may_be_log])
    _refuse_sliding_rigs(sniffed_files, path_by_log_name)
    if not findings.logs_with_columns:
        problems = "\n".join(f"  {log.file}: {log.problem}" for log in sniffed_files)
        raise OilfilmError(
            "Nothing was written, because nothing can be understood as a log of a traction rig:\n"
            f"{problems}\n`oilfilm fit` takes a table of traction coefficients. data/raw/README.md "
            "of oilfilm says what logs need."
        )
    return findings, [log for log in sniffed_files if not log.may_be_log]


def _refuse_sliding_rigs(
    sniffed_files: Sequence[SniffedLog], path_by_log_name: Mapping[str, Path]
) -> None:
    """Refuse logs of which none is of a rig that rolls.

    Raises:
        OilfilmError: Every file is of a rig that does not roll.
    """
    reason_by_file: dict[str, str] = {}
    for log in sniffed_files:
        content = read_bytes(path_by_log_name[log.file])
        reason_by_file[log.file] = why_not_rolling(log, content)
    if reason_by_file and all(reason_by_file.values()):
        file_name, reason = next(iter(reason_by_file.items()))
        raise OilfilmError(f"{file_name}: {reason} Nothing was written.")


def _logs_and_sheets(paths: Iterable[Path]) -> tuple[dict[str, Path], list[Path]]:
    """The paths of logs by their names in the project, and the run sheet if there is one.

    Raises:
        OilfilmError: A name cannot be used, two logs have one name, or there are two run sheets.
    """
    path_by_log_name: dict[str, Path] = {}
    # a sheet may be reached by its own path and by that of its folder
    sheet_by_resolved_path: dict[Path, Path] = {}
    for path in paths:
        path_of_log_name: dict[str, Path] = {}
        if path.is_dir():
            path_of_log_name = {name: path / name for name in raw_log_names(path)}
            sheet_file = find_run_sheet(path)
            if sheet_file:
                sheet_by_resolved_path.setdefault(sheet_file.resolve(), sheet_file)
        elif is_run_sheet_of(path, path.parent):
            sheet_by_resolved_path.setdefault(path.resolve(), path)
        else:
            path_of_log_name = {path.name: path}
        for log_name, log_path in path_of_log_name.items():
            fault = name_fault(log_name, log_path)
            if fault:
                raise OilfilmError(fault)
            first_path = path_by_log_name.setdefault(log_name, log_path)
            if first_path.resolve() != log_path.resolve():
                raise OilfilmError(
                    f"{log_path}: has the name of {first_path}. Rename one, or put both into one "
                    "folder with subfolders and name that folder."
                )
    sheet_files = list(sheet_by_resolved_path.values())
    if len(sheet_files) > 1:
        raise OilfilmError(
            f"{sheet_files[1]}: is a second run sheet beside {sheet_files[0]}. Leave one out."
        )
    return path_by_log_name, sheet_files


def _text_by_path(campaign_name: str, findings: Findings) -> dict[str, str]:
    """The texts of Snakefile and settings with the guesses, by their path below the folder."""
    text_by_path = {
        "Snakefile": template_text("Snakefile"),
        "config/config.yaml": template_text("config.yaml.jinja", name=campaign_name),
        f"config/campaigns/{campaign_name}.yaml": campaign_yaml(campaign_name, findings),
    }
    for rig_name in findings.rig_names:
        if rig_name not in shipped_names("rigs").values():
            rig_text = template_text(
                "rig.yaml.jinja",
                name=rig_name,
                findings=findings,
                needs_radii=_needs_radii(findings),
            )
            text_by_path[f"config/rigs/{rig_name}.yaml"] = rig_text
    for oil_name in findings.labels_of_oil:
        if oil_name not in shipped_names("oils").values():
            text_by_path[f"config/oils/{oil_name}.yaml"] = oil_yaml(oil_name, findings)
    return text_by_path


def _needs_radii(findings: Findings) -> bool:
    """Whether a speed is, or may be, that of a spindle: then the radii of the tracks are needed."""
    if findings.needs_radii:
        return True
    body_speeds = {"ball_speed", "disc_speed"}
    column_names: Iterable[str] = ()
    if body_speeds & findings.names_to_choose_from.keys():
        column_names = chain.from_iterable(log.names for log in findings.logs_with_columns)
    return any(_converted_unit(column_name, "ball_speed") == "rpm" for column_name in column_names)


def _converted_unit(column_name: str, quantity: str) -> str:
    """The unit of a quantity to which the unit in a column's name converts; empty without one."""
    _, unit = split_unit(column_name)
    if not unit or not VOCABULARY.is_convertible(quantity, unit):
        return ""
    return conversion(unit, tuple(VOCABULARY.units_of_quantity[quantity])).unit


# ---------------------------------------------------------------- the files


def template_text(file_name: str, /, **values: object) -> str:
    """The text of a file, made from its template and the values that the template names."""
    environment = Environment(
        loader=PackageLoader("oilfilm.cli"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # noqa: S701 - YAML, whose values and comments `settings_line` writes
    )
    return environment.get_template(file_name).render(line=settings_line, **values)


def campaign_yaml(campaign_name: str, findings: Findings) -> str:
    """Text of `config/campaigns/<name>.yaml`."""
    all_shipped = shipped_names("oils").values()
    shipped_oil_names = [oil_name for oil_name in findings.labels_of_oil if oil_name in all_shipped]
    own_oil_names = [oil_name for oil_name in findings.labels_of_oil if oil_name not in all_shipped]
    unnamed_oil_comment = ""
    if findings.labels_of_oil == {"my-oil": []}:
        unnamed_oil_comment = "guess: no log names its oil; "
    labels_by_oil = {}
    for oil_name, labels in findings.labels_of_oil.items():
        if labels and labels != [oil_name]:
            labels_by_oil[oil_name] = labels
    return template_text(
        "campaign.yaml.jinja",
        campaign_name=campaign_name,
        findings=findings,
        # names come from logs: a line end among them would end the comment
        summary_lines=[printable(line) for line in lines_on_forms(findings)],
        shipped_oil_names=shipped_oil_names,
        own_oil_names=own_oil_names,
        unnamed_oil_comment=unnamed_oil_comment,
        labels_by_oil=labels_by_oil,
        film_is_unknown=_film_is_unknown(findings),
        lines_by_group={
            "columns": list(_column_lines(findings)),
            "header": [
                DraftLine(key, names, "guess")
                for key, names in findings.header_names_of_key.items()
            ],
            "semantics": list(_semantics_lines(findings)),
        },
    )


def _film_is_unknown(findings: Findings) -> bool:
    """Whether the film thickness needs an oil or a rig that does not come with oilfilm."""
    all_oils_are_shipped = set(findings.labels_of_oil) <= set(shipped_names("oils").values())
    return not all_oils_are_shipped or not all(map(_has_known_contact, findings.rig_names))


def _has_known_contact(rig_name: str) -> bool:
    """Whether a rig comes with oilfilm and its contact was recorded."""
    if rig_name not in shipped_names("rigs").values():
        return False
    return load(CONFIG / f"rigs/{rig_name}.yaml", Rig).contact() is not None


def lines_on_forms(findings: Findings) -> Iterator[str]:
    """The forms of the logs with their numbers, one line per form; then the unreadable logs."""
    log_count_by_dialect = Counter(
        (log.format_name, log.dialect) for log in findings.logs
    ).most_common()
    for (format_name, dialect), count in log_count_by_dialect:
        attributes = [format_name]
        if dialect.encoding:
            attributes.append(dialect.encoding)
        if dialect.delimiter:
            attributes += [f"delimiter {dialect.delimiter}", f"decimal {dialect.decimal_mark}"]
        yield f"{count} {'log' if count == 1 else 'logs'}: {', '.join(attributes)}"
    for log in findings.logs:
        if log.problem:
            yield f"{log.file} could not be read: {log.problem}"


def _column_lines(findings: Findings) -> Iterator[DraftLine]:
    """Lines of the group `columns`."""
    for quantity in VOCABULARY.units_of_quantity:
        column_names = findings.column_names_of_quantity.get(quantity)
        unit, unit_is_unknown = findings.unit_for_campaign_file(quantity)
        if quantity in findings.names_to_choose_from:
            offered_names = [
                _offered_name(name, quantity) for name in findings.names_to_choose_from[quantity]
            ]
            choices = ", ".join(offered_names) or "no column is left"
            comment = f"{FILL_IN}: the name of the column; perhaps {choices}"
            yield DraftLine(quantity, {"name": column_names}, comment)
        elif column_names and _open_question(findings, quantity):
            # a name that leaves its meaning open is confirmed, never taken
            question = _open_question(findings, quantity)
            comment = f"{FILL_IN}: the name of the column; perhaps {column_names[0]}: {question}"
            yield DraftLine(quantity, {"name": None}, comment)
        elif column_names and unit_is_unknown:
            units = " or ".join(VOCABULARY.units_of_quantity[quantity])
            comment = f"{FILL_IN}: the unit, such as {units}; the logs do not say it"
            yield DraftLine(quantity, {"name": column_names, "unit": None}, comment)
        elif column_names and unit:
            yield DraftLine(quantity, {"name": column_names, "unit": unit}, "guess")
        elif column_names:
            yield DraftLine(quantity, {"name": column_names}, "guess")


def _open_question(findings: Findings, quantity: str) -> str:
    """What names and units of a quantity's columns leave open; empty where it is nothing."""
    for log in findings.logs_with_columns:
        for name, unit in log.candidates_of_quantity.get(quantity, ()):
            meaning = meaning_of(name, unit)
            if meaning is not None and meaning.question:
                return meaning.question
    return ""


def _offered_name(column_name: str, quantity: str) -> str:
    """The name of a column to choose; a torque is offered as a torque, never as a force."""
    if quantity == "traction_force" and "torque" in concepts_in(column_name):
        return f"{column_name} (a torque: the rig file needs torque_arm_m)"
    return column_name


def _semantics_lines(findings: Findings) -> Iterator[DraftLine]:
    """Lines of the group `semantics`."""
    if findings.run_count_of_zero_source:
        ((source, count),) = findings.run_count_of_zero_source.most_common(1)
        run_count = findings.run_count_of_zero_source.total()
        which_runs = "the runs" if count == run_count else f"{count} of {run_count} runs"
        reason = _COMMENT_BY_ZERO_SOURCE[source].format(which=which_runs)
        if findings.needs_radii and source in ("rolling_phases", "opening_phase"):
            reason += "; true where the radii of the tracks make the beginning pure rolling"
        yield DraftLine("zero", source, reason)
    if findings.needs_slip_definition:
        # a column with the project's name needs no line under `columns`
        column_names = findings.column_names_of_quantity.get(
            "slide_roll_ratio", ["slide_roll_ratio"]
        )
        meanings = [meaning_of(name) for name in column_names]
        is_column_known = "slide_roll_ratio" not in findings.names_to_choose_from
        if is_column_known and all(
            meaning is not None and meaning.definition == "over_mean" for meaning in meanings
        ):
            yield DraftLine("slide_roll_ratio", "over_mean", "as the name says")
        else:
            comment = f"{FILL_IN}: over_mean, over_sum or over_faster: the speed that divides it"
            yield DraftLine("slide_roll_ratio", None, comment)


def oil_yaml(oil_name: str, findings: Findings) -> str:
    """Text of `config/oils/<id>.yaml`: the shipped template without its numbers."""
    label = next(iter(findings.labels_of_oil[oil_name]), oil_name)
    own_value_by_key = {
        "id": oil_name,
        "name": label,
        "display_name": label,
        "note": "not documented yet",
        "source": "not documented yet",
    }

    def with_own_value(line: re.Match[str]) -> str:
        """A line of the template with the oil's own value, or with none."""
        key, example = line.groups()
        if key in ("stand_in", "model"):
            return line[0]
        if key in own_value_by_key:
            return settings_line(key, own_value_by_key[key])
        return settings_line(key, None, f"{FOR_FILM}: as {' '.join(example.split())}")

    shipped_text = (CONFIG / "oils/template.yaml").read_text(encoding="utf-8")
    example_lines = shipped_text[shipped_text.index("id:") :]
    lines_of_keys = re.sub(r"(?m)^( *\w+): +(.+)$", with_own_value, example_lines)
    return (
        "# yaml-language-server: $schema=../schemas/oil.schema.json\n"
        "# Read when the campaign file lists the oil under `oils`: fill in all of it before.\n"
        f"{lines_of_keys}"
    )


def run_sheet_text(findings: Findings) -> str:
    """Text of `data/raw/<name>/runs.csv`: what the headers of the logs do not contain."""
    rows = pd.DataFrame(chain.from_iterable(_rows_of_log(log, findings) for log in findings.logs))
    used_columns = [name for name in ("run", "oil", "log_kind", *SET_POINT_KEYS) if name in rows]
    columns = ["file", *used_columns, "exclude", "remarks"]
    return rows.reindex(columns=columns).to_csv(
        index=False,
        sep=";" if findings.uses_decimal_comma else ",",
        decimal="," if findings.uses_decimal_comma else ".",
        float_format="%g",
        lineterminator="\n",
    )


def _rows_of_log(log: SniffedLog, findings: Findings) -> Iterator[dict[str, object]]:
    """Rows of the run sheet for one log."""
    for run in runs_for_run_sheet(log):
        row: dict[str, object] = {"file": log.file}
        if run.name_in_file:
            row["run"] = run.name_in_file
        remarks = []
        median_by_set_point = measured_set_points(run)
        if median_by_set_point:
            row |= median_by_set_point
            remarks.append("guess: set points are medians of the log")
        if findings.lacks_oil_in_some_logs:
            row["oil"] = ""
            if not run.oil_name:
                remarks.append(OIL_TO_FILL_IN)
        if run.is_settled and not run.log_kind:
            # a table of mu does not say that its rows are settled readings
            row["log_kind"] = "steps"
        row["remarks"] = ". ".join(remarks)
        yield row
