"""The command `oilfilm init`: a project folder, with what logs seem to hold written into it.

Decides: the files that `oilfilm init` writes.
"""

import argparse
import re
import shutil
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from shlex import quote

import numpy as np
import pandas as pd
import yaml
from jinja2 import Environment, PackageLoader, StrictUndefined

from oilfilm.curation.traction_rig import BEST_FIRST, zero_source
from oilfilm.errors import OilfilmError, printable
from oilfilm.home import CONFIG, HOME
from oilfilm.logs.base import SET_POINTS
from oilfilm.logs.ingest import read_bytes
from oilfilm.logs.raw_files import find_sheet, is_sheet, raw_files, unfit_name
from oilfilm.logs.sniff import (
    VOCABULARY,
    Findings,
    Sniffed,
    rows_of_sheet,
    set_points,
    shipped,
    sniff,
)
from oilfilm.settings.messages import load
from oilfilm.settings.resolve import resolve, safe_name
from oilfilm.settings.rig import Rig

# Pages that messages and settings name, and how snakemake runs.
_COPIES = (
    *("data/raw/README.md", "docs/reference/configuration.md"),
    "profiles/default/config.yaml",
)
# Marks what only the laboratory knows: the run stops without it. Behind "for the film" it does not.
FILL_IN, FOR_FILM = "# FILL IN", "# for the film"
_WIDTH = 34
# Why a source of the zero of the force suits some runs.
_ZEROS = {
    "rolling_phases": "guess: {which} begin and end with pure rolling",
    "opening_phase": "guess: {which} begin with pure rolling and do not end with it",
    "standstill": "guess: {which} stand still before the first level and have no pure rolling; is "
    "that the sensor's zero?",
    None: f"{FILL_IN}: {{which}} have neither pure rolling nor standstill; already_removed if the "
    "logger took the zero of the force off",
}

Line = tuple[str, object, str]


@dataclass(frozen=True)
class NewProject:
    """What was written.

    Attributes:
        campaign: Name of the campaign.
        found: What the logs seem to hold.
        no_logs: Files that were given and are no logs; they are not copied.
        texts: The files that were written, without logs and copies, by their path below the folder.
    """

    campaign: str
    found: Findings
    no_logs: Sequence[Sniffed]
    texts: Mapping[str, str]

    @property
    def to_fill_in(self) -> list[tuple[str, int, str]]:
        """The lines that only the laboratory can fill in: file, line number, text."""
        return [
            (file, number, line)
            for file, text in self.texts.items()
            for number, line in enumerate(text.splitlines(), start=1)
            if FILL_IN in line
        ]


def run(options: argparse.Namespace) -> int:
    """Write the folder, say what was found and what is to fill in; 1 if a log cannot be read."""
    made = make_project(options.folder, options.logs)
    print("\n".join(map(printable, _report(made, str(options.folder)))))
    return int(any(log.problem for log in made.found.logs))


def _report(made: NewProject, folder: str) -> Iterator[str]:
    yield f"{folder}: a project with the campaign {made.campaign}"
    yield from (f"  {line}" for line in summary(made.found))
    for log in made.no_logs:
        yield f"  {log.file} is no log and was not copied: {log.problem}"
    for quantity, names in made.found.columns.items():
        yield f"  {quantity}: {', '.join(names)} (guess)"
    yield f"Written: {', '.join(made.texts)}"
    yield f"To fill in, because only you can know it: {len(made.to_fill_in)}"
    for file, number, line in made.to_fill_in:
        yield f"  {file}, line {number}: {' '.join(line.split())}"
    if for_film := [file for file, text in made.texts.items() if FOR_FILM in text]:
        yield f"For pressure and film thickness, fill in as well: {', '.join(for_film)}"
    yield f"Then: cd {quote(folder)}; oilfilm check data/raw/{made.campaign}; oilfilm run"


def make_project(folder: Path, given: Sequence[Path]) -> NewProject:
    """Write a project folder for logs, which are copied into it; nothing that exists is changed.

    Args:
        folder: The folder, with the name of the campaign; it must not exist, or be empty.
        given: Logs, and folders of logs.

    Raises:
        OilfilmError: The folder is not empty, the name cannot be one, or no log can be read.
    """
    name = safe_name(folder.resolve().name, folder)
    if folder.exists() and not (folder.is_dir() and not any(folder.iterdir())):
        raise OilfilmError(
            f"{folder}: exists already and is not empty. Name a new or an empty folder."
        )
    logs, sheets = _gathered(given)
    found, no_logs = _sniffed(logs)
    raw = f"data/raw/{name}"
    own = _texts(name, found)
    if not sheets:
        own[f"{raw}/runs.csv"] = run_sheet(found)
    for file, text in own.items():
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        # a mark at its beginning, so that spreadsheets read umlauts
        encoding = "utf-8-sig" if file.endswith(".csv") else "utf-8"
        (folder / file).write_text(text, encoding=encoding, newline="\n")
    copied = {f"{raw}/{log.file}": logs[log.file] for log in found.logs}
    copied |= {f"{raw}/{sheet.name}": sheet for sheet in sheets}
    copied |= {page: HOME / page for page in _COPIES}
    # beside the settings, where editors find them
    for schema in sorted((HOME / "workflow/schemas").glob("*.schema.json")):
        copied[f"config/schemas/{schema.name}"] = schema
    for file, source in copied.items():
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, folder / file)
    return NewProject(name, found, no_logs, own)


def _sniffed(logs: dict[str, Path]) -> tuple[Findings, list[Sniffed]]:
    """What the logs hold, and the files that are no logs.

    Raises:
        OilfilmError: Nothing can be understood as a log.
    """
    settings = resolve(CONFIG, {"campaign": "etm-slim"})
    by_source = {
        source: settings.with_changes({"campaign": {"semantics": {"zero": source}}})
        for source in BEST_FIRST
    }
    zero = partial(zero_source, settings_by_source=by_source)
    sniffed = [sniff(file, read_bytes(path), zero) for file, path in logs.items()]
    found = Findings([log for log in sniffed if log.is_log])
    if not found.named:
        problems = "\n".join(f"  {log.file}: {log.problem}" for log in sniffed)
        raise OilfilmError(
            "Nothing was written, because nothing can be understood as a log of a traction rig:\n"
            f"{problems}\n`oilfilm fit` takes a table of traction coefficients. data/raw/README.md "
            "of oilfilm says what logs need."
        )
    return found, [log for log in sniffed if not log.is_log]


def _gathered(given: Iterable[Path]) -> tuple[dict[str, Path], list[Path]]:
    """The logs by their future names, and the run sheet if one is given."""
    logs: dict[str, Path] = {}
    sheets: list[Path] = []
    for path in given:
        inside = {path.name: path}
        if path.is_dir():
            inside = {name: path / name for name in raw_files(path)}
            sheets += [sheet for sheet in [find_sheet(path)] if sheet]
        elif is_sheet(path, path.parent):
            inside, sheets = {}, [*sheets, path]
        for file, log in inside.items():
            if fault := unfit_name(file, log):
                raise OilfilmError(fault)
            other = logs.setdefault(file, log)
            if other.resolve() != log.resolve():
                raise OilfilmError(
                    f"{log}: has the name of {other}. Rename one, or put both into one folder with "
                    "subfolders and name that folder."
                )
    if len(sheets) > 1:
        raise OilfilmError(f"{sheets[1]}: is a second run sheet beside {sheets[0]}. Leave one out.")
    return logs, sheets


def _texts(name: str, found: Findings) -> dict[str, str]:
    """The files that say what was found, by their path below the folder."""
    files = {
        "Snakefile": template("Snakefile"),
        "config/config.yaml": template("config.yaml.jinja", name=name),
        f"config/campaigns/{name}.yaml": campaign_yaml(name, found),
    }
    for rig in found.rigs:
        if rig not in shipped("rigs").values():
            text = template("rig.yaml.jinja", name=rig, found=found)
            files[f"config/rigs/{rig}.yaml"] = text
    for oil in found.oils:
        if oil not in shipped("oils").values():
            files[f"config/oils/{oil}.yaml"] = oil_yaml(oil, found)
    return files


# ---------------------------------------------------------------- the files


def template(file: str, /, **values: object) -> str:
    """The text of a file from its template."""
    environment = Environment(
        loader=PackageLoader("oilfilm.cli"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # noqa: S701 - YAML, whose values and comments `_line` writes
    )
    return environment.get_template(file).render(line=_line, **values)


def campaign_yaml(name: str, found: Findings) -> str:
    """`config/campaigns/<name>.yaml`."""
    known = shipped("oils").values()
    own = [oil for oil in found.oils if oil not in known]
    return template(
        "campaign.yaml.jinja",
        name=name,
        found=found,
        # names come out of logs: a line end among them would end the comment
        summary=[*map(printable, summary(found))],
        shipped=[oil for oil in found.oils if oil in known],
        own=own,
        unnamed="guess: no log names its oil; " if found.oils == {"my-oil": []} else "",
        aliases={oil: labels for oil, labels in found.oils.items() if labels not in ([], [oil])},
        no_film=bool(own)
        or any(
            rig not in shipped("rigs").values()
            or load(CONFIG / f"rigs/{rig}.yaml", Rig).contact() is None
            for rig in found.rigs
        ),
        groups={
            "columns": [*_columns(found)],
            "header": [(key, names, "guess") for key, names in found.header.items()],
            "semantics": [*_semantics(found)],
        },
    )


def summary(found: Findings) -> Iterator[str]:
    """How the logs are written and what they cover, one line for each way of writing."""
    forms = Counter((log.format, log.form) for log in found.logs).most_common()
    for (name, form), count in forms:
        words = [name, *([form.encoding] if form.encoding else [])]
        if form.delimiter:
            words += [f"delimiter {form.delimiter}", f"decimal {form.decimal_mark}"]
        yield f"{count} {'log' if count == 1 else 'logs'}: {', '.join(words)}"
    for log in found.logs:
        if log.problem:
            yield f"{log.file} could not be read: {log.problem}"


def _columns(found: Findings) -> Iterator[Line]:
    for quantity in VOCABULARY.quantities:
        names = found.columns.get(quantity)
        unit, unknown = found.unit(quantity)
        if quantity in found.doubtful:
            choice = ", ".join(found.doubtful[quantity]) or "no column is left"
            sentence = f"{FILL_IN}: the name of the column; perhaps {choice}"
            yield quantity, {"name": names}, sentence
        elif names and unknown:
            units = " or ".join(VOCABULARY.quantities[quantity])
            sentence = f"{FILL_IN}: the unit, such as {units}; the logs do not say it"
            yield quantity, {"name": names, "unit": None}, sentence
        elif names:
            yield quantity, {"name": names, **({"unit": unit} if unit else {})}, "guess"


def _semantics(found: Findings) -> Iterator[Line]:
    if found.zeros:
        ((source, count),) = found.zeros.most_common(1)
        total = found.zeros.total()
        which = "the runs" if count == total else f"{count} of {total} runs"
        why = _ZEROS[source].format(which=which)
        if found.needs_radii and source in ("rolling_phases", "opening_phase"):
            why += "; true where the radii of the tracks make the beginning pure rolling"
        yield "zero", source, why
    if found.slip_is_logged:
        yield "slide_roll_ratio", "over_mean", "guess: over_mean, over_sum or over_faster speed"


def oil_yaml(oil: str, found: Findings) -> str:
    """`config/oils/<id>.yaml`: the shipped template with the numbers left out."""
    label = next(iter(found.oils[oil]), oil)
    known = dict.fromkeys(("name", "display_name"), label) | {"id": oil}
    known |= dict.fromkeys(("note", "source"), "not documented yet")

    def own(line: re.Match[str]) -> str:
        key, example = line[1], " ".join(line[2].split())
        if key in ("stand_in", "model"):
            return line[0]
        return _line(key, known.get(key), "" if key in known else f"{FOR_FILM}: as {example}")

    template = (CONFIG / "oils/template.yaml").read_text(encoding="utf-8")
    keys = re.sub(r"(?m)^( *\w+): +(.+)$", own, template[template.index("id:") :])
    return (
        "# yaml-language-server: $schema=../schemas/oil.schema.json\n"
        "# Read when the campaign file lists the oil under `oils`: fill in all of it before.\n"
        f"{keys}"
    )


def run_sheet(found: Findings) -> str:
    """`data/raw/<name>/runs.csv`: what the headers of the logs do not say."""
    rows = pd.DataFrame([row for log in found.logs for row in _rows(log, found)])
    used = [name for name in ("run", "oil", "log_kind", *SET_POINTS) if name in rows]
    columns = ["file", *used, "exclude", "remarks"]
    sep, decimal = (";", ",") if found.decimal_comma else (",", ".")
    return rows.reindex(columns=columns).to_csv(
        index=False, sep=sep, decimal=decimal, float_format="%g", lineterminator="\n"
    )


def _rows(log: Sniffed, found: Findings) -> Iterator[dict[str, object]]:
    for run in rows_of_sheet(log):
        given = set_points(run)
        row = {"file": log.file, **({"run": run.part} if run.part else {}), **given}
        row |= {"oil": ""} if found.unnamed_oil else {}
        # the rows of a table of mu are settled readings, which such a table does not say
        row |= {"log_kind": "steps"} if run.settled and not run.log_kind else {}
        remarks = ["guess: set points are medians of the log"] if given else []
        if found.unnamed_oil and not run.oil:
            remarks.append("FILL IN: the oil")
        yield {**row, "remarks": ". ".join(remarks)}


def _line(key: str, value: object, comment: str = "") -> str:
    """A line of YAML; None is written as nothing, to be filled in."""
    line = f"{key}: {_flow(value)}".rstrip()
    comment = printable(comment.removeprefix("# "))
    return f"{line.ljust(_WIDTH)}  # {comment}" if comment else line


def _flow(value: object) -> str:
    """A value on one line, as YAML reads it back."""
    if value is None:
        return ""
    text = yaml.safe_dump(
        value, default_flow_style=True, allow_unicode=True, sort_keys=False, width=np.inf
    )
    # a last key without a value is to be filled in
    return re.sub(r" null}$", " }", text.removesuffix("\n").removesuffix("\n..."))
