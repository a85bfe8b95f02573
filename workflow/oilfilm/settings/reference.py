"""Printed constants of the paper, read from data/reference."""

from pathlib import Path

import numpy as np

from oilfilm.errors import OilfilmError
from oilfilm.settings.load import load_checked
from oilfilm.traction.law import FloatArray


def printed_constants(path: Path) -> dict[str, FloatArray]:
    """The twelve printed constants of each oil, signs restored, in the law's order.

    Raises:
        OilfilmError: The file is missing or has a mistake.
    """
    oils = load_checked(path, "printed_coefficients")["oils"]
    return {
        oil: np.array([*blocks["A"], *blocks["B"], *blocks["C"]]) for oil, blocks in oils.items()
    }


def falling_viscosity(path: Path) -> list[str]:
    """The oils with printed constants, the most viscous first.

    Raises:
        OilfilmError: The file has a mistake, or the list names other oils than `oils`.
    """
    content = load_checked(path, "printed_coefficients")
    order = [str(oil) for oil in content["falling_viscosity"]]
    if sorted(order) != sorted(content["oils"]):
        raise OilfilmError(
            f"{path}: `falling_viscosity` names {', '.join(order)}, `oils` has "
            f"{', '.join(content['oils'])}; both must have the same oils, each once."
        )
    return order
