"""Units at the edges of the library: SI inside, GPa, um, degC and rpm outside.

Laws, fits and surfaces take GPa, m/s and degC, as their constants do. Units of logs and of typed
numbers are converted only here.

Decides: which units are converted, and into which (other spellings of a unit: `units.yaml`).
"""

import math
import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import yaml

# Types of arrays of any shape. An `IndexArray` has whole numbers: indices, counts and signs.
FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IndexArray = npt.NDArray[np.int64]

PA_PER_GPA = 1e9
M_PER_UM = 1e-6
MM_PER_M = 1e3
RAD_S_PER_RPM = np.pi / 30
ABSOLUTE_ZERO_C = -273.15
# No unit, but a factor that many modules need: the median absolute deviation of a normal
# distribution times this is its standard deviation.
MAD_TO_SIGMA = 1.4826


def rpm_to_surface_speed(speed_rpm: FloatArray, radius_m: float) -> FloatArray:
    """Surface speed in m/s of a body turning at `speed_rpm`, at `radius_m` from its axis."""
    return np.asarray(speed_rpm) * RAD_S_PER_RPM * radius_m


def surface_speed_to_rpm(speed_m_s: FloatArray, radius_m: float) -> FloatArray:
    """Rotational speed in rpm that gives `speed_m_s` at `radius_m` from the axis."""
    return np.asarray(speed_m_s) / radius_m * (1 / RAD_S_PER_RPM)


@dataclass(frozen=True)
class Conversion:
    """Conversion of logged values: value in `unit` = scale * logged value + offset."""

    unit: str
    scale: float = 1.0
    offset: float = 0.0

    def convert(self, values: FloatArray) -> FloatArray:
        """Logged values in `unit`."""
        if self.scale == 1 and self.offset == 0:
            return values
        return self.scale * values + self.offset


# A product of words, each of which may have a power of one digit. A unit comes from a file, and
# pint would compute any expression in it, such as 10**10**10. Of the escapes, 00b9, 00b2, 00b3 and
# 207b are superscript 1, 2, 3 and minus; 00b7 is a raised dot.
_FACTOR = r"(?:1|%|[^\W\d]+)(?:(?:\^|\*\*)-?\d|\u207b?[\u00b9\u00b2\u00b3])?"
_PRODUCT = re.compile(rf"{_FACTOR}(?:\s*[*/\u00b7\s]\s*{_FACTOR})*")
_BARE_EXPONENT = re.compile(r"([^\W\d_])(-?\d)")
_MAX_UNIT_LETTERS = 40
# Scale by unit and target unit. The registry of all units takes a third of a second to load. These
# pairs do not need it.
_USUAL_SCALE_BY_UNITS = {
    ("kN", "N"): 1e3,
    ("kPa", "Pa"): 1e3,
    ("%", "1"): 0.01,
    ("%", "dimensionless"): 0.01,
}


def conversion(unit: str, target_units: tuple[str, ...]) -> Conversion:
    """The conversion of a logged unit to the first target unit that measures the same quantity.

    A unit that is one of `target_units` is kept.

    Args:
        unit: Unit as a log writes it: N, kgf, lbf, rpm, rad/s, degC, K, degF, m/s, mm/s, GPa ...
        target_units: Units that the caller can use.

    Raises:
        ValueError: The unit is unknown or measures something else.
    """
    to_target = possible_conversion(unit, target_units)
    if to_target is None:
        raise ValueError(
            f"the unit {unit[:_MAX_UNIT_LETTERS]!r} is none of {' or '.join(target_units)}, nor "
            "converts to one"
        )
    return to_target


@cache
def possible_conversion(unit: str, target_units: tuple[str, ...]) -> Conversion | None:
    """As `conversion`, but None where there is none."""
    if unit in target_units:
        return Conversion(unit)
    for target_unit in target_units:
        if (unit, target_unit) in _USUAL_SCALE_BY_UNITS:
            return Conversion(target_unit, _USUAL_SCALE_BY_UNITS[unit, target_unit])
    spelling = unit.strip()
    pint_unit_by_spelling = _pint_unit_by_spelling()
    pint_unit = pint_unit_by_spelling.get(spelling) or pint_unit_by_spelling.get(
        spelling.lower(), spelling
    )
    # mm s-1 (ISO 80000) and N/mm2 are read by pint as mm s^-1 and N/mm^2
    pint_unit = _BARE_EXPONENT.sub(r"\1^\2", pint_unit)
    if len(pint_unit) > _MAX_UNIT_LETTERS or not _PRODUCT.fullmatch(pint_unit):
        return None
    for target_unit in target_units:
        try:
            converted_zero = _converted(0.0, pint_unit, target_unit)
            converted_one = _converted(1.0, pint_unit, target_unit)
            converted_two = _converted(2.0, pint_unit, target_unit)
        except Exception:  # noqa: S112  (pint raises a dozen unrelated kinds)
            continue
        scale = converted_one - converted_zero
        # decibels are no multiple of a number
        if math.isclose(converted_two - converted_one, scale):
            return Conversion(target_unit, scale, offset=converted_zero)
    return None


@cache
def _pint_unit_by_spelling() -> dict[str, str]:
    """The name that pint knows a unit by, for each spelling in logs."""
    file = Path(__file__).with_name("units.yaml")
    spellings_by_unit = yaml.safe_load(file.read_text(encoding="utf-8"))
    pint_unit_by_spelling = {}
    for pint_unit, spellings in spellings_by_unit.items():
        for spelling in spellings:
            pint_unit_by_spelling[spelling] = pint_unit
    return pint_unit_by_spelling


def _converted(value: float, unit: str, target_unit: str) -> float:
    """A value in `unit`, converted to `target_unit`."""
    registry = _registry()
    quantity = registry.Quantity(value, unit)
    base_units = str(registry.get_root_units(unit)[1])
    if "count" in base_units:
        raise ValueError("pulses of an encoder are no revolutions, and no number of anything else")
    # a unit of rotation, such as rpm, has radians among its base units. A plain frequency of a
    # spindle counts revolutions; pint would take it for radians
    is_of_rotation = "radian" in str(registry.get_root_units(target_unit)[1])
    if is_of_rotation and "radian" not in base_units:
        quantity = quantity * registry.revolution
    return float(quantity.to(target_unit).magnitude)


@cache
def _registry() -> Any:
    # imported late: logs in the project's own units do not need it
    import pint  # noqa: PLC0415

    return pint.UnitRegistry()
