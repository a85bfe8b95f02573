"""Does it pay to follow the plan: planned tests against random ones, on simulated campaigns.

The truth is a planted law, its constants those printed for oil 4102. Each laboratory measures
twelve curves in a corner of its rig's range, fits them and then adds as many tests as said: those
that `oilfilm plan` names from its own points and refits, and random ones among all that the rig can
run. Both are refitted. Printed are ratios of plan to random tests: of the uncertainty of the torque
that the constants leave, and of the actual error of the torque against the planted law.

    python benchmarks/plan.py [laboratories] [tests] [random designs for each]

Takes a minute.
"""

import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests/helpers"))

from oilfilm.base.randomness import generator  # noqa: E402
from oilfilm.fits.fit import fit_oil  # noqa: E402
from oilfilm.fits.measured_curves import choose_curves, rms_uncertainty  # noqa: E402
from oilfilm.torque.next_tests import plan_tests, request_from_settings  # noqa: E402
from oilfilm.traction.law import CONDITIONS, FloatArray  # noqa: E402
from planned_tests import (  # noqa: E402
    DUTY,
    OIL,
    SETTINGS,
    SMALL_PLAN,
    TRUE_CONSTANTS,
    Errors,
    refit,
    run_tests,
    torques,
)

Conditions = list[tuple[float, float, float]]


def laboratory(count: int, designs: int, number: int) -> FloatArray:
    """Promised uncertainty, and squared actual error: before, by the plan, by each random design.

    Args:
        count: Number of tests that are added.
        designs: Number of random designs.
        number: Number of the laboratory.

    Returns:
        Shape (2, 2 + designs).
    """
    random = generator(number, "laboratory")
    points = run_tests(SMALL_PLAN, random, Errors())
    fit = SETTINGS.with_changes({"fit": {"searches": 2, "bootstrap": 300}}).fit
    results = fit_oil(points, OIL, fit, number).replace(points=points)
    request = replace(
        request_from_settings(SETTINGS), duty=DUTY, test_count=count, targets=("torque",)
    )
    (plan,) = plan_tests(results, SETTINGS, OIL, request)
    # the plan of the product stops, because drag decides: here the law's part alone counts
    tests = plan.candidates.tests
    precision_of_tests = plan.information.precision_of_curves(
        plan.candidates.curves, plan.candidates.form_error
    )
    design = choose_curves(plan.information.precision, precision_of_tests, plan.gradients, count)
    chosen = [
        design.chosen_indices,
        *(random.choice(len(tests), count, False) for _ in range(designs)),
    ]
    promised = [design.uncertainty_before]
    added: list[Conditions] = [[]]
    for indices in chosen:
        precision = plan.information.precision + precision_of_tests[list(indices)].sum(axis=0)
        promised.append(float(rms_uncertainty(precision, plan.gradients)))
        rows = tests.iloc[indices][list(CONDITIONS)].to_numpy(dtype=float)
        added.append([(p, u, t) for p, u, t in rows])
    constants = [refit(points)]
    for design_number, new_conditions in enumerate(added[1:]):
        random_of_design = generator(number, "new tests", design_number)
        new = run_tests(new_conditions, random_of_design, Errors())
        new = new.assign(run_id="new " + new["run_id"])
        constants.append(refit(pd.concat([points, new], ignore_index=True)))
    errors = np.log(torques(np.array(constants)) / torques(TRUE_CONSTANTS[np.newaxis]))
    return np.array([promised, np.mean(errors**2, axis=1)])


def main(laboratories: int, count: int, designs: int) -> None:
    """Print the ratios."""
    run = partial(laboratory, count, designs)
    with ProcessPoolExecutor() as pool:
        results = np.array(list(pool.map(run, range(laboratories))))
    promised, squares = results[:, 0], results[:, 1]
    print(
        f"{laboratories} laboratories, {len(SMALL_PLAN)} curves each, {count} tests more; "
        f"{designs} random designs each"
    )
    before, plan, chance = promised[:, 0], promised[:, 1], promised[:, 2:]
    print(
        f"promised uncertainty of the torque (median): {100 * np.median(before):.3f} % before, "
        f"{100 * np.median(plan):.3f} % by the plan, {100 * np.median(chance):.3f} % by chance; "
        f"ratio plan/chance {np.median(plan / np.median(chance, axis=1)):.2f}"
    )
    actual = np.sqrt([squares[:, 0].mean(), squares[:, 1].mean(), squares[:, 2:].mean()])
    print(
        f"actual error of the torque (rms): {100 * actual[0]:.3f} % before, "
        f"{100 * actual[1]:.3f} % by the plan, {100 * actual[2]:.3f} % by chance; "
        f"ratio plan/chance {actual[1] / actual[2]:.2f}"
    )
    better = np.mean(squares[:, [1]] < squares[:, 2:])
    print(f"the plan has the smaller actual error in {better:.0%} of the comparisons")


if __name__ == "__main__":
    given = [int(word) for word in sys.argv[1:]]
    main(*(given + [20, 5, 5][len(given) :]))
