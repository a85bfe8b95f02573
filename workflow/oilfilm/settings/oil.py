"""The keys of config/oils/<id>.yaml: an oil and the coefficients of its property formulas.

Decides: the keys of an oil file; when its coefficients contradict its grade.
"""

from typing import Annotated, Any, Literal, Self, TypeVar

import numpy as np
from pydantic import AfterValidator, Field, Strict, model_validator

from oilfilm.physics import oils
from oilfilm.settings import quantities as q
from oilfilm.settings.base import Group, contradiction, key, optional, unexpected

_CST_PER_M2_S = 1e6
# Of all liquid lubricants, at 40 degC.
_PRESSURE_VISCOSITY_1_GPA = (5, 50)
# A stand-in has the properties of another oil of about the same grade.
_VISCOSITY_TOLERANCE, _STAND_IN_TOLERANCE = 0.05, 0.25

T = TypeVar("T")


def _temperatures_differ(rows: list[tuple[float, float]]) -> list[tuple[float, float]]:
    temperatures = [temperature_k for temperature_k, _ in rows]
    if len(set(temperatures)) < len(temperatures):
        raise unexpected("each temperature once")
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


def _curve(rows: list[tuple[float, float]]) -> oils.PiecewiseLinear:
    return oils.PiecewiseLinear(*zip(*sorted(rows), strict=True))


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


class PressureViscosity(Group):
    """The pressure-viscosity coefficient alpha."""

    rule: Literal["given", "so-klaus", "roelands"] = key(
        "given: by rows; so-klaus: by viscosity and density; roelands: by the index z."
    )
    rows: PropertyTable[PressureViscosity1Pa] | None = optional("Rows of [K, 1/Pa], for given.")
    z: float | None = optional("Index, for roelands.", unit="1", gt=0.1, le=1.5)

    @model_validator(mode="after")
    def _has_what_its_rule_needs(self) -> Self:
        for rule, name in (("given", "rows"), ("roelands", "z")):
            if (self.rule == rule) != (getattr(self, name) is not None):
                raise contradiction(
                    (name,),
                    f"`{name}` goes with rule: {rule} and with no other; found {self.rule}.",
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


class OilKeys(Group):
    """Keys that every oil has, whatever its formulas."""

    model: str
    coefficients: Group
    id: q.Name = key("The file's name without .yaml, in quotes.")
    name: q.Text = key("Full name.")
    display_name: q.Text = key("Full name, in quotes. Figures and tables show the id.")
    aliases: list[q.Text] = key("Other names that logs give the oil.", default=[])
    nominal_kinematic_viscosity_100c_cst: float = key("At 100 degC.", unit="cSt", gt=0.5, le=2000)
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
        nominal_cst = self.nominal_kinematic_viscosity_100c_cst
        given_cst = float(self.properties().kinematic_viscosity_m2_s(100.0)) * _CST_PER_M2_S
        tolerance = _STAND_IN_TOLERANCE if self.stand_in else _VISCOSITY_TOLERANCE
        # a viscosity that is not a number fails too
        if not abs(given_cst / nominal_cst - 1) <= tolerance:
            raise contradiction(
                ("coefficients",),
                f"the coefficients give {given_cst:.3g} cSt at 100 degC, but "
                f"nominal_kinematic_viscosity_100c_cst is {nominal_cst:g}; expected them within "
                f"{tolerance:.0%}. Check the units of the coefficients and of the density.",
            )
        alpha = 1e9 * float(self.properties().pressure_viscosity_coefficient_1_pa(40.0))
        low, high = _PRESSURE_VISCOSITY_1_GPA
        if not low <= alpha <= high:
            raise contradiction(
                ("coefficients",) if self.pressure_viscosity is None else ("pressure_viscosity",),
                f"the pressure-viscosity coefficient at 40 degC is {alpha:.4g} 1/GPa; expected "
                f"{low} to {high}, as oils have it. Check the units.",
            )
        return self

    def numbers(self) -> dict[str, float]:
        """Coefficients of the viscosity by name."""
        return self.coefficients.model_dump()

    def properties(self) -> oils.Oil:
        """The oil with its property formulas."""
        copied = {"id", "name", "display_name", "model", "stand_in", "note", "source"}
        grade = "nominal_kinematic_viscosity_100c_cst"
        given: dict[str, Any] = self.model_dump(include={*copied, grade})
        coefficients, pressure = self.numbers(), self.pressure_viscosity
        if pressure is not None:
            given["pressure_rule"] = pressure.rule
            coefficients |= {} if pressure.z is None else {"roelands_z": pressure.z}
            if pressure.rows is not None:
                given["pressure_viscosity"] = _curve(pressure.rows)
        if self.limiting_shear_stress is not None:
            given["limiting_stress_ratio"] = self.limiting_shear_stress.ratio
        return oils.Oil(
            **given,
            density=_curve(self.density_kg_m3),
            specific_heat=_curve(self.specific_heat_j_kgk),
            thermal_conductivity=_curve(self.thermal_conductivity_w_mk),
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

    def numbers(self) -> dict[str, float]:
        """See `OilKeys`."""
        rows = np.array(sorted(self.coefficients.kinematic_viscosity_cst))
        needed = 3 if self.model == "vogel" else 2
        if len(rows) != needed:
            raise contradiction(
                ("coefficients", "kinematic_viscosity_cst"),
                f"found {len(rows)} viscosities; model: {self.model} needs {needed}.",
            )
        temperature_k, viscosity_cst = rows.T
        if self.model == "walther":
            return oils.walther_coefficients(temperature_k, viscosity_cst)
        density = _curve(self.density_kg_m3).at(temperature_k)
        viscosity = viscosity_cst / _CST_PER_M2_S * density
        if self.model == "vogel":
            return oils.vogel_coefficients(temperature_k, viscosity)
        return oils.roelands_coefficients(temperature_k, viscosity)


OilFile = Annotated[
    MilL7808Oil | MilL23699Oil | AstmD341Oil | MeasuredOil, Field(discriminator="model")
]
