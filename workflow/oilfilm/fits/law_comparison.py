"""Several laws fitted to the same points by the same engine, held side by side."""

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.fits.certificate import tested_grid, traction_on
from oilfilm.fits.conditions import varied
from oilfilm.fits.cross_validation import (
    leave_curves_out,
    leave_ends_out,
    level_of,
    relative_rms,
)
from oilfilm.fits.drawn import NOTHING, Drawn
from oilfilm.fits.engine import Optimum
from oilfilm.fits.fit import OilFit, fit_oil
from oilfilm.fits.problem import Problem, curve_data
from oilfilm.fits.solution import Solution
from oilfilm.randomness import generator
from oilfilm.settings.config import FitSettings
from oilfilm.settings.resolved import Settings
from oilfilm.traction import laws_for
from oilfilm.traction.law import CONDITIONS, FloatArray, Law

# Why the laws' comparison says nothing of Wang-Deng where the paper's law made the points.
TIE = (
    "a tie by construction: Eq. 7 made the SIMULATED points, and for one ball size load-based "
    "Wang-Deng with D = -A is Eq. 7. Dimensionless Wang-Deng is another law. It is at a "
    "disadvantage, because Eq. 7 made the points"
)
# Traction this small beside the largest is rounding: no dip below zero, no second rise.
_ROUNDING = 1e-9


def compare_laws(
    points: pd.DataFrame,
    oil: str,
    settings: Settings,
    only: Collection[str] | None = None,
    drawn: Mapping[str, Drawn] | None = None,
) -> dict[str, pd.DataFrame]:
    """Fit all laws of config's `compare` to one oil's accepted points.

    Settings, seeds, points and weights are the same for each law; only the refits for the errors
    are fewer than those of the main fit.

    Args:
        points: Table of points of the campaign.
        oil: Oil to fit.
        settings: `compare`, `fit`, `seed`, `oils` and `rigs` of the settings.
        only: The laws that are fitted here; all if not given.
        drawn: What other jobs have computed of the fits, by law; it changes no byte.

    Returns:
        Name of each table of a comparison and the oil's rows of it. A law that cannot be fitted, or
        that needs unknown properties, gives rows without values and a verdict with the reason.
    """
    of_oil = points[points["oil"] == oil]
    compared = [name for name in settings.compare.laws if only is None or name in only]
    known = dict.fromkeys(compared, NOTHING) | dict(drawn or {})
    fit_settings, laws = fit_of_comparison(settings), laws_of(oil, settings)
    fits = {
        name: fit_oil(of_oil, oil, fit_settings, settings.seed, law=laws[name], drawn=known[name])
        for name in compared
        if name in laws
    }
    unseen = {name: _unseen_errors(fit, oil, settings, known[name]) for name, fit in fits.items()}
    rows = [
        _row(fits[name], unseen[name], of_oil, settings) if name in fits else _no_row(oil, name)
        for name in compared
    ]
    beside = [_law_points(oil, fits[name], unseen[name], of_oil) for name in fits]

    def all_laws(table: str) -> pd.DataFrame:
        filled = [fit.tables[table] for fit in fits.values() if len(fit.tables[table])]
        return pd.concat(filled, ignore_index=True) if filled else tables.empty(table)

    return {
        "comparison": tables.from_rows(rows, "comparison"),
        "law_coefficients": all_laws("coefficients"),
        "law_fit_quality": all_laws("fit_quality"),
        "law_refits": all_laws("refits"),
        "law_points": tables.conform(
            pd.concat([tables.empty("law_points"), *beside], ignore_index=True),
            "law_points",
            "comparison",
        ),
    }


def remarks(comparison: pd.DataFrame) -> list[str]:
    """The result of each law, one sentence per row of the table `comparison`."""
    return [
        f"{row['oil']}, {row['law']}: {row['n_constants']} constants, "
        f"rmse {row['rmse']:.2e}, of curves left out {row['left_out_rmse']:.2e}; "
        f"{row['certificate']}"
        for row in tables.rows(comparison)
    ]


def fit_of_comparison(settings: Settings) -> FitSettings:
    """Settings of the fits that are compared: fewer refits than those of the main fit."""
    return settings.fit.model_copy(update={"bootstrap": settings.compare.bootstrap})


def laws_of(oil: str, settings: Settings) -> dict[str, Law]:
    """Every law whose needs an oil of a campaign and its rigs meet, by name."""
    return laws_for(settings.properties_of(oil), settings.common_contact())


def information_criteria(sse: float, n_points: int, n_constants: int) -> tuple[float, float]:
    """Akaike's and the Bayesian information criterion of a least-squares fit.

        AIC = n ln(SSE/n) + 2 k,   BIC = n ln(SSE/n) + k ln n

    k counts the constants and the variance of the errors; terms that all laws share are left out.
    Both take every point for independent, which points of a run are not: differences between laws
    look surer than they are.

    Args:
        sse: Sum of squared errors.
        n_points: n.
        n_constants: Constants fitted.

    Returns:
        AIC and BIC; NaN for an exact fit.

    Reference: K. P. Burnham, D. R. Anderson, Model Selection and Multimodel Inference, 2nd ed.
        (2002), sections 2.2 and 6.4.

    Examples:
        By hand, 100 ln(1e-4/100) = -1381.55, k = 3:

        >>> aic, bic = information_criteria(1e-4, 100, 2)
        >>> print(f"{aic:.2f} {bic:.2f}")
        -1375.55 -1367.74
    """
    if sse <= 0:
        return float("nan"), float("nan")
    fit, k = n_points * np.log(sse / n_points), n_constants + 1
    return float(fit + 2 * k), float(fit + k * np.log(n_points))


def curve_shapes(mu: FloatArray) -> tuple[float, float]:
    """Where curves of mu against slip are not as the paper says: shares of the given grid.

    Args:
        mu: Shape (conditions, slips), slips rising.

    Returns:
        Share of all points where mu is below zero, and share of conditions at which mu rises again
        after a fall: more than the paper's one peak.
    """
    rounding = _ROUNDING * float(np.abs(mu).max(initial=0.0))
    steps = np.diff(mu, axis=1)
    fallen = np.logical_or.accumulate(steps < -rounding, axis=1)
    again = np.any(fallen & (steps > rounding), axis=1)
    return float(np.mean(mu < -rounding)), float(np.mean(again))


_COPIED = (
    "oil",
    "law",
    "n_points",
    "n_curves",
    "sse",
    "rmse",
    "relative_rms",
    "max_error",
    "condition_number",
    "active_bounds",
    "certified",
    "certificate",
)
_COMPUTED = (
    "aic",
    "bic",
    "left_out_rmse",
    "pressure_end_out_relative_rms",
    "speed_end_out_relative_rms",
    "temperature_end_out_relative_rms",
    "zero_slip_traction",
    "negative_share",
    "second_rise_share",
)


def _no_row(oil: str, law: str) -> dict[str, Any]:
    counts = dict.fromkeys(("n_points", "n_curves", "n_constants"), 0)
    reason = "not fitted: the law needs the oil's properties and one known contact (config)"
    none = dict.fromkeys((*_COPIED, *_COMPUTED), np.nan)
    words = {"oil": oil, "law": law, "active_bounds": "", "certificate": reason}
    return {**none, **counts, **words, "certified": False}


def errors_left_out(
    problem: Problem, best: Optimum, oil: str, settings: Settings, block: slice = slice(None)
) -> FloatArray:
    """Error of each point in the fit that has not seen its curve; of a block of groups."""
    # the same groups for every law
    random = generator(settings.seed, "left out", oil)
    return leave_curves_out(problem, best, settings.compare.left_out_groups, random, block)


def _unseen_errors(fit: OilFit, oil: str, settings: Settings, drawn: Drawn) -> FloatArray:
    """The same of a whole fit; none without a fit."""
    if fit.solution is None:
        return np.empty(0)
    if drawn.left_out is not None:
        return drawn.left_out
    return errors_left_out(fit.solution.problem, fit.solution.best, oil, settings)


def _law_points(oil: str, fit: OilFit, unseen: FloatArray, points: pd.DataFrame) -> pd.DataFrame:
    """Rows of the table `law_points` of one law."""
    if fit.solution is None:
        return tables.empty("law_points")
    problem, best, data = fit.solution.problem, fit.solution.best, fit.solution.data
    used = points["accepted"] & points["run_id"].isin(data.runs)
    # the order of `curve_data`, whose traction is that of positive slip
    at = points[used].sort_values(["run_id", "first_row"])
    side = np.where(at["slide_roll_ratio"] < 0, -1.0, 1.0)
    return at[["run_id", "first_row", "slide_roll_ratio"]].assign(
        oil=oil,
        law=problem.law.name,
        traction_coefficient=side * (data.mu + problem.residual(best.values)),
        left_out_traction_coefficient=side * (data.mu + unseen),
    )


def _row(
    fit: OilFit, unseen: FloatArray, points: pd.DataFrame, settings: Settings
) -> dict[str, Any]:
    quality = tables.rows(fit.fit_quality)[0]
    copied = {name: quality[name] for name in _COPIED}
    if fit.solution is None:
        return {**copied, **dict.fromkeys(_COMPUTED, np.nan), "n_constants": 0}
    return {**copied, **_judged(fit.solution, unseen, points, settings)}


def _judged(
    solution: Solution, unseen: FloatArray, points: pd.DataFrame, settings: Settings
) -> dict[str, Any]:
    problem, best, mu = solution.problem, solution.best, solution.data.mu
    constants = len(best.values) + len(problem.at_bounds)
    values = information_criteria(best.sse, len(mu), constants)
    # not the law's own conditions: every law is evaluated at the same levels
    conditions = curve_data(points).conditions
    # the scatter of one level has no ends
    levels = np.where(varied(CONDITIONS, conditions, settings.fit), conditions, np.nan)
    ends_out = [
        leave_ends_out(problem, best, level_of(condition, settings.compare.level_gap))
        for condition in levels.T
    ]
    on_grid = traction_on(problem, best, *tested_grid(problem, solution.data))
    starts = on_grid[:, 0]
    numbers = (
        *values,
        float(np.sqrt(np.mean(unseen**2))),
        *(relative_rms(errors, mu) for errors in ends_out),
        float(starts[np.argmax(np.abs(starts))]),
        *curve_shapes(on_grid),
    )
    return {"n_constants": constants, **dict(zip(_COMPUTED, numbers, strict=True))}
