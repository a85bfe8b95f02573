"""Data that come with oilfilm, for first steps in Python.

Decides: which files are examples.
"""

from pathlib import Path

from oilfilm.base.errors import OilfilmError
from oilfilm.base.home import HOME

_PATH_BY_EXAMPLE = {
    # 162 simulated readings of mu
    "simulated_mu.csv": "docs/examples/simulated_mu.csv",
    # a program that writes 13 simulated logs
    "write_logs.py": "docs/examples/write_logs.py",
    # folder with measured sweeps of one oil; its README.md has licence and source
    "etm-slim": "data/raw/etm-slim",
}


def example(name: str) -> Path:
    """Path of a file or folder of example data, wherever oilfilm is installed.

    Args:
        name: `simulated_mu.csv` (table of mu, simulated), `write_logs.py` (writes simulated logs)
            or `etm-slim` (folder of measured logs).

    Raises:
        OilfilmError: There is no such example.

    Examples:
        >>> import oilfilm
        >>> oilfilm.example("simulated_mu.csv").is_file()
        True
    """
    if name not in _PATH_BY_EXAMPLE:
        raise OilfilmError(
            f"there is no example {name!r}; expected one of {', '.join(_PATH_BY_EXAMPLE)}."
        )
    return HOME / _PATH_BY_EXAMPLE[name]
