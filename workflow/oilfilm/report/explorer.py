"""What the explorer of the report computes with: laws, intervals, the tested box, the sliders.

`page.js` evaluates there what `FittedLaw.predict` evaluates here, with the script that
`law_script` writes from the equations that Python evaluates. The covariance travels as its root, so
that the page needs no linear algebra.

Decides: how the explorer computes mu and its interval in the browser, and with which numbers.
"""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.base.ties import first_smallest
from oilfilm.base.units import FloatArray
from oilfilm.fits.conditions import LEAST_SIZE
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.interval import ABSOLUTE_ENDS, RELATIVE_ENDS
from oilfilm.report.words import CONDITIONS, oil_colour
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.operating_grid import AXES
from oilfilm.traction.expression import Form, Language, in_steps
from oilfilm.traction.law import Law, to_internal

LEVEL = 0.95
_LOAD = "load_n"
_STEPS = 100  # of a slider, at least


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
        low, high, start = (round(float(at), digits) for at in (first * step, last * step, start))
        return cls(name, low, high, step, int(last - first), digits, start, idle)


def explorer(results: CampaignTables, settings: Settings) -> dict[str, Any]:
    """Everything that the explorer needs, as plain values for JSON.

    Args:
        results: Tables `points`, `coefficients`, `refits` and `fit_quality`.
        settings: All settings of the campaign.
    """
    load_n = load_at_1_gpa(settings)
    fits = explored_fits(results, load_n)
    nearby, axes = settings.report.nearby.model_dump(), []
    for axis in sliders(fits, results.points, settings):
        symbol, label, unit = CONDITIONS[axis.name]
        relative = nearby.get(f"{axis.name}_relative")
        width = {"nearby": nearby.get(axis.name, relative), "relative": relative is not None}
        axes.append({**asdict(axis), "symbol": symbol, "label": label, "unit": unit, **width})
    oils = []
    for oil, fit in fits.items():
        about = {"name": oil, "colour": oil_colour(oil, list(settings.oils))}
        where = [fixed.sentence() for fixed in fit.coefficients.fixed]
        oils.append({**about, "where": where, **law_of(fit, load_n)})
    return {"axes": axes, "oils": oils}


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
    """Sliders over everything tested, and over the ranges of `report.sliders` where they overlap.

    Args:
        fits: By oil.
        points: Table of points.
        settings: All settings of the campaign.
    """
    load_n = load_at_1_gpa(settings)
    ranges = settings.report.sliders
    centre = _central(points[points["accepted"]])
    boxes = np.array([_over_axes(fit.coefficients.box, fit.law, load_n) for fit in fits.values()])
    axes = []
    for index, name in enumerate(AXES):
        low, high = getattr(ranges, name)
        tested = boxes.reshape(-1, len(AXES), 2)[:, index]
        tested = tested[~np.isnan(tested).any(axis=1)]
        if len(tested):
            inner, outer = tested[:, 0].min(), tested[:, 1].max()
            near = inner <= high and outer >= low
            low, high = (min(low, inner), max(high, outer)) if near else (inner, outer)
        start = float(np.clip(centre.get(name, low), low, high))
        followed = any(fit.coefficients.known[index] for fit in fits.values() if index < 3)
        idle = not followed and name != "slide_roll_ratio"
        axes.append(Axis.over(name, low, high, start, idle))
    return axes


def _central(points: pd.DataFrame) -> dict[str, float]:
    """Conditions of the accepted point nearest to the middle of all, so that some are shown."""
    known = points[list(AXES)].dropna(axis="columns", how="all").dropna()
    if known.empty:
        return {}
    low, high = known.min(), known.max()
    width = (high - low).where(high > low, 1.0)
    distance = (((known - (low + high) / 2) / width) ** 2).sum(axis="columns")
    nearest = known.iloc[int(first_smallest(distance))]
    return {str(name): float(value) for name, value in nearest.items()}


def law_of(fit: FittedLaw, load_at_1_gpa: float | None = None) -> dict[str, Any]:
    """A fitted law with its interval and its tested box, as the page computes with it.

    Args:
        fit: The fit.
        load_at_1_gpa: Load of the rig's contact at 1 GPa, which laws on load need; it goes with
            the cube of the pressure.

    Returns:
        Its numbers over its own conditions; `inputs` has factor and power of each, from P, U and T.
    """
    law, coefficients = fit.law, fit.coefficients
    band, _, level = coefficients.bands(law, LEVEL)
    place = law.conditions.index
    fixed_names = {each.condition for each in coefficients.fixed}
    followed = [name for name in law.conditions if name not in fixed_names]
    lattice = zip(followed, fit.lattice[1], strict=True) if len(coefficients.tested) else ()
    law_as_json = {
        "law": law.name,
        "conditions": law.conditions,
        "inputs": [(load_at_1_gpa, 3) if name == _LOAD else (1.0, 1) for name in law.conditions],
        "reference": law.reference,
        "internal": to_internal(law, coefficients.constants),
        "known": coefficients.known,
        "fixed": [
            asdict(each) | {"least_size": LEAST_SIZE.get(each.condition, 0.0)}
            for each in coefficients.fixed
        ],
        "level": level,
        "limit": coefficients.limiting_stress_ratio,
        # tested levels of each followed condition, by curve, and their largest step
        "lattice": [
            {"condition": name, "step": step, "tested": coefficients.tested[:, place(name)]}
            | {"log": name not in LEAST_SIZE}
            for name, step in lattice
            if np.isfinite(step)
        ],
        "two_levels": [
            dict(zip(("low", "high"), coefficients.box[place(name)], strict=True), condition=name)
            for name in coefficients.two_levels
        ],
        "band": None if np.isnan(band.reach).any() else asdict(band) | {"reach": band.reach.T},
        "box": fit.reach,
    }
    return {key: plain(value) for key, value in law_as_json.items()}


def _over_axes(box: FloatArray, law: Law, load_at_1_gpa: float | None) -> FloatArray:
    """A box of the law's conditions over P, U, T and S: the load is the cube of P."""
    if _LOAD not in law.conditions or load_at_1_gpa is None:
        return box
    return np.vstack([np.cbrt(box[:1] / load_at_1_gpa), box[1:]])


def plain(value: Any, digits: int = 0) -> Any:
    """Numbers and arrays as JSON has them: null for NaN and infinity.

    Args:
        value: A number, an array, or lists and mappings of them.
        digits: So many of each number, if any.
    """
    if isinstance(value, Mapping):
        return {key: plain(each, digits) for key, each in value.items()}
    if isinstance(value, list | tuple | np.ndarray | pd.Series):
        return [plain(each, digits) for each in value]
    if isinstance(value, float | np.floating):
        known = float(f"{value:.{digits}g}") if digits else float(value)
        return known if np.isfinite(known) else None
    return value.item() if isinstance(value, np.generic) else value


_FUNCTIONS = ("exp", "expm1", "log", "log1p", "sqrt", "tanh", "asinh", "abs", "sign")
JAVASCRIPT = Language(
    {
        "**": Form("{} ** {}", 4, (5, 5)),
        **{function: Form(f"Math.{function}({{}})") for function in _FUNCTIONS},
    }
)


# mu and its interval at `at`, the conditions of the law and S, which is not negative, by the
# numbers of `explorer.law_of`. `band` is a `Band`, its reach by columns.
_TRACTION = """
function traction(fit, at) {
  const { law, reference, known, internal, band } = fit;
  const dot = (first, second) => first.reduce((total, value, i) => total + value * second[i], 0);
  const design = [1, ...reference.map((value, i) => (known[i] ? Math.log(at[i] / value) : 0))];
  const sizes = [];
  for (let start = 0; start < internal.length; start += design.length) {
    sizes.push(Math.exp(dot(design, internal.slice(start, start + design.length))));
  }
  const { mu, slopes } = LAWS[law](sizes, at.at(-1));
  const gradient = slopes.flatMap((slope) => design.map((value) => slope * value));
  const along = band ? band.reach.map((column) => dot(gradient, column)) : [];
  const bends = fit.two_levels.map(({ condition, low, high }) => {
    const axis = fit.conditions.indexOf(condition);
    const moved = at.with(axis, low * (high / low) ** ((at[axis] - low) / (high - low)));
    return traction({ ...fit, band: null, two_levels: [] }, moved).mu - mu;
  });
  const own = band ? Math.hypot(band.absolute, band.relative * mu, ...along) : NaN;
  const h = own + Math.hypot(...bends);
  const [lower, upper] = mu > 0 ? %s : %s;
  return { mu, lower, upper };
}
"""


def law_script(laws: Iterable[Law]) -> str:
    """JavaScript's `traction(fit, at)`: mu of a fitted law with its interval.

    `LAWS` in it: name -> function of the coefficients' sizes |X| and S that gives mu, and its
    derivatives by each ln|X|.
    """
    ends = tuple(
        f"[{', '.join(map(JAVASCRIPT.write, nodes))}]" for nodes in (RELATIVE_ENDS, ABSOLUTE_ENDS)
    )
    return f"const LAWS = {{\n{''.join(map(_law, laws))}}};\n{_TRACTION % ends}"


def _law(law: Law) -> str:
    steps, (mu, *slopes) = in_steps(law.graphs)
    lines = "".join(f"    const {name} = {JAVASCRIPT.write(node)};\n" for name, node in steps)
    written = ", ".join(map(JAVASCRIPT.write, slopes))
    return (
        f'  "{law.name}": ([{", ".join(law.local_constants)}], S) => {{\n'
        f"{lines}    return {{ mu: {JAVASCRIPT.write(mu)}, slopes: [{written}] }};\n  }},\n"
    )
