"""How often the interval of a surface holds the next run, for oils that no law describes.

Each campaign is simulated as points and fitted with Deng's law, and a surface is fitted about it.
New runs at new conditions of the tested box, at slips between the tested ones, are simulated with
the same errors. The columns:

    claim        share of points that the interval should hold
    inside       share of points of new runs inside; least: the smallest share of a campaign
    < .005 ...   the same by slip
    w/i          half width of the interval over the 95 % quantile of the true deviation, median
    curves       share of whole curves inside their band; points without support count as inside
    err95, law   95 % quantile of the error of mu, of the surface and of the law
    answered     share of points with support
    point, curve factors of a single answer and of a band
    kappa        misfit of the law
    s            seconds per fit
    one of them  of designs with several rigs: share inside of runs on one of these rigs, which is
                 not named; `inside` and all other columns are those of runs on other rigs
    named        the same, where the rig of each new run is named

    python benchmarks/surface.py                     (24 and 12 runs, one seed)
    python benchmarks/surface.py all [seeds]         (ten designs, each with one kind of errors)
    python benchmarks/surface.py rigs [seeds]        (designs of three rigs, five kinds of errors)
    python benchmarks/surface.py table [seeds]       (all truths x designs x kinds of errors)
    python benchmarks/surface.py gaps [seeds]        (slips between and beyond the tested ones)
    python benchmarks/surface.py constants [seeds]   (constants and errors of runs of a true law)
    python benchmarks/surface.py scale               (time and memory over the number of runs)

`table` writes docs/explanation/surface_coverage.csv, with one row per truth, design and kind of
errors.

Takes 1 minute; `all` takes 3, `table` 12, `scale` 3.
"""

import itertools
import sys
import time
import tracemalloc
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from oilfilm.base.randomness import generator
from oilfilm.base.units import FloatArray
from oilfilm.surface.effects import EFFECT_NAMES
from oilfilm.surface.measurements import Measurements
from oilfilm.surface.reduction import ANOTHER_RIG
from oilfilm.surface.surface import Surface, fit_surface

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/helpers"))

from lawless_truths import DENG_CONSTANTS, INDEPENDENT_TRUTHS, TRUTHS, LawlessTruth, rounded
from surface_campaigns import (
    PRESSURES,
    SPEEDS,
    TEMPERATURES,
    PlantedErrors,
    ends,
    fitted_law,
    grid,
    latin,
    random_conditions,
    simulated,
    without_corners,
)

ROOT = Path(__file__).parents[1]
TABLE = ROOT / "docs/explanation/surface_coverage.csv"
NEW_RUNS, NEW_SLIPS = 40, 12
# Kinds of errors, see `surface_campaigns.PlantedErrors`.
ERROR_KINDS = ("norm", "logn", "heavy", "het", "slip0")
SLIP_REGIONS = {"< .005": (0, 0.005), "< .02": (0.005, 0.02), "< .1": (0.02, 0.1), "> .1": (0.1, 1)}
CORNERS = (ends(PRESSURES), ends(SPEEDS), ends(TEMPERATURES))
TWELVE = grid(ends(PRESSURES), ends(SPEEDS), (25.0, 72.0, 120.0))
CUBE_LEVELS = (PRESSURES, (25.0, 32.0, 40.0), (25.0, 72.0, 120.0))
CUBE = grid(*CUBE_LEVELS)


def mixed_rigs() -> FloatArray:
    """The 27 conditions, each level of each condition on each of three rigs that take turns."""
    pressures, speeds, temperatures = CUBE_LEVELS
    rows = []
    for (i, pressure), (j, speed) in itertools.product(enumerate(pressures), enumerate(speeds)):
        rows += [(pressure, speed, temperatures[(i + j + rig) % 3]) for rig in range(3)]
    return np.array(rows)


@dataclass(frozen=True)
class Design:
    """A plan of tests with its errors.

    Attributes:
        conditions: The conditions, drawn anew for each campaign if they are random.
        errors: Errors of runs and points.
    """

    conditions: Callable[[np.random.Generator], FloatArray]
    errors: PlantedErrors


DESIGNS = {
    "72": Design(lambda _: grid(PRESSURES, SPEEDS, TEMPERATURES), PlantedErrors()),
    "24 latin": Design(lambda _: latin(), PlantedErrors(kind="logn")),
    "20 random": Design(lambda random: random_conditions(20, random), PlantedErrors(kind="slip0")),
    # each rig runs one temperature, and new runs are those of three other rigs: a hard case
    "27, 3 rigs": Design(lambda _: CUBE, PlantedErrors(rig_gain=0.01)),
    "27, rigs mixed": Design(lambda _: mixed_rigs(), PlantedErrors(rig_gain=0.01)),
    "19, no corners": Design(lambda _: without_corners(), PlantedErrors(kind="heavy")),
    "36 = 3x2x3 x2": Design(
        lambda _: np.repeat(grid(PRESSURES, ends(SPEEDS), (25.0, 72.0, 120.0)), 2, axis=0),
        PlantedErrors(kind="het"),
    ),
    "24 = 2x3x4": Design(
        lambda _: grid(ends(PRESSURES), (25.0, 32.0, 40.0), (25.0, 57.0, 88.0, 120.0)),
        PlantedErrors(),
    ),
    "12 = 2x2x3": Design(lambda _: TWELVE, PlantedErrors()),
    "8 = 2x2x2": Design(lambda _: grid(*CORNERS), PlantedErrors()),
    "2x2x2 x3": Design(lambda _: np.repeat(grid(*CORNERS), 3, axis=0), PlantedErrors()),
}
# Designs of several rigs; new runs are those of other rigs.
OF_RIGS = ("27, 3 rigs", "27, rigs mixed")
# Tested slips, and slips that are asked for.
GAPS = (
    ((0.01, 0.05, 0.25), 0.12),
    ((0.01, 0.05, 0.25), 0.025),
    ((0.01, 0.05, 0.25), 0.005),
    ((0.005, 0.012, 0.06, 0.26), 0.13),
    ((0.01, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3), 0.022),
    ((0.02, 0.1, 0.18, 0.26, 0.3), 0.045),
    ((0.01, 0.03, 0.09, 0.27), 0.015),
    ((0.01, 0.03, 0.09, 0.27), 0.05),
    ((0.01, 0.03, 0.09, 0.27), 0.16),
    ((0.02, 0.2), 0.05),
    ((0.02, 0.2), 0.1),
    ((0.1, 0.14, 0.18, 0.22, 0.26, 0.3), 0.06),
    ((0.1, 0.14, 0.18, 0.22, 0.26, 0.3), 0.03),
    ((0.1, 0.14, 0.18, 0.22, 0.26, 0.3), 0.01),
)


def campaign(
    truth_name: str, design_name: str, seed: int, kind: str | None = None
) -> dict[str, object]:
    """One campaign: coverage, width and error of its surface.

    Args:
        truth_name: Name of the truth.
        design_name: Name of the design.
        seed: Number of the campaign.
        kind: Kind of errors; that of the design if it is not given.
    """
    truth, design = TRUTHS[truth_name], DESIGNS[design_name]
    errors = replace(design.errors, kind=kind or design.errors.kind)
    random = generator(23, "surface", truth_name, design_name, str(seed))
    conditions = design.conditions(random)
    random_rigs = generator(23, "rigs", truth_name, design_name, str(seed))
    rig_gains = errors.rig_gain * random_rigs.standard_normal(3)
    points = simulated(truth, conditions, random, errors, rig_gains=rig_gains)
    law = fitted_law(points)
    start = time.perf_counter()
    surface = fit_surface(points, law)
    seconds = time.perf_counter() - start

    lowest, highest = conditions.min(axis=0), conditions.max(axis=0)
    new_conditions = lowest + random.random((NEW_RUNS, 3)) * (highest - lowest)
    slips = np.exp(random.uniform(np.log(0.0015), np.log(0.3), NEW_SLIPS))
    new = simulated(truth, new_conditions, random, errors, np.sort(slips))
    factors = surface.interval_factors
    rig = ANOTHER_RIG if errors.rig_gain else None
    prediction = surface.predict(new.point_conditions, new.slip, rig)
    supported = prediction.support_codes == 0
    lower, upper = prediction.interval(factors.point)
    inside = (lower <= new.mu) & (new.mu <= upper)
    band_lower, band_upper = prediction.interval(factors.curve)
    outside_band = supported & ~((band_lower <= new.mu) & (new.mu <= band_upper))
    bad_curves = np.bincount(new.curve_of_point, outside_band) > 0
    deviation = np.abs(np.log(np.maximum(new.mu, 1e-9) / prediction.mu))[supported]
    half = factors.point * prediction.next_run_sd[supported]
    true = truth(*new.point_conditions.T, new.slip)
    of_law = np.exp(law.log_mu(new.point_conditions, new.slip))
    by_slip = {}
    for name, (above, below) in SLIP_REGIONS.items():
        region = supported & (new.slip >= above) & (new.slip < below)
        by_slip[name] = inside[region].mean() if region.any() else np.nan
    return {
        "truth": truth_name,
        "design": design_name,
        "errors": errors.kind,
        "claim": factors.level,
        "inside": inside[supported].mean() if supported.any() else np.nan,
        **by_slip,
        "w/i": np.median(half) / np.quantile(deviation, 0.95) if supported.any() else np.nan,
        "curves": 1 - bad_curves.mean(),
        "err95": np.quantile(np.abs(prediction.mu / true - 1), 0.95),
        "law": np.quantile(np.abs(of_law / true - 1), 0.95),
        "answered": supported.mean(),
        "point": factors.point,
        "curve": factors.curve,
        "kappa": surface.verdict.kappa,
        "s": seconds,
        **(on_same_rigs(surface, truth, new, errors, rig_gains) if errors.rig_gain else {}),
    }


def on_same_rigs(
    surface: Surface,
    truth: LawlessTruth,
    new: Measurements,
    errors: PlantedErrors,
    rig_gains: FloatArray,
) -> dict[str, float]:
    """Share inside of new runs on the rigs of a campaign, which are named or not.

    Args:
        surface: The surface of the campaign.
        truth: The truth.
        new: New runs, which give the conditions and slips.
        errors: Sizes of the errors.
        rig_gains: Gains of the rigs of the campaign.
    """
    slips = np.unique(new.slip)
    random = generator(23, "same rigs", str(new.mu[0]))
    runs = simulated(truth, new.conditions, random, errors, slips, rig_gains)
    shares = {}
    for name, rigs in {"one of them": (None,), "named": range(3)}.items():
        inside, half, deviation = [], [], []
        for rig in rigs:
            of_rig = (
                np.ones(len(runs.mu), dtype=bool)
                if rig is None
                else runs.rig_of_curve[runs.curve_of_point] == rig
            )
            prediction = surface.predict(runs.point_conditions[of_rig], runs.slip[of_rig], rig)
            lower, upper = prediction.interval(surface.interval_factors.point)
            supported, mu = prediction.support_codes == 0, runs.mu[of_rig]
            inside += ((lower <= mu) & (mu <= upper))[supported].tolist()
            half += (np.log(upper / lower) / 2)[supported].tolist()
            deviation += np.abs(np.log(np.maximum(mu, 1e-9) / prediction.mu))[supported].tolist()
        shares[name] = float(np.mean(inside))
        shares[f"{name}, w/i"] = float(np.median(half) / np.quantile(deviation, 0.95))
    return shares


def coverage(
    designs: tuple[str, ...],
    truths: tuple[str, ...],
    kinds: tuple[str | None, ...],
    seeds: int,
    path: Path | None = None,
) -> None:
    """Print the coverage by design, by truth and of the independent truths.

    Args:
        designs: Names of the designs.
        truths: Names of the truths.
        kinds: Kinds of errors; None stands for that of the design.
        seeds: Number of campaigns of each.
        path: Where the table goes, anew after each cell.
    """
    campaigns = []
    for design, truth, kind in itertools.product(designs, truths, kinds):
        campaigns.extend(campaign(truth, design, seed, kind) for seed in range(seeds))
        if path:
            # times are those of one machine
            cells_of(pd.DataFrame(campaigns)).drop(columns="s").round(3).to_csv(path, index=False)
    cells = cells_of(pd.DataFrame(campaigns))
    print_cells(cells)
    independent = cells[cells["truth"].isin(INDEPENDENT_TRUTHS)]
    if len(independent):
        print("\ntruths that were written after the method was fixed")
        print_cells(independent)


def cells_of(campaigns: pd.DataFrame) -> pd.DataFrame:
    """Means over the campaigns of each truth, design and kind of errors."""
    return campaigns.groupby(["design", "truth", "errors"], sort=False, as_index=False).mean()


def print_cells(cells: pd.DataFrame) -> None:
    """Print means by design, truth and kind of errors, and the cells far below the claim."""
    for group in ("design", "truth", "errors"):
        grouped = cells.groupby(group, sort=False)
        summary = grouped.mean(numeric_only=True)
        summary.insert(2, "least", grouped["inside"].min())
        summary["w/i"] = grouped["w/i"].median()
        print(summary.round(3).to_string(), end="\n\n")
    missed = cells[cells["inside"] < cells["claim"] - 0.08]
    print("cells more than 8 % below the claim:", len(missed), "of", len(cells))
    if len(missed):
        columns = ["design", "truth", "errors", "claim", "inside", "w/i"]
        print(missed[columns].round(3).to_string(index=False))


def gaps(seeds: int) -> None:
    """Print how often answers between tested slips hold, or are marked."""
    rows = []
    for tested, asked in GAPS:
        for name, truth in (TRUTHS | {"rounded": rounded}).items():
            for seed in range(seeds):
                random = generator(23, "gaps", name, str(tested), str(asked), str(seed))
                points = simulated(truth, CUBE, random, slips=np.array(tested))
                surface = fit_surface(points, fitted_law(points))
                conditions = random_conditions(NEW_RUNS, random)
                new = simulated(truth, conditions, random, slips=np.array([asked]))
                prediction = surface.predict(new.point_conditions, new.slip)
                lower, upper = prediction.interval(surface.interval_factors.point)
                marked = prediction.support_codes != 0
                held = marked | ((lower <= new.mu) & (new.mu <= upper))
                rows.append(
                    {
                        "tested": " ".join(map(str, tested)),
                        "asked": asked,
                        "held": held.mean(),
                        "marked": marked.mean(),
                        "half": np.median(prediction.next_run_sd) * surface.interval_factors.point,
                    }
                )
    grouped = pd.DataFrame(rows).groupby(["tested", "asked"], sort=False)
    summary = grouped.mean()
    summary.insert(1, "least", grouped["held"].min())
    print(summary.round(3).to_string())


def constants(seeds: int) -> None:
    """Print how far constants and sizes of errors are from planted ones, where the law is true.

    `rms z` and `largest z` are differences over the standard errors of the constants. The other
    columns are found sizes over planted ones, means of logarithms.
    """
    rows = []
    for name, seed in itertools.product(("24 latin", "27", "72"), range(seeds)):
        random = generator(23, "constants", name, str(seed))
        conditions = CUBE if name == "27" else DESIGNS[name].conditions(random)
        points = simulated(TRUTHS["own"], conditions, random)
        surface = fit_surface(points, fitted_law(points))
        verdict = surface.verdict
        z = (verdict.constants - DENG_CONSTANTS) / verdict.standard_errors
        planted = PlantedErrors()
        found = surface.misfit_covariance.sizes
        over_planted = {
            effect: found.effects[number] / getattr(planted, effect)
            for number, effect in enumerate(EFFECT_NAMES)
        }
        over_planted["noise"] = found.noise / planted.noise
        logarithms = {effect: np.log(ratio) for effect, ratio in over_planted.items()}
        rows.append({"runs": name, "square": np.mean(z**2), "z": np.abs(z).max(), **logarithms})
    grouped = pd.DataFrame(rows).groupby("runs", sort=False)
    summary = np.exp(grouped.mean())
    summary["rms z"] = np.sqrt(grouped["square"].mean())
    summary["largest z"] = grouped["z"].max()
    print(summary.drop(columns=["square", "z"]).round(2).to_string())


def scale() -> None:
    """Print seconds, and the largest memory of arrays in a fit, over the number of runs."""
    print("  runs      s    MB  err95")
    for runs in (100, 300, 1000, 3000):
        random = generator(23, "scale", str(runs))
        conditions = random_conditions(runs, random)
        points = simulated(TRUTHS["jt"], conditions, random)
        law = fitted_law(points)
        start = time.perf_counter()
        surface = fit_surface(points, law)
        seconds = time.perf_counter() - start
        tracemalloc.start()
        fit_surface(points, law)
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        at = random_conditions(NEW_RUNS, random)
        slip = np.full(NEW_RUNS, 0.05)
        error = surface.predict(at, slip).mu / TRUTHS["jt"](*at.T, slip) - 1
        print(f"{runs:6d} {seconds:6.1f} {peak / 1e6:5.0f} {np.quantile(np.abs(error), 0.95):6.4f}")


def main(arguments: list[str]) -> None:
    """Print the table that the arguments ask for."""
    seeds = int(arguments[1]) if len(arguments) > 1 else 1
    match arguments[:1]:
        case ["all"]:
            coverage(tuple(DESIGNS), tuple(TRUTHS), (None,), seeds)
        case ["table"]:
            coverage(tuple(DESIGNS), tuple(TRUTHS), ERROR_KINDS, seeds, TABLE)
        case ["rigs"]:
            coverage(OF_RIGS, tuple(TRUTHS), ERROR_KINDS, seeds)
        case ["gaps"]:
            gaps(seeds)
        case ["constants"]:
            constants(seeds)
        case ["scale"]:
            scale()
        case []:
            coverage(("24 latin", "12 = 2x2x3"), tuple(TRUTHS), (None,), 1)
        case _:
            raise SystemExit(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])
