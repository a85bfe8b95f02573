"""The command `oilfilm init`: a project folder, with what logs seem to hold written into it."""

import argparse
import shutil
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from shlex import quote

from oilfilm.cli import stubs
from oilfilm.curation.traction_rig import BEST_FIRST, zero_source
from oilfilm.errors import OilfilmError, printable
from oilfilm.home import CONFIG, HOME
from oilfilm.logs.ingest import read_bytes
from oilfilm.logs.raw_files import is_sheet, raw_files, unfit_name
from oilfilm.logs.sniff import Findings, Sniffed, shipped, sniff
from oilfilm.settings.resolve import resolve, safe_name

# Pages that messages and settings name.
_PAGES = ("data/raw/README.md", "docs/reference/configuration.md")
_PROFILE = "profiles/default/config.yaml"
_KINDS = ("config", "campaign", "rig", "oil", "bearing")
Marked = Sequence[tuple[str, int, str]]


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
    yield from (f"  {line}" for line in stubs.summary(made.found))
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
        own[f"{raw}/runs.csv"] = stubs.run_sheet(found)
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

    return NewProject(name, found, no_logs, [*own], marked(stubs.FILL_IN), marked(stubs.FOR_FILM))


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
        "README.txt": stubs.template("README.txt.jinja", name=name),
        "Snakefile": stubs.template("Snakefile"),
        "config/config.yaml": stubs.template("config.yaml.jinja", name=name),
        f"config/campaigns/{name}.yaml": stubs.campaign_yaml(name, found),
        _PROFILE: (HOME / _PROFILE).read_text("utf-8"),
    }
    for rig in found.rigs:
        if rig not in shipped("rigs").values():
            text = stubs.template("rig.yaml.jinja", name=rig, found=found)
            files[f"config/rigs/{rig}.yaml"] = text
    for oil in found.oils:
        if oil not in shipped("oils").values():
            files[f"config/oils/{oil}.yaml"] = stubs.oil_yaml(oil, found)
    return files
