"""What is true in a simulated campaign: the traction of each oil, free of every rig's trouble."""

import itertools
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.errors import OilfilmError
from oilfilm.physics.oils import Oil
from oilfilm.physics.rigs import Contact
from oilfilm.physics.thermal_traction import ThermalEhl, thermal_ehl_traction
from oilfilm.settings.base import present
from oilfilm.settings.resolved import Settings
from oilfilm.traction.laws.deng2026 import traction_coefficient
from oilfilm.units import PA_PER_GPA, FloatArray

# P in GPa, U in m/s, T in degC and S, 0 or more -> mu
Traction = Callable[[FloatArray, FloatArray, FloatArray, FloatArray], FloatArray]


def true_tractions(settings: Settings, constants: Mapping[str, FloatArray]) -> dict[str, Traction]:
    """The traction that is true for each oil of a campaign.

    Args:
        settings: `campaign` and `rigs`; `oils` too where the campaign's truth is thermal EHL.
        constants: The printed constants of each oil, which are the truth otherwise.

    Raises:
        OilfilmError: The rig's geometry is unknown, or an oil has no printed constants.
    """
    campaign = settings.campaign
    thermal = present(campaign.twin, "twin", "the campaign").thermal_ehl
    if thermal is not None:
        known, contact = thermal.constants(), known_contact(settings)
        return {
            oil: partial(_thermal_ehl, settings.known_oil(oil), known, contact)
            for oil in campaign.oils
        }
    for oil in campaign.oils:
        if oil not in constants:
            raise OilfilmError(
                f"campaign {campaign.name!r}: no constants are printed for the oil {oil!r}; "
                f"the rig twin knows {', '.join(constants)}."
            )
    return {oil: partial(traction_coefficient, constants[oil]) for oil in campaign.oils}


def known_contact(settings: Settings) -> Contact:
    """The contact of the campaign's one rig.

    Raises:
        OilfilmError: Its geometry and materials were not recorded.
    """
    ((name, rig),) = settings.rigs.items()
    contact = rig.contact()
    if contact is None:
        raise OilfilmError(
            f"config/rigs/{name}.yaml: the rig twin needs a rig of known geometry; it has none."
        )
    return contact


def truth_grid(settings: Settings, constants: Mapping[str, FloatArray]) -> pd.DataFrame:
    """The true traction at the conditions of `extrapolation` in config, as table `truth_grid`.

    Raises:
        OilfilmError: As `true_tractions`.
    """
    contact = known_contact(settings)
    grids = []
    for oil, traction in true_tractions(settings, constants).items():
        for figure, conditions in settings.extrapolation.items():
            levels = conditions.model_dump()
            grid = pd.DataFrame(itertools.product(*levels.values()), columns=list(levels))
            mu = traction(*(grid[name].to_numpy(dtype=float) for name in levels))
            load_n = contact.load_n(grid["max_hertz_pressure_gpa"].to_numpy())
            grids.append(
                grid.assign(oil=oil, figure=figure, load_n=load_n, traction_coefficient=mu)
            )
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
