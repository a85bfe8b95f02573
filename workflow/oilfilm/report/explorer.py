"""Data and script of the report's explorer: laws, intervals, the tested box, the sliders.

`page.js` gives the values of `FittedLaw.predict`. It calls the script that `law_script` writes from
the equations that Python evaluates. The surface of measured mu is interpolated between nodes, so
that the page needs no linear algebra.

Decides: how the explorer computes mu and its interval in the browser, and with which numbers.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.base.ties import first_smallest
from oilfilm.base.units import FloatArray
from oilfilm.fits.conditions import LEAST_MAGNITUDES, level_numbers_by_gap
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.interval import CONFIDENCE
from oilfilm.report.names import CONDITION_TEXTS, oil_colour
from oilfilm.settings.resolved import Settings
from oilfilm.surface.measurements import LINEAR_SLIP_LIMIT, scaled_slip
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.operating_grid import AXIS_NAMES
from oilfilm.traction.expression import Form, Language, straight_line_form
from oilfilm.traction.law import Law, to_internal

# Nodes of the surface in the page. Along a condition they are its tested levels and the middles
# between them, or a fixed number of nodes where it has too many levels.
_MOST_LEVELS = 6
_NODE_COUNT = 7
_SLIP_NODE_COUNT = 17
# Neighbouring levels of a condition differ by more than this share of its range.
_LEVEL_GAP = 0.05
# Significant digits of the values at the nodes.
_DIGITS = 4
_LOAD = "load_n"
_FEWEST_STEPS = 100  # of a slider
# A limit that is nearer to a step than this share of a step is on that step.
_STEP_TOLERANCE = 1e-9


@dataclass(frozen=True)
class Axis:
    """One of P, U, T and S: a slider, or the abscissa. Values are in the unit of the column.

    Attributes:
        name: Column of the table of points.
        low: Smallest value of the slider.
        high: Largest value.
        step: Distance between its values.
        steps: Number of steps from `low` to `high`.
        digits: Decimals of every value.
        start: First value.
        idle: Whether no fit depends on it, because it was tested at one level or is not known. The
            page then hides its slider.
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
    def with_round_steps(
        cls, name: str, low: float, high: float, start: float, idle: bool = False
    ) -> "Axis":
        """A slider over `low` to `high`; the step is a power of ten that gives 100 steps or more.

        Args:
            name: Column of the table of points.
            low: Value that the slider reaches at least.
            high: Value that the slider reaches at least.
            start: First value.
            idle: As the attribute.
        """
        span = high - low or abs(low) or 1.0
        largest_step = span / _FEWEST_STEPS
        if low > 0:
            # a larger step would begin at zero, where a power law has no value
            largest_step = min(largest_step, low)
        power = int(np.floor(np.log10(largest_step)))
        step = 10.0**power
        digits = max(0, -power)
        first_step = np.floor(low / step + _STEP_TOLERANCE)
        last_step = np.ceil(high / step - _STEP_TOLERANCE)
        return cls(
            name=name,
            low=round(float(first_step * step), digits),
            high=round(float(last_step * step), digits),
            step=step,
            steps=int(last_step - first_step),
            digits=digits,
            start=round(float(start), digits),
            idle=idle,
        )


def explorer_data(results: CampaignTables, settings: Settings) -> dict[str, Any]:
    """Everything that the explorer in the page needs, as plain values for JSON.

    Args:
        results: Tables `points`, `coefficients`, `refits` and `fit_quality`.
        settings: All settings of the campaign.
    """
    load_n_at_1_gpa = load_at_1_gpa(settings)
    fit_by_oil = explored_fits(results, load_n_at_1_gpa)
    nearby = settings.report.nearby.model_dump()
    axes = [_axis_as_json(axis, nearby) for axis in sliders(fit_by_oil, results, settings)]
    oils = []
    for oil in list(fit_by_oil):
        # a fit keeps its surface: it goes before the next one
        fit = fit_by_oil.pop(oil)
        oil_as_json = {
            "name": oil,
            "colour": oil_colour(oil, list(settings.oils)),
            "where": [fixed.sentence() for fixed in fit.coefficients.fixed_conditions],
        }
        oil_as_json.update(law_as_json(fit, load_n_at_1_gpa))
        oils.append(oil_as_json)
    return {"axes": axes, "oils": oils}


def _axis_as_json(axis: Axis, nearby: Mapping[str, float]) -> dict[str, Any]:
    """A slider for JSON, with its texts and with the distance at which a measured point is near.

    Args:
        axis: The slider.
        nearby: Largest distance by condition, absolute or (`_relative`) as a share.
    """
    symbol, label, unit = CONDITION_TEXTS[axis.name]
    relative_key = f"{axis.name}_relative"
    is_relative = relative_key in nearby
    axis_as_json = asdict(axis)
    axis_as_json["symbol"] = symbol
    axis_as_json["label"] = label
    axis_as_json["unit"] = unit
    axis_as_json["nearby"] = nearby[relative_key if is_relative else axis.name]
    axis_as_json["relative"] = is_relative
    return axis_as_json


def load_at_1_gpa(settings: Settings) -> float | None:
    """Load (N) of the rigs' contact at 1 GPa; None where the rigs have no common contact."""
    contact = settings.common_contact()
    return None if contact is None else float(contact.load_n(1.0))


def explored_fits(results: CampaignTables, load_n_at_1_gpa: float | None) -> dict[str, FittedLaw]:
    """The fits of the configured law that can be evaluated at P, U, T and S, by oil.

    Args:
        results: Tables `points`, `coefficients`, `refits` and `fit_quality`.
        load_n_at_1_gpa: As of the function `load_at_1_gpa`; laws of load need it.
    """
    fit_by_oil = {}
    for oil in results.configured_fits.fit_quality["oil"]:
        fit = FittedLaw.from_results(results, oil)
        lacks_constants = np.isnan(fit.coefficients.constants).any()
        lacks_load = load_n_at_1_gpa is None and _LOAD in fit.law.conditions
        if not lacks_constants and not lacks_load:
            fit_by_oil[str(oil)] = fit
    return fit_by_oil


def sliders(
    fit_by_oil: Mapping[str, FittedLaw], results: CampaignTables, settings: Settings
) -> list[Axis]:
    """Sliders over all tested conditions, and over the ranges of `report.sliders` if they overlap.

    Args:
        fit_by_oil: Fits by oil.
        results: Table `points`.
        settings: All settings of the campaign.
    """
    load_n_at_1_gpa = load_at_1_gpa(settings)
    usual_ranges = settings.report.sliders
    start_point = _central_point(results)
    boxes = [
        _box_over_axes(fit.coefficients.tested_box, fit.law, load_n_at_1_gpa)
        for fit in fit_by_oil.values()
    ]
    axes = []
    for index, name in enumerate(AXIS_NAMES):
        low, high = getattr(usual_ranges, name)
        tested_ranges = [box[index] for box in boxes if not np.isnan(box[index]).any()]
        if tested_ranges:
            lowest_tested = min(tested_low for tested_low, _ in tested_ranges)
            highest_tested = max(tested_high for _, tested_high in tested_ranges)
            if lowest_tested <= high and highest_tested >= low:
                low = min(low, lowest_tested)
                high = max(high, highest_tested)
            else:
                low = lowest_tested
                high = highest_tested
        start = float(np.clip(start_point.get(name, low), low, high))
        # every law depends on the slide-roll ratio
        idle = name != "slide_roll_ratio" and not any(
            fit.coefficients.group_has_exponent[index] for fit in fit_by_oil.values()
        )
        axes.append(Axis.with_round_steps(name, low, high, start, idle))
    return axes


def _central_point(results: CampaignTables) -> dict[str, float]:
    """Conditions of the point nearest to the middle of all points.

    There the chart shows some points.

    Args:
        results: Table `points`.
    """

    def accepted_conditions(columns: list[str]) -> Iterator[pd.DataFrame]:
        """Conditions of the accepted points, a part at a time."""
        for part in results.blocks("points", [*columns, "accepted"]):
            yield part.loc[part["accepted"], columns]

    is_known = pd.DataFrame(part.notna().any() for part in accepted_conditions(list(AXIS_NAMES)))
    known_columns = [name for name in AXIS_NAMES if is_known[name].any()]
    if not known_columns:
        return {}
    ends = [part.dropna().agg(["min", "max"]) for part in accepted_conditions(known_columns)]
    low, high = pd.concat(ends).agg(["min", "max"]).to_numpy()
    if np.isnan(low).any():
        return {}
    width = np.where(high > low, high - low, 1.0)

    def nearest(points: pd.DataFrame) -> pd.DataFrame:
        """The row of the point nearest to the middle; no row if there are no points."""
        distance = (((points - (low + high) / 2) / width) ** 2).sum(axis="columns")
        return points.iloc[[int(first_smallest(distance))]] if len(points) else points

    nearest_of_parts = [nearest(part.dropna()) for part in accepted_conditions(known_columns)]
    (central_values,) = nearest(pd.concat(nearest_of_parts, ignore_index=True)).to_numpy().tolist()
    return dict(zip(known_columns, central_values, strict=True))


def law_as_json(fit: FittedLaw, load_n_at_1_gpa: float | None = None) -> dict[str, Any]:
    """A fitted law with its interval and its tested box, as the page computes with it.

    Args:
        fit: The fit.
        load_n_at_1_gpa: Load (N) of the rig's contact at 1 GPa, which laws of load need; the load
            goes with the cube of the pressure.

    Returns:
        Numbers over the conditions of the law. `inputs` has a factor and a power per condition: the
        condition is the factor times this power of P, U or T. `internal` has the internal
        constants; `known`, whether a group has an exponent; `fixed`, the other conditions; `level`,
        that of the interval; `limit`, the limiting shear stress over the pressure; `lattice`, the
        tested conditions; `box`, their ranges.
    """
    law = fit.law
    coefficients = fit.coefficients
    contents = {
        "law": law.name,
        "conditions": law.conditions,
        "inputs": [(load_n_at_1_gpa, 3) if name == _LOAD else (1.0, 1) for name in law.conditions],
        "reference": law.reference,
        "exponential": [group in law.exponential for group in law.groups],
        "internal": to_internal(law, coefficients.constants),
        "known": coefficients.group_has_exponent,
        "fixed": _fixed_conditions(fit),
        "level": fit.interval_level(CONFIDENCE),
        "limit": coefficients.limiting_stress_ratio,
        "lattice": _tested_lattice(fit),
        "surface": _surface_as_json(fit),
        "box": fit.widened_box,
    }
    return {key: as_json(value) for key, value in contents.items()}


def _surface_as_json(fit: FittedLaw) -> dict[str, Any] | None:
    """The surface of measured mu at nodes over the tested box; None where there is none.

    Returns:
        `axes`, of which the last one is the slip; `shift`, the logarithm of mu over that of the
        law, and `half`, that of the upper limit over mu, at all nodes, the last axis fastest;
        `curve`, how much wider a band over a curve is; `answers`, whether mu is that of the
        surface.
    """
    surface = fit.surface
    if surface is None:
        return None
    tested_conditions = surface.contact.law_conditions(fit.law, surface.measurements.conditions)
    axes = [*_axes_of_conditions(fit, tested_conditions), _axis_of_slip(surface.measurements.slip)]
    meshes = np.meshgrid(*[axis["values"] for axis in axes], indexing="ij")
    conditions = np.full((meshes[0].size, len(fit.law.conditions)), np.nan)
    for axis, mesh in zip(axes[:-1], meshes[:-1], strict=True):
        conditions[:, axis["column"]] = mesh.ravel()
    slip = meshes[-1].ravel()
    conditions_on_line = fit.at_tested_levels(conditions)
    surface_prediction = surface.predict(
        fit.law, conditions_on_line, slip, CONFIDENCE, whole_curve=False
    )
    law_mu = fit.without_interval().predict(conditions_on_line, slip).traction_coefficient
    return {
        "axes": [{key: axis[key] for key in ("column", "scale", "nodes")} for axis in axes],
        "shift": as_json(np.log(surface_prediction.mu / law_mu), _DIGITS),
        "half": as_json(np.log(surface_prediction.upper / surface_prediction.mu), _DIGITS),
        "curve": surface.interval_factors.curve / surface.interval_factors.point,
        "answers": surface.no_law_fits,
    }


def _axes_of_conditions(fit: FittedLaw, tested_conditions: FloatArray) -> list[dict[str, Any]]:
    """Axes of the surface over the conditions that the fit follows: those with an exponent.

    Each has its column among the conditions, its scale, values and nodes. The nodes are the values
    on the scale.

    Args:
        fit: The fit.
        tested_conditions: Conditions of the law in each curve, shape (curves, conditions).
    """
    fixed_names = {fixed.condition for fixed in fit.coefficients.fixed_conditions}
    axes = []
    for column_index, name in enumerate(fit.law.conditions):
        if name in fixed_names:
            continue
        is_linear = name in LEAST_MAGNITUDES
        low, high = fit.coefficients.tested_box[column_index]
        if is_linear:
            nodes = _nodes_of_levels(tested_conditions[:, column_index], low, high)
            values = nodes
        else:
            nodes = _nodes_of_levels(
                np.log(tested_conditions[:, column_index]), np.log(low), np.log(high)
            )
            values = np.exp(nodes)
        scale = "linear" if is_linear else "log"
        axes.append({"column": column_index, "scale": scale, "values": values, "nodes": nodes})
    return axes


def _nodes_of_levels(tested_values: FloatArray, low: float, high: float) -> FloatArray:
    """Nodes over the tested box: at its levels, where intervals are narrow, and half way between.

    Args:
        tested_values: Value of the condition in each curve, on the scale of the axis.
        low: Lower end of the box.
        high: Upper end.
    """
    level_of_curve = level_numbers_by_gap(tested_values, _LEVEL_GAP)
    if level_of_curve.max() >= _MOST_LEVELS:
        return np.linspace(low, high, _NODE_COUNT)
    levels = np.bincount(level_of_curve, tested_values) / np.bincount(level_of_curve)
    levels_to_ends = np.concatenate([[low], levels[1:-1], [high]])
    return np.sort(np.concatenate([levels_to_ends, (levels_to_ends[:-1] + levels_to_ends[1:]) / 2]))


def _axis_of_slip(tested_slips: FloatArray) -> dict[str, Any]:
    """The axis over the slip, as those of conditions: even on its scale over the tested slips."""
    lowest, highest = tested_slips.min(), tested_slips.max()
    first, last = scaled_slip(np.array([lowest, highest])).tolist()
    nodes = np.linspace(first, last, _SLIP_NODE_COUNT)
    values = (LINEAR_SLIP_LIMIT * np.sinh(nodes)).clip(lowest, highest)
    return {"column": -1, "scale": "slip", "values": values, "nodes": nodes}


def _fixed_conditions(fit: FittedLaw) -> list[dict[str, Any]]:
    """The conditions on which the fit does not depend, each with its tested level or line."""
    conditions = []
    for fixed in fit.coefficients.fixed_conditions:
        condition = asdict(fixed)
        condition["least_size"] = LEAST_MAGNITUDES.get(fixed.condition, 0.0)
        conditions.append(condition)
    return conditions


def _tested_lattice(fit: FittedLaw) -> list[dict[str, Any]]:
    """Each condition that the fit follows: its level in each tested curve, and its largest step.

    Empty where the tested conditions are not known.
    """
    coefficients = fit.coefficients
    if not len(coefficients.tested_conditions):
        return []
    fixed_names = {fixed.condition for fixed in coefficients.fixed_conditions}
    followed_names = [name for name in fit.law.conditions if name not in fixed_names]
    lattice = []
    for name, step in zip(followed_names, fit.measured_coordinates.largest_steps, strict=True):
        if np.isfinite(step):
            tested_values = coefficients.tested_conditions[:, fit.law.conditions.index(name)]
            is_logarithmic = name not in LEAST_MAGNITUDES
            lattice.append(
                {"condition": name, "step": step, "tested": tested_values, "log": is_logarithmic}
            )
    return lattice


def _box_over_axes(box: FloatArray, law: Law, load_n_at_1_gpa: float | None) -> FloatArray:
    """The tested box over P, U, T and S, shape (4, 2): the load goes with the cube of P.

    Args:
        box: Over the conditions of the law and S, shape (4, 2).
        law: The law.
        load_n_at_1_gpa: Load (N) of the rig's contact at 1 GPa.
    """
    if _LOAD not in law.conditions or load_n_at_1_gpa is None:
        return box
    pressure_gpa = np.cbrt(box[:1] / load_n_at_1_gpa)
    return np.vstack([pressure_gpa, box[1:]])


def as_json(value: Any, digits: int = 0) -> Any:
    """Numbers and arrays as JSON has them: null for NaN and infinity.

    Args:
        value: A number, an array, or lists and mappings of them.
        digits: Significant digits of each number; all of them if 0.
    """
    if isinstance(value, Mapping):
        return {key: as_json(content, digits) for key, content in value.items()}
    if isinstance(value, list | tuple | np.ndarray | pd.Series):
        return [as_json(content, digits) for content in value]
    if isinstance(value, float | np.floating):
        rounded = float(f"{value:.{digits}g}") if digits else float(value)
        return rounded if np.isfinite(rounded) else None
    return value.item() if isinstance(value, np.generic) else value


_FUNCTIONS = ("exp", "expm1", "log", "log1p", "sqrt", "tanh", "asinh", "abs", "sign")
_FUNCTION_FORMS = {function: Form(f"Math.{function}({{}})") for function in _FUNCTIONS}
JAVASCRIPT = Language({"**": Form("{} ** {}", 4, (5, 5))} | _FUNCTION_FORMS)


# JavaScript of mu and its interval. `at` has the conditions of the law and S, which is never below
# zero; `fit` has the numbers of `law_as_json`. `%s` stands for `LINEAR_SLIP_LIMIT`.
_TRACTION = """
function departure({ axes, shift, half }, at) {
  const unknown = { shift: NaN, half: NaN };
  const slip = (value) => Math.asinh(value / %s);
  const scales = { log: Math.log, linear: (value) => value, slip };
  let corners = [[0, 1]];
  for (const { column, scale, nodes } of axes) {
    const value = scales[scale](at.at(column));
    const last = nodes.length - 1;
    const rounding = 1e-6 * (nodes[last] - nodes[0]);
    if (!(value >= nodes[0] - rounding && value <= nodes[last] + rounding)) return unknown;
    const above = Math.max(1, nodes.findIndex((node) => value <= node + rounding));
    const below = above - 1;
    const unclippedShare = (value - nodes[below]) / (nodes[above] - nodes[below]);
    const share = Math.min(1, Math.max(0, unclippedShare));
    corners = corners.flatMap(([row, weight]) => [
      [row * nodes.length + below, weight * (1 - share)],
      [row * nodes.length + above, weight * share],
    ]).filter(([, weight]) => weight > 0);
  }
  const mean = (values) => corners.reduce(
    (sum, [row, weight]) => sum + weight * (values[row] ?? NaN), 0);
  return { shift: mean(shift), half: mean(half) };
}
function traction(fit, at) {
  const { law, reference, exponential, known, internal, surface } = fit;
  const dot = (first, second) => first.reduce((total, value, i) => total + value * second[i], 0);
  const term = (relative, i) => (exponential[i] ? relative - 1 : Math.log(relative));
  const design = [1, ...reference.map((value, i) => (known[i] ? term(at[i] / value, i) : 0))];
  const sizes = [];
  for (let start = 0; start < internal.length; start += design.length) {
    sizes.push(Math.exp(dot(design, internal.slice(start, start + design.length))));
  }
  const ofLaw = LAWS[law](sizes, at.at(-1));
  const { shift, half } = surface ? departure(surface, at) : { shift: NaN, half: NaN };
  const measured = ofLaw * Math.exp(shift);
  const end = (width) => measured * Math.exp(width);
  return {
    mu: surface?.answers && Number.isFinite(half) ? measured : ofLaw,
    lower: end(-half),
    upper: end(half),
    bandLower: end(-half * (surface?.curve ?? NaN)),
    bandUpper: end(half * (surface?.curve ?? NaN)),
  };
}
"""


def law_script(laws: Iterable[Law]) -> str:
    """The JavaScript function `traction(fit, at)`: mu of a fitted law with its interval.

    Its table `LAWS` has one function per law, by the law's name. The function takes the sizes |X|
    of the coefficients and S, and gives mu.
    """
    functions = "".join(_law_function(law) for law in laws)
    return f"const LAWS = {{\n{functions}}};\n{_TRACTION % LINEAR_SLIP_LIMIT}"


def _law_function(law: Law) -> str:
    """One entry of the table `LAWS`."""
    steps, (mu,) = straight_line_form(law.graphs[:1])
    arguments = ", ".join(law.coefficient_names)
    lines = "".join(f"    const {name} = {JAVASCRIPT.write(node)};\n" for name, node in steps)
    return (
        f'  "{law.name}": ([{arguments}], S) => {{\n'
        f"{lines}    return {JAVASCRIPT.write(mu)};\n  }},\n"
    )
