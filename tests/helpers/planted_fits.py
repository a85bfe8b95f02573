"""Fits with planted constants: as tables, as tables of the printed constants, and with refits."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from campaigns import printed, rows
from oilfilm.fits.conditions import FixedCondition, StepPartner
from oilfilm.fits.fitted import Coefficients, FittedLaw
from oilfilm.traction import PAPER_LAW
from oilfilm.traction.law import Law, bounds, to_constants

TESTED = {
    "max_hertz_pressure_gpa": (1.0, 1.5),
    "entrainment_speed_m_s": (25.0, 40.0),
    "inlet_temperature_c": (25.0, 120.0),
    "slide_roll_ratio": (0.0, 0.3),
}


def planted_tables(
    law: Law, oils: Mapping[str, Mapping[str, float]], **of_quality: Any
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Tables of coefficients and fit quality of oils whose constants are planted.

    Args:
        law: The law.
        oils: Constants by name, for each oil.
        of_quality: Further columns of the table of fit quality.
    """
    ends = {
        f"tested_{end}_{name}": value
        for name, pair in TESTED.items()
        for end, value in zip(("min", "max"), pair, strict=True)
    }
    coefficients, quality = [], []
    for oil, constants in oils.items():
        oil_and_law = {"oil": oil, "law": law.name}
        quality.append({**oil_and_law, **ends, **of_quality})
        for name, value in constants.items():
            verdict = "not identifiable" if np.isnan(value) else "known"
            constant = {"constant": name, "value": value, "verdict": verdict}
            coefficients.append({**oil_and_law, **constant})
    constants_table = rows("coefficients", *coefficients, flag=True)
    return constants_table, rows("fit_quality", *quality, flag=True)


def printed_fits() -> tuple[pd.DataFrame, pd.DataFrame]:
    """Tables of coefficients and fit quality that hold the printed constants."""
    names = [constant.name for constant in PAPER_LAW.constants]
    oils = {oil: dict(zip(names, values, strict=True)) for oil, values in printed().items()}
    return planted_tables(PAPER_LAW, oils)


def fits_of(coefficients: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """A table of coefficients with the fit quality that says which law is configured."""
    laws = coefficients[["oil", "law"]].drop_duplicates().to_dict("records")
    quality = rows("fit_quality", *({"configured": True, **law} for law in laws))
    return {"coefficients": coefficients, "fit_quality": quality}


def planted_fit(law: Law) -> tuple[FittedLaw, float, int]:
    """A fit that does not follow the speed, which varied in step with load or pressure.

    Returns:
        The fit, and factor and power by which the law's first condition goes with the pressure.
    """
    random, ends = np.random.default_rng(9), bounds(law)
    # thick and thin films, refits scattered by 5 %
    internal = ends[:, 0] + (ends[:, 1] - ends[:, 0]) * random.uniform(0.4, 0.6, len(ends))
    given = [constant.prescribed is not None for constant in law.constants]
    internal = np.where(given, law.prescribed, internal)
    scattered = internal + np.where(given, 0, 0.05) * random.standard_normal((30, len(ends)))
    factor, power = (42.0, 3) if "load_n" in law.conditions else (1.0, 1)
    box = np.array([[1.0, 1.5], [25.0, 40.0], [25.0, 120.0], [0.0, 0.3]])
    box[0] = factor * box[0] ** power
    line = StepPartner(law.conditions[0], box[0].mean(), 0.5)
    speed = FixedCondition("entrainment_speed_m_s", 32.0, 2.0, (line,))
    spread, known = to_constants(law, scattered), np.array([True, False, True])
    constants = to_constants(law, internal)
    fit = Coefficients(constants, known, spread, spread[:3], box, (speed,), degrees_of_freedom=20.0)
    return FittedLaw(law, fit), factor, power
