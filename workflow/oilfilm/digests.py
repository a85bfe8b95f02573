"""Digests of the code, settings and inputs behind a table.

Decides: what reruns a rule when code changes: which modules count for it, and what of their text
does not.
"""

import ast
import gc
import hashlib
import json
import re
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.util import resolve_name
from pathlib import Path
from typing import Any, NamedTuple

_PACKAGE = Path(__file__).parent
# What computes no number of a table: settings (their values are in the params of the rules),
# messages, what surrounds a job, reading and writing of tables (their schema version is in every
# digest) and the list of laws (a rule names those that it fits or shows).
_NO_NUMBERS = re.compile(
    r"oilfilm(\.(atomic_write|cli|digests|errors|home|run|settings)(\..*)?"
    r"|\.tables(\.(?!failed_gates|schema_version).*)?|\.\w+\.tables|\.traction\.laws)?"
)
_SCHEMA_VERSION = _PACKAGE / "tables/schema_version.py"


def file_digest(path: Path) -> str:
    """sha256 of a file's bytes, in hex."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def files_below(folder: Path) -> list[str]:
    """Paths of all files below a folder, sorted; links are not followed."""
    paths, folders = [], [folder]
    # no recursion: folders may be nested deeper than the call stack allows
    while folders:
        for path in folders.pop().iterdir():
            if path.is_dir() and not path.is_symlink():
                folders.append(path)
            else:
                paths.append(path.relative_to(folder).as_posix())
    return sorted(paths)


def input_digest(path: Path) -> str:
    """sha256 of a file, or of the names and contents of all files below a folder."""
    if path.is_file():
        return file_digest(path)
    digest = hashlib.sha256()
    for name in files_below(path):
        digest.update(f"{name} {file_digest(path / name)}\n".encode())
    return digest.hexdigest()


def settings_digest(settings: Mapping[str, Any]) -> str:
    """sha256 of plain settings, in hex; the order of keys does not matter."""
    text = json.dumps(settings, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()


def code_digest(script: Path, *modules: Path) -> str:
    """Digest of what computes the numbers of a job: its script and the modules behind it.

    Snakemake does not see that a module behind a script has changed. A rule with this digest among
    its params runs again when the code changes, and not for a comment, a docstring, the layout or
    the message of an error.

    Args:
        script: The script of the rule.
        modules: Modules that no import leads to, as that of a law which the job takes by name, and
            files of data, every byte of which counts.
    """
    digest = hashlib.sha256()
    for path in [script, *sorted(modules_behind(script, *modules))]:
        digest.update(f"{path.name} {_code(path).digest}\n".encode())
    return digest.hexdigest()[:16]


def modules_behind(script: Path, *modules: Path) -> set[Path]:
    """The modules that count for a script: those that it imports, directly or not."""
    found: set[Path] = set()
    waiting = [script, *modules, _SCHEMA_VERSION]
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting.extend(_code(path).imports)
    return found - {script}


class _Code(NamedTuple):
    digest: str
    imports: frozenset[Path]


@cache
def _code(path: Path) -> _Code:
    content = path.read_bytes()
    if path.suffix != ".py":
        return _Code(hashlib.sha256(content).hexdigest(), frozenset())
    gc.disable()  # a third of the time to parse a module
    try:
        tree = ast.parse(content)
    finally:
        gc.enable()
    inside = path.is_relative_to(_PACKAGE)
    package = ".".join(path.parent.relative_to(_PACKAGE.parent).parts) if inside else ""
    imports: set[Path] = set()
    for statement in _statements(tree):
        if isinstance(statement, ast.Raise) and isinstance(statement.exc, ast.Call):
            statement.exc = statement.exc.func  # without its message
        elif isinstance(statement, ast.Import | ast.ImportFrom):
            imports.update(*map(_module_files, _imported_names(statement, package)))
    text = _EMPTY.sub("", ast.dump(tree))
    beside = {path.with_name(name.decode()) for name in _DATA.findall(content)}
    imports.update(file for file in beside if file.is_file())
    return _Code(hashlib.sha256(text.encode()).hexdigest(), frozenset(imports))


# A module names the file beside it that it reads.
_DATA = re.compile(rb'"(\w+\.(?:yaml|mplstyle))"')
# Newer versions of Python leave empty lists out of a dump.
_EMPTY = re.compile(r"(?<=\()(\w+=\[\](, )?)+|, \w+=\[\]")


def _statements(parent: ast.AST) -> Iterator[ast.stmt]:
    """Every statement below a node; docstrings are removed."""
    for name in ("body", "orelse", "finalbody", "handlers", "cases"):
        block = getattr(parent, name, None)
        if not isinstance(block, list):  # an expression with a body
            continue
        if isinstance(parent, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            if ast.get_docstring(parent, clean=False) is not None:
                del block[0]
        for each in block:
            if isinstance(each, ast.stmt):
                yield each
            yield from _statements(each)


def _imported_names(statement: ast.Import | ast.ImportFrom, package: str) -> Iterator[str]:
    """What a statement may import: `a` and `a.b` of `from a import b`."""
    if isinstance(statement, ast.Import):
        yield from (alias.name for alias in statement.names)
        return
    module = resolve_name("." * statement.level + (statement.module or ""), package)
    yield module
    yield from (f"{module}.{alias.name}" for alias in statement.names)


@cache
def _module_files(name: str) -> tuple[Path, ...]:
    """Files that an import of a module of oilfilm runs, if they count."""
    parts = name.split(".")
    if parts[0] != _PACKAGE.name:
        return ()
    # importing a module runs the __init__ of each package above it
    names = [parts[:depth] for depth in range(1, len(parts) + 1)]
    return tuple(
        file
        for steps in names
        if not _NO_NUMBERS.fullmatch(".".join(steps))
        for file in (
            _PACKAGE.joinpath(*steps[1:]).with_suffix(".py"),
            _PACKAGE.joinpath(*steps[1:], "__init__.py"),
        )
        if file.is_file()
    )
