"""Every command that a message or a page advises exists, with its options."""

import argparse
import re
from functools import cache
from pathlib import Path

import pytest

from campaigns import ROOT, needs_study
from oilfilm.cli.parser import parser

SOURCES = [
    *(ROOT / "workflow").rglob("*.py"),
    *(ROOT / "workflow").rglob("*.smk"),
    *sorted((ROOT / "docs").rglob("*.md")),
    *(ROOT / "config").rglob("*.yaml"),
    *(path for path in (ROOT / "docs/nightly").iterdir() if path.is_file()),
    *(ROOT / "README.md", ROOT / "CONTRIBUTING.md"),
]
# A command in backquotes, or the line of a block in a page; without what comes after a pipe.
COMMAND = r"(?:\.venv/bin/)?((?:oilfilm|snakemake|make) [^`\n#|]+)"
QUOTED, LINE = re.compile(f"`{COMMAND}[^`]*`"), re.compile(f"^{COMMAND}", re.MULTILINE)
TARGETS = {
    target
    for path in (ROOT / "Makefile", *(ROOT / "make").glob("*.mk"))
    for target in re.findall(r"(?m)^([a-z-]+):", path.read_text(encoding="utf-8"))
}
BENCHMARKS = {path.stem for path in (ROOT / "benchmarks").glob("*.py")}
RULES = {
    name
    for path in (ROOT / "workflow").rglob("*")
    if path.suffix == ".smk" or path.name == "Snakefile"
    for name in re.findall(r"(?m)^\s*(?:rule|checkpoint) (\w+):", path.read_text(encoding="utf-8"))
}


def options(of: argparse.ArgumentParser) -> set[str]:
    return {name for action in of._actions for name in action.option_strings}


@cache
def known() -> dict[str, set[str]]:
    """Options of `oilfilm`, under an empty name, of each of its commands and of snakemake."""
    # imported where needed: it takes a second
    from snakemake.cli import get_argument_parser  # noqa: PLC0415

    whole = parser()
    (sub,) = (each for each in whole._actions if isinstance(each.choices, dict))
    parsers = {"": whole, **sub.choices, "snakemake": get_argument_parser()}
    return {name: options(each) for name, each in parsers.items()}


def advised(path: Path) -> list[str]:
    """The commands that a file names."""
    text = path.read_text(encoding="utf-8")
    return QUOTED.findall(text) + (LINE.findall(text) if path.suffix != ".py" else [])


def mistake(command: str) -> str:
    """What is wrong with a command; empty where it can be run."""
    # what is quoted is one word
    program, *words = re.sub(r"(['\"]).*?\1", "QUOTED", command).replace('"', " ").split()
    if not words or words[0].endswith("...") or words[0].isupper():  # any of several
        return ""
    own = words[: words.index("--")] if "--" in words else words  # the rest is for snakemake
    given = {word.partition("=")[0] for word in own if word.startswith("-")}
    plain = [word for word in words if re.fullmatch(r"[a-z][a-z_-]*", word)]
    if program == "make":
        named = {word.removeprefix("NAME=") for word in words if word.startswith("NAME=")}
        unknown = set(plain) - TARGETS | named - BENCHMARKS - {"..."}
    elif program == "snakemake":
        unknown = (given - known()[program]) | (set(plain) & {words[0]}) - RULES
    else:
        name = "" if words[0].startswith("-") else words[0]
        unknown = given - known()[name] if name in known() else {name}
    return f"{program} has no {min(unknown)}" if unknown else ""


@pytest.mark.slow
@needs_study
def test_advised_commands_exist() -> None:
    named = ((path, command) for path in SOURCES for command in advised(path))
    assert not [(path, each, why) for path, each in named if (why := mistake(each))]
