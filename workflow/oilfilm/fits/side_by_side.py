"""Fits of several oils or campaigns side by side: mu at the same conditions, and ratios of mu.

Decides: the conditions at which fits are compared; the interval of a ratio of two mu.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from oilfilm.base.errors import OilfilmError
from oilfilm.base.units import FloatArray
from oilfilm.fits.conditions import LEAST_SIZE
from oilfilm.fits.fitted import SLIP, FittedLaw


def ratio_interval(
    values: FloatArray, ends: FloatArray, base: FloatArray, base_ends: FloatArray
) -> FloatArray:
    """Interval of values / base from the intervals of two independent positive numbers.

    Limits of the difference of logarithms, d -+ sqrt((x - x_end)^2 + (y - y_end)^2), where each
    limit takes the ends that are farthest apart. Errors that both share, such as the calibration of
    one rig, cancel in a ratio: the interval is then too wide, never too narrow.

    Reference: G. Y. Zou, A. Donner, Stat. Med. 27 (2008) 1693, Eq. 4.

    Args:
        values: Shape (n,).
        ends: Lower and upper ends of their intervals, shape (2, n).
        base: What is divided by, shape (n,).
        base_ends: Its ends, shape (2, n).

    Returns:
        Lower and upper ends, shape (2, n); NaN where a number is unknown or not positive.

    Examples:
        Two numbers known to within a factor of e: the ratio is known to within e^sqrt(2).

        >>> one, ends = np.array([1.0]), np.exp([[-1.0], [1.0]])
        >>> np.log(ratio_interval(one, ends, one, ends)).ravel().round(4)
        array([-1.4142,  1.4142])
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        x, x_ends, y, y_ends = (np.log(each) for each in (values, ends, base, base_ends))
    half = np.hypot(x_ends - x, (y_ends - y)[::-1])
    half[~np.isfinite(half)] = np.nan
    return np.asarray(np.exp(x - y + half * np.array([[-1.0], [1.0]])))


def middle_of_tested(fits: Mapping[str, FittedLaw], given: Mapping[str, float]) -> dict[str, float]:
    """Conditions for a comparison: as given, else the middle of the range that all fits tested.

    The middle of pressure, speed and load is that of their logarithms.

    Args:
        fits: Fits by name.
        given: Conditions by their columns' names.

    Raises:
        OilfilmError: The tested ranges of a condition do not overlap, or no law takes what is
            given.
    """
    wanted = list(dict.fromkeys(name for fit in fits.values() for name in fit.law.conditions))
    if odd := [name for name in given if name not in wanted]:
        raise OilfilmError(f"no fit takes {odd[0]}. The laws take {', '.join(wanted)}.")
    at = {}
    for name in wanted:
        if name in given:
            at[name] = given[name]
            continue
        ranges = {
            label: fit.coefficients.box[fit.law.conditions.index(name)]
            for label, fit in fits.items()
            if name in fit.law.conditions
        }
        low = max(smallest for smallest, _ in ranges.values())
        high = min(largest for _, largest in ranges.values())
        if not low <= high * (1 + 1e-6):
            tested = "; ".join(f"{label} {a:.4g} to {b:.4g}" for label, (a, b) in ranges.items())
            raise OilfilmError(
                f"the tested ranges of {name} do not overlap ({tested}). Say where to compare."
            )
        middle = (low + high) / 2 if name in LEAST_SIZE else np.sqrt(low * high)
        at[name] = float(f"{middle:.3g}")
    return at


def side_by_side(
    fits: Mapping[str, FittedLaw], at: Mapping[str, float], slips: Sequence[float] | FloatArray
) -> pd.DataFrame:
    """mu of each fit at one condition, and its ratio to the first fit, with their intervals.

    The intervals are those of the next good run.

    Args:
        fits: Fits by name.
        at: Conditions by their columns' names.
        slips: Slide-roll ratios.

    Returns:
        One row per fit and slip: `fit`, `slide_roll_ratio`, `traction_coefficient`,
        `obs_ci_lower`, `obs_ci_upper`, `ratio`, `ratio_lower`, `ratio_upper`, `outside`,
        `over_limit`.
    """
    slip, frames = np.asarray(slips, dtype=float), []
    for label, fit in fits.items():
        line = np.array([at[name] for name in fit.law.conditions])
        predicted = fit.predict(np.broadcast_to(line, (len(slip), len(line))), slip)
        columns = ("traction_coefficient", "obs_ci_lower", "obs_ci_upper", "outside", "over_limit")
        of_fit = {name: getattr(predicted, name) for name in columns}
        frames.append(pd.DataFrame({"fit": label, SLIP: slip, **of_fit}))
    base = frames[0]
    for frame in frames:
        mu, ends = (
            [each["traction_coefficient"].to_numpy() for each in (frame, base)],
            [each[["obs_ci_lower", "obs_ci_upper"]].to_numpy().T for each in (frame, base)],
        )
        with np.errstate(invalid="ignore", divide="ignore"):
            frame["ratio"] = mu[0] / mu[1]
        frame["ratio_lower"], frame["ratio_upper"] = ratio_interval(mu[0], ends[0], mu[1], ends[1])
    return pd.concat(frames, ignore_index=True)
