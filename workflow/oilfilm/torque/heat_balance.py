"""What the oil's own heating changes: torque, cage slip, film, and the oil that is best.

Every other table has the oil of the contacts at its inlet temperature. Here it is as warm as the
lumped balance of heat makes it, where the bearing's file has the flow of its oil.

Decides: how hot the oil of a bearing becomes; what heating of the oil changes.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.bearing.equilibria import Neighbour, friction_equilibrium
from oilfilm.bearing.geometry import Bearing, OilSupply
from oilfilm.physics.contact import Floats
from oilfilm.physics.oils import Oil
from oilfilm.settings.base import present
from oilfilm.settings.resolved import Settings
from oilfilm.torque.bearing_torque import Cases, OilInBearing, joined
from oilfilm.torque.best_oil import best_oils
from oilfilm.units import RAD_S_PER_RPM, BoolArray, FloatArray, IndexArray

# No oil of a bearing is a liquid beyond it.
_HOTTEST_C = 400.0
# Heat that may be left over, relative; more means that the heat jumps where it should balance.
_LARGEST_ERROR = 1e-6
_TOLERANCE_K = 1e-9


@dataclass(frozen=True)
class HeatBalance:
    """The balance of each point; NaN where none was found; shapes (points,).

    Attributes:
        outlet_temperature_c: Of the oil that leaves the bearing.
        contact_temperature_c: Of the oil in the contacts.
        balanced: True where the oil takes its share of the heat, to 1e-6 of it.
    """

    outlet_temperature_c: FloatArray
    contact_temperature_c: FloatArray
    balanced: BoolArray


def heat_to_oil_w(
    oil: Oil, supply: OilSupply, inlet_temperature_c: Floats, outlet_temperature_c: Floats
) -> FloatArray:
    """Heat that a flow of oil carries away.

        Q = rho(T_in) V c_p(T_mean) (T_out - T_in),   T_mean = (T_in + T_out)/2

    Args:
        oil: The oil.
        supply: Its flow V, at the inlet.
        inlet_temperature_c: T_in, in degC.
        outlet_temperature_c: T_out, in degC.

    Returns:
        Q, in W.

    Validity: steady flow of liquid oil. The mean c_p is exact where c_p is linear in temperature.

    Reference: first law of thermodynamics for a steady flow.
    """
    mean = (np.asarray(inlet_temperature_c) + outlet_temperature_c) / 2
    mass_flow = oil.density_kg_m3(inlet_temperature_c) * supply.flow_m3_s
    rise = np.asarray(outlet_temperature_c) - inlet_temperature_c
    return np.asarray(mass_flow * oil.specific_heat_j_kgk(mean) * rise)


def heat_balance(
    friction_heat_w: Callable[[FloatArray, IndexArray], FloatArray],
    oil: Oil,
    supply: OilSupply,
    inlet_temperature_c: FloatArray,
) -> HeatBalance:
    """Where the oil carries away its share of the heat that arises with oil so warm.

        heat_share H(T_c) = Q(T_out),   T_c = T_in + outlet_weight (T_out - T_in)

    Hot oil is thin and makes less heat, so that the heat falls while the cooling rises: there is
    one such temperature, unless the motion jumps from rolling to skidding on the way.

    Args:
        friction_heat_w: H in W of the points with these numbers, from the oil's temperature in
            the contacts, both of one shape.
        oil: The oil.
        supply: Its flow.
        inlet_temperature_c: T_in of each point, shape (points,).

    Returns:
        The balance; none where the oil would leave at more than 400 degC.
    """
    points = np.arange(len(inlet_temperature_c))

    def contact_c(rise: FloatArray, which: IndexArray) -> FloatArray:
        return np.asarray(inlet_temperature_c[which] + supply.outlet_weight * rise)

    def left_over_w(rise: FloatArray, which: IndexArray) -> FloatArray:
        inlet = inlet_temperature_c[which]
        made = supply.heat_share * friction_heat_w(contact_c(rise, which), which)
        return heat_to_oil_w(oil, supply, inlet, inlet + rise) - made

    at_inlet = -left_over_w(np.zeros(len(points)), points)
    # with cool oil's heat and heat capacity the oil leaves warmer than it does
    per_kelvin = heat_to_oil_w(oil, supply, inlet_temperature_c, inlet_temperature_c + 1)
    highest = np.minimum(1.5 * at_inlet / per_kelvin + 1, _HOTTEST_C - inlet_temperature_c)
    # late, as most jobs read the settings of a bearing and balance no heat
    from scipy.optimize import elementwise  # noqa: PLC0415

    found = elementwise.find_root(
        left_over_w,
        (np.zeros(len(points)), highest),
        args=(points,),
        tolerances={"xatol": _TOLERANCE_K, "frtol": 1e-3 * _LARGEST_ERROR},
    )
    scale = np.maximum(np.abs(at_inlet), np.finfo(float).tiny)
    # nothing is heated where nothing turns
    balanced = (at_inlet == 0) | (found.success & (np.abs(found.f_x) <= _LARGEST_ERROR * scale))
    rise = np.where(balanced, np.where(at_inlet == 0, 0.0, found.x), np.nan)
    return HeatBalance(inlet_temperature_c + rise, contact_c(rise, points), balanced)


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
            found = friction_equilibrium(problem, latest.at_points(which))
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
