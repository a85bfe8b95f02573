"""The keys of config/rigs/<name>.yaml and of config/bearings/<name>.yaml.

A traction rig as far as it is known, and a ball bearing as its drawing has it.

Decides: the keys of a rig file and of a bearing file; which bearings cannot be built.
"""

import math
from collections.abc import Iterator
from typing import Literal, Self

import numpy as np
from pydantic import model_validator

from oilfilm.bearing.geometry import Bearing, Cage, OilSupply
from oilfilm.physics.contact import Contact, combined_roughness, reduced_modulus, rq_from_ra
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


_M3_S_PER_L_MIN = 1e-3 / 60


# ---------------------------------------------------------------- bearings


class BallMaterial(Elasticity):
    """Elastic constants and density."""

    density_kg_m3: q.SolidDensityKgM3 = key("Density.")


class CageKeys(Group):
    """Cage and its lands."""

    guidance: Literal["outer", "inner"] = key("Ring whose land guides the cage.")
    land_diameter_m: q.LengthM = key("Diameter of the guiding land.")
    land_width_m: q.LengthM = key("Width of both lands together.")
    land_clearance_m: q.LengthM = key("Radial clearance.")
    pocket_friction_coefficient: float = key("Of ball on pocket.", unit="1", ge=0, le=1)


class OilSupplyKeys(Group):
    """The oil that cools the bearing."""

    flow_l_min: float = key("Flow at the inlet temperature.", unit="L/min", gt=0, le=1000)
    heat_share: q.Share = key("Share of friction heat that the oil, not shaft or housing, takes.")
    outlet_weight: q.Share = key("Oil of the contacts: 0 inlet, 1 outlet temperature.", default=0.5)

    def supply(self) -> OilSupply:
        """The oil for the heat balance."""
        return OilSupply(self.flow_l_min * _M3_S_PER_L_MIN, self.heat_share, self.outlet_weight)


class BearingFile(Group):
    """A single-row ball bearing."""

    name: q.Text = key("What it is.")
    source: q.Text = key("Where the values come from.")
    assumed: q.Unique[q.Name] = key("Keys whose values the source does not give.", default=[])
    ball_diameter_m: q.LengthM = key("Diameter of a ball.")
    pitch_diameter_m: q.LengthM = key("Diameter of the circle of ball centres.")
    ball_count: int = key("Number of balls.", ge=3)
    contact_angle_deg: float = key("Unloaded contact angle.", unit="deg", ge=0, lt=90)
    inner_groove_curvature: q.GrooveCurvature = key("Inner groove radius over ball diameter.")
    outer_groove_curvature: q.GrooveCurvature = key("Outer groove radius over ball diameter.")
    ring: Elasticity = key("Elastic constants of the rings.")
    ball: BallMaterial = key("Elastic constants and density of the balls.")
    ball_roughness_ra_um: q.RoughnessUm = key("Ra of the balls.")
    race_roughness_ra_um: q.RoughnessUm = key("Ra of the races.")
    cage: CageKeys = key("Cage and its lands.")
    oil_supply: OilSupplyKeys | None = optional("Cooling oil; without it there is no heat balance.")

    @model_validator(mode="after")
    def _can_be_built(self) -> Self:
        for steps, sentence in self._impossible():
            raise contradiction(steps, sentence)
        return self

    def _impossible(self) -> Iterator[tuple[tuple[str, ...], str]]:
        """What cannot be built: the key to blame, and a sentence."""
        ball, pitch, cage = self.ball_diameter_m, self.pitch_diameter_m, self.cage
        if ball >= pitch / 2:
            room = f"less than half of the pitch diameter of {pitch:g} m"
            yield ("ball_diameter_m",), f"found {ball:g} m; expected {room}."
        most = int(math.pi / math.asin(min(ball / pitch, 1.0)))
        if self.ball_count > most:
            found = f"found {self.ball_count} balls of {ball:g} m, which overlap"
            yield ("ball_count",), f"{found}; there is room for {most}."
        land, outer = cage.land_diameter_m, cage.guidance == "outer"
        low, high = (pitch, pitch + ball) if outer else (pitch - ball, pitch)
        if not low <= land <= high or land == pitch:
            between = f"{low:g} to {high:g} m, between pitch diameter and the balls' far side"
            found = f"found {land:g} m with guidance: {cage.guidance}"
            yield ("cage", "land_diameter_m"), f"{found}; expected {between}."
        if cage.land_clearance_m >= ball / 2:
            found, most_m = f"found {cage.land_clearance_m:g} m", f"{ball / 2:g} m"
            expected = f"well below the balls' radius of {most_m}"
            yield ("cage", "land_clearance_m"), f"{found}; expected {expected}."

    def bearing(self, name: str) -> Bearing:
        """The bearing for mechanics; `name` is its file's name.

        Examples:
            The mass of a 218's ball, 22.23 mm of steel, by hand 7833 pi 0.02223^3/6:

            >>> from pathlib import Path
            >>> from oilfilm.settings.messages import load
            >>> file = Path(__file__).parents[3] / "config/bearings/harris-218.yaml"
            >>> print(f"{load(file, BearingFile).bearing('218').ball_mass_kg * 1e3:.2f} g")
            45.06 g
        """
        rq_m = [
            rq_from_ra(ra_um * M_PER_UM)
            for ra_um in (self.ball_roughness_ra_um, self.race_roughness_ra_um)
        ]
        return Bearing(
            name=name,
            ball_diameter_m=self.ball_diameter_m,
            pitch_diameter_m=self.pitch_diameter_m,
            ball_count=self.ball_count,
            contact_angle_rad=float(np.radians(self.contact_angle_deg)),
            groove_curvature=(self.inner_groove_curvature, self.outer_groove_curvature),
            reduced_modulus_pa=self.ball.reduced_modulus_with(self.ring),
            ball_density_kg_m3=self.ball.density_kg_m3,
            roughness_rq_m=float(combined_roughness(*rq_m)),
            cage=Cage(
                guided_by_outer=self.cage.guidance == "outer",
                **self.cage.model_dump(exclude={"guidance"}),
            ),
        )
