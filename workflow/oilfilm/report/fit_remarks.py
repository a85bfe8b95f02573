"""What whoever uses a fit must know, in sentences."""

from collections.abc import Mapping
from typing import Any

import pandas as pd

from oilfilm import tables

# A curve of which mu differs less than this as a whole is odd by its shape.
_SAME_GAIN = 0.03


def fit_remarks(quality: pd.DataFrame, residuals: pd.DataFrame) -> list[str]:
    """The verdict on each fit, and a warning where single curves pull it away.

    Args:
        quality: Table of fit quality.
        residuals: Table of curve residuals.
    """
    remarks = []
    for row in tables.rows(quality):
        remarks.append(f"{row['oil']}, {row['law']}: {row['certificate']}")
        remarks += warnings_of_fit(row, residuals)
    return remarks


def warnings_of_fit(quality: Mapping[str, Any], residuals: pd.DataFrame) -> list[str]:
    """Curves that are left out of a fit, and curves that pull it away.

    Args:
        quality: One row of the table of fit quality.
        residuals: Table of curve residuals.
    """
    oil, warnings = quality["oil"], []
    if quality["incomplete_curves"]:
        warnings.append(
            f"{oil}: WARNING: these curves are left out of the fit: "
            f"{quality['incomplete_curves']}. A condition that varied in the others is not known "
            "of them"
        )
    of_fit = (residuals["oil"] == oil) & (residuals["law"] == quality["law"])
    if pulling := pulling_curves(residuals[of_fit]):
        warnings.append(
            f"{oil}: WARNING: these curves pull the plain fit away: {pulling}. A robust fit "
            f"differs from it by {quality['robust_difference']:.2%} of mu"
        )
    return warnings


def pulling_curves(residuals: pd.DataFrame) -> str:
    """The odd curves of one oil in words, worst first.

    Args:
        residuals: The oil's rows of the table of curve residuals.
    """
    odd = residuals[residuals["odd"]].sort_values("robust_weight", kind="stable")
    return "; ".join(
        f"{row['run_id']} ({_difference(row)}{_likely(row['likely_oil'])})"
        for row in tables.rows(odd)
    )


def _difference(row: Mapping[str, Any]) -> str:
    if abs(row["gain"] - 1) < _SAME_GAIN:
        return f"of another shape: rms error of mu {row['rmse']:.1e}"
    return f"mu {row['gain']:.2f} times the fit's"


def _likely(oil: str) -> str:
    return f"; the fit of {oil} is much nearer: is the label of the run right?" if oil else ""
