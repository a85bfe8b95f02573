"""How sure mu of a fitted law is: where the next good run lies, and what the law's mean may be.

The first interval is conformal: it comes from the errors of the prediction at curves that were left
out of the fit. It holds whatever the reason of these errors, and whether or not the law is true.
The second interval comes from the delta method and holds if the law is true. The report's script
is written from the same equations (`oilfilm.report.explorer`).

Decides: the intervals of mu at a condition, wherever they are shown (`predict`, Python, explorer,
exports, figures, torque).
"""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

import numpy as np
import scipy

from oilfilm.base.ties import exceeds, reaches
from oilfilm.base.units import FloatArray, IndexArray
from oilfilm.traction.expression import compiled, name, parse

# Lower and upper end of an interval from mu and the half width h. Where mu > 0 they are
# mu exp(-+asinh(h/mu)): mu exp(-+h/mu) for a small h, and near mu -+ h for a tiny mu, without a
# change of sign. Elsewhere they are mu -+ h.
_ARGUMENTS = {"mu": name("mu"), "h": name("h")}
_UPPER_RELATIVE_END = "(h + sqrt(mu*mu + h*h))"
RELATIVE_ENDS = [
    parse(f"mu*mu/{_UPPER_RELATIVE_END}", _ARGUMENTS),
    parse(_UPPER_RELATIVE_END, _ARGUMENTS),
]
ABSOLUTE_ENDS = [parse("mu - h", _ARGUMENTS), parse("mu + h", _ARGUMENTS)]
_relative_ends = compiled(list(_ARGUMENTS), RELATIVE_ENDS)
_absolute_ends = compiled(list(_ARGUMENTS), ABSOLUTE_ENDS)

# Confidence levels at which the interval of a further run is kept. A campaign of few runs gives
# only the lower ones.
LEVELS = (0.5, 0.8, 0.9, 0.95, 0.99)
# Columns of `fit_quality` that hold an `Unseen`.
_PART_COLUMNS = {
    "absolute": "unseen_absolute",
    "relative": "unseen_relative",
    "slip": "unseen_slip",
}
_QUANTILE_COLUMNS = tuple(f"unseen_quantile_{round(100 * level)}" for level in LEVELS)
# A part of the model of errors, no limit: traction below this share of the rms of mu is as
# uncertain as at this share.
_SMALL_TRACTION = 0.05


def normal_quantile(level: float) -> float:
    """Standard errors to each side of a normal mean that hold a share `level`."""
    return NormalDist().inv_cdf(0.5 + level / 2)


def student_quantile(level: float, degrees: float) -> float:
    """The same of Student's distribution.

    Args:
        level: Share that the interval holds.
        degrees: Degrees of freedom.

    Examples:
        >>> print(f"{student_quantile(0.95, 3):.5f} {student_quantile(0.95, np.inf):.5f}")
        3.18245 1.95996
    """
    return float(scipy.special.stdtrit(degrees, 0.5 + level / 2))


def degrees_of_spread(curves: int, terms: int) -> float:
    """Degrees of freedom of a spread that comes from the residuals of whole curves.

    The number of curves less twice the terms of a power law, because curves with much leverage show
    little of the scatter. 12 curves and 4 terms give 4. There the degrees after Bell and McCaffrey
    are 1.2 to 5, by condition, with a median of 3. With 8 degrees, intervals of 95 % held the truth
    at 90 %.

    Reference: R. M. Bell, D. F. McCaffrey, Survey Methodology 28 (2002) 169, section 3.
    """
    return float(max(curves - 2 * terms, min(curves - terms, 1)))


@dataclass(frozen=True)
class Band:
    """The parts of the half width h of an interval about mu.

        h = sqrt(absolute^2 + (relative mu)^2 + |g reach|^2) + |unseen bend|

    Attributes:
        reach: Multiplies the gradient g of mu by the internal constants, shape (constants, m).
        absolute: Part that does not depend on mu.
        relative: Part that goes with mu.
    """

    reach: FloatArray
    absolute: float = 0.0
    relative: float = 0.0

    def ends(self, mu: FloatArray, gradient: FloatArray, unseen_bend: FloatArray) -> FloatArray:
        """Lower and upper end, shape (2, points): sqrt(mu^2 + h^2) +- h where mu > 0, else mu +- h.

        Args:
            mu: Traction coefficient for positive slip, shape (points,).
            gradient: Its derivatives by the internal constants, shape (points, constants).
            unseen_bend: As of `between_two_levels`, shape (points, conditions); a part of h too.
        """
        floor = np.full(len(mu), self.absolute)
        random_parts = np.column_stack([gradient @ self.reach, floor, self.relative * mu])
        # a bend is no random error: it is added to the random parts, not to their squares
        random_width = np.linalg.norm(random_parts, axis=1)
        half_width = random_width + np.linalg.norm(unseen_bend, axis=1)
        is_positive = mu > 0
        positive_mu = np.where(is_positive, mu, 1.0)
        width_there = np.where(is_positive, half_width, 0)
        # far outside the tested conditions the interval may be infinite
        with np.errstate(over="ignore"):
            relative = _relative_ends(positive_mu, width_there)
        return np.where(is_positive, relative, _absolute_ends(mu, half_width))


def between_two_levels(value: FloatArray, low: float, high: float) -> FloatArray:
    """Condition at which a power law is equal to a straight line through the same two levels.

    Two levels do not show whether mu goes with the logarithm of a condition, as in the laws, or
    with the condition itself. Both are possible.

    Args:
        value: Condition at which the straight line is evaluated.
        low: The lower tested level.
        high: The higher tested level.

    Examples:
        >>> between_two_levels(np.array([25.0, 70.0, 100.0]), 25.0, 100.0).round(1).tolist()
        [25.0, 57.4, 100.0]
    """
    return np.asarray(low * (high / low) ** ((value - low) / (high - low)))


@dataclass(frozen=True)
class Unseen:
    """Errors of the prediction at curves that were left out of the fit.

    A point's error is divided by its expected size s,

        s^2 = absolute^2 + (relative mu)^2 + (slip S dmu/dS)^2 + e^2,

    where e is the random standard error of the law's mu. The ratio is the score of the point.

    Attributes:
        absolute: Part of s that does not depend on mu.
        relative: Part that goes with mu.
        slip: Part that goes with S dmu/dS, as an error of the slip's scale does. Where a law is
            wrong, it is most often wrong at small slip.
        quantiles: Quantile of the scores at each of `LEVELS`; NaN where the curves are too few for
            the level.
    """

    absolute: float
    relative: float
    slip: float
    quantiles: FloatArray

    def quantile_at(self, level: float) -> tuple[float, float]:
        """The highest level that the curves allow, up to `level`, and its quantile.

        NaN where they allow none.
        """
        allowed_level, allowed_quantile = float("nan"), float("nan")
        for kept_level, quantile in zip(LEVELS, self.quantiles, strict=True):
            if reaches(level, kept_level) and np.isfinite(quantile):
                allowed_level, allowed_quantile = kept_level, float(quantile)
        return allowed_level, allowed_quantile

    def columns(self) -> dict[str, float]:
        """The columns of the table `fit_quality` that hold it."""
        columns = {column: getattr(self, part) for part, column in _PART_COLUMNS.items()}
        for column, quantile in zip(_QUANTILE_COLUMNS, self.quantiles.tolist(), strict=True):
            columns[column] = quantile
        return columns

    @classmethod
    def from_columns(cls, row: Mapping[str, Any]) -> "Unseen":
        """From a row of the table `fit_quality`, as `columns` wrote it."""
        parts = {part: float(row[column]) for part, column in _PART_COLUMNS.items()}
        quantiles = np.array([row[column] for column in _QUANTILE_COLUMNS], dtype=float)
        return cls(**parts, quantiles=quantiles)


UNKNOWN = Unseen(np.nan, np.nan, np.nan, np.full(len(LEVELS), np.nan))


def scores_of_unseen(
    predicted: FloatArray,
    measured: FloatArray,
    slip_slope: FloatArray,
    law_error: FloatArray,
    curve: IndexArray,
) -> Unseen:
    """Scores of points whose curve was left out of the fit, and their quantiles over curves.

    A new run has n + 1 equally likely ranks among n curves. The points of a curve share the errors
    of the run, so a curve counts as one, however many points it has (hierarchical conformal
    prediction). The quantile is that of points weighted by 1/(points of their curve), at (n + 1)/n
    times the wanted level. Where that is above 1 the curves do not allow the level.

    References: R. F. Barber et al., Ann. Stat. 49 (2021) 486 (errors of fits that have not seen the
        point); R. Dunn, L. Wasserman, A. Ramdas, J. Am. Stat. Assoc. 118 (2023) 2491 (points in
        groups); Y. Lee, R. F. Barber, R. Willett, arXiv:2306.06342 (weights of groups).

    Args:
        predicted: mu of each point by the fit without its curve, shape (points,); NaN where there
            is no such fit.
        measured: mu of each point.
        slip_slope: S dmu/dS of the law at each point.
        law_error: The random standard error of that fit's mu.
        curve: Curve of each point.

    Returns:
        The expected sizes and the quantiles; `UNKNOWN` of fewer than two curves.
    """
    has_prediction = np.isfinite(predicted) & np.isfinite(law_error)
    predicted = predicted[has_prediction]
    measured = measured[has_prediction]
    slip_slope = slip_slope[has_prediction]
    law_error = law_error[has_prediction]
    curve = curve[has_prediction]
    curves = len(np.unique(curve))
    if curves < 2:
        return UNKNOWN
    parts = np.stack([np.ones_like(predicted), predicted, slip_slope])
    sizes = _sizes(parts, measured - predicted, law_error)
    expected_size = np.sqrt(sizes**2 @ parts**2 + law_error**2)
    scores = _distance(predicted, measured) / np.maximum(expected_size, np.finfo(float).tiny)
    order = np.argsort(scores, kind="stable")
    weight = 1 / np.bincount(curve)[curve]
    cumulative_share = np.cumsum(weight[order]) / curves
    wanted_share = np.array(LEVELS) * (curves + 1) / curves
    index = reaches(cumulative_share, wanted_share[:, np.newaxis]).argmax(axis=1)
    quantiles = np.where(reaches(1.0, wanted_share), scores[order][index], np.nan)
    absolute, relative, slip = sizes.tolist()
    return Unseen(absolute, relative, slip, quantiles)


def _distance(mu: FloatArray, measured: FloatArray) -> FloatArray:
    """Half width of the interval about mu, as `Band.ends` makes it, that just holds `measured`.

    Where mu is above zero and `measured` is not, no such interval holds it; their difference then.
    """
    both_positive = (mu > 0) & (measured > 0)
    ratio = np.where(both_positive, measured, 1.0) / np.where(both_positive, mu, 1.0)
    relative_distance = mu * np.abs(ratio - 1 / ratio) / 2
    return np.where(both_positive, relative_distance, np.abs(measured - mu))


def _sizes(parts: FloatArray, error: FloatArray, law_error: FloatArray) -> FloatArray:
    """Sizes of the parts of errors beside the law's standard error, by least squares of error^2.

    No size is negative. The weights are the inverse variances of errors in proportion to mu.

    Args:
        parts: 1, mu and S dmu/dS of each point, shape (3, points).
        error: Measured less predicted mu of each point.
        law_error: Random standard error of the law's mu at each point.

    Returns:
        Shape (3,).
    """
    squares = parts**2
    mean_square = np.mean(squares[1])
    variance = np.mean(error**2) * (squares[1] / mean_square + _SMALL_TRACTION**2)
    if not variance.any():
        return np.zeros(len(parts))
    beside_law_error = (error**2 - law_error**2) / variance
    sizes = np.sqrt(_not_negative((squares / variance).T, beside_law_error))
    # no point is exact, not even where traction and slope are zero
    sizes[0] = max(sizes[0], _SMALL_TRACTION * float(np.sqrt(np.mean(error**2))))
    return np.asarray(sizes)


def _not_negative(columns: FloatArray, wanted: FloatArray) -> FloatArray:
    """Least squares of few columns without a negative factor: every choice of columns is tried.

    Of choices that are equally good the one of fewest columns is taken, for example where columns
    are the same. In `scipy.optimize.nnls` rounding would decide there; elsewhere both are equal.

    Args:
        columns: Shape (rows, columns).
        wanted: Shape (rows,).

    Returns:
        Factors, shape (columns,).
    """
    count = columns.shape[1]
    best = np.zeros(count)
    largest_gain = 0.0
    choices = itertools.product((False, True), repeat=count)
    for choice in sorted(choices, key=sum):
        chosen = np.flatnonzero(choice)
        factors, *_ = np.linalg.lstsq(columns[:, chosen], wanted)
        # decrease of the sum of squares
        gain = float(wanted @ columns[:, chosen] @ factors)
        if (factors >= 0).all() and exceeds(gain, largest_gain):
            best = np.zeros(count)
            best[chosen] = factors
            largest_gain = gain
    return best
