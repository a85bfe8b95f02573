"""Effect of the oil's heating on torque, cage slip, film and the best oil.

In all other tables the oil of the contacts has its inlet temperature. Here its temperature follows
from a lumped heat balance, if the bearing's file states the oil flow.

Decides: how hot the oil of a bearing becomes; what heating of the oil changes.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.base.units import RAD_S_PER_RPM, BoolArray, FloatArray, IndexArray
from oilfilm.bearing.equilibria import NearbyEquilibria, friction_equilibrium
from oilfilm.bearing.geometry import Bearing, OilSupply
from oilfilm.bearing.inputs import InputValues
from oilfilm.physics.contact import Floats
from oilfilm.physics.oils import Oil
from oilfilm.settings.base import required_value
from oilfilm.settings.resolved import Settings
from oilfilm.torque.bearing_torque import CaseGroup, FrictionCases, OilInBearing, stack_tables
from oilfilm.torque.best_oil import best_oil_table

# Highest temperature of an oil in a bearing; no oil is a liquid above.
_HIGHEST_OIL_TEMPERATURE_C = 400.0
# Largest relative error of a heat balance. A larger error means that the heat jumps there.
_LARGEST_RELATIVE_ERROR = 1e-6
# Tolerance of the temperature rise.
_TOLERANCE_K = 1e-9


@dataclass(frozen=True)
class HeatBalance:
    """Heat balance of each point, NaN without a balance; shapes (points,).

    Attributes:
        outlet_temperature_c: Temperature of the oil that leaves the bearing.
        contact_temperature_c: Temperature of the oil in the contacts.
        is_balanced: True where the oil takes its share of the heat, with a relative error below
            1e-6.
    """

    outlet_temperature_c: FloatArray
    contact_temperature_c: FloatArray
    is_balanced: BoolArray


def heat_to_oil_w(
    oil: Oil, supply: OilSupply, inlet_temperature_c: Floats, outlet_temperature_c: Floats
) -> FloatArray:
    """Heat that a flow of oil carries away.

        Q = rho(T_in) V c_p(T_mean) (T_out - T_in),   T_mean = (T_in + T_out)/2

    Args:
        oil: The oil.
        supply: Oil supply with the flow V at the inlet.
        inlet_temperature_c: Inlet temperature T_in, in degC.
        outlet_temperature_c: Outlet temperature T_out, in degC.

    Returns:
        Q, in W.

    Validity: steady flow of liquid oil. The mean c_p is exact where c_p is linear in temperature.

    Reference: first law of thermodynamics for a steady flow.
    """
    mean_temperature_c = (np.asarray(inlet_temperature_c) + outlet_temperature_c) / 2
    mass_flow_kg_s = oil.density_kg_m3(inlet_temperature_c) * supply.flow_m3_s
    rise_k = np.asarray(outlet_temperature_c) - inlet_temperature_c
    return np.asarray(mass_flow_kg_s * oil.specific_heat_j_kgk(mean_temperature_c) * rise_k)


def heat_balance(
    friction_heat_w: Callable[[FloatArray, IndexArray], FloatArray],
    oil: Oil,
    supply: OilSupply,
    inlet_temperature_c: FloatArray,
) -> HeatBalance:
    """Temperatures at which the oil carries away its share of the friction heat.

        heat_share H(T_c) = Q(T_out),   T_c = T_in + outlet_weight (T_out - T_in)

    Hot oil is thin and causes less friction heat. The heat decreases with temperature, the cooling
    increases. Hence there is one balance, unless the motion jumps from rolling to skidding.

    Args:
        friction_heat_w: Function that returns the friction heat H, in W. Its arguments are the
            temperature of the oil in the contacts, in degC, and the indices of the points, of the
            same shape.
        oil: The oil.
        supply: The oil supply.
        inlet_temperature_c: Inlet temperature T_in of each point, shape (points,).

    Returns:
        The balance. A point has none if the oil would leave at more than 400 degC.
    """
    all_point_indices = np.arange(len(inlet_temperature_c))

    def contact_temperature_at_rise_c(rise_k: FloatArray, point_index: IndexArray) -> FloatArray:
        """Temperature (degC) of the oil in the contacts at this rise of the oil."""
        return np.asarray(inlet_temperature_c[point_index] + supply.outlet_weight * rise_k)

    def excess_cooling_w(rise_k: FloatArray, point_index: IndexArray) -> FloatArray:
        """Heat taken by the oil less its share of the friction heat; 0 in the balance."""
        inlet_c = inlet_temperature_c[point_index]
        friction_heat_to_oil_w = supply.heat_share * friction_heat_w(
            contact_temperature_at_rise_c(rise_k, point_index), point_index
        )
        return heat_to_oil_w(oil, supply, inlet_c, inlet_c + rise_k) - friction_heat_to_oil_w

    heat_at_inlet_w = -excess_cooling_w(np.zeros(len(all_point_indices)), all_point_indices)
    # heat and heat capacity at the inlet temperature overestimate the rise
    heat_per_kelvin_w = heat_to_oil_w(oil, supply, inlet_temperature_c, inlet_temperature_c + 1)
    largest_rise_k = 1.5 * heat_at_inlet_w / heat_per_kelvin_w + 1
    largest_rise_k = np.minimum(largest_rise_k, _HIGHEST_OIL_TEMPERATURE_C - inlet_temperature_c)
    # imported here because most jobs import this module and calculate no heat balance
    from scipy.optimize import elementwise  # noqa: PLC0415

    root = elementwise.find_root(
        excess_cooling_w,
        (np.zeros(len(all_point_indices)), largest_rise_k),
        args=(all_point_indices,),
        tolerances={"xatol": _TOLERANCE_K, "frtol": 1e-3 * _LARGEST_RELATIVE_ERROR},
    )
    heat_scale_w = np.maximum(np.abs(heat_at_inlet_w), np.finfo(float).tiny)
    is_without_heat = heat_at_inlet_w == 0
    is_solved = root.success & (np.abs(root.f_x) <= _LARGEST_RELATIVE_ERROR * heat_scale_w)
    is_balanced = is_without_heat | is_solved
    rise_k = np.where(is_balanced, np.where(is_without_heat, 0.0, root.x), np.nan)
    return HeatBalance(
        inlet_temperature_c + rise_k,
        contact_temperature_at_rise_c(rise_k, all_point_indices),
        is_balanced,
    )


_POINT_COLUMNS = ["inner_speed_rpm", "axial_load_n", "inlet_temperature_c"]
# Columns that the table has for oil at its inlet temperature and for heated oil.
_COMPARED_COLUMNS = ["torque_n_m", "cage_slip", "lambda_ratio"]


def heat_balance_table(
    oils: Sequence[OilInBearing],
    cage_slip_table: pd.DataFrame,
    torque_table: pd.DataFrame,
    settings: Settings,
) -> pd.DataFrame:
    """Every point of the cage-slip map and every measured plateau with heated oil.

    Args:
        oils: Oils with their laws.
        cage_slip_table: Table of cage slip.
        torque_table: Table of torque. Rows with the load variable `stress` are used.
        settings: The settings.

    Returns:
        The table `heat_balance`; empty if the oil flow is not known.
    """
    torque_test = required_value(settings.campaign.torque, "torque", "the campaign")
    oil_supply = settings.bearings[torque_test.bearing].oil_supply
    if oil_supply is None or not oils:
        return tables.empty_table("heat_balance")
    supply = oil_supply.supply()
    bearing = settings.tested_bearing()
    plateaus = torque_table[torque_table["load_variable"] == "stress"]
    # points of the map have no run
    points = pd.concat(
        [cage_slip_table.assign(run_id="", first_row=0), plateaus], ignore_index=True
    )
    heated_results = pd.concat(
        [
            _friction_with_heated_oil(oil, bearing, points[points["oil"] == oil.name], supply)
            for oil in oils
        ],
        ignore_index=True,
    )
    with_heated_oil = points.merge(
        heated_results, on=["run_id", "first_row", "oil", *_POINT_COLUMNS], suffixes=("", "_hot")
    )
    with_heated_oil = with_heated_oil.rename(
        columns={f"{name}_hot": f"heated_{name}" for name in _COMPARED_COLUMNS}
    )
    with_heated_oil["best_oil"] = _best_oil_of_rows(with_heated_oil, cage_slip_table, settings)
    heated_map_results = heated_results[heated_results["run_id"] == ""]
    with_heated_oil["heated_best_oil"] = _best_oil_of_rows(
        with_heated_oil, heated_map_results, settings
    )
    return stack_tables([with_heated_oil], "heat_balance")


def _best_oil_of_rows(
    heat_balance_rows: pd.DataFrame, cage_slip_table: pd.DataFrame, settings: Settings
) -> "pd.Series[str]":
    """Best oil at the operating point of each row; empty for measured plateaus.

    Args:
        heat_balance_rows: Rows of the table `heat_balance`.
        cage_slip_table: Results at the points of the map, from which the best oil follows.
        settings: Limits of cage slip and film.
    """
    slip_limit = settings.bearing.cage_slip.slip_limit
    best_oil_of_point = best_oil_table(cage_slip_table, slip_limit, settings.gates.lambda_limit)
    best_oil_names = heat_balance_rows[_POINT_COLUMNS].merge(
        best_oil_of_point[[*_POINT_COLUMNS, "best_oil"]], on=_POINT_COLUMNS, how="left"
    )["best_oil"]
    return best_oil_names.fillna("").where(heat_balance_rows["run_id"] == "", "")


def _heated_cases(
    oil: OilInBearing, bearing: Bearing, points: pd.DataFrame, contact_temperature_c: FloatArray
) -> FrictionCases:
    """Operating points with the oil of the contacts at another temperature than at the inlet.

    The mass flow of the feed oil is that at the inlet, where its volume flow is stated.

    Args:
        oil: The oil.
        bearing: The bearing.
        points: Operating points with the temperature at the inlet.
        contact_temperature_c: Temperature of the oil in the contacts, shape (points,).
    """
    inlet_temperature_c = points["inlet_temperature_c"].to_numpy(dtype=float)
    inlet_density_kg_m3 = oil.properties.density_kg_m3(inlet_temperature_c)
    volume_ratio = inlet_density_kg_m3 / oil.properties.density_kg_m3(contact_temperature_c)
    inputs = InputValues.nominal(
        {**bearing.uncertain_inputs, **oil.bearing_settings.uncertain_inputs()}, len(points)
    )
    heated_points = points[_POINT_COLUMNS].assign(inlet_temperature_c=contact_temperature_c)
    return FrictionCases(
        bearing,
        [CaseGroup(oil, "stress", heated_points)],
        replace(inputs, feed_flow_m3_s=inputs.feed_flow_m3_s * volume_ratio),
    )


def _friction_with_heated_oil(
    oil: OilInBearing, bearing: Bearing, points: pd.DataFrame, supply: OilSupply
) -> pd.DataFrame:
    """Friction at the points of one oil, with the oil at the temperature of its heat balance."""
    speed_rpm, _, inlet_c = points[_POINT_COLUMNS].to_numpy(dtype=float).T
    inlet_problem = FrictionCases(
        bearing, [CaseGroup(oil, "stress", points[_POINT_COLUMNS])]
    ).problem
    inlet_equilibrium = friction_equilibrium(inlet_problem)
    # the motion at the last temperature of each point
    latest_equilibria = NearbyEquilibria.from_unknowns(
        inlet_problem, inlet_equilibrium.solution.unknowns
    )

    def friction_heat_w(contact_temperature_c: FloatArray, point_index: IndexArray) -> FloatArray:
        """Friction heat by the equilibrium near the motion at the last temperature."""
        heat_w = np.full(len(point_index), np.nan)
        can_be_solved = inlet_equilibrium.solution.converged[point_index] & np.isfinite(
            contact_temperature_c
        )
        solvable_index = point_index[can_be_solved]
        if len(solvable_index) == 0:
            return heat_w
        problem = _heated_cases(
            oil, bearing, points.iloc[solvable_index], contact_temperature_c[can_be_solved]
        ).problem
        equilibrium = friction_equilibrium(problem, latest_equilibria.at_points(solvable_index))
        converged = equilibrium.solution.converged
        latest_equilibria.unknowns[solvable_index[converged]] = equilibrium.solution.unknowns[
            converged
        ]
        power_w = equilibrium.torque_n_m() * speed_rpm[solvable_index] * RAD_S_PER_RPM
        heat_w[can_be_solved] = np.where(converged, power_w, np.nan)
        return heat_w

    balance = heat_balance(friction_heat_w, oil.properties, supply, inlet_c)
    balanced_temperature_c = np.where(balance.is_balanced, balance.contact_temperature_c, inlet_c)
    calculated = _heated_cases(oil, bearing, points, balanced_temperature_c).calculate(
        latest_equilibria
    )
    calculated.loc[~balance.is_balanced, _COMPARED_COLUMNS] = np.nan
    key_columns = points[
        ["run_id", "first_row", "oil", "bearing", "pitch_speed_mm_rpm", *_POINT_COLUMNS]
    ]
    return key_columns.reset_index(drop=True).assign(
        **calculated[_COMPARED_COLUMNS],
        balanced=pd.Series(balance.is_balanced, dtype="boolean").where(
            inlet_equilibrium.solution.converged
        ),
        heat_w=calculated["torque_n_m"] * speed_rpm * RAD_S_PER_RPM,
        contact_temperature_c=balance.contact_temperature_c,
        outlet_temperature_c=balance.outlet_temperature_c,
    )
