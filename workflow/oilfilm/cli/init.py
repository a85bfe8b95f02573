"""The command `oilfilm init`: a project folder, with what logs seem to hold written into it."""

import argparse
import sys
from collections.abc import Iterator
from shlex import quote

from oilfilm.cli import stubs
from oilfilm.cli.new_project import NewProject, make_project
from oilfilm.errors import printable


def run(options: argparse.Namespace) -> int:
    """Write the folder, say what was found and what is to fill in; 1 if a log cannot be read."""
    made = make_project(options.folder, options.logs, options.campaign, _progress)
    if sys.stderr.isatty():
        print("\r\x1b[K", end="", file=sys.stderr, flush=True)
    print("\n".join(map(printable, _report(made, str(options.folder)))))
    given = {path.name for path in options.logs}
    stopped = [*made.found.logs, *(log for log in made.no_logs if log.file in given)]
    return int(any(log.problem for log in stopped))


def _progress(read: int, count: int) -> None:
    """One line at a terminal, because hundreds of logs take a minute."""
    if sys.stderr.isatty():
        print(f"\r\x1b[K{read} of {count} logs read", end="", file=sys.stderr, flush=True)


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
    yield f"Then: cd {quote(folder)}; oilfilm check data/raw/{made.campaign}; oilfilm run"
