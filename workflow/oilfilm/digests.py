"""Digests of the code, settings and inputs behind a table."""

import hashlib
import json
import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from functools import cache
from importlib.util import resolve_name
from pathlib import Path
from typing import Any

_PACKAGE = Path(__file__).parent


def file_digest(path: Path) -> str:
    """sha256 of a file's bytes, in hex."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def input_digest(path: Path) -> str:
    """sha256 of a file, or of the names and contents of all files below a folder."""
    if path.is_file():
        return file_digest(path)
    digest = hashlib.sha256()
    for file in sorted(path.rglob("*")):
        if file.is_file():
            digest.update(f"{file.relative_to(path).as_posix()} {file_digest(file)}\n".encode())
    return digest.hexdigest()


def settings_digest(settings: Mapping[str, Any]) -> str:
    """sha256 of plain settings, in hex; the order of keys does not matter."""
    text = json.dumps(settings, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()


def code_digest(script: Path, *modules: Path) -> str:
    """sha256 over a script and every module of oilfilm that it imports, directly or not.

    `modules` are those that the script imports by a name that only the job knows.

    Snakemake does not see that a module behind a script has changed; a rule that carries this
    digest among its params is run again when, and only when, its own code changes.
    """
    digest = hashlib.sha256()
    # a script is beside the library in a clone and below it where it is installed: it comes first
    library = _with_imports([script, *modules]) - {script}
    for path in [script, *sorted(library)]:
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


def _with_imports(paths: Iterable[Path]) -> set[Path]:
    modules: set[Path] = set()
    waiting = list(paths)
    while waiting:
        path = waiting.pop()
        if path not in modules:
            modules.add(path)
            waiting.extend(_imported(path))
    return modules


@cache
def _imported(path: Path) -> frozenset[Path]:
    """Modules of oilfilm that a file imports; each file is read once."""
    inside = path.is_relative_to(_PACKAGE)
    package = ".".join(path.parent.relative_to(_PACKAGE.parent).parts) if inside else ""
    files: set[Path] = set()
    for name in _imported_names(path.read_text(encoding="utf-8-sig")):
        with suppress(ImportError):  # relative to no package: a script, or words of a docstring
            files.update(_module_files(resolve_name(name, package)))
    return frozenset(files)


# Found as text, because a parser would take a fifth of the time that Snakemake needs to start. If
# a docstring looks like an import, a rule may run once too often.
_IMPORT = re.compile(
    r"""(?:^|[:;])[ \t\f]*(?:
        from[ \t]*([\w.]+)[ \t]*import\b[ \t]*(\((?:[\w\s,]|\#[^\n]*+)*+\)|[^\n;]*)
        |import[ \t]+([^\n;]*)
    )""",
    re.MULTILINE | re.VERBOSE,
)
_COMMENT = re.compile(r"#[^\n]*")


def _imported_names(text: str) -> set[str]:
    """What the import statements of a text may import: `a` and `a.b` of `from a import b`."""
    found = set()
    for package, attributes, modules in _IMPORT.findall(text.replace("\\\n", " ")):
        if package:
            found.add(package)
            stem = package if package.endswith(".") else f"{package}."
            found |= {stem + name for name in re.findall(r"\w+", _COMMENT.sub("", attributes))}
        found.update(re.findall(r"[\w.]+", _COMMENT.sub("", modules)))
    return found


@cache
def _module_files(name: str) -> tuple[Path, ...]:
    parts = name.split(".")
    if parts[0] != _PACKAGE.name:
        return ()
    # importing a module runs the __init__ of each package above it
    modules = [_PACKAGE.joinpath(*parts[1:depth]) for depth in range(1, len(parts) + 1)]
    candidates = (
        file for module in modules for file in (module.with_suffix(".py"), module / "__init__.py")
    )
    return tuple(file for file in candidates if file.is_file())
