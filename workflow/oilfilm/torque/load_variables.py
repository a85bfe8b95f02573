"""Traction laws in a bearing: evaluated with contact pressure, load or dimensionless load.

Decides: how a law is evaluated in a bearing, with pressure or with load.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.bearing.ellipse import TractionLaw
from oilfilm.fits.fitted import FittedLaw
from oilfilm.physics.contact import Conditions, Contact, creep_slope
from oilfilm.traction.law import to_internal

# Load variables of the campaign's law; `stress` is the maximum Hertz pressure.
LOAD_VARIABLES = ("stress", "load", "dimensionless_load")
# Smallest p_max/E' for the creep of the bodies. The solver may try contacts without load.
_SMALLEST_RELATIVE_PRESSURE = 1e-9


@dataclass(frozen=True)
class LawInBearing:
    """A fitted law whose power law of pressure is evaluated with pressure, load or W/(E' R^2).

    The pressure is the maximum Hertz pressure. With the ball and flat of one traction rig the three
    are equal: the load is proportional to the cube of the pressure. All three then fit the same
    data; with load, the exponents are a third of those with pressure. In a bearing they differ,
    because the balls have other sizes and the contacts are elliptical. R is then Rx, the reduced
    radius along the rolling direction.

    A law that was fitted to the load itself is the same with every load variable. It is evaluated
    with the load of the contact, or with dimensionless groups of the load, Rx and E'.

    Attributes:
        fitted: The fitted law.
        load_variable: One of `LOAD_VARIABLES`, or the name of a law on load.
        rig_contact: Contact of the traction rig on which the law was fitted.
        smallest_level_of_condition: Smallest level of each condition at which the power laws are
            evaluated. They have no value at zero.
        internal_constants: Internal constants of the law: one row, shape (1, constants), or one row
            for each operating point of the bearing, shape (points, constants).
    """

    fitted: FittedLaw
    load_variable: str
    rig_contact: Contact
    smallest_level_of_condition: Mapping[str, float]
    internal_constants: FloatArray

    @classmethod
    def from_fit(
        cls,
        fitted: FittedLaw,
        load_variable: str,
        rig_contact: Contact,
        smallest_level_of_condition: Mapping[str, float],
    ) -> "LawInBearing":
        """A fitted law with the constants of its fit."""
        internal_constants = to_internal(fitted.law, fitted.coefficients.constants)
        return cls(
            fitted,
            load_variable,
            rig_contact,
            smallest_level_of_condition,
            np.atleast_2d(internal_constants),
        )

    def with_constants(self, constants: FloatArray) -> "LawInBearing":
        """The same law with other constants: one row, or one row for each operating point."""
        return replace(
            self, internal_constants=to_internal(self.fitted.law, np.atleast_2d(constants))
        )

    def at_points(self, point_index: IndexArray) -> "LawInBearing":
        """See `TractionLaw`."""
        has_one_row = len(self.internal_constants) == 1
        return (
            self
            if has_one_row
            else replace(self, internal_constants=self.internal_constants[point_index])
        )

    def __call__(self, conditions: Conditions, slide_roll_ratio: FloatArray) -> FloatArray:
        """See `TractionLaw`."""
        law = self.fitted.law
        limited_conditions = self.limited_conditions(self._level_by_condition(conditions))
        law = law.in_contacts(conditions.radius_x_m.ravel(), conditions.reduced_modulus_pa)
        conditions_table = limited_conditions.reshape(-1, limited_conditions.shape[-1])
        design = law.design(conditions_table, self.fitted.coefficients.group_has_exponent)
        design = design.reshape(*limited_conditions.shape[:-1], -1)
        # axes: points, contacts, nodes, coefficients of the law, constants of a coefficient
        constants = self.internal_constants.reshape(
            len(self.internal_constants), 1, 1, len(law.coefficients), -1
        )
        coefficients_of_law = np.exp(np.einsum("...d,...ld->l...", design, constants))
        mu = law.mu_of_magnitudes(coefficients_of_law, slide_roll_ratio)
        # at small slip a law may give more traction than the creep of the bodies allows
        relative_pressure = np.fmax(conditions.relative_pressure, _SMALLEST_RELATIVE_PRESSURE)
        creep = creep_slope(relative_pressure, conditions.ellipticity)
        return np.minimum(mu, creep * slide_roll_ratio, out=mu)

    def limited_conditions(self, level_by_condition: Mapping[str, FloatArray]) -> FloatArray:
        """The law's conditions, none below its smallest level, shape (..., conditions).

        Args:
            level_by_condition: Levels of all conditions, of one shape.
        """
        # fmax replaces a NaN of a failed trial, which then ends without equilibrium
        limited_levels = [
            np.fmax(level_by_condition[name], self.smallest_level_of_condition[name])
            for name in self.fitted.law.conditions
        ]
        return np.stack(limited_levels, axis=-1)

    def is_below_smallest_level(self, conditions: Conditions) -> BoolArray:
        """Where one of the law's conditions is below its smallest level, shape of the contacts."""
        level_by_condition = self._level_by_condition(conditions)
        is_below = [
            level_by_condition[name] < self.smallest_level_of_condition[name]
            for name in self.fitted.law.conditions
        ]
        return np.asarray(np.any(is_below, axis=0))

    def _level_by_condition(self, conditions: Conditions) -> dict[str, FloatArray]:
        """Levels of the conditions of contacts, by the names that laws give them."""
        return {
            "max_hertz_pressure_gpa": self._equivalent_pressure_gpa(conditions),
            "load_n": conditions.load_n,
            "entrainment_speed_m_s": conditions.entrainment_speed_m_s,
            "inlet_temperature_c": conditions.inlet_temperature_c,
        }

    def _equivalent_pressure_gpa(self, conditions: Conditions) -> FloatArray:
        """Pressure at which the rig's contact has the load variable of the bearing's contact."""
        if self.load_variable == "stress":
            return conditions.max_hertz_pressure_gpa
        load_ratio = conditions.load_n / self.rig_contact.load_n(1.0)
        if self.load_variable == "dimensionless_load":
            rig_scale_n = self.rig_contact.reduced_modulus_pa * self.rig_contact.radius_m**2
            bearing_scale_n = conditions.reduced_modulus_pa * conditions.radius_x_m**2
            load_ratio = load_ratio * rig_scale_n / bearing_scale_n
        return np.cbrt(load_ratio)


@dataclass(frozen=True)
class JoinedLaw:
    """Several laws, each for some of the operating points.

    Attributes:
        laws: The laws, with constants for every point.
        law_index_of_point: Index of each point's law, shape (points,).
    """

    laws: Sequence[LawInBearing]
    law_index_of_point: IndexArray

    def __call__(self, conditions: Conditions, slide_roll_ratio: FloatArray) -> FloatArray:
        """See `TractionLaw`."""
        mu = np.empty_like(slide_roll_ratio)
        for law_index, law in enumerate(self.laws):
            point_index_of_law = np.flatnonzero(self.law_index_of_point == law_index)
            if len(point_index_of_law) == 0:
                continue
            # the last axes are points, contacts and nodes
            array_index = (..., point_index_of_law, slice(None), slice(None))
            law_of_these_points = law.at_points(point_index_of_law)
            mu[array_index] = law_of_these_points(
                conditions.select(*array_index), slide_roll_ratio[array_index]
            )
        return mu

    def at_points(self, point_index: IndexArray) -> "JoinedLaw":
        """See `TractionLaw`."""
        return JoinedLaw(
            [law.at_points(point_index) for law in self.laws], self.law_index_of_point[point_index]
        )


def join_laws(laws: Sequence[LawInBearing], point_counts: Sequence[int]) -> TractionLaw:
    """One law for all operating points, from the law of each group of points.

    Laws that differ only in their constants become one law, with constants for each point.

    Args:
        laws: Law of each group.
        point_counts: Number of operating points of each group.
    """
    # laws of one kind differ only in their constants
    kind_of_group = [(law.fitted.law, law.load_variable) for law in laws]
    kinds = list(dict.fromkeys(kind_of_group))
    laws_of_kinds = []
    for kind in kinds:
        first_of_kind = laws[kind_of_group.index(kind)]
        internal_constants_of_group = []
        for law, group_kind, point_count in zip(laws, kind_of_group, point_counts, strict=True):
            # groups of another kind have constants as well, which are not used
            internal_constants = (
                law.internal_constants if group_kind == kind else first_of_kind.internal_constants
            )
            internal_constants_of_group.append(
                np.resize(
                    internal_constants, (point_count, first_of_kind.internal_constants.shape[1])
                )
            )
        laws_of_kinds.append(
            replace(first_of_kind, internal_constants=np.concatenate(internal_constants_of_group))
        )
    if len(laws_of_kinds) == 1:
        return laws_of_kinds[0]
    law_index_of_point = np.repeat([kinds.index(kind) for kind in kind_of_group], point_counts)
    return JoinedLaw(laws_of_kinds, law_index_of_point)
