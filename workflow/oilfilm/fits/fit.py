"""One law fitted to one oil: searches, certificate, errors."""

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.fits.certificate import certify
from oilfilm.fits.conditions import (
    fixed_conditions,
    followed_conditions,
    incomplete_curves,
    to_text,
    varied,
)
from oilfilm.fits.cross_validation import (
    leave_curves_out,
    leave_ends_out,
    level_of,
    relative_rms,
    spread_left_out,
)
from oilfilm.fits.engine import Optimum, at_bounds, polish, search
from oilfilm.fits.fit_tables import Solution, fitted_names, tables_of_fit, tables_without_fit
from oilfilm.fits.interval import scores_of_unseen
from oilfilm.fits.objectives import robust_fit
from oilfilm.fits.problem import (
    CurveData,
    Problem,
    build_problem,
    curve_data,
)
from oilfilm.fits.uncertainty import (
    Estimates,
    calibration_refits,
    curve_bootstrap,
    naive_covariance,
    profiles,
    robust_draws,
    without_bounds,
)
from oilfilm.randomness import generator
from oilfilm.settings.config import FitSettings
from oilfilm.traction import LAWS
from oilfilm.traction.law import CONDITIONS, Law
from oilfilm.units import BoolArray, FloatArray

# Columns of the points that span the tested box, and the columns of `fit_quality` that hold it.
BOX = (
    "max_hertz_pressure_gpa",
    "entrainment_speed_m_s",
    "inlet_temperature_c",
    "load_n",
    "slide_roll_ratio",
)


@dataclass(frozen=True)
class OilFit:
    """The tables of one oil's fit by name, and what they were made from.

    `solution` is None where the data could not be fitted.
    """

    tables: dict[str, pd.DataFrame]
    solution: Solution | None

    @property
    def coefficients(self) -> pd.DataFrame:
        """Table of coefficients."""
        return self.tables["coefficients"]

    @property
    def fit_quality(self) -> pd.DataFrame:
        """Table of fit quality."""
        return self.tables["fit_quality"]

    @property
    def refits(self) -> pd.DataFrame:
        """Table of refits."""
        return self.tables["refits"]

    @property
    def certificate(self) -> str:
        """The certificate of the fit in a sentence."""
        return str(self.fit_quality["certificate"].item())


def fit_oil(
    points: pd.DataFrame,
    oil: str,
    settings: FitSettings,
    seed: int,
    law: Law | None = None,
) -> OilFit:
    """Fit a law to one oil's accepted points.

    Args:
        points: Table of points of the campaign.
        oil: Oil to fit.
        settings: Config's `fit`.
        seed: Of all random numbers.
        law: The configured law if not given.

    Returns:
        The oil's rows of the tables of a fit. Data that cannot be fitted give rows without values
        and a verdict that says why.
    """
    law = law or LAWS[settings.law]
    points = points[points["oil"] == oil]
    data = curve_data(points, law.conditions)
    incomplete = incomplete_curves(law.conditions, data.conditions, settings)
    left_out = list(itertools.compress(data.runs, incomplete))
    if left_out:
        points = points[~points["run_id"].isin(left_out)]
        data = curve_data(points, law.conditions)
    followed = followed_conditions(law.conditions, data.conditions, settings)
    about = {"oil": oil, "law": law.name, "incomplete_curves": "; ".join(left_out)}
    quality = about | _tested(law, data, followed, settings) | _tested_box(points)
    try:
        problem = build_problem(law, data, followed)
        _refuse_hopeless(problem)
    except ValueError as error:
        return OilFit(tables_without_fit(fitted_names(law), quality, str(error)), None)
    solution = _solve(problem, oil, points, settings, seed)
    quality |= _ends_out(solution, points, settings)
    return OilFit(tables_of_fit(solution, points, quality, settings), solution)


def _tested(
    law: Law, data: CurveData, followed: BoolArray, settings: FitSettings
) -> dict[str, Any]:
    """What the table of quality says of the curves before any search."""
    conditions = itertools.compress(zip(law.conditions, data.conditions.T, strict=True), followed)
    two = [name for name, each in conditions if level_of(each, settings.level_gap).max() == 1]
    fixed = fixed_conditions(law.conditions, data.conditions, followed, settings)
    return {
        "configured": True,
        "n_points": len(data.mu),
        "n_curves": len(data.runs),
        "fixed_conditions": to_text(fixed),
        "two_level_conditions": ", ".join(two),
    }


def _refuse_hopeless(problem: Problem) -> None:
    """Raise a ValueError that says in words why no law can be fitted to such data."""
    data = problem.data
    if not len(data.mu):
        raise ValueError("0 accepted points")
    lost = int((~np.isfinite(data.mu) | ~np.isfinite(data.slip)).sum())
    if lost:
        raise ValueError(f"{lost} accepted points have no traction coefficient or no slip")
    if not np.any(data.slip):
        raise ValueError("every slide-roll ratio is zero, where traction says nothing")
    if not np.any(data.mu > 0):
        raise ValueError(
            "no accepted point has traction above zero; is the sign of the force right "
            "(semantics of the campaign file)?"
        )
    levels = data.conditions[data.curve]
    distinct = len(np.unique(np.column_stack([levels, data.slip, data.mu]), axis=0))
    needed = int(problem.free.sum()) + 1
    if distinct < needed:
        copies = f", {distinct} of them distinct" if distinct < len(data.mu) else ""
        raise ValueError(
            f"{len(data.mu)} accepted points{copies}; at least {needed} distinct ones are needed"
        )
    if np.ptp(data.mu) == 0:
        raise ValueError(f"mu is {data.mu[0]:.4g} at every point, whatever the slip")


def _solve(
    problem: Problem, oil: str, points: pd.DataFrame, settings: FitSettings, seed: int
) -> Solution:
    randoms = [generator(seed, "search", oil, number) for number in range(settings.searches)]
    ends = search(problem, settings, randoms)
    ends += _from_nested(problem, settings, generator(seed, "nested", oil))
    problem, optima = _with_bounds_held(problem, ends)
    best = min(optima, key=lambda optimum: optimum.sse)
    naive = naive_covariance(problem, best)
    errors = np.sqrt(np.diag(naive))
    drawn = _refits(problem, best, settings, generator(seed, "bootstrap", oil))
    refits = without_bounds(problem, drawn)
    shifted = calibration_refits(problem, best, points)
    estimates = Estimates(best.values, naive, refits, shifted)
    # the same groups for every law
    random = generator(seed, "left out", oil)
    left_out = leave_curves_out(problem, best, settings.left_out_groups, random)
    own_error = spread_left_out(problem, best, estimates.random_covariance)
    by_slip = problem.law.jacobian(problem.expand(best.values), problem.at) @ problem.law.slip_scale
    return Solution(
        problem,
        best,
        certify(problem, optima, errors, settings),
        estimates,
        profiles(problem, best, naive),
        robust_fit(problem, best),
        left_out,
        scores_of_unseen(problem.mu + left_out, problem.mu, by_slip, own_error, problem.at.curve),
        len(drawn) - len(refits),
    )


def _from_nested(
    problem: Problem, settings: FitSettings, random: np.random.Generator
) -> list[Optimum]:
    """The end next to the optimum of the law's special case, as one more search, if it has one."""
    if problem.law.nested is None:
        return []
    inner = build_problem(problem.law.nested, problem.data, problem.varied)
    (best,) = search(inner, settings, [random])
    names = [constant.name for constant in inner.law.constants]
    known = dict(zip(names, inner.expand(best.values), strict=True))
    start = [known.get(constant.name, constant.lower) for constant in problem.law.constants]
    return [polish(problem, np.array(start)[problem.free])]


def _refits(
    problem: Problem, best: Optimum, settings: FitSettings, random: np.random.Generator
) -> FloatArray:
    """Constants spread as other campaigns of such runs would give them; none of too few curves."""
    if problem.curves < settings.min_curves_for_errors:
        return np.empty((0, len(best.values)))
    spread = robust_draws if problem.curves < settings.min_curves_to_resample else curve_bootstrap
    return spread(problem, best, settings.bootstrap, random)


def _with_bounds_held(problem: Problem, ends: list[Optimum]) -> tuple[Problem, list[Optimum]]:
    """The problem with constants held that ran into a bound at its lowest end, and all ends."""
    values = min(ends, key=lambda optimum: optimum.sse).values
    stuck = at_bounds(problem, values)
    free = [Optimum(end.values[~stuck], end.sse) for end in ends]
    return problem.holding(values, stuck), free


def _tested_box(points: pd.DataFrame) -> dict[str, float]:
    """Smallest and largest value of each condition over the accepted points, NaN if unknown."""
    accepted = points.loc[points["accepted"], list(BOX)].abs()
    low, high = accepted.min(), accepted.max()
    return {
        **{f"tested_min_{name}": float(low[name]) for name in BOX},
        **{f"tested_max_{name}": float(high[name]) for name in BOX},
    }


def _ends_out(solution: Solution, points: pd.DataFrame, settings: FitSettings) -> dict[str, float]:
    """Errors at the lowest and highest level of each condition, left out of the fit."""
    # not the law's own conditions: every law is evaluated at the same levels
    conditions = curve_data(points).conditions
    # the scatter of one level has no ends
    levels = np.where(varied(CONDITIONS, conditions, settings), conditions, np.nan)
    errors = [
        leave_ends_out(solution.problem, solution.best, level_of(level, settings.level_gap))
        for level in levels.T
    ]
    return {
        f"{name}_end_out_relative_rms": relative_rms(error, solution.problem.mu)
        for name, error in zip(("pressure", "speed", "temperature"), errors, strict=True)
    }
