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
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.bearing.kinematics import entrainment_speed_m_s
from oilfilm.errors import OilfilmError
from oilfilm.fits.fitted import FittedLaw
from oilfilm.settings.config import SelectionLimits, SelectionSettings
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.bearing_torque import Cases, OilInBearing
from oilfilm.torque.best_oil import IntArray, best_index, by_oil, enough_film, operating_points
from oilfilm.traction.law import CONDITIONS
from oilfilm.units import BoolArray, FloatArray

# The judgement where the choice depends on a film beyond the range of the thermal reduction.
OUTSIDE = "outside the film formula"
# Without a choice there is nothing that scenarios could disagree about.
NO_CHOICE = ("no film", OUTSIDE)
_DRAWN = ["inlet_temperature_c", "oil_volume_fraction", "refit"]
_AS_SET: dict[str, str | float] = {"rule_order": "as set", "varied_limit": "", "limit_factor": 1.0}
# What is chosen at every operating point: the oil that the rules advise, or one oil.
BY_RULES = "rules"


@dataclass(frozen=True)
class SlipMap:
    """Motion of a bearing with each oil; arrays of shape (oils, operating points).

    Attributes:
        oils: Names.
        points: Operating points, with pressure and entrainment speed of the contacts.
        slip: Cage slip.
        torque: Friction torque, in N m.
        film: Lambda.
    """

    oils: list[str]
    points: pd.DataFrame
    slip: FloatArray
    torque: FloatArray
    film: FloatArray

    @classmethod
    def of(cls, cage_slip: pd.DataFrame, settings: SelectionSettings) -> "SlipMap | None":
        """The map of the rules' oils; None where one of them was not calculated."""
        named = {oil for rule in settings.rules for oil in rule.prefer}
        oils = [oil for oil in dict.fromkeys(cage_slip["oil"]) if oil in named]
        if set(oils) < named:
            return None
        slip, torque, film, inner, outer = by_oil(
            *(cage_slip, oils, "cage_slip", "torque_n_m", "lambda_ratio"),
            *("inner_max_hertz_pressure_gpa", "outer_max_hertz_pressure_gpa"),
        )
        points = operating_points(cage_slip)
        points = points.assign(
            max_hertz_pressure_gpa=np.fmax.reduce([*inner, *outer]),
            # whether it is fast depends on the bearing, not on how much its cage slips
            entrainment_speed_m_s=entrainment_speed_m_s(points["pitch_speed_mm_rpm"].to_numpy()),
        )
        return cls(oils, points, slip, torque, film)


@dataclass(frozen=True)
class Choice:
    """What is chosen at each operating point; indices of oils are -1 where there is none.

    Attributes:
        deciding: Index of the rule that decides.
        advised: The oil that it advises.
        start: The oil that the rules advise where nothing slips.
        best: The best oil by cage slip.
        within: Oils with enough film that hold the cage, shape (oils, points).
        good: Oils that are as good as the best one, of the same shape.
        judgement: Of the advice.
    """

    deciding: IntArray
    advised: IntArray
    start: IntArray
    best: IntArray
    within: BoolArray
    good: BoolArray
    judgement: np.ndarray

    @property
    def judged(self) -> BoolArray:
        """Where there is a choice."""
        return ~np.isin(self.judgement, NO_CHOICE)


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
    slips = _scenarios(oils, results, settings)
    of_drawn: list[Choice] = []
    made: dict[tuple[object, ...], Choice] = {}
    maps: list[tuple[tuple[object, ...], SlipMap]] = []
    for drawn, cage_slip in slips.groupby(_DRAWN, sort=False):
        at = SlipMap.of(cage_slip, choice)
        if at is None:
            continue
        maps.append((tuple(drawn), at))
        if drawn[0] == slips["inlet_temperature_c"].iloc[0]:
            made[*_AS_SET.values(), *drawn] = choose(at, choice, lambda_limit)
            of_drawn.append(made[*_AS_SET.values(), *drawn])
    as_set = settings.bearing.oil_volume_fraction, 0
    for drawn, at in maps:
        for reading, rules in _readings(choice) if drawn[1:] == as_set else ():
            made.setdefault((*reading, *drawn), choose(at, rules, lambda_limit))
    rows = [
        (*scenario, name, maps[0][1].points["bearing"].iloc[0], each.judged.sum(), holds.sum())
        for name in (BY_RULES, *dict.fromkeys(oil for rule in choice.rules for oil in rule.prefer))
        for scenario, each in made.items()
        if each.judged.any()
        for holds in [_holds(each, name, maps[0][1].oils)]
    ]
    return {
        "slip_advice": _with_shares(nominal, of_drawn, maps[0][1].oils),
        "advice_band": tables.conform(
            pd.DataFrame(rows, columns=tables.columns("advice_band")), "advice_band", "advice band"
        ),
    }


def _holds(choice: Choice, name: str, oils: Sequence[str]) -> BoolArray:
    """Where the rules' oil, or this oil, is a good choice."""
    agree = choice.judgement == "agree"
    return choice.judged & (agree if name == BY_RULES else choice.good[oils.index(name)])


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
    if (at := SlipMap.of(cage_slip, settings)) is None:
        return tables.empty("slip_advice")
    made, names = choose(at, settings, lambda_limit), np.array([*at.oils, ""])
    frame = at.points.assign(
        oils_within_limit=_joined(made.within, at.oils),
        selection_rule=np.array([rule.name for rule in settings.rules])[made.deciding],
        slip_that_decides=_of_oil(at.slip, made.start),
        advised_oil=names[made.advised],
        advised_cage_slip=_of_oil(at.slip, made.advised),
        advised_torque_n_m=_of_oil(at.torque, made.advised),
        best_oil=names[made.best],
        best_cage_slip=_of_oil(at.slip, made.best),
        best_torque_n_m=_of_oil(at.torque, made.best),
        good_oils=_joined(made.good, at.oils),
        judgement=made.judgement,
        agree_share=np.nan,
        best_oil_share=np.nan,
        best_oils="",
    )
    return tables.conform(frame[tables.columns("slip_advice")], "slip_advice", "slip advice")


def _joined(chosen: BoolArray, oils: Sequence[str]) -> list[str]:
    """Names of the oils that are chosen at each operating point."""
    return ["; ".join(itertools.compress(oils, column)) for column in chosen.T]


def choose(at: SlipMap, settings: SelectionSettings, lambda_limit: float) -> Choice:
    """The advice and the best oil at each operating point of a map.

    Raises:
        OilfilmError: No rule applies to an operating point.
    """
    limit, slip, torque = settings.limits.slip_limit, at.slip, at.torque
    enough, perhaps = enough_film(at.film, lambda_limit)
    # without equilibrium an oil is no choice, whatever its film
    perhaps &= np.isfinite(slip)
    within = enough & (slip <= limit)
    best = best_index(slip, torque, enough, limit)
    deciding, advised, start = _by_rules(at, settings, enough)
    outside = _by_rules(at, settings, perhaps)[1] != advised
    outside |= best_index(slip, torque, perhaps, limit) != best
    best_slip = _of_oil(slip, best)
    could = best_slip <= limit
    loss = np.where(could, torque / _of_oil(torque, best), slip / best_slip) - 1
    good = enough & (within | ~could) & (loss <= settings.indifference)
    judgement = np.select(
        [outside, best < 0, advised < 0, _of_oil(good, advised) == 1, ~could],
        [OUTSIDE, "no film", "rule has none", "agree", "slips more"],
        np.where(_of_oil(within, advised) == 1, "heats more", "slips"),
    )
    return Choice(deciding, advised, start, best, within, good, judgement)


def decide(
    points: Mapping[str, FloatArray] | pd.DataFrame,
    settings: SelectionSettings,
    oils: Sequence[str],
    enough: BoolArray,
) -> tuple[IntArray, IntArray]:
    """At each operating point the first rule that applies, and the oil it advises (-1 for none).

    Args:
        points: Pressure, speed, temperature and slide-roll ratio of operating points.
        settings: `selection` of the settings, which says by `reading` which slide-roll ratio and
            which entrainment speed the rules' cage slip and bearing speed are.
        oils: The oils that may be advised.
        enough: Whether an oil has enough film, shape (oils, points).

    Raises:
        OilfilmError: No rule applies to one of the points.
    """
    limits = settings.limits
    levels = {name: np.asarray(points[name]) for name in (*CONDITIONS, "slide_roll_ratio")}
    pressure, speed, temperature, slip = levels.values()
    slipping = slip > settings.slide_roll_ratio_limit
    states = {
        "slipping": slipping,
        "gripping": ~slipping,
        "light": pressure < limits.light_below_gpa,
        "heavy": pressure >= limits.heavy_from_gpa,
        "hot": temperature >= limits.hot_from_c,
        "fast": speed >= settings.fast_from_m_s,
    }
    applies = np.array([np.all([states[name] for name in rule.when], 0) for rule in settings.rules])
    if not (ruled := applies.any(axis=0)).all():
        at = ", ".join(f"{name} {level[~ruled][0]:.3g}" for name, level in levels.items())
        raise OilfilmError(
            f"selection.rules of the configuration: no rule applies at {at}; end the list "
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
    at: SlipMap, settings: SelectionSettings, enough: BoolArray
) -> tuple[IntArray, IntArray, IntArray]:
    """At each point the rule that decides, the oil it advises, and that of the rules at no slip."""
    limit, slip, each = settings.limits.slip_limit, at.slip, np.arange(len(at.points))
    points = {name: at.points[name].to_numpy() for name in CONDITIONS}
    points["slide_roll_ratio"] = np.zeros(len(each))
    _, start = decide(points, settings, at.oils, enough)
    points["slide_roll_ratio"] = settings.slide_roll_ratio(
        np.where(start >= 0, slip[start, each], 0.0)
    )
    deciding, advised = decide(points, settings, at.oils, enough)
    # "4050 is recommended, and if necessary, lubricant 4102": necessary while the cage still slips
    prefer = [[at.oils.index(oil) for oil in rule.prefer] for rule in settings.rules]
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
) -> Iterator[tuple[tuple[str | float, ...], SelectionSettings]]:
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
        yield (order, limit, factor), choice.model_copy(update=update)


def _scenarios(
    oils: Sequence[OilInBearing], results: CampaignTables, settings: Settings
) -> pd.DataFrame:
    """Cage slip of each oil as set, with every drag and refit, and with warmer or cooler oil.

    Refit 0 is the fit itself.
    """
    band, choice = settings.bearing, settings.selection.band
    low, high = band.oil_volume_fraction_range
    fractions = np.union1d(
        np.geomspace(low, high, choice.oil_volume_fractions), band.oil_volume_fraction
    )
    spread = {
        oil.name: FittedLaw.of(
            results.coefficients, oil.name, results.refits, law=oil.laws["stress"].fitted.law
        ).coefficients.spread
        for oil in oils
    }
    # in every scenario each oil has a refit of its own: they were measured apart
    refits = range(min(choice.refits, *map(len, spread.values())) + 1)
    points = operating_points(results.cage_slip).drop(columns="bearing")
    as_set = {"oil_volume_fraction": band.oil_volume_fraction, "refit": 0}
    groups = []
    for fraction, refit in itertools.product(fractions.tolist(), refits):
        at = {"oil_volume_fraction": fraction, "refit": refit}
        update = band.model_copy(update={"oil_volume_fraction": fraction})
        for oil in oils if at != as_set else ():
            drawn = replace(oil, settings=update)
            if refit:
                drawn = drawn.with_constants(spread[oil.name][refit - 1])
            groups.append((drawn, "stress", points.assign(**at)))
    for temperature in choice.inlet_temperature_c:
        if temperature not in set(points["inlet_temperature_c"]):
            warm = points.assign(inlet_temperature_c=temperature, **as_set)
            groups += [(oil, "stress", warm) for oil in oils]
    return pd.concat(
        [results.cage_slip.assign(**as_set), Cases(settings.tested_bearing(), groups).run()],
        ignore_index=True,
    )


def _with_shares(
    nominal: pd.DataFrame, drawn: Sequence[Choice], oils: Sequence[str]
) -> pd.DataFrame:
    """The nominal advice with the shares of scenarios in which it and its best oil are good."""
    judged = np.array([each.judged for each in drawn])
    agree = np.array([each.judgement == "agree" for each in drawn])
    places = {oil: place for place, oil in enumerate(oils)}
    best: IntArray = np.array([places.get(oil, -1) for oil in nominal["best_oil"]], dtype=np.intp)
    good = np.array([_of_oil(each.good, best) for each in drawn])
    names = np.array([[*oils, ""][place] for each in drawn for place in each.best])
    names = names.reshape(judged.shape)
    with np.errstate(invalid="ignore"):
        frame = nominal.assign(
            agree_share=(agree & judged).sum(axis=0) / judged.sum(axis=0),
            best_oil_share=np.where(judged, good, 0.0).sum(axis=0) / judged.sum(axis=0),
            best_oils=[
                "; ".join(np.unique(each[kept]))
                for each, kept in zip(names.T, judged.T, strict=True)
            ],
        )
    frame.loc[best < 0, "best_oil_share"] = np.nan
    return tables.conform(frame, "slip_advice", "slip advice")
