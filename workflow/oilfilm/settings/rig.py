"""The keys of config/rigs/<name>.yaml: a traction rig, as far as it is known."""

from typing import Self

from pydantic import model_validator

from oilfilm.physics.contact import reduced_modulus
from oilfilm.physics.rigs import Contact
from oilfilm.physics.roughness import combined_roughness, rq_from_ra
from oilfilm.settings.base import (
    BallRadiusM,
    Group,
    LoadN,
    PoissonRatio,
    PressureGpa,
    RelativeError,
    RoughnessUm,
    SlideRollRatio,
    SpeedMs,
    TemperatureC,
    TemperatureErrorC,
    Text,
    TrackRadiusM,
    YoungsModulusPa,
    contradiction,
    key,
)
from oilfilm.units import M_PER_UM


class Elasticity(Group):
    """Elastic constants of a body."""

    youngs_modulus_pa: YoungsModulusPa = key("Young's modulus.")
    poisson_ratio: PoissonRatio = key("Poisson's ratio.")


class FullScale(Group):
    """Full scale of the sensors."""

    load_n: LoadN = key("Load.")
    traction_force_n: LoadN = key("Traction force.")
    surface_speed_m_s: SpeedMs = key("Surface speed.")
    temperature_c: float = key("Temperature.", unit="degC", gt=0, le=2000)


class Calibration(Group):
    """Standard uncertainties of the sensors' calibration."""

    load_relative: RelativeError = key("Of the load.")
    traction_force_relative: RelativeError = key("Of the traction force.")
    speed_relative: RelativeError = key("Of the surface speeds.")
    temperature_c: TemperatureErrorC = key("Of the inlet temperature.")


class RigLimits(Group):
    """Highest levels at which the rig can run a test."""

    max_hertz_pressure_gpa: PressureGpa = key("Maximum Hertz pressure.")
    entrainment_speed_m_s: SpeedMs = key("Entrainment speed.")
    inlet_temperature_c: TemperatureC = key("Inlet temperature.")
    slide_roll_ratio: SlideRollRatio = key("Slide-roll ratio.")
    smallest_load_n: LoadN | None = key("Smallest load that the rig controls.", default=None)


class Rig(Group):
    """A ball-on-disc rig."""

    name: Text = key("What it is.")
    source: Text = key("Where the values come from.")
    ball_radius_m: BallRadiusM | None = key("Radius of the ball.", default=None)
    ball_track_radius_m: TrackRadiusM | None = key(
        "R1: spindle axis to contact on the ball.", default=None
    )
    disc_track_radius_m: TrackRadiusM | None = key(
        "R2: spindle axis to contact on the disc.", default=None
    )
    ball: Elasticity | None = key("Elastic constants of the ball.", default=None)
    disc: Elasticity | None = key("Elastic constants of the disc.", default=None)
    ball_roughness_ra_um: RoughnessUm | None = key("Ra of the ball.", default=None)
    ball_roughness_rq_um: RoughnessUm | None = key(
        "Rq of the ball where it was measured; else 1.25 Ra.", default=None
    )
    disc_roughness_ra_um: RoughnessUm | None = key("Ra of the disc.", default=None)
    disc_roughness_rq_um: RoughnessUm | None = key(
        "Rq of the disc where it was measured; else 1.25 Ra.", default=None
    )
    full_scale: FullScale | None = key("Full scale of the sensors.", default=None)
    calibration: Calibration | None = key(
        "Standard uncertainties of the sensors' calibration.", default=None
    )
    limits: RigLimits | None = key(
        "Highest levels at which the rig can run a test; `oilfilm plan` needs them.", default=None
    )

    @model_validator(mode="after")
    def _contact_is_complete(self) -> Self:
        if self.ball_radius_m is None:
            return self
        for name in ("ball", "disc", "ball_roughness_ra_um", "disc_roughness_ra_um"):
            if getattr(self, name) is None:
                raise contradiction(
                    ("ball_radius_m",),
                    f"the key {name!r} is missing, which a rig with `ball_radius_m` must have.",
                )
        return self

    def contact(self) -> Contact | None:
        """The contact of ball and disc; None where it was not recorded."""
        ball_ra_um, disc_ra_um = self.ball_roughness_ra_um, self.disc_roughness_ra_um
        if self.ball_radius_m is None or self.ball is None or self.disc is None:
            return None
        if ball_ra_um is None or disc_ra_um is None:
            return None
        ball_ra_m, disc_ra_m = ball_ra_um * M_PER_UM, disc_ra_um * M_PER_UM
        modulus_pa = reduced_modulus(
            self.ball.youngs_modulus_pa,
            self.ball.poisson_ratio,
            self.disc.youngs_modulus_pa,
            self.disc.poisson_ratio,
        )
        return Contact(
            self.ball_radius_m,
            float(modulus_pa),
            float(
                combined_roughness(
                    _rq_m(self.ball_roughness_rq_um, ball_ra_m),
                    _rq_m(self.disc_roughness_rq_um, disc_ra_m),
                )
            ),
            float(combined_roughness(ball_ra_m, disc_ra_m)),
        )


def _rq_m(measured_um: float | None, ra_m: float) -> float:
    return float(rq_from_ra(ra_m)) if measured_um is None else measured_um * M_PER_UM
