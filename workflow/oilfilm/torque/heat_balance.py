"""What the oil's own heating changes: torque, cage slip, film, and the oil that is best.

Every other table has the oil of the contacts at its inlet temperature. Here it is as warm as the
balance of heat makes it, where the bearing's file has the flow of its oil.

Decides: what heating of the oil changes.
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.bearing.friction import Neighbour, friction_equilibrium
from oilfilm.bearing.geometry import Bearing, OilSupply
from oilfilm.bearing.heat_balance import heat_balance
from oilfilm.settings.base import present
from oilfilm.settings.resolved import Settings
from oilfilm.torque.bearing_torque import Cases, OilInBearing, joined
from oilfilm.torque.best_oil import best_oils
from oilfilm.units import RAD_S_PER_RPM, FloatArray, IndexArray

_POINT = ["inner_speed_rpm", "axial_load_n", "inlet_temperature_c"]
_COMPARED = ["torque_n_m", "cage_slip", "lambda_ratio"]


def heat_balance_table(
    oils: Sequence[OilInBearing], cage_slip: pd.DataFrame, torque: pd.DataFrame, settings: Settings
) -> pd.DataFrame:
    """Each point of the map of cage slip and each measured plateau with heated oil.

    Args:
        oils: Oils with their laws.
        cage_slip: Table of cage slip.
        torque: Table of torque; the rows of the law of pressure are taken.
        settings: The settings.

    Returns:
        The table; empty where the flow of oil is not known.
    """
    campaign = present(settings.campaign.torque, "torque", "the campaign")
    keys = settings.bearings[campaign.bearing].oil_supply
    if keys is None or not oils:
        return tables.empty("heat_balance")
    supply, bearing = keys.supply(), settings.tested_bearing()
    plateaus = torque[torque["load_variable"] == "stress"]
    points = pd.concat([cage_slip.assign(run_id="", first_row=0), plateaus], ignore_index=True)
    heated = pd.concat(
        [_heated(oil, bearing, points[points["oil"] == oil.name], supply) for oil in oils],
        ignore_index=True,
    )
    frame = points.merge(heated, on=["run_id", "first_row", "oil", *_POINT], suffixes=("", "_hot"))
    frame = frame.rename(columns={f"{name}_hot": f"heated_{name}" for name in _COMPARED})
    on_map = frame["run_id"] == ""
    for column, slip in (
        ("best_oil", cage_slip),
        ("heated_best_oil", heated[heated["run_id"] == ""]),
    ):
        limits = settings.selection.limits.slip_limit, settings.gates.lambda_limit
        best = best_oils(slip, *limits)[[*_POINT, "best_oil"]]
        of_point = frame[_POINT].merge(best, on=_POINT, how="left")["best_oil"]
        frame[column] = of_point.fillna("").where(on_map, "")
    return joined([frame], "heat_balance")


def _heated(
    oil: OilInBearing, bearing: Bearing, points: pd.DataFrame, supply: OilSupply
) -> pd.DataFrame:
    """Friction of one oil's points with the oil as warm as it makes itself."""
    speed, _, inlet = points[_POINT].to_numpy(dtype=float).T
    cold = Cases(bearing, [(oil, "stress", points[_POINT])]).problem
    known = friction_equilibrium(cold)
    latest = Neighbour.of(cold, known.solution.unknowns)

    def heat_w(contact_temperature_c: FloatArray, which: IndexArray) -> FloatArray:
        """Friction heat, found near the motion of the last temperature."""
        heat = np.full(len(which), np.nan)
        solved = known.solution.converged[which] & np.isfinite(contact_temperature_c)
        if len(which := which[solved]):
            warmed = contact_temperature_c[solved]
            now = points[_POINT].iloc[which].assign(inlet_temperature_c=warmed)
            problem = Cases(bearing, [(oil, "stress", now)]).problem
            found = friction_equilibrium(problem, latest.at(which))
            good = found.solution.converged
            latest.unknowns[which[good]] = found.solution.unknowns[good]
            power = found.torque_n_m() * speed[which] * RAD_S_PER_RPM
            heat[solved] = np.where(good, power, np.nan)
        return heat

    balance = heat_balance(heat_w, oil.oil, supply, inlet)
    warm = np.where(balance.balanced, balance.contact_temperature_c, inlet)
    at = points[_POINT].assign(inlet_temperature_c=warm)
    terms = Cases(bearing, [(oil, "stress", at)]).run(latest)
    terms.loc[~balance.balanced, _COMPARED] = np.nan
    own = points[["run_id", "first_row", "oil", "bearing", "pitch_speed_mm_rpm", *_POINT]]
    return own.reset_index(drop=True).assign(
        **terms[_COMPARED],
        balanced=balance.balanced,
        heat_w=terms["torque_n_m"] * speed * RAD_S_PER_RPM,
        contact_temperature_c=balance.contact_temperature_c,
        outlet_temperature_c=balance.outlet_temperature_c,
    )
