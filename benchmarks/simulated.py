"""The demonstration's points of one oil with the errors of the twin's logs, for benchmarks of fits.

The errors are those of the twin's logs: what a run shares (load, temperature, zero) and what is
each plateau's own. Logs of the same size would take a minute a campaign.
"""

import numpy as np

from oilfilm.base.units import FloatArray
from oilfilm.fits.problem import CurveData
from oilfilm.settings.base import required_value
from oilfilm.settings.campaign import Twin
from oilfilm.settings.rig import Rig
from oilfilm.traction.laws.deng2026 import traction_coefficient


def simulate_curves(
    constants: FloatArray, conditions: FloatArray, twin: Twin, rig: Rig, random: np.random.Generator
) -> CurveData:
    """The accepted points of one oil as a perfect curation of the twin's logs would give them.

    Args:
        constants: The twelve constants of Eqs 7-9 that are true.
        conditions: Nominal (P in GPa, U in m/s, T in degC) of each run, shape (runs, 3).
        twin: The campaign file's `twin`.
        rig: The rig.
        random: Source of every random number.

    Raises:
        OilfilmError: The rig's geometry or the full scale of its sensors is not known.
    """
    contact = required_value(rig.contact(), "ball_radius_m", "the rig")
    full_scale = required_value(rig.full_scale, "full_scale", "the rig")
    runs, steps = len(conditions), twin.slip_steps
    slip = np.linspace(0, twin.slip_max, steps)
    control = random.standard_normal((runs, 3))
    gain, off, zero = random.standard_normal((3, runs, 1))
    pressure, speed, temperature = conditions.T[:, :, np.newaxis]
    load_n = contact.load_n(pressure) * (1 + twin.control_load * control[:, :1])
    true_pressure = pressure * np.cbrt(1 + twin.control_load * control[:, :1])
    true_speed = speed * (1 + twin.control_speed * control[:, 1:2])
    true_temperature = temperature + twin.control_temperature_c * control[:, 2:]
    mu = traction_coefficient(constants, true_pressure, true_speed, true_temperature, slip)
    # plateau and zero reference are means over as many samples as the twin's steps leave settled
    noise_n = twin.noise_of_full_scale * full_scale.traction_force_n
    noise_n /= np.sqrt(twin.sampling_rate_hz * twin.step_s / 2)
    force_n = mu * load_n + noise_n * (zero + random.standard_normal(mu.shape))
    load_gain = 1 + twin.systematic_load * gain
    measured = np.column_stack(
        [
            true_pressure * np.cbrt(load_gain),
            true_speed,
            true_temperature + twin.systematic_temperature_c * off,
        ]
    )
    return CurveData(
        measured,
        np.ravel(load_n * load_gain),
        np.repeat(np.arange(runs), steps),
        np.tile(slip, runs),
        [f"run{number:03d}" for number in range(runs)],
        (force_n / (load_n * load_gain)).ravel(),
        mu_se=np.full(runs * steps, np.nan),
        slip_se=np.full(runs * steps, np.nan),
    )
