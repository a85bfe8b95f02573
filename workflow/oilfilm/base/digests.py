"""Digests of the code, settings and inputs behind a table.

Decides: what reruns a rule when code changes: which modules count for it, and which parts of their
text do not.
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

from oilfilm.base import studies

# Names of modules that compute no number of a table, so that a change of them reruns no rule:
# - declarations of keys: the values of settings are in the params of the rules. The modules of
#   settings that compute with these values do count;
# - messages, what refuses an oil, the command line and the code around a job;
# - reading and writing of tables, also in the module `tables` of a study: the declarations of a
#   rule's tables have their own digest. The modules of tables that compute rows or columns do
#   count;
# - the list of laws: a rule names the laws that it fits.
_MODULES_WITHOUT_NUMBERS = re.compile(
    r"oilfilm(\.(cli|run|base\.(atomic_write|digests|errors|home))(\..*)?"
    r"|\.physics\.plausible_oil"
    r"|\.settings(\.(?!(campaign|ranges|resolved|rig)\b).*)?"
    r"|\.tables(\.(?!(failed_gates|samples_content|set_points|sorted_rows)\b).*)?"
    r"|\.traction\.laws)?|\w+\.tables"
)


def file_digest(path: Path) -> str:
    """sha256 of a file's bytes, in hex."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def files_below(folder: Path) -> list[str]:
    """Paths of all files below a folder, relative to it and sorted; links are not followed."""
    paths = []
    folders = [folder]
    # no recursion: folders may be nested deeper than the call stack allows
    while folders:
        for path in folders.pop().iterdir():
            if path.is_dir() and not path.is_symlink():
                folders.append(path)
            else:
                paths.append(path.relative_to(folder).as_posix())
    return sorted(paths)


def files_of(path: Path) -> list[Path]:
    """The file itself, or all files below a folder."""
    return [path / name for name in files_below(path)] if path.is_dir() else [path]


def path_digest(path: Path) -> str:
    """sha256 of a file, or of the names and contents of all files below a folder."""
    if path.is_file():
        return file_digest(path)
    digest = hashlib.sha256()
    for name in files_below(path):
        digest.update(f"{name} {file_digest(path / name)}\n".encode())
    return digest.hexdigest()


def mapping_digest(mapping: Mapping[str, Any]) -> str:
    """sha256 of a mapping of plain values, in hex; the order of keys does not matter."""
    text = json.dumps(mapping, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()


def code_digest(script: Path, *modules: Path) -> str:
    """Digest of the code that computes the numbers of a job: its script and the modules behind it.

    Snakemake does not see that a module behind a script has changed. A rule with this digest among
    its params runs again when the code changes. It does not run again for a comment, a docstring,
    the layout or the message of an error.

    Args:
        script: The script of the rule.
        modules: Modules that the script does not import, such as that of a law which the job takes
            by name. Files of data may be among them. Comments in YAML files and in styles of
            figures do not count; of any other file every byte counts.

    Returns:
        16 hexadecimal digits.
    """
    digest = hashlib.sha256()
    for path in [script, *sorted(files_behind(script, *modules))]:
        digest.update(f"{path.name} {_file_code(path).digest}\n".encode())
    return digest.hexdigest()[:16]


def files_behind(script: Path, *modules: Path) -> set[Path]:
    """The files that count for a script.

    They are the modules that it imports, directly or indirectly, and the files of data that these
    modules read.
    """
    visited_files: set[Path] = set()
    waiting_files = [script, *modules]
    while waiting_files:
        path = waiting_files.pop()
        if path not in visited_files:
            visited_files.add(path)
            waiting_files.extend(_file_code(path).needed_files)
    return visited_files - {script}


class _FileCode(NamedTuple):
    """Digest of one file of code or data, and the files that it needs.

    Attributes:
        digest: sha256 of what the file computes or contains, in hex.
        needed_files: The files that it imports or reads.
    """

    digest: str
    needed_files: frozenset[Path]


@cache
def _file_code(path: Path) -> _FileCode:
    """Digest of a module's syntax tree, or of the content of a file of data; what it needs."""
    content = path.read_bytes()
    if path.suffix != ".py":
        digest = hashlib.sha256(_without_comments(path, content)).hexdigest()
        return _FileCode(digest, frozenset())
    gc.disable()  # collecting garbage takes a third of the time of parsing a module
    try:
        tree = ast.parse(content)
    finally:
        gc.enable()
    package = ""
    if path.is_relative_to(studies.PACKAGES):
        package = ".".join(path.parent.relative_to(studies.PACKAGES).parts)
    syntax_words: list[str] = []
    module_names: list[str] = []
    _collect_syntax(tree, package, syntax_words, module_names)
    needed_files: set[Path] = set()
    for module_name in module_names:
        needed_files.update(_module_files(module_name))
    data_files = [path.with_name(name.decode()) for name in _DATA_FILE_NAME.findall(content)]
    needed_files.update(data_file for data_file in data_files if data_file.is_file())
    digest = hashlib.sha256("\n".join(syntax_words).encode()).hexdigest()
    return _FileCode(digest, frozenset(needed_files))


def _without_comments(path: Path, content: bytes) -> bytes:
    """Content of a file of data without its comments."""
    if path.suffix == ".yaml":
        loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml is ten times as fast
        return repr(yaml.load(content, loader)).encode()  # noqa: S506
    if path.suffix == ".mplstyle":
        return b"\n".join(line for line in content.splitlines() if not line.startswith(b"#"))
    return content


# A module names a file beside it that it reads by such a string.
_DATA_FILE_NAME = re.compile(rb'"(\w+\.(?:yaml|mplstyle))"')


def _collect_syntax(
    node: ast.AST, package: str, syntax_words: list[str], module_names: list[str]
) -> None:
    """Add what a node computes to `syntax_words`, and what it imports to `module_names`.

    The words are the types of the node and of the nodes below it, the names of their fields and
    the constants in them, in the order of the source. Empty fields are left out, because newer
    versions of Python have more of them. Docstrings and the messages of errors are left out, too,
    and so are the meaning and the limits of a key of settings.
    """
    if isinstance(node, ast.Import | ast.ImportFrom):
        module_names += _imported_names(node, package)
    elif isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
        node.exc = node.exc.func
    elif isinstance(node, ast.AnnAssign) and isinstance(node.value, ast.Call):
        _keep_default_only(node.value)
    syntax_words.append(type(node).__name__)
    for field_name in node._fields:
        field_value = getattr(node, field_name, None)
        if isinstance(field_value, ast.AST):
            # ctx says whether a name is read or set; the position of the name shows this, too
            if field_name != "ctx":
                syntax_words.append(field_name)
                _collect_syntax(field_value, package, syntax_words, module_names)
        elif isinstance(field_value, list):
            has_docstring = (
                field_name == "body"
                and isinstance(node, _NODES_WITH_DOCSTRING)
                and ast.get_docstring(node, clean=False) is not None
            )
            children = field_value[1:] if has_docstring else field_value
            if children:
                syntax_words.append(field_name)
            for child in children:
                if isinstance(child, ast.AST):
                    _collect_syntax(child, package, syntax_words, module_names)
                else:
                    syntax_words.append(repr(child))
        elif field_value is not None:
            syntax_words.extend([field_name, repr(field_value)])
    syntax_words.append(")")


_NODES_WITH_DOCSTRING = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def _keep_default_only(call: ast.Call) -> None:
    """Leave of a call that declares a key of settings its default; no other part is a value."""
    if isinstance(call.func, ast.Name) and call.func.id in ("key", "optional"):
        call.args = []
        call.keywords = [keyword for keyword in call.keywords if keyword.arg == "default"]


def _imported_names(statement: ast.Import | ast.ImportFrom, package: str) -> Iterator[str]:
    """Names of modules that a statement may import: `a` and `a.b` for `from a import b`."""
    if isinstance(statement, ast.Import):
        yield from (alias.name for alias in statement.names)
        return
    module = resolve_name("." * statement.level + (statement.module or ""), package)
    yield module
    yield from (f"{module}.{alias.name}" for alias in statement.names)


@cache
def _module_files(module_name: str) -> tuple[Path, ...]:
    """Files that run when a module of oilfilm or of a study is imported.

    Modules that compute no number are left out, and so are modules of other packages.
    """
    parts = module_name.split(".")
    if parts[0] not in ("oilfilm", *studies.available()):
        return ()
    files = []
    # importing a module runs the __init__ of each package above it
    for depth in range(1, len(parts) + 1):
        if _MODULES_WITHOUT_NUMBERS.fullmatch(".".join(parts[:depth])):
            continue
        path = studies.PACKAGES.joinpath(*parts[:depth])
        files += [path.with_suffix(".py"), path / "__init__.py"]
    return tuple(file for file in files if file.is_file())
