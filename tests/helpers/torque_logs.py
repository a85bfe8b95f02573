"""A torque log of known torque, for the tests of curation."""

import numpy as np
import pandas as pd

RATE_HZ = 20
BEARING = "mainshaft-167"
UNITS = {
    "time": "s",
    "axial_load": "N",
    "inner_speed": "rpm",
    "oil_temperature": "degC",
    "outer_ring_temperature": "degC",
    "torque": "N m",
}
NAMES = (
    "time_s",
    "axial_load_n",
    "inner_speed_rpm",
    "oil_temperature_c",
    "outer_ring_temperature_c",
    "torque_n_m",
)


def signals(seed: int = 1) -> pd.DataFrame:
    """Rest, three speeds with torques of 2, 3 and 5 N m, rest."""
    levels = np.repeat([0, 1, 2, 3, 0], [120, 160, 160, 160, 120])
    return measured(3000.0 * levels, np.array([0.0, 2.0, 3.0, 5.0])[levels], seed)


def measured(speed: np.ndarray, torque: np.ndarray, seed: int) -> pd.DataFrame:
    """Signals of known speed and torque, with a zero of 0.3 N m and noise of 0.05 N m."""
    random = np.random.default_rng(seed)
    count = len(speed)
    return pd.DataFrame(
        {
            "time_s": np.arange(count) / RATE_HZ,
            "axial_load_n": 10000 + 5 * random.standard_normal(count),
            "inner_speed_rpm": speed + np.where(speed > 0, random.standard_normal(count), 0),
            "oil_temperature_c": 100 + 0.1 * random.standard_normal(count),
            "outer_ring_temperature_c": 110 + 0.1 * random.standard_normal(count),
            "torque_n_m": torque + 0.3 + 0.05 * random.standard_normal(count),
        }
    ).round(4)


def by_quantity(frame: pd.DataFrame) -> dict[str, np.ndarray]:
    """Columns by quantity, as the writers of `formats` take them."""
    return {quantity: frame[name].to_numpy() for quantity, name in zip(UNITS, NAMES, strict=True)}


def text(frame: pd.DataFrame, header: str = "# oil: 4050\n") -> bytes:
    return header.encode() + frame.to_csv(index=False, lineterminator="\n").encode()
