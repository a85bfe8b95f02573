"""The oil that keeps a bearing's cage from slipping, beside the one that the paper advises.

The paper chooses oils by cage slip: up to a limit the one with the least heat, beyond it one with
more traction. Where the friction equilibrium gives the slip with each oil, the choice follows from
it alone: of the oils with enough film whose slip stays within the limit the one with the least
torque, and where none does the one that slips least. The paper's rules (`selection` of the
configuration) are asked in the order in which an engineer would: which oil they advise where
nothing slips, whether the cage slips with that oil, and if so which one they advise then.
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.settings.config import SelectionSettings
from oilfilm.studies.selection import BoolArray, IntArray, Sayings, states
from oilfilm.units import FloatArray

PLACE = ["bearing", "inlet_temperature_c", "pitch_speed_mm_rpm", "inner_speed_rpm", "axial_load_n"]


def advise(
    cage_slip: pd.DataFrame, settings: SelectionSettings, lambda_limit: float
) -> pd.DataFrame:
    """Table of advice: a row an operating point of the map of cage slip.

    Args:
        cage_slip: Table of cage slip.
        settings: `selection` of the settings.
        lambda_limit: Full film above.

    Returns:
        The table; empty where an oil that the rules name was not calculated.

    Raises:
        OilfilmError: No rule applies to an operating point.
    """
    named = {oil for rule in settings.rules for oil in rule.prefer}
    oils = [oil for oil in dict.fromkeys(cage_slip["oil"]) if oil in named]
    if set(oils) < named:
        return tables.empty("slip_advice")
    places = cage_slip[PLACE].drop_duplicates().reset_index(drop=True)

    def of(column: str) -> FloatArray:
        """A column by oil and place."""
        wide = cage_slip.pivot(index=PLACE, columns="oil", values=column)
        return wide.loc[pd.MultiIndex.from_frame(places), oils].to_numpy(dtype=float).T

    slip, torque, film = of("cage_slip"), of("torque_n_m"), of("lambda_ratio")
    contacts = places.assign(
        max_hertz_pressure_gpa=np.fmax.reduce(
            [*of("inner_max_hertz_pressure_gpa"), *of("outer_max_hertz_pressure_gpa")]
        ),
        entrainment_speed_m_s=np.fmax.reduce(of("entrainment_speed_m_s")),
    )
    limit = settings.limits.slip_limit
    enough = film > lambda_limit
    within = enough & (slip <= limit)
    best = _best(slip, torque, enough, within)
    deciding, advised, start = _by_rules(contacts, oils, settings, slip, enough)
    each = np.arange(len(places))

    def chosen(values: FloatArray, oil: IntArray) -> FloatArray:
        return np.where(oil >= 0, values[oil, each], np.nan)

    advised_slip, best_slip = chosen(slip, advised), chosen(slip, best)
    advised_torque, best_torque = chosen(torque, advised), chosen(torque, best)
    holds, could = advised_slip <= limit, best_slip <= limit
    loss = np.where(could, advised_torque / best_torque, advised_slip / best_slip) - 1
    indifferent = loss <= settings.indifference
    judgement = np.select(
        [best < 0, advised < 0, could & ~holds, indifferent, could],
        ["no film", "rule has none", "slips", "agree", "heats more"],
        "slips more",
    )
    names = np.array([*oils, ""])
    frame = places.assign(
        oils_within_limit=["; ".join(np.compress(column, oils)) for column in within.T],
        selection_rule=np.array([rule.name for rule in settings.rules])[deciding],
        slip_that_decides=chosen(slip, start),
        advised_oil=names[advised],
        advised_cage_slip=advised_slip,
        advised_torque_n_m=advised_torque,
        best_oil=names[best],
        best_cage_slip=best_slip,
        best_torque_n_m=best_torque,
        judgement=judgement,
    )
    return tables.conform(frame[tables.columns("slip_advice")], "slip_advice", "slip advice")


def _best(slip: FloatArray, torque: FloatArray, enough: BoolArray, within: BoolArray) -> IntArray:
    """Place of the oil that holds the cage at the least torque, or slips least; -1 without film."""
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
    """Of each place the rule that decides, the oil it advises, and that of the rules at no slip."""
    limit, each = settings.limits.slip_limit, np.arange(len(contacts))

    def sayings(ratio: FloatArray) -> tuple[IntArray, IntArray]:
        slipping = contacts.assign(slide_roll_ratio=ratio)
        said = Sayings(settings.rules, oils, states(slipping, settings.limits), enough)
        deciding = said.deciding(slipping)
        return deciding, said.advice[deciding, each]

    _, start = sayings(np.zeros(len(contacts)))
    deciding, advised = sayings(np.where(start >= 0, slip[start, each], 0.0))
    # "4050 is recommended, and if necessary, lubricant 4102": necessary while the cage still slips
    prefer = [[oils.index(oil) for oil in rule.prefer] for rule in settings.rules]
    for place in each[(advised >= 0) & ~(slip[advised, each] <= limit)]:
        others = [oil for oil in prefer[deciding[place]] if enough[oil, place]]
        holding = [oil for oil in others if slip[oil, place] <= limit]
        advised[place] = holding[0] if holding else others[-1]
    return deciding, advised, start
