"""The constants of a fit in the order of how well the data determine them, each in words.

Decides: which constants are listed first.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables

# From what the data determine to what they cannot.
_ORDER = ("known", "in step", "sign unknown", "no interval", "at a bound", "not identifiable")
DETERMINED = ("known", "in step")
# Constants that move together so closely replace each other.
_STRONG = 0.95


def by_certainty(coefficients: pd.DataFrame, correlations: pd.DataFrame) -> pd.DataFrame:
    """Constants, those first that the data determine, with a column `determined` in words.

    Args:
        coefficients: Table of coefficients.
        correlations: Table of correlations.
    """
    order = coefficients["verdict"].map(_ORDER.index).rename("order")
    ranked = coefficients.assign(order=order, place=np.arange(len(coefficients)))
    ranked["oil_place"] = pd.factorize(ranked["oil"])[0]
    ranked = ranked.sort_values(["oil_place", "order", "place"]).drop(
        columns=["oil_place", "order", "place"]
    )
    partners = _partners(correlations)
    words = [
        _words(row, partners.get((row["oil"], row["constant"]), "")) for row in tables.rows(ranked)
    ]
    return ranked.assign(determined=pd.Series(words, ranked.index, dtype=str))


def _partners(correlations: pd.DataFrame) -> dict[tuple[str, str], str]:
    """The constant with which each one moves most, where that is closely."""
    other_way = correlations.rename(columns={"constant": "other", "other": "constant"})
    both = pd.concat([correlations, other_way], ignore_index=True)
    both = both[both["correlation"].abs() >= _STRONG]
    both = both.assign(size=both["correlation"].abs()).sort_values("size", ascending=False)
    return {
        (row["oil"], row["constant"]): f"correlated {row['correlation']:.2f} with {row['other']}"
        for row in reversed(tables.rows(both))
    }


def _words(row: Mapping[str, Any], partner: str) -> str:
    beside = f"; {partner}" if partner else ""
    if row["verdict"] == "known":
        return f"yes{beside}"
    if row["verdict"] == "in step":
        return f"along the tested line only{beside}"
    if row["verdict"] == "no interval":
        return f"not known, too few runs for errors{beside}"
    if row["verdict"] == "sign unknown":
        span = f"{row['lower']:.3g} to {row['upper']:.3g}"
        return f"no, the joint interval spans {span}{beside}"
    if row["verdict"] == "at a bound":
        return "no, it is at a bound of the search"
    return "no, the conditions tested cannot give it"
