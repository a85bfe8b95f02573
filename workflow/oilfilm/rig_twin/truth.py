"""What is true in a simulated campaign: the traction of each oil, free of every rig's trouble."""

import itertools
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.errors import OilfilmError
from oilfilm.physics.contact import load_for_max_hertz_pressure
from oilfilm.physics.oils import Oil, oil_from_config
from oilfilm.physics.rigs import Contact, contact_of
from oilfilm.physics.thermal_traction import ThermalEhl, thermal_ehl_traction
from oilfilm.traction.laws.deng2026 import traction_coefficient
from oilfilm.units import PA_PER_GPA, FloatArray

# P in GPa, U in m/s, T in degC and S, 0 or more -> mu
Traction = Callable[[FloatArray, FloatArray, FloatArray, FloatArray], FloatArray]


def true_tractions(
    config: Mapping[str, Any], constants: Mapping[str, FloatArray]
) -> dict[str, Traction]:
    """The traction that is true for each oil of a campaign.

    Args:
        config: `campaign` and `rigs`; `oils` as well where the campaign's truth is thermal EHL.
        constants: The printed constants of each oil, which are the truth otherwise.

    Raises:
        OilfilmError: The rig's geometry is unknown, or an oil has no printed constants.
    """
    campaign = config["campaign"]
    if "thermal_ehl" in campaign["twin"]:
        thermal, contact = ThermalEhl(**campaign["twin"]["thermal_ehl"]), known_contact(config)
        return {
            oil: partial(_thermal_ehl, oil_from_config(config["oils"][oil]), thermal, contact)
            for oil in campaign["oils"]
        }
    for oil in campaign["oils"]:
        if oil not in constants:
            raise OilfilmError(
                f"campaign {campaign['name']!r}: no constants are printed for the oil {oil!r}; "
                f"the rig twin knows {', '.join(constants)}."
            )
    return {oil: partial(traction_coefficient, constants[oil]) for oil in campaign["oils"]}


def known_contact(config: Mapping[str, Any]) -> Contact:
    """The contact of the campaign's one rig.

    Raises:
        OilfilmError: Its geometry and materials were not recorded.
    """
    ((name, rig),) = config["rigs"].items()
    contact = contact_of(rig)
    if contact is None:
        raise OilfilmError(
            f"config/rigs/{name}.yaml: the rig twin needs a rig of known geometry; it has none."
        )
    return contact


def truth_grid(config: Mapping[str, Any], constants: Mapping[str, FloatArray]) -> pd.DataFrame:
    """The true traction at the conditions of `extrapolation` in config, as table `truth_grid`.

    Raises:
        OilfilmError: As `true_tractions`.
    """
    contact = known_contact(config)
    grids = []
    for oil, traction in true_tractions(config, constants).items():
        for figure, levels in config["extrapolation"].items():
            grid = pd.DataFrame(itertools.product(*levels.values()), columns=list(levels))
            conditions = (
                "max_hertz_pressure_gpa",
                "entrainment_speed_m_s",
                "inlet_temperature_c",
                "slide_roll_ratio",
            )
            mu = traction(*(grid[name].to_numpy(dtype=float) for name in conditions))
            load_n = load_for_max_hertz_pressure(
                grid["max_hertz_pressure_gpa"].to_numpy() * PA_PER_GPA,
                contact.radius_m,
                contact.reduced_modulus_pa,
            )
            about = {"oil": oil, "figure": figure, "load_n": load_n}
            grids.append(grid.assign(**about, traction_coefficient=mu))
    return tables.conform(pd.concat(grids, ignore_index=True), "truth_grid", "truth of the twin")


def _thermal_ehl(
    oil: Oil,
    constants: ThermalEhl,
    contact: Contact,
    max_hertz_pressure_gpa: FloatArray,
    entrainment_speed_m_s: FloatArray,
    inlet_temperature_c: FloatArray,
    slide_roll_ratio: FloatArray,
) -> FloatArray:
    return thermal_ehl_traction(
        oil,
        constants,
        max_hertz_pressure_pa=np.asarray(max_hertz_pressure_gpa) * PA_PER_GPA,
        entrainment_speed_m_s=entrainment_speed_m_s,
        inlet_temperature_c=inlet_temperature_c,
        slide_roll_ratio=slide_roll_ratio,
        radius_m=contact.radius_m,
        reduced_modulus_pa=contact.reduced_modulus_pa,
    ).traction_coefficient
