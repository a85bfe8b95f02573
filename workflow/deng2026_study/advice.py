"""The paper's advice on which oil to choose, beside the best oil of a bearing by cage slip.

The paper chooses oils by cage slip. Up to a limit of slip it takes the oil with the least heat,
above the limit an oil with more traction. Where the friction equilibrium gives the slip with each
oil, the choice follows from it alone (`oilfilm.torque.best_oil`).

The paper's rules (`selection` of the study's settings) are its sentences in the order of its
conclusion. The first rule whose conditions are met decides. Of the oils that it prefers, the first
one with enough film is advised. The rules are applied in two steps:

1. The rules advise an oil for a cage that does not slip.
2. If the cage slips with that oil, they are applied again with that slip.

The paper states neither an order of its rules nor a number for "hot" and "fast". So the result is a
band over scenarios: the rules in each order, each limit times some factors, at each supply
temperature. In a simulated campaign the true traction has a band of its own. `best_share` of the
table of cage slip says how sure the best oil itself is.

Decides: which oil the paper advises at an operating point, and how firm that is.
"""

import itertools
from collections.abc import Iterator, Mapping, Sequence
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
from oilfilm.torque.bearing_torque import CaseGroup, Cases, OilInBearing, joined
from oilfilm.torque.best_oil import IntArray, best_of, by_oil, enough_film, operating_points
from simulated_lab.true_bearing import true_map

# The judgement where the choice depends on a film beyond the range of the thermal reduction.
OUTSIDE = "outside the film formula"
# The judgement where an oil that may be the best one has no equilibrium.
NO_EQUILIBRIUM = "no equilibrium"
# Without a choice there is nothing that scenarios could disagree about.
NO_CHOICE = ("no film", OUTSIDE, NO_EQUILIBRIUM)
# Oils, operating points, and arrays of shape (oils, points): cage slip, torque in N m, lambda.
SlipMap = tuple[list[str], pd.DataFrame, FloatArray, FloatArray, FloatArray]
# An oil stays the best one if it is the best in this share of the draws.
STAYS_BEST_SHARE = 0.95
# The traction behind a band: the fitted law, or the truth of a simulated campaign.
BY_LAW, BY_TRUTH = "law", "truth"
# What is chosen at every operating point: the oil that the rules advise, or one oil.
BY_RULES = "rules"
# Columns that identify a scenario of the rules.
_SCENARIO = ["rule_order", "varied_limit", "limit_factor"]


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
    selection = study_settings(settings).selection
    lambda_limit = settings.gates.lambda_limit
    nominal = advise(results.cage_slip, selection, lambda_limit)
    if nominal.empty:
        return {"slip_advice": nominal, "advice_band": tables.empty("advice_band")}
    cage_slip = _slip_at_band_temperatures(oils, results.cage_slip, settings)
    return {"slip_advice": nominal, "advice_band": _band(cage_slip, settings, BY_LAW)}


def _band(cage_slip: pd.DataFrame, settings: Settings, traction: str) -> pd.DataFrame:
    """Table `advice_band`: how often the advice of each scenario is good.

    Args:
        cage_slip: Table of cage slip at all temperatures of the band.
        settings: `gates` and `studies`.
        traction: `BY_LAW` or `BY_TRUTH`: the traction behind the table of cage slip.
    """
    selection = study_settings(settings).selection
    slip_map = _slip_map(cage_slip, selection)
    choices = [
        _choices(slip_map, changed, settings.gates.lambda_limit).assign(**scenario)
        for scenario, changed in _scenarios(selection)
    ]
    judged = pd.concat(choices)
    judged = judged[~judged["judgement"].isin(NO_CHOICE)]
    judged[BY_RULES] = judged["judgement"] == "agree"
    keys = ["bearing", *_SCENARIO, "inlet_temperature_c"]
    band = judged.melt(keys, [BY_RULES, *_oils_of_rules(selection)], "choice", "agrees")
    counts = band.groupby([*keys, "choice"], sort=False)["agrees"]
    band = counts.agg(operating_points="size", agreeing_points="sum").reset_index()
    return joined([band.assign(traction=traction)], "advice_band")


def advice_by_truth(
    advice: pd.DataFrame,
    band: pd.DataFrame,
    results: CampaignTables,
    settings: Settings,
    constants: Mapping[str, FloatArray],
) -> dict[str, pd.DataFrame]:
    """The advice with its judgement by the true traction, the map and the band of that traction.

    Args:
        advice: Table of advice by the fitted law.
        band: Its band.
        results: Table of cage slip.
        settings: The settings.
        constants: The printed constants of each oil.

    Returns:
        The tables `slip_advice`, `advice_band` and `true_cage_slip`. If mu was measured, the last
        one is empty and the others are those by the law.
    """
    if settings.campaign.twin is None or advice.empty:
        return {
            "slip_advice": advice,
            "advice_band": band,
            "true_cage_slip": tables.empty("true_cage_slip"),
        }
    truth = true_map(results.cage_slip, settings, constants)
    at_band_temperatures = [truth]
    for temperature in _missing_temperatures(results.cage_slip, settings):
        points = results.cage_slip.assign(inlet_temperature_c=temperature)
        at_band_temperatures.append(true_map(points, settings, constants))
    band_of_truth = _band(pd.concat(at_band_temperatures), settings, BY_TRUTH)
    judged = advise(truth, study_settings(settings).selection, settings.gates.lambda_limit)
    keys = ["bearing", "inlet_temperature_c", "pitch_speed_mm_rpm", "axial_load_n"]
    of_truth = judged[[*keys, "best_oil", "judgement"]].rename(
        columns={"best_oil": "true_best_oil", "judgement": "true_judgement"}
    )
    of_law = advice.drop(columns=["true_best_oil", "true_judgement"])
    with_truth = of_law.merge(of_truth, on=keys, how="left")
    return {
        "slip_advice": joined([with_truth], "slip_advice"),
        "advice_band": joined([band, band_of_truth], "advice_band"),
        "true_cage_slip": joined([truth], "true_cage_slip"),
    }


def _slip_at_band_temperatures(
    oils: Sequence[OilInBearing], cage_slip: pd.DataFrame, settings: Settings
) -> pd.DataFrame:
    """Table of cage slip, with rows for the supply temperatures of the band that it lacks."""
    points = operating_points(cage_slip).drop(columns="bearing")
    groups = [
        CaseGroup(oil, "stress", points.assign(inlet_temperature_c=temperature))
        for temperature in _missing_temperatures(cage_slip, settings)
        for oil in oils
    ]
    if not groups:
        return cage_slip
    calculated = Cases(settings.tested_bearing(), groups).run()
    return pd.concat([cage_slip, calculated], ignore_index=True)


def _missing_temperatures(cage_slip: pd.DataFrame, settings: Settings) -> list[float]:
    """Supply temperatures of the band that the table of cage slip lacks."""
    band_temperatures = set(study_settings(settings).selection.band.inlet_temperature_c)
    return sorted(band_temperatures - set(cage_slip["inlet_temperature_c"]))


def _oils_of_rules(selection: SelectionSettings) -> list[str]:
    """The oils that the rules name, each once, in the order of the rules."""
    return list(dict.fromkeys(oil for rule in selection.rules for oil in rule.prefer))


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
    if not set(_oils_of_rules(settings)) <= set(cage_slip["oil"]):
        return tables.empty("slip_advice")
    frame = _choices(_slip_map(cage_slip, settings), settings, lambda_limit)
    return joined([frame], "slip_advice")


def _slip_map(cage_slip: pd.DataFrame, settings: SelectionSettings) -> SlipMap:
    """Motion of a bearing with each oil of the rules."""
    oils_of_rules = _oils_of_rules(settings)
    oils = [oil for oil in dict.fromkeys(cage_slip["oil"]) if oil in oils_of_rules]
    slip, torque, film, inner_pressure, outer_pressure = by_oil(
        cage_slip,
        oils,
        "cage_slip",
        "torque_n_m",
        "lambda_ratio",
        "inner_max_hertz_pressure_gpa",
        "outer_max_hertz_pressure_gpa",
    )
    points = operating_points(cage_slip)
    pressures = np.concatenate([inner_pressure, outer_pressure])
    points["max_hertz_pressure_gpa"] = np.fmax.reduce(pressures)
    return oils, points, slip, torque, film


def _choices(slip_map: SlipMap, settings: SelectionSettings, lambda_limit: float) -> pd.DataFrame:
    """The advice and the best oil at each operating point of each scenario.

    Returns:
        Most columns of the table of advice, those of the scenario, and for each oil of the rules
        by its name whether it is as good as the best one.

    Raises:
        OilfilmError: No rule applies to an operating point.
    """
    oils, points, slip, torque, film = slip_map
    slip_limit = settings.limits.slip_limit
    enough, perhaps_enough = enough_film(film, lambda_limit)
    within_limit = enough & reaches(slip_limit, slip)
    choice = best_of(slip, torque, film, slip_limit, lambda_limit)
    best = choice.oil
    deciding, advised = _by_rules(points, slip, oils, settings, enough)
    _, perhaps_advised = _by_rules(points, slip, oils, settings, perhaps_enough)
    film_unknown = (perhaps_advised != advised) | choice.lacks_film
    # an oil is as good as the best one: by torque where the best oil holds the cage, else by slip
    best_slip = _of_oil(slip, best)
    best_holds = reaches(slip_limit, best_slip)
    ratio = np.where(best_holds, torque / _of_oil(torque, best), slip / best_slip)
    as_good = reaches(1 + settings.indifference, ratio)
    good = enough & (within_limit | ~best_holds) & as_good
    # the first condition that is met gives the judgement
    conditions = {
        NO_EQUILIBRIUM: choice.lacks_equilibrium,
        OUTSIDE: film_unknown,
        "no film": best < 0,
        "rule has none": advised < 0,
        "agree": _of_oil(good, advised) == 1,
        "slips more": ~best_holds,
        "heats more": _of_oil(within_limit, advised) == 1,
    }
    judgement = np.select(list(conditions.values()), list(conditions), "slips")
    names = np.array([*oils, ""])
    rule_names = np.array([rule.name for rule in settings.rules])
    return points.assign(
        oils_within_limit=tables.lists(_names_of(within_limit, oils), points.index),
        selection_rule=rule_names[deciding],
        advised_oil=names[advised],
        best_oil=names[best],
        good_oils=tables.lists(_names_of(good, oils), points.index),
        judgement=judgement,
        true_best_oil="",
        true_judgement="",
        **dict(zip(oils, good, strict=True)),
    )


def _names_of(chosen: BoolArray, oils: Sequence[str]) -> list[tuple[str, ...]]:
    """Names of the oils that are chosen at each operating point.

    Args:
        chosen: Whether an oil is chosen, shape (oils, points).
        oils: Their names.
    """
    return [tuple(itertools.compress(oils, chosen_at_point)) for chosen_at_point in chosen.T]


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
        slip: Their cage slip, shape (points,).
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
    applies = np.array(
        [np.all([states[name] for name in rule.when], axis=0) for rule in settings.rules]
    )
    without_rule = ~applies.any(axis=0)
    if without_rule.any():
        first = levels.assign(cage_slip=slip)[without_rule].iloc[0]
        condition = ", ".join(f"{name} {level:.3g}" for name, level in first.items())
        raise OilfilmError(
            f"selection.rules of the study's settings: no rule applies at {condition}; end the "
            "list with rules for `slipping` and for `gripping`."
        )
    advice = []
    for rule in settings.rules:
        preferred = np.array([oils.index(oil) for oil in rule.prefer])
        first_enough = preferred[enough[preferred].argmax(axis=0)]
        advice.append(np.where(enough[preferred].any(axis=0), first_enough, -1))
    deciding = np.argmax(applies, axis=0)
    return deciding, np.array(advice)[deciding, np.arange(len(slip))]


def _by_rules(
    points: pd.DataFrame,
    slip: FloatArray,
    oils: Sequence[str],
    settings: SelectionSettings,
    enough: BoolArray,
) -> tuple[IntArray, IntArray]:
    """At each point the rule that decides, and the oil it advises.

    Args:
        points: As for `decide`.
        slip: Cage slip, shape (oils, points).
        oils: The oils that may be advised.
        settings: `selection` of the study's settings.
        enough: As for `decide`.
    """
    slip_limit = settings.limits.slip_limit
    numbers = np.arange(len(points))
    _, without_slip = decide(points, np.zeros(len(points)), settings, oils, enough)
    slip_with_it = np.where(without_slip >= 0, slip[without_slip, numbers], 0.0)
    deciding, advised = decide(points, slip_with_it, settings, oils, enough)
    # "4050 is recommended, and if necessary, lubricant 4102": necessary while the cage still slips
    still_slips = (advised >= 0) & ~reaches(slip_limit, slip[advised, numbers])
    for point in numbers[still_slips]:
        preferred = [oils.index(oil) for oil in settings.rules[deciding[point]].prefer]
        with_film = [oil for oil in preferred if enough[oil, point]]
        holding = [oil for oil in with_film if reaches(slip_limit, slip[oil, point])]
        advised[point] = holding[0] if holding else with_film[-1]
    return deciding, advised


def _of_oil(values: FloatArray | BoolArray, oil: IntArray) -> FloatArray:
    """Value of the chosen oil at each operating point, null where there is none."""
    return np.where(oil >= 0, values[oil, np.arange(len(oil))], np.nan)


def _scenarios(selection: SelectionSettings) -> Iterator[tuple[dict[str, Any], SelectionSettings]]:
    """The rules as set, in each order, and in each order with one limit after the other changed."""
    rule_by_name = {rule.name: rule for rule in selection.rules}
    orders = {"as set": list(rule_by_name)}
    orders.update(selection.band.rule_orders)
    limits = [("", 1.0)]
    limits.extend(itertools.product(SelectionLimits.model_fields, selection.band.limit_factors))
    for order, rule_names in orders.items():
        for limit, factor in limits:
            changed = {}
            if limit:
                changed[limit] = factor * getattr(selection.limits, limit)
            changed_selection = selection.model_copy(
                update={
                    "rules": [rule_by_name[name] for name in rule_names],
                    "limits": selection.limits.model_copy(update=changed),
                }
            )
            scenario = {"rule_order": order, "varied_limit": limit, "limit_factor": factor}
            yield scenario, changed_selection
