"""Writes 13 simulated logs of a rig into a folder `logs`, for the tutorial "Your first CSV".

The truth is the law `deng2026` with constants that were published for oil 4102. One log has a
planted fault.
"""

from pathlib import Path

import numpy as np

import oilfilm

BALL_RADIUS_M, DISC_RADIUS_M = 0.010, 0.040
CONSTANTS = [
    *(-0.01567792, 1.6654, -0.5014, -0.1065),  # A0 to A3
    *(0.63482685, 1.2727, -0.4139, -1.2181),  # B0 to B3
    *(24.43483717, 0.3964, 0.1591, -0.7121),  # C0 to C3
]
LOAD_N = {1.0: 42.1, 1.5: 142.1}
HEAD = "Time (s),Normal Force (N),Friction Force (N),Ball (rpm),Disc (rpm),Oil Temp (degC)"


def one_log(pressure_gpa: float, speed_m_s: float, temperature_c: float, seed: int) -> np.ndarray:
    """Columns of one run: rolling, 16 levels of slip, rolling."""
    random = np.random.default_rng(seed)
    levels = np.concatenate([[0.0], np.linspace(0.0, 0.3, 16), [0.0]])
    slip = np.repeat(levels, 200)  # 4 s each at 50 Hz
    time_s = np.arange(len(slip)) / 50
    pressure = pressure_gpa * (1 + random.normal(0, 0.005))
    traction = oilfilm.predict("deng2026", CONSTANTS, pressure, speed_m_s, temperature_c, slip)
    mu = traction.traction_coefficient
    ball_rpm = speed_m_s * (1 - slip / 2) / BALL_RADIUS_M * 30 / np.pi
    disc_rpm = speed_m_s * (1 + slip / 2) / DISC_RADIUS_M * 30 / np.pi
    exact = [
        LOAD_N[pressure_gpa] + 0 * slip,
        mu * LOAD_N[pressure_gpa] + 0.05,  # the sensor's zero is not removed
        ball_rpm,
        disc_rpm,
        temperature_c + 0 * slip,
    ]
    noise = (0.2, 0.004, 3.0, 1.0, 0.1)
    noisy = [
        value + random.normal(0, size, len(slip)) for value, size in zip(exact, noise, strict=True)
    ]
    return np.column_stack([time_s, *noisy])


def main() -> None:
    """Write the logs."""
    folder = Path("logs")
    folder.mkdir()
    seed = 0
    for pressure in (1.0, 1.5):
        for speed in (25.0, 40.0):
            for temperature in (40.0, 70.0, 100.0):
                rows = one_log(pressure, speed, temperature, seed)
                name = f"run{seed + 1:02}.csv"
                write(folder / name, rows, temperature)
                seed += 1
    rows[1800:, 2] = rows[1800, 2]  # the cable came loose
    write(folder / "run13.csv", rows, temperature)


def write(path: Path, rows: np.ndarray, temperature_c: float) -> None:
    """A log as a logger writes it."""
    head = f"Oil: 4102\nOil Temp Set (degC): {temperature_c:g}\n{HEAD}\n"
    body = "\n".join(",".join(f"{value:.4f}" for value in row) for row in rows)
    path.write_text(head + body + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
