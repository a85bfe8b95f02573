"""The code that a release is made by, as files and without version control.

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

from oilfilm import studies
from oilfilm.home import PACKAGE, RUN_LOCK
from oilfilm.releases.manifest import Environment, FileRecord, records_digest

# Configuration is not code: a release holds what it resolves to.
_CODE = ("Snakefile", "workflow", "data/reference")
_LIBRARY = "workflow/oilfilm"
# A pin is a part of a release; if it counted, no release could be pinned.
PINS = "data/reference/pins"


def code_files(home: Path) -> dict[str, Path]:
    """All files that a run is made by, by their path in a clone.

    Args:
        home: Folder of the workflow, as `oilfilm.home.HOME`. Where it has no library, the files of
            the installed packages are named as in a clone.
    """
    trees = [(name, home / name) for name in _CODE]
    if not (home / _LIBRARY).is_dir():
        trees.append((_LIBRARY, PACKAGE))
        trees += [(f"workflow/{name}", studies.folder(name)) for name in studies.available()]
    files = {
        "/".join((name, *path.relative_to(top).parts)): path
        for name, top in trees
        for path in _files(top)
    }
    return dict(sorted(files.items()))


def _files(path: Path) -> Iterator[Path]:
    if path.is_dir():
        if (
            path.name == "__pycache__"
            or path.as_posix().endswith(PINS)
            or path == PACKAGE / "shipped"
        ):
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
    return records_digest(FileRecord.of(file, path) for path, file in code_files(home).items())


def environment(home: Path) -> Environment:
    """Python, kind of machine, kernels and versions of the locked packages; no host.

    The kernels are those of this process: other steps of a run may have had another machine.
    """
    names = re.findall(r"^([\w.-]+)==", (home / RUN_LOCK).read_text(encoding="utf-8"), re.MULTILINE)
    versions = {}
    for name in names:
        with suppress(metadata.PackageNotFoundError):  # of another system
            versions[name] = metadata.version(name)
    return Environment(
        python=platform.python_version(),
        # bytes are promised on one kind of machine: mathematical libraries choose by it
        platform=f"{sys.platform} {platform.machine()}",
        c_library=" ".join(platform.libc_ver()).strip(),
        cpu=" ".join(np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])),
        blas=blas_libraries(),
        packages=versions,
    )


def blas_libraries() -> list[str] | None:
    """BLAS libraries of NumPy and SciPy: name, version and the kernel that each has chosen.

    OpenBLAS names a kernel after the first CPU of its list that has it: Prescott's is Katmai, that
    of Zen is Haswell. None where a kernel is not known (MKL, Accelerate).
    """
    # imported where needed: the core, which reads releases, is installed without it
    from threadpoolctl import threadpool_info  # noqa: PLC0415

    import_module("scipy.linalg")  # loads SciPy's BLAS, which is not that of NumPy
    libraries = [library for library in threadpool_info() if library["user_api"] == "blas"]
    if not libraries or not all(library.get("architecture") for library in libraries):
        return None
    parts = ("internal_api", "version", "architecture")
    return sorted({" ".join(str(library[part]) for part in parts) for library in libraries})
