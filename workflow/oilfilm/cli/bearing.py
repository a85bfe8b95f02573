"""The command `oilfilm bearing`: torque, power loss, cage slip and best oil of a bearing."""

import argparse

import numpy as np

from oilfilm.api.bearing_torque import bearing_torque
from oilfilm.api.folders import config_folder
from oilfilm.cli.arguments import campaign_folder, json_line, quantity


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    folder, _ = campaign_folder(options.results)
    load, speed, temperature = (
        np.array([quantity(text, unit, option) for text in texts])
        for texts, unit, option in (
            (options.load, "N", "--load"),
            (options.speed, "rpm", "--speed"),
            (options.temperature, "degC", "--temperature"),
        )
    )
    mesh = np.meshgrid(load, speed, temperature, indexing="ij")
    load, speed, temperature = (values.ravel() for values in mesh)
    answer = bearing_torque(
        options.bearing,
        load,
        speed,
        temperature,
        oil=options.oil or "",
        results=folder,
        config=config_folder(options.config),
    )
    if not options.json:
        print(answer.summary())
        return 0
    for row in answer.to_frame().to_dict("records"):
        with_nulls = {
            str(name): None if value is None or value != value else value  # noqa: PLR0124 - NaN
            for name, value in row.items()
        }
        print(json_line({**with_nulls, "about": answer.about}))
    return 0
