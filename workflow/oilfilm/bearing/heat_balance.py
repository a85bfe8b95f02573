"""Lumped heat balance of a bearing: how hot its oil leaves it, and how hot the contacts are.

Decides: how hot the oil of a bearing becomes.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from oilfilm.bearing.geometry import OilSupply
from oilfilm.physics.contact import Floats
from oilfilm.physics.oils import Oil
from oilfilm.units import BoolArray, FloatArray, IndexArray

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
