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

The best oil here is the best of the oils that the rules name: the advice can be no other oil. A
campaign may have further oils, one of which may be better. `best_share` compares all of them.

Decides: which oil the paper advises at an operating point, and how firm that is.
"""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from deng2026_study.settings import SelectionLimits, SelectionSettings, study_settings
from oilfilm import tables
from oilfilm.base.errors import OilfilmError
from oilfilm.base.ties import exceeds, reaches
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.bearing_torque import CaseGroup, FrictionCases, OilInBearing, stack_tables
from oilfilm.torque.best_oil import (
    NOT_KNOWN,
    OPERATING_POINT_COLUMNS,
    arrays_by_oil,
    best_oil_table,
    certain_and_possible_full_film,
    distinct_operating_points,
    find_best_oil,
)
from simulated_lab.true_bearing import true_cage_slip_map

# The judgement where the choice depends on a film beyond the range of the thermal reduction.
OUTSIDE_FILM_FORMULA = "outside the film formula"
# The judgement where an oil that may be the best one has no equilibrium.
NO_EQUILIBRIUM = "no equilibrium"
# Judgements without a choice: there is nothing that scenarios could disagree about.
JUDGEMENTS_WITHOUT_CHOICE = ("no film", OUTSIDE_FILM_FORMULA, NO_EQUILIBRIUM)
# An oil stays the best one if it is the best in at least this share of the draws.
STAYS_BEST_SHARE = 0.95
# The traction behind a band: the fitted law, or the truth of a simulated campaign.
BY_LAW, BY_TRUTH = "law", "truth"
# A choice of oil for all operating points: that of the rules, or one oil everywhere. This is the
# name of the first one in the column `choice` of `advice_band`; that of the others is their oil.
BY_RULES = "rules"
# Columns that identify a scenario of the rules.
_SCENARIO_COLUMNS = ["rule_order", "varied_limit", "limit_factor"]


class _SlipMap(NamedTuple):
    """The motion of a bearing with each oil of the rules, over operating points.

    Attributes:
        oil_names: Names of the oils.
        points: The operating points, with the larger contact pressure.
        slip: Cage slip, shape (oils, points).
        torque_n_m: Friction torque, shape (oils, points).
        lambda_ratio: Film thickness over roughness, shape (oils, points).
    """

    oil_names: list[str]
    points: pd.DataFrame
    slip: FloatArray
    torque_n_m: FloatArray
    lambda_ratio: FloatArray


def advice_tables(
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
    advice = advise(results.cage_slip, selection, lambda_limit)
    if advice.empty:
        return {"slip_advice": advice, "advice_band": tables.empty_table("advice_band")}
    cage_slip = _slip_at_band_temperatures(oils, results.cage_slip, settings)
    return {"slip_advice": advice, "advice_band": _advice_band(cage_slip, settings, BY_LAW)}


def _advice_band(cage_slip: pd.DataFrame, settings: Settings, traction_source: str) -> pd.DataFrame:
    """Table `advice_band`: how often the advice of each scenario is good.

    Args:
        cage_slip: Table of cage slip at all temperatures of the band.
        settings: `gates` and `studies`.
        traction_source: `BY_LAW` or `BY_TRUTH`: the traction behind the table of cage slip.
    """
    selection = study_settings(settings).selection
    slip_map = _slip_map(cage_slip, selection)
    judged_scenarios = [
        _judge_advice(slip_map, changed_selection, settings.gates.lambda_limit).assign(**scenario)
        for scenario, changed_selection in _scenarios(selection)
    ]
    judged = pd.concat(judged_scenarios)
    judged = judged[~judged["judgement"].isin(JUDGEMENTS_WITHOUT_CHOICE)]
    judged[BY_RULES] = judged["judgement"] == "agree"
    key_columns = ["bearing", *_SCENARIO_COLUMNS, "inlet_temperature_c"]
    band = judged.melt(key_columns, [BY_RULES, *_oils_of_rules(selection)], "choice", "agrees")
    agreements = band.groupby([*key_columns, "choice"], sort=False)["agrees"]
    band = agreements.agg(operating_points="size", agreeing_points="sum").reset_index()
    return stack_tables([band.assign(traction=traction_source)], "advice_band")


def advice_by_truth(
    advice: pd.DataFrame,
    band: pd.DataFrame,
    results: CampaignTables,
    settings: Settings,
    constants_by_oil: Mapping[str, FloatArray],
) -> dict[str, pd.DataFrame]:
    """The advice with its judgement by the true traction, the map and the band of that traction.

    Args:
        advice: Table of advice by the fitted law.
        band: Its band.
        results: Table of cage slip.
        settings: The settings.
        constants_by_oil: The printed constants of each oil.

    Returns:
        The tables `slip_advice`, `advice_band` and `true_cage_slip`. If mu was measured, the last
        one is empty and the others are those by the law.
    """
    if settings.campaign.twin is None or advice.empty:
        return {
            "slip_advice": advice,
            "advice_band": band,
            "true_cage_slip": tables.empty_table("true_cage_slip"),
        }
    true_slip = true_cage_slip_map(results.cage_slip, settings, constants_by_oil)
    true_slips = [true_slip]
    for temperature in _missing_temperatures(results.cage_slip, settings):
        rows_at_temperature = results.cage_slip.assign(inlet_temperature_c=temperature)
        true_slips.append(true_cage_slip_map(rows_at_temperature, settings, constants_by_oil))
    band_of_truth = _advice_band(pd.concat(true_slips), settings, BY_TRUTH)
    judged = advise(true_slip, study_settings(settings).selection, settings.gates.lambda_limit)
    key_columns = ["bearing", "inlet_temperature_c", "pitch_speed_mm_rpm", "axial_load_n"]
    truth_columns = judged[[*key_columns, "best_oil", "judgement"]].rename(
        columns={"best_oil": "true_best_oil", "judgement": "true_judgement"}
    )
    advice_of_law = advice.drop(columns=["true_best_oil", "true_judgement"])
    with_truth = advice_of_law.merge(truth_columns, on=key_columns, how="left")
    return {
        "slip_advice": stack_tables([with_truth], "slip_advice"),
        "advice_band": stack_tables([band, band_of_truth], "advice_band"),
        "true_cage_slip": stack_tables([true_slip], "true_cage_slip"),
    }


def _slip_at_band_temperatures(
    oils: Sequence[OilInBearing], cage_slip: pd.DataFrame, settings: Settings
) -> pd.DataFrame:
    """Table of cage slip, with rows for the supply temperatures of the band that it lacks."""
    points = distinct_operating_points(cage_slip).drop(columns="bearing")
    groups = [
        CaseGroup(oil, "stress", points.assign(inlet_temperature_c=temperature))
        for temperature in _missing_temperatures(cage_slip, settings)
        for oil in oils
    ]
    if not groups:
        return cage_slip
    calculated = FrictionCases(settings.tested_bearing(), groups).calculate()
    return pd.concat([cage_slip, calculated], ignore_index=True)


def _missing_temperatures(cage_slip: pd.DataFrame, settings: Settings) -> list[float]:
    """Supply temperatures of the band that the table of cage slip lacks."""
    band_temperatures = set(study_settings(settings).selection.band.inlet_temperature_c)
    return sorted(band_temperatures - set(cage_slip["inlet_temperature_c"]))


def _oils_of_rules(selection: SelectionSettings) -> list[str]:
    """The oils that the rules name, each once, in the order of the rules."""
    return list(dict.fromkeys(oil for rule in selection.rules for oil in rule.prefer))


def advise(
    cage_slip: pd.DataFrame, selection: SelectionSettings, lambda_limit: float
) -> pd.DataFrame:
    """Table of advice: one row per operating point of the map of cage slip.

    Args:
        cage_slip: Table of cage slip.
        selection: `selection` of the study's settings.
        lambda_limit: Lambda above which a film is full.

    Returns:
        The table; empty where an oil that the rules name was not calculated.

    Raises:
        OilfilmError: No rule applies to an operating point.
    """
    if not set(_oils_of_rules(selection)) <= set(cage_slip["oil"]):
        return tables.empty_table("slip_advice")
    advice = _judge_advice(_slip_map(cage_slip, selection), selection, lambda_limit)
    return stack_tables([advice], "slip_advice")


def has_known_best_oil(
    advice: pd.DataFrame, cage_slip: pd.DataFrame, selection: SelectionSettings, lambda_limit: float
) -> "pd.Series[bool]":
    """Whether the rules' oils have a best one at each operating point, and it is known.

    The judgement does not tell: it has no choice, too, where only the advised oil is not known.

    Args:
        advice: Table of advice.
        cage_slip: Table of cage slip.
        selection: `selection` of the study's settings.
        lambda_limit: Lambda above which a film is full.
    """
    of_rules = cage_slip[cage_slip["oil"].isin(_oils_of_rules(selection))]
    best_oils = best_oil_table(of_rules, selection.limits.slip_limit, lambda_limit)
    with_best_oil = best_oils[~best_oils["best_oil"].isin(["", NOT_KNOWN])]
    points = pd.MultiIndex.from_frame(advice[OPERATING_POINT_COLUMNS])
    known_points = pd.MultiIndex.from_frame(with_best_oil[OPERATING_POINT_COLUMNS])
    return pd.Series(points.isin(known_points), advice.index)


def _slip_map(cage_slip: pd.DataFrame, selection: SelectionSettings) -> _SlipMap:
    """Motion of a bearing with each oil of the rules."""
    oils_of_rules = _oils_of_rules(selection)
    oil_names = [oil for oil in dict.fromkeys(cage_slip["oil"]) if oil in oils_of_rules]
    slip, torque, lambda_ratio, inner_pressure, outer_pressure = arrays_by_oil(
        cage_slip,
        oil_names,
        "cage_slip",
        "torque_n_m",
        "lambda_ratio",
        "inner_max_hertz_pressure_gpa",
        "outer_max_hertz_pressure_gpa",
    )
    points = distinct_operating_points(cage_slip)
    pressures = np.concatenate([inner_pressure, outer_pressure])
    points["max_hertz_pressure_gpa"] = np.fmax.reduce(pressures)
    return _SlipMap(oil_names, points, slip, torque, lambda_ratio)


def _judge_advice(
    slip_map: _SlipMap, selection: SelectionSettings, lambda_limit: float
) -> pd.DataFrame:
    """The advice and the best oil of the rules at each operating point, and whether they agree.

    Returns:
        Most columns of the table of advice, and for each oil of the rules a column with its name:
        whether it is as good as the best one.

    Raises:
        OilfilmError: No rule applies to an operating point.
    """
    oil_names, points, slip, torque, lambda_ratio = slip_map
    slip_limit = selection.limits.slip_limit
    has_film, may_have_film = certain_and_possible_full_film(lambda_ratio, lambda_limit)
    is_within_limit = has_film & reaches(slip_limit, slip)
    best_choice = find_best_oil(slip, torque, lambda_ratio, slip_limit, lambda_limit)
    best_oil_index = best_choice.oil_index
    rule_index, advised_oil_index = _rule_and_advised_oil(
        points, slip, oil_names, selection, has_film
    )
    _, perhaps_advised_oil_index = _rule_and_advised_oil(
        points, slip, oil_names, selection, may_have_film
    )
    is_film_unknown = (
        perhaps_advised_oil_index != advised_oil_index
    ) | best_choice.hinges_on_unknown_film
    # an oil is as good as the best one: by torque where the best oil holds the cage, else by slip
    best_slip = _values_of_chosen_oil(slip, best_oil_index)
    best_holds_cage = reaches(slip_limit, best_slip)
    ratio_to_best = np.where(
        best_holds_cage, torque / _values_of_chosen_oil(torque, best_oil_index), slip / best_slip
    )
    is_nearly_best = reaches(1 + selection.indifference, ratio_to_best)
    is_good = has_film & (is_within_limit | ~best_holds_cage) & is_nearly_best
    # the first condition that is met gives the judgement
    is_met_by_judgement = {
        NO_EQUILIBRIUM: best_choice.hinges_on_missing_equilibrium,
        OUTSIDE_FILM_FORMULA: is_film_unknown,
        "no film": best_oil_index < 0,
        "rule has none": advised_oil_index < 0,
        "agree": _values_of_chosen_oil(is_good, advised_oil_index) == 1,
        "slips more": ~best_holds_cage,
        "heats more": _values_of_chosen_oil(is_within_limit, advised_oil_index) == 1,
    }
    judgement = np.select(list(is_met_by_judgement.values()), list(is_met_by_judgement), "slips")
    name_of_index = np.array([*oil_names, ""])
    rule_names = np.array([rule.name for rule in selection.rules])
    return points.assign(
        oils_within_limit=tables.list_column(
            _names_of_chosen(is_within_limit, oil_names), points.index
        ),
        selection_rule=rule_names[rule_index],
        advised_oil=name_of_index[advised_oil_index],
        best_oil=name_of_index[best_oil_index],
        good_oils=tables.list_column(_names_of_chosen(is_good, oil_names), points.index),
        judgement=judgement,
        true_best_oil="",
        true_judgement="",
        **dict(zip(oil_names, is_good, strict=True)),
    )


def _names_of_chosen(is_chosen: BoolArray, oil_names: Sequence[str]) -> list[tuple[str, ...]]:
    """Names of the oils that are chosen at each operating point.

    Args:
        is_chosen: Whether an oil is chosen, shape (oils, points).
        oil_names: Names of the oils.
    """
    return [
        tuple(itertools.compress(oil_names, chosen_at_point)) for chosen_at_point in is_chosen.T
    ]


def first_rule_and_oil(
    points: pd.DataFrame,
    slip: FloatArray,
    selection: SelectionSettings,
    oil_names: Sequence[str],
    has_film: BoolArray,
) -> tuple[IndexArray, IndexArray]:
    """At each operating point the index of the first rule that applies, and of the oil it advises.

    The index of the oil is -1 where the rule has none with enough film.

    Args:
        points: Pressure, dmN and temperature of operating points.
        slip: Their cage slip, shape (points,).
        selection: `selection` of the study's settings.
        oil_names: Names of the oils that may be advised.
        has_film: Whether an oil has enough film, shape (oils, points).

    Raises:
        OilfilmError: No rule applies to one of the points.
    """
    limits = selection.limits
    levels = points[["max_hertz_pressure_gpa", "pitch_speed_mm_rpm", "inlet_temperature_c"]]
    pressure_gpa, pitch_speed, temperature_c = levels.to_numpy(dtype=float).T
    is_slipping = exceeds(slip, limits.slip_limit)
    is_in_state = {
        "slipping": is_slipping,
        "gripping": ~is_slipping,
        "light": exceeds(limits.light_below_gpa, pressure_gpa),
        "heavy": reaches(pressure_gpa, limits.heavy_from_gpa),
        "hot": reaches(temperature_c, limits.hot_from_c),
        "fast": reaches(pitch_speed, limits.fast_from_mm_rpm),
    }
    rule_applies = np.array(
        [np.all([is_in_state[name] for name in rule.when], axis=0) for rule in selection.rules]
    )
    lacks_rule = ~rule_applies.any(axis=0)
    if lacks_rule.any():
        first_without_rule = levels.assign(cage_slip=slip)[lacks_rule].iloc[0]
        condition = ", ".join(f"{name} {level:.3g}" for name, level in first_without_rule.items())
        raise OilfilmError(
            f"selection.rules of the study's settings: no rule applies at {condition}; end the "
            "list with rules for `slipping` and for `gripping`."
        )
    oil_index_of_rule = []
    for rule in selection.rules:
        preferred_indices = np.array([oil_names.index(oil) for oil in rule.prefer])
        first_with_film = preferred_indices[has_film[preferred_indices].argmax(axis=0)]
        oil_index_of_rule.append(
            np.where(has_film[preferred_indices].any(axis=0), first_with_film, -1)
        )
    rule_index = np.argmax(rule_applies, axis=0)
    return rule_index, np.array(oil_index_of_rule)[rule_index, np.arange(len(slip))]


def _rule_and_advised_oil(
    points: pd.DataFrame,
    slip: FloatArray,
    oil_names: Sequence[str],
    selection: SelectionSettings,
    has_film: BoolArray,
) -> tuple[IndexArray, IndexArray]:
    """At each operating point the index of the rule that decides, and of the oil it advises.

    Args:
        points: As for `first_rule_and_oil`.
        slip: Cage slip, shape (oils, points).
        oil_names: Names of the oils that may be advised.
        selection: `selection` of the study's settings.
        has_film: As for `first_rule_and_oil`.
    """
    slip_limit = selection.limits.slip_limit
    point_indices = np.arange(len(points))
    _, advised_at_no_slip = first_rule_and_oil(
        points, np.zeros(len(points)), selection, oil_names, has_film
    )
    slip_with_advised = np.where(
        advised_at_no_slip >= 0, slip[advised_at_no_slip, point_indices], 0.0
    )
    rule_index, advised_oil_index = first_rule_and_oil(
        points, slip_with_advised, selection, oil_names, has_film
    )
    # "4050 is recommended, and if necessary, lubricant 4102": necessary while the cage still slips
    still_slips = (advised_oil_index >= 0) & ~reaches(
        slip_limit, slip[advised_oil_index, point_indices]
    )
    for point_index in point_indices[still_slips]:
        preferred_indices = [
            oil_names.index(oil_name)
            for oil_name in selection.rules[rule_index[point_index]].prefer
        ]
        indices_with_film = [
            oil_index for oil_index in preferred_indices if has_film[oil_index, point_index]
        ]
        indices_that_hold_cage = [
            oil_index
            for oil_index in indices_with_film
            if reaches(slip_limit, slip[oil_index, point_index])
        ]
        advised_oil_index[point_index] = (
            indices_that_hold_cage[0] if indices_that_hold_cage else indices_with_film[-1]
        )
    return rule_index, advised_oil_index


def _values_of_chosen_oil(values: FloatArray | BoolArray, oil_index: IndexArray) -> FloatArray:
    """Value of the chosen oil at each operating point, null where there is none."""
    return np.where(oil_index >= 0, values[oil_index, np.arange(len(oil_index))], np.nan)


def _scenarios(selection: SelectionSettings) -> Iterator[tuple[dict[str, Any], SelectionSettings]]:
    """The rules as set, in each order, and in each order with one limit after the other changed."""
    rule_by_name = {rule.name: rule for rule in selection.rules}
    rule_names_by_order = {"as set": list(rule_by_name)}
    rule_names_by_order.update(selection.band.rule_orders)
    limits_and_factors = [("", 1.0)]
    limits_and_factors.extend(
        itertools.product(SelectionLimits.model_fields, selection.band.limit_factors)
    )
    for order_name, rule_names in rule_names_by_order.items():
        for limit_name, factor in limits_and_factors:
            changed_limit = {}
            if limit_name:
                changed_limit[limit_name] = factor * getattr(selection.limits, limit_name)
            changed_selection = selection.model_copy(
                update={
                    "rules": [rule_by_name[name] for name in rule_names],
                    "limits": selection.limits.model_copy(update=changed_limit),
                }
            )
            scenario = {
                "rule_order": order_name,
                "varied_limit": limit_name,
                "limit_factor": factor,
            }
            yield scenario, changed_selection
