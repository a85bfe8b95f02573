"""The best oil of a bearing: full film, cage slip within its limit, and the smallest torque.

Where no oil keeps the cage within the slip limit, the best oil has the smallest slip. Of oils that
differ by rounding only, the first in the order of the campaign is the best.

An oil without an equilibrium, or outside the range of the film formula, may be the best oil. Where
the choice depends on such an oil, the best oil is not known.

Decides: which oil is best at an operating point of a bearing, and where that is not known.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pandas as pd

from oilfilm.base.ties import exceeds, first_smallest, reaches
from oilfilm.base.units import BoolArray, FloatArray, IndexArray

IntArray = npt.NDArray[np.intp]
OPERATING_POINT = [
    "bearing",
    "inlet_temperature_c",
    "pitch_speed_mm_rpm",
    "inner_speed_rpm",
    "axial_load_n",
]


def operating_points(cage_slip: pd.DataFrame) -> pd.DataFrame:
    """The operating points of the table of cage slip, without repetition."""
    return cage_slip[OPERATING_POINT].drop_duplicates().reset_index(drop=True)


def by_oil(cage_slip: pd.DataFrame, oils: Sequence[str], *columns: str) -> list[FloatArray]:
    """Columns of the table of cage slip, each of shape (oils, operating points)."""
    columns_by_oil = cage_slip.pivot(index=OPERATING_POINT, columns="oil", values=list(columns))
    columns_by_oil = columns_by_oil.loc[pd.MultiIndex.from_frame(operating_points(cage_slip))]
    return [columns_by_oil[name][list(oils)].to_numpy(dtype=float).T for name in columns]


# Entry for an oil's name in tables.
NOT_KNOWN = "not known"


def enough_film(lambda_ratio: FloatArray, lambda_limit: float) -> tuple[BoolArray, BoolArray]:
    """Whether a film is thick enough, and whether it may be: an unknown film may be.

    Args:
        lambda_ratio: Film thickness over roughness; NaN where it is not known.
        lambda_limit: A film is full above this ratio.
    """
    is_enough = exceeds(lambda_ratio, lambda_limit)
    return is_enough, is_enough | np.isnan(lambda_ratio)


def best_index(
    slip: FloatArray, torque: FloatArray, has_film: BoolArray, slip_limit: float
) -> IntArray:
    """Index of the best oil of those with an equilibrium; -1 where none has enough film.

    Args:
        slip: Cage slip, shape (oils, ...); NaN without an equilibrium.
        torque: Friction torque, of the same shape.
        has_film: Whether the film is thick enough, of the same shape.
        slip_limit: Largest cage slip of a held cage.
    """
    is_candidate = has_film & np.isfinite(slip)
    holds_cage = is_candidate & reaches(slip_limit, slip)
    smallest_torque = first_smallest(np.where(holds_cage, torque, np.inf), axis=0)
    smallest_slip = first_smallest(np.where(is_candidate, slip, np.inf), axis=0)
    best = np.where(holds_cage.any(axis=0), smallest_torque, smallest_slip)
    return np.where(is_candidate.any(axis=0), best, -1)


@dataclass(frozen=True)
class Best:
    """The best oil of operating points; each attribute has the same shape.

    Attributes:
        oil: Index by `best_index`, with the known films alone.
        lacks_equilibrium: True where an oil that may have enough film has no equilibrium.
        lacks_film: True where another oil is best if the unknown films are thick enough.
    """

    oil: IntArray
    lacks_equilibrium: BoolArray
    lacks_film: BoolArray

    @property
    def is_known(self) -> BoolArray:
        """True where no unknown equilibrium or film can change the best oil."""
        return ~(self.lacks_equilibrium | self.lacks_film)


def best_of(
    slip: FloatArray,
    torque: FloatArray,
    lambda_ratio: FloatArray,
    slip_limit: float,
    lambda_limit: float,
) -> Best:
    """The best oil of each operating point, and whether it is known.

    Args:
        slip: Cage slip, shape (oils, ...); NaN without an equilibrium.
        torque: Friction torque, of the same shape.
        lambda_ratio: Film thickness over roughness, of the same shape; NaN where it is not known.
        slip_limit: Largest cage slip of a held cage.
        lambda_limit: A film is full above this ratio.
    """
    has_film, may_have_film = enough_film(lambda_ratio, lambda_limit)
    best_oil = best_index(slip, torque, has_film, slip_limit)
    best_with_unknown_films = best_index(slip, torque, may_have_film, slip_limit)
    without_equilibrium = may_have_film & ~np.isfinite(slip)
    return Best(
        oil=best_oil,
        lacks_equilibrium=np.asarray(without_equilibrium.any(axis=0)),
        lacks_film=np.asarray(best_with_unknown_films != best_oil),
    )


def best_oils(cage_slip: pd.DataFrame, slip_limit: float, lambda_limit: float) -> pd.DataFrame:
    """The operating points with the column `best_oil`.

    `best_oil` is empty where no oil has a full film. It is `NOT_KNOWN` where an oil without a known
    equilibrium or film may be better.
    """
    oils = list(dict.fromkeys(cage_slip["oil"]))
    slip, torque, lambda_ratio = by_oil(cage_slip, oils, "cage_slip", "torque_n_m", "lambda_ratio")
    best = best_of(slip, torque, lambda_ratio, slip_limit, lambda_limit)
    oil_names = np.array([*oils, ""])[best.oil]
    return operating_points(cage_slip).assign(
        best_oil=np.where(best.is_known, oil_names, NOT_KNOWN)
    )


def best_shares(
    draws: FloatArray, oil_count: int, slip_limit: float, lambda_limit: float
) -> dict[str, FloatArray | IndexArray]:
    """Share of the draws in which each oil is the best oil of its operating point.

    A draw has the same drag, bearing and traction rig for all oils. A draw in which the best oil is
    not known counts for no oil.

    Args:
        draws: Torque, cage slip and lambda, shape (3, draws, oil_count * points). All points of an
            oil are next to each other.
        oil_count: Number of oils.
        slip_limit: Largest cage slip of a held cage.
        lambda_limit: A film is full above this ratio.

    Returns:
        The columns `best_share`, `draws_answered` and `draws_unanswered` of the table of cage slip,
        each of shape (oil_count * points,). The share is null where no draw has an answer.
    """
    quantity_count, draw_count, column_count = draws.shape
    draws_by_oil = draws.reshape(quantity_count, draw_count, oil_count, column_count // oil_count)
    torque, slip, lambda_ratio = draws_by_oil.swapaxes(1, 2)
    best = best_of(slip, torque, lambda_ratio, slip_limit, lambda_limit)
    answered_draws = best.is_known.sum(axis=0)
    draws_with_best_oil = np.array(
        [(best.is_known & (best.oil == oil)).sum(axis=0) for oil in range(oil_count)]
    )
    shares = np.divide(
        draws_with_best_oil,
        answered_draws,
        out=np.full(draws_with_best_oil.shape, np.nan),
        where=answered_draws > 0,
    )
    return {
        "best_share": shares.ravel(),
        "draws_answered": np.tile(answered_draws, oil_count),
        "draws_unanswered": np.tile(draw_count - answered_draws, oil_count),
    }


def stays_best(cage_slip: pd.DataFrame, share: float) -> pd.DataFrame:
    """Whether one oil is best in at least a share of the draws, at each operating point.

    Args:
        cage_slip: Table of cage slip.
        share: Share of all draws.

    Returns:
        One row per operating point. `surely` is true if one oil reaches the share without the draws
        that have no answer. `perhaps` is true if it depends on these draws. The other columns are
        `draws_answered` and `draws_unanswered`.
    """
    columns = ["best_share", "draws_answered", "draws_unanswered"]
    draws_of_points = cage_slip.groupby(OPERATING_POINT, sort=False)[columns].max()
    answered, unanswered = draws_of_points["draws_answered"], draws_of_points["draws_unanswered"]
    best_draws = draws_of_points["best_share"].fillna(0.0) * answered
    needed_draws = share * (answered + unanswered)
    surely = reaches(best_draws, needed_draws)
    perhaps = ~surely & reaches(best_draws + unanswered, needed_draws)
    return draws_of_points.assign(surely=surely, perhaps=perhaps)
