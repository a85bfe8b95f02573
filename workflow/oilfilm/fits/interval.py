"""How sure mu of a fitted law is, by the delta method.

Python evaluates the equations of the two ends, and the report's script is written from them
(`oilfilm.report.law_script`).

Decides: the interval of mu at a condition, wherever it is shown (`predict`, Python, explorer,
exports, figures, torque).
"""

from dataclasses import dataclass

import numpy as np
import scipy

from oilfilm.traction.expression import compiled, name, parse
from oilfilm.traction.law import FloatArray

# Lower and upper end by mu and the half width h: relative where the law is above zero, so that no
# end changes its sign; absolute elsewhere.
_BY = {"mu": name("mu"), "h": name("h")}
RELATIVE_ENDS = [parse(text, _BY) for text in ("mu / exp(h / mu)", "mu * exp(h / mu)")]
ABSOLUTE_ENDS = [parse(text, _BY) for text in ("mu - h", "mu + h")]
_relative_ends, _absolute_ends = compiled([*_BY], RELATIVE_ENDS), compiled([*_BY], ABSOLUTE_ENDS)


def normal_quantile(level: float) -> float:
    """Standard errors to each side of a normal mean that hold a share `level`."""
    return float(scipy.special.ndtri(0.5 + level / 2))


@dataclass(frozen=True)
class Evaluated:
    """A fitted law at some points, with all that its interval needs.

    Attributes:
        mu: Traction coefficient for positive slip, shape (points,).
        gradient: Its derivatives by the internal constants, shape (points, constants).
        root: R with R R^T the covariance of the internal constants, NaN where it is not known.
    """

    mu: FloatArray
    gradient: FloatArray
    root: FloatArray

    def interval(self, level: float) -> tuple[FloatArray, FloatArray]:
        """Lower and upper end of mu, NaN where the covariance is not known.

        With the standard error s, s^2 = g^T C g of the gradient g and the covariance C, and the
        half width h = z s: mu exp(+-h/mu) where mu > 0, and mu +- h elsewhere. It says what the
        law's mean curve may be, not where one more measured point may be, and is true as far as
        the law is.

        Args:
            level: Of confidence.
        """
        half_width = normal_quantile(level) * np.linalg.norm(self.gradient @ self.root, axis=1)
        above = self.mu > 0
        # far out the interval may be endless
        with np.errstate(over="ignore"):
            relative = _relative_ends(np.where(above, self.mu, 1.0), np.where(above, half_width, 0))
        ends = np.where(above, relative, _absolute_ends(self.mu, half_width))
        return ends[0], ends[1]
