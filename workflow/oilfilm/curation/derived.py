"""What points have of their rig and oil: pressure, film, lambda, errors of calibration.

Decides: pressure, film and lambda of a point; the error of calibration that the points of a run
share.
"""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from oilfilm.physics.contact import max_hertz_pressure
from oilfilm.physics.film import contact_film
from oilfilm.physics.oils import Oil
from oilfilm.physics.rigs import Contact
from oilfilm.settings.config import FilmSettings
from oilfilm.settings.resolved import Settings
from oilfilm.settings.rig import Rig
from oilfilm.units import M_PER_UM, PA_PER_GPA

# No traction rig loads a contact less; below it F/W is noise over nothing.
LEAST_LOAD_N = 1e-6
# Column -> the column and the key of the rig file it comes from; relative but for temperature.
_RELATIVE = {
    "load_systematic_n": ("load_n", "load_relative"),
    "traction_force_systematic_n": ("traction_force_n", "traction_force_relative"),
    "entrainment_speed_systematic_m_s": ("entrainment_speed_m_s", "speed_relative"),
}


def with_film(points: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """Points with maximum Hertz pressure, film thickness, lambda and the film's judgement.

    Pressure needs the rig's geometry and materials, or is the stated one; film needs the oil's
    properties, lambda the roughness as well. Where they are not known the columns are null and the
    film "cannot be judged".
    """
    points = points.assign(
        max_hertz_pressure_gpa=np.nan, film_thickness_um=np.nan, lambda_ratio=np.nan
    )
    for (rig, oil_name), of_both in points.groupby(["rig", "oil"]):
        contact, oil_file = settings.rigs[str(rig)].contact(), settings.oils[str(oil_name)]
        if contact is not None:
            oil = oil_file.properties() if oil_file else None
            derived = contact_state(of_both, contact, oil, settings.film)
            points.loc[of_both.index, list(derived)] = derived
        elif "nominal_max_hertz_pressure_gpa" in points:
            # without geometry only the pressure that the log or its sheet states is known
            stated = of_both["nominal_max_hertz_pressure_gpa"]
            points.loc[of_both.index, "max_hertz_pressure_gpa"] = stated
    known = points["lambda_ratio"].notna()
    full = points["lambda_ratio"] > settings.gates.lambda_limit
    judgement = np.select([~known, full], ["cannot be judged", "full film"], "below limit")
    return points.assign(film_judgement=judgement)


def contact_state(
    points: pd.DataFrame, contact: Contact, oil: Oil | None, settings: FilmSettings
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
    thickness_m, lambda_ratio = contact_film(
        oil,
        contact,
        **settings.model_dump(),
        load_n=load,
        entrainment_speed_m_s=points["entrainment_speed_m_s"].to_numpy(),
        inlet_temperature_c=points["inlet_temperature_c"].to_numpy(),
        slide_roll_ratio=points["slide_roll_ratio"].to_numpy(),
    )
    return derived.assign(film_thickness_um=thickness_m / M_PER_UM, lambda_ratio=lambda_ratio)


def with_calibration(points: pd.DataFrame, rigs: Mapping[str, Rig]) -> pd.DataFrame:
    """Points with the standard uncertainty of each sensor's calibration.

    All points of a rig share these errors, so they are kept apart from the random ones; null
    where the rig file states none.
    """
    rig = points["rig"].astype("category")

    def from_rig(key: str) -> "pd.Series[float]":
        values = {name: getattr(file.calibration, key, None) for name, file in rigs.items()}
        return rig.map(values).astype(float)

    return points.assign(
        **{
            column: points[quantity].abs() * from_rig(key)
            for column, (quantity, key) in _RELATIVE.items()
        },
        inlet_temperature_systematic_c=from_rig("temperature_c"),
    )
