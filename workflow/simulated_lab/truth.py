"""The truth of a simulated campaign: the traction of each oil, without errors of any rig.

Traction rig and torque rig have the same truth. It gives mu of the whole contact on the traction
rig, and local mu at every quadrature node of the contacts in a bearing.

Decides: the truth behind simulated logs of both rigs.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, Protocol

import numpy as np

from oilfilm.base.errors import OilfilmError
from oilfilm.base.units import PA_PER_GPA, FloatArray
from oilfilm.bearing.ellipse import QuadratureRule, TractionLaw, gauss_rule
from oilfilm.physics.contact import Conditions, Contact, elliptical_contact
from oilfilm.physics.oils import Oil
from oilfilm.physics.thermal_traction import ThermalEhlConstants, sliding_film, thermal_ehl_traction
from oilfilm.settings.base import required_value
from oilfilm.settings.resolved import Settings
from oilfilm.traction.laws.deng2026 import traction_coefficient

# Lowest conditions at which a truth is evaluated. The solver of a bearing also tries contacts
# without load or speed, where the formulas have no value.
_LEAST_LOAD_N = 1e-3
_LEAST_PRESSURE_GPA = 1e-3
_LEAST_SPEED_M_S = 1e-3
# Comparison of both forms of a truth: numbers of quadrature nodes across and along the ellipse, and
# number of slips.
_COMPARED_NODE_COUNTS = (12, 8)
_COMPARED_SLIP_COUNT = 8
# Decimals of their misfit. Two forms of the same truth differ by rounding only, which must be 0.
_MISFIT_DECIMALS = 6


class TrueTraction(Protocol):
    """The traction of one oil.

    Attributes:
        depends_on_ellipse: True if local mu depends on the shape of the contact.
    """

    depends_on_ellipse: ClassVar[bool]

    def __call__(self, *conditions_and_slip: FloatArray) -> FloatArray:
        """mu of the traction rig's contact.

        Args:
            conditions_and_slip: Maximum Hertz pressure in GPa, entrainment speed in m/s, inlet
                temperature in degC, and slide-roll ratio, 0 or more.
        """
        ...

    def local_law(self, rule: QuadratureRule, radius_y_m: FloatArray) -> TractionLaw:
        """The law that gives local mu at quadrature nodes of other contacts, as in a bearing.

        Args:
            rule: The quadrature nodes.
            radius_y_m: Reduced radius of the contacts across the rolling direction. It broadcasts
                against (operating points, contacts, nodes).
        """
        ...


def _positive(conditions: Conditions) -> Conditions:
    """Conditions with a load, a pressure and a speed above zero."""
    # fmax replaces a NaN of a failed trial, which then ends without equilibrium
    return replace(
        conditions,
        load_n=np.fmax(conditions.load_n, _LEAST_LOAD_N),
        max_hertz_pressure_gpa=np.fmax(conditions.max_hertz_pressure_gpa, _LEAST_PRESSURE_GPA),
        entrainment_speed_m_s=np.fmax(conditions.entrainment_speed_m_s, _LEAST_SPEED_M_S),
    )


@dataclass(frozen=True)
class LawTruth:
    """The paper's law. Local mu follows from p_max of the contact and from the local slip.

    It needs neither the node's position nor the contact's shape.

    Attributes:
        constants: The twelve constants of Eqs 7-9.
    """

    depends_on_ellipse: ClassVar[bool] = False
    constants: FloatArray

    def __call__(self, *conditions_and_slip: FloatArray) -> FloatArray:
        """See `TrueTraction`."""
        return traction_coefficient(self.constants, *conditions_and_slip)

    def local_law(self, rule: QuadratureRule, radius_y_m: FloatArray) -> TractionLaw:
        """See `TrueTraction`."""

        def local_mu(conditions: Conditions, slide_roll_ratio: FloatArray) -> FloatArray:
            """mu at each node of the contact."""
            positive_conditions = _positive(conditions)
            return self(
                positive_conditions.max_hertz_pressure_gpa,
                positive_conditions.entrainment_speed_m_s,
                positive_conditions.inlet_temperature_c,
                slide_roll_ratio,
            )

        return local_mu


@dataclass(frozen=True)
class FilmTruth:
    """A thermal, shear-thinning film. Local mu follows from the local pressure and slip.

    Attributes:
        oil: The oil's properties.
        film_constants: Shear stresses of the film and thermal properties of the bodies.
        rig_contact: The traction rig's contact. Its mu is the mean over the whole contact.
    """

    depends_on_ellipse: ClassVar[bool] = True
    oil: Oil
    film_constants: ThermalEhlConstants
    rig_contact: Contact

    def __call__(self, *conditions_and_slip: FloatArray) -> FloatArray:
        """See `TrueTraction`."""
        pressure_gpa, speed_m_s, temperature_c, slip = conditions_and_slip
        return thermal_ehl_traction(
            self.oil,
            self.film_constants,
            np.asarray(pressure_gpa) * PA_PER_GPA,
            speed_m_s,
            temperature_c,
            slip,
            self.rig_contact.radius_m,
            self.rig_contact.reduced_modulus_pa,
        )

    def local_law(self, rule: QuadratureRule, radius_y_m: FloatArray) -> TractionLaw:
        """See `TrueTraction`."""

        def local_mu(conditions: Conditions, slide_roll_ratio: FloatArray) -> FloatArray:
            """mu at each node of the contact."""
            positive_conditions = _positive(conditions)
            contact = elliptical_contact(
                positive_conditions.load_n,
                positive_conditions.radius_x_m,
                radius_y_m,
                positive_conditions.reduced_modulus_pa,
            )
            max_pressure_pa = positive_conditions.max_hertz_pressure_gpa * PA_PER_GPA
            # Hertz's pressure at each node
            pressure_pa = max_pressure_pa * np.sqrt(1 - rule.along**2 - rule.across**2)
            film = sliding_film(
                self.oil,
                self.film_constants,
                replace(positive_conditions, ellipticity=contact.ellipticity),
                pressure_pa,
                slide_roll_ratio,
                contact.semi_axis_x_m,
            )
            return film.shear_stress_pa / pressure_pa

        return local_mu


def true_tractions(
    settings: Settings, constants_by_oil: Mapping[str, FloatArray]
) -> dict[str, TrueTraction]:
    """The true traction of each oil of a campaign: a thermal EHL film, or the paper's law.

    Args:
        settings: `campaign` and `rigs`; for a film also `oils`.
        constants_by_oil: The printed constants of each oil, for the paper's law.

    Raises:
        OilfilmError: The rig's geometry is unknown, or an oil has no printed constants.
    """
    campaign = settings.campaign
    thermal_ehl = required_value(campaign.twin, "twin", "the campaign").thermal_ehl
    if thermal_ehl is not None:
        film_constants = ThermalEhlConstants(**thermal_ehl.model_dump())
        rig_contact = contact_of_only_rig(settings)
        return {
            oil: FilmTruth(settings.oil_with_properties(oil), film_constants, rig_contact)
            for oil in campaign.oils
        }
    for oil in campaign.oils:
        if oil not in constants_by_oil:
            raise OilfilmError(
                f"campaign {campaign.name!r}: no constants are printed for the oil {oil!r}; "
                f"the rig twin has constants of {', '.join(constants_by_oil)}."
            )
    return {oil: LawTruth(constants_by_oil[oil]) for oil in campaign.oils}


def contact_of_only_rig(settings: Settings) -> Contact:
    """The contact of the campaign's one rig.

    Raises:
        OilfilmError: Its geometry and materials were not recorded.
    """
    ((rig_name, rig),) = settings.rigs.items()
    contact = rig.contact()
    if contact is None:
        raise OilfilmError(
            f"config/rigs/{rig_name}.yaml: the rig twin needs a rig of known geometry; it has none."
        )
    return contact


def truth_misfit(true_traction: TrueTraction, settings: Settings) -> float:
    """Relative difference between both forms of a truth: local mu and mu of the traction rig.

    Local mu is averaged over the traction rig's contact, weighted with the load of each node. The
    average must be mu of the traction rig.

    Args:
        true_traction: Truth of one oil.
        settings: `campaign` (its `matrix` and `twin`) and `rigs`.

    Returns:
        Root-mean-square difference over the campaign's matrix and some slips, relative to the
        root-mean-square mu of the traction rig.
    """
    campaign = settings.campaign
    rig_contact = contact_of_only_rig(settings)
    matrix = required_value(campaign.matrix, "matrix", "the campaign")
    slip_max = required_value(campaign.twin, "twin", "the campaign").slip_max
    grid = np.meshgrid(
        matrix.max_hertz_pressure_gpa,
        matrix.entrainment_speed_m_s,
        matrix.inlet_temperature_c,
        indexing="ij",
    )
    # axes: conditions of the matrix, slips, quadrature nodes
    pressure_gpa, speed_m_s, temperature_c = (axis_values.reshape(-1, 1, 1) for axis_values in grid)
    slip = np.linspace(0, slip_max, _COMPARED_SLIP_COUNT).reshape(1, -1, 1)
    shape = np.broadcast_shapes(pressure_gpa.shape, slip.shape)
    conditions = Conditions(
        load_n=np.broadcast_to(rig_contact.load_n(pressure_gpa), shape),
        max_hertz_pressure_gpa=np.broadcast_to(pressure_gpa, shape),
        entrainment_speed_m_s=np.broadcast_to(speed_m_s, shape),
        inlet_temperature_c=np.broadcast_to(temperature_c, shape),
        radius_x_m=np.full(shape, rig_contact.radius_m),
        reduced_modulus_pa=rig_contact.reduced_modulus_pa,
    )
    rule = gauss_rule(*_COMPARED_NODE_COUNTS)
    local_law = true_traction.local_law(rule, np.asarray(rig_contact.radius_m))
    mean_mu = (local_law(conditions, slip) * rule.load_share).sum(axis=-1)
    rig_mu = true_traction(pressure_gpa, speed_m_s, temperature_c, slip)[..., 0]
    relative_rms = float(np.sqrt(np.mean((mean_mu - rig_mu) ** 2) / np.mean(rig_mu**2)))
    return round(relative_rms, _MISFIT_DECIMALS)
