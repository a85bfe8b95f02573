"""Lost signs of the printed exponents: all 512 sets per oil, compared with the paper's text.

A set's total is the number of statements that hold, each counted by the share of its box where it
does. A sign is judged by its margin: the best total among the sets that have it, less the best
among those that have the other one, whatever the other eight signs are.

Decides: which signs the printed exponents may have.
"""

import itertools
from collections.abc import Collection, Mapping, Sequence
from typing import Literal

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
from oilfilm.units import BoolArray, FloatArray

Slips = Literal["curve", "figures"]

_EXPONENTS = [index for index, constant in enumerate(LAW.constants) if constant.condition]
_EXPONENT_NAMES = [LAW.constants[index].name for index in _EXPONENTS]
_SETS = np.array(list(itertools.product((1, -1), repeat=len(_EXPONENTS))))  # one row per set
_RANKED_BY: Slips = "curve"  # the slips whose totals count; the others may only lower a verdict
_WEIGHTS = {name: statement.weight for name, statement in STATEMENTS.items()} | dict.fromkeys(
    BETWEEN_OILS, 1.0
)


def study_signs(
    printed: Mapping[str, FloatArray],
    falling_viscosity: Sequence[str],
    points: pd.DataFrame,
    oils: Collection[str],
    settings: PrintedSettings,
    traction_max: float,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Score every sign set of every oil, and judge every sign in use.

    Args:
        printed: The twelve constants of each oil, with the signs in use.
        falling_viscosity: The oils, the most viscous first.
        points: Table of points of the campaign, for the sum of squared errors of each set.
        oils: The oils whose rows are given.
        settings: Boxes of conditions, slide-roll ratios and limits.
        traction_max: Largest believable mu.

    Returns:
        The tables `signs` and `sign_verdicts`.
    """
    limits = Limits(traction_max, settings.signs.linear_r2_min, settings.signs.decline_max)
    by_slips = {
        slips: _scores(printed, falling_viscosity, slips, settings, limits)
        for slips in ("curve", "figures")
    }
    sets, verdicts = [], []
    for oil in [oil for oil in falling_viscosity if oil in oils]:
        internal = _candidates(printed[oil])
        constants = np.array([to_constants(LAW, of_set) for of_set in internal.T])
        errors = squared_errors(points[points["oil"] == oil], constants)
        in_use = (np.where(printed[oil][_EXPONENTS] < 0, -1, 1) == _SETS).all(axis=1)
        of_oil = {slips: scores[oil] for slips, scores in by_slips.items()}
        rows = _set_rows(oil, of_oil, errors, in_use, settings.signs)
        sets.append(rows.sort_values("total", ascending=False, kind="stable"))
        effects = _effects(internal[:, in_use], settings)
        verdicts.append(_verdict_rows(rows, of_oil, effects, settings.signs))
    if not sets:
        return tables.empty("signs"), tables.empty("sign_verdicts")
    return (
        tables.conform(pd.concat(sets, ignore_index=True), "signs", "sign sets"),
        tables.conform(pd.concat(verdicts, ignore_index=True), "sign_verdicts", "signs"),
    )


def _candidates(constants: FloatArray) -> FloatArray:
    """Internal constants of every sign set, shape (constants, sets); A0, B0, C0 keep theirs."""
    internal = np.tile(to_internal(LAW, constants)[:, np.newaxis], (1, len(_SETS)))
    internal[_EXPONENTS] = np.abs(internal[_EXPONENTS]) * _SETS.T
    return internal


def _scores(
    printed: Mapping[str, FloatArray],
    falling_viscosity: Sequence[str],
    slips: Slips,
    settings: PrintedSettings,
    limits: Limits,
) -> dict[str, dict[str, FloatArray]]:
    """Oil -> statement -> share of its box where it holds, for each sign set."""
    scores, surfaces, best = {}, {}, {}
    for oil in falling_viscosity:
        internal = _candidates(printed[oil])
        boxes = {box: _surface(box, slips, internal, settings) for box in Boxes.model_fields}
        scores[oil] = {
            name: statement.score(boxes[statement.box], limits)
            for name, statement in STATEMENTS.items()
        }
        winner = int(np.argmax(_total(scores[oil])))
        surfaces[oil] = boxes["extrapolated"]
        best[oil] = _surface("extrapolated", slips, internal[:, [winner]], settings)
    # the others as their own statements choose them: the signs in use must not vouch for each other
    for index, oil in enumerate(falling_viscosity):
        before = [best[other] for other in falling_viscosity[:index]]
        after = [best[other] for other in falling_viscosity[index + 1 :]]
        scores[oil]["viscosity_order"] = viscosity_order(surfaces[oil], before, after)
        scores[oil]["hot_convergence"] = hot_convergence(surfaces[oil], before + after)
    return scores


def _surface(box: str, slips: Slips, internal: FloatArray, settings: PrintedSettings) -> Surface:
    levels: dict[str, list[float]] = getattr(settings.boxes, box).model_dump()
    ratios = settings.signs.slide_roll_ratio
    chosen = ratios.curve if slips == "curve" else ratios.figures
    return Surface.over(levels, settings.signs.levels, chosen, ratios.figures, internal)


def _total(scores: Mapping[str, FloatArray], without: str = "") -> FloatArray:
    """Number of statements that hold, those that cannot be asked not counted."""
    weighted = [_WEIGHTS[name] * score for name, score in scores.items() if name != without]
    return np.nansum(weighted, axis=0)


def _effects(in_use: FloatArray, settings: PrintedSettings) -> FloatArray:
    """Largest change of mu over the tested box if one sign alone is turned, over the largest mu."""
    turned = np.tile(in_use, (1, 1 + len(_EXPONENTS)))
    turned[_EXPONENTS, range(1, turned.shape[1])] *= -1
    mu = _surface("tested", _RANKED_BY, turned, settings).mu.reshape(-1, turned.shape[1])
    return np.abs(mu[:, 1:] - mu[:, :1]).max(axis=0) / mu[:, 0].max()


def _set_rows(
    oil: str,
    by_slips: Mapping[str, Mapping[str, FloatArray]],
    errors: FloatArray,
    in_use: BoolArray,
    limits: SignSettings,
) -> pd.DataFrame:
    totals = {slips: pd.Series(_total(scores)) for slips, scores in by_slips.items()}
    total = totals[_RANKED_BY]
    ranks = {
        slips: total.rank(method="min", ascending=False).astype(int)
        for slips, total in totals.items()
    }
    return pd.DataFrame(
        {
            "oil": oil,
            "signs": ["".join("+" if sign > 0 else "-" for sign in signs) for signs in _SETS],
            "in_use": in_use,
            "rank": ranks[_RANKED_BY],
            "rank_at_figures": ranks["figures"],
            "total": total,
            "near_best": total > total.max() - limits.near_best,
            **by_slips[_RANKED_BY],
            "sse": errors,
        }
    )


def _verdict_rows(
    sets: pd.DataFrame,
    by_slips: Mapping[str, Mapping[str, FloatArray]],
    effects: FloatArray,
    limits: SignSettings,
) -> pd.DataFrame:
    total, near, errors = (sets[name].to_numpy() for name in ("total", "near_best", "sse"))
    signs = _SETS[sets["in_use"]][0]
    rows = []
    for column, constant in enumerate(_EXPONENT_NAMES):
        has = _SETS[:, column] == signs[column]
        without = {
            (name, slips): _margin(_total(scores, without=name), has)
            for slips, scores in by_slips.items()
            for name in scores
        }
        weakest = min(without, key=lambda case: without[case])
        margin, effect = _margin(total, has), effects[column]
        rows.append(
            {
                "oil": sets["oil"].iloc[0],
                "constant": constant,
                "sign": "+" if signs[column] > 0 else "-",
                "margin": margin,
                "weakest_margin": without[weakest],
                "weakest_without": weakest[0],
                "weakest_slips": weakest[1],
                "near_best_share": has[near].mean(),
                "effect": effect,
                "least_sse": errors[has].min(),
                "least_sse_turned": errors[~has].min(),
                "verdict": verdict(
                    margin, without[weakest], effect, limits.near_best, limits.no_effect_max
                ),
            }
        )
    return pd.DataFrame(rows)


def _margin(total: FloatArray, has: BoolArray) -> float:
    return float(total[has].max() - total[~has].max())


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
