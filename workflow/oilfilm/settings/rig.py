"""The keys of the files in config/rigs, config/bearings and config/oils.

Each traction rig, ball bearing and oil has one file <name>.yaml.

Decides: the keys of the files of rigs, bearings and oils; which bearings cannot be built; when the
coefficients of an oil contradict its grade.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar

import numpy as np
from pydantic import AfterValidator, Field, Strict, model_validator

from oilfilm.base.units import ABSOLUTE_ZERO_C, M_PER_UM, PA_PER_GPA
from oilfilm.bearing.geometry import Bearing, Cage, OilSupply, Rings
from oilfilm.bearing.inputs import UncertainInput
from oilfilm.physics import oils, plausible_oil
from oilfilm.physics.contact import Contact, combined_roughness, reduced_modulus, rq_from_ra
from oilfilm.physics.plausible_oil import STANDARD_RANGE_C
from oilfilm.settings import quantities as q
from oilfilm.settings.base import Group, key, key_error_at, optional, unexpected_value_error
from oilfilm.settings.ranges import refuse_outside_ranges, uncertain_input

# Ranges that rigs usually have: glass; steels, ceramics and hard metals.
_USUAL_MODULI_PA = ((6e10, 9.5e10), (1.9e11, 7.2e11))
_USUAL_RADII_M = ((0.001, 0.06),)


class Elasticity(Group):
    """Elastic constants of a body."""

    youngs_modulus_pa: q.YoungsModulusPa = key("Young's modulus.")
    poisson_ratio: q.PoissonRatio = key("Poisson's ratio.")

    def reduced_modulus_with(self, other_body: "Elasticity") -> float:
        """Reduced modulus of a contact with another body, in Pa."""
        modulus_pa = reduced_modulus(
            self.youngs_modulus_pa,
            self.poisson_ratio,
            other_body.youngs_modulus_pa,
            other_body.poisson_ratio,
        )
        return float(modulus_pa)


class FullScale(Group):
    """Full scale of the sensors."""

    load_n: q.LoadN = key("Load.")
    traction_force_n: q.LoadN = key("Traction force.")
    surface_speed_m_s: q.SpeedMs = key("Surface speed.")
    temperature_c: float = key("Temperature.", unit="degC", gt=0, le=2000)
    assumed: q.AnyNumberDistinct[q.Name] = key(
        "Those of these keys whose values are not known. They bound no test of `oilfilm plan`.",
        default=[],
    )


class Calibration(Group):
    """Standard uncertainties of calibration."""

    load_relative: q.CalibrationError = key("Of the load.")
    traction_force_relative: q.CalibrationError = key("Of the traction force.")
    speed_relative: q.CalibrationError = key("Of the surface speeds.")
    temperature_c: q.TemperatureErrorC = key("Of the inlet temperature.")


class ErrorsBetweenRuns(Group):
    """Standard deviations of what differs from run to run; usual sizes where a key is missing."""

    traction_force_relative: float | None = optional(
        "Of the traction force, relative; one error per run.", unit="1", ge=1e-4, le=0.2
    )
    zero_as_traction_coefficient: float | None = optional(
        "Of the zero of the traction force, over the load; one error per run.",
        unit="1",
        ge=1e-7,
        le=5e-3,
    )
    slip_relative: float | None = optional(
        "Of the slide-roll ratio, relative; one error per run.", unit="1", ge=1e-4, le=0.2
    )
    inlet_temperature_k: float | None = optional(
        "Of the inlet temperature; one error per run.", unit="K", ge=0.01, le=20
    )
    noise_of_points_relative: float | None = optional(
        "Of mu of each point, relative.", unit="1", ge=5e-4, le=0.2
    )


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
    torque_arm_m: q.TrackRadiusM | None = optional(
        "Lever arm of a logged traction torque: the force is torque over arm."
    )
    force_lag_s_range: q.NotFallingPair[q.DurationOrZeroS] | None = optional(
        "Time by which the traction force is logged behind the slip, for ramps; two equal numbers "
        "where it is known."
    )
    ball: Elasticity | None = optional("Elastic constants of the ball.")
    disc: Elasticity | None = optional("Elastic constants of the disc.")
    ball_roughness_ra_um: q.RoughnessUm | None = optional("Ra of the ball.")
    ball_roughness_rq_um: q.RoughnessUm | None = optional("Measured Rq of the ball; else 1.25 Ra.")
    disc_roughness_ra_um: q.RoughnessUm | None = optional("Ra of the disc.")
    disc_roughness_rq_um: q.RoughnessUm | None = optional("Measured Rq of the disc; else 1.25 Ra.")
    full_scale: FullScale | None = optional("Full scale of the sensors.")
    calibration: Calibration | None = optional("Standard uncertainties of calibration.")
    errors_between_runs: ErrorsBetweenRuns | None = optional(
        "Standard deviations from run to run; usual sizes are assumed without it."
    )
    limits: RigLimits | None = optional("Highest levels of a test, for `oilfilm plan`.")

    @model_validator(mode="after")
    def _contact_is_complete(self) -> Self:
        if self.ball_radius_m is None:
            return self
        for body_name in ("ball", "disc"):
            if getattr(self, body_name) is None:
                raise key_error_at(
                    ("ball_radius_m",),
                    f"the key {body_name!r} is missing, which a rig with `ball_radius_m` must "
                    "have.",
                )
        return self

    def doubts(self) -> Iterator[str]:
        """Sentences on unusual values, which no log can contradict."""
        for body_name, body in (("ball", self.ball), ("disc", self.disc)):
            if body is not None:
                value = body.youngs_modulus_pa
                yield from _doubt_of_value(
                    f"{body_name}: youngs_modulus_pa", value, _USUAL_MODULI_PA
                )
        if self.ball_radius_m is not None:
            yield from _doubt_of_value("ball_radius_m", self.ball_radius_m, _USUAL_RADII_M)

    def contact(self) -> Contact | None:
        """The contact of ball and disc; None where it was not recorded.

        The pressure does not depend on the roughness. Roughness that was not recorded is NaN, and
        so is lambda then.
        """
        if self.ball_radius_m is None or self.ball is None or self.disc is None:
            return None
        ball_rq_m = _rq_m(self.ball_roughness_ra_um, self.ball_roughness_rq_um)
        disc_rq_m = _rq_m(self.disc_roughness_ra_um, self.disc_roughness_rq_um)
        modulus_pa = self.ball.reduced_modulus_with(self.disc)
        roughness_m = float(combined_roughness(ball_rq_m, disc_rq_m))
        return Contact(self.ball_radius_m, modulus_pa, roughness_m)


def _doubt_of_value(
    name: str, value: float, usual_ranges: tuple[tuple[float, float], ...]
) -> Iterator[str]:
    """A sentence if a value is in none of the usual ranges."""
    if not any(low <= value <= high for low, high in usual_ranges):
        ranges = " or ".join(f"{low:g} to {high:g}" for low, high in usual_ranges)
        yield f"{name} is {value:.4g}; usual rigs have {ranges}"


def _rq_m(ra_um: float | None, rq_um: float | None) -> float:
    """Rq in m: as measured, else from Ra; NaN where neither was recorded."""
    if rq_um is not None:
        return rq_um * M_PER_UM
    if ra_um is not None:
        return float(rq_from_ra(ra_um * M_PER_UM))
    return math.nan


# ---------------------------------------------------------------- bearings

_M3_S_PER_L_MIN = 1e-3 / 60
# Inputs of a bearing whose flow of oil is not known.
_UNKNOWN_INPUT = UncertainInput(math.nan, math.nan, math.nan)
_UNKNOWN_FEED_INPUTS = {"feed_flow_m3_s": _UNKNOWN_INPUT, "momentum_share": _UNKNOWN_INPUT}
# Of bearing steel.
_STEEL_DENSITY_KG_M3 = 7833.0
_STEEL_EXPANSION_1_K = 12e-6
# Balls below this density are of another material.
_MIN_STEEL_DENSITY_KG_M3 = 6500.0


class RingMaterial(Elasticity):
    """Elastic constants, density and thermal expansion; by default of bearing steel."""

    density_kg_m3: q.SolidDensityKgM3 = key("Density.", default=_STEEL_DENSITY_KG_M3)
    expansion_1_k: q.Expansion1K = key("Thermal expansion.", default=_STEEL_EXPANSION_1_K)


class BallMaterial(Elasticity):
    """Elastic constants, density and thermal expansion."""

    density_kg_m3: q.SolidDensityKgM3 = key("Density.")
    expansion_1_k: q.Expansion1K = key(
        "Thermal expansion; by default of steel, which only balls as dense as steel may have.",
        default=_STEEL_EXPANSION_1_K,
    )

    @model_validator(mode="after")
    def _expansion_is_known(self) -> Self:
        is_stated = "expansion_1_k" in self.model_fields_set
        if self.density_kg_m3 < _MIN_STEEL_DENSITY_KG_M3 and not is_stated:
            sentence = (
                f"found {self.density_kg_m3:g} kg/m3, which is not steel, and no key "
                "'expansion_1_k'; add it (silicon nitride has 3.2e-6)."
            )
            raise key_error_at(("density_kg_m3",), sentence)
        return self


class MountingKeys(Group):
    """Shaft, housing and temperatures, by which rings and balls grow.

    The contact angle of the file is that of the bearing before mounting, at 20 degC.
    """

    bore_diameter_m: q.LengthM = key("Bore of the inner ring.")
    outside_diameter_m: q.LengthM = key("Outside diameter of the outer ring.")
    housing_ratio: q.AboveOne = key("Outside diameter of the housing over that of the bearing.")
    shaft_bore_ratio: q.HollowShaftRatio = key(
        "Bore of the shaft over the inner groove's diameter."
    )
    shaft_bore_ratio_range: q.RisingPair[q.HollowShaftRatio] = key("Its range.")
    shaft_interference_um: q.InterferenceUm = key("Of ring and shaft before mounting, on diameter.")
    shaft_interference_um_range: q.RisingPair[q.InterferenceUm] = key("Its range.")
    housing_interference_um: q.InterferenceOrClearanceUm = key(
        "Of ring and housing, on diameter; below 0 a clearance."
    )
    housing_interference_um_range: q.RisingPair[q.InterferenceOrClearanceUm] = key("Its range.")
    ring_temperature_difference_k: q.TemperatureDifferenceK = key(
        "Inner less outer ring. The outer ring has the temperature of the oil."
    )
    ring_temperature_difference_k_range: q.RisingPair[q.TemperatureDifferenceK] = key("Its range.")
    ball_temperature_difference_k: q.TemperatureDifferenceK = key("Balls less mean of both rings.")
    ball_temperature_difference_k_range: q.RisingPair[q.TemperatureDifferenceK] = key("Its range.")

    @model_validator(mode="after")
    def _values_are_in_their_ranges(self) -> Self:
        refuse_outside_ranges(self)
        return self

    def uncertain_inputs(self) -> dict[str, UncertainInput]:
        """Value and range of the uncertain inputs, with interferences on the radius in m."""
        on_radius = M_PER_UM / 2
        return {
            "shaft_bore_ratio": uncertain_input(self, "shaft_bore_ratio"),
            "shaft_interference_m": uncertain_input(self, "shaft_interference_um", on_radius),
            "housing_interference_m": uncertain_input(self, "housing_interference_um", on_radius),
            "ring_temperature_difference_k": uncertain_input(self, "ring_temperature_difference_k"),
            "ball_temperature_difference_k": uncertain_input(self, "ball_temperature_difference_k"),
        }


class CageKeys(Group):
    """Cage and its lands."""

    guidance: Literal["outer", "inner"] = key("Ring whose land guides the cage.")
    land_diameter_m: q.LengthM = key("Diameter of the guiding land.")
    land_width_m: q.LengthM = key("Width of both lands together.")
    land_clearance_m: q.LengthM = key("Radial clearance.")
    pocket_friction_coefficient: float = key("Of ball on pocket.", unit="1", ge=0, le=1)


class OilSupplyKeys(Group):
    """The oil that is fed to the bearing: its momentum, and its cooling."""

    flow_l_min: float = key("Flow at the inlet temperature.", unit="L/min", gt=0, le=1000)
    flow_l_min_range: q.RisingPair[q.FlowLMin] = key("Its range.")
    momentum_share: q.Share = key(
        "Share of the flow that leaves the inner ring with the ring's speed. 1 is an upper bound."
    )
    momentum_share_range: q.RisingPair[q.Share] = key("Its range.")
    heat_share: q.Share = key("Share of friction heat that the oil, not shaft or housing, takes.")
    outlet_weight: q.Share = key("Oil of the contacts: 0 inlet, 1 outlet temperature.", default=0.5)

    @model_validator(mode="after")
    def _values_are_in_their_ranges(self) -> Self:
        refuse_outside_ranges(self)
        return self

    def uncertain_inputs(self) -> dict[str, UncertainInput]:
        """Value and range of the uncertain inputs."""
        return {
            "feed_flow_m3_s": uncertain_input(self, "flow_l_min", _M3_S_PER_L_MIN),
            "momentum_share": uncertain_input(self, "momentum_share"),
        }

    def supply(self) -> OilSupply:
        """The oil for the heat balance."""
        return OilSupply(self.flow_l_min * _M3_S_PER_L_MIN, self.heat_share, self.outlet_weight)


class BearingFile(Group):
    """A single-row ball bearing."""

    name: q.Text = key("What it is.")
    source: q.Text = key("Where the values come from.")
    assumed: q.AnyNumberDistinct[q.Name] = key(
        "Keys whose values the source does not give.", default=[]
    )
    ball_diameter_m: q.LengthM = key("Diameter of a ball.")
    pitch_diameter_m: q.LengthM = key("Diameter of the circle of ball centres.")
    ball_count: int = key("Number of balls.", ge=3)
    contact_angle_deg: float = key("Unloaded contact angle.", unit="deg", ge=0, lt=90)
    inner_groove_curvature: q.GrooveCurvature = key("Inner groove radius over ball diameter.")
    outer_groove_curvature: q.GrooveCurvature = key("Outer groove radius over ball diameter.")
    ring: RingMaterial = key("Material of the rings, of shaft and housing too.")
    ball: BallMaterial = key("Material of the balls.")
    ball_roughness_ra_um: q.RoughnessUm = key("Ra of the balls.")
    race_roughness_ra_um: q.RoughnessUm = key("Ra of the races.")
    cage: CageKeys = key("Cage and its lands.")
    mounting: MountingKeys = key("Shaft, housing and temperatures, by which the rings grow.")
    oil_supply: OilSupplyKeys | None = optional(
        "Feed oil; without it the torque lacks its momentum, and there is no heat balance."
    )

    @model_validator(mode="after")
    def _can_be_built(self) -> Self:
        for key_path, sentence in self._impossible_dimensions():
            raise key_error_at(key_path, sentence)
        return self

    def _impossible_dimensions(self) -> Iterator[tuple[tuple[str, ...], str]]:
        """Dimensions that cannot be built, one item each: the key to blame, and a sentence."""
        ball_m = self.ball_diameter_m
        pitch_m = self.pitch_diameter_m
        if ball_m >= pitch_m / 2:
            expected = f"less than half of the pitch diameter of {pitch_m:g} m"
            yield ("ball_diameter_m",), f"found {ball_m:g} m; expected {expected}."
        max_ball_count = int(math.pi / math.asin(min(ball_m / pitch_m, 1.0)))
        if self.ball_count > max_ball_count:
            found_text = f"found {self.ball_count} balls of {ball_m:g} m, which overlap"
            yield ("ball_count",), f"{found_text}; there is room for {max_ball_count}."
        land_m = self.cage.land_diameter_m
        if self.cage.guidance == "outer":
            low_m, high_m = pitch_m, pitch_m + ball_m
        else:
            low_m, high_m = pitch_m - ball_m, pitch_m
        if not low_m <= land_m <= high_m or land_m == pitch_m:
            found_text = f"found {land_m:g} m with guidance: {self.cage.guidance}"
            expected = f"{low_m:g} to {high_m:g} m, between pitch diameter and the balls' far side"
            yield ("cage", "land_diameter_m"), f"{found_text}; expected {expected}."
        clearance_m = self.cage.land_clearance_m
        if clearance_m >= ball_m / 2:
            expected = f"well below the balls' radius of {ball_m / 2:g} m"
            yield ("cage", "land_clearance_m"), f"found {clearance_m:g} m; expected {expected}."

        yield from self._impossible_mounting()

    def _impossible_mounting(self) -> Iterator[tuple[tuple[str, ...], str]]:
        """Rings without any thickness, one item each: the key to blame, and a sentence."""
        mounting = self.mounting
        inner_groove_m, outer_groove_m = self._groove_diameters_m()
        bore_m = mounting.bore_diameter_m
        if not bore_m < inner_groove_m:
            expected = (
                f"less than {inner_groove_m:.4g} m, the diameter at the bottom of the inner groove"
            )
            yield ("mounting", "bore_diameter_m"), f"found {bore_m:g} m; expected {expected}."
        outside_m = mounting.outside_diameter_m
        if not outside_m > outer_groove_m:
            expected = (
                f"more than {outer_groove_m:.4g} m, the diameter at the bottom of the outer groove"
            )
            yield ("mounting", "outside_diameter_m"), f"found {outside_m:g} m; expected {expected}."
        largest_ratio = mounting.shaft_bore_ratio_range[1]
        if not largest_ratio < bore_m / inner_groove_m:
            found_text = f"found {largest_ratio:g} at most"
            expected = (
                f"less than the bore of the ring over the groove, {bore_m / inner_groove_m:.3g}"
            )
            yield ("mounting", "shaft_bore_ratio_range"), f"{found_text}; expected {expected}."

    def _groove_diameters_m(self) -> tuple[float, float]:
        """Diameters at the bottoms of the inner and the outer groove."""
        cosine = math.cos(math.radians(self.contact_angle_deg))
        inner_curvature, outer_curvature = self.inner_groove_curvature, self.outer_groove_curvature
        ball_m = self.ball_diameter_m
        inner_groove_m = self.pitch_diameter_m + 2 * ball_m * (
            (inner_curvature - 0.5) * cosine - inner_curvature
        )
        outer_groove_m = self.pitch_diameter_m - 2 * ball_m * (
            (outer_curvature - 0.5) * cosine - outer_curvature
        )
        return inner_groove_m, outer_groove_m

    def bearing(self, name: str) -> Bearing:
        """The bearing for the mechanics.

        Args:
            name: Name of its file.

        Examples:
            The mass of a ball of a 218, 22.23 mm of steel, by hand 7833 pi 0.02223^3/6:

            >>> from pathlib import Path
            >>> from oilfilm.settings.messages import load
            >>> file = Path(__file__).parents[3] / "config/bearings/harris-218.yaml"
            >>> print(f"{load(file, BearingFile).bearing('218').ball_mass_kg * 1e3:.2f} g")
            45.06 g
        """
        ball_rq_m = rq_from_ra(self.ball_roughness_ra_um * M_PER_UM)
        race_rq_m = rq_from_ra(self.race_roughness_ra_um * M_PER_UM)
        feed_inputs = (
            _UNKNOWN_FEED_INPUTS if self.oil_supply is None else self.oil_supply.uncertain_inputs()
        )
        return Bearing(
            name=name,
            ball_diameter_m=self.ball_diameter_m,
            pitch_diameter_m=self.pitch_diameter_m,
            ball_count=self.ball_count,
            contact_angle_rad=float(np.radians(self.contact_angle_deg)),
            groove_curvature=(self.inner_groove_curvature, self.outer_groove_curvature),
            reduced_modulus_pa=self.ball.reduced_modulus_with(self.ring),
            ball_density_kg_m3=self.ball.density_kg_m3,
            roughness_rq_m=float(combined_roughness(ball_rq_m, race_rq_m)),
            cage=Cage(
                guided_by_outer_ring=self.cage.guidance == "outer",
                **self.cage.model_dump(exclude={"guidance"}),
            ),
            rings=self._rings(),
            uncertain_inputs=self.mounting.uncertain_inputs() | feed_inputs,
        )

    def _rings(self) -> Rings:
        """The rings for the mechanics."""
        inner_groove_m, outer_groove_m = self._groove_diameters_m()
        return Rings(
            **self.ring.model_dump(),
            ball_expansion_1_k=self.ball.expansion_1_k,
            bore_ratio=self.mounting.bore_diameter_m / inner_groove_m,
            outer_groove_ratio=outer_groove_m / self.mounting.outside_diameter_m,
            housing_ratio=self.mounting.housing_ratio,
        )


# ---------------------------------------------------------------- oils

_CST_PER_M2_S = 1e6
# Kinematic viscosity of the thinnest oil, at any temperature of use, in cSt.
_MIN_VISCOSITY_CST = 0.5
# Range of the pressure-viscosity coefficient of all liquid lubricants at 40 degC.
_PRESSURE_VISCOSITY_RANGE_1_GPA = (5, 50)
# Largest relative difference of the viscosity from the nominal one.
_VISCOSITY_TOLERANCE = 0.05
# The same for a stand-in, which has the properties of another oil of about the same grade.
_STAND_IN_TOLERANCE = 0.25
# Least distance of two temperatures of measured viscosity. Nearer rows carry their rounding, 0.5 %,
# into the slope: 3 % of it over 10 K.
_MIN_STEP_K = 10.0

T = TypeVar("T")


def _temperatures_differ(rows: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Validator of rows of [temperature, value]: no temperature is there twice."""
    temperatures = [temperature_k for temperature_k, _ in rows]
    if len(set(temperatures)) < len(temperatures):
        raise unexpected_value_error("each temperature once")
    return rows


TemperatureK = Annotated[float, Field(ge=200, le=700, json_schema_extra={"unit": "K"})]
ViscosityCst = Annotated[float, Field(gt=0.2, le=1e5, json_schema_extra={"unit": "cSt"})]
PressureViscosity1Pa = Annotated[float, Field(ge=1e-9, le=1e-7, json_schema_extra={"unit": "1/Pa"})]
OilDensityKgM3 = Annotated[float, Field(ge=400, le=2500, json_schema_extra={"unit": "kg/m3"})]
SpecificHeatJKgK = Annotated[float, Field(ge=500, le=6000, json_schema_extra={"unit": "J/(kg K)"})]
ConductivityWMK = Annotated[float, Field(ge=0.01, le=1, json_schema_extra={"unit": "W/(m K)"})]
# Rows of [temperature, value]. YAML has lists only, hence not strict.
PropertyTable = Annotated[
    list[Annotated[tuple[TemperatureK, T], Strict(False)]],
    Field(min_length=2),
    AfterValidator(_temperatures_differ),
]


def _linear_between_rows(rows: list[tuple[float, float]]) -> oils.PiecewiseLinear:
    """A property as a function of temperature, linear between its rows of [K, value]."""
    sorted_rows = sorted(rows)
    temperatures_k = tuple(temperature_k for temperature_k, _ in sorted_rows)
    values = tuple(value for _, value in sorted_rows)
    return oils.PiecewiseLinear(temperatures_k, values)


class MilL7808Coefficients(Group):
    """Coefficients of the MIL-L-7808 formulas."""

    viscosity_intercept: float = key("a = exp(intercept - slope ln T), T in K.", unit="1")
    viscosity_slope: float = key("Slope of the same.", unit="1", gt=0)
    viscosity_scale_pa_s: float = key("eta = scale (exp(a) - offset).", unit="Pa s", gt=0)
    viscosity_offset: float = key("Offset of the same.", unit="1")
    pressure_viscosity_base_1_pa: float = key(
        "alpha = base + rate/(T - pole).", unit="1/Pa", gt=0, le=1e-6
    )
    pressure_viscosity_rate_k_pa: float = key("Rate of the same.", unit="K/Pa", gt=0, le=1e-3)
    pressure_viscosity_pole_k: float = key("Pole of the same.", unit="K", gt=0, lt=300)


class AlphaOfViscosity(Group):
    """Coefficients of the pressure viscosity as a power of the viscosity."""

    pressure_viscosity_exponent: float = key(
        "m; alpha = exp(m ln eta - n)/eta.", unit="1", gt=0, le=10
    )
    pressure_viscosity_offset: float = key("n, for eta in Pa s and alpha in 1/Pa.", unit="1")


class MilL23699Coefficients(AlphaOfViscosity):
    """Coefficients of the MIL-L-23699 formulas."""

    reference_temperature_k: TemperatureK = key("T_r; d = 1/T - 1/T_r.")
    reference_viscosity_pa_s: float = key("eta = eta_r exp(c1 d + c2 d^2).", unit="Pa s", gt=0)
    viscosity_first_order_k: float = key("c1.", unit="K", gt=0)
    viscosity_second_order_k2: float = key("c2.", unit="K2")


class AstmD341Coefficients(AlphaOfViscosity):
    """Coefficients of ASTM D341."""

    viscosity_intercept: float = key(
        "A; log10 log10(nu + 0.7) = A - B log10 T, nu in cSt, T in K.", unit="1"
    )
    viscosity_slope: float = key("B.", unit="1", gt=0)


class MeasuredViscosity(Group):
    """Viscosities of a data sheet, through which the formula's curve goes."""

    kinematic_viscosity_cst: PropertyTable[ViscosityCst] = key("Rows of [K, cSt]; for vogel three.")

    @model_validator(mode="after")
    def _viscosity_falls(self) -> Self:
        """The viscosity falls from row to row, and the rows are well apart."""
        rows = sorted(self.kinematic_viscosity_cst)
        for (colder_k, thicker_cst), (hotter_k, thinner_cst) in pairwise(rows):
            found_text = f"found {thicker_cst:g} cSt at {colder_k:g} K and {thinner_cst:g} cSt at "
            found_text += f"{hotter_k:g} K"
            sentence = ""
            if not thinner_cst < thicker_cst:
                sentence = (
                    f"{found_text}; expected a viscosity that falls with temperature. Two "
                    "viscosities or temperatures may be swapped or mistyped."
                )
            elif hotter_k - colder_k < _MIN_STEP_K:
                sentence = (
                    f"{found_text}; expected temperatures at least {_MIN_STEP_K:g} K apart, or "
                    "the rounding of the viscosities decides the curve. Take rows further apart."
                )
            if sentence:
                raise key_error_at(("kinematic_viscosity_cst",), sentence)
        return self


class PressureViscosity(Group):
    """The pressure-viscosity coefficient alpha."""

    rule: Literal["given", "so-klaus", "roelands"] = key(
        "given: by rows; so-klaus: by viscosity and density; roelands: by the index z."
    )
    rows: PropertyTable[PressureViscosity1Pa] | None = optional("Rows of [K, 1/Pa], for given.")
    z: float | None = optional("Index, for roelands.", unit="1", gt=0.1, le=1.5)

    @model_validator(mode="after")
    def _has_what_its_rule_needs(self) -> Self:
        for rule, key_name in (("given", "rows"), ("roelands", "z")):
            if (self.rule == rule) != (getattr(self, key_name) is not None):
                raise key_error_at(
                    (key_name,),
                    f"`{key_name}` goes with rule: {rule} and with no other; found {self.rule}.",
                )
        return self


class OilUncertainty(Group):
    """Uncertainty of properties where it is known, relative."""

    pressure_viscosity_coefficient: q.Tolerance | None = optional("Half-width of alpha.")
    density: q.Tolerance | None = optional("Half-width of the density.")


class LimitingStress(Group):
    """Limiting shear stress over pressure, above which no film carries traction."""

    ratio: float = key("Limiting shear stress over pressure.", unit="1", gt=0, le=0.5)
    source: q.Text = key("Where the ratio comes from, or that it is assumed.")


# Keys that an oil has under the same name.
_KEYS_COPIED_TO_OIL = {
    "id",
    "name",
    "display_name",
    "model",
    "stand_in",
    "note",
    "source",
    "nominal_kinematic_viscosity_100c_cst",
}


class OilKeys(Group):
    """Keys that every oil has, with any formulas."""

    model: str
    coefficients: Group
    id: q.Name = key("The file's name without .yaml, in quotes.")
    name: q.Text = key("Full name.")
    display_name: q.Text = key("Full name, in quotes. Figures and tables show the id.")
    aliases: list[q.Text] = key("Other names that logs give the oil.", default=[])
    nominal_kinematic_viscosity_100c_cst: float = key(
        "At 100 degC.", unit="cSt", gt=_MIN_VISCOSITY_CST, le=2000
    )
    stand_in: bool = key("The properties are another oil's, because its own are not known.")
    note: q.Text = key("What the reader must know of the properties' origin.")
    source: q.Text = key("Source of the numbers.")
    density_kg_m3: PropertyTable[OilDensityKgM3] = key("Rows of [K, kg/m3].")
    pressure_viscosity: PressureViscosity | None = optional("For walther, vogel and roelands.")
    specific_heat_j_kgk: PropertyTable[SpecificHeatJKgK] = key("Rows of [K, J/(kg K)].")
    thermal_conductivity_w_mk: PropertyTable[ConductivityWMK] = key("Rows of [K, W/(m K)].")
    limiting_shear_stress: LimitingStress | None = optional("Else 0.12 of the pressure.")
    relative_uncertainty: OilUncertainty = key("Where it is known.", default=OilUncertainty())

    @model_validator(mode="after")
    def _coefficients_give_the_stated_viscosity(self) -> Self:
        for key_path, sentence in self.faults(*STANDARD_RANGE_C):
            raise key_error_at(key_path, sentence)
        nominal_cst = self.nominal_kinematic_viscosity_100c_cst
        viscosity_cst = float(self.properties().kinematic_viscosity_m2_s(100.0)) * _CST_PER_M2_S
        tolerance = _STAND_IN_TOLERANCE if self.stand_in else _VISCOSITY_TOLERANCE
        # a viscosity that is not a number fails too
        if not abs(viscosity_cst / nominal_cst - 1) <= tolerance:
            raise key_error_at(
                ("coefficients",),
                f"the coefficients give {viscosity_cst:.3g} cSt at 100 degC, but "
                f"nominal_kinematic_viscosity_100c_cst is {nominal_cst:g}; expected them within "
                f"{tolerance:.0%}. Check the units of the coefficients and of the density.",
            )
        alpha_1_pa = float(self.properties().pressure_viscosity_coefficient_1_pa(40.0))
        alpha_1_gpa = PA_PER_GPA * alpha_1_pa
        lowest_1_gpa, highest_1_gpa = _PRESSURE_VISCOSITY_RANGE_1_GPA
        if not lowest_1_gpa <= alpha_1_gpa <= highest_1_gpa:
            raise key_error_at(
                ("coefficients",) if self.pressure_viscosity is None else ("pressure_viscosity",),
                f"the pressure-viscosity coefficient at 40 degC is {alpha_1_gpa:.4g} 1/GPa; "
                f"expected {lowest_1_gpa} to {highest_1_gpa}, as oils have it. Check the units.",
            )
        return self

    def faults(self, low_c: float, high_c: float) -> Iterator[tuple[tuple[str, ...], str]]:
        """Properties that no oil has, one item per fault: the key to blame, and a sentence.

        Args:
            low_c: Lowest temperature of use, in degC. The rows of viscosity and density widen the
                range.
            high_c: Highest temperature of use, in degC.
        """
        temperatures_c = [low_c, high_c]
        for rows in self.property_tables_of_use():
            temperatures_c += [temperature_k + ABSOLUTE_ZERO_C for temperature_k, _ in rows]
        oil = self.properties()
        for fault in plausible_oil.impossible_properties(
            oil, min(temperatures_c), max(temperatures_c)
        ):
            yield (
                self.key_path_by_property[fault.quantity],
                f"{fault.sentence} Check the numbers and the units.",
            )

    # Path of the key to blame for a property.
    key_path_by_property: ClassVar[dict[plausible_oil.OilProperty, tuple[str, ...]]] = {
        "viscosity": ("coefficients",),
        "pressure_viscosity": ("coefficients",),
        "density": ("density_kg_m3",),
    }

    def property_tables_of_use(self) -> Iterator[Sequence[tuple[float, float]]]:
        """Tables whose rows of [K, value] are at temperatures at which the oil is used."""
        yield self.density_kg_m3

    def doubts(self) -> Iterator[str]:
        """Sentences on what is possible and unusual."""
        if not self.stand_in:
            yield from plausible_oil.unusual_properties(self.properties())

    def viscosity_coefficients(self) -> dict[str, float]:
        """Coefficients of the viscosity by name."""
        return self.coefficients.model_dump()

    def properties(self) -> oils.Oil:
        """The oil with its property formulas."""
        arguments: dict[str, Any] = self.model_dump(include=_KEYS_COPIED_TO_OIL)
        coefficients = self.viscosity_coefficients()
        pressure_viscosity = self.pressure_viscosity
        if pressure_viscosity is not None:
            arguments["pressure_rule"] = pressure_viscosity.rule
            if pressure_viscosity.z is not None:
                coefficients["roelands_z"] = pressure_viscosity.z
            if pressure_viscosity.rows is not None:
                arguments["pressure_viscosity"] = _linear_between_rows(pressure_viscosity.rows)
        if self.limiting_shear_stress is not None:
            arguments["limiting_stress_ratio"] = self.limiting_shear_stress.ratio
        return oils.Oil(
            **arguments,
            density=_linear_between_rows(self.density_kg_m3),
            specific_heat=_linear_between_rows(self.specific_heat_j_kgk),
            thermal_conductivity=_linear_between_rows(self.thermal_conductivity_w_mk),
            coefficients=coefficients,
            relative_uncertainty=self.relative_uncertainty.model_dump(exclude_none=True),
        )


class MilL7808Oil(OilKeys):
    """An oil by the MIL-L-7808 formulas."""

    model: Literal["adore-mil-l-7808"] = key("Formulas of viscosity and pressure viscosity.")
    coefficients: MilL7808Coefficients = key("Numbers of the formulas.")


class MilL23699Oil(OilKeys):
    """An oil by the MIL-L-23699 formulas."""

    model: Literal["adore-mil-l-23699"] = key("Formulas of viscosity and pressure viscosity.")
    coefficients: MilL23699Coefficients = key("Numbers of the formulas.")


class AstmD341Oil(OilKeys):
    """An oil by ASTM D341, from its viscosity at two temperatures."""

    model: Literal["astm-d341"] = key("Formulas of viscosity and pressure viscosity.")
    coefficients: AstmD341Coefficients = key("Numbers of the formulas.")


class MeasuredOil(OilKeys):
    """An oil by the viscosities and the density of its data sheet."""

    model: Literal["walther", "vogel", "roelands"] = key("Formula of the viscosity.")
    coefficients: MeasuredViscosity = key("Viscosities of the data sheet.")
    pressure_viscosity: PressureViscosity = key("Pressure-viscosity coefficient.")

    key_path_by_property: ClassVar[dict[plausible_oil.OilProperty, tuple[str, ...]]] = {
        "viscosity": ("coefficients", "kinematic_viscosity_cst"),
        "pressure_viscosity": ("pressure_viscosity",),
        "density": ("density_kg_m3",),
    }

    def property_tables_of_use(self) -> Iterator[Sequence[tuple[float, float]]]:
        """See `OilKeys`."""
        yield self.density_kg_m3
        yield self.coefficients.kinematic_viscosity_cst
        if self.pressure_viscosity.rows is not None:
            yield self.pressure_viscosity.rows

    def viscosity_coefficients(self) -> dict[str, float]:
        """See `OilKeys`."""
        rows = np.array(sorted(self.coefficients.kinematic_viscosity_cst))
        needed_count = 3 if self.model == "vogel" else 2
        if len(rows) != needed_count:
            raise key_error_at(
                ("coefficients", "kinematic_viscosity_cst"),
                f"found {len(rows)} viscosities; model: {self.model} needs {needed_count}.",
            )
        temperatures_k, viscosities_cst = rows.T
        if viscosities_cst.min() <= _MIN_VISCOSITY_CST:
            raise key_error_at(
                ("coefficients", "kinematic_viscosity_cst"),
                f"found {viscosities_cst.min():g} cSt; expected more than {_MIN_VISCOSITY_CST:g}, "
                "as oils have it. Check the decimal mark and the units.",
            )
        if self.model == "walther":
            return oils.walther_coefficients(temperatures_k, viscosities_cst)
        density_kg_m3 = _linear_between_rows(self.density_kg_m3).value_at(temperatures_k)
        viscosity_pa_s = viscosities_cst / _CST_PER_M2_S * density_kg_m3
        if self.model == "vogel":
            return oils.vogel_coefficients(temperatures_k, viscosity_pa_s)
        return oils.roelands_coefficients(temperatures_k, viscosity_pa_s)


OilFile = Annotated[
    MilL7808Oil | MilL23699Oil | AstmD341Oil | MeasuredOil, Field(discriminator="model")
]
