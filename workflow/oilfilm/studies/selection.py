"""The paper's advice on which oil to choose, over the operating map, beside what the numbers say.

The rules (`selection` of the settings) are the paper's sentences in an order of ours: the
first whose conditions are met decides. Of the oils that it prefers the first one with enough film
is taken. The numbers are asked for what the rule is after, the most traction or the least heat
(mu at the same load, speed and slip), among the oils with enough film.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pandas as pd

from oilfilm import tables
from oilfilm.errors import OilfilmError
from oilfilm.settings.config import SelectionLimits, SelectionRule, SelectionSettings
from oilfilm.studies.audit.evidence import Evidence
from oilfilm.studies.operating_grid import Grid, traction
from oilfilm.units import FloatArray

BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]


def states(places: pd.DataFrame, limits: SelectionLimits) -> dict[str, BoolArray]:
    """What a rule may ask of a contact, for every place."""
    pressure = places["max_hertz_pressure_gpa"].to_numpy()
    slipping = places["slide_roll_ratio"].to_numpy() > limits.slip_limit
    return {
        "slipping": slipping,
        "gripping": ~slipping,
        "light": pressure < limits.light_below_gpa,
        "heavy": pressure >= limits.heavy_from_gpa,
        "hot": places["inlet_temperature_c"].to_numpy() >= limits.hot_from_c,
        "fast": places["entrainment_speed_m_s"].to_numpy() >= limits.fast_from_m_s,
    }


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
        OilfilmError: No rule applies to a place of the map.
    """
    wanted = {oil for rule in settings.rules for oil in rule.prefer}
    maps = [
        _map(evidence, settings, box)
        for evidence in bases
        if wanted <= set(evidence.laws) & set(evidence.films)
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
    places = grid.places()
    enough = film > evidence.lambda_limit
    said = Sayings(settings.rules, oils, states(places, settings.limits), enough)
    deciding = said.deciding(places)
    advised = said.advice[deciding, np.arange(len(places))]
    most = np.array([rule.aim == "most traction" for rule in settings.rules])[deciding]
    best = _best(mu, enough, most)
    loss = _loss(mu, advised, best, most)
    names = np.array([*oils, ""])
    judgement = np.select(
        [(advised < 0) & (best < 0), advised < 0, loss <= settings.indifference],
        ["no film", "rule has none", "agree"],
        "disagree",
    )
    frame = places.assign(
        basis=evidence.basis,
        selection_rule=np.array([rule.name for rule in settings.rules])[deciding],
        aim=np.where(most, "most traction", "least heat"),
        advised_oil=names[advised],
        contradicting_rules=said.contradicting(deciding),
        best_oil=names[best],
        judgement=judgement,
        loss_ratio=loss,
        advised_lambda_ratio=_of(film, advised),
        best_lambda_ratio=_of(film, best),
        advised_traction_coefficient=_of(mu, advised),
        best_traction_coefficient=_of(mu, best),
    )
    return tables.conform(frame[tables.columns("selection")], "selection", "selection")


@dataclass(frozen=True)
class Sayings:
    """What each rule says at each place.

    Attributes:
        rules: As in `selection` of the settings.
        oils: The oils that may be advised.
        states: What a rule may ask, for every place.
        enough: Whether an oil has enough film, shape (oils, places).
    """

    rules: Sequence[SelectionRule]
    oils: Sequence[str]
    states: Mapping[str, BoolArray]
    enough: BoolArray

    @property
    def applies(self) -> BoolArray:
        """Shape (rules, places)."""
        always = np.ones(self.enough.shape[1], dtype=bool)
        return np.array(
            [
                np.logical_and.reduce([always, *(self.states[name] for name in rule.when)])
                for rule in self.rules
            ]
        )

    def deciding(self, places: pd.DataFrame) -> IntArray:
        """Place of the first rule that applies, shape (places,).

        Raises:
            OilfilmError: None applies to one of these places.
        """
        ruled = self.applies.any(axis=0)
        if not ruled.all():
            unruled = places[~ruled].select_dtypes("number").iloc[0]
            where = ", ".join(f"{name} {value:.3g}" for name, value in unruled.items())
            raise OilfilmError(
                f"selection.rules of the configuration: no rule applies at {where}; end the list "
                "with rules for `slipping` and for `gripping`."
            )
        return self.applies.argmax(axis=0)

    @property
    def advice(self) -> IntArray:
        """Place of the advised oil among the oils, -1 for none: shape (rules, places)."""
        advice = []
        for rule in self.rules:
            order = np.array([self.oils.index(oil) for oil in rule.prefer])
            has_film = self.enough[order]
            advice.append(np.where(has_film.any(axis=0), order[has_film.argmax(axis=0)], -1))
        return np.array(advice)

    def contradicting(self, deciding: IntArray) -> list[str]:
        """Names of the rules that apply as well and advise another oil, joined by '; '."""
        advice = self.advice
        other = self.applies & (advice != advice[deciding, np.arange(advice.shape[1])])
        names = [str(rule.name) for rule in self.rules]
        return ["; ".join(np.compress(column, names)) for column in other.T]


def _best(mu: FloatArray, enough: BoolArray, most: BoolArray) -> IntArray:
    """Oil with the most or the least mu among those with enough film, -1 for none."""
    merit = np.where(enough, np.where(most, mu, -mu), -np.inf)
    return np.where(enough.any(axis=0), merit.argmax(axis=0), -1)


def _loss(mu: FloatArray, advised: IntArray, best: IntArray, most: BoolArray) -> FloatArray:
    """By how much the advised oil misses the aim, relative to the best one."""
    ratio = _of(mu, advised) / _of(mu, best)
    return np.where(most, 1 - ratio, ratio - 1)


def _of(values: FloatArray, oil: IntArray) -> FloatArray:
    """Value of the chosen oil at each place, null where there is none."""
    return np.where(oil >= 0, values[oil, np.arange(len(oil))], np.nan)
