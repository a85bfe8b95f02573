"""The paper's advice on which oil to choose, beside the best oil of a bearing by cage slip.

The paper chooses oils by cage slip: up to a limit the one with the least heat, beyond it one with
more traction. Where the friction equilibrium gives the slip with each oil, the choice follows from
it alone (`oilfilm.torque.best_oil`). The paper's rules (`selection` of the configuration) are its
sentences in the order of its conclusion: the first whose conditions are met decides, and of the
oils that it prefers the first one with enough film is taken. They are applied as an engineer would:
which oil they advise where nothing slips, whether the cage slips with that oil, and if so which one
then.

The paper states neither an order of its rules nor a number for "hot" and "fast". So the result is a
band over scenarios: the rules in each order, each limit times some factors, at each supply
temperature; and the rules as set with other drag (`bearing.oil_volume_fraction_range`) and refits
of the law of each oil.

Decides: which oil the paper advises at an operating point, and how firm that is.
"""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.bearing.kinematics import entrainment_speed_m_s
from oilfilm.errors import OilfilmError
from oilfilm.fits.fitted import FittedLaw
from oilfilm.settings.config import SelectionLimits, SelectionSettings
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.bearing_torque import OilInBearing
from oilfilm.torque.best_oil import IntArray, best_index, by_oil, enough_film, operating_points
from oilfilm.units import BoolArray, FloatArray

# The judgement where the choice depends on a film beyond the range of the thermal reduction.
OUTSIDE = "outside the film formula"
# Without a choice there is nothing that scenarios could disagree about.
NO_CHOICE = ("no film", OUTSIDE)
_POINT = ["pitch_speed_mm_rpm", "axial_load_n"]
_DRAWN = ["oil_volume_fraction", "refit"]
_AS_SET: dict[str, str | float] = {"rule_order": "as set", "varied_limit": "", "limit_factor": 1.0}
_SCENARIO = [*_AS_SET, "inlet_temperature_c", *_DRAWN]
# What is chosen at every operating point: the oil that the rules advise, or one oil.
BY_RULES = "rules"


def advice_in_band(
    oils: Sequence[OilInBearing], results: CampaignTables, settings: Settings
) -> dict[str, pd.DataFrame]:
    """The advice at each operating point with its shares of scenarios, and each scenario's count.

    Args:
        oils: Oils with their laws.
        results: Tables of coefficients and refits, and of cage slip, the nominal scenario.
        settings: `bearing`, `gates` and `selection`, and the campaign's bearing.

    Returns:
        The tables `slip_advice` and `advice_band`; empty where the rules name an oil that has no
        law.
    """
    choice, lambda_limit = settings.selection, settings.gates.lambda_limit
    nominal = advise(results.cage_slip, choice, lambda_limit)
    if nominal.empty:
        return {"slip_advice": nominal, "advice_band": tables.empty("advice_band")}
    as_set = {"oil_volume_fraction": settings.bearing.oil_volume_fraction, "refit": 0}
    slips = pd.concat(_drag_and_law(oils, results, settings), ignore_index=True)
    drawn = [
        advise(of_scenario, choice, lambda_limit).assign(
            **_AS_SET, **{name: of_scenario[name].iloc[0] for name in _DRAWN}
        )
        for _, of_scenario in slips.groupby(_DRAWN, sort=False)
    ]
    slips = pd.concat(_at_temperatures(oils, results.cage_slip, settings), ignore_index=True)
    read = [
        advise(at_temperature, rules, lambda_limit).assign(**reading, **as_set)
        for _, at_temperature in slips.groupby("inlet_temperature_c", sort=False)
        for reading, rules in _readings(choice)
    ]
    advice = pd.concat([*drawn, *read], ignore_index=True)
    advice = advice[~advice["judgement"].isin(NO_CHOICE)].drop_duplicates([*_SCENARIO, *_POINT])
    good = {BY_RULES: advice["judgement"] == "agree"}
    for oil in dict.fromkeys(oil for rule in choice.rules for oil in rule.prefer):
        good[oil] = advice["good_oils"].str.split("; ").map(lambda oils, own=oil: own in oils)
    chosen = [advice.assign(choice=name, agrees=holds) for name, holds in good.items()]
    band = (
        pd.concat(chosen)
        .groupby([*_SCENARIO, "choice", "bearing"], sort=False)["agrees"]
        .agg(operating_points="size", agreeing_points="sum")
        .reset_index()[tables.columns("advice_band")]
    )
    of_drawn = pd.concat(drawn, ignore_index=True)
    of_drawn = of_drawn[~of_drawn["judgement"].isin(NO_CHOICE)]
    return {
        "slip_advice": _with_shares(nominal, of_drawn),
        "advice_band": tables.conform(band, "advice_band", "advice band"),
    }


def advise(
    cage_slip: pd.DataFrame, settings: SelectionSettings, lambda_limit: float
) -> pd.DataFrame:
    """Table of advice: one row per operating point of the map of cage slip.

    Args:
        cage_slip: Table of cage slip.
        settings: `selection` of the settings.
        lambda_limit: Full film above.

    Returns:
        The table, whose shares of scenarios are null (`advice_in_band` has them); empty where an
        oil that the rules name was not calculated.

    Raises:
        OilfilmError: No rule applies to an operating point.
    """
    named = {oil for rule in settings.rules for oil in rule.prefer}
    oils = [oil for oil in dict.fromkeys(cage_slip["oil"]) if oil in named]
    if set(oils) < named:
        return tables.empty("slip_advice")
    points, of = operating_points(cage_slip), partial(by_oil, cage_slip, oils)
    slip, torque, film = of("cage_slip"), of("torque_n_m"), of("lambda_ratio")
    contacts = points.assign(
        max_hertz_pressure_gpa=np.fmax.reduce(
            [*of("inner_max_hertz_pressure_gpa"), *of("outer_max_hertz_pressure_gpa")]
        ),
        # whether it is fast depends on the bearing, not on how much its cage slips
        entrainment_speed_m_s=entrainment_speed_m_s(points["pitch_speed_mm_rpm"].to_numpy()),
    )
    limit = settings.limits.slip_limit
    enough, perhaps = enough_film(film, lambda_limit)
    # without equilibrium an oil is no choice, whatever its film
    perhaps &= np.isfinite(slip)
    within = enough & (slip <= limit)
    best = best_index(slip, torque, enough, limit)
    deciding, advised, start = _by_rules(contacts, oils, settings, slip, enough)
    outside = _by_rules(contacts, oils, settings, slip, perhaps)[1] != advised
    outside |= best_index(slip, torque, perhaps, limit) != best
    best_slip, best_torque = _of_oil(slip, best), _of_oil(torque, best)
    could = best_slip <= limit
    loss = np.where(could, torque / best_torque, slip / best_slip) - 1
    good = enough & (within | ~could) & (loss <= settings.indifference)
    judgement = np.select(
        [outside, best < 0, advised < 0, _of_oil(good, advised) == 1, ~could],
        [OUTSIDE, "no film", "rule has none", "agree", "slips more"],
        np.where(_of_oil(within, advised) == 1, "heats more", "slips"),
    )
    names = np.array([*oils, ""])
    frame = points.assign(
        oils_within_limit=["; ".join(np.compress(column, oils)) for column in within.T],
        selection_rule=np.array([rule.name for rule in settings.rules])[deciding],
        slip_that_decides=_of_oil(slip, start),
        advised_oil=names[advised],
        advised_cage_slip=_of_oil(slip, advised),
        advised_torque_n_m=_of_oil(torque, advised),
        best_oil=names[best],
        best_cage_slip=best_slip,
        best_torque_n_m=best_torque,
        good_oils=["; ".join(np.compress(column, oils)) for column in good.T],
        judgement=judgement,
        agree_share=np.nan,
        best_oil_share=np.nan,
        best_oils="",
    )
    return tables.conform(frame[tables.columns("slip_advice")], "slip_advice", "slip advice")


def decide(
    points: pd.DataFrame, settings: SelectionSettings, oils: Sequence[str], enough: BoolArray
) -> tuple[IntArray, IntArray]:
    """At each operating point the first rule that applies, and the oil it advises (-1 for none).

    Args:
        points: Operating points with their slide-roll ratio.
        settings: `selection` of the settings, which says by `reading` which slide-roll ratio and
            which entrainment speed the rules' cage slip and bearing speed are.
        oils: The oils that may be advised.
        enough: Whether an oil has enough film, shape (oils, points).

    Raises:
        OilfilmError: No rule applies to one of the points.
    """
    limits, pressure = settings.limits, points["max_hertz_pressure_gpa"]
    slipping = points["slide_roll_ratio"] > settings.slide_roll_ratio_limit
    states = pd.DataFrame(
        {
            "slipping": slipping,
            "gripping": ~slipping,
            "light": pressure < limits.light_below_gpa,
            "heavy": pressure >= limits.heavy_from_gpa,
            "hot": points["inlet_temperature_c"] >= limits.hot_from_c,
            "fast": points["entrainment_speed_m_s"] >= settings.fast_from_m_s,
        }
    )
    applies = np.array([states[list(rule.when)].all(axis=1) for rule in settings.rules])
    if not (ruled := applies.any(axis=0)).all():
        unruled = points[~ruled].select_dtypes("number").iloc[0]
        condition = ", ".join(f"{name} {value:.3g}" for name, value in unruled.items())
        raise OilfilmError(
            f"selection.rules of the configuration: no rule applies at {condition}; end the list "
            "with rules for `slipping` and for `gripping`."
        )
    orders = [np.array([oils.index(oil) for oil in rule.prefer]) for rule in settings.rules]
    advice = [
        np.where(enough[order].any(axis=0), order[enough[order].argmax(axis=0)], -1)
        for order in orders
    ]
    deciding = np.argmax(applies, axis=0)
    return deciding, np.array(advice)[deciding, np.arange(len(points))]


def _by_rules(
    contacts: pd.DataFrame,
    oils: Sequence[str],
    settings: SelectionSettings,
    slip: FloatArray,
    enough: BoolArray,
) -> tuple[IntArray, IntArray, IntArray]:
    """At each point the rule that decides, the oil it advises, and that of the rules at no slip."""
    limit, each = settings.limits.slip_limit, np.arange(len(contacts))
    _, start = decide(contacts.assign(slide_roll_ratio=0.0), settings, oils, enough)
    started = np.where(start >= 0, slip[start, each], 0.0)
    slipping = contacts.assign(slide_roll_ratio=settings.slide_roll_ratio(started))
    deciding, advised = decide(slipping, settings, oils, enough)
    # "4050 is recommended, and if necessary, lubricant 4102": necessary while the cage still slips
    prefer = [[oils.index(oil) for oil in rule.prefer] for rule in settings.rules]
    for point in each[(advised >= 0) & ~(slip[advised, each] <= limit)]:
        others = [oil for oil in prefer[deciding[point]] if enough[oil, point]]
        holding = [oil for oil in others if slip[oil, point] <= limit]
        advised[point] = holding[0] if holding else others[-1]
    return deciding, advised, start


def _of_oil(values: FloatArray | BoolArray, oil: IntArray) -> FloatArray:
    """Value of the chosen oil at each operating point, null where there is none."""
    return np.where(oil >= 0, values[oil, np.arange(len(oil))], np.nan)


def _readings(
    choice: SelectionSettings,
) -> Iterator[tuple[dict[str, str | float], SelectionSettings]]:
    """The rules in each order, and in each with one limit after the other changed."""
    by_name = {rule.name: rule for rule in choice.rules}
    orders = {str(_AS_SET["rule_order"]): list(by_name), **choice.band.rule_orders}
    factors = itertools.product(SelectionLimits.model_fields, choice.band.limit_factors)
    limits = [("", 1.0), *factors]
    for (order, names), (limit, factor) in itertools.product(orders.items(), limits):
        changed = {limit: factor * getattr(choice.limits, limit)} if limit else {}
        update = {
            "rules": [by_name[name] for name in names],
            "limits": choice.limits.model_copy(update=changed),
        }
        reading: dict[str, str | float] = {"rule_order": order}
        reading |= {"varied_limit": limit, "limit_factor": factor}
        yield reading, choice.model_copy(update=update)


def _at_temperatures(
    oils: Sequence[OilInBearing], cage_slip: pd.DataFrame, settings: Settings
) -> Iterator[pd.DataFrame]:
    """Cage slip as set, and with oil of other supply temperatures."""
    yield cage_slip
    for oil, temperature in itertools.product(oils, settings.selection.band.inlet_temperature_c):
        at = cage_slip[cage_slip["oil"] == oil.name]
        if temperature not in set(at["inlet_temperature_c"]):
            points = at["axial_load_n"].to_numpy(), at["inner_speed_rpm"].to_numpy()
            yield oil.run(settings.tested_bearing(), *points, temperature).assign(
                pitch_speed_mm_rpm=at["pitch_speed_mm_rpm"].to_numpy()
            )


def _drag_and_law(
    oils: Sequence[OilInBearing], results: CampaignTables, settings: Settings
) -> Iterator[pd.DataFrame]:
    """Cage slip of each oil with every drag and refit; refit 0 is the fit itself."""
    bearing, band, choice = settings.tested_bearing(), settings.bearing, settings.selection.band
    low, high = band.oil_volume_fraction_range
    ends = np.geomspace(low, high, choice.oil_volume_fractions)
    spread = {
        oil.name: FittedLaw.of(
            results.coefficients, oil.name, results.refits, law=oil.laws["stress"].fitted.law
        ).coefficients.spread
        for oil in oils
    }
    # in every scenario each oil has a refit of its own: they were measured apart
    count = min(choice.refits, *map(len, spread.values()))
    refits = np.arange(count + 1)
    for oil in oils:
        at = results.cage_slip[results.cage_slip["oil"] == oil.name]
        constants = np.vstack([oil.laws["stress"].constants, spread[oil.name][:count]])
        points = at[["axial_load_n", "inner_speed_rpm", "inlet_temperature_c"]].to_numpy()
        load, speed, temperature = np.tile(points, (len(refits), 1)).T
        for fraction in np.union1d(ends, band.oil_volume_fraction):
            drag = band.model_copy(update={"oil_volume_fraction": float(fraction)})
            drawn = replace(oil, settings=drag).with_constants(
                np.repeat(constants, len(at), axis=0)
            )
            yield drawn.run(bearing, load, speed, temperature).assign(
                pitch_speed_mm_rpm=np.tile(at["pitch_speed_mm_rpm"], len(refits)),
                oil_volume_fraction=fraction,
                refit=np.repeat(refits, len(at)),
            )


def _with_shares(nominal: pd.DataFrame, chosen: pd.DataFrame) -> pd.DataFrame:
    """The nominal advice with the shares of scenarios in which it and its best oil are good."""
    shares = pd.DataFrame(columns=["agree_share", "best_oil_share", "best_oils"])
    if len(chosen):
        best = nominal.set_index(_POINT)["best_oil"]
        expected = best.loc[pd.MultiIndex.from_frame(chosen[_POINT])]
        pairs = zip(expected, chosen["good_oils"], strict=True)
        good = [oil in oils.split("; ") for oil, oils in pairs]
        agrees = chosen["judgement"] == "agree"
        by_point = chosen.assign(good=good, agrees=agrees).groupby(_POINT)
        shares["agree_share"] = by_point["agrees"].mean()
        shares["best_oil_share"] = by_point["good"].mean().where(best != "")
        shares["best_oils"] = by_point["best_oil"].agg(lambda oils: "; ".join(sorted(set(oils))))
    frame = nominal.drop(columns=shares.columns).join(shares, on=_POINT)
    frame = frame.fillna({"best_oils": ""})[tables.columns("slip_advice")]
    return tables.conform(frame, "slip_advice", "slip advice")
