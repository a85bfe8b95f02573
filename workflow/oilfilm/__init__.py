"""Traction-rig logs to validated datasets, traction-law constants and figures.

In other programs and notebooks:

- `oilfilm.fit(P, U, T, S, mu)` fits a traction law to arrays;
- `oilfilm.fit_table("mu.csv")` does so with a table of mu;
- `oilfilm.read_fit(folder, oil)` reads a fit of the workflow;
- `oilfilm.check("data/raw/june")` judges raw logs;
- `oilfilm.predict(law, constants, P, U, T, S)` evaluates a law;
- `oilfilm.bearing_torque("mainshaft-167", load, speed, temperature)` gives a bearing's friction;
- `oilfilm.example("simulated_mu.csv")` is a file of data to begin with.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    # what editors complete and type checkers see
    from oilfilm.api.arrays import fit
    from oilfilm.api.bearing_torque import bearing_torque
    from oilfilm.api.examples import example
    from oilfilm.api.log_check import check
    from oilfilm.api.table_fit import fit_table
    from oilfilm.base.errors import OilfilmError
    from oilfilm.fits.fitted import predict, read_fit

    __version__: str

__all__ = [
    "OilfilmError",
    "__version__",
    "bearing_torque",
    "check",
    "example",
    "fit",
    "fit_table",
    "predict",
    "read_fit",
]

_MODULES = {
    "OilfilmError": "oilfilm.base.errors",
    "bearing_torque": "oilfilm.api.bearing_torque",
    "check": "oilfilm.api.log_check",
    "example": "oilfilm.api.examples",
    "fit": "oilfilm.api.arrays",
    "fit_table": "oilfilm.api.table_fit",
    "predict": "oilfilm.fits.fitted",
    "read_fit": "oilfilm.fits.fitted",
}


def __dir__() -> list[str]:
    return list(__all__)


def __getattr__(name: str) -> Any:
    # imported when it is used, so that a program that needs no SciPy does not wait for it
    if name == "__version__":
        import tomllib  # noqa: PLC0415

        from oilfilm.base.home import HOME  # noqa: PLC0415

        # importlib.metadata knows installed packages only; an unpacked archive runs without one
        return tomllib.loads((HOME / "pyproject.toml").read_text("utf-8"))["project"]["version"]
    if name in _MODULES:
        return getattr(importlib.import_module(_MODULES[name]), name)
    raise AttributeError(f"module 'oilfilm' has no attribute {name!r}")
