"""Campaigns simulated at once as settled points, where hundreds of campaigns are needed.

The errors are what a run shares (gain of the force, load, temperature, zero), what each point has
of its own, and what all runs of a rig share (calibration). Drifts are planted by run. Logs of the
same size would take a minute per campaign.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np
import pandas as pd

from campaigns import HEATED_FILM, oil_of, printed, rig_contact
from oilfilm import tables
from oilfilm.base.units import PA_PER_GPA, FloatArray
from oilfilm.physics.contact import Contact
from oilfilm.physics.thermal_traction import ThermalEhlConstants, thermal_ehl_traction
from oilfilm.traction.law import CONDITIONS
from oilfilm.traction.laws.deng2026 import traction_coefficient

# mu of an oil at (P in GPa, U in m/s, T in degC, S).
Truth = Callable[..., FloatArray]


def law_truth(oil: str) -> Truth:
    """The law of Deng et al. (2026) with the constants that they print for an oil."""
    return partial(traction_coefficient, printed()[oil])


def heated_film_truth(oil: str) -> Truth:
    """A thermal, shear-thinning film on the rig, which no law of oilfilm is."""
    properties, film, contact = oil_of(oil), ThermalEhlConstants(**HEATED_FILM), rig_contact()

    def traction(
        pressure_gpa: FloatArray, speed: FloatArray, temperature: FloatArray, slip: FloatArray
    ) -> FloatArray:
        bodies = contact.radius_m, contact.reduced_modulus_pa
        peak_pa = np.asarray(pressure_gpa) * PA_PER_GPA
        return thermal_ehl_traction(properties, film, peak_pa, speed, temperature, slip, *bodies)

    return traction


@dataclass(frozen=True)
class RunErrors:
    """Standard deviations of what is wrong in a run, and the errors that all runs share.

    Attributes:
        gain: Of the traction force, relative, one per run.
        load: Of the load, relative, one per run.
        temperature_c: Of the temperature, one per run.
        zero: Of the force's zero, as a traction coefficient, one per run.
        point: Of each point's mu, relative.
        common_gain: Error of the force that all runs share, relative.
        common_load: Of the load, relative.
        common_temperature_c: Of the temperature.
    """

    gain: float = 0.008
    load: float = 0.004
    temperature_c: float = 0.7
    zero: float = 5e-5
    point: float = 0.004
    common_gain: float = 0.0
    common_load: float = 0.0
    common_temperature_c: float = 0.0


@dataclass(frozen=True)
class Drift:
    """What goes wrong over the runs of a campaign, one value per run.

    Attributes:
        force: Factor on the traction force.
        load_n: Added to the load that is read.
        speed: Factor on the entrainment speed that is read.
        slip: Factor on the slide-roll ratio that is read.
        temperature_c: Added to the temperature that is read.
        other: Share of the traction that is another oil's.
    """

    force: FloatArray | float = 1.0
    load_n: FloatArray | float = 0.0
    speed: FloatArray | float = 1.0
    slip: FloatArray | float = 1.0
    temperature_c: FloatArray | float = 0.0
    other: FloatArray | float = 0.0


@dataclass(frozen=True)
class PointCampaign:
    """What a simulated campaign of settled points is made of.

    Attributes:
        truth: True traction of the oil.
        contact: The rig's.
        errors: What is wrong in each run.
        drift: What goes wrong over the runs.
        other: True traction of the oil that `drift.other` mixes in.
        slip_max: Largest slide-roll ratio.
        slip_steps: Points of a run, the first one at no slip.
    """

    truth: Truth
    contact: Contact
    errors: RunErrors = field(default_factory=RunErrors)
    drift: Drift = field(default_factory=Drift)
    other: Truth | None = None
    slip_max: float = 0.3
    slip_steps: int = 31

    def points(
        self, conditions: FloatArray, random: np.random.Generator, oil: str = "oil"
    ) -> pd.DataFrame:
        """The table of points as a perfect curation would give it, runs in the order given.

        Args:
            conditions: True (P in GPa, U in m/s, T in degC) of each run, shape (runs, 3).
            random: Source of every random number.
            oil: Name of the oil in the table.
        """
        runs, steps, errors = len(conditions), self.slip_steps, self.errors
        slip = np.broadcast_to(np.linspace(0, self.slip_max, steps), (runs, steps))
        true_levels = [np.broadcast_to(level[:, np.newaxis], slip.shape) for level in conditions.T]
        true_pressure, true_speed, true_temperature = true_levels
        mu = self.truth(*true_levels, slip)
        if self.other is not None:
            share = np.reshape(self.drift.other, (-1, 1))
            mu = (1 - share) * mu + share * self.other(*true_levels, slip)
        gain, load, temperature, zero = random.standard_normal((4, runs, 1))
        true_load = self.contact.load_n(true_pressure)
        read_load = true_load * (1 + errors.load * load + errors.common_load)
        read_load = read_load + np.reshape(self.drift.load_n, (-1, 1))
        force = mu * (1 + errors.point * random.standard_normal(mu.shape)) + errors.zero * zero
        force = force * true_load * (1 + errors.gain * gain + errors.common_gain)
        force = force * np.reshape(self.drift.force, (-1, 1))
        read_temperature = true_temperature + errors.temperature_c * temperature
        read_temperature = read_temperature + errors.common_temperature_c
        columns = {
            "max_hertz_pressure_gpa": true_pressure * np.cbrt(read_load / true_load),
            "entrainment_speed_m_s": true_speed * np.reshape(self.drift.speed, (-1, 1)),
            "inlet_temperature_c": read_temperature + np.reshape(self.drift.temperature_c, (-1, 1)),
            "load_n": read_load,
            "slide_roll_ratio": slip * np.reshape(self.drift.slip, (-1, 1)),
            "traction_force_n": force,
            "traction_coefficient": force / read_load,
        }
        rows = pd.DataFrame({name: np.ravel(values) for name, values in columns.items()})
        all_columns = tables.empty_table("points").reindex(rows.index)
        return all_columns.assign(
            **rows,
            oil=oil,
            accepted=True,
            first_row=np.tile(np.arange(steps), runs),
            run_id=np.repeat([f"run{number:03d}" for number in range(runs)], steps),
        )


def spread_conditions(
    low: FloatArray, high: FloatArray, runs: int, random: np.random.Generator
) -> FloatArray:
    """Conditions drawn evenly between two corners of the box, shape (runs, 3)."""
    return low + (high - low) * random.random((runs, len(CONDITIONS)))
