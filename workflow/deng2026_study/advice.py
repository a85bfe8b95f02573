"""The paper's advice on which oil to choose, beside the best oil of a bearing by cage slip.

The paper chooses oils by cage slip: up to a limit the one with the least heat, beyond it one with
more traction. Where the friction equilibrium gives the slip with each oil, the choice follows from
it alone (`oilfilm.torque.best_oil`). The paper's rules (`selection` of the study's settings) are
its sentences in the order of its conclusion: the first whose conditions are met decides, and of the
oils that it prefers the first one with enough film is taken. They are applied as an engineer would:
which oil they advise where nothing slips, whether the cage slips with that oil, and if so which one
then.

The paper states neither an order of its rules nor a number for "hot" and "fast". So the result is a
band over scenarios: the rules in each order, each limit times some factors, at each supply
temperature. How sure the best oil itself is, is `best_share` of the table of cage slip.

Decides: which oil the paper advises at an operating point, and how firm that is.
"""

import itertools
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd

from deng2026_study.settings import SelectionLimits, SelectionSettings, study_settings
from oilfilm import tables
from oilfilm.base.errors import OilfilmError
from oilfilm.base.ties import exceeds, reaches
from oilfilm.base.units import BoolArray, FloatArray
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.bearing_torque import Cases, OilInBearing, joined
from oilfilm.torque.best_oil import IntArray, best_of, by_oil, enough_film, operating_points

# The judgement where the choice depends on a film beyond the range of the thermal reduction.
OUTSIDE = "outside the film formula"
# The judgement where an oil that may be the best one has no equilibrium.
NO_EQUILIBRIUM = "no equilibrium"
# Without a choice there is nothing that scenarios could disagree about.
NO_CHOICE = ("no film", OUTSIDE, NO_EQUILIBRIUM)
# Oils, operating points, and arrays of shape (oils, points): cage slip, torque in N m, lambda.
SlipMap = tuple[list[str], pd.DataFrame, FloatArray, FloatArray, FloatArray]
# What is chosen at every operating point: the oil that the rules advise, or one oil.
BY_RULES = "rules"
# Columns that tell apart how the rules are read.
_READING = ["rule_order", "varied_limit", "limit_factor"]


def advice_in_band(
    oils: Sequence[OilInBearing], results: CampaignTables, settings: Settings
) -> dict[str, pd.DataFrame]:
    """The advice at each operating point, and how often each scenario's advice is good.

    Args:
        oils: Oils with their laws.
        results: Table of cage slip, the nominal scenario.
        settings: `bearing`, `gates` and `studies`, and the campaign's bearing.

    Returns:
        The tables `slip_advice` and `advice_band`; empty where the rules name an oil that has no
        law.
    """
    choice = study_settings(settings).selection
    lambda_limit = settings.gates.lambda_limit
    nominal = advise(results.cage_slip, choice, lambda_limit)
    if nominal.empty:
        return {"slip_advice": nominal, "advice_band": tables.empty("advice_band")}
    points = operating_points(results.cage_slip).drop(columns="bearing")
    others = set(choice.band.inlet_temperature_c) - set(points["inlet_temperature_c"])
    groups = [
        (oil, "stress", points.assign(inlet_temperature_c=temperature))
        for temperature in sorted(others)
        for oil in oils
    ]
    slips = [results.cage_slip]
    if groups:
        slips.append(Cases(settings.tested_bearing(), groups).run())
    at = _slip_map(pd.concat(slips, ignore_index=True), choice)
    made = [
        _choices(at, rules, lambda_limit).assign(**reading) for reading, rules in _readings(choice)
    ]
    judged = pd.concat(made)
    judged = judged[~judged["judgement"].isin(NO_CHOICE)]
    judged[BY_RULES] = judged["judgement"] == "agree"
    chosen = [BY_RULES, *dict.fromkeys(oil for rule in choice.rules for oil in rule.prefer)]
    keys = ["bearing", *_READING, "inlet_temperature_c"]
    band = judged.melt(keys, chosen, "choice", "agrees")
    counts = band.groupby([*keys, "choice"], sort=False)["agrees"]
    band = counts.agg(operating_points="size", agreeing_points="sum").reset_index()
    return {"slip_advice": nominal, "advice_band": joined([band], "advice_band")}


def advise(
    cage_slip: pd.DataFrame, settings: SelectionSettings, lambda_limit: float
) -> pd.DataFrame:
    """Table of advice: one row per operating point of the map of cage slip.

    Args:
        cage_slip: Table of cage slip.
        settings: `selection` of the study's settings.
        lambda_limit: Full film above.

    Returns:
        The table; empty where an oil that the rules name was not calculated.

    Raises:
        OilfilmError: No rule applies to an operating point.
    """
    if not {oil for rule in settings.rules for oil in rule.prefer} <= set(cage_slip["oil"]):
        return tables.empty("slip_advice")
    frame = _choices(_slip_map(cage_slip, settings), settings, lambda_limit)
    return joined([frame], "slip_advice")


def _slip_map(cage_slip: pd.DataFrame, settings: SelectionSettings) -> SlipMap:
    """Motion of a bearing with each oil of the rules."""
    named = {oil for rule in settings.rules for oil in rule.prefer}
    oils = [oil for oil in dict.fromkeys(cage_slip["oil"]) if oil in named]
    slip, torque, film, inner, outer = by_oil(
        *(cage_slip, oils, "cage_slip", "torque_n_m", "lambda_ratio"),
        *("inner_max_hertz_pressure_gpa", "outer_max_hertz_pressure_gpa"),
    )
    points = operating_points(cage_slip)
    points["max_hertz_pressure_gpa"] = np.fmax.reduce([*inner, *outer])
    return oils, points, slip, torque, film


def _choices(at: SlipMap, settings: SelectionSettings, lambda_limit: float) -> pd.DataFrame:
    """The advice and the best oil at each operating point of each scenario.

    Returns:
        Most columns of the table of advice, those of the scenario, and for each oil of the rules
        by its name whether it is as good as the best one.

    Raises:
        OilfilmError: No rule applies to an operating point.
    """
    oils, points, slip, torque, film = at
    limit = settings.limits.slip_limit
    enough, perhaps = enough_film(film, lambda_limit)
    within = enough & reaches(limit, slip)
    choice = best_of(slip, torque, film, limit, lambda_limit)
    best = choice.oil
    deciding, advised = _by_rules(points, slip, oils, settings, enough)
    outside = _by_rules(points, slip, oils, settings, perhaps)[1] != advised
    outside |= choice.lacks_film
    best_slip = _of_oil(slip, best)
    could = reaches(limit, best_slip)
    ratio = np.where(could, torque / _of_oil(torque, best), slip / best_slip)
    good = enough & (within | ~could) & reaches(1 + settings.indifference, ratio)
    judgement = np.select(
        [
            *(choice.lacks_equilibrium, outside, best < 0),
            *(advised < 0, _of_oil(good, advised) == 1, ~could),
        ],
        [NO_EQUILIBRIUM, OUTSIDE, "no film", "rule has none", "agree", "slips more"],
        np.where(_of_oil(within, advised) == 1, "heats more", "slips"),
    )
    names = np.array([*oils, ""])
    return points.assign(
        oils_within_limit=tables.lists(_names_of(within, oils), points.index),
        selection_rule=np.array([rule.name for rule in settings.rules])[deciding],
        advised_oil=names[advised],
        best_oil=names[best],
        good_oils=tables.lists(_names_of(good, oils), points.index),
        judgement=judgement,
        **dict(zip(oils, good, strict=True)),
    )


def _names_of(chosen: BoolArray, oils: Sequence[str]) -> list[tuple[str, ...]]:
    """Names of the oils that are chosen at each operating point.

    Args:
        chosen: Shape (oils, points).
        oils: Their names.
    """
    return [tuple(itertools.compress(oils, at_point)) for at_point in chosen.T]


def decide(
    points: pd.DataFrame,
    slip: FloatArray,
    settings: SelectionSettings,
    oils: Sequence[str],
    enough: BoolArray,
) -> tuple[IntArray, IntArray]:
    """At each operating point the first rule that applies, and the oil it advises (-1 for none).

    Args:
        points: Pressure, dmN and temperature of operating points.
        slip: Their cage slip.
        settings: `selection` of the study's settings.
        oils: The oils that may be advised.
        enough: Whether an oil has enough film, shape (oils, points).

    Raises:
        OilfilmError: No rule applies to one of the points.
    """
    limits = settings.limits
    levels = points[["max_hertz_pressure_gpa", "pitch_speed_mm_rpm", "inlet_temperature_c"]]
    pressure, speed, temperature = levels.to_numpy(dtype=float).T
    slipping = exceeds(slip, limits.slip_limit)
    states = {
        "slipping": slipping,
        "gripping": ~slipping,
        "light": exceeds(limits.light_below_gpa, pressure),
        "heavy": reaches(pressure, limits.heavy_from_gpa),
        "hot": reaches(temperature, limits.hot_from_c),
        "fast": reaches(speed, limits.fast_from_mm_rpm),
    }
    applies = np.array([np.all([states[name] for name in rule.when], 0) for rule in settings.rules])
    if not (ruled := applies.any(axis=0)).all():
        unruled = levels.assign(cage_slip=slip)[~ruled].iloc[0]
        at = ", ".join(f"{name} {level:.3g}" for name, level in unruled.items())
        raise OilfilmError(
            f"selection.rules of the study's settings: no rule applies at {at}; end the list "
            "with rules for `slipping` and for `gripping`."
        )
    orders = [np.array([oils.index(oil) for oil in rule.prefer]) for rule in settings.rules]
    advice = [
        np.where(enough[order].any(axis=0), order[enough[order].argmax(axis=0)], -1)
        for order in orders
    ]
    deciding = np.argmax(applies, axis=0)
    return deciding, np.array(advice)[deciding, np.arange(len(slip))]


def _by_rules(
    points: pd.DataFrame,
    slip: FloatArray,
    oils: Sequence[str],
    settings: SelectionSettings,
    enough: BoolArray,
) -> tuple[IntArray, IntArray]:
    """At each point the rule that decides, and the oil it advises."""
    limit, each = settings.limits.slip_limit, np.arange(len(points))
    _, start = decide(points, np.zeros(len(points)), settings, oils, enough)
    with_start = np.where(start >= 0, slip[start, each], 0.0)
    deciding, advised = decide(points, with_start, settings, oils, enough)
    # "4050 is recommended, and if necessary, lubricant 4102": necessary while the cage still slips
    for point in each[(advised >= 0) & ~reaches(limit, slip[advised, each])]:
        prefer = map(oils.index, settings.rules[deciding[point]].prefer)
        others = [oil for oil in prefer if enough[oil, point]]
        holding = [oil for oil in others if reaches(limit, slip[oil, point])]
        advised[point] = [*holding, others[-1]][0]
    return deciding, advised


def _of_oil(values: FloatArray | BoolArray, oil: IntArray) -> FloatArray:
    """Value of the chosen oil at each operating point, null where there is none."""
    return np.where(oil >= 0, values[oil, np.arange(len(oil))], np.nan)


def _readings(choice: SelectionSettings) -> Iterator[tuple[dict[str, Any], SelectionSettings]]:
    """The rules as set, in each order, and in each with one limit after the other changed."""
    by_name = {rule.name: rule for rule in choice.rules}
    orders = {"as set": list(by_name), **choice.band.rule_orders}
    factors = itertools.product(SelectionLimits.model_fields, choice.band.limit_factors)
    limits = [("", 1.0), *factors]
    for (order, names), (limit, factor) in itertools.product(orders.items(), limits):
        changed = {limit: factor * getattr(choice.limits, limit)} if limit else {}
        update = {
            "rules": [by_name[name] for name in names],
            "limits": choice.limits.model_copy(update=changed),
        }
        reading = dict(zip(_READING, (order, limit, factor), strict=True))
        yield reading, choice.model_copy(update=update)
