"""A fitted law, read back from the table of coefficients."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from oilfilm.traction import LAWS
from oilfilm.traction.law import CONDITIONS, FloatArray, Law, Observations, to_internal


@dataclass(frozen=True)
class FittedLaw:
    """A law with fitted constants; `local` holds A, B, C where exponents are not identifiable.

    Where nothing could be fitted, both are NaN and so is the traction.
    """

    law: Law
    constants: FloatArray
    local: FloatArray

    @classmethod
    def of(cls, coefficients: pd.DataFrame, oil: str) -> "FittedLaw":
        """The fit of one oil; the table must hold one law for it."""
        rows = coefficients[coefficients["oil"] == oil].set_index("constant")
        law = LAWS[rows["law"].iloc[0]]
        values = rows["value"].reindex([constant.name for constant in law.constants])
        local = rows["value"].reindex(list(law.local_constants))
        return cls(law, values.to_numpy(), local.to_numpy())

    def traction(self, conditions: FloatArray, slip: FloatArray) -> FloatArray:
        """mu against slip at one (P in GPa, U in m/s, T in degC), shape of `slip`.

        A fit that lacks the exponents of a condition knows its tested level only: whatever level
        is asked for, the curve there is given.
        """
        constants, known = self.constants, np.ones(len(CONDITIONS), dtype=bool)
        if np.isnan(self.local).all() and np.isnan(constants).any():
            return np.full(len(slip), np.nan)
        if np.isnan(constants).any():
            heads = [constant.condition is None for constant in self.law.constants]
            constants = np.where(np.isnan(constants), 0.0, constants)
            constants[heads] = self.local
            exponents = dict(
                zip([one.condition for one in self.law.constants], self.constants, strict=True)
            )
            known = np.array([not np.isnan(exponents[name]) for name in CONDITIONS])
        levels = np.where(known, conditions, self.law.reference)
        curve = np.zeros(len(slip), dtype=np.int64)
        at = Observations(self.law.design(levels), curve, slip)
        return self.law.traction(to_internal(self.law, constants), at)
