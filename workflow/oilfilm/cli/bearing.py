"""The command `oilfilm bearing`: torque, power loss, cage slip and best oil of a bearing."""

import argparse

import numpy as np

from oilfilm.api.bearing_torque import bearing_torque
from oilfilm.api.folders import config_folder
from oilfilm.cli.arguments import json_line, results_and_footer, typed_quantity


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    results_folder, _ = results_and_footer(options.results)
    values_by_argument = (
        [typed_quantity(text, "N", "--load") for text in options.load],
        [typed_quantity(text, "rpm", "--speed") for text in options.speed],
        [typed_quantity(text, "degC", "--temperature") for text in options.temperature],
    )
    # Each combination is one operating point. The three arrays have one number per point.
    meshes = np.meshgrid(*values_by_argument, indexing="ij")
    axial_load_n, inner_speed_rpm, inlet_temperature_c = (mesh.ravel() for mesh in meshes)
    answer = bearing_torque(
        options.bearing,
        axial_load_n,
        inner_speed_rpm,
        inlet_temperature_c,
        oil=options.oil or "",  # "" for all oils of the campaign
        results=results_folder,
        config=config_folder(options.config),
    )
    if not options.json:
        print(answer.summary())
        return 0
    for row in answer.to_frame().to_dict("records"):
        row_with_nulls = {
            str(name): None if value is None or value != value else value  # noqa: PLR0124 - NaN
            for name, value in row.items()
        }
        print(json_line({**row_with_nulls, "about": answer.about}))
    return 0
