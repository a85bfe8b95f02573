"""Contact pressure, film thickness and lambda of points, as far as rig and oil are known."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.curation.points import LEAST_LOAD_N
from oilfilm.physics.contact import max_hertz_pressure
from oilfilm.physics.film import (
    central_film_thickness,
    lambda_ratio,
    minimum_film_thickness,
    thermal_loading_parameter,
    thermal_reduction_factor,
)
from oilfilm.physics.oils import Oil, oil_from_config
from oilfilm.physics.rigs import Contact, contact_of
from oilfilm.units import M_PER_UM, PA_PER_GPA

# Outside these no oil is a liquid lubricant, and the formulas of its properties overflow.
_OIL_TEMPERATURES_C = (-100.0, 500.0)
_THICKNESS = {"minimum": minimum_film_thickness, "central": central_film_thickness}


def with_film(points: pd.DataFrame, config: Mapping[str, Any]) -> pd.DataFrame:
    """Points with maximum Hertz pressure, film thickness, lambda and the film's judgement.

    Pressure needs the rig's geometry and materials, film and lambda the oil's properties as well;
    where they are not known the columns are null and the film "cannot be judged".
    """
    contacts = {name: contact_of(rig) for name, rig in config["rigs"].items()}
    oils = {name: oil and oil_from_config(oil) for name, oil in config["oils"].items()}
    points = points.assign(
        max_hertz_pressure_gpa=np.nan, film_thickness_um=np.nan, lambda_ratio=np.nan
    )
    for rig, contact in contacts.items():
        for name, oil in oils.items():
            rows = (points["rig"] == rig) & (points["oil"] == name)
            if contact is not None and rows.any():
                derived = contact_state(points[rows], contact, oil, config["film"])
                points.loc[rows, list(derived)] = derived
    known = points["lambda_ratio"].notna()
    full = points["lambda_ratio"] > config["gates"]["lambda_limit"]
    judgement = np.select([~known, full], ["cannot be judged", "full film"], "below limit")
    return points.assign(film_judgement=judgement)


def contact_state(
    points: pd.DataFrame, contact: Contact, oil: Oil | None, settings: Mapping[str, Any]
) -> pd.DataFrame:
    """Maximum Hertz pressure and, where the oil is known, film thickness and lambda.

    Args:
        points: Columns load_n, entrainment_speed_m_s, inlet_temperature_c and slide_roll_ratio.
        contact: The contact they are of.
        oil: The oil, None where its properties are not known.
        settings: `film` of the configuration.
    """
    load = points["load_n"].where(points["load_n"] > LEAST_LOAD_N).to_numpy()
    pressure_pa = max_hertz_pressure(load, contact.radius_m, contact.reduced_modulus_pa)
    derived = pd.DataFrame({"max_hertz_pressure_gpa": pressure_pa / PA_PER_GPA}, points.index)
    if oil is None:
        return derived
    speed = points["entrainment_speed_m_s"].where(points["entrainment_speed_m_s"] > 0).to_numpy()
    measured = points["inlet_temperature_c"]
    temperature = measured.where(measured.between(*_OIL_TEMPERATURES_C)).to_numpy()
    viscosity = oil.dynamic_viscosity_pa_s(temperature)
    film_m = _THICKNESS[settings["thickness"]](
        load_n=load,
        entrainment_speed_m_s=speed,
        dynamic_viscosity_pa_s=viscosity,
        pressure_viscosity_coefficient_1_pa=oil.pressure_viscosity_coefficient_1_pa(temperature),
        radius_x_m=contact.radius_m,
        reduced_modulus_pa=contact.reduced_modulus_pa,
    )
    if settings["thermal_reduction"]:
        film_m = film_m * thermal_reduction_factor(
            max_hertz_pressure_pa=pressure_pa,
            reduced_modulus_pa=contact.reduced_modulus_pa,
            slide_roll_ratio=points["slide_roll_ratio"].abs().to_numpy(),
            thermal_loading=thermal_loading_parameter(
                entrainment_speed_m_s=speed,
                dynamic_viscosity_pa_s=viscosity,
                temperature_viscosity_coefficient_1_k=(
                    oil.temperature_viscosity_coefficient_1_k(temperature)
                ),
                thermal_conductivity_w_mk=oil.thermal_conductivity_w_mk(temperature),
            ),
        )
    # outside the formulas' range, as with a broken thermocouple, a film is no film
    film_m = np.where(np.isfinite(film_m) & (film_m > 0), film_m, np.nan)
    roughness_m = contact.roughness_m(settings["roughness"])
    return derived.assign(
        film_thickness_um=film_m / M_PER_UM, lambda_ratio=lambda_ratio(film_m, roughness_m)
    )
