"""The printed constants beside a campaign's own fit: errors, distances, differences in mu.

Decides: how printed and fitted constants are compared.
"""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.problem import curve_data
from oilfilm.paper.printed.statements import LAW, grid_levels
from oilfilm.settings.config import PrintedSettings
from oilfilm.traction.law import CONDITIONS, Observations, to_internal
from oilfilm.traction.laws.deng2026 import traction_coefficient
from oilfilm.units import FloatArray

_NAMES = [constant.name for constant in LAW.constants]
_ROUNDING = 1e-9
_AXES = (*CONDITIONS, "slide_roll_ratio")


def judge_printed(
    points: pd.DataFrame,
    coefficients: pd.DataFrame,
    quality: pd.DataFrame,
    printed: Mapping[str, FloatArray],
    oils: Iterable[str],
    settings: PrintedSettings,
    refits: pd.DataFrame | None = None,
) -> pd.DataFrame:
    """One row per oil that has printed constants.

    Args:
        points: Table of points; those fitted are the accepted ones.
        coefficients: Table of fitted constants.
        quality: Table of the fits' quality.
        printed: The twelve printed constants of each oil.
        oils: The campaign's oils.
        settings: Boxes of conditions and levels of the grid.
        refits: Table of refits, which gives the fitted constants' covariance; without it there is
            no joint distance.

    Returns:
        The table `printed_judged`. All judgements are null where no point was accepted. Only the
        errors are given where the conditions cannot give all twelve constants.
    """
    boxes, rows = settings.boxes.model_dump(), []
    for oil in [oil for oil in oils if oil in printed]:
        if _of(quality, oil).empty:  # fitted with another law, whose constants are others
            continue
        fitted = _of(coefficients, oil).set_index("constant").reindex(_NAMES)
        systematic = fitted["systematic_standard_error"].fillna(0.0).to_numpy()
        errors = np.hypot(fitted["standard_error"].to_numpy(), systematic)
        values = fitted["value"].to_numpy()
        off = values - printed[oil]
        # data without any noise leave errors of rounding alone, which measure nothing
        errors = np.where(errors > _ROUNDING * np.abs(values), errors, np.nan)
        of_oil = points[points["oil"] == oil]
        (printed_sse,) = squared_errors(of_oil, printed[oil][np.newaxis])
        (fitted_sse,) = _of(quality, oil)["sse"]
        rows.append(
            {
                "oil": oil,
                "n_points": of_oil["accepted"].sum(),
                "printed_sse": printed_sse,
                "fitted_sse": fitted_sse,
                **{
                    f"{name.lower()}_distance": distance
                    for name, distance in zip(_NAMES, off / errors, strict=True)
                },
                "joint_distance": _joint_distance(coefficients, refits, oil, printed[oil]),
                **{
                    f"{box}_{name}": value
                    for box in ("tested", "extrapolated")
                    for name, value in largest_difference(
                        values, printed[oil], boxes[box], settings.levels
                    ).items()
                },
            }
        )
    return tables.from_rows(rows, "printed_judged")


def largest_difference(
    fitted: FloatArray,
    printed: FloatArray,
    box: Mapping[str, Sequence[float]],
    levels: int,
) -> dict[str, float]:
    """Where in a box printed and fitted mu differ most, on a grid.

    Args:
        fitted: A0..A3, B0..B3, C0..C3; any NaN makes every answer NaN.
        printed: The same, as printed.
        box: Lowest and highest value of each condition and of `slide_roll_ratio`.
        levels: Evenly spaced levels of each.

    Returns:
        `difference` (printed - fitted), `traction_coefficient` (fitted), and the condition there.
    """
    grid = np.meshgrid(*[grid_levels(box, name, levels) for name in _AXES], indexing="ij")
    by_fit, as_printed = (traction_coefficient(values, *grid) for values in (fitted, printed))
    difference = as_printed - by_fit
    if np.isnan(difference).any():
        return dict.fromkeys(("difference", "traction_coefficient", *_AXES), np.nan)
    largest = np.unravel_index(np.argmax(np.abs(difference)), difference.shape)
    return {
        "difference": float(difference[largest]),
        "traction_coefficient": float(by_fit[largest]),
        **{name: float(axis[largest]) for name, axis in zip(_AXES, grid, strict=True)},
    }


def squared_errors(points: pd.DataFrame, constants: FloatArray) -> FloatArray:
    """Eq. 10 of sets of constants on the accepted points of one oil, as the fit takes them.

    Args:
        points: The oil's rows of the table of points.
        constants: A0..A3, B0..B3, C0..C3, shape (sets, 12).

    Returns:
        Sum of squared errors of each set; NaN where no point was accepted, or where a condition
        is unknown or not above zero.
    """
    data = curve_data(points)
    if len(data.mu) == 0 or not np.all(data.conditions > 0):
        return np.full(len(constants), np.nan)
    at = Observations(LAW.design(data.conditions), data.curve, data.slip)
    # one set at a time, so that memory does not grow with sets times points
    return np.array(
        [
            np.sum((LAW.traction(internal, at) - data.mu) ** 2)
            for internal in to_internal(LAW, constants)
        ]
    )


def _of(frame: pd.DataFrame, oil: str) -> pd.DataFrame:
    return frame[(frame["oil"] == oil) & (frame["law"] == LAW.name)]


def _joint_distance(
    coefficients: pd.DataFrame, refits: pd.DataFrame | None, oil: str, printed: FloatArray
) -> float:
    """Mahalanobis distance in the law's internal constants: ln|X0| and the exponents.

    About sqrt(12) where the printed constants are the truth. NaN without refits, or with fewer
    than give the covariance all its directions.
    """
    fitted = FittedLaw.of(_of(coefficients, oil), oil, refits).coefficients
    covariance = fitted.covariance(LAW)
    if np.isnan(covariance).any() or np.linalg.matrix_rank(covariance) < len(printed):
        return np.nan
    off = to_internal(LAW, fitted.constants) - to_internal(LAW, printed)
    return float(np.sqrt(off @ np.linalg.solve(covariance, off)))
