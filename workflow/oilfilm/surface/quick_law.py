"""A law fitted in a fraction of a second, as the mean of a surface.

A surface lets the constants of its law move, so they need not be the best ones. The fit of a law
with its certificate and its errors is in `oilfilm.fits`.
"""

import numpy as np
import scipy

from oilfilm.base.randomness import generator
from oilfilm.base.ties import first_smallest
from oilfilm.base.units import BoolArray, FloatArray
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.measurements import Measurements
from oilfilm.traction.law import Law

# Number of searches from different starts, so that one poor optimum does not matter.
_START_COUNT = 6
# Largest absolute value of an exponent at the starts: those of traction are hardly larger.
_LARGEST_START_EXPONENT = 1.5
# Residuals of ln mu far above this one count less: a bad curve must not pull the law away.
_USUAL_RESIDUAL = 0.1
# Largest number of evaluations of the residuals in a search.
_MAX_EVALUATIONS = 60


class NoClearTractionError(ValueError):
    """No measured mu is clear of the error of the zero."""


def quick_law(
    law: Law, measurements: Measurements, smallest_mu: float, start_fit: FreeLaw | None = None
) -> FreeLaw:
    """The law fitted to the logarithms of points by robust least squares.

    Exponents of conditions with one level are 0 and are not free.

    Args:
        law: A law of the maximum Hertz pressure, the speed and the temperature.
        measurements: The points.
        smallest_mu: Points with a smaller mu are left out.
        start_fit: A fit to nearly the same points, at which the search starts.

    Raises:
        NoClearTractionError: No point has a mu of `smallest_mu` or more.
    """
    is_clear = measurements.mu >= smallest_mu
    if not is_clear.any():
        raise NoClearTractionError(
            f"no mu is {smallest_mu:g} or more; check the unit of mu and the zero of the rig"
        )
    conditions = measurements.point_conditions[is_clear]
    slip = measurements.slip[is_clear]
    measured_log_mu = np.log(measurements.mu[is_clear])
    is_free = _is_free(law, measurements)
    lower = np.array([constant.lower for constant in law.constants])
    upper = np.array([constant.upper for constant in law.constants])

    def law_with_free(free_constants: FloatArray) -> FreeLaw:
        """The law with these values of its free constants."""
        constants = law.prescribed.copy()
        constants[is_free] = free_constants
        return FreeLaw(law, constants, is_free)

    def residuals(free_constants: FloatArray) -> FloatArray:
        """ln(mu) of the law less the measured one, at each point."""
        return law_with_free(free_constants).log_mu(conditions, slip) - measured_log_mu

    def slopes(free_constants: FloatArray) -> FloatArray:
        """Derivatives of the residuals with respect to the free constants."""
        return law_with_free(free_constants).log_slopes(conditions, slip)

    searches = []
    for start in _starts(law) if start_fit is None else [start_fit.constants]:
        search = scipy.optimize.least_squares(
            residuals,
            np.clip(start, lower, upper)[is_free],
            slopes,
            bounds=(lower[is_free], upper[is_free]),
            x_scale="jac",
            loss="soft_l1",
            f_scale=_USUAL_RESIDUAL,
            max_nfev=_MAX_EVALUATIONS,
        )
        searches.append(search)
    best_index = int(first_smallest([search.cost for search in searches]))
    return law_with_free(searches[best_index].x)


def _is_free(law: Law, measurements: Measurements) -> BoolArray:
    """Whether each constant is fitted, shape (constants,)."""
    varies = measurements.level_numbers().max(axis=0) > 0
    groups_vary = dict(zip(law.groups, law.varied_groups(varies), strict=True))
    is_free = []
    for constant in law.constants:
        is_varied = constant.group is None or groups_vary[constant.group]
        is_free.append(is_varied and constant.prescribed is None)
    return np.array(is_free)


def _starts(law: Law) -> list[FloatArray]:
    """Internal constants at which searches start."""
    random_generator = generator(0, "quick law", law.name)
    starts = []
    for _ in range(_START_COUNT):
        constants = []
        for constant in law.constants:
            if constant.group is None:
                lowest = max(constant.lower, constant.smallest_start)
                constants.append(random_generator.uniform(lowest, constant.upper))
            else:
                constants.append(
                    random_generator.uniform(-_LARGEST_START_EXPONENT, _LARGEST_START_EXPONENT)
                )
        starts.append(np.array(constants))
    return starts
