"""A grid of operating conditions, and traction and film thickness all over it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from oilfilm.fits.fitted import FittedLaw
from oilfilm.physics.contact import Contact
from oilfilm.physics.film import Thickness, contact_film
from oilfilm.physics.oils import Oil
from oilfilm.settings.resolved import Settings
from oilfilm.traction.law import CONDITIONS, QUANTITIES, Observations, to_internal
from oilfilm.units import M_PER_UM, FloatArray

AXES = (*CONDITIONS, "slide_roll_ratio")


@dataclass(frozen=True)
class Grid:
    """Levels of the three conditions and of the slip, each with each; all arrays rise."""

    max_hertz_pressure_gpa: FloatArray
    entrainment_speed_m_s: FloatArray
    inlet_temperature_c: FloatArray
    slide_roll_ratio: FloatArray

    @classmethod
    def spanning(
        cls, box: Mapping[str, Sequence[float]], levels: int, slide_roll_ratio: Sequence[float]
    ) -> "Grid":
        """`levels` of each condition from end to end of a box.

        Pressures and speeds have equal ratios, because the laws are power laws of them;
        temperatures, which are felt in degrees, have equal steps.
        """
        pressure, speed, temperature = (box[name] for name in CONDITIONS)
        return cls(
            np.geomspace(pressure[0], pressure[1], levels),
            np.geomspace(speed[0], speed[1], levels),
            np.linspace(temperature[0], temperature[1], levels),
            np.asarray(slide_roll_ratio, dtype=float),
        )

    def at(self, **levels: Sequence[float] | FloatArray) -> "Grid":
        """The grid with other levels on some of its axes."""
        return replace(
            self, **{name: np.asarray(values, dtype=float) for name, values in levels.items()}
        )

    @property
    def levels(self) -> tuple[FloatArray, ...]:
        """The levels of P, U, T and S."""
        return tuple(getattr(self, name) for name in AXES)

    @property
    def shape(self) -> tuple[int, ...]:
        """How many levels each of P, U, T and S has."""
        return tuple(len(levels) for levels in self.levels)

    def operating_points(self) -> pd.DataFrame:
        """Every point of the grid, one row per point, the slip running fastest."""
        mesh = np.meshgrid(*self.levels, indexing="ij")
        return pd.DataFrame({name: values.ravel() for name, values in zip(AXES, mesh, strict=True)})


def traction(law: FittedLaw, grid: Grid) -> FloatArray:
    """mu all over a grid, shape `grid.shape`, of a law with all its constants."""
    *levels, slip = grid.levels
    conditions = np.stack(np.meshgrid(*levels, indexing="ij"), axis=-1).reshape(-1, len(levels))
    at = Observations(
        law.law.design(conditions),
        np.repeat(np.arange(len(conditions)), len(slip)),
        np.tile(slip, len(conditions)),
    )
    internal = to_internal(law.law, law.coefficients.constants)
    return law.law.traction(internal, at).reshape(grid.shape)


@dataclass(frozen=True)
class Film:
    """What the film of one oil in one contact is calculated from.

    Attributes:
        contact: The contact.
        oil: The oil.
        thickness: Which film, as `film.thickness` of the configuration.
    """

    contact: Contact
    oil: Oil
    thickness: Thickness

    def over(self, grid: Grid) -> tuple[FloatArray, FloatArray]:
        """Film thickness in um and lambda, both of shape `grid.shape`.

        Null where the thermal reduction is asked for heat beyond its range.
        """
        pressure, speed, temperature, slip = np.meshgrid(*grid.levels, indexing="ij")
        thickness_m, lambda_ratio = contact_film(
            self.oil,
            self.contact,
            self.thickness,
            load_n=self.contact.load_n(pressure),
            entrainment_speed_m_s=speed,
            inlet_temperature_c=temperature,
            slide_roll_ratio=slip,
        )
        return thickness_m / M_PER_UM, lambda_ratio


def films(settings: Settings) -> dict[str, Film]:
    """Film of each oil with properties in the contact of the first rig that is known."""
    contacts = (rig.contact() for rig in settings.rigs.values())
    known = [each for each in contacts if each and not np.isnan(each.roughness_rq_m)]
    return {
        name: Film(known[0], oil.properties(), settings.film.thickness)
        for name, oil in settings.oils.items()
        if known and oil is not None
    }


def obstacle(law: FittedLaw) -> str:
    """Why a law has no value at any pressure, speed and temperature; empty where it has."""
    if law.law.conditions != CONDITIONS:
        return f"the law {law.law.name} is not one of pressure, speed and temperature"
    if np.isnan(law.coefficients.constants).any():
        return "nothing could be fitted"
    followed = zip(CONDITIONS, law.coefficients.known, strict=True)
    lacking = [QUANTITIES[name].symbol for name, known in followed if not known]
    return f"the effect of {', '.join(lacking)} alone is not known" if lacking else ""
