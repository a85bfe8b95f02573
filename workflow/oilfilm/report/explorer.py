"""What the explorer of the report computes with: laws, intervals, the tested box, the sliders.

`page.js` evaluates there what `FittedLaw.predict` evaluates here, with the script that
`law_script` writes from the laws themselves. The covariance travels as its root, so that the page
needs no linear algebra.

Decides: what the explorer computes with.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.fits.conditions import LEAST_SIZE, FixedCondition
from oilfilm.fits.fitted import FittedLaw
from oilfilm.report.colours import oil_colour
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.operating_grid import AXES
from oilfilm.traction.law import Law, to_internal
from oilfilm.units import FloatArray

LEVEL = 0.95
_LOAD = "load_n"
_STEPS = 100  # of a slider, at least
# Symbol, label and unit.
LABELS = {
    "max_hertz_pressure_gpa": ("P", "Maximum Hertz pressure", "GPa"),
    "entrainment_speed_m_s": ("U", "Entrainment speed", "m/s"),
    "inlet_temperature_c": ("T", "Inlet temperature", "\N{DEGREE SIGN}C"),
    "slide_roll_ratio": ("S", "Slide-roll ratio", ""),
}


@dataclass(frozen=True)
class Axis:
    """One of P, U, T and S: a slider, or the abscissa.

    Attributes:
        name: Column of the table of points.
        low: Smallest value of the slider.
        high: Largest value.
        step: Distance between its values.
        steps: How many of them.
        digits: Decimals that every value has.
        start: Value it begins with.
        idle: True where no fit follows it: it was tested at one level, or is not known.
    """

    name: str
    low: float
    high: float
    step: float
    steps: int
    digits: int
    start: float
    idle: bool = False

    @classmethod
    def over(cls, name: str, low: float, high: float, start: float, idle: bool = False) -> "Axis":
        """A slider from `low` to `high` at least, by a power of ten of at least 100 steps."""
        span = high - low or abs(low) or 1.0
        # a step above `low` would begin at zero, where a power law has no value
        widest = min(span / _STEPS, low) if low > 0 else span / _STEPS
        power = int(np.floor(np.log10(widest)))
        step, digits = 10.0**power, max(0, -power)
        first, last = np.floor(low / step + 1e-9), np.ceil(high / step - 1e-9)
        low, high, start = (
            round(float(value), digits) for value in (first * step, last * step, start)
        )
        return cls(name, low, high, step, int(last - first), digits, start, idle)


def explorer(results: CampaignTables, settings: Settings) -> dict[str, Any]:
    """Everything that the explorer needs, as plain values for JSON.

    Args:
        results: Tables `points`, `coefficients`, `refits` and `fit_quality`.
        settings: All settings of the campaign.
    """
    load_n = load_at_1_gpa(settings)
    fits = explored_fits(results, load_n)
    nearby = settings.report.nearby.model_dump()
    axes = []
    for axis in sliders(fits, results.points, settings):
        symbol, label, unit = LABELS[axis.name]
        relative = f"{axis.name}_relative" in nearby
        near = nearby[f"{axis.name}_relative" if relative else axis.name]
        axes.append(
            asdict(axis)
            | {"symbol": symbol, "label": label, "unit": unit, "nearby": near, "relative": relative}
        )
    return {
        "axes": axes,
        "oils": [
            {
                "name": oil,
                "colour": oil_colour(oil, list(settings.oils)),
                "where": [fixed.sentence() for fixed in fit.coefficients.fixed],
                **law_of(fit, load_n),
            }
            for oil, fit in fits.items()
        ],
    }


def load_at_1_gpa(settings: Settings) -> float | None:
    """Load of the rig's contact at 1 GPa; None where the contact is not known, or not one."""
    contact = settings.common_contact()
    return None if contact is None else float(contact.load_n(1.0))


def explored_fits(results: CampaignTables, load_at_1_gpa: float | None) -> dict[str, FittedLaw]:
    """The fits of the configured law that can be evaluated at P, U, T and S, by oil."""
    fits = {
        str(oil): FittedLaw.of_configured(results, oil)
        for oil in results.configured.fit_quality["oil"]
    }
    return {
        oil: fit
        for oil, fit in fits.items()
        if not np.isnan(fit.coefficients.constants).any()
        and (load_at_1_gpa is not None or _LOAD not in fit.law.conditions)
    }


def sliders(fits: Mapping[str, FittedLaw], points: pd.DataFrame, settings: Settings) -> list[Axis]:
    """Sliders over everything tested, and over what the paper draws where that is near.

    Args:
        fits: By oil.
        points: Table of points.
        settings: All settings of the campaign.
    """
    load_n, paper = load_at_1_gpa(settings), settings.printed.boxes.extrapolated
    centre = _central(points[points["accepted"]])
    boxes = np.array([_over_axes(fit.coefficients.box, fit.law, load_n) for fit in fits.values()])
    axes = []
    for index, name in enumerate(AXES):
        low, high = getattr(paper, name)
        tested = boxes.reshape(-1, len(AXES), 2)[:, index]
        tested = tested[~np.isnan(tested).any(axis=1)]
        if len(tested):
            inner, outer = tested[:, 0].min(), tested[:, 1].max()
            near = inner <= high and outer >= low
            low, high = (min(low, inner), max(high, outer)) if near else (inner, outer)
        start = float(np.clip(centre.get(name, low), low, high))
        follow = name == "slide_roll_ratio" or any(
            fit.coefficients.known[index] for fit in fits.values()
        )
        axes.append(Axis.over(name, low, high, start, idle=not follow))
    return axes


def _central(points: pd.DataFrame) -> dict[str, float]:
    """Conditions of the accepted point nearest to the middle of all, so that some are shown."""
    known = points[list(AXES)].dropna(axis="columns", how="all").dropna()
    if known.empty:
        return {}
    low, high = known.min(), known.max()
    width = (high - low).where(high > low, 1.0)
    distance = (((known - (low + high) / 2) / width) ** 2).sum(axis="columns")
    nearest = known.iloc[int(distance.to_numpy().argmin())]
    return {str(name): float(value) for name, value in nearest.items()}


def law_of(fit: FittedLaw, load_at_1_gpa: float | None = None) -> dict[str, Any]:
    """A fitted law with its interval and its tested box, as the page computes with it.

    Args:
        fit: The fit.
        load_at_1_gpa: Load of the rig's contact at 1 GPa, which laws on load need; it goes with
            the cube of the pressure.
    """
    law, coefficients = fit.law, fit.coefficients
    band, _, level = coefficients.bands(law, LEVEL)
    inputs: list[dict[str, Any]] = [
        {"axis": axis, "factor": 1.0, "power": 1, "reference": reference}
        for axis, reference in enumerate(law.reference)
    ]
    if _LOAD in law.conditions:
        inputs[0] |= {"factor": load_at_1_gpa, "power": 3}
    return {
        "law": law.name,
        "inputs": inputs,
        "internal": to_internal(law, coefficients.constants).tolist(),
        "known": coefficients.known.tolist(),
        "fixed": [_fixed_over_axes(fixed, law, load_at_1_gpa) for fixed in coefficients.fixed],
        "level": _plain(level),
        "limit": coefficients.limiting_stress_ratio,
        "lattice": _lattice(fit, load_at_1_gpa) if len(coefficients.tested) else [],
        "two_levels": [_ends_of(name, fit, load_at_1_gpa) for name in coefficients.two_levels],
        "band": None
        if np.isnan(band.reach).any()
        else {**asdict(band), "reach": band.reach.T.tolist()},
        "box": [list(map(_plain, ends)) for ends in _over_axes(fit.reach, law, load_at_1_gpa)],
    }


def _lattice(fit: FittedLaw, load_at_1_gpa: float | None) -> list[dict[str, Any]]:
    """Tested levels of each followed axis, by curve, and their largest step.

    A step of the logarithm of the load is three of that of the pressure.
    """
    _, steps = fit.lattice
    fixed = {each.condition for each in fit.coefficients.fixed}
    followed = [(axis, name) for axis, name in enumerate(fit.law.conditions) if name not in fixed]
    tested = fit.coefficients.tested
    axes = []
    for (axis, name), step in zip(followed, steps, strict=True):
        values, power = tested[:, axis], 1
        if name == _LOAD and load_at_1_gpa is not None:
            values, power = np.cbrt(values / load_at_1_gpa), 3
        if np.isfinite(step):
            shown = {"axis": axis, "log": name not in LEAST_SIZE, "step": float(step) / power}
            axes.append({**shown, "tested": values.tolist()})
    return axes


def _ends_of(name: str, fit: FittedLaw, load_at_1_gpa: float | None) -> dict[str, Any]:
    """The two tested levels of a condition; a load is the cube of the pressure on its axis."""
    axis, on_load = fit.law.conditions.index(name), name == _LOAD and load_at_1_gpa is not None
    low, high = fit.coefficients.box[axis] / (load_at_1_gpa if on_load else 1.0)
    return {"axis": axis, "power": 3 if on_load else 1, "low": low, "high": high}


def _over_axes(box: FloatArray, law: Law, load_at_1_gpa: float | None) -> FloatArray:
    """A box of the law's conditions over P, U, T and S: the load is the cube of P."""
    if _LOAD not in law.conditions or load_at_1_gpa is None:
        return box
    return np.vstack([np.cbrt(box[:1] / load_at_1_gpa), box[1:]])


def _fixed_over_axes(
    fixed: FixedCondition, law: Law, load_at_1_gpa: float | None
) -> dict[str, Any]:
    """Where a condition without exponent was tested, over P, U and T; load is the cube of P."""

    def along(condition: str, value: float | None) -> tuple[int, int, float]:
        axis, level = law.conditions.index(condition), np.nan if value is None else value
        if condition != _LOAD or load_at_1_gpa is None:
            return axis, 1, level
        return axis, 3, float(np.cbrt(level / load_at_1_gpa))

    axis, power, level = along(fixed.condition, fixed.level)
    in_step = []
    for other in fixed.in_step:
        on_axis, other_power, centre = along(other.condition, other.centre)
        exponent = other.exponent * other_power / power
        in_step.append({"axis": on_axis, "centre": centre, "exponent": exponent})
    return {
        "axis": axis,
        "level": _plain(level),
        "within": fixed.within / power,
        "least_size": LEAST_SIZE.get(fixed.condition, 0.0),
        "in_step": in_step,
    }


def _plain(value: float) -> float | None:
    """A number that JSON has; None for NaN and infinity."""
    return float(value) if np.isfinite(value) else None
