"""How sure mu of a fitted law is: where the next good run lies, and what the law's mean may be.

The first interval is conformal: curves left out of the fit say how far a run that the fit has not
seen lies from its prediction, whatever the reason, and whether or not the law is true. The second
one is the law's own, by the delta method, and holds if the law is true. The report's script is
written from the same equations (`oilfilm.report.explorer`).

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

# Lower and upper end by mu and the half width h: where the law is above zero mu exp(-+asinh(h/mu)),
# which is mu exp(-+h/mu) for a small h, changes no sign and stays near h for a tiny mu; absolute
# elsewhere.
_BY = {"mu": name("mu"), "h": name("h")}
_FACTOR = "(h + sqrt(mu*mu + h*h))"
RELATIVE_ENDS = [parse(text, _BY) for text in (f"mu*mu/{_FACTOR}", _FACTOR)]
ABSOLUTE_ENDS = [parse(text, _BY) for text in ("mu - h", "mu + h")]
_relative_ends, _absolute_ends = compiled([*_BY], RELATIVE_ENDS), compiled([*_BY], ABSOLUTE_ENDS)

# At which the interval of a further run is kept; a campaign of few runs gives the lower ones only.
LEVELS = (0.5, 0.8, 0.9, 0.95, 0.99)
_PARTS = {part: f"unseen_{part}" for part in ("absolute", "relative", "slip")}
_QUANTILES = tuple(f"unseen_quantile_{round(100 * level)}" for level in LEVELS)
# A part of the model of errors, no limit: traction below this share of the rms of mu is as
# uncertain as at this share.
_SMALL_TRACTION = 0.05


def normal_quantile(level: float) -> float:
    """Standard errors to each side of a normal mean that hold a share `level`."""
    return NormalDist().inv_cdf(0.5 + level / 2)


def student_quantile(level: float, degrees: float) -> float:
    """The same of Student's distribution.

    Examples:
        >>> print(f"{student_quantile(0.95, 3):.5f} {student_quantile(0.95, np.inf):.5f}")
        3.18245 1.95996
    """
    return float(scipy.special.stdtrit(degrees, 0.5 + level / 2))


def degrees_of_spread(curves: int, terms: int) -> float:
    """Degrees of freedom of a spread by the residuals of whole curves.

    Curves less the terms of a power law, and as many again: curves with much leverage show little
    of the scatter. Of 12 curves and 4 terms, 4 are left. Those after Bell and McCaffrey are 1.2 to
    5 there, by condition, with a median of 3; with 8, intervals held the truth at 90 %.

    Reference: R. M. Bell, D. F. McCaffrey, Survey Methodology 28 (2002) 169, section 3.
    """
    return float(max(curves - 2 * terms, min(curves - terms, 1)))


@dataclass(frozen=True)
class Band:
    """What makes the half width h of an interval about mu.

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
        parts = np.column_stack([gradient @ self.reach, floor, self.relative * mu])
        # a bend is no random error: it is added to them as a whole
        half_width = np.linalg.norm(parts, axis=1) + np.linalg.norm(unseen_bend, axis=1)
        above = mu > 0
        # far out the interval may be endless
        with np.errstate(over="ignore"):
            relative = _relative_ends(np.where(above, mu, 1.0), np.where(above, half_width, 0))
        return np.where(above, relative, _absolute_ends(mu, half_width))


def between_two_levels(value: FloatArray, low: float, high: float) -> FloatArray:
    """Where a power law has what a straight line has at `value`, both through the same two levels.

    Two levels do not tell whether mu goes with the logarithm of a condition, as in the laws, or
    with the condition itself: mu at both is possible.

    Examples:
        >>> between_two_levels(np.array([25.0, 70.0, 100.0]), 25.0, 100.0).round(1).tolist()
        [25.0, 57.4, 100.0]
    """
    return np.asarray(low * (high / low) ** ((value - low) / (high - low)))


@dataclass(frozen=True)
class Unseen:
    """How far curves left out of the fit lie from their prediction.

    A point's error is measured in its expected size s,

        s^2 = absolute^2 + (relative mu)^2 + (slip S dmu/dS)^2 + e^2,

    e the law's own random standard error there.

    Attributes:
        absolute: Part of s that does not depend on mu.
        relative: Part that goes with mu.
        slip: Part that goes with S dmu/dS, as an error of the slip's scale does: where the law is
            wrong, it is most often so at small slip.
        quantiles: Of the scores, errors over s, at each of `LEVELS`; NaN where there are too few
            curves for it.
    """

    absolute: float
    relative: float
    slip: float
    quantiles: FloatArray

    def at(self, level: float) -> tuple[float, float]:
        """The highest level that the curves allow, up to `level`, and its quantile.

        NaN where they allow none.
        """
        possible = [
            (each, float(quantile))
            for each, quantile in zip(LEVELS, self.quantiles, strict=True)
            if reaches(level, each) and np.isfinite(quantile)
        ]
        return max(possible, default=(float("nan"), float("nan")))

    def columns(self) -> dict[str, float]:
        """As columns of the table `fit_quality`."""
        quantiles = dict(zip(_QUANTILES, self.quantiles.tolist(), strict=True))
        return {**{name: getattr(self, part) for part, name in _PARTS.items()}, **quantiles}

    @classmethod
    def of(cls, row: Mapping[str, Any]) -> "Unseen":
        """What `columns` wrote."""
        quantiles = np.array([row[name] for name in _QUANTILES], dtype=float)
        parts = {part: float(row[name]) for part, name in _PARTS.items()}
        return cls(**parts, quantiles=quantiles)


UNKNOWN = Unseen(np.nan, np.nan, np.nan, np.full(len(LEVELS), np.nan))


def scores_of_unseen(
    predicted: FloatArray,
    measured: FloatArray,
    by_slip: FloatArray,
    own_error: FloatArray,
    curve: IndexArray,
) -> Unseen:
    """Scores of points whose curve the fit had not seen, and their quantiles over curves.

    A new run has n + 1 equally likely ranks among n curves. A curve counts as one, however many
    points it has, because its points share the errors of the run (hierarchical conformal
    prediction): the quantile is that of points weighted by 1/(points of their curve), at the level
    (n + 1)/n times the wanted one. Where that is above 1 the curves do not allow the level.

    References: R. F. Barber et al., Ann. Stat. 49 (2021) 486 (errors of fits that have not seen the
        point); R. Dunn, L. Wasserman, A. Ramdas, J. Am. Stat. Assoc. 118 (2023) 2491 (points in
        groups); Y. Lee, R. F. Barber, R. Willett, arXiv:2306.06342 (weights of groups).

    Args:
        predicted: mu by the fit that has not seen the point's curve; NaN where there is none.
        measured: mu of each point.
        by_slip: S dmu/dS of the law at each point.
        own_error: The random standard error of that fit's mu.
        curve: Curve of each point.
    """
    known = np.isfinite(predicted) & np.isfinite(own_error)
    floats = predicted, measured, by_slip, own_error
    predicted, measured, by_slip, own_error = (each[known] for each in floats)
    curve = curve[known]
    curves = len(np.unique(curve))
    if curves < 2:
        return UNKNOWN
    parts = np.stack([np.ones_like(predicted), predicted, by_slip])
    sizes = _sizes(parts, measured - predicted, own_error)
    size = np.sqrt(sizes**2 @ parts**2 + own_error**2)
    scores = _distance(predicted, measured) / np.maximum(size, np.finfo(float).tiny)
    order = np.argsort(scores, kind="stable")
    share = np.cumsum((1 / np.bincount(curve)[curve])[order]) / curves
    wanted = np.array(LEVELS) * (curves + 1) / curves
    index = reaches(share, wanted[:, np.newaxis]).argmax(axis=1)
    quantiles = np.where(reaches(1.0, wanted), scores[order][index], np.nan)
    absolute, relative, slip = sizes.tolist()
    return Unseen(absolute, relative, slip, quantiles)


def _distance(mu: FloatArray, measured: FloatArray) -> FloatArray:
    """Half width of the interval about mu, as `Band.ends` makes it, that just holds `measured`.

    Where mu is above zero and `measured` is not, no such interval holds it; their difference then.
    """
    both = (mu > 0) & (measured > 0)
    ratio = np.where(both, measured, 1.0) / np.where(both, mu, 1.0)
    return np.where(both, mu * np.abs(ratio - 1 / ratio) / 2, np.abs(measured - mu))


def _sizes(parts: FloatArray, error: FloatArray, own_error: FloatArray) -> FloatArray:
    """Sizes of the parts of errors beside the law's own: least squares of error^2, none negative.

    Weighted by the inverse variance that errors in proportion to mu have.

    Args:
        parts: 1, mu and S dmu/dS of each point, shape (3, points).
        error: Of each point.
        own_error: The law's own standard error there.
    """
    squares = parts**2
    mean_square = np.mean(squares[1])
    variance = np.mean(error**2) * (squares[1] / mean_square + _SMALL_TRACTION**2)
    if not variance.any():
        return np.zeros(len(parts))
    beside_own = (error**2 - own_error**2) / variance
    sizes = np.sqrt(_not_negative((squares / variance).T, beside_own))
    # no point is exact, not even where there is neither traction nor a slope
    sizes[0] = max(sizes[0], _SMALL_TRACTION * float(np.sqrt(np.mean(error**2))))
    return np.asarray(sizes)


def _not_negative(columns: FloatArray, wanted: FloatArray) -> FloatArray:
    """Least squares of few columns without a negative factor: the best choice among all choices.

    Of choices that are as good, as where columns are the same, the one of fewest columns. There
    rounding would decide in `scipy.optimize.nnls`, which gives the same elsewhere.
    """
    best, largest_gain = np.zeros(columns.shape[1]), 0.0
    for choice in sorted(itertools.product((False, True), repeat=len(best)), key=sum):
        chosen = np.flatnonzero(choice)
        factors = np.linalg.lstsq(columns[:, chosen], wanted)[0]
        gain = float(wanted @ columns[:, chosen] @ factors)  # of the sum of squares
        if (factors >= 0).all() and exceeds(gain, largest_gain):
            best, largest_gain = np.zeros_like(best), gain
            best[chosen] = factors
    return best
