"""Runs of `oilfilm plan`: their effect on the smallest drift that is seen, and on the error of mu.

Campaigns are simulated as points, for oils that no law describes and for one of Deng's law (`own`).

The first table has the smallest trend that a surface sees (five standard deviations), as a gain of
the force in per cent and a temperature in K over all runs, by the order of 24 runs.

The second table has the smallest step of the force, in per cent, that is seen between the old runs
and those of the plan. The reference run is at a tested condition, as planned, or at the untested
middle of the box, or there is none.

The third table has designs with two levels of a condition: as tested, with the runs of the plan,
and with as many repeats in their place.

    err95    95 % quantile of the error of mu at new conditions of the box, mean over the truths
    half     half width of the 95 % interval of the next run, median, mean over the truths
    inside   share of points of new runs inside

    python benchmarks/run_plan.py [seeds]

Takes 5 minutes.
"""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

from oilfilm.base.randomness import generator
from oilfilm.base.units import FloatArray
from oilfilm.surface.measurements import LevelWidths, Measurements
from oilfilm.surface.steadiness import smallest_visible_size
from oilfilm.surface.surface import fit_surface
from oilfilm.torque.lacking_runs import ConditionLevels
from oilfilm.torque.run_plan import MeasuredRuns, plan_runs

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/helpers"))

from campaigns import without
from lawless_truths import TRUTHS
from planned_tests import OIL, SETTINGS
from surface_campaigns import (
    PRESSURES,
    SPEEDS,
    TEMPERATURES,
    ends,
    fitted_law,
    grid,
    latin,
    random_conditions,
    simulated,
)

ORDER_TRUTHS = ("own", "jt", "rat", "sol")
NEW_RUNS, NEW_SLIPS = 40, 12
WITHOUT_MATRIX = without(SETTINGS, "matrix")
DESIGNS = {
    "24 = 2x3x4": grid(ends(PRESSURES), (25.0, 32.0, 40.0), (25.0, 57.0, 88.0, 120.0)),
    "24 = 3x4x2": grid(PRESSURES, SPEEDS, ends(TEMPERATURES)),
    "12 = 2x2x3": grid(ends(PRESSURES), ends(SPEEDS), (25.0, 72.0, 120.0)),
    "8 = 2x2x2": grid(ends(PRESSURES), ends(SPEEDS), ends(TEMPERATURES)),
}


def planned(conditions: FloatArray) -> tuple[FloatArray, list[str]]:
    """Conditions and reasons of the runs that the plan adds to a campaign, in its order."""
    runs = len(conditions)
    measured = MeasuredRuns(conditions, np.full(runs, 0.03), np.full(runs, 0.3))
    plan = plan_runs(measured, WITHOUT_MATRIX, OIL)
    return np.array([run.conditions for run in plan.runs]), [run.reason for run in plan.runs]


def smallest_visible(
    truth: str, conditions: FloatArray, pattern: Callable[[FloatArray], FloatArray], effect: str
) -> float:
    """The smallest size of a pattern over the runs that is seen; rows are in order of time."""
    random = generator(23, "run plan", truth)
    slips = np.geomspace(0.002, 0.3, 9)
    points = simulated(TRUTHS[truth], conditions, random, slips=slips)
    curves, _ = points.canonical_order()
    ordered = points.in_canonical_order()
    surface = fit_surface(ordered, fitted_law(ordered))
    time = np.arange(len(conditions), dtype=float)
    return smallest_visible_size(surface.misfit_covariance, effect, pattern(time)[curves])


def with_references(conditions: FloatArray, reference: FloatArray) -> FloatArray:
    """The runs with a reference run before every fifth of them."""
    parts = []
    for start in range(0, len(conditions), 5):
        parts.append(reference[np.newaxis])
        parts.append(conditions[start : start + 5])
    return np.concatenate(parts)


def orders() -> None:
    """Print the smallest trend by the order of the runs."""
    runs = latin()
    by_pressure = runs[np.lexsort((runs[:, 2], runs[:, 1], runs[:, 0]))]
    by_temperature = runs[np.lexsort((runs[:, 0], runs[:, 1], runs[:, 2]))]
    middle = np.array([1.25, 30.0, 70.0])
    random = generator(23, "order of runs")
    variants = {"random": runs[random.permutation(len(runs))]}
    for name, ordered in (("pressure", by_pressure), ("temperature", by_temperature)):
        variants[name] = ordered
        variants[f"{name}, references between"] = with_references(ordered, middle)
        added, _ = planned(ordered)
        variants[f"{name}, then the plan"] = np.concatenate([ordered, added])

    def trend(time: FloatArray) -> FloatArray:
        return time / time.max() - 0.5

    rows = []
    for name, conditions in variants.items():
        row: dict[str, object] = {"order": name, "runs": len(conditions)}
        for truth in ORDER_TRUTHS:
            gain = 100 * smallest_visible(truth, conditions, trend, "gain")
            kelvin = smallest_visible(truth, conditions, trend, "temperature_k")
            row[truth] = f"{gain:.1f} % {kelvin:.1f} K"
        rows.append(row)
    print(pd.DataFrame(rows).to_string(index=False), end="\n\n")


def references() -> None:
    """Print the smallest step between old and new runs by the place of the reference run."""
    rows = []
    for design, conditions in DESIGNS.items():
        tested = generator(23, "order of runs").permutation(conditions)
        added, reasons = planned(tested)
        is_reference = np.array(reasons) == "reference"
        at_middle = added.copy()
        at_middle[is_reference] = ConditionLevels.from_conditions(tested, LevelWidths()).middle
        variants = {"tested": added, "middle": at_middle, "none": added[~is_reference]}

        def step(time: FloatArray, first: int = len(tested)) -> FloatArray:
            return np.asarray(time >= first, dtype=float)

        for name, new in variants.items():
            row: dict[str, object] = {"design": design, "reference": name, "new runs": len(new)}
            together = np.concatenate([tested, new])
            for truth in ORDER_TRUTHS:
                row[truth] = round(100 * smallest_visible(truth, together, step, "gain"), 1)
            rows.append(row)
    print(pd.DataFrame(rows).to_string(index=False), end="\n\n")


def levels(seeds: int) -> None:
    """Print error and interval of designs with two levels, with and without the plan."""
    rows = []
    for design, in_order in DESIGNS.items():
        conditions = generator(23, "order of runs").permutation(in_order)
        added, _ = planned(conditions)
        for truth in TRUTHS:
            for seed in range(seeds):
                random = generator(23, "levels", design, truth, str(seed))
                repeated = conditions[random.choice(len(conditions), len(added))]
                variants = {
                    "as tested": conditions,
                    "with the plan": np.concatenate([conditions, added]),
                    "with repeats": np.concatenate([conditions, repeated]),
                }
                new_conditions = random_conditions(NEW_RUNS, random)
                slips = np.sort(np.exp(random.uniform(np.log(0.0015), np.log(0.3), NEW_SLIPS)))
                new = simulated(TRUTHS[truth], new_conditions, random, slips=slips)
                for name, tested in variants.items():
                    points = simulated(TRUTHS[truth], tested, random)
                    rows.append({"design": design, "runs": name, **quality(truth, points, new)})
    table = pd.DataFrame(rows).groupby(["design", "runs"], sort=False)
    print(table[["count", "err95", "half", "inside"]].mean().round(3).to_string())


def quality(truth: str, points: Measurements, new: Measurements) -> dict[str, float]:
    """Error and interval of the surface of some points at new runs."""
    surface = fit_surface(points, fitted_law(points))
    factor = surface.interval_factors.point
    prediction = surface.predict(new.point_conditions, new.slip)
    supported = prediction.support_codes == 0
    lower, upper = prediction.interval(factor)
    inside = (lower <= new.mu) & (new.mu <= upper)
    true = TRUTHS[truth](*new.point_conditions.T, new.slip)
    return {
        "count": float(len(points.conditions)),
        "err95": float(np.quantile(np.abs(prediction.mu / true - 1), 0.95)),
        "half": float(np.median(factor * prediction.next_run_sd)),
        "inside": float(inside[supported].mean()) if supported.any() else np.nan,
    }


if __name__ == "__main__":
    orders()
    references()
    levels(int(sys.argv[1]) if len(sys.argv) > 1 else 1)
