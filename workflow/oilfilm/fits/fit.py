"""One law fitted to one oil: searches, certificate, errors, also on curves that it has not seen.

Decides: the errors of curves left out.
"""

import itertools
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.base.randomness import generator
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.fits.conditions import (
    fixed_conditions,
    followed_conditions,
    incomplete_curves,
    levels_by_gap,
    to_text,
    varied,
)
from oilfilm.fits.descent import descend
from oilfilm.fits.engine import Optimum, at_bounds, polish, search
from oilfilm.fits.fit_tables import (
    Solution,
    certify,
    fitted_names,
    tables_of_fit,
    tables_without_fit,
)
from oilfilm.fits.interval import scores_of_unseen
from oilfilm.fits.objectives import robust_fit
from oilfilm.fits.problem import CurveData, Problem, build_problem, curve_data
from oilfilm.fits.uncertainty import (
    Estimates,
    calibration_refits,
    curve_bootstrap,
    naive_covariance,
    profiles,
    robust_draws,
)
from oilfilm.settings.config import FitSettings
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS, laws_for
from oilfilm.traction.law import CONDITIONS, Law, NoValueError

# Why the comparison of laws tells nothing about Wang-Deng where the paper's law made the points.
TIE = (
    "a tie by construction: Eq. 7 made the SIMULATED points, and for one ball size load-based "
    "Wang-Deng with D = -A is Eq. 7. Dimensionless Wang-Deng is another law. It is at a "
    "disadvantage, because Eq. 7 made the points"
)
# Of fits without some curves. A descent ends by its SSE; the errors of single points, which are
# reported, follow the constants more closely.
_TOLERANCE = 1e-8
# Columns of the points that span the tested box, and the columns of `fit_quality` that hold it.
BOX = (*CONDITIONS, "load_n", "slide_roll_ratio")


def laws_of(oil: str, settings: Settings) -> dict[str, Law]:
    """Every law whose needs an oil of a campaign and its rigs meet, by name."""
    return laws_for(settings.properties_of(oil), settings.common_contact())


def fit_law(points: pd.DataFrame, oil: str, name: str, settings: Settings) -> CampaignTables:
    """Fit one law to one oil's accepted points, and judge it by curves left out of the fit.

    Points, settings, seeds and the curves that are left out are the same for every law.

    Args:
        points: Table of points.
        oil: Oil to fit.
        name: The law.
        settings: `fit` and `seed`; for a law that needs properties of the oil and the
            contact, `oils` and `rigs` as well.

    Returns:
        As `fit_oil`. A law that needs unknown properties gives no values, with the reason.
    """
    law = LAWS[name] if name in LAWS else laws_of(oil, settings).get(name)
    if law is None:
        quality = {"oil": oil, "law": name, "configured": True}
        return tables_without_fit([], {**quality, "no_fit": "properties unknown"})
    return fit_oil(points, oil, settings.fit, settings.seed, law)


def fit_oil(
    points: pd.DataFrame, oil: str, settings: FitSettings, seed: int, law: Law | None = None
) -> CampaignTables:
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
    varying = itertools.compress(zip(law.conditions, data.conditions.T, strict=True), followed)
    two = [name for name, each in varying if levels_by_gap(each, settings.level_gap).max() == 1]
    fixed = fixed_conditions(law.conditions, data.conditions, followed, settings)
    quality: dict[str, Any] = {
        **{"oil": oil, "law": law.name, "configured": True},
        **{"n_points": len(data.mu), "n_curves": len(data.runs)},
        "incomplete_curves": tuple(left_out),
        "fixed_conditions": to_text(fixed),
        "two_level_conditions": tuple(two),
    }
    accepted = points.loc[points["accepted"], list(BOX)].abs()
    for end, values in (("min", accepted.min()), ("max", accepted.max())):
        quality |= {f"tested_{end}_{name}": float(values[name]) for name in BOX}
    obstacle = _obstacle(law, data, followed)
    if obstacle:
        return tables_without_fit(fitted_names(law), {**quality, **obstacle})
    problem = build_problem(law, data, followed)
    solution = _solve(problem, oil, points, settings, seed)
    quality |= _ends_out(solution, points, settings)
    return tables_of_fit(solution, points, quality, settings)


def _obstacle(law: Law, data: CurveData, followed: BoolArray) -> dict[str, Any]:
    """Why a law cannot be fitted to such data, as columns of `fit_quality`; empty where it can."""
    try:
        law.varied_groups(followed)
    except ValueError:
        return {"no_fit": "conditions did not vary"}
    try:
        problem = build_problem(law, data, followed)
    except NoValueError:
        return {"no_fit": "no value"}
    if not len(data.mu):
        return {"no_fit": "no points"}
    unusable = int(np.sum(~np.isfinite(data.mu + data.slip)))
    if unusable:
        return {"no_fit": "unknown traction", "unusable_points": unusable}
    if not np.any(data.slip):
        return {"no_fit": "no slip"}
    if not np.any(data.mu > 0):
        return {"no_fit": "no traction"}
    points = np.column_stack([data.conditions[data.curve], data.slip, data.mu])
    distinct = len(np.unique(points, axis=0))
    needed = int(problem.free.sum()) + 1
    if distinct < needed:
        counts = {"distinct_points": distinct, "points_needed": needed}
        return {"no_fit": "too few points", **counts}
    if np.ptp(data.mu) == 0:
        return {"no_fit": "constant traction"}
    return {}


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
    # a bound is where the search stopped, not what the curves say: its value means nothing
    refits = drawn[~at_bounds(problem, drawn).any(axis=1)]
    shifted = calibration_refits(problem, best, points)
    estimates = Estimates(best.values, naive, refits, shifted)
    # the same groups for every law
    random = generator(seed, "left out", oil)
    left_out = leave_curves_out(problem, best, settings, random)
    own_error = spread_left_out(problem, best, estimates.random_covariance)
    by_slip = problem.by_slip(best.values)
    return Solution(
        problem,
        best,
        certify(problem, optima, errors, settings),
        estimates.reported(problem),
        profiles(problem, best, naive),
        robust_fit(problem, best),
        left_out,
        scores_of_unseen(problem.mu + left_out, problem.mu, by_slip, own_error, problem.at.curve),
        len(drawn) - len(refits),
    )


def _from_nested(
    problem: Problem, settings: FitSettings, random: np.random.Generator
) -> list[Optimum]:
    """One more search, from the optimum of the law's special case; none where it has none."""
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
    """The problem with those constants held that are at a bound in the lowest of its optima.

    Beside it are all optima, without these constants.
    """
    values = min(ends, key=lambda optimum: optimum.sse).values
    stuck = at_bounds(problem, values)
    free = [Optimum(end.values[~stuck], end.sse) for end in ends]
    return problem.holding(values, stuck), free


def _ends_out(solution: Solution, points: pd.DataFrame, settings: FitSettings) -> dict[str, float]:
    """Errors at the lowest and highest level of each condition, left out of the fit."""
    # not the law's own conditions: every law is evaluated at the same levels
    conditions = curve_data(points).conditions
    # a condition that did not vary only scatters: it has no lowest and highest level
    levels = np.where(varied(CONDITIONS, conditions, settings), conditions, np.nan)
    problem, errors = solution.problem, {}
    for name, level in zip(("pressure", "speed", "temperature"), levels.T, strict=True):
        of_level = levels_by_gap(level, settings.level_gap)
        left = leave_ends_out(problem, solution.best, of_level, settings)
        size = np.sum(problem.mu[np.isfinite(left)] ** 2)
        rms = float(np.sqrt(np.nansum(left**2) / size)) if size else np.nan
        errors[f"{name}_end_out_relative_rms"] = rms
    return errors


# ---------------------------------------------------------------- curves left out


def leave_curves_out(
    problem: Problem, optimum: Optimum, settings: FitSettings, random: np.random.Generator
) -> FloatArray:
    """Error of each point's mu in a fit that has not seen its curve.

    Each such fit descends from the optimum of all; another valley is not looked for. Up to
    `left_out_groups` curves are left out one at a time. More are left out in as many groups, drawn
    at random, so that the cost grows with the number of curves and not with its square. A fit then
    misses some more curves than the one that it is judged by.

    Args:
        problem: What was fitted.
        optimum: Where it ended.
        settings: `left_out_groups`, and those of `followed_conditions`.
        random: Draws the groups.

    Returns:
        Fitted minus measured mu, shape (points,); NaN where the other curves leave a constant open.

    Reference: T. Hastie, R. Tibshirani, J. Friedman, The Elements of Statistical Learning, 2nd ed.
        (2009), section 7.10.1.
    """
    group = np.arange(problem.curves)
    if problem.curves > settings.left_out_groups:
        group = random.permutation(group) % settings.left_out_groups
    left_out = np.unique(group)[:, np.newaxis] == group
    return _errors_left_out(problem, optimum, left_out, settings)


def spread_left_out(problem: Problem, optimum: Optimum, covariance: FloatArray) -> FloatArray:
    """Random standard error of mu at each point, by a fit that has not seen its curve.

    Its square is that of the fit to all curves, times how much larger it is without the curve:
    g^T (J^T J - J_i^T J_i)^-1 g over g^T (J^T J)^-1 g.

    Args:
        problem: What was fitted.
        optimum: Where it ended.
        covariance: Of the free internal constants, shape (free, free).

    Returns:
        Shape (points,).
    """
    jacobian = problem.jacobian(optimum.values)
    variance = np.einsum("pi,ij,pj->p", jacobian, covariance, jacobian)
    orthonormal, _ = np.linalg.qr(jacobian)
    seen = np.sum(orthonormal**2, axis=1)
    unseen = np.empty_like(seen)
    for first, length in zip(problem.starts, problem.lengths, strict=True):
        of_curve = orthonormal[first : first + length]
        # (I - Q_i^T Q_i)^-1 is endless where the curve alone decides a direction
        others = np.linalg.pinv(np.eye(orthonormal.shape[1]) - of_curve.T @ of_curve)
        unseen[first : first + length] = np.einsum("pi,ij,pj->p", of_curve, others, of_curve)
    growth = np.divide(unseen, seen, out=np.ones_like(seen), where=seen > 0)
    return np.sqrt(np.maximum(variance * growth, 0.0))


def leave_ends_out(
    problem: Problem, optimum: Optimum, levels: IndexArray, settings: FitSettings
) -> FloatArray:
    """Error of each point's mu at the lowest and highest level, by fits without that level.

    Each fit is extrapolated to the level that it has not seen.

    Args:
        problem: What was fitted.
        optimum: Where it ended.
        levels: Level of each curve, counted from 0, as by `levels_by_gap`.
        settings: Those of `followed_conditions`.

    Returns:
        Fitted minus measured mu, shape (points,); NaN at all levels between, and at all points
        where there are fewer than two levels or the others leave a constant open.
    """
    if levels.max(initial=0) == 0:
        return np.full(len(problem.mu), np.nan)
    ends = np.stack([levels == 0, levels == levels.max()])
    return _errors_left_out(problem, optimum, ends, settings)


def _errors_left_out(
    problem: Problem, optimum: Optimum, left_out: BoolArray, settings: FitSettings
) -> FloatArray:
    """Errors at the curves that each row of `left_out` leaves out, by a fit to the others."""
    # not by the rank: a condition that has one level left still scatters
    conditions = problem.data.conditions[:, problem.varied]
    names = list(itertools.compress(problem.law.conditions, problem.varied))
    possible = [
        bool(followed_conditions(names, conditions[~row], settings).all()) and not row.all()
        for row in left_out
    ]
    left_out = left_out[possible]
    starts = np.tile(optimum.values, (len(left_out), 1))
    weights = (~left_out).astype(float)
    ends, _ = descend(problem, starts, weights=weights, tolerance=_TOLERANCE, near=True)
    errors = np.full(len(problem.mu), np.nan)
    for end, row in zip(ends, left_out, strict=True):
        points = row[problem.at.curve]
        errors[points] = problem.residual(end)[points]
    return errors
