"""The law with the constants that the paper prints.

Decides: the law that the paper prints.
"""

import numpy as np
import pandas as pd

from oilfilm.errors import OilfilmError
from oilfilm.fits.fitted import Coefficients, FittedLaw
from oilfilm.home import reference_file
from oilfilm.paper.reference import PrintedCoefficients, printed_constants
from oilfilm.traction.laws.deng2026 import DENG2026


def printed(oil: str | int) -> FittedLaw:
    """The law with the constants that the paper prints for an oil: no intervals, no tested box.

    Args:
        oil: 4102, 4050 or 4010.

    Raises:
        OilfilmError: The paper prints no constants of it.

    Reference: Deng et al. (2026), Eqs 11-13; lost signs as in data/reference.

    Examples:
        >>> law = printed("4102")
        >>> print(f"{law.predict_at(1.0, 20.0, 20.0, 0.05).traction_coefficient:.4f}")
        0.0204
    """
    constants = printed_constants(reference_file("printed_coefficients"))
    if (name := str(oil)) not in constants:
        raise OilfilmError(f"the paper prints no constants of {oil!r}; of {', '.join(constants)}.")
    return FittedLaw(DENG2026, Coefficients.bare(DENG2026, constants[name]))


def with_printed(coefficients: pd.DataFrame, printed: PrintedCoefficients) -> pd.DataFrame:
    """The table of coefficients with `printed_value`, the printed constant; null where none is.

    An exponent that was tested along a line of conditions alone has none to compare with.
    """
    names = [constant.name for constant in DENG2026.constants]
    known = {
        (printed.law, oil, name): value
        for oil, values in printed.constants().items()
        for name, value in zip(names, values, strict=True)
    }
    keys = zip(coefficients["law"], coefficients["oil"], coefficients["constant"], strict=True)
    values = pd.Series([known.get(key, np.nan) for key in keys], coefficients.index, dtype=float)
    return coefficients.assign(printed_value=values.mask(coefficients["verdict"] == "in step"))
