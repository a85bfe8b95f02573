"""Printed constants of the paper, read from data/reference."""

from pathlib import Path

import numpy as np

from oilfilm.config import load_checked
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
