"""The command `oilfilm bearing`: torque, power loss, cage slip and best oil of a bearing."""

import argparse

import numpy as np

from oilfilm.api.bearing_torque import bearing_torque
from oilfilm.api.folders import config_folder
from oilfilm.cli.arguments import campaign_folder, json_line, quantity


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    results_folder, _ = campaign_folder(options.results)
    loads_n = [quantity(text, "N", "--load") for text in options.load]
    speeds_rpm = [quantity(text, "rpm", "--speed") for text in options.speed]
    temperatures_c = [quantity(text, "degC", "--temperature") for text in options.temperature]
    # all combinations, one operating point per number
    meshes = np.meshgrid(loads_n, speeds_rpm, temperatures_c, indexing="ij")
    load_n, speed_rpm, temperature_c = (mesh.ravel() for mesh in meshes)
    answer = bearing_torque(
        options.bearing,
        load_n,
        speed_rpm,
        temperature_c,
        oil=options.oil or "",
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
