"""A grid of operating conditions, and traction and film thickness all over it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.curation.film_state import contact_state
from oilfilm.fitting.fitted import FittedLaw
from oilfilm.physics.contact import load_for_max_hertz_pressure
from oilfilm.physics.oils import Oil
from oilfilm.physics.rigs import Contact
from oilfilm.traction.law import CONDITIONS, Observations, to_internal
from oilfilm.units import PA_PER_GPA, FloatArray

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

    def places(self) -> pd.DataFrame:
        """Every place of the grid, a row each, the slip running fastest."""
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
        settings: `film` of the configuration: which film over which roughness.
    """

    contact: Contact
    oil: Oil
    settings: Mapping[str, Any]

    def over(self, grid: Grid) -> tuple[FloatArray, FloatArray]:
        """Film thickness in um and lambda, both of shape `grid.shape`.

        Null where the thermal reduction is asked for heat beyond its range.
        """
        places = grid.places()
        load_n = load_for_max_hertz_pressure(
            places["max_hertz_pressure_gpa"].to_numpy() * PA_PER_GPA,
            self.contact.radius_m,
            self.contact.reduced_modulus_pa,
        )
        state = contact_state(places.assign(load_n=load_n), self.contact, self.oil, self.settings)
        thickness, ratio = (
            state[name].to_numpy().reshape(grid.shape)
            for name in ("film_thickness_um", "lambda_ratio")
        )
        return thickness, ratio
