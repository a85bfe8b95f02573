"""Torque logs of known torque: one for the tests of curation, and those of the twin."""

import numpy as np
import pandas as pd
import pytest

from campaigns import printed
from oilfilm import tables
from oilfilm.curation.curate import CuratedTables, curate_logs
from oilfilm.curation.torque_rig import TorqueRig
from oilfilm.settings.resolved import Settings

RATE_HZ = 20
BEARING = "mainshaft-167"
QUANTITIES = "time axial_load inner_speed oil_temperature outer_ring_temperature torque".split()
UNITS = dict(zip(QUANTITIES, ("s", "N", "rpm", "degC", "degC", "N m"), strict=True))
# Columns of the table of torque logs: quantities with their units, in the same order.
NAMES = tuple(
    f"{quantity}_{unit.removeprefix('deg').replace(' ', '_').lower()}"
    for quantity, unit in UNITS.items()
)


def signals(seed: int = 1) -> pd.DataFrame:
    """Rest, three speeds with torques of 2, 3 and 5 N m, rest."""
    levels = np.repeat([0, 1, 2, 3, 0], [120, 160, 160, 160, 120])
    return signals_of(3000.0 * levels, np.array([0.0, 2.0, 3.0, 5.0])[levels], seed)


def signals_of(speed: np.ndarray, torque: np.ndarray, seed: int) -> pd.DataFrame:
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
    """A log as CSV, below header lines."""
    return header.encode() + frame.to_csv(index=False, lineterminator="\n").encode()


def curated_logs(settings: Settings) -> tuple[dict[str, str], CuratedTables, pd.DataFrame]:
    """Planted defect of each simulated log, the curated logs, and the table of the truth."""
    simulator = pytest.importorskip("simulated_lab.torque_logs")
    logs = list(simulator.simulate_torque(settings, printed()))
    curated = curate_logs([(plan.name, content) for plan, content, _ in logs], settings, TorqueRig)
    truth = tables.from_rows([row for *_, rows in logs for row in rows], "torque_truth")
    return {plan.name: plan.defect for plan, *_ in logs}, curated, truth
