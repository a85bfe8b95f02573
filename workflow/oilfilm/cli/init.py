"""The command `oilfilm init`: a project folder, with what logs seem to hold written into it.

Decides: the files that `oilfilm init` writes.
"""

import argparse
import re
import shutil
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
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
from oilfilm.logs.raw_files import is_sheet, raw_files, unfit_name
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

# Pages that messages and settings name.
_PAGES = ("data/raw/README.md", "docs/reference/configuration.md")
_PROFILE = "profiles/default/config.yaml"
_KINDS = ("config", "campaign", "rig", "oil", "bearing")
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

Marked = Sequence[tuple[str, int, str]]
Line = tuple[str, object, str]


@dataclass(frozen=True)
class NewProject:
    """What was written.

    Attributes:
        campaign: Name of the campaign.
        found: What the logs seem to hold.
        no_logs: Files that were given and are no logs; they are not copied.
        files: The files that were written, below the folder; no logs.
        to_fill_in: The lines that only the laboratory can fill in: file, line number, text.
        for_film: The same of lines that the film thickness needs.
    """

    campaign: str
    found: Findings
    no_logs: Sequence[Sniffed]
    files: Sequence[str]
    to_fill_in: Marked
    for_film: Marked


def run(options: argparse.Namespace) -> int:
    """Write the folder, say what was found and what is to fill in; 1 if a log cannot be read."""
    made = make_project(options.folder, options.logs, options.campaign)
    print("\n".join(map(printable, _report(made, str(options.folder)))))
    given = {path.name for path in options.logs}
    stopped = [*made.found.logs, *(log for log in made.no_logs if log.file in given)]
    return int(any(log.problem for log in stopped))


def _report(made: NewProject, folder: str) -> Iterator[str]:
    yield f"{folder}: a project with the campaign {made.campaign}"
    yield from (f"  {line}" for line in summary(made.found))
    for log in made.no_logs:
        yield f"  {log.file} is no log and was not copied: {log.problem}"
    for quantity, names in made.found.columns.items():
        yield f"  {quantity}: {', '.join(names)} (guess)"
    yield "Written:"
    yield from (f"  {file}" for file in made.files)
    if made.to_fill_in:
        yield f"To fill in, because only you can know it: {len(made.to_fill_in)}"
    for file, number, line in made.to_fill_in:
        yield f"  {file}, line {number}: {' '.join(line.split())}"
    if made.for_film:
        files = ", ".join(dict.fromkeys(file for file, *_ in made.for_film))
        yield f"For pressure and film thickness, fill in as well: {files}"
    first = "" if made.found.logs else f"put logs into data/raw/{made.campaign}; "
    then = "Fill in these lines, then" if made.to_fill_in else "Then"
    yield f"{then}: cd {quote(folder)}; {first}oilfilm check data/raw/{made.campaign}; oilfilm run"


def make_project(folder: Path, given: Sequence[Path], campaign: str | None = None) -> NewProject:
    """Write a project folder for logs, which are copied into it; nothing that exists is changed.

    Args:
        folder: The folder; it must not exist, or be empty.
        given: Logs, and folders of logs.
        campaign: Name of the campaign; that of the folder if not given.

    Raises:
        OilfilmError: The folder is not empty, the name cannot be one, or no log can be read.
    """
    name = safe_name(campaign or folder.resolve().name, "--campaign" if campaign else folder)
    if folder.exists() and not (folder.is_dir() and not any(folder.iterdir())):
        raise OilfilmError(
            f"{folder}: exists already and is not empty. Name a new or an empty folder."
        )
    logs, sheet = _gathered(given)
    found, no_logs = _sniffed(logs)
    raw = f"data/raw/{name}"
    own = _texts(name, found)
    if sheet is None:
        own[f"{raw}/runs.csv"] = run_sheet(found)
    copies = {page: page for page in _PAGES} | {
        # beside the settings, where editors find them
        f"config/schemas/{kind}.schema.json": f"workflow/schemas/{kind}.schema.json"
        for kind in _KINDS
    }
    texts = own | {file: (HOME / source).read_text("utf-8") for file, source in copies.items()}
    for file, text in texts.items():
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        # a mark at its beginning, so that spreadsheets read umlauts
        encoding = "utf-8-sig" if file.endswith(".csv") else "utf-8"
        (folder / file).write_text(text, encoding=encoding, newline="\n")
    (folder / raw).mkdir(parents=True, exist_ok=True)
    copied = {log.file: logs[log.file] for log in found.logs}
    for file, path in (copied | ({sheet.name: sheet} if sheet else {})).items():
        (folder / raw / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, folder / raw / file)

    def marked(mark: str) -> Marked:
        return [
            (file, number, line)
            for file, text in own.items()
            for number, line in enumerate(text.splitlines(), start=1)
            if mark in line
        ]

    return NewProject(name, found, no_logs, [*own], marked(FILL_IN), marked(FOR_FILM))


def _sniffed(logs: dict[str, Path]) -> tuple[Findings, list[Sniffed]]:
    """What the logs hold, and the files that are no logs.

    Raises:
        OilfilmError: Logs are given and nothing of them can be understood.
    """
    settings = resolve(CONFIG, {"campaign": "etm-slim"})
    by_source = {
        source: settings.with_changes({"campaign": {"semantics": {"zero": source}}})
        for source in BEST_FIRST
    }
    zero = partial(zero_source, settings_by_source=by_source)
    sniffed: list[Sniffed] = []
    for file, path in logs.items():
        if sys.stderr.isatty():  # hundreds of logs take a minute
            print(f"\r\x1b[K{len(sniffed)} of {len(logs)} logs read", end="", file=sys.stderr)
        sniffed.append(sniff(file, read_bytes(path), zero))
    if sys.stderr.isatty():
        print("\r\x1b[K", end="", file=sys.stderr)
    found = Findings([log for log in sniffed if log.is_log])
    if sniffed and not found.named:
        problems = "\n".join(f"  {log.file}: {log.problem}" for log in sniffed)
        raise OilfilmError(
            "Nothing was written, because nothing can be understood as a log of a traction rig:\n"
            f"{problems}\n`oilfilm fit` takes a table of traction coefficients. data/raw/README.md "
            "of oilfilm says what logs need."
        )
    return found, [log for log in sniffed if not log.is_log]


def _gathered(given: Iterable[Path]) -> tuple[dict[str, Path], Path | None]:
    """The logs by their future names, and the run sheet if one is given."""
    logs: dict[str, Path] = {}
    sheets: list[Path] = []
    for path in given:
        top = path if path.is_dir() else path.parent
        sheets += [each for each in (sorted(path.glob("*")) or [path]) if is_sheet(each, top)]
        inside = {name: path / name for name in raw_files(path)} if path.is_dir() else {}
        for file, log in (inside or {path.name: path}).items():
            if log in sheets:
                continue
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
    return logs, sheets[0] if sheets else None


def _texts(name: str, found: Findings) -> dict[str, str]:
    """The files that say what was found, by their path below the folder."""
    files = {
        "README.txt": template("README.txt.jinja", name=name),
        "Snakefile": template("Snakefile"),
        "config/config.yaml": template("config.yaml.jinja", name=name),
        f"config/campaigns/{name}.yaml": campaign_yaml(name, found),
        _PROFILE: (HOME / _PROFILE).read_text("utf-8"),
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
    return environment.get_template(file).render(line=_line, schema=schema_line, **values)


def schema_line(kind: str) -> str:
    """The line by which an editor checks a settings file and completes its keys."""
    folder = "schemas" if kind == "config" else "../schemas"
    return f"# yaml-language-server: $schema={folder}/{kind}.schema.json"


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
        no_film=bool(own) or any(rig_of(rig).contact() is None for rig in found.rigs),
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


def rig_of(name: str) -> Rig:
    """A shipped rig, or one of which nothing is known."""
    if name in shipped("rigs").values():
        rig: Rig = load(CONFIG / f"rigs/{name}.yaml", Rig)
        return rig
    return Rig(name=name, source="unknown")


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
    numbers = "viscosity", "nominal", "pressure", "density", "specific", "thermal"
    lines = [
        schema_line("oil"),
        "# Read when the campaign file lists the oil under `oils`: fill in all of it before.",
    ]
    template = (CONFIG / "oils/template.yaml").read_text(encoding="utf-8").splitlines()
    start = next(number for number, line in enumerate(template) if line.startswith("id:"))
    for line in template[start:]:
        key, _, rest = line.partition(":")
        given = {"id": oil, "name": label, "display_name": label}
        if key in given:
            lines.append(_line(key, given[key]))
        elif key in ("note", "source"):
            lines.append(_line(key, "not documented yet", rest.strip()))
        elif key.strip().startswith(numbers):
            comment = rest.partition("#")[2].strip() or f"as{rest}"
            lines.append(_line(key, None, f"{FOR_FILM}: {comment}"))
        elif not key.startswith("# aliases"):
            lines.append(line)
    return "\n".join([*lines, ""])


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
