"""What no oil does over a range of temperatures, and what few oils do.

The formulas of `oils` go through any numbers. A mistyped viscosity can give them a pole, or a
viscosity that rises with temperature.

Decides: which properties of an oil are impossible, and which are unusual.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from oilfilm.base.units import ABSOLUTE_ZERO_C, PA_PER_GPA, BoolArray, FloatArray
from oilfilm.physics.oils import Oil, walther_coefficients

OilProperty = Literal["viscosity", "pressure_viscosity", "density"]

# Range in which every oil is judged: data sheets state the viscosity at its ends.
STANDARD_RANGE_C = (40.0, 100.0)
# Step of the temperatures at which an oil is judged.
_TEMPERATURE_STEP_K = 1.0
# Relative fall of the viscosity per kelvin, beta. Oils have 0.01 at 150 degC to 0.2 at -40 degC
# (docs/physics.md: 0.0125 to 0.043 from 140 to 25 degC).
_VISCOSITY_FALL_1_K = (0.002, 0.3)
# Range of alpha at any temperature of use. Esters have 6 at 140 degC; traction fluids reach 45 at
# 25 degC, and more in the cold.
_PRESSURE_VISCOSITY_1_GPA = (1.0, 150.0)
# Thermal expansion. Oils have 0.0006 to 0.001 1/K; a constant density is a coarse one.
_EXPANSION_1_K = (0.0, 0.002)
_DENSITY_KG_M3 = (400.0, 2500.0)
# Relative change of the central film per kelvin. The film goes with eta^0.67 alpha^0.53.
_FILM_VISCOSITY_EXPONENT = 0.67
_FILM_PRESSURE_EXPONENT = 0.53
_FILM_CHANGE_1_K = 0.25
# Vogel's pole. Oils have it near their glass transition, 120 to 220 K; above 250 K the formula
# freezes an oil that flows.
_HIGHEST_POLE_K = 250.0
_USUAL_POLE_K = (60.0, 230.0)
# Walther's slope B. Mineral oils and esters have 3.3 to 4, light naphthenic oils up to 4.8,
# polysiloxanes 1.6 to 2.5.
_USUAL_WALTHER_SLOPE = (1.5, 5.0)


@dataclass(frozen=True)
class ImpossibleProperty:
    """A property with values that no oil has.

    Attributes:
        quantity: The property.
        finding: What was found.
        expected: What every oil has.
    """

    quantity: OilProperty
    finding: str
    expected: str

    @property
    def sentence(self) -> str:
        """What was found and what was expected."""
        return f"{self.finding}; expected {self.expected}."


def impossible_properties(oil: Oil, low_c: float, high_c: float) -> Iterator[ImpossibleProperty]:
    """Properties that are impossible at some temperature between two.

    Args:
        oil: The oil.
        low_c: Lowest temperature, in degC.
        high_c: Highest temperature, in degC.
    """
    temperature_count = max(2, int(np.ceil((high_c - low_c) / _TEMPERATURE_STEP_K)) + 1)
    temperature_c = np.linspace(low_c, high_c, temperature_count)
    # a mistyped number may overflow, and is found by what comes out
    with np.errstate(all="ignore"):
        viscosity_pa_s = oil.dynamic_viscosity_pa_s(temperature_c)
        fall_1_k = oil.temperature_viscosity_coefficient_1_k(temperature_c)
        alpha_1_gpa = oil.pressure_viscosity_coefficient_1_pa(temperature_c) * PA_PER_GPA
        density_kg_m3 = oil.density_kg_m3(temperature_c)
        yield from _pole_faults(oil, low_c)
        yield from _density_faults(temperature_c, density_kg_m3)
        yield from _viscosity_faults(temperature_c, viscosity_pa_s, fall_1_k)
        yield from _pressure_viscosity_faults(temperature_c, alpha_1_gpa)
        yield from _film_faults(temperature_c, viscosity_pa_s, alpha_1_gpa)


def _pole_faults(oil: Oil, low_c: float) -> Iterator[ImpossibleProperty]:
    """A pole of Vogel's formula that is not far below the range."""
    pole_k = oil.coefficients.get("pole_k")
    if oil.model != "vogel" or pole_k is None:
        return
    highest_k = min(_HIGHEST_POLE_K, low_c - ABSOLUTE_ZERO_C)
    if not pole_k < highest_k:
        yield ImpossibleProperty(
            "viscosity",
            f"Vogel's formula through these viscosities has a pole at {pole_k:.0f} K "
            f"({pole_k + ABSOLUTE_ZERO_C:.0f} degC), where the viscosity has no limit",
            f"a pole below {highest_k:.0f} K, as oils have it; one of the viscosities is wrong",
        )


def _first_wrong_index(is_wrong: BoolArray) -> int | None:
    """The index of the first wrong value; None where there is none."""
    indices = np.flatnonzero(is_wrong)
    return int(indices[0]) if len(indices) else None


def _density_faults(
    temperature_c: FloatArray, density_kg_m3: FloatArray
) -> Iterator[ImpossibleProperty]:
    """A density that no oil has, or a thermal expansion that no oil has."""
    lowest_density, highest_density = _DENSITY_KG_M3
    wrong_index = _first_wrong_index(
        ~((density_kg_m3 >= lowest_density) & (density_kg_m3 <= highest_density))
    )
    if wrong_index is not None:
        yield ImpossibleProperty(
            "density",
            f"the density at {temperature_c[wrong_index]:.0f} degC is "
            f"{density_kg_m3[wrong_index]:.4g} kg/m3",
            f"{lowest_density:g} to {highest_density:g}",
        )
        return
    lowest_expansion, highest_expansion = _EXPANSION_1_K
    expansion_1_k = -np.diff(density_kg_m3) / np.diff(temperature_c) / density_kg_m3[1:]
    rounding = 1e-12
    wrong_index = _first_wrong_index(
        ~((expansion_1_k >= lowest_expansion - rounding) & (expansion_1_k <= highest_expansion))
    )
    if wrong_index is not None:
        verb = "rises" if expansion_1_k[wrong_index] < 0 else "falls"
        yield ImpossibleProperty(
            "density",
            f"the density {verb} by {abs(expansion_1_k[wrong_index]):.2%} per kelvin at "
            f"{temperature_c[wrong_index]:.0f} degC",
            f"a fall of at most {highest_expansion:.1%} per kelvin; two values may be swapped",
        )


def _viscosity_faults(
    temperature_c: FloatArray, viscosity_pa_s: FloatArray, fall_1_k: FloatArray
) -> Iterator[ImpossibleProperty]:
    """A viscosity that is missing, rises with temperature, or falls as that of no oil."""
    wrong_index = _first_wrong_index(~(np.isfinite(viscosity_pa_s) & (viscosity_pa_s > 0)))
    if wrong_index is not None:
        yield ImpossibleProperty(
            "viscosity",
            f"the formula gives no viscosity at {temperature_c[wrong_index]:.0f} degC",
            "a viscosity above 0",
        )
        return
    smallest_fall, largest_fall = _VISCOSITY_FALL_1_K
    is_falling = fall_1_k > 0
    # neighbours too: between them there may be a pole
    is_falling[1:] &= np.diff(viscosity_pa_s) < 0
    wrong_index = _first_wrong_index(~is_falling)
    if wrong_index is not None:
        yield ImpossibleProperty(
            "viscosity",
            "the viscosity does not fall with temperature at "
            f"{temperature_c[wrong_index]:.0f} degC "
            f"({1e3 * viscosity_pa_s[wrong_index]:.3g} mPa s)",
            "a viscosity that falls strictly, as oils have it",
        )
        return
    wrong_index = _first_wrong_index(~((fall_1_k >= smallest_fall) & (fall_1_k <= largest_fall)))
    if wrong_index is not None:
        yield ImpossibleProperty(
            "viscosity",
            f"the viscosity falls by {fall_1_k[wrong_index]:.2%} per kelvin at "
            f"{temperature_c[wrong_index]:.0f} degC",
            f"{smallest_fall:.1%} to {largest_fall:.0%} per kelvin, as oils have it",
        )


def _pressure_viscosity_faults(
    temperature_c: FloatArray, alpha_1_gpa: FloatArray
) -> Iterator[ImpossibleProperty]:
    """A pressure-viscosity coefficient that no oil has."""
    lowest_alpha, highest_alpha = _PRESSURE_VISCOSITY_1_GPA
    wrong_index = _first_wrong_index(
        ~((alpha_1_gpa >= lowest_alpha) & (alpha_1_gpa <= highest_alpha))
    )
    if wrong_index is None:
        return
    wrong_alpha_1_gpa = alpha_1_gpa[wrong_index]
    value_text = (
        f"{wrong_alpha_1_gpa:.3g} 1/GPa" if np.isfinite(wrong_alpha_1_gpa) else "not a number"
    )
    yield ImpossibleProperty(
        "pressure_viscosity",
        f"the pressure-viscosity coefficient at {temperature_c[wrong_index]:.0f} degC is "
        f"{value_text}",
        f"{lowest_alpha:g} to {highest_alpha:g} 1/GPa; `rule: given` takes measured rows",
    )


def _film_faults(
    temperature_c: FloatArray, viscosity_pa_s: FloatArray, alpha_1_gpa: FloatArray
) -> Iterator[ImpossibleProperty]:
    """A film thickness that changes too fast with temperature.

    Reference of the exponents: Hamrock and Dowson (1977).
    """
    log_film = _FILM_VISCOSITY_EXPONENT * np.log(viscosity_pa_s)
    log_film = log_film + _FILM_PRESSURE_EXPONENT * np.log(alpha_1_gpa)
    log_change_1_k = np.abs(np.diff(log_film) / np.diff(temperature_c))
    wrong_index = _first_wrong_index(log_change_1_k > _FILM_CHANGE_1_K)
    if wrong_index is not None:
        yield ImpossibleProperty(
            "pressure_viscosity",
            f"the film thickness changes by {np.expm1(log_change_1_k[wrong_index]):.0%} within one "
            f"kelvin at {temperature_c[wrong_index]:.0f} degC",
            f"at most {np.expm1(_FILM_CHANGE_1_K):.0%}: viscosity and pressure-viscosity "
            "coefficient change slowly",
        )


def unusual_properties(oil: Oil) -> Iterator[str]:
    """Sentences on properties that are unusual, although no law of physics contradicts them."""
    pole_k = oil.coefficients.get("pole_k")
    lowest_usual, highest_usual = _USUAL_POLE_K
    if oil.model == "vogel" and pole_k is not None and not lowest_usual <= pole_k <= highest_usual:
        yield (
            f"its three viscosities give Vogel's formula a pole at {pole_k:.0f} K; usual oils have "
            f"{lowest_usual:g} to {highest_usual:g} K, so that one viscosity may be mistyped"
        )
    slope = walther_slope(oil)
    lowest_usual, highest_usual = _USUAL_WALTHER_SLOPE
    if not lowest_usual <= slope <= highest_usual:
        yield (
            f"its viscosities at 40 and 100 degC give a Walther slope of {slope:.2f}; usual oils "
            f"have {lowest_usual:g} to {highest_usual:g}, so that one viscosity may be mistyped"
        )


def walther_slope(oil: Oil) -> float:
    """Slope B of Walther's line between 40 and 100 degC; see `oils.walther_coefficients`."""
    ends_c = np.array(STANDARD_RANGE_C)
    viscosity_cst = oil.kinematic_viscosity_m2_s(ends_c) * 1e6
    return walther_coefficients(ends_c - ABSOLUTE_ZERO_C, viscosity_cst)["viscosity_slope"]
