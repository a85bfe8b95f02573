"""Confidence of a fitted law's mean: half widths, degrees of freedom, and the band about mu.

The interval of the next run comes from the surface of measured mu (`oilfilm.surface.interval`).

Decides: the interval of a law's mean; the level of intervals and tests of fits.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from oilfilm.base.units import FloatArray

# The level of every interval and test of a fit, unless another one is given.
CONFIDENCE = 0.95


def student_half_width(level: float, degrees_of_freedom: float) -> float:
    """Half width of the interval by Student's distribution, in standard errors.

    Args:
        level: Share that the interval holds.
        degrees_of_freedom: Of the estimated standard error.

    Examples:
        >>> print(f"{student_half_width(0.95, 3):.5f} {student_half_width(0.95, np.inf):.5f}")
        3.18245 1.95996
    """
    return float(scipy.special.stdtrit(degrees_of_freedom, 0.5 + level / 2))


def spread_degrees_of_freedom(curve_count: int, term_count: int) -> float:
    """Degrees of freedom of a spread that comes from the residuals of whole curves.

    It is the number of curves less twice the number of terms of a power law, because curves with
    much leverage show little of the scatter. 12 curves and 4 terms give 4. There the degrees after
    Bell and McCaffrey are 1.2 to 5, by condition, with a median of 3. With 8 degrees, intervals of
    95 % held the truth at 90 %.

    Reference: R. M. Bell, D. F. McCaffrey, Survey Methodology 28 (2002) 169, section 3.
    """
    return float(max(curve_count - 2 * term_count, min(curve_count - term_count, 1)))


@dataclass(frozen=True)
class Band:
    """The interval of the mean curve of an oil, from the errors of a law.

    The half width h joins two parts by the root of the sum of their squares: the errors of the
    constants, which are the gradient times the error columns, and the misfit of the law.

    Attributes:
        error_columns: Independent errors of the internal constants, each times its half width; one
            column per error, shape (constants, errors).
        misfit_half_width: Half width that the misfit of the law adds, relative to mu.
    """

    error_columns: FloatArray
    misfit_half_width: float = 0.0

    def ends(self, mu: FloatArray, gradient: FloatArray) -> FloatArray:
        """Lower and upper end, shape (2, points): sqrt(mu^2 + h^2) +- h where mu > 0, else mu +- h.

        Args:
            mu: Traction coefficient for positive slip, shape (points,).
            gradient: Its derivatives by the internal constants, shape (points, constants).
        """
        half_width_of_constants = np.linalg.norm(gradient @ self.error_columns, axis=1)
        half_width = np.hypot(half_width_of_constants, self.misfit_half_width * mu)
        is_positive = mu > 0
        positive_mu = np.where(is_positive, mu, 1.0)
        positive_half_width = np.where(is_positive, half_width, 0)
        # far outside the tested conditions the interval may be infinite
        with np.errstate(over="ignore"):
            upper = positive_half_width + np.sqrt(positive_mu**2 + positive_half_width**2)
        positive_ends = np.stack([positive_mu**2 / upper, upper])
        return np.where(is_positive, positive_ends, np.stack([mu - half_width, mu + half_width]))
