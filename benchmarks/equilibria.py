"""1 620 equilibria of the mainshaft bearing alone, in sixties and in one call, on several CPUs.

Run by `make bench NAME=equilibria`. Three oils by their printed laws, three speeds, three
temperatures and 60 loads, half of them with a skidding cage. A point must have the same number of
equilibria and the same cage slips in any company and with the kernels of any CPU that this machine
can be. Where no exact motion was found, `scipy.optimize.root` (hybr) tries from many speeds of the
cage.

Takes an hour.
"""

import os
import subprocess
import sys
import tempfile
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
from oilfilm.torque.load_variables import join_laws
from other_cpus import CPUS, Cpu

OILS = ("4010", "4050", "4102")
SPEEDS_RPM, TEMPERATURES_C = (6000, 12000, 18000), (40.0, 70.0, 100.0)
LOADS_N = np.geomspace(500, 20000, 60)
TOLERANCE = 1e-9
# Most points in one call, by the name of the way.
WAYS = {"in one call": 100_000, "in sixties": 60, "alone": 1}
# Speeds of the cage from which MINPACK starts, over that of a rolling one.
CAGE_SPEEDS = np.linspace(1.0, 0.0, 41)


class Found(NamedTuple):
    """What is found at each point, shapes (points,).

    Attributes:
        fastest: Cage slip of the fastest cage.
        slowest: Cage slip of the slowest cage.
        count: Number of equilibria.
        held: Whether the band of friction holds the fastest cage (`held_by_band`).
        complete: Whether all equilibria are found (`is_complete`).
    """

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
    law = join_laws([printed_law(oil) for oil in OILS], [len(grid)] * len(OILS))
    points = OperatingPoints.from_load_and_speed(load, speed * RPM)
    return FrictionProblem(shipped("mainshaft-167"), points, Lubrication.joined(parts), law)


def solved(problem: FrictionProblem, size: int) -> Found:
    """All equilibria, so many points in one call."""
    parts = []
    count = len(problem.points.axial_load_n)
    for start in range(0, count, size):
        motions = equilibria(problem.at_points(np.arange(start, min(start + size, count))))
        parts.append(
            Found(
                np.where(motions.count > 0, motions.fastest.cage_slip(), np.nan),
                np.where(motions.count > 0, motions.slowest.cage_slip(), np.nan),
                motions.count,
                motions.fastest.held_by_band(),
                motions.is_complete,
            )
        )
    return Found(*map(np.concatenate, zip(*parts, strict=True)))


def found_by_minpack(problem: FrictionProblem, number: int) -> list[float]:
    """Speeds of the cage of one point, over their scale, at roots of the exact equations."""
    one = problem.at_points(np.array([number]))
    scale, here = one.scale()[0], np.zeros(1, dtype=np.int64)

    def forces(unknowns: np.ndarray) -> np.ndarray:
        return one.residuals((unknowns * scale)[np.newaxis], here)[0]

    ends = []
    for share in CAGE_SPEEDS:
        start = one.start_unknowns()[0] / scale
        start[2:6] *= share
        end = root(forces, start, method="hybr", options={"xtol": 1e-14, "maxfev": 2000})
        if np.abs(forces(end.x)).max() < TOLERANCE:
            ends.append(float(end.x[5]))
    return sorted({round(speed, 6) for speed in ends})


def differences(found: Found, reference: Found) -> str:
    """How far the equilibria of all points are from those of a reference."""
    slips = np.stack([found.fastest, found.slowest])
    reference_slips = np.stack([reference.fastest, reference.slowest])
    farthest = np.nanmax(np.abs(slips - reference_slips))
    one_only = np.isnan(found.fastest) != np.isnan(reference.fastest)
    return (
        f"slips to {farthest:.1e}, {one_only.sum()} found in one only, "
        f"{(found.count != reference.count).sum()} with another number of equilibria, "
        f"{(found.held != reference.held).sum()} with another mark, "
        f"{(found.complete != reference.complete).sum()} complete in one only"
    )


def solve_in_three_ways(file: Path) -> None:
    """Solve all points in one call, in sixties and alone, and keep what is found in a file."""
    problem = whole_problem()
    ways = [solved(problem, size) for size in WAYS.values()]
    values = [np.stack([way[number] for way in ways]) for number in range(len(Found._fields))]
    np.savez(file, **dict(zip(Found._fields, values, strict=True)))


def start_as(cpu: Cpu, file: Path) -> subprocess.Popen[bytes]:
    """A process that solves all points as another CPU does."""
    return subprocess.Popen(
        [sys.executable, __file__, str(file)], env={**os.environ, **cpu.environment}
    )


def ways_of(file: Path) -> list[Found]:
    """What a process has found, in the order of `WAYS`."""
    with np.load(file) as kept:
        values = [kept[name] for name in Found._fields]
    return [Found(*(value[number] for value in values)) for number in range(len(WAYS))]


def compare_cpus() -> Found:
    """Print how far the ways and the kernels agree; all points in one call, by the oldest CPU."""
    reference = None
    with tempfile.TemporaryDirectory() as folder:
        running = {}
        for name, cpu in CPUS.items():
            if reason := cpu.lacking():
                print(f"NOT tried: {name} ({reason})")
                continue
            file = Path(folder) / f"{name}.npz"
            running[name] = file, start_as(cpu, file)
        for name, (file, process) in running.items():
            if process.wait():
                raise SystemExit(f"The process that computes as {name} has failed.")
            for way, found in zip(WAYS, ways_of(file), strict=True):
                reference = reference or found
                print(f"{name}, {way}: {differences(found, reference)}", flush=True)
    if reference is None:
        raise SystemExit("This machine has none of the kernels that are compared.")
    return reference


def main() -> None:
    """Print the agreement, and what MINPACK finds where there is no exact motion."""
    found = compare_cpus()
    print(f"{len(found.count)} points: {(found.count == 0).sum()} without motion,")
    print(f"  {found.held.sum()} held by a band, {(found.count > 1).sum()} with several motions,")
    print(f"  {(~found.complete).sum()} that may have more: beyond the law, or a curve stalls")
    problem = whole_problem()
    for number in np.flatnonzero((found.count == 0) | found.held):
        speeds = found_by_minpack(problem, int(number))
        load = problem.points.axial_load_n[number]
        print(f"point {number} ({load:.0f} N), slip {found.fastest[number]:.4f}: MINPACK {speeds}")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        solve_in_three_ways(Path(sys.argv[1]))
    else:
        main()
