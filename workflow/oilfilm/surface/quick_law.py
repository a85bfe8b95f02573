"""A law fitted in a fraction of a second, as the mean of a surface.

A surface lets the constants of its law move, so they need not be the best ones. The fit of a law
with its certificate and its errors is in `oilfilm.fits`.
"""

import numpy as np
import scipy.optimize

from oilfilm.base.randomness import generator
from oilfilm.base.ties import first_smallest
from oilfilm.base.units import BoolArray, FloatArray
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.measurements import Measurements
from oilfilm.traction.law import Law

# Starts of the search, so that one poor optimum does not matter.
_STARTS = 6
# Exponents at the starts: those of traction are hardly larger.
_LARGEST_FIRST_EXPONENT = 1.5
# Residuals of ln mu far above this one count less: a bad curve must not pull the law away.
_USUAL_RESIDUAL = 0.1
_STEPS = 60


def quick_law(
    law: Law, measurements: Measurements, smallest_mu: float, start_fit: FreeLaw | None = None
) -> FreeLaw:
    """The law fitted to the logarithms of points by robust least squares.

    Exponents of conditions with one level are 0 and are not free.

    Args:
        law: A law by the maximum Hertz pressure, the speed and the temperature.
        measurements: The points.
        smallest_mu: Points of less traction do not count.
        start_fit: A fit to nearly the same points, at which the search starts.

    Raises:
        ValueError: No point has as much traction.
    """
    is_clear = measurements.mu >= smallest_mu
    if not is_clear.any():
        raise ValueError(
            f"no mu is {smallest_mu:g} or more; check the unit of mu and the zero of the rig"
        )
    conditions = measurements.point_conditions[is_clear]
    slip = measurements.slip[is_clear]
    logarithm = np.log(measurements.mu[is_clear])
    free = _free(law, measurements)
    lower = np.array([constant.lower for constant in law.constants])
    upper = np.array([constant.upper for constant in law.constants])

    def law_with_free(values: FloatArray) -> FreeLaw:
        """The law with these values of its free constants."""
        constants = law.prescribed.copy()
        constants[free] = values
        return FreeLaw(law, constants, free)

    def residuals(values: FloatArray) -> FloatArray:
        """ln(mu) of the law less the measured one, at each point."""
        return law_with_free(values).log_mu(conditions, slip) - logarithm

    def slopes(values: FloatArray) -> FloatArray:
        """Derivatives of the residuals with respect to the free constants."""
        return law_with_free(values).log_slopes(conditions, slip)

    searches = []
    for start in _starts(law) if start_fit is None else [start_fit.constants]:
        search = scipy.optimize.least_squares(
            residuals,
            np.clip(start, lower, upper)[free],
            slopes,
            bounds=(lower[free], upper[free]),
            x_scale="jac",
            loss="soft_l1",
            f_scale=_USUAL_RESIDUAL,
            max_nfev=_STEPS,
        )
        searches.append(search)
    best = int(first_smallest([search.cost for search in searches]))
    return law_with_free(searches[best].x)


def _free(law: Law, measurements: Measurements) -> BoolArray:
    """Whether each constant is fitted, shape (constants,)."""
    varies = measurements.level_numbers().max(axis=0) > 0
    groups_vary = dict(zip(law.groups, law.varied_groups(varies), strict=True))
    free = []
    for constant in law.constants:
        is_varied = constant.condition is None or groups_vary[constant.condition]
        free.append(is_varied and constant.prescribed is None)
    return np.array(free)


def _starts(law: Law) -> list[FloatArray]:
    """Internal constants at which searches start."""
    random = generator(0, "quick law", law.name)
    starts = []
    for _ in range(_STARTS):
        start = []
        for constant in law.constants:
            if constant.condition is None:
                lowest = max(constant.lower, constant.start_lower)
                start.append(random.uniform(lowest, constant.upper))
            else:
                start.append(random.uniform(-_LARGEST_FIRST_EXPONENT, _LARGEST_FIRST_EXPONENT))
        starts.append(np.array(start))
    return starts
