"""Where the files beside the library are: rules, scripts, reference data and default settings.

In a clone this is its top folder. The wheel carries the same files in `oilfilm/shipped`.

Decides: where rules, reference data and default settings of an installed oilfilm are.
"""

from pathlib import Path

from oilfilm import studies

PACKAGE = Path(__file__).resolve().parent
_CLONE = PACKAGE.parents[1]
HOME = _CLONE if (_CLONE / "workflow" / "rules").is_dir() else PACKAGE / "shipped"
CONFIG = HOME / "config"
# The packages that results are made with, by exact version.
RUN_LOCK = "requirements/run.lock"


def reference_file(name: str) -> Path:
    """A file of data/reference or of a study's reference data, given without its ending.

    From the working folder in a clone.
    """
    path = HOME / "data/reference" / f"{name}.yaml"
    if not path.is_file():
        path = studies.reference_file(name) or path
    return path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path


def portable(path: Path) -> str:
    """A path without the folder of the installation, so that results do not depend on it.

    Nor on the prefix that another workflow gives this one, nor on where Snakemake puts the local
    copies of results that are kept in object storage.

    Examples:
        >>> portable(Path("rig/results/demo/tables/runs.parquet"))
        'results/demo/tables/runs.parquet'
    """
    if path.is_relative_to(HOME):
        return path.relative_to(HOME).as_posix()
    if not path.is_absolute():
        for at, part in enumerate(path.parts):
            if part == "results" or path.parts[at : at + 2] == ("data", "raw"):
                return Path(*path.parts[at:]).as_posix()
    return path.as_posix()
