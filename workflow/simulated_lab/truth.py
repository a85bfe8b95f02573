"""What is true in a simulated campaign: the traction of each oil, free of every rig's trouble.

One truth stands behind both rigs. On the traction rig it gives mu of the whole contact, in a
bearing mu at every point of its contacts.

Decides: the truth behind simulated logs of both rigs.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from oilfilm.base.errors import OilfilmError
from oilfilm.base.units import PA_PER_GPA, FloatArray
from oilfilm.bearing.ellipse import Grid, TractionLaw, grid
from oilfilm.physics.contact import Conditions, Contact, elliptical_contact
from oilfilm.physics.oils import Oil
from oilfilm.physics.thermal_traction import ThermalEhl, sliding_film, thermal_ehl_traction
from oilfilm.settings.base import present
from oilfilm.settings.resolved import Settings
from oilfilm.traction.laws.deng2026 import traction_coefficient

# A contact that carries nothing has no traction; the solver of a bearing passes such states.
_LEAST_LOAD_N, _LEAST_PRESSURE_GPA, _LEAST_SPEED_M_S = 1e-3, 1e-3, 1e-3
# Nodes across and along the ellipse, and slips, over which the two rigs are compared.
_COMPARED_NODES, _COMPARED_SLIPS = (12, 8), 8


class Truth(Protocol):
    """The traction of one oil."""

    def __call__(self, *conditions: FloatArray) -> FloatArray:
        """mu of the traction rig's contact.

        Args:
            conditions: Pressure in GPa, speed in m/s, temperature in degC, and S, 0 or more.
        """
        ...

    def at_points(self, rule: Grid, radius_y_m: FloatArray) -> TractionLaw:
        """mu at the points of other contacts.

        Args:
            rule: The points.
            radius_y_m: Reduced radius of the contacts across the rolling direction, broadcasting
                against them.
        """
        ...


def _carrying(at: Conditions) -> Conditions:
    """Contacts that carry something, if only a little."""
    return replace(
        at,
        load_n=np.fmax(at.load_n, _LEAST_LOAD_N),
        max_hertz_pressure_gpa=np.fmax(at.max_hertz_pressure_gpa, _LEAST_PRESSURE_GPA),
        entrainment_speed_m_s=np.fmax(at.entrainment_speed_m_s, _LEAST_SPEED_M_S),
    )


@dataclass(frozen=True)
class LawTruth:
    """The paper's law: mu of a contact by its p_max, at every point with the slip there.

    Attributes:
        constants: The twelve constants of Eqs 7-9.
    """

    constants: FloatArray

    def __call__(self, *conditions: FloatArray) -> FloatArray:
        """See `Truth`."""
        return traction_coefficient(self.constants, *conditions)

    def at_points(self, rule: Grid, radius_y_m: FloatArray) -> TractionLaw:
        """See `Truth`."""

        def law(at: Conditions, slide_roll_ratio: FloatArray) -> FloatArray:
            at = _carrying(at)
            contact = at.max_hertz_pressure_gpa, at.entrainment_speed_m_s, at.inlet_temperature_c
            return self(*contact, slide_roll_ratio)

        return law


@dataclass(frozen=True)
class FilmTruth:
    """A thermal, shear-thinning film: mu at every point by that point's own pressure and slip.

    Attributes:
        oil: The oil's properties.
        constants: Stresses and thermal properties of the bodies.
        rig: The traction rig's contact, which shows the mean over its points.
    """

    oil: Oil
    constants: ThermalEhl
    rig: Contact

    def __call__(self, *conditions: FloatArray) -> FloatArray:
        """See `Truth`."""
        gpa, speed, temperature, slip = conditions
        radius, modulus = self.rig.radius_m, self.rig.reduced_modulus_pa
        peak = np.asarray(gpa) * PA_PER_GPA
        return thermal_ehl_traction(
            self.oil, self.constants, peak, speed, temperature, slip, radius, modulus
        )

    def at_points(self, rule: Grid, radius_y_m: FloatArray) -> TractionLaw:
        """See `Truth`."""

        def law(at: Conditions, slide_roll_ratio: FloatArray) -> FloatArray:
            at = _carrying(at)
            contact = elliptical_contact(
                at.load_n, at.radius_x_m, radius_y_m, at.reduced_modulus_pa
            )
            peak = at.max_hertz_pressure_gpa * PA_PER_GPA
            pressure = peak * np.sqrt(1 - rule.along**2 - rule.across**2)
            at = replace(at, ellipticity=contact.ellipticity)
            film = sliding_film(
                self.oil, self.constants, at, pressure, slide_roll_ratio, contact.semi_axis_x_m
            )
            return film.shear_stress_pa / pressure

        return law


def true_tractions(settings: Settings, constants: Mapping[str, FloatArray]) -> dict[str, Truth]:
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
        known, contact = ThermalEhl(**thermal.model_dump()), known_contact(settings)
        return {oil: FilmTruth(settings.known_oil(oil), known, contact) for oil in campaign.oils}
    for oil in campaign.oils:
        if oil not in constants:
            raise OilfilmError(
                f"campaign {campaign.name!r}: no constants are printed for the oil {oil!r}; "
                f"the rig twin knows {', '.join(constants)}."
            )
    return {oil: LawTruth(constants[oil]) for oil in campaign.oils}


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


def misfit(truth: Truth, settings: Settings) -> float:
    """How far the truth at the points of a contact lies from that of the traction rig.

    Args:
        truth: Of one oil.
        settings: `campaign` (its `matrix` and `twin`) and `rigs`.

    Returns:
        Root-mean-square difference over the campaign's matrix and slips, between mu at the points,
        averaged over the traction rig's contact, and mu of that rig; relative to the latter.
    """
    campaign, rig = settings.campaign, known_contact(settings)
    levels = present(campaign.matrix, "matrix", "the campaign").model_dump().values()
    slip = np.linspace(0, present(campaign.twin, "twin", "the campaign").slip_max, _COMPARED_SLIPS)
    pressure, speed, temperature = (
        level.reshape(-1, 1, 1) for level in np.meshgrid(*levels, indexing="ij")
    )
    shape = np.broadcast_shapes(pressure.shape, (len(slip), 1))
    at = Conditions(
        load_n=np.broadcast_to(rig.load_n(pressure), shape),
        max_hertz_pressure_gpa=np.broadcast_to(pressure, shape),
        entrainment_speed_m_s=np.broadcast_to(speed, shape),
        inlet_temperature_c=np.broadcast_to(temperature, shape),
        radius_x_m=np.full(shape, rig.radius_m),
        reduced_modulus_pa=rig.reduced_modulus_pa,
    )
    rule = grid(*_COMPARED_NODES)
    local = truth.at_points(rule, np.asarray(rig.radius_m))
    mean = (local(at, slip[:, np.newaxis]) * rule.share).sum(axis=-1)
    shown = truth(pressure, speed, temperature, slip[:, np.newaxis])[..., 0]
    # what is left of equal ones is rounding
    return round(float(np.sqrt(np.mean((mean - shown) ** 2) / np.mean(shown**2))), 6)
