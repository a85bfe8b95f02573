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


def signals(seed: int = 1, levels: tuple[float, ...] = (2.0, 3.0, 5.0)) -> pd.DataFrame:
    """Rest, three speeds of known torque, rest; a zero of 0.3 N m, noise of 0.05 N m."""
    random = np.random.default_rng(seed)
    speed = np.concatenate([np.zeros(120), np.repeat([3000.0, 6000.0, 9000.0], 160), np.zeros(120)])
    torque = np.concatenate([np.zeros(120), np.repeat(levels, 160), np.zeros(120)])
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
