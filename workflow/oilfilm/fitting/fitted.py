"""A fitted law, read back from the table of coefficients."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from oilfilm.traction import LAWS
from oilfilm.traction.law import FloatArray, Law, Observations, to_internal


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

        A fit without exponents knows the tested condition only and gives the curve there.
        """
        if np.isnan(self.constants).any():
            return self.law.curve(self.local, slip)
        curve = np.zeros(len(slip), dtype=np.int64)
        at = Observations(self.law.design(conditions), curve, slip)
        return self.law.traction(to_internal(self.law, self.constants), at)
