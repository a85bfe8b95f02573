"""Errors that the points of a run share (the effects of the run), and the noise of each point.

Decides: how large the errors of runs are expected to be where a rig does not state them.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from oilfilm.base.units import FloatArray

# Steps of the differences that give the slopes of ln mu by ln S and by T.
_LOG_SLIP_STEP = 0.02
_TEMPERATURE_STEP_K = 1.0
# Names of the effects of a run, in the order of the columns of `effect_design`.
EFFECT_NAMES = ("gain", "zero", "slip_scale", "temperature_k")

# Function of the conditions of points, shape (points, 3), and their slips, shape (points,). Returns
# ln mu, shape (points,).
LogMu = Callable[[FloatArray, FloatArray], FloatArray]


@dataclass(frozen=True, kw_only=True)
class LogNormal:
    """The prior of a size: a log-normal distribution between two bounds.

    Attributes:
        median: Median of the size, in its unit.
        ln_sd: Standard deviation of the natural logarithm of the size.
        smallest: Smallest size that is searched.
        largest: Largest size that is searched.
    """

    median: float
    ln_sd: float
    smallest: float
    largest: float

    def __post_init__(self) -> None:
        if not 0 < self.smallest <= self.median <= self.largest:
            raise ValueError(
                f"the median {self.median:g} is not between the smallest value {self.smallest:g} "
                f"and the largest value {self.largest:g}, all above 0"
            )
        if not self.ln_sd > 0:
            raise ValueError(f"ln_sd is {self.ln_sd:g}; expected a number above 0")


@dataclass(frozen=True)
class ErrorPriors:
    """Priors of the standard deviations of the errors of a rig.

    Without repeated runs the data show these standard deviations in part only, so the rig file
    should state them.

    Attributes:
        gain: Relative error of the traction force, the same in a whole run.
        zero: Error of the zero of the force, as a traction coefficient, the same in a whole run.
        slip_scale: Relative error of the slide-roll ratio, the same in a whole run.
        temperature_k: Error of the temperature, in K, the same in a whole run.
        noise: Relative error of mu at each point.
        rig_gain: Relative error of the traction force that all runs of a rig share. It counts where
            the runs are of several rigs.
    """

    gain: LogNormal = LogNormal(median=0.008, ln_sd=0.6, smallest=1e-4, largest=0.2)
    zero: LogNormal = LogNormal(median=4e-5, ln_sd=0.6, smallest=1e-7, largest=5e-3)
    slip_scale: LogNormal = LogNormal(median=0.004, ln_sd=0.6, smallest=1e-4, largest=0.2)
    temperature_k: LogNormal = LogNormal(median=0.5, ln_sd=0.6, smallest=1e-2, largest=20.0)
    noise: LogNormal = LogNormal(median=0.003, ln_sd=0.6, smallest=5e-4, largest=0.2)
    rig_gain: LogNormal = LogNormal(median=0.01, ln_sd=0.6, smallest=1e-4, largest=0.2)

    def run_and_noise_priors(self) -> tuple[LogNormal, ...]:
        """The priors of the effects of runs, in the order of `EFFECT_NAMES`, then of the noise."""
        return (self.gain, self.zero, self.slip_scale, self.temperature_k, self.noise)


def effect_design(log_mu: LogMu, conditions: FloatArray, slip: FloatArray) -> FloatArray:
    """Derivative of ln mu with respect to each effect, shape (points, effects).

    It is 1 for the gain, 1/mu for the zero, d ln mu / d ln S for the scale of slip and
    d ln mu / dT for the temperature.

    Args:
        log_mu: ln mu of the present surface or law, from conditions and slips.
        conditions: P in GPa, U in m/s and T in degC, shape (points, 3).
        slip: Slide-roll ratio, above 0, shape (points,).
    """
    mu = np.exp(log_mu(conditions, slip))
    slip_factor = np.exp(_LOG_SLIP_STEP)
    rise_in_slip = log_mu(conditions, slip * slip_factor) - log_mu(conditions, slip / slip_factor)
    # powers of a temperature in degC have no value at 0 and below
    step_down_k = np.where(conditions[:, 2] > _TEMPERATURE_STEP_K, _TEMPERATURE_STEP_K, 0.0)
    warmer, colder = conditions.copy(), conditions.copy()
    warmer[:, 2] += _TEMPERATURE_STEP_K
    colder[:, 2] -= step_down_k
    rise_in_temperature = log_mu(warmer, slip) - log_mu(colder, slip)
    return np.column_stack(
        [
            np.ones(len(slip)),
            1 / mu,
            rise_in_slip / (2 * _LOG_SLIP_STEP),
            rise_in_temperature / (_TEMPERATURE_STEP_K + step_down_k),
        ]
    )
