"""The part of the errors that no averaging lowers: the calibration of a rig's sensors.

Decides: the error of calibration that the points of a run share.
"""

from collections.abc import Mapping

import pandas as pd

from oilfilm.settings.rig import Rig

# Column -> the column and the key of the rig file it comes from; relative but for temperature.
_RELATIVE = {
    "load_systematic_n": ("load_n", "load_relative"),
    "traction_force_systematic_n": ("traction_force_n", "traction_force_relative"),
    "entrainment_speed_systematic_m_s": ("entrainment_speed_m_s", "speed_relative"),
}


def with_calibration(points: pd.DataFrame, rigs: Mapping[str, Rig]) -> pd.DataFrame:
    """Points with the standard uncertainty of each sensor's calibration.

    All points of a rig share these errors, so they are kept apart from the random ones; null
    where the rig file states none.
    """
    rig = points["rig"].astype("category")

    def from_rig(key: str) -> "pd.Series[float]":
        values = {name: getattr(file.calibration, key, None) for name, file in rigs.items()}
        return rig.map(values).astype(float)

    return points.assign(
        **{
            column: points[quantity].abs() * from_rig(key)
            for column, (quantity, key) in _RELATIVE.items()
        },
        inlet_temperature_systematic_c=from_rig("temperature_c"),
    )
