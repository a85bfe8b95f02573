"""Writes a new project folder; nothing that is there already is changed."""

import shutil
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from oilfilm.cli import stubs
from oilfilm.curation.zero_source import BEST_FIRST, zero_source
from oilfilm.errors import OilfilmError
from oilfilm.home import CONFIG, HOME
from oilfilm.logs.ingest import read_bytes
from oilfilm.logs.raw_files import is_sheet, raw_files, unfit_name
from oilfilm.logs.sniff import Findings, Sniffed, shipped, sniff
from oilfilm.settings.resolve import resolve, safe_name

# Pages that messages and settings name.
_PAGES = ("data/raw/README.md", "docs/reference/configuration.md")


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
    to_fill_in: Sequence[tuple[str, int, str]]
    for_film: Sequence[tuple[str, int, str]]


def make_project(
    folder: Path,
    given: Sequence[Path],
    campaign: str | None = None,
    progress: Callable[[int, int], None] = lambda read, count: None,
) -> NewProject:
    """Write a project folder for logs, which are copied into it.

    Args:
        folder: The folder; it must not exist, or be empty.
        given: Logs, and folders of logs.
        campaign: Name of the campaign; that of the folder if not given.
        progress: Called before each log, with the number of those read and of all.

    Raises:
        OilfilmError: The folder is not empty, the name cannot be one, or a log cannot be read.
    """
    name = safe_name(campaign or folder.resolve().name, "--campaign" if campaign else folder)
    if folder.exists() and not (folder.is_dir() and not any(folder.iterdir())):
        raise OilfilmError(
            f"{folder}: exists already and is not empty. Name a new or an empty folder."
        )
    logs, sheet = _gathered(given)
    settings = resolve(CONFIG, {"campaign": "etm-slim"})
    by_source = {
        source: settings.with_changes({"campaign": {"semantics": {"zero": source}}})
        for source in BEST_FIRST
    }
    sniffed: list[Sniffed] = []
    for file, path in logs.items():
        progress(len(sniffed), len(logs))
        content = read_bytes(path)
        sniffed.append(sniff(file, content, partial(zero_source, settings_by_source=by_source)))
    found = Findings([log for log in sniffed if log.is_log])
    no_logs = [log for log in sniffed if not log.is_log]
    files = _files(name, found, written_sheet=sheet is None)
    raw = folder / "data/raw" / name
    raw.mkdir(parents=True)
    copied = {log.file: logs[log.file] for log in found.logs}
    copied |= {sheet.name: sheet} if sheet else {}
    for file, path in copied.items():
        (raw / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, raw / file)
    for page in _PAGES:
        (folder / page).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(HOME / page, folder / page)
    for file, text in files.items():
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        # a mark at its beginning, so that spreadsheets read umlauts
        encoding = "utf-8-sig" if file.endswith(".csv") else "utf-8"
        (folder / file).write_text(text, encoding=encoding, newline="\n")
    lines = [
        (file, number, line)
        for file, text in files.items()
        for number, line in enumerate(text.splitlines(), start=1)
    ]
    to_fill_in, for_film = (
        [each for each in lines if mark in each[2]] for mark in (stubs.FILL_IN, stubs.FOR_FILM)
    )
    return NewProject(name, found, no_logs, [*files], to_fill_in, for_film)


def _gathered(given: Iterable[Path]) -> tuple[dict[str, Path], Path | None]:
    """The logs by their future names, and the run sheet if one is given."""
    logs: dict[str, Path] = {}
    sheets: list[Path] = []
    for path in given:
        inside = raw_files(path) if path.is_dir() else []
        sheets += (
            [each for each in sorted(path.glob("*")) if is_sheet(each, path)] if inside else []
        )
        if not path.is_dir() and is_sheet(path, path.parent):
            sheets.append(path)
            continue
        for file, log in [(name, path / name) for name in inside] or [(path.name, path)]:
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


def _files(name: str, found: Findings, *, written_sheet: bool) -> dict[str, str]:
    """Every file but the logs, by its path below the folder."""
    files = {
        "README.txt": stubs.template("README.txt.jinja", name=name),
        "Snakefile": stubs.template("Snakefile"),
        "profiles/default/config.yaml": (HOME / "profiles/default/config.yaml").read_text("utf-8"),
        "config/config.yaml": stubs.template("config.yaml.jinja", name=name),
        f"config/campaigns/{name}.yaml": stubs.campaign_yaml(name, found),
    }
    for rig in found.rigs:
        if rig not in shipped("rigs").values():
            files[f"config/rigs/{rig}.yaml"] = stubs.template(
                "rig.yaml.jinja", name=rig, found=found
            )
    for oil in found.oils:
        if oil not in shipped("oils").values():
            files[f"config/oils/{oil}.yaml"] = stubs.oil_yaml(oil, found)
    if written_sheet:
        files[f"data/raw/{name}/runs.csv"] = stubs.run_sheet(found)
    return files
