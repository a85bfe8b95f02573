"""What whoever uses a fit must know, in sentences."""

from collections.abc import Mapping
from typing import Any

import pandas as pd

from oilfilm.errors import OilfilmError


def fit_remarks(quality: Mapping[str, Any]) -> list[str]:
    """The verdict on one fit, and a warning where single curves pull it away.

    Args:
        quality: One row of the table of fit quality.
    """
    remarks = [f"{quality['oil']}, {quality['law']}: {quality['certificate']}"]
    if quality["incomplete_curves"]:
        remarks.append(
            f"{quality['oil']}: WARNING: these curves are left out of the fit: "
            f"{quality['incomplete_curves']}. A condition that varied in the others is not known "
            "of them"
        )
    if quality["pulling_curves"]:
        remarks.append(
            f"{quality['oil']}: WARNING: these curves pull the plain fit away: "
            f"{quality['pulling_curves']}. A robust fit differs from it by "
            f"{quality['robust_difference']:.2%} of mu"
        )
    return remarks


def certificates(quality: pd.DataFrame, allow_uncertified: bool) -> str:
    """The verdict on each fit, a line each.

    Data that could not be fitted gave no constants that anyone could mistake for proven ones:
    only a fit that gave some needs a certificate.

    Raises:
        OilfilmError: A fit has no certificate and that is not allowed.
    """
    lines = [f"{row.oil}, {row.law}: {row.certificate}" for row in quality.itertuples()]
    unproven = quality[~quality["certified"] & (quality["searches"] > 0)]
    if len(unproven) and not allow_uncertified:
        what = "; ".join(f"{row.oil}: {row.certificate}" for row in unproven.itertuples())
        raise OilfilmError(
            f"fit_quality: {len(unproven)} of {len(quality)} fits have no certificate ({what}). "
            "Their constants are in the tables, but nothing proves them. Look at the data, raise "
            "fit.searches or fit.generations, or set fit.allow_uncertified: true to go on with "
            "them."
        )
    return "\n".join(lines) + "\n"
