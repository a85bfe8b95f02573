"""What the explorer of the report computes with: laws, intervals, points, films, rules.

`page.js` does there what `FittedLaw.predict` and `selection.select` do here; the tests hold the two
against each other. So that the page needs neither the oils' formulas nor linear algebra, it is
given the covariance as its root, and the film at each step of the temperature's slider.

Decides: what the explorer computes with.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.fits.conditions import LEAST_SIZE, FixedCondition
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.interval import normal_quantile
from oilfilm.physics.film import THERMAL_REDUCTION_FIT, InletOil
from oilfilm.report.colours import oil_colour
from oilfilm.settings.config import Box, NearbySettings
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.operating_grid import AXES, Film, Grid, films, obstacle
from oilfilm.traction.law import Law, to_internal
from oilfilm.units import PA_PER_GPA, FloatArray

LEVEL = 0.95
_LOAD = "load_n"
_STEPS = 100  # of a slider, at least
_LABELS = {
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
        step: Distance between its values.
        steps: How many of them.
        start: Value it begins with.
        idle: True where no fit follows it: it was tested at one level, or is not known.
    """

    name: str
    low: float
    step: float
    steps: int
    start: float
    idle: bool = False

    @property
    def digits(self) -> int:
        """Decimals that every value of the slider has."""
        return _digits(self.step)

    @property
    def values(self) -> FloatArray:
        """Every value of the slider, rounded as the page rounds it."""
        return np.round(self.low + self.step * np.arange(self.steps + 1), self.digits)

    @classmethod
    def over(cls, name: str, low: float, high: float, start: float, idle: bool = False) -> "Axis":
        """A slider from `low` to `high` at least, by a power of ten of at least 100 steps."""
        span = high - low or abs(low) or 1.0
        # a step above `low` would begin at zero, where a power law has no value
        widest = min(span / _STEPS, low) if low > 0 else span / _STEPS
        step = float(10.0 ** np.floor(np.log10(widest)))
        first, last = np.floor(low / step + 1e-9), np.ceil(high / step - 1e-9)
        low, start = (round(float(value), _digits(step)) for value in (first * step, start))
        return cls(name, low, step, int(last - first), start, idle)


def _digits(step: float) -> int:
    """Decimals of a power of ten."""
    return max(0, -int(np.floor(np.log10(step))))


def explorer(results: CampaignTables, settings: Settings) -> dict[str, Any]:
    """Everything that the explorer needs, as plain values for JSON.

    Args:
        results: Tables `points`, `coefficients` (of one law), `refits` and `fit_quality`.
        settings: All settings of the campaign.
    """
    points = results.points
    fits = {
        oil: FittedLaw.of_configured(results, oil) for oil in results.configured.fit_quality["oil"]
    }
    contact = settings.common_contact()
    load_n = None if contact is None else float(contact.load_n(1.0))  # at 1 GPa
    lacking = {oil: _lacking(fit, load_n) for oil, fit in fits.items()}
    shown = {oil: fit for oil, fit in fits.items() if not lacking[oil]}
    accepted = points[points["accepted"]]
    boxes = {oil: _box_over_axes(fit, load_n) for oil, fit in shown.items()}
    axes = _axes(shown, boxes, accepted, settings.printed.boxes.extrapolated)
    known = films(settings)
    nearby = settings.report.nearby
    chosen = _thinned(accepted[accepted["oil"].isin(shown)], settings.report.points_max)
    return {
        "axes": [_axis(axis, nearby) for axis in axes],
        "factor": normal_quantile(LEVEL),
        "oils": [
            {
                "name": oil,
                "colour": oil_colour(oil, list(settings.oils)),
                **law_of(fit, load_n),
                "usable": obstacle(fit),
                "film": _film(known[oil], axes[2].values) if oil in known else None,
                "points": _points(chosen[chosen["oil"] == oil]),
            }
            for oil, fit in shown.items()
        ],
        # the rules name certain oils only
        "advised": "paper" in settings.campaign.studies
        and any(oil in shown for rule in settings.selection.rules for oil in rule.prefer),
        "lacking": [{"oil": oil, "why": why} for oil, why in lacking.items() if why],
        "points": {"shown": len(chosen), "accepted": len(accepted)},
        "selection": {
            **settings.selection.model_dump(include={"rules", "indifference", "reading"}),
            "limits": {
                **settings.selection.limits.model_dump(),
                "slide_roll_ratio": settings.selection.slide_roll_ratio_limit,
                "fast_from_m_s": settings.selection.fast_from_m_s,
            },
            "lambda_limit": settings.gates.lambda_limit,
        },
    }


def _lacking(fit: FittedLaw, load_at_1_gpa: float | None) -> str:
    """Why the explorer cannot show a fit; empty where it can."""
    if np.isnan(fit.coefficients.constants).any():
        return "nothing could be fitted"
    if _LOAD in fit.law.conditions and load_at_1_gpa is None:
        return f"the law {fit.law.name} needs the load, and the rig's contact is not known"
    return ""


def _axes(
    fits: Mapping[str, FittedLaw],
    boxes: Mapping[str, FloatArray],
    points: pd.DataFrame,
    paper: Box,
) -> list[Axis]:
    """Sliders over everything tested, and over what the paper draws where that is near."""
    centre = _central(points)
    axes = []
    for index, name in enumerate(AXES):
        low, high = getattr(paper, name)
        ends = np.array([box[index] for box in boxes.values()]).reshape(-1, 2)
        tested = ends[~np.isnan(ends).any(axis=1)]
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


def _axis(axis: Axis, nearby: NearbySettings) -> dict[str, Any]:
    symbol, label, unit = _LABELS[axis.name]
    relative = axis.name in ("max_hertz_pressure_gpa", "entrainment_speed_m_s")
    return {
        **asdict(axis),
        "symbol": symbol,
        "label": label,
        "unit": unit,
        "high": float(axis.values[-1]),
        "digits": axis.digits,
        "nearby": getattr(nearby, f"{axis.name}_relative" if relative else axis.name),
        "relative": relative,
    }


def _box_over_axes(fit: FittedLaw, load_at_1_gpa: float | None) -> FloatArray:
    """The tested box over P, U, T and S, whatever conditions the law takes."""
    box = fit.coefficients.box.copy()
    if _LOAD in fit.law.conditions and load_at_1_gpa is not None:
        box[0] = np.cbrt(box[0] / load_at_1_gpa)
    return box


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
        "fixed": [_over_axes(fixed, law, load_at_1_gpa) for fixed in coefficients.fixed],
        "level": _plain(level),
        "two_levels": [_ends_of(name, fit, load_at_1_gpa) for name in coefficients.two_levels],
        "band": None
        if np.isnan(band.reach).any()
        else {**asdict(band), "reach": band.reach.T.tolist()},
        "box": [[_plain(end) for end in ends] for ends in _box_over_axes(fit, load_at_1_gpa)],
    }


def _ends_of(name: str, fit: FittedLaw, load_at_1_gpa: float | None) -> dict[str, Any]:
    """The two tested levels of a condition; a load is the cube of the pressure on its axis."""
    axis = fit.law.conditions.index(name)
    low, high = fit.coefficients.box[axis]
    factor = load_at_1_gpa if name == _LOAD else 1.0
    return {
        "axis": axis,
        "power": 3 if name == _LOAD else 1,
        "low": low / factor,
        "high": high / factor,
    }


def _over_axes(fixed: FixedCondition, law: Law, load_at_1_gpa: float | None) -> dict[str, Any]:
    """Where a condition without exponent was tested, over P, U and T; load is the cube of P."""

    def along(condition: str, value: float) -> tuple[int, int, float]:
        axis = law.conditions.index(condition)
        if condition != _LOAD or load_at_1_gpa is None:
            return axis, 1, value
        return axis, 3, float(np.cbrt(value / load_at_1_gpa))

    axis, power, level = along(fixed.condition, np.nan if fixed.level is None else fixed.level)
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
        "where": fixed.sentence(),
    }


def _film(film: Film, temperatures_c: FloatArray) -> dict[str, Any]:
    """lambda without inlet heating at 1 GPa and 1 m/s, its powers of both, and the heating.

    Every isothermal film is a power law of pressure and speed; only the temperature's part has a
    form of its own.
    """
    isothermal = film.settings.model_copy(update={"thermal_reduction": False})
    cold = replace(film, settings=isothermal)
    unit, no_slip = np.ones(1), np.zeros(1)
    lambda_ratio = cold.over(Grid(unit, unit, temperatures_c, no_slip))[1].ravel()
    doubled = np.array([1.0, 2.0])
    at_100_c = Grid(doubled, doubled, np.array([100.0]), no_slip)
    powers = np.log2(cold.over(at_100_c)[1][:, :, 0, 0])
    loading = InletOil.of(film.oil, temperatures_c).thermal_loading(1.0)
    heated = film.settings.thermal_reduction
    return {
        "lambda": [_plain(value) for value in lambda_ratio],
        "pressure_power": float(powers[1, 0] - powers[0, 0]),
        "speed_power": float(powers[0, 1] - powers[0, 0]),
        "loading": [_plain(value) for value in loading] if heated else [],
        "reduction": asdict(THERMAL_REDUCTION_FIT),
        "modulus_gpa": film.contact.reduced_modulus_pa / PA_PER_GPA,
        "stand_in": film.oil.stand_in,
    }


def _thinned(points: pd.DataFrame, most: int) -> pd.DataFrame:
    """At most so many points, evenly chosen."""
    return points.iloc[:: -(-len(points) // most)] if len(points) > most else points


def _points(points: pd.DataFrame) -> dict[str, list[Any]]:
    """Columns of numbers; each point's run by its number among the runs."""
    run, runs = pd.factorize(points["run_id"])
    names = (*AXES, "traction_coefficient", "traction_coefficient_se")
    numbers = {name: [_plain(value) for value in points[name]] for name in names}
    return {**numbers, "run": run.tolist(), "runs": runs.tolist()}


def _plain(value: float) -> float | None:
    """A number that JSON has; None for NaN and infinity."""
    return float(value) if np.isfinite(value) else None
