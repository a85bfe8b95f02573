"""Traction-rig logs to validated datasets, traction-law constants and figures.

For use in other programs: `oilfilm.read_fit(folder, oil)` and `oilfilm.predict(law, ...)`.
"""

from typing import Any

__all__ = ["predict", "read_fit"]


def __getattr__(name: str) -> Any:
    # late, so that a module that needs no SciPy does not wait for it
    if name in __all__:
        from oilfilm.fitting import fitted  # noqa: PLC0415

        return getattr(fitted, name)
    raise AttributeError(f"module 'oilfilm' has no attribute {name!r}")
