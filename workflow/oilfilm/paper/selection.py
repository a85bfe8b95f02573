"""The paper's advice on which oil to choose, over the operating map, beside the best by numbers.

The rules (`selection` of the settings) are the paper's sentences in an order of ours: the
first whose conditions are met decides. Of the oils that it prefers the first one with enough film
is taken. The best oil is the one that meets the rule's aim best, most traction or least heat (mu
at the same load, speed and slip), among the oils with enough film.

The rules name cage slip and bearing speed: `selection.reading` says which slide-roll ratio
and which entrainment speed these are.

Decides: which oil the paper advises at an operating point.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.errors import OilfilmError
from oilfilm.paper.audit.evidence import Evidence
from oilfilm.settings.config import SelectionSettings
from oilfilm.torque.best_oil import IntArray, enough_film
from oilfilm.torque.operating_grid import Grid, traction
from oilfilm.units import BoolArray, FloatArray

# The judgement where the choice depends on a film beyond the range of the thermal reduction.
OUTSIDE = "outside the film formula"


def select(
    bases: Sequence[Evidence], settings: SelectionSettings, box: Mapping[str, Sequence[float]]
) -> pd.DataFrame:
    """Table of selection: one row per basis and operating point of the map.

    A basis without the law or the film of an oil that the rules name has no rows.

    Args:
        bases: Laws and films.
        settings: `selection` of the settings.
        box: Lowest and highest of each condition.

    Raises:
        OilfilmError: No rule applies to an operating point of the map.
    """
    named = {oil for rule in settings.rules for oil in rule.prefer}
    maps = [
        _map(evidence, settings, box)
        for evidence in bases
        if named <= set(evidence.laws) & set(evidence.films)
    ]
    return pd.concat(maps, ignore_index=True) if maps else tables.empty("selection")


def _map(
    evidence: Evidence, settings: SelectionSettings, box: Mapping[str, Sequence[float]]
) -> pd.DataFrame:
    # an oil that no rule names is no choice
    named = {oil for rule in settings.rules for oil in rule.prefer}
    oils = [oil for oil in evidence.laws if oil in named]
    grid = Grid.spanning(box, settings.map.levels, settings.map.slide_roll_ratio).at(
        inlet_temperature_c=settings.map.inlet_temperature_c
    )
    mu = np.stack([traction(evidence.laws[oil], grid).ravel() for oil in oils])
    film = np.stack([evidence.films[oil].over(grid)[1].ravel() for oil in oils])
    points = grid.operating_points()
    enough, perhaps = enough_film(film, evidence.lambda_limit)
    rule, advised, contradicting = decide(points, settings, oils, enough)
    most = np.array([rule.aim == "most traction" for rule in settings.rules])[rule]
    merit = np.where(most, mu, -mu)
    best = _best(merit, enough)
    outside = decide(points, settings, oils, perhaps).oil != advised
    outside |= _best(merit, perhaps) != best
    # by how much the advised oil misses the aim
    ratio = of_oil(mu, advised) / of_oil(mu, best)
    loss = np.where(most, 1 - ratio, ratio - 1)
    names = np.array([*oils, ""])
    judgement = np.select(
        [outside, (advised < 0) & (best < 0), advised < 0, loss <= settings.indifference],
        [OUTSIDE, "no film", "rule has none", "agree"],
        "disagree",
    )
    frame = points.assign(
        basis=evidence.basis,
        cage_slip=settings.cage_slip(points["slide_roll_ratio"].to_numpy()),
        selection_rule=np.array([rule.name for rule in settings.rules])[rule],
        aim=np.where(most, "most traction", "least heat"),
        advised_oil=names[advised],
        contradicting_rules=contradicting,
        best_oil=names[best],
        judgement=judgement,
        loss_ratio=loss,
        advised_lambda_ratio=of_oil(film, advised),
        best_lambda_ratio=of_oil(film, best),
        advised_traction_coefficient=of_oil(mu, advised),
        best_traction_coefficient=of_oil(mu, best),
    )
    return tables.conform(frame[tables.columns("selection")], "selection", "selection")


def _best(merit: FloatArray, enough: BoolArray) -> IntArray:
    """Index of the oil with the largest merit of those with enough film; -1 without one."""
    best = np.where(enough, merit, -np.inf).argmax(axis=0)
    return np.where(enough.any(axis=0), best, -1)


class Decisions(NamedTuple):
    """What the rules decide at operating points; one value per point.

    Attributes:
        rule: Index of the first rule that applies.
        oil: Index of the oil that it advises, -1 for none.
        contradicting: Names of the rules that apply as well and advise another oil, joined by '; '.
    """

    rule: IntArray
    oil: IntArray
    contradicting: list[str]


def decide(
    points: pd.DataFrame, settings: SelectionSettings, oils: Sequence[str], enough: BoolArray
) -> Decisions:
    """The rules' decision at each operating point.

    Args:
        points: Operating points with their slide-roll ratio.
        settings: `selection` of the settings.
        oils: The oils that may be advised.
        enough: Whether an oil has enough film, shape (oils, points).

    Raises:
        OilfilmError: No rule applies to one of the points.
    """
    states = _states(points, settings)
    always = np.ones(len(points), dtype=bool)
    applies, advice = [], []
    for rule in settings.rules:
        applies.append(np.logical_and.reduce([always, *(states[name] for name in rule.when)]))
        order = np.array([oils.index(oil) for oil in rule.prefer])
        has_film = enough[order]
        advice.append(np.where(has_film.any(axis=0), order[has_film.argmax(axis=0)], -1))
    ruled = np.any(applies, axis=0)
    if not ruled.all():
        unruled = points[~ruled].select_dtypes("number").iloc[0]
        condition = ", ".join(f"{name} {value:.3g}" for name, value in unruled.items())
        raise OilfilmError(
            f"selection.rules of the configuration: no rule applies at {condition}; end the list "
            "with rules for `slipping` and for `gripping`."
        )
    deciding = np.argmax(applies, axis=0)
    advised = np.array(advice)[deciding, np.arange(len(points))]
    names = [str(rule.name) for rule in settings.rules]
    others = np.array(applies) & (np.array(advice) != advised)
    contradicting = ["; ".join(np.compress(column, names)) for column in others.T]
    return Decisions(deciding, advised, contradicting)


def _states(points: pd.DataFrame, settings: SelectionSettings) -> dict[str, BoolArray]:
    """The states of a contact that rules refer to, for every operating point."""
    limits = settings.limits
    pressure = points["max_hertz_pressure_gpa"].to_numpy()
    slipping = points["slide_roll_ratio"].to_numpy() > settings.slide_roll_ratio_limit
    return {
        "slipping": slipping,
        "gripping": ~slipping,
        "light": pressure < limits.light_below_gpa,
        "heavy": pressure >= limits.heavy_from_gpa,
        "hot": points["inlet_temperature_c"].to_numpy() >= limits.hot_from_c,
        "fast": points["entrainment_speed_m_s"].to_numpy() >= settings.fast_from_m_s,
    }


def of_oil(values: FloatArray | BoolArray, oil: IntArray) -> FloatArray:
    """Value of the chosen oil at each operating point, null where there is none.

    Args:
        values: Shape (oils, points).
        oil: Index of the oil, -1 for none; shape (points,).
    """
    return np.where(oil >= 0, values[oil, np.arange(len(oil))], np.nan)
