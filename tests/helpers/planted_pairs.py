"""Two oils whose ratio of mu is known: one times a factor, two of a family, two that are unlike.

The sizes that are expected of a ratio were chosen while pairs on `own`, `jt`, `sol`, `wav` and
`glass_step` were seen; those on the other truths were not.
"""

from dataclasses import dataclass

from lawless_truths import TRUTHS, LawlessTruth
from oilfilm.base.units import FloatArray

PLANTED_RATIO = 1.04


@dataclass(frozen=True)
class OilPair:
    """Two truths.

    Attributes:
        first: mu of the first oil.
        second: mu of the second oil.
    """

    first: LawlessTruth
    second: LawlessTruth

    def ratio(self, conditions: FloatArray, slip: FloatArray) -> FloatArray:
        """mu of the second oil over that of the first, shape (points,)."""
        return self.second(*conditions.T, slip) / self.first(*conditions.T, slip)


def scaled_oil(truth: LawlessTruth, factor: float = PLANTED_RATIO) -> LawlessTruth:
    """An oil with the same shape of all curves and `factor` times the traction."""

    def scaled(pressure, speed, temperature, slip):
        return factor * truth(pressure, speed, temperature, slip)

    return scaled


def related_oil(truth: LawlessTruth) -> LawlessTruth:
    """An oil of the same family: as if it were 4 K colder, and other conditions differed too."""

    def shifted(pressure, speed, temperature, slip):
        return 1.02 * truth(1.03 * pressure, 0.95 * speed, temperature - 4, 1.05 * slip)

    return shifted


PLANTED = {f"{name} x 1.04": OilPair(TRUTHS[name], scaled_oil(TRUTHS[name])) for name in TRUTHS}
RELATED = {f"{name}, relative": OilPair(TRUTHS[name], related_oil(TRUTHS[name])) for name in TRUTHS}
UNRELATED = {
    f"{first}, {second}": OilPair(TRUTHS[first], TRUTHS[second])
    for first, second in (("rat", "wav"), ("mix", "sol"), ("limited_eyring", "heated_tanh"))
}
