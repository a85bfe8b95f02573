"""The best oil of a bearing by cage slip: it holds the cage with a full film, at the least torque.

Where no oil holds the cage it is the one that slips least. Of oils that differ by rounding only the
first one in the campaign's order is taken.

An oil without an equilibrium, or one whose film the formula does not give, may be the best one.
Where the choice depends on such an oil the best oil is not known.

Decides: which oil is best at an operating point of a bearing, and where that is not known.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pandas as pd

from oilfilm.ties import exceeds, first_smallest, reaches
from oilfilm.units import BoolArray, FloatArray, IndexArray

IntArray = npt.NDArray[np.intp]
OPERATING_POINT = [
    "bearing",
    "inlet_temperature_c",
    "pitch_speed_mm_rpm",
    "inner_speed_rpm",
    "axial_load_n",
]


def operating_points(cage_slip: pd.DataFrame) -> pd.DataFrame:
    """The points of the map of cage slip, each once."""
    return cage_slip[OPERATING_POINT].drop_duplicates().reset_index(drop=True)


def by_oil(cage_slip: pd.DataFrame, oils: Sequence[str], *columns: str) -> list[FloatArray]:
    """Columns of the table of cage slip, each of shape (oils, operating points)."""
    wide = cage_slip.pivot(index=OPERATING_POINT, columns="oil", values=list(columns))
    wide = wide.loc[pd.MultiIndex.from_frame(operating_points(cage_slip))]
    return [wide[name][list(oils)].to_numpy(dtype=float).T for name in columns]


# In place of an oil's name, in tables.
NOT_KNOWN = "not known"


def enough_film(film: FloatArray, lambda_limit: float) -> tuple[BoolArray, BoolArray]:
    """Where a film is thick enough, and where it is or may be: unknown films are null."""
    enough = exceeds(film, lambda_limit)
    return enough, enough | np.isnan(film)


def best_index(
    slip: FloatArray, torque: FloatArray, enough: BoolArray, slip_limit: float
) -> IntArray:
    """Index of the best of the oils that have an equilibrium, -1 where none has enough film.

    Args:
        slip: Cage slip, shape (oils, ...); null without an equilibrium.
        torque: Friction torque.
        enough: Whether the film is thick enough.
        slip_limit: Largest cage slip with which a cage counts as held.
    """
    among = enough & np.isfinite(slip)
    within = among & reaches(slip_limit, slip)
    least_torque = first_smallest(np.where(within, torque, np.inf), axis=0)
    least_slip = first_smallest(np.where(among, slip, np.inf), axis=0)
    best = np.where(within.any(axis=0), least_torque, least_slip)
    return np.where(among.any(axis=0), best, -1)


@dataclass(frozen=True)
class Best:
    """The best oil of some points, each of shape (...).

    Attributes:
        oil: As of `best_index`, with the films that are known.
        lacks_equilibrium: True where an oil that may have enough film has no equilibrium.
        lacks_film: True where another oil is best if the unknown films are thick enough.
    """

    oil: IntArray
    lacks_equilibrium: BoolArray
    lacks_film: BoolArray

    @property
    def known(self) -> BoolArray:
        """True where no unknown equilibrium or film can change the choice."""
        return ~(self.lacks_equilibrium | self.lacks_film)


def best_of(
    slip: FloatArray, torque: FloatArray, film: FloatArray, slip_limit: float, lambda_limit: float
) -> Best:
    """The best oil at each point, and what is unknown of the choice.

    Args:
        slip: Cage slip, shape (oils, ...); null without an equilibrium.
        torque: Friction torque.
        film: Film thickness over roughness; null where the formula gives none.
        slip_limit: Largest cage slip with which a cage counts as held.
        lambda_limit: Full film above.
    """
    enough, perhaps = enough_film(film, lambda_limit)
    best = best_index(slip, torque, enough, slip_limit)
    return Best(
        best,
        np.asarray((perhaps & ~np.isfinite(slip)).any(axis=0)),
        np.asarray(best_index(slip, torque, perhaps, slip_limit) != best),
    )


def best_oils(cage_slip: pd.DataFrame, slip_limit: float, lambda_limit: float) -> pd.DataFrame:
    """The best oil of each operating point, `best_oil`.

    It is empty where none has a full film, and `NOT_KNOWN` where an unknown one may be better.
    """
    oils = list(dict.fromkeys(cage_slip["oil"]))
    slip, torque, film = by_oil(cage_slip, oils, "cage_slip", "torque_n_m", "lambda_ratio")
    best = best_of(slip, torque, film, slip_limit, lambda_limit)
    names = np.array([*oils, ""])[best.oil]
    return operating_points(cage_slip).assign(best_oil=np.where(best.known, names, NOT_KNOWN))


def best_shares(
    draws: FloatArray, oils: int, slip_limit: float, lambda_limit: float
) -> dict[str, FloatArray | IndexArray]:
    """How often each oil is the best one of its point among random draws.

    A draw has one drag, one bearing and one traction rig for all oils. A draw in which the best oil
    is not known counts for no oil.

    Args:
        draws: Torque, cage slip and lambda, shape (3, draws, oils * points), oil by oil.
        oils: Number of oils.
        slip_limit: Largest cage slip with which a cage counts as held.
        lambda_limit: Full film above.

    Returns:
        The columns `best_share`, `draws_answered` and `draws_unanswered` of the table of cage slip,
        each of shape (oils * points,); the share is null where no draw has an answer.
    """
    by_oil = draws.reshape(*draws.shape[:2], oils, draws.shape[-1] // oils)
    torque, slip, film = by_oil.swapaxes(1, 2)
    best = best_of(slip, torque, film, slip_limit, lambda_limit)
    answered = best.known.sum(axis=0)
    counts = [(best.known & (best.oil == oil)).sum(axis=0) for oil in range(oils)]
    shares = np.divide(counts, answered, out=np.full(np.shape(counts), np.nan), where=answered > 0)
    return {
        "best_share": shares.ravel(),
        "draws_answered": np.tile(answered, oils),
        "draws_unanswered": np.tile(len(slip[0]) - answered, oils),
    }


def stays_best(cage_slip: pd.DataFrame, share: float) -> pd.DataFrame:
    """Whether one oil is best in at least a share of the draws, at each operating point.

    Args:
        cage_slip: Table of cage slip.
        share: The share, of all draws.

    Returns:
        One row per point: `surely`, where it is so whatever the draws without an answer are;
        `perhaps`, where these draws decide; `draws_answered` and `draws_unanswered`.
    """
    names = ["best_share", "draws_answered", "draws_unanswered"]
    points = cage_slip.groupby(OPERATING_POINT, sort=False)[names].max()
    answered, unanswered = points["draws_answered"], points["draws_unanswered"]
    best, wanted = points["best_share"].fillna(0.0) * answered, share * (answered + unanswered)
    surely = reaches(best, wanted)
    return points.assign(surely=surely, perhaps=~surely & reaches(best + unanswered, wanted))
