"""The edges of the library: SI inside, GPa, um, degC and rpm outside; converted only here.

Decides: which units are converted, and into which.
"""

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import yaml

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IndexArray = npt.NDArray[np.int64]

PA_PER_GPA = 1e9
M_PER_UM = 1e-6
MM_PER_M = 1e3
RAD_S_PER_RPM = np.pi / 30
ABSOLUTE_ZERO_C = -273.15
# The median absolute deviation of a normal distribution times this is its standard deviation.
MAD_TO_SIGMA = 1.4826


def rpm_to_surface_speed(speed_rpm: FloatArray, radius_m: float) -> FloatArray:
    """Surface speed in m/s of a body turning at `speed_rpm`, at `radius_m` from its axis."""
    return np.asarray(speed_rpm) * RAD_S_PER_RPM * radius_m


def surface_speed_to_rpm(speed_m_s: FloatArray, radius_m: float) -> FloatArray:
    """Rotational speed in rpm that gives `speed_m_s` at `radius_m` from the axis."""
    return np.asarray(speed_m_s) / radius_m * (1 / RAD_S_PER_RPM)


@dataclass(frozen=True)
class Conversion:
    """value in `unit` = scale * logged value + offset."""

    unit: str
    scale: float = 1.0
    offset: float = 0.0

    def of(self, values: FloatArray) -> FloatArray:
        """Logged values in `unit`."""
        if self.scale == 1 and self.offset == 0:
            return values
        return self.scale * values + self.offset


# Words, each perhaps to a power of one digit, and products of them. A unit comes out of a file, and
# pint would compute whatever else is in it, 10**10**10 too.
_FACTOR = r"(?:1|%|[^\W\d]+)(?:(?:\^|\*\*)-?\d|\u207b?[\u00b9\u00b2\u00b3])?"
_PLAIN = re.compile(rf"{_FACTOR}(?:\s*[*/\u00b7\s]\s*{_FACTOR})*")
_LONGEST = 40


def conversion(unit: str, targets: tuple[str, ...]) -> Conversion:
    """How a logged unit becomes the first of `targets` that it measures the same quantity as.

    Args:
        unit: Unit as a log writes it: N, kgf, lbf, rpm, rad/s, degC, K, degF, m/s, mm/s, GPa ...
        targets: Units that the caller can use.

    Raises:
        ValueError: The unit is unknown or measures something else.
    """
    if (found := possible_conversion(unit, targets)) is None:
        raise ValueError(
            f"the unit {unit[:_LONGEST]!r} is none of {' or '.join(targets)}, nor converts to one"
        )
    return found


@cache
def possible_conversion(unit: str, targets: tuple[str, ...]) -> Conversion | None:
    """The same; None where there is none."""
    if unit in targets:
        return Conversion(unit)
    spelling = _spellings().get(unit.strip().lower(), unit.strip())
    for target in targets if len(spelling) <= _LONGEST and _PLAIN.fullmatch(spelling) else ():
        try:
            at_zero, at_one = (_measured(value, spelling, target) for value in (0.0, 1.0))
        except Exception:  # noqa: S112  (pint raises a dozen unrelated kinds)
            continue
        return Conversion(target, at_one - at_zero, at_zero)
    return None


@cache
def _spellings() -> dict[str, str]:
    """What pint reads, by what logs write."""
    known = yaml.safe_load(Path(__file__).with_name("units.yaml").read_text(encoding="utf-8"))
    return {spelling: unit for unit, spellings in known.items() for spelling in spellings}


def _measured(value: float, unit: str, target: str) -> float:
    """A value of one unit in another."""
    registry = _registry()
    quantity = registry.Quantity(value, unit)
    turns, counts = ("radian" in str(registry.get_root_units(name)[1]) for name in (target, unit))
    # of a spindle, a plain frequency counts revolutions; pint would take it for radians
    if turns and not counts:
        quantity = quantity * registry.revolution
    return float(quantity.to(target).magnitude)


@cache
def _registry() -> Any:
    # imported where needed: logs in the project's own units do not pay for it
    import pint  # noqa: PLC0415

    return pint.UnitRegistry()
