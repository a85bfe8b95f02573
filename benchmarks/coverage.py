"""How often the interval of the mean curve holds, over simulated campaigns of many kinds.

Truths: each law with the paper's constants, or with those that come nearest to them, and the
heated film of `thermal`. Each campaign is fitted with the configured law, true or not, by the code
that fits a user's data. The interval of the mean curve (`mean_ci`) should hold the noise-free truth
at new conditions of the tested region, where the fit is sound. The interval of the next run is that
of the surface (`benchmarks/surface.py`).

    python benchmarks/coverage.py [replicates]
    python benchmarks/coverage.py --quick            (plans of 12 and 18 runs, one campaign each)
    python benchmarks/coverage.py few [campaigns]    (width of that interval of 12 runs)

Without `--quick` the table of the documentation is written anew after each row.

Takes 20 minutes in one process with one thread of linear algebra; `--quick` 2.
"""

import itertools
import sys
import time
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from oilfilm import tables
from oilfilm.base.randomness import generator
from oilfilm.fits.fit import fit_oil, laws_of_oil
from oilfilm.fits.fitted import Coefficients, FittedLaw
from oilfilm.fits.soundness import soundness_row
from oilfilm.fits.surface_search import with_surface
from oilfilm.settings.resolve import resolve
from oilfilm.traction.law import FloatArray
from simulated_lab.printed import read_printed_constants
from simulated_lab.truth import LawTruth, TrueTraction, true_tractions

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/helpers"))

from simulated_points import PointCampaign, RunErrors, spread_conditions

ROOT = Path(__file__).parents[1]
OILS = ("4102", "4050", "4010")
TRUTHS = (
    *("deng2026", "wang-deng-load", "wang-deng-critical-load", "wang-deng-groups"),
    *("eyring", "carreau", "tanh", "heated film"),
)
LEVELS = ([1.0, 1.25, 1.5], [25.0, 30.0, 35.0, 40.0], [25.0, 50.0, 70.0, 85.0, 100.0, 120.0])
# Numbers of curves of a campaign.
PLANS = (72, 24, 18, 12)
QUICK_PLANS = (18, 12)
NEW_CONDITIONS = 30
SLIPS = np.linspace(0.01, 0.3, 30)
# Where the coverage is listed for the documentation.
TABLE = ROOT / "docs/explanation/coverage.csv"
# Standard uncertainties of a calibration, which all runs share.
SHARED_ERRORS = RunErrors(common_gain=0.005, common_load=0.003, common_temperature_c=0.5)


def with_calibration(points: pd.DataFrame, errors: RunErrors) -> pd.DataFrame:
    """The points with the standard uncertainties of a calibration stated.

    Args:
        points: Table of points.
        errors: Its `common_...` are the standard uncertainties; the speed is exact.
    """
    return points.assign(
        load_systematic_n=errors.common_load * points["load_n"],
        traction_force_systematic_n=errors.common_gain * points["traction_force_n"].abs(),
        entrainment_speed_systematic_m_s=0.0,
        inlet_temperature_systematic_c=errors.common_temperature_c,
    )


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
class FittedTruth:
    """A fitted law as a truth.

    Attributes:
        fit: The fit.
        contact: The contact of the rig, which gives the load of a pressure.
    """

    fit: FittedLaw
    contact: object

    def __call__(self, *conditions: FloatArray) -> FloatArray:
        """See `TrueTraction`."""
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
def truth_of(name: str, oil: str) -> TrueTraction:
    """The truth of this name."""
    constants = read_printed_constants(ROOT / "data/reference/printed_coefficients.yaml")
    settings = _settings("demo")
    if name == "deng2026":
        return LawTruth(constants[oil])
    if name == "heated film":
        return true_tractions(_settings("thermal"), constants)[oil]
    exact = replace(RunErrors(), **dict.fromkeys(vars(RunErrors()), 0.0))
    campaign = PointCampaign(LawTruth(constants[oil]), settings.common_contact(), exact)
    points = campaign.points(conditions_of(72), generator(1, "truth"), oil)
    law = laws_of_oil(oil, settings)[name]
    if name == "wang-deng-critical-load":
        # its own nearest constants have the critical load between two tested loads
        nested = truth_of("wang-deng-load", oil).fit
        constants = np.append(nested.coefficients.constants, (1e-3, -1.0, 0.0, 0.0))
        fitted = FittedLaw(law, Coefficients.from_constants(law, constants))
    else:
        fitted = _fitted(fit_oil(points, oil, _quick(72), 1, law), oil, law)
    return FittedTruth(fitted, settings.common_contact())


def _quick(curves: int):
    """Settings of a fit with fewer searches and refits: errors of intervals, not of optima."""
    return _settings("demo").fit.model_copy(update={"searches": 2, "bootstrap": 300})


def _fitted(fit, oil: str, law=None) -> FittedLaw:
    return FittedLaw.from_tables(fit.coefficients, oil, fit.refits, fit.fit_quality, law)


def trial(case: tuple[str, str, int, bool, int]) -> dict[str, object]:
    """One campaign: coverage and width of the interval of the mean curve.

    Args:
        case: Name of the truth, oil, number of curves, whether all runs share errors that the
            calibration states, and number of the campaign.
    """
    truth, oil, curves, common, number = case
    random = generator(7, "coverage", *map(str, case))
    settings = _settings("demo")
    errors = RunErrors()
    if common:
        drawn = random.standard_normal(3)
        errors = RunErrors(
            common_gain=SHARED_ERRORS.common_gain * drawn[0],
            common_load=SHARED_ERRORS.common_load * drawn[1],
            common_temperature_c=SHARED_ERRORS.common_temperature_c * drawn[2],
        )
    campaign = PointCampaign(truth_of(truth, oil), settings.common_contact(), errors)
    matrix = conditions_of(curves)
    points = campaign.points(matrix, random, oil)
    if common:
        points = with_calibration(points, SHARED_ERRORS)
    fit = fit_oil(points, oil, _quick(curves), number).replace(points=points)
    fit = with_surface(fit, oil, settings)
    fitted = FittedLaw.from_results(fit, oil)
    (quality,) = tables.rows(fit.fit_quality)
    sound = soundness_row(quality, fitted, points, settings)["sound"]
    conditions = spread_conditions(matrix.min(axis=0), matrix.max(axis=0), NEW_CONDITIONS, random)
    conditions_of_points = np.repeat(conditions, len(SLIPS), axis=0)
    slip = np.tile(SLIPS, NEW_CONDITIONS)
    true_mu = campaign.truth(*conditions_of_points.T, slip)
    prediction = fitted.predict(conditions_of_points, slip)
    lower, upper = prediction.mean_ci_lower, prediction.mean_ci_upper
    share_inside = np.mean((lower <= true_mu) & (true_mu <= upper))
    half_width = (upper - lower) / 2 / prediction.traction_coefficient
    return {
        "truth": truth, "oil": oil, "curves": curves, "common": common,
        "mean": share_inside, "own half": np.median(half_width),
        "sound": sound, "mean if sound": share_inside if sound else np.nan,
    }  # fmt: skip


def trial_of_twelve_runs(case: tuple[str, int]) -> tuple[FloatArray, FloatArray]:
    """One campaign of 12 runs: error of ln mu and half width, at the corners and in the middle."""
    oil, number = case
    campaign = PointCampaign(truth_of("deng2026", oil), _settings("demo").common_contact())
    matrix = conditions_of(12)
    points = campaign.points(matrix, generator(7, "few", oil, str(number)), oil)
    fitted = _fitted(fit_oil(points, oil, _quick(12), number), oil)
    ends = np.stack([matrix.min(axis=0), matrix.max(axis=0)])
    corners_and_middle = np.array([*itertools.product(*ends.T), ends.mean(axis=0)])
    conditions = np.repeat(corners_and_middle, 3, axis=0)
    slip = np.tile([0.01, 0.05, 0.3], len(corners_and_middle))
    prediction = fitted.predict(conditions, slip)
    error = np.log(prediction.traction_coefficient / campaign.truth(*conditions.T, slip))
    return error, np.log(prediction.mean_ci_upper / prediction.mean_ci_lower) / 2


def check_few(campaigns: int = 200) -> None:
    """Print the width of the interval of the mean curve over the right one, and how often it holds.

    The right half width at a point is the 95 % quantile of the error over all campaigns.
    """
    for oil in OILS:
        campaigns_of_oil = [trial_of_twelve_runs((oil, number)) for number in range(campaigns)]
        error, half = map(np.array, zip(*campaigns_of_oil, strict=True))
        ratio = np.median(half, axis=0) / np.quantile(np.abs(error), 0.95, axis=0)
        held = np.mean(np.abs(error) <= half)
        print(
            f"{oil}: median width over the right one, by point: {ratio.min():.2f} to "
            f"{ratio.max():.2f}, median {np.median(ratio):.2f}; truth inside at {held:.1%}"
        )


def main(replicates: int = 3, plans: tuple[int, ...] = PLANS, path: Path | None = TABLE) -> None:
    """Print the table, and renew the one of the documentation.

    Args:
        replicates: Campaigns of each truth, plan, oil and kind of calibration.
        plans: Numbers of curves.
        path: Where the table goes, anew after each row; nowhere if it is not given.
    """
    wanted = ["mean", "own half", "sound", "mean if sound"]
    rows = []
    for truth, curves, common in itertools.product(TRUTHS, plans, (False, True)):
        start = time.perf_counter()
        campaigns = pd.DataFrame(
            [
                trial((truth, oil, curves, common, number))
                for oil in OILS
                for number in range(replicates)
            ]
        )
        means = campaigns[wanted].astype(float).mean().round(3)
        rows.append({"truth": truth, "curves": curves, "common": common, **means})
        seconds = time.perf_counter() - start
        print(*rows[-1].values(), f"{seconds:.0f} s", flush=True)
        if path:
            pd.DataFrame(rows).to_csv(path, index=False, lineterminator="\n")


if __name__ == "__main__":
    numbers = [int(argument) for argument in sys.argv[1:] if argument.isdecimal()]
    with threadpool_limits(limits=1, user_api="blas"):
        match sys.argv[1:2]:
            case ["few"]:
                check_few(*numbers)
            case ["--quick"]:
                main(1, QUICK_PLANS, None)
            case _:
                main(*numbers)
