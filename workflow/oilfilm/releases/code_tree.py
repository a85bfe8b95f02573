"""The code that makes a release, as files and without version control.

Decides: which files are the code of a release.
"""

import platform
import re
import shutil
import sys
from collections.abc import Iterator
from contextlib import suppress
from importlib import import_module, metadata
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_info

from oilfilm.base import studies
from oilfilm.base.home import PACKAGE, REQUIREMENTS_LOCK_FILE
from oilfilm.releases.manifest import Environment, FileRecord, records_digest

# Configuration is not code: a release has the resolved settings.
_PATHS_OF_CODE = ("Snakefile", "workflow", "data/reference")
_LIBRARY = "workflow/oilfilm"
# A pin is a part of a release. No release could be pinned if pins counted as code.
PINS = "data/reference/pins"


def code_files(home: Path) -> dict[str, Path]:
    """All files of code behind a run, by their path in a clone.

    Args:
        home: Folder of the workflow, as `home.HOME`. Where it has no library, the files
            of the installed packages get the paths that they have in a clone.
    """
    source_by_clone_path = {path: home / path for path in _PATHS_OF_CODE}
    if not (home / _LIBRARY).is_dir():
        source_by_clone_path[_LIBRARY] = PACKAGE
        for name in studies.available():
            source_by_clone_path[f"workflow/{name}"] = studies.folder(name)
    file_by_path = {}
    for clone_path, source in source_by_clone_path.items():
        for path in _files_of_code(source):
            path_parts = path.relative_to(source).parts
            file_by_path["/".join((clone_path, *path_parts))] = path
    return dict(sorted(file_by_path.items()))


def _files_of_code(path: Path) -> Iterator[Path]:
    """A file, or the files below a folder, without hidden files, caches, pins and copies."""
    is_pins = path.as_posix().endswith(PINS)
    if path.name == "__pycache__" or is_pins or path == PACKAGE / "shipped":
        return
    if path.is_file():
        yield path
    elif path.is_dir():
        for entry in path.iterdir():
            if not entry.name.startswith("."):
                yield from _files_of_code(entry)


def copy_file(source: Path, target: Path) -> None:
    """Copy the content of a file; missing folders of the target are made."""
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(source, target)


def code_tree_digest(home: Path) -> str:
    """One hash over all of the code."""
    return records_digest(
        FileRecord.from_file(file, path) for path, file in code_files(home).items()
    )


def environment(home: Path) -> Environment:
    """Python, kind of machine, kernels and versions of the locked packages; no host.

    The kernels are those of this process. Other steps of a run may have had another machine.
    """
    lock = (home / REQUIREMENTS_LOCK_FILE).read_text(encoding="utf-8")
    package_names = re.findall(r"^([\w.-]+)==", lock, re.MULTILINE)
    version_by_package = {}
    for package_name in package_names:
        with suppress(metadata.PackageNotFoundError):  # of another system
            version_by_package[package_name] = metadata.version(package_name)
    return Environment(
        python=platform.python_version(),
        # results have the same bytes on one kind of machine: mathematical libraries depend on it
        platform=f"{sys.platform} {platform.machine()}",
        c_library=" ".join(platform.libc_ver()).strip(),
        cpu=" ".join(np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])),
        blas=blas_libraries(),
        packages=version_by_package,
    )


def blas_libraries() -> list[str] | None:
    """BLAS libraries of NumPy and SciPy: name, version and the kernel that each has chosen.

    OpenBLAS names a kernel after the first CPU of its list that has it. For Prescott this is
    Katmai, for Zen it is Haswell. None where a kernel is not known (MKL, Accelerate).
    """
    import_module("scipy.linalg")  # loads SciPy's BLAS, which is not that of NumPy
    libraries = [library for library in threadpool_info() if library["user_api"] == "blas"]
    if not libraries or not all(library.get("architecture") for library in libraries):
        return None
    descriptions = {
        f"{library['internal_api']} {library['version']} {library['architecture']}"
        for library in libraries
    }
    return sorted(descriptions)
