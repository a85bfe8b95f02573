"""Quantities of the settings, each with its unit and physical range.

The ranges are wide. They refuse a value in the wrong unit (1250 for 1.25 GPa), not an unusual rig.

Decides: unit and range of every quantity in the settings.
"""

from contextlib import suppress
from datetime import date
from itertools import pairwise
from typing import Annotated, Any, TypeVar

from pydantic import AfterValidator, Field

from oilfilm.settings.base import unexpected_value_error

T = TypeVar("T")


def _unit(unit: str) -> dict[str, Any]:
    """The unit of a quantity as an argument of `Field`."""
    return {"json_schema_extra": {"unit": unit}}


# Validators: each returns its argument, or raises an error.


def _refuse_unless_rising(values: list[Any]) -> list[Any]:
    if any(low >= high for low, high in pairwise(values)):
        raise unexpected_value_error("rising values, the smallest first")
    return values


def _refuse_falling(values: list[Any]) -> list[Any]:
    if any(low > high for low, high in pairwise(values)):
        raise unexpected_value_error("the smaller value first")
    return values


def _refuse_duplicates(values: list[Any]) -> list[Any]:
    if any(value in values[:index] for index, value in enumerate(values)):
        raise unexpected_value_error("each value once")
    return values


def _refuse_unless_calendar_day(text: str) -> str:
    with suppress(ValueError):
        if date.fromisoformat(text).isoformat() == text:
            return text
    raise unexpected_value_error("a day of the calendar, such as '2026-01-10'")


# ---------------------------------------------------------------- text

NAME_PATTERN = r"^[A-Za-z0-9_][A-Za-z0-9_.-]*$"
Name = Annotated[str, Field(pattern=NAME_PATTERN)]  # becomes part of a path
Text = Annotated[str, Field(min_length=1)]
Day = Annotated[str, AfterValidator(_refuse_unless_calendar_day)]
WebAddress = Annotated[str, Field(pattern=r"^https?://[^\s<>\"{}|\\^`]+$")]

# ---------------------------------------------------------------- lists

# One item or more.
OneOrMore = Annotated[list[T], Field(min_length=1)]
# One item or more, all different.
OneOrMoreDistinct = Annotated[OneOrMore[T], AfterValidator(_refuse_duplicates)]
# Two items or more, all different.
TwoOrMoreDistinct = Annotated[OneOrMoreDistinct[T], Field(min_length=2)]
# One to five items, all different: each has a row of panels in a figure.
UpToFiveDistinct = Annotated[OneOrMoreDistinct[T], Field(max_length=5)]
# Any number of items, all different.
AnyNumberDistinct = Annotated[list[T], AfterValidator(_refuse_duplicates)]
# One number or more, each larger than the one before.
OneOrMoreRising = Annotated[OneOrMore[T], AfterValidator(_refuse_unless_rising)]
# Lower and upper end of a range, which differ.
RisingPair = Annotated[
    list[T], Field(min_length=2, max_length=2), AfterValidator(_refuse_unless_rising)
]
# Lower and upper end of a range. They may be equal, where the value is known.
NotFallingPair = Annotated[
    list[T], Field(min_length=2, max_length=2), AfterValidator(_refuse_falling)
]

# ---------------------------------------------------------------- numbers without unit

Share = Annotated[float, Field(ge=0, le=1, **_unit("1"))]
PositiveShare = Annotated[float, Field(gt=0, le=1, **_unit("1"))]
# K_rs of SKF's starvation factor
ReplenishmentConstant = Annotated[float, Field(ge=0, le=1e-6, **_unit("1"))]
# traction in a bearing's ellipse over that in a rig's circle
EllipseFactor = Annotated[float, Field(gt=0, le=2, **_unit("1"))]
Positive = Annotated[float, Field(gt=0, **_unit("1"))]
AboveOne = Annotated[float, Field(gt=1, **_unit("1"))]
Tolerance = Annotated[float, Field(gt=0, lt=1, **_unit("1"))]  # relative: 0.03 is 3 %
SameLevel = Annotated[float, Field(ge=0, le=0.1, **_unit("1"))]  # relative; 0: only equal ones
RelativeError = Annotated[float, Field(ge=0, lt=1, **_unit("1"))]
# of a sensor: none is without error, and one of more than a fifth measures nothing
CalibrationError = Annotated[float, Field(gt=0, le=0.2, **_unit("1"))]
Factor = Annotated[float, Field(gt=0, le=1000, **_unit("1"))]
SlideRollRatio = Annotated[float, Field(gt=0, le=2, **_unit("1"))]  # over the mean speed
SlideRollRatioOrZero = Annotated[float, Field(ge=0, le=2, **_unit("1"))]
SignedSlideRollRatio = Annotated[float, Field(ge=-2, le=2, **_unit("1"))]
SlipChange = Annotated[float, Field(gt=0, le=2, **_unit("1"))]
TractionChange = Annotated[float, Field(gt=0, le=1, **_unit("1"))]  # absolute, in mu
LevelCount = Annotated[int, Field(ge=2, le=1000)]
LambdaRatio = Annotated[float, Field(ge=0, le=100, **_unit("1"))]
Gamma = Annotated[float, Field(gt=-1, lt=1, **_unit("1"))]  # of a bearing: D cos(alpha)/dm
PoissonRatio = Annotated[float, Field(ge=0, le=0.5, **_unit("1"))]
Slips = Annotated[OneOrMoreRising[SlideRollRatio], Field(max_length=50)]
# groove radius over ball diameter
GrooveCurvature = Annotated[float, Field(gt=0.5, le=1, **_unit("1"))]

# ---------------------------------------------------------------- operating conditions

PressureGpa = Annotated[float, Field(gt=0, le=10, **_unit("GPa"))]
LoadN = Annotated[float, Field(gt=0, le=1e7, **_unit("N"))]
SpeedMs = Annotated[float, Field(gt=0, le=500, **_unit("m/s"))]
PitchSpeedMmRpm = Annotated[float, Field(gt=0, le=1e8, **_unit("mm rpm"))]  # dmN
SpeedRpm = Annotated[float, Field(gt=0, le=1e6, **_unit("rpm"))]
# of an oil; above 0 because laws take powers of it, below what a temperature in K would be
TemperatureC = Annotated[float, Field(gt=0, le=250, **_unit("degC"))]
# the size of a difference, as a tolerance or a limit: never negative
TemperatureToleranceC = Annotated[float, Field(gt=0, le=50, **_unit("degC"))]
TemperatureErrorC = Annotated[float, Field(ge=0, le=50, **_unit("degC"))]
DurationS = Annotated[float, Field(gt=0, le=86400, **_unit("s"))]
DurationOrZeroS = Annotated[float, Field(ge=0, le=86400, **_unit("s"))]
ForceErrorN = Annotated[float, Field(ge=0, le=1e6, **_unit("N"))]
TorqueErrorNm = Annotated[float, Field(ge=0, le=1e6, **_unit("N m"))]

# ---------------------------------------------------------------- bodies

HollowShaftRatio = Annotated[float, Field(ge=0, lt=1, **_unit("1"))]  # 0: a solid shaft
# on diameter; never a clearance
InterferenceUm = Annotated[float, Field(ge=0, le=1000, **_unit("um"))]
# on diameter; below 0: a clearance
InterferenceOrClearanceUm = Annotated[float, Field(ge=-1000, le=1000, **_unit("um"))]
# signed: hotter or colder body
TemperatureDifferenceK = Annotated[float, Field(ge=-200, le=200, **_unit("K"))]
Expansion1K = Annotated[float, Field(ge=0, le=1e-4, **_unit("1/K"))]
FlowLMin = Annotated[float, Field(ge=0, le=1000, **_unit("L/min"))]
LengthM = Annotated[float, Field(ge=1e-6, le=10, **_unit("m"))]
BallRadiusM = Annotated[float, Field(ge=1e-4, le=0.5, **_unit("m"))]
TrackRadiusM = Annotated[float, Field(ge=1e-4, le=2, **_unit("m"))]
RoughnessUm = Annotated[float, Field(gt=0, le=2, **_unit("um"))]
YoungsModulusPa = Annotated[float, Field(ge=1e8, le=2e12, **_unit("Pa"))]
SolidDensityKgM3 = Annotated[float, Field(ge=500, le=25000, **_unit("kg/m3"))]
SolidConductivityWMK = Annotated[float, Field(gt=0, le=3000, **_unit("W/(m K)"))]
SolidHeatJM3K = Annotated[float, Field(ge=1e5, le=1e8, **_unit("J/(m3 K)"))]
