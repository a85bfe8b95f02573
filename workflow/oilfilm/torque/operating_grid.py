"""A grid of operating conditions, with traction and film thickness at its points."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from oilfilm.base.units import M_PER_UM, FloatArray
from oilfilm.fits.fitted import FittedLaw
from oilfilm.physics.contact import Contact
from oilfilm.physics.film import FilmKind, contact_film
from oilfilm.physics.oils import Oil
from oilfilm.settings.resolved import Settings
from oilfilm.traction.law import CONDITIONS, QUANTITIES, Observations, to_internal

# Names of the axes of a grid: pressure, speed, temperature and slip.
AXIS_NAMES = (*CONDITIONS, "slide_roll_ratio")


@dataclass(frozen=True)
class Grid:
    """All combinations of levels of the three conditions and of the slip.

    Each attribute has the levels of one axis in ascending order. Its name is one of `AXIS_NAMES`.
    """

    max_hertz_pressure_gpa: FloatArray
    entrainment_speed_m_s: FloatArray
    inlet_temperature_c: FloatArray
    slide_roll_ratio: FloatArray

    @classmethod
    def spanning(
        cls, box: Mapping[str, Sequence[float]], level_count: int, slide_roll_ratio: Sequence[float]
    ) -> "Grid":
        """A grid over a box of conditions.

        Pressures and speeds have equal ratios, because the laws are power laws of them.
        Temperatures have equal steps.

        Args:
            box: Lowest and highest level of each condition.
            level_count: Number of levels of each condition.
            slide_roll_ratio: The slips.
        """
        pressure, speed, temperature = (box[name] for name in CONDITIONS)
        return cls(
            np.geomspace(pressure[0], pressure[1], level_count),
            np.geomspace(speed[0], speed[1], level_count),
            np.linspace(temperature[0], temperature[1], level_count),
            np.asarray(slide_roll_ratio, dtype=float),
        )

    def with_levels(self, **levels: Sequence[float] | FloatArray) -> "Grid":
        """The grid with other levels on some of its axes.

        Args:
            levels: The levels of an axis by its name, one of `AXIS_NAMES`.
        """
        arrays = {name: np.asarray(values, dtype=float) for name, values in levels.items()}
        return replace(self, **arrays)

    @property
    def levels(self) -> tuple[FloatArray, ...]:
        """The levels of P, U, T and S."""
        return tuple(getattr(self, name) for name in AXIS_NAMES)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of levels of P, U, T and S."""
        return tuple(len(levels) for levels in self.levels)

    def operating_points(self) -> pd.DataFrame:
        """Every point of the grid, one row per point; the slip varies fastest."""
        mesh = np.meshgrid(*self.levels, indexing="ij")
        return pd.DataFrame(
            {name: values.ravel() for name, values in zip(AXIS_NAMES, mesh, strict=True)}
        )


def traction_on_grid(fitted: FittedLaw, grid: Grid) -> FloatArray:
    """mu at all points of a grid, shape `grid.shape`, of a law whose constants are all known."""
    pressure, speed, temperature, slip = grid.levels
    condition_mesh = np.meshgrid(pressure, speed, temperature, indexing="ij")
    conditions = np.stack(condition_mesh, axis=-1).reshape(-1, len(condition_mesh))
    observations = Observations(
        design=fitted.law.design(conditions),
        curve_of_point=np.repeat(np.arange(len(conditions)), len(slip)),
        slip=np.tile(slip, len(conditions)),
    )
    internal = to_internal(fitted.law, fitted.coefficients.constants)
    return fitted.law.traction(internal, observations).reshape(grid.shape)


@dataclass(frozen=True)
class OilFilm:
    """One oil in one contact, from which its film follows.

    Attributes:
        contact: The contact.
        oil: The oil.
        film_kind: Minimum or central film, `film.thickness` of the configuration.
    """

    contact: Contact
    oil: Oil
    film_kind: FilmKind

    def on_grid(self, grid: Grid) -> tuple[FloatArray, FloatArray]:
        """Film thickness in um and lambda, both of shape `grid.shape`.

        They are NaN outside the range of the thermal reduction.
        """
        pressure, speed, temperature, slip = np.meshgrid(*grid.levels, indexing="ij")
        thickness_m, lambda_ratio = contact_film(
            self.oil,
            self.contact,
            self.film_kind,
            load_n=self.contact.load_n(pressure),
            entrainment_speed_m_s=speed,
            inlet_temperature_c=temperature,
            slide_roll_ratio=slip,
        )
        return thickness_m / M_PER_UM, lambda_ratio


def film_by_oil(settings: Settings) -> dict[str, OilFilm]:
    """Film of each oil with known properties, in the contact of the first rig with a known one."""
    film_contact = None
    for rig in settings.rigs.values():
        contact = rig.contact()
        if contact is not None and not np.isnan(contact.roughness_rq_m):
            film_contact = contact
            break
    if film_contact is None:
        return {}
    return {
        name: OilFilm(film_contact, oil.properties(), settings.film.thickness)
        for name, oil in settings.oils.items()
        if oil is not None
    }


def reason_without_value(fitted: FittedLaw) -> str:
    """Reason why a law has no value at some pressure, speed and temperature; empty if it has."""
    if fitted.law.conditions != CONDITIONS:
        return f"the law {fitted.law.name} is not one of pressure, speed and temperature"
    if np.isnan(fitted.coefficients.constants).any():
        return "nothing could be fitted"
    symbols_not_followed = [
        QUANTITIES[name].symbol
        for name, is_followed in zip(
            CONDITIONS, fitted.coefficients.group_has_exponent, strict=True
        )
        if not is_followed
    ]
    if symbols_not_followed:
        return f"the effect of {', '.join(symbols_not_followed)} alone is not known"
    return ""
