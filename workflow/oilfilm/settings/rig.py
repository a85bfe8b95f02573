"""The keys of config/rigs/<name>.yaml: a traction rig, as far as it is known.

Decides: the keys of a rig file.
"""

import math
from collections.abc import Iterator
from typing import Self

from pydantic import model_validator

from oilfilm.physics.contact import reduced_modulus
from oilfilm.physics.rigs import Contact, combined_roughness, rq_from_ra
from oilfilm.settings import quantities as q
from oilfilm.settings.base import Group, contradiction, key, optional
from oilfilm.units import M_PER_UM

# Glass; steels, ceramics and hard metals.
_MODULI_PA = (6e10, 9.5e10), (1.9e11, 7.2e11)
_RADII_M = ((0.001, 0.06),)


class Elasticity(Group):
    """Elastic constants of a body."""

    youngs_modulus_pa: q.YoungsModulusPa = key("Young's modulus.")
    poisson_ratio: q.PoissonRatio = key("Poisson's ratio.")

    def reduced_modulus_with(self, other: "Elasticity") -> float:
        """Reduced modulus of a contact of two bodies, in Pa."""
        mine, its = ((body.youngs_modulus_pa, body.poisson_ratio) for body in (self, other))
        return float(reduced_modulus(*mine, *its))


class FullScale(Group):
    """Full scale of the sensors."""

    load_n: q.LoadN = key("Load.")
    traction_force_n: q.LoadN = key("Traction force.")
    surface_speed_m_s: q.SpeedMs = key("Surface speed.")
    temperature_c: float = key("Temperature.", unit="degC", gt=0, le=2000)


class Calibration(Group):
    """Standard uncertainties of calibration."""

    load_relative: q.CalibrationError = key("Of the load.")
    traction_force_relative: q.CalibrationError = key("Of the traction force.")
    speed_relative: q.CalibrationError = key("Of the surface speeds.")
    temperature_c: q.TemperatureErrorC = key("Of the inlet temperature.")


class RigLimits(Group):
    """Highest levels at which the rig can run a test."""

    max_hertz_pressure_gpa: q.PressureGpa = key("Maximum Hertz pressure.")
    entrainment_speed_m_s: q.SpeedMs = key("Entrainment speed.")
    inlet_temperature_c: q.TemperatureC = key("Inlet temperature.")
    slide_roll_ratio: q.SlideRollRatio = key("Slide-roll ratio.")
    smallest_load_n: q.LoadN | None = optional("Smallest load that the rig controls.")


class Rig(Group):
    """A ball-on-disc rig."""

    name: q.Text = key("What it is.")
    source: q.Text = key("Where the values come from.")
    ball_radius_m: q.BallRadiusM | None = optional("Radius of the ball.")
    ball_track_radius_m: q.TrackRadiusM | None = optional("R1: spindle axis to contact, ball.")
    disc_track_radius_m: q.TrackRadiusM | None = optional("R2: spindle axis to contact, disc.")
    ball: Elasticity | None = optional("Elastic constants of the ball.")
    disc: Elasticity | None = optional("Elastic constants of the disc.")
    ball_roughness_ra_um: q.RoughnessUm | None = optional("Ra of the ball.")
    ball_roughness_rq_um: q.RoughnessUm | None = optional("Measured Rq of the ball; else 1.25 Ra.")
    disc_roughness_ra_um: q.RoughnessUm | None = optional("Ra of the disc.")
    disc_roughness_rq_um: q.RoughnessUm | None = optional("Measured Rq of the disc; else 1.25 Ra.")
    full_scale: FullScale | None = optional("Full scale of the sensors.")
    calibration: Calibration | None = optional("Standard uncertainties of calibration.")
    limits: RigLimits | None = optional("Highest levels of a test, for `oilfilm plan`.")

    @model_validator(mode="after")
    def _contact_is_complete(self) -> Self:
        if self.ball_radius_m is None:
            return self
        for name in ("ball", "disc"):
            if getattr(self, name) is None:
                raise contradiction(
                    ("ball_radius_m",),
                    f"the key {name!r} is missing, which a rig with `ball_radius_m` must have.",
                )
        return self

    def doubts(self) -> Iterator[str]:
        """What is as it seldom is, although no log contradicts it."""
        modulus = "youngs_modulus_pa"
        for name, value, usual in (
            (f"ball: {modulus}", getattr(self.ball, modulus, None), _MODULI_PA),
            (f"disc: {modulus}", getattr(self.disc, modulus, None), _MODULI_PA),
            ("ball_radius_m", self.ball_radius_m, _RADII_M),
        ):
            if value is not None and not any(low <= value <= high for low, high in usual):
                ranges = " or ".join(f"{low:g} to {high:g}" for low, high in usual)
                yield f"{name} is {value:.4g}; usual rigs have {ranges}"

    def contact(self) -> Contact | None:
        """The contact of ball and disc; None where it was not recorded.

        Pressure needs no roughness: where it was not recorded it is NaN, and lambda with it.
        """
        if self.ball_radius_m is None or self.ball is None or self.disc is None:
            return None
        rq_m = []
        for body in ("ball", "disc"):
            ra_um, rq_um = (getattr(self, f"{body}_roughness_{kind}_um") for kind in ("ra", "rq"))
            of_ra = rq_from_ra(math.nan if ra_um is None else ra_um * M_PER_UM)
            rq_m.append(float(of_ra) if rq_um is None else rq_um * M_PER_UM)
        modulus_pa = self.ball.reduced_modulus_with(self.disc)
        return Contact(self.ball_radius_m, modulus_pa, float(combined_roughness(*rq_m)))
