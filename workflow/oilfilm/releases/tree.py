"""The code that a release is made by, as files: no version control is asked."""

import platform
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
from oilfilm.releases.manifest import FileRecord, records_digest

# Configuration is not code: a release holds what it resolves to.
_PLACES = ("Snakefile", "workflow", "data/reference")
# A pin is a part of a release; if it counted, no release could be pinned.
PINS = "data/reference/pins"


def code_files(root: Path) -> list[str]:
    """Paths of all files that a run is made by: workflow, Snakefile and reference data."""
    return sorted(path for place in _PLACES for path in _files(root, root / place))


def _files(root: Path, place: Path) -> Iterator[str]:
    if place.is_dir():
        if place.name == "__pycache__" or place == root / PINS:
            return
        for below in place.iterdir():
            if not below.name.startswith("."):
                yield from _files(root, below)
    elif place.is_file():
        yield place.relative_to(root).as_posix()


def code_tree_digest(root: Path) -> str:
    """One hash over all of the code."""
    return records_digest(FileRecord.of(root, path) for path in code_files(root))


def environment(root: Path) -> dict[str, Any]:
    """Python, kind of machine and every package that a run may import, with versions; no host.

    Raises:
        OilfilmError: pyproject.toml cannot be read, or a package that it asks for is not installed.
    """
    try:
        project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    except (KeyError, ValueError) as error:
        raise OilfilmError(f"pyproject.toml: cannot be read ({error}).") from error
    return {
        "python": platform.python_version(),
        # bytes are promised on one kind of machine: mathematical libraries choose by it
        "platform": f"{sys.platform} {platform.machine()}",
        "c_library": " ".join(platform.libc_ver()).strip(),
        "cpu": " ".join(np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])),
        "packages": _versions(tuple(project["dependencies"])),
    }


@cache
def _versions(asked: tuple[str, ...]) -> dict[str, str]:
    """Installed versions of these packages and of all that they need in turn."""
    wanted = [Requirement(text) for text in asked]
    versions: dict[str, str] = {}
    seen: set[tuple[str, frozenset[str]]] = set()
    while wanted:
        needed = wanted.pop()
        name, extras = canonicalize_name(needed.name), frozenset(needed.extras)
        if (name, extras) in seen or not _applies(needed, frozenset()):
            continue
        seen.add((name, extras))
        try:
            found = metadata.distribution(name)
        except metadata.PackageNotFoundError:
            raise OilfilmError(
                f"the package {name!r} is not installed. Run `make setup`, then again."
            ) from None
        versions[name] = found.version
        for text in found.requires or []:
            inner = Requirement(text)
            if _applies(inner, extras):
                inner.marker = None
                wanted.append(inner)
    return dict(sorted(versions.items()))


def _applies(needed: Requirement, extras: frozenset[str]) -> bool:
    return needed.marker is None or any(
        needed.marker.evaluate({"extra": extra}) for extra in extras | {""}
    )
