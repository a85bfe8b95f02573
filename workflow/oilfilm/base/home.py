"""Where the files beside the library are: rules, scripts, reference data and default settings.

A clone has them in its top folder. The wheel carries the same files in `oilfilm/shipped`.

Decides: where rules, reference data and default settings of an installed oilfilm are.
"""

from pathlib import Path

from oilfilm.base import studies

# The folder of the package oilfilm.
PACKAGE = Path(__file__).resolve().parents[1]
_CLONE = PACKAGE.parents[1]
# The folder with rules, scripts, reference data and settings: a clone, or `shipped` of the package.
HOME = _CLONE if (_CLONE / "workflow" / "rules").is_dir() else PACKAGE / "shipped"
# The configuration folder with oilfilm's own settings.
CONFIG = HOME / "config"
# The packages that results are made with, by exact version; a path below HOME.
REQUIREMENTS_LOCK_FILE = "requirements/run.lock"


def reference_file(name: str) -> Path:
    """A file of data/reference or of a study's reference data, given without its ending.

    A path below the working folder is returned relative to it.
    """
    path = HOME / "data/reference" / f"{name}.yaml"
    if not path.is_file():
        path = studies.reference_file(name) or path
    return path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path


def project_path(path: Path) -> str:
    """The path below the project folder, as a text that is the same on every machine.

    What is before the project folder is left out: the folder of the installation, the prefix that
    another workflow gives this one, or the folder of Snakemake's local copies of results in object
    storage. Any other path stays as it is.

    Examples:
        >>> project_path(Path("rig/results/demo/tables/runs.parquet"))
        'results/demo/tables/runs.parquet'
    """
    if path.is_relative_to(HOME):
        return path.relative_to(HOME).as_posix()
    if not path.is_absolute():
        for start in range(len(path.parts)):
            parts_below = path.parts[start:]
            if parts_below[0] == "results" or parts_below[:2] == ("data", "raw"):
                return Path(*parts_below).as_posix()
    return path.as_posix()
