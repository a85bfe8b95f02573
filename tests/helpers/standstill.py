"""Logs of a rig that stands still, turns and stops, with planted traction and zero of the force.

The traction of every log is mu = A (1 - exp(-S/s)) or A tanh(S/s).
"""

import numpy as np

from formats import NAMES

Columns = dict[str, np.ndarray]

RATE_HZ, SPEED_M_S, LOAD_N = 20, 2.0, 40.0
LEVELS = (0.002, 0.008, 0.015, 0.03, 0.05, 0.08, 0.12)
UNITS = dict(zip(NAMES, "s N N m/s m/s degC".split(), strict=True))
# A of the planted law.
LARGEST_MU = 0.05


def planted_mu(slip: np.ndarray, slope: float = 5.0, shape: str = "exponential") -> np.ndarray:
    """mu at slips; `slope` is dmu/dS without slip, `shape` is `exponential` or `tanh`."""
    scaled = slope * slip / LARGEST_MU
    return LARGEST_MU * (np.tanh(scaled) if shape == "tanh" else 1 - np.exp(-scaled))


def log(
    levels: tuple[float, ...] = LEVELS,
    offset_n: float = 0.35,
    *,
    still_s: tuple[float, float] = (20.0, 20.0),
    ramp_s: float = 1.0,
    drift_n: float = 0.0,
    slope: float = 5.0,
    shape: str = "exponential",
    encoder_m_s: float = 0.0,
    seed: int = 1,
) -> Columns:
    """Standstill, a ramp to the first level, the levels at 4 s each, a ramp down, standstill.

    Args:
        levels: Slide-roll ratios.
        offset_n: Zero of the force.
        still_s: Times at standstill before and after.
        ramp_s: Time of each ramp of the speed.
        drift_n: Change of the zero over the run.
        slope: As in `planted_mu`.
        shape: As in `planted_mu`.
        encoder_m_s: Noise of the speeds at standstill.
        seed: Seed of the noise.
    """
    random = np.random.default_rng(seed)
    ramp = np.linspace(0, 1, round(ramp_s * RATE_HZ), endpoint=False)
    rest = [np.zeros(round(seconds * RATE_HZ)) for seconds in still_s]
    held = np.repeat(levels, 4 * RATE_HZ)
    share = np.concatenate([rest[0], ramp, np.ones(len(held)), ramp[::-1], rest[1]])
    before, after = len(rest[0]) + len(ramp), len(rest[1]) + len(ramp)
    slip = np.pad(held, (before, after), mode="edge")
    count, turning = len(slip), share > 0
    mu = planted_mu(slip, slope, shape) * turning
    # a ramp starts with the thin film of a slow contact: traction of another kind
    mu = mu + 0.08 * (turning & (share < 1))
    time = np.arange(count) / RATE_HZ
    noise = random.standard_normal((5, count))
    speed = SPEED_M_S * share
    encoder = np.where(turning, 1e-4, encoder_m_s)
    force = LOAD_N * mu + offset_n + drift_n * time / time[-1] + 0.01 * noise[0]
    return {
        "time": time,
        "load": LOAD_N + 0.02 * noise[1],
        "traction_force": force,
        "ball_speed": speed * (1 - slip / 2) + encoder * noise[2],
        "disc_speed": speed * (1 + slip / 2) + encoder * noise[3],
        "inlet_temperature": 70 + 0.05 * noise[4],
    }
