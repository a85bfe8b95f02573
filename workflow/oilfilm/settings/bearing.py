"""The keys of config/bearings/<name>.yaml: a ball bearing as its drawing has it.

Decides: the keys of a bearing file; which bearings cannot be built.
"""

import math
from collections.abc import Iterator
from typing import Literal, Self

import numpy as np
from pydantic import model_validator

from oilfilm.bearing.geometry import Bearing, Cage, OilSupply
from oilfilm.physics.rigs import combined_roughness, rq_from_ra
from oilfilm.settings import quantities as q
from oilfilm.settings.base import Group, contradiction, key, optional
from oilfilm.settings.rig import Elasticity
from oilfilm.units import M_PER_UM

_M3_S_PER_L_MIN = 1e-3 / 60


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
