"""The law with the constants that the paper prints.

Decides: the law that the paper prints, where it was tested, and what its lost signs leave open.
"""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd

from deng2026_study.settings import default_settings
from oilfilm.base.errors import OilfilmError
from oilfilm.base.home import reference_file
from oilfilm.base.ties import first_largest
from oilfilm.base.units import FloatArray
from oilfilm.fits.fitted import Coefficients, FittedLaw
from oilfilm.settings.config import Box
from oilfilm.settings.messages import load
from oilfilm.traction.laws.deng2026 import DENG2026, traction_coefficient
from simulated_lab.printed import PrintedCoefficients

# Slips at which the widest range over the open signs is searched. The first one is the rig's
# smallest step.
_SEARCHED_SLIPS = (0.01, 0.05, 0.3)


@dataclass(frozen=True, repr=False)
class PrintedLaw(FittedLaw):
    """The law with printed constants: no intervals, but the range over signs that are open.

    Attributes:
        sign_certainty: How sure the sign of each exponent is, by the name of the constant: certain,
            probable, open, or without effect.
    """

    sign_certainty: Mapping[str, str] = field(default_factory=dict)

    @property
    def why_no_interval(self) -> str:
        """See `FittedLaw`."""
        return "the paper states none"

    def remarks(self, conditions: FloatArray, slip: FloatArray) -> list[str]:
        """See `FittedLaw`."""
        signs = ", ".join(f"{name} {certainty}" for name, certainty in self.sign_certainty.items())
        (low,), (high,) = self.mu_range_over_open_signs(conditions, slip)
        return [f"restored signs: {signs}", f"over the open signs mu is {low:.5f} to {high:.5f}"]

    def mu_range_over_open_signs(
        self, conditions: FloatArray, slide_roll_ratio: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest mu over all combinations of the open signs; other signs are as in use.

        Args:
            conditions: P in GPa, U in m/s and T in degC, shape (points, 3).
            slide_roll_ratio: S, shape (points,).

        Returns:
            Each of shape (points,).
        """
        constant_names = [constant.name for constant in self.law.constants]
        open_sign_indices = [constant_names.index(name) for name in self.names_of_open_signs()]
        pressure_gpa, speed_m_s, temperature_c = np.asarray(conditions, dtype=float).T
        slip = np.abs(slide_roll_ratio)
        mu_of_signs = []
        for sign_factors in itertools.product((1.0, -1.0), repeat=len(open_sign_indices)):
            constants = self.coefficients.constants.copy()
            constants[open_sign_indices] *= sign_factors
            mu_of_signs.append(
                traction_coefficient(constants, pressure_gpa, speed_m_s, temperature_c, slip)
            )
        signed_ends = np.sign(slide_roll_ratio) * np.array(
            [np.min(mu_of_signs, axis=0), np.max(mu_of_signs, axis=0)]
        )
        return signed_ends.min(axis=0), signed_ends.max(axis=0)

    def names_of_open_signs(self) -> list[str]:
        """Names of the constants whose sign is open."""
        return [name for name, certainty in self.sign_certainty.items() if certainty == "open"]


def printed_law(printed_coefficients: PrintedCoefficients, oil: str, tested_box: Box) -> PrintedLaw:
    """The printed law of one oil, with the paper's tested box and what its lost signs leave open.

    Args:
        printed_coefficients: Content of data/reference/printed_coefficients.yaml.
        oil: Name of one of its oils.
        tested_box: What the paper's abstract says was tested (`printed.boxes.tested`).
    """
    ends_by_name = tested_box.model_dump()
    column_names = [*DENG2026.conditions, "slide_roll_ratio"]
    box = np.array([ends_by_name[name] for name in column_names], dtype=float)
    coefficients = replace(
        Coefficients.from_constants(DENG2026, printed_coefficients.constants_by_oil()[oil]),
        tested_box=box,
    )
    law = PrintedLaw(
        DENG2026, coefficients, sign_certainty=printed_coefficients.sign_certainties(oil)
    )
    names_of_open_signs = law.names_of_open_signs()
    if not names_of_open_signs:
        return law
    searched_points = np.array(list(itertools.product(*box[:-1], _SEARCHED_SLIPS)))
    lower, upper = law.mu_range_over_open_signs(searched_points[:, :-1], searched_points[:, -1])
    widest_index = int(first_largest(upper / lower))
    condition_text = "{:g} GPa, {:g} m/s, {:g} degC, S {:g}".format(*searched_points[widest_index])
    sentence = (
        f"the signs of {', '.join(names_of_open_signs)} were lost and are open: over them mu is "
        f"{lower[widest_index]:.2g} to {upper[widest_index]:.2g} at {condition_text}"
    )
    return replace(law, warnings=(sentence,))


def printed(oil: str | int) -> PrintedLaw:
    """The law with the constants that the paper prints for an oil: tested box, but no intervals.

    Args:
        oil: 4102, 4050 or 4010.

    Returns:
        The law; `sign_certainty` says how sure each restored sign is, and
        `mu_range_over_open_signs` gives the lowest and the highest mu over those that are open.

    Raises:
        OilfilmError: The paper prints no constants of it.

    Reference: Deng et al. (2026), Eqs 11-13; lost signs as in data/reference.

    Examples:
        >>> law = printed("4102")
        >>> print(f"{law.predict_at(1.0, 20.0, 20.0, 0.05).traction_coefficient:.4f}")
        0.0204
    """
    printed_coefficients = load(reference_file("printed_coefficients"), PrintedCoefficients)
    if str(oil) not in printed_coefficients.oils:
        printed_oils = ", ".join(printed_coefficients.falling_viscosity)
        raise OilfilmError(
            f"the paper prints no constants of {oil!r}; it prints those of {printed_oils}."
        )
    return printed_law(printed_coefficients, str(oil), default_settings().printed.boxes.tested)


def add_printed_values(
    coefficients: pd.DataFrame, printed_coefficients: PrintedCoefficients
) -> pd.DataFrame:
    """The table of coefficients with the column `printed_value`, null where nothing is printed.

    It is null too for an exponent of which only combinations with others were tested (`in step`).

    Args:
        coefficients: Table of coefficients.
        printed_coefficients: Content of data/reference/printed_coefficients.yaml.
    """
    constant_names = [constant.name for constant in DENG2026.constants]
    printed_value_by_key = {}
    for oil, constants in printed_coefficients.constants_by_oil().items():
        for name, constant in zip(constant_names, constants, strict=True):
            printed_value_by_key[printed_coefficients.law, oil, name] = constant
    keys = zip(coefficients["law"], coefficients["oil"], coefficients["constant"], strict=True)
    values = pd.Series(
        [printed_value_by_key.get(key, np.nan) for key in keys], coefficients.index, dtype=float
    )
    return coefficients.assign(printed_value=values.mask(coefficients["verdict"] == "in step"))
