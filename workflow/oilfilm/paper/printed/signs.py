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
    BETWEEN_OILS,
    LAW,
    STATEMENTS,
    Limits,
    Surface,
    hot_convergence,
    viscosity_order,
)
from oilfilm.settings.config import Boxes, PrintedSettings, SignSettings
from oilfilm.traction.law import to_constants, to_internal
from oilfilm.units import FloatArray

Shares = dict[str, FloatArray]  # of its box where a statement holds, for each sign set

_EXPONENTS = [index for index, constant in enumerate(LAW.constants) if constant.condition]
_SETS = np.array(list(itertools.product((1, -1), repeat=len(_EXPONENTS))))  # one row per set
# The slips whose totals count come first; the others may only lower a verdict.
_SLIPS = ("curve", "figures")
_WEIGHTS = {name: statement.weight for name, statement in STATEMENTS.items()} | dict.fromkeys(
    BETWEEN_OILS, 1.0
)


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
    limits = Limits(traction_max, settings.signs.linear_r2_min, settings.signs.decline_max)
    scores = {slips: _scores(printed, slips, settings, limits) for slips in _SLIPS}
    sets, verdicts = [], []
    for oil in [oil for oil in printed if oil in oils]:
        of_oil = [scores[slips][oil] for slips in _SLIPS]
        internal = _candidates(printed[oil])
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


def _candidates(constants: FloatArray) -> FloatArray:
    """Internal constants of every sign set, shape (constants, sets); A0, B0, C0 keep theirs."""
    internal = np.tile(to_internal(LAW, constants)[:, np.newaxis], (1, len(_SETS)))
    internal[_EXPONENTS] = np.abs(internal[_EXPONENTS]) * _SETS.T
    return internal


def _scores(
    printed: Mapping[str, FloatArray], slips: str, settings: PrintedSettings, limits: Limits
) -> dict[str, Shares]:
    """The statements' shares of each oil."""
    scores, surfaces, best = {}, {}, {}
    for oil, constants in printed.items():
        internal = _candidates(constants)
        boxes = {box: _surface(box, slips, internal, settings) for box in Boxes.model_fields}
        scores[oil] = {
            name: statement.score(boxes[statement.box], limits)
            for name, statement in STATEMENTS.items()
        }
        winner = int(np.argmax(_total(scores[oil])))
        surfaces[oil] = boxes["extrapolated"]
        best[oil] = _surface("extrapolated", slips, internal[:, [winner]], settings)
    # the others as their own statements choose them: the signs in use must not vouch for each other
    for index, oil in enumerate(printed):
        others = list(best.values())
        before, after = others[:index], others[index + 1 :]
        scores[oil]["viscosity_order"] = viscosity_order(surfaces[oil], before, after)
        scores[oil]["hot_convergence"] = hot_convergence(surfaces[oil], before + after)
    return scores


def _surface(box: str, slips: str, internal: FloatArray, settings: PrintedSettings) -> Surface:
    levels = settings.boxes.model_dump()[box]
    ratios = settings.signs.slide_roll_ratio
    slip = getattr(ratios, slips)
    return Surface.over(levels, settings.signs.levels, slip, ratios.figures, internal)


def _total(shares: Shares, without: str = "") -> FloatArray:
    """Number of statements that hold, those that cannot be asked not counted."""
    weighted = [_WEIGHTS[name] * share for name, share in shares.items() if name != without]
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
            "weakest_without": weakest.str[0].astype("str"),
            "weakest_slips": weakest.str[1].astype("str"),
            "near_best_share": [own[sets["near_best"]].mean() for own in has],
            "effect": effects,
            "least_sse": [sets["sse"][own].min(skipna=False) for own in has],
            "least_sse_turned": [sets["sse"][~own].min(skipna=False) for own in has],
        }
    )
    near_best, no_effect = limits.near_best, limits.no_effect_max
    sure = zip(frame["margin"], frame["weakest_margin"], frame["effect"], strict=True)
    return frame.assign(verdict=[verdict(*row, near_best, no_effect) for row in sure])


def verdict(
    margin: float, weakest: float, effect: float, near_best: float, no_effect_max: float
) -> str:
    """How sure a sign in use is.

    Without effect: turning it alone moves mu by `no_effect_max` of its largest value at most.
    Settled: all sets within `near_best` statements of the best have the sign, whichever one
    statement is left out and at either slips. Probable: all of them have it at the slips of the
    whole curve, with every statement.
    Against: all of them have the other one. Open: both signs are among them.

    Args:
        margin: In statements (see the module).
        weakest: The smallest margin with any one statement left out, at either slips.
        effect: Largest change of mu over its largest value.
        near_best: Statements behind the best that still count as near it.
        no_effect_max: Largest effect that counts as none.
    """
    if effect <= no_effect_max:
        return "without effect"
    if weakest >= near_best:
        return "settled"
    if margin >= near_best:
        return "probable"
    return "against" if margin <= -near_best else "open"
