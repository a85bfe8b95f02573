"""A bearing with the true traction of a simulated campaign, beside the campaign's fitted law.

The map by the fitted law is no truth: bearings run where no rig has tested. Here bearing, oil, drag
and everything else are as in the map, and only the traction is the true one.

Decides: how far the map by the fitted law is from the truth.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pandas as pd

from oilfilm.base.units import RAD_S_PER_RPM, FloatArray
from oilfilm.bearing.ellipse import gauss_rule
from oilfilm.bearing.equilibria import friction_equilibrium
from oilfilm.bearing.friction import FrictionProblem
from oilfilm.bearing.inputs import InputValues
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.bearing.resistance import Lubrication
from oilfilm.bearing.torque import worst_lambda_ratio
from oilfilm.settings.resolved import Settings
from simulated_lab.truth import TrueTraction, true_tractions

# Quadrature nodes of the map, across and along the ellipse. A heated film is solved at each one.
_NODE_COUNTS = (8, 2)
# Columns of the map that depend on the traction.
_RESULT_COLUMNS = (
    "cage_slip",
    "torque_n_m",
    "lambda_ratio",
    "inner_max_hertz_pressure_gpa",
    "outer_max_hertz_pressure_gpa",
)


def true_problem(
    settings: Settings,
    oil: str,
    true_traction: TrueTraction,
    operating_points: tuple[FloatArray, FloatArray, FloatArray],
    node_counts: tuple[int, int],
) -> FrictionProblem:
    """The friction problem of the campaign's bearing with the true traction of an oil.

    Growth, feed oil, drag and rolling resistance are those of bearing and settings.

    Args:
        settings: The settings.
        oil: Name of the oil.
        true_traction: Its true traction.
        operating_points: Axial load (N), inner speed (rpm) and oil temperature (degC), each of
            shape (points,).
        node_counts: Numbers of quadrature nodes across and along the ellipse.
    """
    load_n, speed_rpm, temperature_c = operating_points
    bearing = settings.tested_bearing()
    rule = gauss_rule(*node_counts)
    lubrication = Lubrication.flooded(
        settings.oil_with_properties(oil),
        temperature_c,
        settings.bearing.drag_coefficient,
        settings.bearing.oil_volume_fraction,
    )
    problem = FrictionProblem(
        bearing,
        OperatingPoints.from_load_and_speed(load_n, speed_rpm * RAD_S_PER_RPM),
        lubrication,
        true_traction.local_law(rule, bearing.radius_y_m[:, np.newaxis]),
        rule,
    )
    inputs = InputValues.nominal(
        {**bearing.uncertain_inputs, **settings.bearing.uncertain_inputs()}, len(speed_rpm)
    )
    if true_traction.depends_on_ellipse:
        # such a truth knows the ellipse: it needs no factor from circle to ellipse
        inputs = replace(inputs, ellipse_factor=np.ones(len(speed_rpm)))
    return problem.with_inputs(inputs)


def true_cage_slip_map(
    cage_slip: pd.DataFrame, settings: Settings, constants_by_oil: Mapping[str, FloatArray]
) -> pd.DataFrame:
    """The map of cage slip with the true traction, and how far the map by the law is from it.

    Args:
        cage_slip: Table of cage slip, by the fitted law.
        settings: The settings of a simulated campaign.
        constants_by_oil: The printed constants of each oil.

    Returns:
        Rows of the table `true_cage_slip`. Results are null without equilibrium.
    """
    traction_by_oil = true_tractions(settings, constants_by_oil)
    maps = []
    for oil, map_of_law in cage_slip.groupby("oil", sort=False):
        point_columns = map_of_law[["axial_load_n", "inner_speed_rpm", "inlet_temperature_c"]]
        load_n, speed_rpm, temperature_c = point_columns.to_numpy(dtype=float).T
        true_traction = traction_by_oil[str(oil)]
        operating_points = (load_n, speed_rpm, temperature_c)
        equilibrium = friction_equilibrium(
            true_problem(settings, str(oil), true_traction, operating_points, _NODE_COUNTS)
        )
        # of both contacts of a ball; the conditions are the same at all nodes of an ellipse
        pressure_gpa = equilibrium.balance.conditions.select(..., 0).max_hertz_pressure_gpa
        lambda_ratio, _ = worst_lambda_ratio(equilibrium)
        true_values = (
            equilibrium.cage_slip(),
            equilibrium.torque_n_m(),
            lambda_ratio,
            *pressure_gpa.T,
        )
        converged = equilibrium.solution.converged
        result_by_column = dict(zip(_RESULT_COLUMNS, true_values, strict=True))
        converged_columns = {
            name: np.where(converged, value, np.nan) for name, value in result_by_column.items()
        }
        maps.append(
            map_of_law.assign(
                **converged_columns,
                converged=converged,
                law_cage_slip=map_of_law["cage_slip"],
                law_torque_n_m=map_of_law["torque_n_m"],
                cage_slip_inside=_is_inside(map_of_law, "cage_slip", converged_columns),
                torque_inside=_is_inside(map_of_law, "torque_n_m", converged_columns),
            )
        )
    return pd.concat(maps, ignore_index=True)


def _is_inside(
    map_of_law: pd.DataFrame, name: str, true_columns: Mapping[str, FloatArray]
) -> "pd.Series[bool]":
    """Whether the truth is in the 95 % interval of the law's result; null if one is not known."""
    true_values = pd.Series(true_columns[name], map_of_law.index)
    lower, upper = map_of_law[f"{name}_lower"], map_of_law[f"{name}_upper"]
    is_inside = (lower <= true_values) & (true_values <= upper)
    return is_inside.astype("boolean").where(true_values.notna() & lower.notna())
