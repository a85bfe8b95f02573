"""The code that a release is made by, as files and without version control."""

import platform
import shutil
import sys
import tomllib
from collections.abc import Iterator
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from oilfilm.errors import OilfilmError
from oilfilm.home import PACKAGE
from oilfilm.releases.manifest import FileRecord, records_digest

# Configuration is not code: a release holds what it resolves to.
_CODE = ("Snakefile", "workflow", "data/reference")
_LIBRARY = "workflow/oilfilm"
_PROJECT = "oilfilm"
# A pin is a part of a release; if it counted, no release could be pinned.
PINS = "data/reference/pins"
_PINS = tuple(PINS.split("/"))


def code_files(home: Path) -> dict[str, Path]:
    """All files that a run is made by, by their path in a clone.

    Args:
        home: Folder of the workflow, as `oilfilm.home.HOME`. Where it has no library, the files of
            the installed library are named as in a clone.
    """
    trees = [(name, home / name) for name in _CODE]
    if not (home / _LIBRARY).is_dir():
        trees.append((_LIBRARY, PACKAGE))
    files = {
        "/".join((name, *path.relative_to(top).parts)): path
        for name, top in trees
        for path in _files(top)
    }
    return dict(sorted(files.items()))


def _files(path: Path) -> Iterator[Path]:
    if path.is_dir():
        if path.name == "__pycache__" or path.parts[-3:] == _PINS or path == PACKAGE / "shipped":
            return
        for below in path.iterdir():
            if not below.name.startswith("."):
                yield from _files(below)
    elif path.is_file():
        yield path


def copy_file(source: Path, target: Path) -> None:
    """Copy the content of a file; folders on the way to it are made."""
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(source, target)


def code_tree_digest(home: Path) -> str:
    """One hash over all of the code."""
    return records_digest(FileRecord.of_file(file, path) for path, file in code_files(home).items())


def environment(home: Path) -> dict[str, Any]:
    """Python, kind of machine and every package that a run may import, with versions; no host.

    Raises:
        OilfilmError: pyproject.toml cannot be read, or a package that it asks for is not installed.
    """
    try:
        project = tomllib.loads((home / "pyproject.toml").read_text(encoding="utf-8"))["project"]
        extras = project["optional-dependencies"]
        needed = (*project["dependencies"], *extras["report"], *extras["workflow"])
    except (KeyError, ValueError) as error:
        raise OilfilmError(f"pyproject.toml: cannot be read ({error}).") from error
    return {
        "python": platform.python_version(),
        # bytes are promised on one kind of machine: mathematical libraries choose by it
        "platform": f"{sys.platform} {platform.machine()}",
        "c_library": " ".join(platform.libc_ver()).strip(),
        "cpu": " ".join(np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])),
        "packages": _versions(needed),
    }


@cache
def _versions(dependencies: tuple[str, ...]) -> dict[str, str]:
    """Installed versions of these packages and of all that they need in turn."""
    requirements = [Requirement(text) for text in dependencies]
    versions: dict[str, str] = {}
    seen: set[tuple[str, frozenset[str]]] = set()
    while requirements:
        requirement = requirements.pop()
        name, extras = canonicalize_name(requirement.name), frozenset(requirement.extras)
        # one extra of the project may name another; the code itself has a digest of its own
        own = name == _PROJECT
        if own or (name, extras) in seen or not _applies(requirement, frozenset()):
            continue
        seen.add((name, extras))
        try:
            distribution = metadata.distribution(name)
        except metadata.PackageNotFoundError:
            raise OilfilmError(
                f"the package {name!r} is not installed. Run `make setup` in a clone, elsewhere "
                "`pip install 'oilfilm[workflow]'`; then again."
            ) from None
        versions[name] = distribution.version
        for text in distribution.requires or []:
            inner = Requirement(text)
            if _applies(inner, extras):
                inner.marker = None
                requirements.append(inner)
    return dict(sorted(versions.items()))


def _applies(requirement: Requirement, extras: frozenset[str]) -> bool:
    return requirement.marker is None or any(
        requirement.marker.evaluate({"extra": extra}) for extra in extras | {""}
    )
