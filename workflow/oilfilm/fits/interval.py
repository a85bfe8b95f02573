"""Confidence of a fitted law's mean: quantiles, degrees of freedom, and the band about mu.

The interval of the next run comes from the surface of measured mu (`oilfilm.surface.interval`).

Decides: the interval of a law's mean; the level of intervals and tests of fits.
"""

from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
import scipy

from oilfilm.base.units import FloatArray

# The level of every interval and test of a fit, where none is asked for.
CONFIDENCE = 0.95


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
    """The interval of the mean curve of an oil, from the errors of a law.

    The half width h has two parts: the length of the products of gradient and columns, and the
    misfit of the law.

    Attributes:
        error_columns: One column per error of the internal constants, times its quantile. The
            gradient of mu by the constants is multiplied by it. Shape (constants, m).
        misfit: Half width that the misfit of the law adds, relative to mu.
    """

    error_columns: FloatArray
    misfit: float = 0.0

    def ends(self, mu: FloatArray, gradient: FloatArray) -> FloatArray:
        """Lower and upper end, shape (2, points): sqrt(mu^2 + h^2) +- h where mu > 0, else mu +- h.

        Args:
            mu: Traction coefficient for positive slip, shape (points,).
            gradient: Its derivatives by the internal constants, shape (points, constants).
        """
        from_constants = np.linalg.norm(gradient @ self.error_columns, axis=1)
        half_width = np.hypot(from_constants, self.misfit * mu)
        is_positive = mu > 0
        positive_mu = np.where(is_positive, mu, 1.0)
        width_there = np.where(is_positive, half_width, 0)
        # far outside the tested conditions the interval may be infinite
        with np.errstate(over="ignore"):
            upper = width_there + np.sqrt(positive_mu**2 + width_there**2)
        relative = np.stack([positive_mu**2 / upper, upper])
        return np.where(is_positive, relative, np.stack([mu - half_width, mu + half_width]))
