"""The oil that keeps a bearing's cage from slipping, beside the one that the paper advises.

The paper chooses oils by cage slip: up to a limit the one with the least heat, beyond it one with
more traction. Where the friction equilibrium gives the slip with each oil, the choice follows from
it alone: of the oils with enough film whose slip stays within the limit the one with the least
torque, and where none does the one that slips least. The paper's rules (`selection` of the
configuration) are applied in the order in which an engineer would: which oil they advise where
nothing slips, whether the cage slips with that oil, and if so which one they advise then.
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.bearing.kinematics import entrainment_speed_m_s
from oilfilm.paper.selection import OUTSIDE, IntArray, decide, enough_film, of_oil
from oilfilm.settings.config import SelectionSettings
from oilfilm.units import BoolArray, FloatArray

_OPERATING_POINT = [
    "bearing",
    "inlet_temperature_c",
    "pitch_speed_mm_rpm",
    "inner_speed_rpm",
    "axial_load_n",
]


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
    points = cage_slip[_OPERATING_POINT].drop_duplicates().reset_index(drop=True)

    def of(column: str) -> FloatArray:
        """A column by oil and operating point."""
        wide = cage_slip.pivot(index=_OPERATING_POINT, columns="oil", values=column)
        return wide.loc[pd.MultiIndex.from_frame(points), oils].to_numpy(dtype=float).T

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
    best = _best(slip, torque, enough, limit)
    deciding, advised, start = _by_rules(contacts, oils, settings, slip, enough)
    outside = _by_rules(contacts, oils, settings, slip, perhaps)[1] != advised
    outside |= _best(slip, torque, perhaps, limit) != best
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


def _best(slip: FloatArray, torque: FloatArray, enough: BoolArray, limit: float) -> IntArray:
    """Index of the oil that holds the cage at the least torque, or slips least; -1 without film."""
    within = enough & (slip <= limit)
    least_torque = np.where(within, torque, np.inf).argmin(axis=0)
    least_slip = np.where(enough & np.isfinite(slip), slip, np.inf).argmin(axis=0)
    best = np.where(within.any(axis=0), least_torque, least_slip)
    return np.where((enough & np.isfinite(slip)).any(axis=0), best, -1)


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
