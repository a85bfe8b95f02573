"""Film thickness against the worked checks of docs/physics.md and the exponents of its formulas."""

from functools import partial
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from campaigns import oil_of
from oilfilm.physics.contact import (
    Conditions,
    Contact,
    combined_roughness,
    ellipticity,
    load_for_max_hertz_pressure,
    reduced_modulus,
    rq_from_ra,
)
from oilfilm.physics.film import (
    InletOil,
    contact_film,
    film_thickness,
    isothermal_film_thickness,
    thermal_reduction_factor,
)

M50 = reduced_modulus(203e9, 0.29, 203e9, 0.29)
LOAD_N = load_for_max_hertz_pressure(1.5e9, 0.010, M50)
# docs/physics.md, check 1: 20 mm ball on a flat, MIL-L-23699 oil at 100 degC, 25 m/s, 1.5 GPa
CHECK_1: dict[str, Any] = {
    "load_n": LOAD_N,
    "max_hertz_pressure_gpa": 1.5,
    "inlet_temperature_c": 100.0,
    "entrainment_speed_m_s": 25.0,
    "dynamic_viscosity_pa_s": 5.006e-3,
    "pressure_viscosity_coefficient_1_pa": 1.103e-8,
    "radius_x_m": 0.010,
    "reduced_modulus_pa": M50,
}
# the rig's worst corner: 7808-type oil at 120 degC, properties as printed in docs/physics.md [C]
WORST_CORNER = CHECK_1 | {
    "dynamic_viscosity_pa_s": 2.09e-3,
    "pressure_viscosity_coefficient_1_pa": 0.681e-8,
}
RIG_ROUGHNESS_M = combined_roughness(rq_from_ra(0.014e-6), rq_from_ra(0.010e-6))


def isothermal(thickness: Literal["central", "minimum"], **arguments: Any) -> Any:
    names = ("dynamic_viscosity_pa_s", "pressure_viscosity_coefficient_1_pa")
    oil = InletOil(*(arguments.pop(name) for name in names), np.nan, np.nan)
    return isothermal_film_thickness(oil, Conditions(**arguments), thickness)


central, minimum = partial(isothermal, "central"), partial(isothermal, "minimum")
reduction = partial(thermal_reduction_factor, 1.5e9 / M50)
factors = st.floats(0.05, 20.0)
slips = st.floats(-2.0, 2.0)
thermal_loadings = st.floats(0.0, 10.0)


@pytest.mark.parametrize(
    ("race_mm", "minimum_um", "central_um"),
    [(52.291 / 2, 0.553, 0.690), (-77.706 / 2, 0.661, 0.828)],
)
def test_check_2_film_in_a_ball_bearing(
    race_mm: float, minimum_um: float, central_um: float
) -> None:
    # docs/physics.md, check 2 [C], printed to 0.0005 um. The published 0.557 and 0.665 are [M].
    ball_m, pitch_m = 12.700e-3, (52.291e-3 + 77.706e-3) / 2
    along = 1 / (2 / ball_m + 1e3 / race_mm)
    contact: dict[str, Any] = {
        "load_n": 5 * 8900 / 9,
        "max_hertz_pressure_gpa": np.nan,
        "inlet_temperature_c": np.nan,
        # inner ring 400 rad/s, outer at rest, by kinematics: u = omega (dm^2 - d^2)/(4 dm)
        "entrainment_speed_m_s": 400 * (pitch_m**2 - ball_m**2) / (4 * pitch_m),
        "dynamic_viscosity_pa_s": 0.04,
        "pressure_viscosity_coefficient_1_pa": 2.3e-8,
        "radius_x_m": along,
        "reduced_modulus_pa": reduced_modulus(200e9, 0.3, 200e9, 0.3),
        "ellipticity": ellipticity(along, 1 / (2 / ball_m - 1 / 6.604e-3)),
    }
    assert minimum(**contact) * 1e6 == pytest.approx(minimum_um, abs=0.0005)
    assert central(**contact) * 1e6 == pytest.approx(central_um, abs=0.0005)


def test_worst_corner_of_the_rig_has_the_printed_film() -> None:
    # docs/physics.md [C], printed to 0.0005 um
    assert minimum(**WORST_CORNER) * 1e6 == pytest.approx(0.092, abs=0.0005)
    assert central(**WORST_CORNER) * 1e6 == pytest.approx(0.155, abs=0.0005)


def test_worst_corner_of_the_rig_runs_at_the_printed_lambda() -> None:
    # docs/physics.md: lambda 3.9 with Rq 0.0215 um, printed to 0.05; thermally reduced, S = 0
    conductivity = 0.1333  # between 0.13395 at 367 K and 0.13265 at 422 K
    conditions = Conditions(LOAD_N, 1.5, 25.0, 120.0, 0.010, M50)
    film_m = film_thickness(
        InletOil(2.09e-3, 0.681e-8, 0.0145, conductivity), conditions, 0.0, "minimum"
    )
    assert film_m / RIG_ROUGHNESS_M == pytest.approx(3.9, abs=0.05)


@pytest.mark.parametrize(("thickness", "isothermal_um"), [("minimum", 0.211), ("central", 0.360)])
def test_film_of_an_oil_in_the_rig_is_that_of_check_1(
    thickness: Literal["minimum", "central"], isothermal_um: float
) -> None:
    # docs/physics.md, check 1 [C], printed to 0.0005 um; at S = 0.3
    film_m, lambda_ratio = contact_film(
        oil_of("4050"),
        Contact(0.010, float(M50), float(RIG_ROUGHNESS_M)),
        thickness,
        load_n=np.array(142.0),
        entrainment_speed_m_s=np.array(25.0),
        inlet_temperature_c=np.array([100.0, 1000.0]),  # no oil is liquid at the second
        slide_roll_ratio=np.array(0.3),
    )
    assert film_m[0] * 1e6 == pytest.approx(0.766 * isothermal_um, rel=0.005)
    assert lambda_ratio[0] == pytest.approx(0.766 * isothermal_um / 0.0215, rel=0.01)
    assert np.isnan(film_m[1])


# Hamrock and Dowson (1977): powers in the centre and at the sides
@pytest.mark.parametrize(
    ("quantity", "central_power", "minimum_power"),
    [("entrainment_speed_m_s", 0.67, 0.68), ("load_n", -0.067, -0.073)],
)
@given(factor=factors)
def test_film_follows_speed_and_load_by_the_published_powers(
    quantity: str, central_power: float, minimum_power: float, factor: float
) -> None:
    changed = CHECK_1 | {quantity: factor * CHECK_1[quantity]}
    assert central(**changed) / central(**CHECK_1) == pytest.approx(factor**central_power)
    assert minimum(**changed) / minimum(**CHECK_1) == pytest.approx(factor**minimum_power)


@given(slips, thermal_loadings)
def test_heating_never_thickens_the_film_of_either_surface(slip: float, loading: float) -> None:
    positive, negative = reduction(
        slide_roll_ratio=np.array([slip, -slip]), thermal_loading=loading
    )
    assert 0 < positive <= 1
    assert reduction(slide_roll_ratio=slip, thermal_loading=0.0) == 1
    assert positive == negative
