"""Lost signs of the printed exponents: all 512 sets per oil, compared with the paper's text.

A set's total is the number of statements that hold, each counted by the share of its box where it
does. A sign is judged by its margin: the best total among the sets that have it, less the best
among those that have the other one, whatever the other eight signs are.

Decides: which signs the printed exponents may have.
"""

import itertools
from collections.abc import Collection, Mapping

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.paper.printed.judge import squared_errors
from oilfilm.paper.printed.statements import (
    HALF,
    LAW,
    Surface,
    hot_convergence,
    share,
    viscosity_order,
    where_true,
)
from oilfilm.settings.config import PrintedSettings, SignSettings
from oilfilm.traction.law import to_constants, to_internal
from oilfilm.units import FloatArray

Shares = dict[str, FloatArray]  # of its box where a statement holds, for each sign set

_EXPONENTS = [index for index, constant in enumerate(LAW.constants) if constant.condition]
_SETS = np.array(list(itertools.product((1, -1), repeat=len(_EXPONENTS))))  # one row per set
# The slips whose totals count come first; the others may only lower a verdict.
_SLIPS = ("curve", "figures")


def study_signs(
    printed: Mapping[str, FloatArray],
    points: pd.DataFrame,
    oils: Collection[str],
    settings: PrintedSettings,
    traction_max: float,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Score every sign set of every oil, and judge every sign in use.

    Args:
        printed: The twelve constants of each oil, with the signs in use, the most viscous first.
        points: Table of points of the campaign, for the sum of squared errors of each set.
        oils: The oils whose rows are given.
        settings: Boxes of conditions, slide-roll ratios and limits.
        traction_max: Largest believable mu.

    Returns:
        The tables `signs` and `sign_verdicts`.
    """
    # internal constants of every sign set, shape (constants, sets); A0, B0, C0 keep their sign
    candidates = {}
    for oil, constants in printed.items():
        internal = np.tile(to_internal(LAW, constants)[:, np.newaxis], (1, len(_SETS)))
        internal[_EXPONENTS] = np.abs(internal[_EXPONENTS]) * _SETS.T
        candidates[oil] = internal
    scores = [_scores(candidates, slips, settings, traction_max) for slips in _SLIPS]
    sets, verdicts = [], []
    for oil in [oil for oil in printed if oil in oils]:
        of_oil, internal = [each[oil] for each in scores], candidates[oil]
        constants = np.array([to_constants(LAW, of_set) for of_set in internal.T])
        totals = [pd.Series(_total(shares)) for shares in of_oil]
        ranks = [total.rank(method="min", ascending=False).astype(int) for total in totals]
        in_use = (np.sign(printed[oil][_EXPONENTS]) == _SETS).all(axis=1)
        rows = pd.DataFrame(
            {
                "oil": oil,
                "signs": ["".join("+" if sign > 0 else "-" for sign in signs) for signs in _SETS],
                "in_use": in_use,
                "rank": ranks[0],
                "rank_at_figures": ranks[1],
                "total": totals[0],
                "near_best": totals[0] > totals[0].max() - settings.signs.near_best,
                **of_oil[0],
                "sse": squared_errors(points[points["oil"] == oil], constants),
            }
        )
        sets.append(rows.sort_values("total", ascending=False, kind="stable"))
        effects = _effects(internal[:, in_use], settings)
        verdicts.append(_verdicts(rows, of_oil, effects, settings.signs))
    if not sets:
        return tables.empty("signs"), tables.empty("sign_verdicts")
    return (
        tables.conform(pd.concat(sets), "signs", "sign sets"),
        tables.conform(pd.concat(verdicts), "sign_verdicts", "signs"),
    )


def _scores(
    candidates: Mapping[str, FloatArray],
    slips: str,
    settings: PrintedSettings,
    traction_max: float,
) -> dict[str, Shares]:
    """The statements' shares of each oil."""
    scores, surfaces, best = {}, {}, {}
    for oil, internal in candidates.items():
        tested = _surface("tested", slips, internal, settings)
        surfaces[oil] = drawn = _surface("extrapolated", slips, internal, settings)
        compared = settings.signs.slide_roll_ratio.figures
        holds = where_true(tested, drawn, compared, traction_max, settings.signs)
        scores[oil] = {name: share(each) for name, each in holds.items()}
        winner = int(np.argmax(_total(scores[oil])))
        best[oil] = _surface("extrapolated", slips, internal[:, [winner]], settings)
    # the others as their own statements choose them: the signs in use must not vouch for each other
    others = list(best.values())
    for index, (oil, surface) in enumerate(surfaces.items()):
        before, after = others[:index], others[index + 1 :]
        scores[oil]["viscosity_order"] = viscosity_order(surface, before, after)
        scores[oil]["hot_convergence"] = hot_convergence(surface, before + after)
    return scores


def _surface(box: str, slips: str, internal: FloatArray, settings: PrintedSettings) -> Surface:
    levels, slip = settings.boxes.model_dump()[box], settings.signs.slide_roll_ratio.model_dump()
    return Surface.over(levels, settings.signs.levels, slip[slips], internal)


def _total(shares: Shares, without: str = "") -> FloatArray:
    """Number of statements that hold, those that cannot be asked not counted."""
    weighted = [
        (0.5 if name in HALF else 1.0) * share for name, share in shares.items() if name != without
    ]
    return np.nansum(weighted, axis=0)


def _effects(in_use: FloatArray, settings: PrintedSettings) -> FloatArray:
    """Largest change of mu over the tested box if one sign is turned, over the largest mu."""
    turned = np.tile(in_use, (1, 1 + len(_EXPONENTS)))
    turned[_EXPONENTS, range(1, turned.shape[1])] *= -1
    mu = _surface("tested", _SLIPS[0], turned, settings).mu.reshape(-1, turned.shape[1])
    return np.abs(mu[:, 1:] - mu[:, :1]).max(axis=0) / mu[:, 0].max()


def _verdicts(
    sets: pd.DataFrame, by_slips: list[Shares], effects: FloatArray, limits: SignSettings
) -> pd.DataFrame:
    """One row per sign in use of one oil."""
    signs = _SETS[sets["in_use"]][0]
    has = (signs == _SETS).T

    def margins(total: FloatArray) -> list[float]:
        return [total[own].max() - total[~own].max() for own in has]

    without = pd.DataFrame(
        {
            (name, slips): margins(_total(shares, without=name))
            for slips, shares in zip(_SLIPS, by_slips, strict=True)
            for name in shares
        }
    )
    weakest = without.idxmin(axis=1)
    frame = pd.DataFrame(
        {
            "oil": sets["oil"].iloc[0],
            "constant": [LAW.constants[index].name for index in _EXPONENTS],
            "sign": np.where(signs > 0, "+", "-"),
            "margin": margins(sets["total"].to_numpy()),
            "weakest_margin": without.min(axis=1),
            "weakest_without": weakest.str[0],
            "weakest_slips": weakest.str[1],
            "near_best_share": [own[sets["near_best"]].mean() for own in has],
            "effect": effects,
            "least_sse": [sets["sse"][own].min(skipna=False) for own in has],
            "least_sse_turned": [sets["sse"][~own].min(skipna=False) for own in has],
        }
    )
    return frame.assign(
        verdict=verdicts(frame["margin"], frame["weakest_margin"], frame["effect"], limits)
    )


def verdicts(
    margin: pd.Series, weakest: pd.Series, effect: pd.Series, limits: SignSettings
) -> np.ndarray:
    """How sure the signs in use are.

    Without effect: turning it alone moves mu by `no_effect_max` of its largest value at most.
    Settled: all sets within `near_best` statements of the best have the sign, whichever one
    statement is left out and at either slips. Probable: all of them have it at the slips of the
    whole curve, with every statement.
    Against: all of them have the other one. Open: both signs are among them.

    Args:
        margin: In statements (see the module).
        weakest: The smallest margin with any one statement left out, at either slips.
        effect: Largest change of mu over its largest value.
        limits: The limits.
    """
    near, none = limits.near_best, effect <= limits.no_effect_max
    found = [none, weakest >= near, margin >= near, margin <= -near]
    return np.select(found, ["without effect", "settled", "probable", "against"], "open")
