"""The oil that keeps a bearing's cage from slipping, beside the one that the paper advises.

The paper chooses oils by cage slip: up to a limit the one with the least heat, beyond it one with
more traction. Where the friction equilibrium gives the slip with each oil, the choice follows from
it alone: of the oils with enough film whose slip stays within the limit the one with the least
torque, and where none does the one that slips least. The paper's rules (`selection` of the
configuration) are applied in the order in which an engineer would: which oil they advise where
nothing slips, whether the cage slips with that oil, and if so which one they advise then.
"""

from collections.abc import Sequence
from functools import partial

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.bearing.kinematics import entrainment_speed_m_s
from oilfilm.paper.selection import OUTSIDE, decide, of_oil
from oilfilm.settings.config import SelectionSettings
from oilfilm.torque.best_oil import (
    IntArray,
    best_index,
    by_oil,
    enough_film,
    operating_points,
)
from oilfilm.units import BoolArray, FloatArray


def advise(
    cage_slip: pd.DataFrame, settings: SelectionSettings, lambda_limit: float
) -> pd.DataFrame:
    """Table of advice: one row per operating point of the map of cage slip.

    Args:
        cage_slip: Table of cage slip.
        settings: `selection` of the settings.
        lambda_limit: Full film above.

    Returns:
        The table, whose shares of scenarios are null (`advice_band` has them); empty where an oil
        that the rules name was not calculated.

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
    best_slip, best_torque = of_oil(slip, best), of_oil(torque, best)
    could = best_slip <= limit
    loss = np.where(could, torque / best_torque, slip / best_slip) - 1
    good = enough & (within | ~could) & (loss <= settings.indifference)
    judgement = np.select(
        [outside, best < 0, advised < 0, of_oil(good, advised) == 1, ~could],
        [OUTSIDE, "no film", "rule has none", "agree", "slips more"],
        np.where(of_oil(within, advised) == 1, "heats more", "slips"),
    )
    names = np.array([*oils, ""])
    frame = points.assign(
        oils_within_limit=["; ".join(np.compress(column, oils)) for column in within.T],
        selection_rule=np.array([rule.name for rule in settings.rules])[deciding],
        slip_that_decides=of_oil(slip, start),
        advised_oil=names[advised],
        advised_cage_slip=of_oil(slip, advised),
        advised_torque_n_m=of_oil(torque, advised),
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


def _by_rules(
    contacts: pd.DataFrame,
    oils: Sequence[str],
    settings: SelectionSettings,
    slip: FloatArray,
    enough: BoolArray,
) -> tuple[IntArray, IntArray, IntArray]:
    """At each point the rule that decides, the oil it advises, and that of the rules at no slip."""
    limit, each = settings.limits.slip_limit, np.arange(len(contacts))
    start = decide(contacts.assign(slide_roll_ratio=0.0), settings, oils, enough).oil
    started = np.where(start >= 0, slip[start, each], 0.0)
    slipping = contacts.assign(slide_roll_ratio=settings.slide_roll_ratio(started))
    deciding, advised, _ = decide(slipping, settings, oils, enough)
    # "4050 is recommended, and if necessary, lubricant 4102": necessary while the cage still slips
    prefer = [[oils.index(oil) for oil in rule.prefer] for rule in settings.rules]
    for point in each[(advised >= 0) & ~(slip[advised, each] <= limit)]:
        others = [oil for oil in prefer[deciding[point]] if enough[oil, point]]
        holding = [oil for oil in others if slip[oil, point] <= limit]
        advised[point] = holding[0] if holding else others[-1]
    return deciding, advised, start
