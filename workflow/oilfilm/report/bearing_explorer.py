"""Data of the report's explorer of a bearing: torque, loss, cage slip and best oil at any point.

`bearing.js` interpolates between the operating points that the workflow has calculated, so that the
page needs no friction equilibrium. The map of cage slip has one oil temperature. The change by
another temperature comes from a coarser map of several temperatures.

Decides: from which calculated points the bearing's explorer interpolates.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.base.units import FloatArray
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.bearing_torque import every_second_level

# Column of the tables of each value, by the name of the value in the page.
_COLUMN_OF_VALUE = {
    "torque": "torque_n_m",
    "torqueLower": "torque_n_m_lower",
    "torqueUpper": "torque_n_m_upper",
    "slip": "cage_slip",
    "slipLower": "cage_slip_lower",
    "slipUpper": "cage_slip_upper",
    "film": "lambda_ratio",
    "share": "best_share",
}
_AXIAL_LOAD, _INNER_SPEED, _OIL_TEMPERATURE = (
    "axial_load_n",
    "inner_speed_rpm",
    "inlet_temperature_c",
)
# Column, label and unit of each axis, by the name of the axis in the page.
_AXES = {
    "load": (_AXIAL_LOAD, "Axial load", "N"),
    "speed": (_INNER_SPEED, "Speed of the inner ring", "rpm"),
    "temperature": (_OIL_TEMPERATURE, "Oil temperature", "\N{DEGREE SIGN}C"),
}
# Least number of steps of a slider; fewer where a step would be below 1.
_FEWEST_STEPS = 200
# Significant digits of the values in the page.
_DIGITS = 5


def bearing_explorer_data(results: CampaignTables, settings: Settings) -> dict[str, Any] | None:
    """Everything that the bearing's explorer needs, as plain values for JSON.

    Args:
        results: Tables `cage_slip` and `cage_slip_by_temperature`.
        settings: All settings of the campaign.

    Returns:
        `axes`: the sliders. `temperature`: oil temperature of `fine`. `fine` and `coarse`: levels
        of load, speed and temperature, and by oil the values at all their combinations, with the
        temperature fastest. None where the campaign has no map of cage slip.
    """
    fine_map = results.cage_slip
    if fine_map.empty:
        return None
    coarse_map = pd.concat([_at_coarse_levels(fine_map), results.cage_slip_by_temperature])
    coarse_levels = {
        name: sorted(coarse_map[column].unique()) for name, (column, *_) in _AXES.items()
    }
    fine_levels = {name: sorted(fine_map[column].unique()) for name, (column, *_) in _AXES.items()}
    oils = list(dict.fromkeys(fine_map["oil"]))
    return {
        "campaign": settings.campaign.name,
        "bearing": str(fine_map["bearing"].iloc[0]),
        "slipLimit": settings.bearing.cage_slip.slip_limit,
        "filmLimit": settings.gates.lambda_limit,
        "axes": [_slider(name, fine_levels, coarse_levels) for name in _AXES],
        "temperature": fine_levels["temperature"][0],
        "fine": {"levels": list(fine_levels.values()), "oils": _values_of_oils(fine_map, oils)},
        "coarse": {
            "levels": list(coarse_levels.values()),
            "oils": _values_of_oils(coarse_map, oils),
        },
        "oils": oils,
    }


def _at_coarse_levels(fine_map: pd.DataFrame) -> pd.DataFrame:
    """Rows of the map of cage slip at every second level of load and speed."""
    loads = every_second_level(fine_map[_AXIAL_LOAD].unique().tolist())
    speeds = every_second_level(fine_map[_INNER_SPEED].unique().tolist())
    return fine_map[fine_map[_AXIAL_LOAD].isin(loads) & fine_map[_INNER_SPEED].isin(speeds)]


def _slider(
    name: str, fine_levels: dict[str, list[float]], coarse_levels: dict[str, list[float]]
) -> dict[str, Any]:
    """A slider over one of `_AXES`; it starts near the level in the middle of the map.

    Its ends and its start are multiples of its step. A slider without a range between such numbers
    stays at the level.

    Args:
        name: Name of the axis.
        fine_levels: Levels of the map by axis.
        coarse_levels: Levels of the coarser map by axis.
    """
    _, label, unit = _AXES[name]
    levels = coarse_levels[name]
    axis = {"name": name, "label": label, "unit": unit}
    span = levels[-1] - levels[0]
    # a step of 1, 10 or 100: the numbers of the sliders are round
    step = 10.0 ** max(0, np.floor(np.log10(span / _FEWEST_STEPS))) if span > 0 else 1.0
    low, high = float(np.ceil(levels[0] / step) * step), float(np.floor(levels[-1] / step) * step)
    middle = fine_levels[name][len(fine_levels[name]) // 2]
    if low >= high:
        # no range between round numbers: the slider stays at the level, which is never rounded
        level = float(middle)
        return {**axis, "low": level, "high": level, "step": step, "start": level}
    start = min(max(float(np.round(middle / step) * step), low), high)
    return {**axis, "low": low, "high": high, "step": step, "start": start}


def _values_of_oils(slip_map: pd.DataFrame, oils: Sequence[str]) -> list[dict[str, Any]]:
    """Values of each oil at all combinations of levels, and where the page may show them.

    `single` is 1 where the cage has one motion and the torque has an interval. It is 0 where the
    cage may roll or skid, and where that is not known.
    """
    values_of_oils = []
    for oil in oils:
        rows = slip_map[slip_map["oil"] == oil].sort_values(
            [_AXIAL_LOAD, _INNER_SPEED, _OIL_TEMPERATURE]
        )
        is_single = ~rows["bistable"].astype("boolean").fillna(True).to_numpy(dtype=bool)
        is_single &= rows["torque_n_m_lower"].notna().to_numpy()
        values: dict[str, Any] = {
            name: _as_json(rows[column].to_numpy(dtype=float))
            for name, column in _COLUMN_OF_VALUE.items()
        }
        values["single"] = [int(single) for single in is_single]
        values_of_oils.append(values)
    return values_of_oils


def _as_json(values: FloatArray) -> list[float | None]:
    """Numbers with few digits for JSON; null where they are not known."""
    return [float(f"{value:.{_DIGITS}g}") if np.isfinite(value) else None for value in values]
