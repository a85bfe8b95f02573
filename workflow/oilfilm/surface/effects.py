"""Errors that the points of a run share, and the noise of each point.

Decides: how large the errors of runs are expected to be where a rig does not state them.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from oilfilm.base.units import FloatArray

# Steps of the differences that give the slopes of ln mu by ln S and by T.
_LOG_SLIP_STEP = 0.02
_TEMPERATURE_STEP_K = 1.0
# Names of the effects, in the order of the columns of a design.
EFFECTS = ("gain", "zero", "slip_scale", "temperature_k")

LogMu = Callable[[FloatArray, FloatArray], FloatArray]


@dataclass(frozen=True)
class LogNormal:
    """What is known of a standard deviation before the data: it is log-normal.

    Attributes:
        median: Median.
        ln_sd: Standard deviation of its logarithm.
        smallest: Smallest value.
        largest: Largest value.
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
class RunErrorSizes:
    """Sizes of the errors of a rig, before the data: standard deviations.

    Without repeated runs the data tell these sizes in part only, so the rig should state them.

    Attributes:
        gain: Of the traction force, relative, one error per run.
        zero: Of the zero of the force, as a traction coefficient, one error per run.
        slip_scale: Of the slide-roll ratio, relative, one error per run.
        temperature_k: Of the temperature, in K, one error per run.
        noise: Of each point's mu, relative.
        rig_gain: Of the traction force, relative, one error per rig, which all its runs share. It
            counts where the runs are of several rigs.
    """

    gain: LogNormal = LogNormal(0.008, 0.6, 1e-4, 0.2)
    zero: LogNormal = LogNormal(4e-5, 0.6, 1e-7, 5e-3)
    slip_scale: LogNormal = LogNormal(0.004, 0.6, 1e-4, 0.2)
    temperature_k: LogNormal = LogNormal(0.5, 0.6, 1e-2, 20.0)
    noise: LogNormal = LogNormal(0.003, 0.6, 5e-4, 0.2)
    rig_gain: LogNormal = LogNormal(0.01, 0.6, 1e-4, 0.2)

    def run_and_noise_sizes(self) -> tuple[LogNormal, ...]:
        """The sizes of what differs from run to run, in the order of `EFFECTS`, and the noise."""
        return (self.gain, self.zero, self.slip_scale, self.temperature_k, self.noise)


def effect_design(log_mu: LogMu, conditions: FloatArray, slip: FloatArray) -> FloatArray:
    """Change of ln mu by a unit error of each effect, shape (points, effects).

    A gain changes ln mu by 1, a zero by 1/mu, a scale of slip by d ln mu / d ln S and a temperature
    by d ln mu / dT.

    Args:
        log_mu: ln mu from conditions and slips, as the best present description has it.
        conditions: P in GPa, U in m/s and T in degC, shape (points, 3).
        slip: Slide-roll ratio, above 0, shape (points,).
    """
    mu = np.exp(log_mu(conditions, slip))
    factor = np.exp(_LOG_SLIP_STEP)
    rise_in_slip = log_mu(conditions, slip * factor) - log_mu(conditions, slip / factor)
    step = np.array([0.0, 0.0, _TEMPERATURE_STEP_K])
    rise_in_temperature = log_mu(conditions + step, slip) - log_mu(conditions - step, slip)
    return np.column_stack(
        [
            np.ones(len(slip)),
            1 / mu,
            rise_in_slip / (2 * _LOG_SLIP_STEP),
            rise_in_temperature / (2 * _TEMPERATURE_STEP_K),
        ]
    )
