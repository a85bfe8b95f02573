"""Equilibria of the mainshaft bearing: one by one, by the thousand, and by SciPy's root finder.

Run by `make bench NAME=bearing`. The baseline is what one writes first: `scipy.optimize.root` on
the same forces, a point at a time, from the same start. All three end in the same motion, which is
checked. Times are the best of several runs, as other work on the machine only ever adds to them.

The bearing is also solved in operation: with growth of the rings, feed oil, starvation and the
factor on the ellipse. That is compared with the bearing of the drawing, in turns.

Takes a minute.
"""

import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from scipy.optimize import root

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/helpers"))

from bearings import RPM, in_operation, lubrication, printed_law, shipped
from oilfilm.bearing.equilibria import friction_equilibrium
from oilfilm.bearing.friction import FrictionProblem
from oilfilm.bearing.quasistatic import OperatingPoints, raceway_control_equilibrium

BEARING, OIL, TEMPERATURE_C = "mainshaft-167", "4050", 100.0
# Operating points that are solved at once, in turns, and by SciPy's root finder.
POINTS = 10_000
POINTS_IN_TURNS = 1_000
POINTS_BY_ROOT = 50
CORES = 2


# read and prepared once, as by whoever asks for more than one point
bearing_of, law_of, oil_at = cache(shipped), cache(printed_law), cache(lubrication)


def operating_points(count: int) -> OperatingPoints:
    """Axial loads of 5 to 40 kN and speeds of 0.5 to 2.5 million mm rpm, always the same."""
    random = np.random.default_rng(0)
    pitch_mm = bearing_of(BEARING).pitch_diameter_m * 1e3
    speed = random.uniform(0.5e6, 2.5e6, count) / pitch_mm * RPM
    return OperatingPoints.from_load_and_speed(random.uniform(5e3, 4e4, count), speed)


def selected(points: OperatingPoints, indices: slice) -> OperatingPoints:
    """Some of the points."""
    return points.at_points(np.arange(len(points.axial_load_n))[indices])


def raceway_control_count(points: OperatingPoints) -> int:
    """Equilibria with raceway control; how many were found."""
    return int(raceway_control_equilibrium(bearing_of(BEARING), points).solution.converged.sum())


def problem(points: OperatingPoints) -> FrictionProblem:
    """The bearing with the oil and its law."""
    oil = oil_at(OIL, TEMPERATURE_C, len(points.axial_load_n))
    return FrictionProblem(bearing_of(BEARING), points, oil, law_of(OIL))


def friction_motions(points: OperatingPoints) -> tuple[int, np.ndarray]:
    """Friction equilibria: how many were found, and the cage's speeds."""
    found = friction_equilibrium(problem(points))
    orbit = found.balance.motion.orbit_speed_rad_s
    return int(found.solution.converged.sum()), orbit


def operation_over_drawing(points: OperatingPoints, repeats: int) -> float:
    """Time of equilibria in operation over that of the drawing's bearing, best of each."""
    drawing = problem(points)
    operation = in_operation(drawing)
    best_s = [np.inf, np.inf]
    for _ in range(repeats):
        for index, friction_problem in enumerate((drawing, operation)):
            start = time.perf_counter()
            found = friction_equilibrium(friction_problem)
            best_s[index] = min(best_s[index], time.perf_counter() - start)
            assert found.solution.converged.all()
    return float(best_s[1] / best_s[0])


def friction_motions_in_chunks(points: OperatingPoints) -> tuple[int, np.ndarray]:
    """The same in parts that fit a processor's cache."""
    starts = range(0, len(points.axial_load_n), 100)
    parts = [friction_motions(selected(points, slice(start, start + 100))) for start in starts]
    return sum(count for count, _ in parts), np.concatenate([orbit for _, orbit in parts])


def by_root(points: OperatingPoints, index: int) -> tuple[bool, float]:
    """Friction equilibrium of one point by SciPy's root finder: found or not, the cage's speed."""
    one = problem(selected(points, slice(index, index + 1)))
    scale, here = one.scale(), np.zeros(1, dtype=np.int64)

    def forces(unknown: np.ndarray) -> np.ndarray:
        return one.residuals(unknown * scale, here)[0]

    found = root(forces, (one.start_unknowns() / scale)[0], tol=1e-10)
    return bool(np.abs(found.fun).max() < 1e-8), float(found.x[5] * scale[0, 5])


def timed(name: str, work: Callable[[], object], count: int, repeats: int) -> float:
    """Best wall time of some work on `count` points, in ms a point; printed."""
    best = np.inf
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - start)
    ms_per_point = 1e3 * best / count
    print(f"{name}: {ms_per_point:.3f} ms a point ({best:.3f} s)")
    return ms_per_point


def main() -> None:
    """Time all of it and print how it compares."""
    points = operating_points(POINTS)
    one = selected(points, slice(0, 1))
    friction_motions(one)
    timed("raceway control, one point", lambda: raceway_control_count(one), 1, 50)
    single = timed("friction equilibrium, one point", lambda: friction_motions(one), 1, 50)
    timed(
        f"raceway control, {POINTS} points at once",
        lambda: raceway_control_count(points),
        POINTS,
        2,
    )
    ratio = operation_over_drawing(selected(points, slice(0, POINTS_IN_TURNS)), 5)
    print(
        f"{POINTS_IN_TURNS} points in operation over the bearing of the drawing: {ratio:.2f} times"
    )
    few = selected(points, slice(0, POINTS_BY_ROOT))
    ends: list[tuple[bool, float]] = []
    naive = timed(
        f"friction equilibrium by scipy.optimize.root, {POINTS_BY_ROOT} points one by one",
        lambda: ends.extend(by_root(few, index) for index in range(POINTS_BY_ROOT)),
        POINTS_BY_ROOT,
        1,
    )
    found, orbit = friction_motions(few)
    reached = np.array([good for good, _ in ends])
    same = np.isclose([speed for _, speed in ends], orbit, rtol=1e-6)
    print(
        f"  found by root: {reached.sum()}, by us: {found} of {POINTS_BY_ROOT}; "
        f"the same: {same.sum()}"
    )
    parts = [selected(points, slice(start, None, CORES)) for start in range(CORES)]
    counts: list[int] = []
    with ProcessPoolExecutor(CORES, get_context("spawn")) as pool:
        list(pool.map(friction_motions, [one] * CORES))
        many = timed(
            f"friction equilibrium, {POINTS} points on {CORES} processes",
            lambda: counts.append(sum(n for n, _ in pool.map(friction_motions_in_chunks, parts))),
            POINTS,
            1,
        )
    print(f"  found: {counts[-1]} of {POINTS}")
    print(f"times faster than root: one point {naive / single:.1f}, many {naive / many:.1f}")


if __name__ == "__main__":
    main()
