"""How often the intervals of mu hold, over simulated campaigns of many kinds.

Truths: each law with the paper's constants, or with those that come nearest to them, and the
heated film of `thermal`. Each campaign is fitted with the configured law, true or not, by the code
that fits a user's data. Then new good runs at new conditions of the tested region are simulated:
the interval of the next good run (`obs_ci`) should hold 90 to 99 % of their points; the law's own
interval (`mean_ci`) the noise-free truth, where the fit is sound.

    python benchmarks/coverage.py [replicates]
"""

import itertools
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd

from oilfilm.fits.fit import fit_oil
from oilfilm.fits.fitted import Coefficients, FittedLaw
from oilfilm.fits.law_comparison import laws_of
from oilfilm.paper.reference import printed_constants
from oilfilm.randomness import generator
from oilfilm.rig_twin.truth import LawTruth, Truth, true_tractions
from oilfilm.settings.resolve import resolve
from oilfilm.traction.law import FloatArray

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/helpers"))

from simulated_points import (
    Campaign,
    RunErrors,
    spread_conditions,
    with_calibration,
)

ROOT = Path(__file__).parents[1]
OILS = ("4102", "4050", "4010")
TRUTHS = (
    *("deng2026", "wang-deng-load", "wang-deng-critical-load", "wang-deng-groups"),
    *("eyring", "carreau", "tanh", "heated film"),
)
LEVELS = ([1.0, 1.25, 1.5], [25.0, 30.0, 35.0, 40.0], [25.0, 50.0, 70.0, 85.0, 100.0, 120.0])
NEW_RUNS = 30
TABLE = ROOT / "docs/explanation/coverage.csv"
COMMON = RunErrors(common_gain=0.005, common_load=0.003, common_temperature_c=0.5)


def conditions_of(curves: int) -> FloatArray:
    """The test matrix of a campaign with so many curves."""
    pressures, speeds, temperatures = LEVELS
    if curves == 24:
        return np.array(
            [
                (pressure, speed, temperatures[(i + j + half) % 6])
                for (i, pressure), (j, speed), half in itertools.product(
                    enumerate(pressures), enumerate(speeds), (0, 3)
                )
            ]
        )
    levels = {
        72: LEVELS,
        18: (pressures, speeds[::2] + speeds[-1:], temperatures[::5]),
        12: (pressures[::2], speeds[::2] + speeds[-1:], temperatures[::5]),
    }[curves]
    return np.array(list(itertools.product(*levels)))


@cache
def _settings(campaign: str):
    return resolve(ROOT / "config", {"campaign": campaign})


@dataclass(frozen=True)
class PointTruth:
    """A fitted law as a truth."""

    fit: FittedLaw
    contact: object

    def __call__(self, *conditions: FloatArray) -> FloatArray:
        """See `Truth`."""
        pressure, speed, temperature, slip = np.broadcast_arrays(*conditions)
        columns = {
            "max_hertz_pressure_gpa": pressure,
            "entrainment_speed_m_s": speed,
            "inlet_temperature_c": temperature,
            "load_n": self.contact.load_n(pressure),
        }
        rows = np.column_stack([columns[name].ravel() for name in self.fit.law.conditions])
        return self.fit.predict(rows, slip.ravel()).traction_coefficient.reshape(slip.shape)


@cache
def truth_of(name: str, oil: str) -> Truth:
    """The truth of this name."""
    constants = printed_constants(ROOT / "data/reference/printed_coefficients.yaml")
    settings = _settings("demo")
    if name == "deng2026":
        return LawTruth(constants[oil])
    if name == "heated film":
        return true_tractions(_settings("thermal"), constants)[oil]
    exact = replace(RunErrors(), **dict.fromkeys(vars(RunErrors()), 0.0))
    campaign = Campaign(LawTruth(constants[oil]), settings.common_contact(), exact)
    points = campaign.points(conditions_of(72), generator(1, "truth"), oil)
    law = laws_of(oil, settings)[name]
    if name == "wang-deng-critical-load":
        # its own nearest constants have the critical load between two tested loads
        nested = truth_of("wang-deng-load", oil).fit
        constants = np.append(nested.coefficients.constants, (1e-3, -1.0, 0.0, 0.0))
        fitted = FittedLaw(law, Coefficients.bare(law, constants))
    else:
        fitted = _fitted(fit_oil(points, oil, _quick(72), 1, law), oil, law)
    return PointTruth(fitted, settings.common_contact())


def _quick(curves: int):
    """Settings of a fit with fewer searches and refits: errors of intervals, not of optima."""
    return _settings("demo").fit.model_copy(update={"searches": 2, "bootstrap": 300})


def _fitted(fit, oil: str, law=None) -> FittedLaw:
    return FittedLaw.of(fit.coefficients, oil, fit.refits, fit.fit_quality, law)


def trial(case: tuple[str, str, int, bool, int]) -> dict[str, object]:
    """One campaign: coverage and width of both intervals."""
    truth, oil, curves, common, number = case
    random = generator(7, "coverage", *map(str, case))
    contact = _settings("demo").common_contact()
    errors = RunErrors()
    if common:
        drawn = random.standard_normal(3)
        errors = RunErrors(
            common_gain=COMMON.common_gain * drawn[0],
            common_load=COMMON.common_load * drawn[1],
            common_temperature_c=COMMON.common_temperature_c * drawn[2],
        )
    campaign = Campaign(truth_of(truth, oil), contact, errors)
    matrix = conditions_of(curves)
    points = campaign.points(matrix, random, oil)
    if common:
        points = with_calibration(points, COMMON)
    fitted = _fitted(fit_oil(points, oil, _quick(curves), number), oil)
    conditions = spread_conditions(matrix.min(axis=0), matrix.max(axis=0), NEW_RUNS, random)
    # a good run of a rig whose sensors are exact
    new = replace(campaign, errors=RunErrors()).points(conditions, random, oil)
    new = new[new["slide_roll_ratio"] > 0]
    at = new[list(fitted.law.conditions)].to_numpy(float)
    slip = new["slide_roll_ratio"].to_numpy()
    inside = fitted.predict(at, slip)
    measured = new["traction_coefficient"].to_numpy()
    true = np.ravel(
        campaign.truth(
            *(np.repeat(level[:, np.newaxis], campaign.slip_steps, 1) for level in conditions.T),
            np.broadcast_to(np.linspace(0, 0.3, 31), (NEW_RUNS, 31)),
        )[:, 1:]
    )
    exact = np.repeat(conditions, 30, axis=0)
    own = fitted.predict(exact, slip)
    mu = inside.traction_coefficient
    half = (inside.obs_ci_upper - inside.obs_ci_lower) / 2 / mu
    return {
        "truth": truth, "oil": oil, "curves": curves, "common": common,
        "obs": np.mean((inside.obs_ci_lower <= measured) & (measured <= inside.obs_ci_upper)),
        "half": np.median(half), "q95": np.quantile(np.abs(measured / mu - 1), 0.95),
        "mean": np.mean((own.mean_ci_lower <= true) & (true <= own.mean_ci_upper)),
        "own half": np.median((own.mean_ci_upper - own.mean_ci_lower) / 2 / mu),
        "level": fitted.coefficients.bands(fitted.law, 0.95)[2],
    }  # fmt: skip


def main(replicates: int = 3) -> None:
    """Print the table, and renew the one of the documentation."""
    cases = [
        (truth, oil, curves, common, number)
        for truth in TRUTHS
        for curves in (72, 24, 18, 12)
        for common in (False, True)
        for oil in OILS
        for number in range(replicates)
    ]
    with ProcessPoolExecutor(2) as pool:
        rows = pd.DataFrame(list(pool.map(trial, cases, chunksize=4)))
    rows["ratio"] = rows["half"] / rows["q95"]
    wanted = ["obs", "half", "q95", "ratio", "mean", "own half", "level"]
    table = rows.groupby(["truth", "curves", "common"], sort=False)[wanted].mean()
    print(table.round(3).to_string())
    table.round(3).reset_index().to_csv(TABLE, index=False, lineterminator="\n")


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:2]))
