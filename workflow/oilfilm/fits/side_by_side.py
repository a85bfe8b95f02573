"""Fits of several oils or campaigns side by side: mu at the same conditions, and ratios of mu.

Decides: the conditions at which fits are compared; the interval of a ratio of two laws; when one
oil is certainly higher.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from oilfilm.base.errors import OilfilmError
from oilfilm.base.units import FloatArray
from oilfilm.fits.conditions import LEAST_MAGNITUDES
from oilfilm.fits.fitted import SLIP, FittedLaw
from oilfilm.fits.oil_pairs import OilPair
from oilfilm.surface.ratio import RatioSurface
from oilfilm.surface.support import Support
from oilfilm.traction.law import CONDITIONS

# A value with its interval, as columns of `comparison_table`.
MU_COLUMNS = ("traction_coefficient", "obs_ci_lower", "obs_ci_upper")
RATIO_COLUMNS = ("ratio", "ratio_lower", "ratio_upper")
_PREDICTED_COLUMNS = (*MU_COLUMNS, "outside", "over_limit")
# Largest relative difference of two levels that count as one.
_SAME_LEVEL = 1e-6


def ratio_interval(
    numerator: FloatArray,
    numerator_ends: FloatArray,
    denominator: FloatArray,
    denominator_ends: FloatArray,
) -> FloatArray:
    """Interval of a ratio from the intervals of two independent positive numbers.

    Limits of the difference of logarithms are d -+ sqrt((x - x_end)^2 + (y - y_end)^2). Each limit
    takes the ends that are farthest apart. Errors that both numbers share, such as the calibration
    of one rig, cancel in a ratio. The interval is then too wide, never too narrow.

    Reference: G. Y. Zou, A. Donner, Stat. Med. 27 (2008) 1693, Eq. 4.

    Args:
        numerator: Numerators, shape (n,).
        numerator_ends: Lower and upper ends of their intervals, shape (2, n).
        denominator: Denominators, shape (n,).
        denominator_ends: Lower and upper ends of their intervals, shape (2, n).

    Returns:
        Lower and upper ends, shape (2, n); NaN where a number is unknown or not positive.

    Examples:
        Two numbers known to within a factor of e: the ratio is known to within e^sqrt(2).

        >>> one, ends = np.array([1.0]), np.exp([[-1.0], [1.0]])
        >>> np.log(ratio_interval(one, ends, one, ends)).ravel().round(4)
        array([-1.4142,  1.4142])
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        x = np.log(numerator)
        x_ends = np.log(numerator_ends)
        y = np.log(denominator)
        y_ends = np.log(denominator_ends)
        difference = x - y
    # the ratio is smallest with the lower end of x and the upper end of y
    half_width = np.hypot(x_ends - x, (y_ends - y)[::-1])
    half_width[~np.isfinite(half_width)] = np.nan
    direction = np.array([[-1.0], [1.0]])
    return np.asarray(np.exp(difference + direction * half_width))


def comparison_conditions(
    fits: Mapping[str, FittedLaw], given_conditions: Mapping[str, float]
) -> dict[str, float]:
    """Conditions for a comparison: those given, else the middle of the range that all fits tested.

    The middle of pressure, speed and load is that of their logarithms.

    Args:
        fits: Fits by name.
        given_conditions: Conditions by their columns' names.

    Returns:
        Value of each condition of the laws, by column.

    Raises:
        OilfilmError: The tested ranges of a condition do not overlap or are not known, or a given
            condition is one of no law.
    """
    condition_names = list(
        dict.fromkeys(name for fit in fits.values() for name in fit.law.conditions)
    )
    for name in given_conditions:
        if name not in condition_names:
            raise OilfilmError(f"no fit takes {name}. The laws take {', '.join(condition_names)}.")
    return {
        name: given_conditions[name]
        if name in given_conditions
        else _middle_of_condition(fits, name)
        for name in condition_names
    }


def _middle_of_condition(fits: Mapping[str, FittedLaw], condition_name: str) -> float:
    """Middle of the range that all fits tested, to three digits where these are in the range."""
    ranges = {
        label: fit.coefficients.tested_box[fit.law.conditions.index(condition_name)]
        for label, fit in fits.items()
        if condition_name in fit.law.conditions
    }
    labels_without_range = [label for label, ends in ranges.items() if np.isnan(ends).any()]
    if labels_without_range:
        raise OilfilmError(
            f"{condition_name} is not known of the runs of {', '.join(labels_without_range)}, so "
            "that there is no range that all fits tested. Leave these fits out."
        )
    lowest = max(smallest for smallest, _ in ranges.values())
    highest = min(largest for _, largest in ranges.values())
    if not lowest <= highest + _SAME_LEVEL * abs(highest):
        tested_ranges = "; ".join(
            f"{label} {smallest:.4g} to {largest:.4g}"
            for label, (smallest, largest) in ranges.items()
        )
        raise OilfilmError(
            f"the tested ranges of {condition_name} do not overlap ({tested_ranges}). "
            "Say where to compare."
        )
    # values of these conditions may be 0 or below
    has_no_logarithm = condition_name in LEAST_MAGNITUDES
    middle = (lowest + highest) / 2 if has_no_logarithm else np.sqrt(lowest * highest)
    rounded_middle = float(f"{middle:.3g}")
    return rounded_middle if lowest <= rounded_middle <= highest else float(middle)


def comparison_table(
    fits: Mapping[str, FittedLaw],
    value_by_condition: Mapping[str, float],
    slips: Sequence[float] | FloatArray,
    pairs: Mapping[str, OilPair] | None = None,
) -> pd.DataFrame:
    """mu of each fit at one operating point, and its ratio to the first fit, with their intervals.

    The intervals of mu are those of the next good run. The ratio is that of the runs where a pair
    has one, else that of the two laws, which is never certain. The ratio of the first fit to itself
    is 1.

    Args:
        fits: Fits by name.
        value_by_condition: Conditions of the operating point by their columns' names.
        slips: Slide-roll ratios.
        pairs: What the runs say of the ratio of a fit to the first one, by the name of the fit.

    Returns:
        One row per fit and slip: `fit`, `slide_roll_ratio`, `traction_coefficient`,
        `obs_ci_lower`, `obs_ci_upper`, `outside`, `over_limit`, `ratio`, `ratio_lower`,
        `ratio_upper`, `ratio_of` (`runs` or `laws`), `ratio_support` (code of `Support`),
        `ratio_outside` and `certain` (`higher`, `lower` or empty).
    """
    slip = np.asarray(slips, dtype=float)
    frames = []
    for label, fit in fits.items():
        operating_point = np.array([value_by_condition[name] for name in fit.law.conditions])
        prediction = fit.predict(
            np.broadcast_to(operating_point, (len(slip), len(operating_point))), slip
        )
        frame = pd.DataFrame({"fit": label, SLIP: slip})
        for column in _PREDICTED_COLUMNS:
            frame[column] = getattr(prediction, column)
        frames.append(frame)
    for label, frame in zip(fits, frames, strict=True):
        pair = (pairs or {}).get(label)
        if pair is not None and isinstance(pair.ratio_or_obstacle, RatioSurface):
            ratio = _ratio_by_runs(pair.ratio_or_obstacle, value_by_condition, slip)
        else:
            ratio = _ratio_by_laws(frame, frames[0])
        if frame is frames[0]:
            ratio = ratio.assign(ratio=1.0, ratio_lower=1.0, ratio_upper=1.0)
        frame[ratio.columns] = ratio
    return pd.concat(frames, ignore_index=True)


def _ratio_by_laws(frame: pd.DataFrame, first_frame: pd.DataFrame) -> pd.DataFrame:
    """The ratio of two laws with its interval, one row per slip.

    Args:
        frame: mu of a fit with its interval, one row per slip.
        first_frame: mu of the first fit, the denominator, with its interval, one row per slip.
    """
    mu, ends = _mu_magnitudes(frame)
    first_mu, first_ends = _mu_magnitudes(first_frame)
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = mu / first_mu
    lower, upper = ratio_interval(mu, ends, first_mu, first_ends)
    return pd.DataFrame(
        {
            "ratio": ratio,
            "ratio_lower": lower,
            "ratio_upper": upper,
            "ratio_of": "laws",
            "ratio_support": Support.SUPPORTED,
            "ratio_outside": frame["outside"] | first_frame["outside"],
            "certain": "",
        }
    )


def _mu_magnitudes(frame: pd.DataFrame) -> tuple[FloatArray, FloatArray]:
    """|mu|, shape (slips,), and the ends of its interval, shape (2, slips).

    Traction is odd in slip, so that a ratio is that of the sizes.
    """
    ends = frame[["obs_ci_lower", "obs_ci_upper"]].to_numpy().T
    return np.abs(frame["traction_coefficient"].to_numpy()), np.sort(np.abs(ends), axis=0)


def _ratio_by_runs(
    ratio_surface: RatioSurface, value_by_condition: Mapping[str, float], slip: FloatArray
) -> pd.DataFrame:
    """The ratio by the runs with its interval, one row per slip; nan at rolling."""
    condition_rows = np.tile([value_by_condition[name] for name in CONDITIONS], (len(slip), 1))
    # traction is odd in slip, so that a ratio is even; at rolling both mu are 0
    is_rolling = slip == 0
    prediction = ratio_surface.predict(condition_rows, np.where(is_rolling, 1.0, np.abs(slip)))
    lower, upper = prediction.interval(ratio_surface.interval_factors.point)
    columns = {"ratio": prediction.ratio, "ratio_lower": lower, "ratio_upper": upper}
    frame = pd.DataFrame(columns)
    frame[is_rolling] = np.nan
    is_known = ~prediction.is_outside
    is_certainly_higher = is_known & (frame["ratio_lower"] > 1)
    is_certainly_lower = is_known & (frame["ratio_upper"] < 1)
    return frame.assign(
        ratio_of="runs",
        ratio_support=np.where(is_rolling, Support.SUPPORTED, prediction.support_codes),
        ratio_outside=prediction.is_outside & ~is_rolling,
        certain=np.select([is_certainly_higher, is_certainly_lower], ["higher", "lower"], ""),
    )
