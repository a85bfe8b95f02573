"""1 620 equilibria of the mainshaft bearing alone, in sixties and in one call, against MINPACK.

Run by `make bench-equilibria`; OPENBLAS_CORETYPE chooses the kernel of the BLAS. Three oils by
their printed laws, three speeds, three temperatures and 60 loads, half of them with a skidding
cage. A point must have the same number of equilibria and the same cage slips in any company. Where
no exact motion was found, `scipy.optimize.root` (hybr) tries from many speeds of the cage.
"""

import sys
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import root

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/helpers"))

from bearings import RPM, lubrication, printed_law, shipped
from oilfilm.bearing.equilibria import equilibria
from oilfilm.bearing.friction import FrictionProblem
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.bearing.resistance import Lubrication
from oilfilm.torque.load_variables import law_of_groups

OILS = ("4010", "4050", "4102")
SPEEDS_RPM, TEMPERATURES_C = (6000, 12000, 18000), (40.0, 70.0, 100.0)
LOADS_N = np.geomspace(500, 20000, 60)
TOLERANCE = 1e-9
# Speeds of the cage from which MINPACK starts, over that of a rolling one.
CAGE_SPEEDS = np.linspace(1.0, 0.0, 41)


class Found(NamedTuple):
    """Fastest and slowest cage's slip, number of equilibria, and marks, one value per point."""

    fastest: np.ndarray
    slowest: np.ndarray
    count: np.ndarray
    held: np.ndarray
    complete: np.ndarray


def whole_problem() -> FrictionProblem:
    """All points in one problem."""
    grid = np.array(list(product(SPEEDS_RPM, TEMPERATURES_C, LOADS_N)))
    speed, _, load = np.tile(grid, (len(OILS), 1)).T
    parts = [lubrication(oil, grid[:, 1], len(grid)) for oil in OILS]
    law = law_of_groups([printed_law(oil) for oil in OILS], [len(grid)] * len(OILS))
    points = OperatingPoints.axial(load, speed * RPM)
    return FrictionProblem(shipped("mainshaft-167"), points, Lubrication.joined(parts), law)


def solved(problem: FrictionProblem, size: int) -> Found:
    """All equilibria, so many points in one call."""
    parts = []
    count = len(problem.points.axial_load_n)
    for start in range(0, count, size):
        motions = equilibria(problem.at(np.arange(start, min(start + size, count))))
        parts.append(
            Found(
                np.where(motions.count > 0, motions.fastest.cage_slip(), np.nan),
                np.where(motions.count > 0, motions.slowest.cage_slip(), np.nan),
                motions.count,
                motions.fastest.held_by_band(),
                motions.complete,
            )
        )
    return Found(*map(np.concatenate, zip(*parts, strict=True)))


def found_by_minpack(problem: FrictionProblem, number: int) -> list[float]:
    """Speeds of the cage of one point, over their scale, at roots of the exact equations."""
    one = problem.at(np.array([number]))
    scale, here = one.scale()[0], np.zeros(1, dtype=np.int64)

    def forces(unknowns: np.ndarray) -> np.ndarray:
        return one.residuals(unknowns * scale, here)[0]

    ends = []
    for share in CAGE_SPEEDS:
        start = one.start()[0] / scale
        start[2:6] *= share
        end = root(forces, start, method="hybr", options={"xtol": 1e-14, "maxfev": 2000})
        if np.abs(forces(end.x)).max() < TOLERANCE:
            ends.append(float(end.x[5]))
    return sorted({round(speed, 6) for speed in ends})


def main() -> None:
    """Print how far the three ways agree, and what MINPACK finds where there is no exact motion."""
    problem = whole_problem()
    at_once = solved(problem, len(problem.points.axial_load_n))
    print(f"{len(at_once.count)} points in one call: {(at_once.count == 0).sum()} without motion,")
    print(
        f"  {at_once.held.sum()} held by a band, {(at_once.count > 1).sum()} with several motions,"
    )
    print(f"  {(~at_once.complete).sum()} curves that stall before their end")
    for name, size in (("in sixties", 60), ("alone", 1)):
        other = solved(problem, size)
        away = np.nanmax(np.abs(np.stack(other[:2]) - np.stack(at_once[:2])))
        differ = (np.isnan(other.fastest) != np.isnan(at_once.fastest)).sum()
        print(
            f"{name}: slips to {away:.1e}, {differ} found in one way only, "
            f"{(other.count != at_once.count).sum()} with another number of equilibria, "
            f"{(other.held != at_once.held).sum()} with another mark"
        )
    for number in np.flatnonzero((at_once.count == 0) | at_once.held):
        speeds = found_by_minpack(problem, int(number))
        load = problem.points.axial_load_n[number]
        print(
            f"point {number} ({load:.0f} N), slip {at_once.fastest[number]:.4f}: MINPACK {speeds}"
        )


if __name__ == "__main__":
    main()
