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
import pandas as pd

from oilfilm.base.ties import exceeds, first_smallest, reaches
from oilfilm.base.units import BoolArray, FloatArray, IndexArray

OPERATING_POINT_COLUMNS = [
    "bearing",
    "inlet_temperature_c",
    "pitch_speed_mm_rpm",
    "inner_speed_rpm",
    "axial_load_n",
]


def distinct_operating_points(cage_slip_table: pd.DataFrame) -> pd.DataFrame:
    """The operating points of the table of cage slip, without repetition."""
    return cage_slip_table[OPERATING_POINT_COLUMNS].drop_duplicates().reset_index(drop=True)


def arrays_by_oil(
    cage_slip_table: pd.DataFrame, oil_names: Sequence[str], *column_names: str
) -> list[FloatArray]:
    """Some columns of the table of cage slip, each as an array of shape (oils, points).

    The points are those of `distinct_operating_points`, in the same order.
    """
    columns_by_oil = cage_slip_table.pivot(
        index=OPERATING_POINT_COLUMNS, columns="oil", values=list(column_names)
    )
    columns_by_oil = columns_by_oil.loc[
        pd.MultiIndex.from_frame(distinct_operating_points(cage_slip_table))
    ]
    return [
        columns_by_oil[column_name][list(oil_names)].to_numpy(dtype=float).T
        for column_name in column_names
    ]


# Entry of tables in place of an oil's name.
NOT_KNOWN = "not known"


def certain_and_possible_full_film(
    lambda_ratio: FloatArray, lambda_limit: float
) -> tuple[BoolArray, BoolArray]:
    """Where a film is known to be full, and where it is or may be full.

    An unknown film may be full.

    Args:
        lambda_ratio: Film thickness over roughness; NaN where it is not known.
        lambda_limit: A film is full above this ratio.
    """
    is_full = exceeds(lambda_ratio, lambda_limit)
    return is_full, is_full | np.isnan(lambda_ratio)


def index_of_best_oil(
    slip: FloatArray, torque: FloatArray, has_film: BoolArray, slip_limit: float
) -> IndexArray:
    """Index of the best oil of those with enough film and an equilibrium; -1 where there is none.

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
    best_candidate = np.where(holds_cage.any(axis=0), smallest_torque, smallest_slip)
    return np.where(is_candidate.any(axis=0), best_candidate, -1)


@dataclass(frozen=True)
class BestOil:
    """The best oil of operating points; each attribute has the shape of the points.

    Attributes:
        oil_index: Index of the best oil by `index_of_best_oil`. Films that are not known count as
            too thin.
        hinges_on_missing_equilibrium: True where an oil that may have enough film has no
            equilibrium.
        hinges_on_unknown_film: True where another oil would be best if the unknown films were thick
            enough.
    """

    oil_index: IndexArray
    hinges_on_missing_equilibrium: BoolArray
    hinges_on_unknown_film: BoolArray

    @property
    def is_known(self) -> BoolArray:
        """True where no unknown equilibrium or film can change the best oil."""
        return ~(self.hinges_on_missing_equilibrium | self.hinges_on_unknown_film)


def find_best_oil(
    slip: FloatArray,
    torque: FloatArray,
    lambda_ratio: FloatArray,
    slip_limit: float,
    lambda_limit: float,
) -> BestOil:
    """The best oil of each operating point, and whether it is known.

    Args:
        slip: Cage slip, shape (oils, ...); NaN without an equilibrium.
        torque: Friction torque, of the same shape.
        lambda_ratio: Film thickness over roughness, of the same shape; NaN where it is not known.
        slip_limit: Largest cage slip of a held cage.
        lambda_limit: A film is full above this ratio.
    """
    has_film, may_have_film = certain_and_possible_full_film(lambda_ratio, lambda_limit)
    best_oil_index = index_of_best_oil(slip, torque, has_film, slip_limit)
    best_index_with_unknown_films = index_of_best_oil(slip, torque, may_have_film, slip_limit)
    without_equilibrium = may_have_film & ~np.isfinite(slip)
    return BestOil(
        oil_index=best_oil_index,
        hinges_on_missing_equilibrium=np.asarray(without_equilibrium.any(axis=0)),
        hinges_on_unknown_film=np.asarray(best_index_with_unknown_films != best_oil_index),
    )


def best_oil_table(
    cage_slip_table: pd.DataFrame, slip_limit: float, lambda_limit: float
) -> pd.DataFrame:
    """The operating points with the column `best_oil`.

    `best_oil` is empty where no oil has a full film. It is `NOT_KNOWN` where an oil without a known
    equilibrium or film may be better.
    """
    oil_names = list(dict.fromkeys(cage_slip_table["oil"]))
    slip, torque, lambda_ratio = arrays_by_oil(
        cage_slip_table, oil_names, "cage_slip", "torque_n_m", "lambda_ratio"
    )
    best = find_best_oil(slip, torque, lambda_ratio, slip_limit, lambda_limit)
    best_oil_names = np.array([*oil_names, ""])[best.oil_index]
    return distinct_operating_points(cage_slip_table).assign(
        best_oil=np.where(best.is_known, best_oil_names, NOT_KNOWN)
    )


def best_shares(
    draws: FloatArray, oil_count: int, slip_limit: float, lambda_limit: float
) -> dict[str, FloatArray | IndexArray]:
    """Share of the draws in which each oil is the best oil of its operating point.

    The draws sample what is uncertain. All oils of a draw have the same drag, bearing and traction
    rig. Draws in which the best oil is not known are left out.

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
    best = find_best_oil(slip, torque, lambda_ratio, slip_limit, lambda_limit)
    answered_draw_count = best.is_known.sum(axis=0)
    best_draw_count = np.array(
        [
            (best.is_known & (best.oil_index == oil_index)).sum(axis=0)
            for oil_index in range(oil_count)
        ]
    )
    shares = np.divide(
        best_draw_count,
        answered_draw_count,
        out=np.full(best_draw_count.shape, np.nan),
        where=answered_draw_count > 0,
    )
    return {
        "best_share": shares.ravel(),
        "draws_answered": np.tile(answered_draw_count, oil_count),
        "draws_unanswered": np.tile(draw_count - answered_draw_count, oil_count),
    }


def certainty_of_best_oil(cage_slip_table: pd.DataFrame, share: float) -> pd.DataFrame:
    """How certain it is that one oil is best in a share of the draws, at each operating point.

    Args:
        cage_slip_table: Table of cage slip.
        share: Smallest share of all draws in which the oil must be best.

    Returns:
        One row per operating point, which is the index. `surely` is true if one oil reaches the
        share even if it is not best in any draw without an answer. `perhaps` is true if these draws
        decide. The other columns are `draws_answered`, `draws_unanswered` and `best_share`, the
        largest share of an oil in the draws with an answer.
    """
    draw_columns = ["best_share", "draws_answered", "draws_unanswered"]
    # the largest share of a point is that of its best oil; all its oils have as many draws
    largest_of_point = cage_slip_table.groupby(OPERATING_POINT_COLUMNS, sort=False)[
        draw_columns
    ].max()
    surely = is_best_in_share(largest_of_point, share)
    unanswered = largest_of_point["draws_unanswered"]
    best_draws, needed_draws = _best_and_needed_draws(largest_of_point, share)
    perhaps = ~surely & reaches(best_draws + unanswered, needed_draws)
    return largest_of_point.assign(surely=surely, perhaps=perhaps)


def is_best_in_share(cage_slip_table: pd.DataFrame, share: float) -> "pd.Series[bool]":
    """Whether the oil of each row is best in a share of the draws of its operating point.

    Draws without an answer count as draws in which another oil is best.

    Args:
        cage_slip_table: `best_share`, `draws_answered` and `draws_unanswered`.
        share: Smallest share of all draws.
    """
    best_draws, needed_draws = _best_and_needed_draws(cage_slip_table, share)
    return pd.Series(reaches(best_draws, needed_draws), cage_slip_table.index)


def _best_and_needed_draws(
    cage_slip_table: pd.DataFrame, share: float
) -> tuple["pd.Series[float]", "pd.Series[float]"]:
    """Draws in which the oil of each row is best, and those in which it must be."""
    answered = cage_slip_table["draws_answered"]
    best_draws = cage_slip_table["best_share"].fillna(0.0) * answered
    return best_draws, share * (answered + cage_slip_table["draws_unanswered"])
