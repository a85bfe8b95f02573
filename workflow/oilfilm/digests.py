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

import yaml

_PACKAGE = Path(__file__).parent
# What computes no number of a table: settings (their values are in the params of the rules),
# messages, what surrounds a job, reading and writing of tables (the declarations of those that a
# rule writes have a digest of their own) and the list of laws (a rule names those that it fits).
_NO_NUMBERS = re.compile(
    r"oilfilm(\.(atomic_write|cli|digests|errors|home|run|settings)(\..*)?"
    r"|\.tables(\.(?!failed_gates).*)?|\.\w+\.tables|\.traction\.laws)?"
)


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


def files_of(path: Path) -> list[Path]:
    """A file, or all files below a folder."""
    return [path / name for name in files_below(path)] if path.is_dir() else [path]


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
            files of data. Comments in YAML files and styles of figures count for nothing; of any
            other file every byte counts.
    """
    digest = hashlib.sha256()
    for path in [script, *sorted(modules_behind(script, *modules))]:
        digest.update(f"{path.name} {_code(path).digest}\n".encode())
    return digest.hexdigest()[:16]


def modules_behind(script: Path, *modules: Path) -> set[Path]:
    """The modules that count for a script: those that it imports, directly or not."""
    found: set[Path] = set()
    waiting = [script, *modules]
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
        return _Code(hashlib.sha256(_without_comments(path, content)).hexdigest(), frozenset())
    gc.disable()  # it takes a third of the time to parse a module
    try:
        tree = ast.parse(content)
    finally:
        gc.enable()
    inside = path.is_relative_to(_PACKAGE)
    package = ".".join(path.parent.relative_to(_PACKAGE.parent).parts) if inside else ""
    text: list[str] = []
    names: list[str] = []
    _walk(tree, package, text, names)
    imports = {file for name in names for file in _module_files(name)}
    beside = {path.with_name(name.decode()) for name in _DATA.findall(content)}
    imports.update(file for file in beside if file.is_file())
    return _Code(hashlib.sha256("\n".join(text).encode()).hexdigest(), frozenset(imports))


def _without_comments(path: Path, content: bytes) -> bytes:
    """What a file of data holds beside its comments."""
    if path.suffix == ".yaml":
        loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml is ten times as fast
        return repr(yaml.load(content, loader)).encode()  # noqa: S506
    if path.suffix == ".mplstyle":
        return b"\n".join(line for line in content.splitlines() if not line.startswith(b"#"))
    return content


# A module names the file beside it that it reads.
_DATA = re.compile(rb'"(\w+\.(?:yaml|mplstyle))"')


def _walk(node: ast.AST, package: str, text: list[str], names: list[str]) -> None:
    """Add what a node computes to `text`, and what it imports to `names`.

    Empty fields are left out: newer versions of Python have more of them. So are docstrings and the
    message of an error.
    """
    if isinstance(node, ast.Import | ast.ImportFrom):
        names += _imported_names(node, package)
    elif isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
        node.exc = node.exc.func
    text.append(type(node).__name__)
    for name in node._fields:
        value = getattr(node, name, None)
        if isinstance(value, ast.AST):
            # whether a name is read or set is seen from its place
            if name != "ctx":
                text.append(name)
                _walk(value, package, text, names)
        elif isinstance(value, list):
            if name == "body" and isinstance(node, _WITH_DOCSTRING):
                value = value[ast.get_docstring(node, clean=False) is not None :]
            if value:
                text.append(name)
            for each in value:
                if isinstance(each, ast.AST):
                    _walk(each, package, text, names)
                else:
                    text.append(repr(each))
        elif value is not None:
            text += name, repr(value)
    text.append(")")


_WITH_DOCSTRING = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


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
