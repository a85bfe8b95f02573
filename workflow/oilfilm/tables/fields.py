"""What columns are made of: their units, bounds and descriptions."""

from collections.abc import Sequence
from typing import Any

import pandas as pd
import pandera.pandas as pa

# The end of a column's name -> its unit; the longest ending that fits counts.
_UNITS = {
    "_s": "s",
    "_n": "N",
    "_m_s": "m/s",
    "_c": "degC",
    "_systematic_c": "K",
    "_change": "1",
    "_transient": "1",
    "_asymmetry": "1",
    "_rms": "1",
    "rmse": "1",
    "sse": "1",
    "_error": "1",
    "_spread": "1",
    "_cosine": "1",
    "_traction": "1",
    "condition_number": "1",
    "_gpa": "GPa",
    "_um": "um",
    "_ratio": "1",
    "_rpm": "rpm",
    "_n_m": "N m",
    "_deg": "deg",
    "_w": "W",
    "_mm": "mm",
    "_mm_rpm": "mm rpm",
    "_slip": "1",
    "_curvature": "1",
    "_coefficient": "1",
    "_difference": "1",
    "correlation": "1",
    "signed_root": "1",
    "gain": "1",
    "_weight": "1",
    "aic": "1",
    "bic": "1",
    "_share": "1",
}
# Infinity passes a plain lower bound; no quantity of a traction rig comes near this one.
LARGEST = 1e12


def number(
    description: str, *, at_least: float = -LARGEST, at_most: float = LARGEST, gaps: bool = False
) -> Any:
    """A quantity; infinity passes no bound."""
    return pa.Field(ge=at_least, le=at_most, nullable=gaps, coerce=True, description=description)


def share(description: str, *, gaps: bool = False) -> Any:
    """A number from 0 to 1."""
    return number(description, at_least=0, at_most=1, gaps=gaps)


def count(description: str) -> Any:
    """A whole number of things, none or more."""
    return pa.Field(ge=0, coerce=True, description=description)


def text(description: str, *, one_of: tuple[str, ...] = (), gaps: bool = False) -> Any:
    """Words; only certain ones where `one_of` lists them."""
    allowed: dict[str, Any] = {"isin": list(one_of)} if one_of else {}
    return pa.Field(nullable=gaps, coerce=True, description=description, **allowed)


def flag(description: str) -> Any:
    """True or false."""
    return pa.Field(coerce=True, description=description)


class Table(pa.DataFrameModel):
    """A model whose columns are all there, in order, and no others."""

    class Config:
        """Settings that pandera reads."""

        strict = True
        ordered = True


def unit_of(column: str) -> str:
    """The unit that a column's name ends in; empty for columns without one."""
    name = column.removesuffix("_se")
    endings = [ending for ending in _UNITS if name.endswith(ending)]
    return _UNITS[max(endings, key=len)] if endings else ""


def repeated(frame: pd.DataFrame, key: Sequence[str]) -> str:
    """A complaint where rows share a key; empty where none do."""
    again = frame[frame.duplicated(list(key))]
    if again.empty:
        return ""
    first = ", ".join(f"{name} {again.iloc[0][name]}" for name in key)
    return f"{len(again)} rows repeat {' + '.join(key)}, the first at {first}"
