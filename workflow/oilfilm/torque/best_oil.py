"""The best oil of a bearing by cage slip: it holds the cage with a full film, at the least torque.

Where no oil holds the cage it is the one that slips least.

Decides: which oil is best at an operating point of a bearing.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from oilfilm.units import BoolArray, FloatArray

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


def enough_film(film: FloatArray, lambda_limit: float) -> tuple[BoolArray, BoolArray]:
    """Where a film is thick enough, and where it is or may be: unknown films are null.

    A choice that differs between the two depends on a film that the formula does not give.
    """
    enough = film > lambda_limit
    return enough, enough | np.isnan(film)


def best_index(
    slip: FloatArray, torque: FloatArray, enough: BoolArray, slip_limit: float
) -> IntArray:
    """Index of the best oil at each point, -1 where none has enough film.

    Args:
        slip: Cage slip, shape (oils, points).
        torque: Friction torque.
        enough: Whether the film is thick enough.
        slip_limit: Largest cage slip with which a cage counts as held.
    """
    among = enough & np.isfinite(slip)
    within = enough & (slip <= slip_limit)
    least_torque = np.where(within, torque, np.inf).argmin(axis=0)
    least_slip = np.where(among, slip, np.inf).argmin(axis=0)
    best = np.where(within.any(axis=0), least_torque, least_slip)
    return np.where(among.any(axis=0), best, -1)


def best_oils(cage_slip: pd.DataFrame, slip_limit: float, lambda_limit: float) -> pd.DataFrame:
    """The best oil (`best_oil`, empty where none has a full film) of each operating point."""
    oils = list(dict.fromkeys(cage_slip["oil"]))
    columns = ("cage_slip", "torque_n_m", "lambda_ratio")
    slip, torque, film = by_oil(cage_slip, oils, *columns)
    best = best_index(slip, torque, enough_film(film, lambda_limit)[0], slip_limit)
    return operating_points(cage_slip).assign(best_oil=np.array([*oils, ""])[best])
