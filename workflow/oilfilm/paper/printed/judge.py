"""The printed constants beside a campaign's own fit: errors, distances, differences in mu.

Decides: how printed and fitted constants are compared.
"""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.problem import curve_data
from oilfilm.settings.config import PrintedSettings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.operating_grid import AXES
from oilfilm.traction.law import Observations, to_internal
from oilfilm.traction.laws.deng2026 import DENG2026 as LAW
from oilfilm.traction.laws.deng2026 import traction_coefficient
from oilfilm.units import FloatArray

_NAMES = [constant.name for constant in LAW.constants]
_ROUNDING = 1e-9


def judge_printed(
    results: CampaignTables,
    printed: Mapping[str, FloatArray],
    oils: Iterable[str],
    settings: PrintedSettings,
) -> pd.DataFrame:
    """One row per oil that has printed constants and a fit of the paper's law.

    Args:
        results: Tables of points, coefficients, refits and fit quality, of one law per oil.
        printed: The twelve printed constants of each oil.
        oils: The campaign's oils.
        settings: Boxes of conditions and levels of the grid.

    Returns:
        The table `printed_judged`. All judgements are null where no point was accepted. Only the
        errors are given where the conditions cannot give all twelve constants. Without refits,
        which give the fitted constants' covariance, there is no joint distance.
    """
    quality = results.fit_quality[results.fit_quality["law"] == LAW.name].set_index("oil")
    rows = []
    for oil in [oil for oil in oils if oil in printed and oil in quality.index]:
        table = results.coefficients
        of_oil = table[(table["oil"] == oil) & (table["law"] == LAW.name)]
        fitted = of_oil.set_index("constant").reindex(_NAMES)
        values = fitted["value"].to_numpy()
        systematic = fitted["systematic_standard_error"].fillna(0.0).to_numpy()
        errors = np.hypot(fitted["standard_error"].to_numpy(), systematic)
        # data without any noise leave errors of rounding alone, which measure nothing
        errors = np.where(errors > _ROUNDING * np.abs(values), errors, np.nan)
        points = results.points[results.points["oil"] == oil]
        row = {
            "oil": oil,
            "n_points": points["accepted"].sum(),
            "printed_sse": squared_errors(points, printed[oil][np.newaxis])[0],
            "fitted_sse": quality.at[oil, "sse"],
            "joint_distance": _joint_distance(of_oil, results.refits, oil, printed[oil]),
        }
        for name, distance in zip(_NAMES, (values - printed[oil]) / errors, strict=True):
            row[f"{name.lower()}_distance"] = distance
        for box, levels in settings.boxes.model_dump().items():
            largest = largest_difference(values, printed[oil], levels, settings.levels)
            row |= {f"{box}_{name}": value for name, value in largest.items()}
        rows.append(row)
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
    axes = [np.linspace(box[name][0], box[name][1], levels) for name in AXES]
    grid = np.meshgrid(*axes, indexing="ij")
    by_fit = traction_coefficient(fitted, *grid)
    difference = traction_coefficient(printed, *grid) - by_fit
    found = dict(zip(AXES, grid, strict=True))
    found |= {"difference": difference, "traction_coefficient": by_fit}
    if np.isnan(difference).any():
        return dict.fromkeys(found, np.nan)
    largest = np.unravel_index(np.argmax(np.abs(difference)), difference.shape)
    return {name: float(values[largest]) for name, values in found.items()}


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
    sets = to_internal(LAW, constants)
    return np.array([np.sum((LAW.traction(internal, at) - data.mu) ** 2) for internal in sets])


def _joint_distance(
    coefficients: pd.DataFrame, refits: pd.DataFrame, oil: str, printed: FloatArray
) -> float:
    """Mahalanobis distance in the law's internal constants: ln|X0| and the exponents.

    About sqrt(12) where the printed constants are the truth. NaN without refits, or with fewer
    than give the covariance all its directions.
    """
    fitted = FittedLaw.of(coefficients, oil, refits).coefficients
    covariance = fitted.covariance(LAW)
    if np.isnan(covariance).any() or np.linalg.matrix_rank(covariance) < len(printed):
        return np.nan
    off = to_internal(LAW, fitted.constants) - to_internal(LAW, printed)
    return float(np.sqrt(off @ np.linalg.solve(covariance, off)))
