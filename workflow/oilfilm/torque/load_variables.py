"""Traction laws in a bearing: evaluated with contact pressure, load or dimensionless load.

Decides: how a law is evaluated in a bearing, with pressure or with load.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from oilfilm.bearing.ellipse import TractionLaw
from oilfilm.fits.fitted import FittedLaw
from oilfilm.physics.contact import Conditions, Contact, creep_slope
from oilfilm.traction.law import to_internal
from oilfilm.units import FloatArray, IndexArray

LOAD_VARIABLES = ("stress", "load", "dimensionless_load")
# A contact that is not pressed together has no creep; the solver passes such states.
_LEAST_RELATIVE_PRESSURE = 1e-9


@dataclass(frozen=True)
class LawInBearing:
    """A fitted law with its power law of stress taken as one of stress, of load or of W/(E' R^2).

    On the one ball and flat of a traction rig the three are equal: load goes with the cube of
    the stress, so that data which one fits the others fit as well, with a third of the exponents.
    In a bearing, with other balls and elliptical contacts, they differ; R is then Rx, the reduced
    radius along the rolling direction. A law that was fitted to load itself is the same with every
    load variable: it is given the load of the contact, or groups made with its Rx and E'.

    Attributes:
        fitted: The law.
        load_variable: One of `LOAD_VARIABLES`, or the name of a law on load.
        rig: Contact of the traction rig on which the law was fitted.
        floor: Smallest level of each condition that the power laws are given; they have no value
            at zero.
        internal: The law's internal constants: one row, shape (1, constants), or one row for each
            operating point of the bearing, shape (points, constants).
    """

    fitted: FittedLaw
    load_variable: str
    rig: Contact
    floor: Mapping[str, float]
    internal: FloatArray

    @classmethod
    def of(
        cls, fitted: FittedLaw, load_variable: str, rig: Contact, floor: Mapping[str, float]
    ) -> "LawInBearing":
        """A fitted law with the constants of its fit."""
        internal = to_internal(fitted.law, fitted.coefficients.constants)
        return cls(fitted, load_variable, rig, floor, np.atleast_2d(internal))

    def with_constants(self, constants: FloatArray) -> "LawInBearing":
        """The same law with other constants: one row, or one row for each operating point."""
        return replace(self, internal=to_internal(self.fitted.law, np.atleast_2d(constants)))

    def at_points(self, which: IndexArray) -> "LawInBearing":
        """See `TractionLaw`."""
        one = len(self.internal) == 1
        return self if one else replace(self, internal=self.internal[which])

    def __call__(self, at: Conditions, slide_roll_ratio: FloatArray) -> FloatArray:
        """See `TractionLaw`."""
        law = self.fitted.law
        levels = {
            "max_hertz_pressure_gpa": self._stress_gpa(at),
            "load_n": at.load_n,
            "entrainment_speed_m_s": at.entrainment_speed_m_s,
            "inlet_temperature_c": at.inlet_temperature_c,
        }
        conditions = np.stack(
            # a trial that is no number ends as no equilibrium
            [np.fmax(levels[name], self.floor[name]) for name in law.conditions],
            axis=-1,
        )
        law = law.in_contacts(at.radius_x_m.ravel(), at.reduced_modulus_pa)
        rows = conditions.reshape(-1, conditions.shape[-1])
        design = law.design(rows, self.fitted.coefficients.known)
        # the points are the third axis from the end, before contacts and nodes
        blocks = self.internal.reshape(len(self.internal), 1, 1, len(law.coefficients), -1)
        design = design.reshape(*conditions.shape[:-1], -1)
        sizes = np.exp(np.einsum("...d,...ld->l...", design, blocks))
        mu = law.value(sizes, slide_roll_ratio)
        # below the slips of the tests a law may grip harder than the bodies' creep lets it
        steel = creep_slope(np.fmax(at.relative_pressure, _LEAST_RELATIVE_PRESSURE), at.ellipticity)
        return np.minimum(mu, steel * slide_roll_ratio, out=mu)

    def _stress_gpa(self, at: Conditions) -> FloatArray:
        """Stress of the rig's contact where its load variable is that of the bearing's contact."""
        if self.load_variable == "stress":
            return at.max_hertz_pressure_gpa
        relative = at.load_n / self.rig.load_n(1.0)
        if self.load_variable == "dimensionless_load":
            of_rig = self.rig.reduced_modulus_pa * self.rig.radius_m**2
            relative = relative * of_rig / (at.reduced_modulus_pa * at.radius_x_m**2)
        return np.cbrt(relative)


@dataclass(frozen=True)
class JoinedLaw:
    """Several laws, each of some of the operating points.

    Attributes:
        laws: The laws, with constants for every point.
        number: Index of each point's law, shape (points,).
    """

    laws: Sequence[LawInBearing]
    number: IndexArray

    def __call__(self, at: Conditions, slide_roll_ratio: FloatArray) -> FloatArray:
        """See `TractionLaw`."""
        mu = np.empty_like(slide_roll_ratio)
        for number, law in enumerate(self.laws):
            if len(which := np.flatnonzero(self.number == number)):
                levels = {
                    name: value[..., which, :, :] if np.ndim(value) else value
                    for name, value in vars(at).items()
                }
                slip = slide_roll_ratio[..., which, :, :]
                mu[..., which, :, :] = law.at_points(which)(Conditions(**levels), slip)
        return mu

    def at_points(self, which: IndexArray) -> "JoinedLaw":
        """See `TractionLaw`."""
        return JoinedLaw([law.at_points(which) for law in self.laws], self.number[which])


def law_of_groups(laws: Sequence[LawInBearing], counts: Sequence[int]) -> TractionLaw:
    """The law of operating points that come in groups, each with its law.

    Laws that differ in their constants alone become one, with constants for each point.
    """
    keys = [(law.fitted.law, law.load_variable) for law in laws]
    kinds, joined = list(dict.fromkeys(keys)), []
    for kind in kinds:
        first = laws[keys.index(kind)]
        own = [law if key == kind else first for law, key in zip(laws, keys, strict=True)]
        rows = [
            np.resize(law.internal, (count, first.internal.shape[1]))
            for law, count in zip(own, counts, strict=True)
        ]
        joined.append(replace(first, internal=np.concatenate(rows)))
    number = np.repeat([kinds.index(key) for key in keys], counts)
    return joined[0] if len(joined) == 1 else JoinedLaw(joined, number)
