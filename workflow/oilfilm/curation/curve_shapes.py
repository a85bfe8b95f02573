"""The shape of each curve of a campaign, beside the other curves of its oil and rig.

The law of the curves is not the configured one: which runs are used does not depend on the law that
is fitted to them. A curve that no others can judge is compared with what holds for any oil.

Decides: when a run is refused for the shape of its curve, and when it is warned about; what any
curve of traction must keep to; the points by which a shape is judged.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from oilfilm.base.ties import first_largest
from oilfilm.base.units import BoolArray, FloatArray
from oilfilm.curation.gate import refusal_by, sentence_named
from oilfilm.logs.base import Refusal
from oilfilm.surface.measurements import Measurements, scaled_slip
from oilfilm.surface.quick_law import NoClearTractionError
from oilfilm.surface.shape import FEWEST_CURVES, REFUSED_ODDNESS, CurveShape, curve_shapes
from oilfilm.traction import PAPER_LAW

_CONDITION_COLUMNS = ["max_hertz_pressure_gpa", "entrainment_speed_m_s", "inlet_temperature_c"]
# Columns of points that are judged: a campaign's table has three times as many.
SHAPE_COLUMNS = [
    "run_id",
    "oil",
    "accepted",
    "first_row",
    "last_row",
    *_CONDITION_COLUMNS,
    "slide_roll_ratio",
    "traction_coefficient",
    "traction_coefficient_se",
]
# Below this slip the rig rolls: the error of the slip decides the traction.
_LEAST_SLIDING_SLIP = 0.002
# Points whose mu has a larger relative standard error do not show the shape.
_LARGEST_RELATIVE_ERROR = 0.01
# The other curves cannot judge a curve if they would not show a change of its mu by this factor.
_LARGEST_UNSEEN_FACTOR = 2.0

# What holds for any oil at one condition, with a wide margin: traction rises no faster than the
# slip, falls by heat more slowly than by the square of the slip, and has one peak.
# Exponent of that fall: mu falls more slowly than 1/S**2.
_STEEPEST_FALL = 2.0
# Factor by which a rise or a fall may be steeper than these limits.
_MARGIN_FACTOR = 1.25
# Ratio of mu at the lower edge of a valley to mu in it. A larger ratio shows two peaks.
_DEEPEST_VALLEY = 1.15
# Error of the zero that must not matter, as a traction coefficient.
_ZERO_ERROR = 0.002
# Number of standard errors of a point that noise explains.
_ERRORS_OF_NOISE = 5.0
# A single level is off if it leaves the curve of its neighbours by this change of ln mu, and by
# this multiple of the largest change of the other levels, judged without it. Of 2 940 clean curves
# of fourteen oils 5 are named so, all of an oil with kinks. A step of +15 % is found in 76 to 96 %
# of curves with 12 or 15 levels, and in 42 to 65 % with 7 or 8. Six levels show too little.
_LEAST_LOG_DEVIATION = 0.08
_LEAST_EXCESS_RATIO = 3.0
_FEWEST_LEVELS = 7
# Change of ln mu by which a level of any smooth curve may leave the curve of its neighbours.
_LEAST_ROUGHNESS = 0.01
# From here on the error of the zero does not shape ln mu.
_LEAST_TRACTION = 5 * _ZERO_ERROR
# Neighbours on either side through which a curve is laid.
_NEIGHBOURS_PER_SIDE = 2


@dataclass(frozen=True)
class ShapeVerdicts:
    """Runs with a shape that is odd or cannot be judged.

    Attributes:
        refusals: Refusals of runs whose curve contradicts the others.
        warnings: For each warning the id of a run, and a sentence about it.
        unjudged_ids: Ids of runs that were compared with four others or more, which cannot judge
            their curve. Runs that were not compared are not among them: those with fewer others,
            at 0 degC and below, or of unknown condition.
    """

    refusals: list[Refusal] = field(default_factory=list)
    warnings: list[tuple[str, str]] = field(default_factory=list)
    unjudged_ids: set[str] = field(default_factory=set)


def judge_shapes(points: pd.DataFrame, runs: pd.DataFrame) -> ShapeVerdicts:
    """The verdicts on the shapes of all accepted runs of a traction rig.

    A run of negative slip is judged as one of positive slip, and its verdict states positive
    values. Of a run in both directions only the points of positive slip are judged.

    Args:
        points: Table of points; those of accepted runs are judged.
        runs: Table of runs.
    """
    verdicts = ShapeVerdicts()
    accepted_runs = runs[runs["verdict"] == "accepted"]
    rig_of_run = accepted_runs.set_index("run_id")["rig"]
    accepted_points = points[points["accepted"] & points["run_id"].isin(rig_of_run.index)]
    accepted_points = _with_positive_slip(accepted_points)
    is_sliding = accepted_points["slide_roll_ratio"] >= _LEAST_SLIDING_SLIP
    judged_points = accepted_points[is_sliding & accepted_points["traction_coefficient"].notna()]
    judged_points = judged_points.sort_values(["run_id", "slide_roll_ratio"], kind="stable")
    rig_of_point = judged_points["run_id"].map(rig_of_run)
    for _, points_of_oil_and_rig in judged_points.groupby(["oil", rig_of_point], sort=True):
        certain_points = points_of_oil_and_rig[_is_mu_certain(points_of_oil_and_rig)]
        run_ids = _ids_of_runs_with_condition(certain_points)
        for run_id, temperature_c in _temperature_of_cold_runs(certain_points).items():
            sentence = sentence_named("cold_shape_not_judged", temperature=temperature_c)
            verdicts.warnings.append((str(run_id), sentence))
        ids_judged_alone = set(points_of_oil_and_rig["run_id"])
        if len(run_ids) >= FEWEST_CURVES:
            _judge_beside_others(certain_points[certain_points["run_id"].isin(run_ids)], verdicts)
            ids_judged_alone -= set(run_ids) - verdicts.unjudged_ids
        is_judged_alone = points_of_oil_and_rig["run_id"].isin(ids_judged_alone)
        for run_id, curve in points_of_oil_and_rig[is_judged_alone].groupby("run_id"):
            verdicts.warnings.extend(_warnings_without_others(str(run_id), curve))
    return verdicts


def _with_positive_slip(points: pd.DataFrame) -> pd.DataFrame:
    """Points, with slip and mu of the other sign in runs that slide at negative slip only."""
    largest_slip_of_run = points.groupby("run_id")["slide_roll_ratio"].transform("max")
    columns = ["slide_roll_ratio", "traction_coefficient"]
    reversed_values = points[columns].mask(
        largest_slip_of_run < _LEAST_SLIDING_SLIP, -points[columns]
    )
    return points.assign(**reversed_values)


def _is_mu_certain(points: pd.DataFrame) -> "pd.Series[bool]":
    """Mask of the points whose mu is certain enough, or has no known error."""
    mu = points["traction_coefficient"]
    mu_se = points["traction_coefficient_se"]
    return ~(mu_se > _LARGEST_RELATIVE_ERROR * mu.abs())


def _ids_of_runs_with_condition(points: pd.DataFrame) -> list[str]:
    """Ids of the runs whose condition is known and has a logarithm."""
    means = points.groupby("run_id")[_CONDITION_COLUMNS].mean()
    return list(means.index[(means > 0).all(axis=1)])


def _temperature_of_cold_runs(points: pd.DataFrame) -> "pd.Series[float]":
    """Mean inlet temperature of the runs at 0 degC and below, in degC, by their ids."""
    temperature_c = points.groupby("run_id")["inlet_temperature_c"].mean()
    return temperature_c[temperature_c <= 0]


def _judge_beside_others(points: pd.DataFrame, verdicts: ShapeVerdicts) -> None:
    """Add the verdicts on curves of one oil and rig, each beside the others.

    Args:
        points: Points of five curves or more, sorted by run and slip.
        verdicts: Verdicts, to which those of these curves are added.
    """
    curve_of_point, run_ids = pd.factorize(points["run_id"], sort=True)
    conditions = points.groupby("run_id")[_CONDITION_COLUMNS].mean().loc[run_ids]
    measurements = Measurements(
        conditions=conditions.to_numpy(float),
        curve_of_point=curve_of_point,
        slip=points["slide_roll_ratio"].to_numpy(float),
        mu=points["traction_coefficient"].to_numpy(float),
    )
    try:
        shapes = curve_shapes(measurements, PAPER_LAW)
    except NoClearTractionError:
        sentence = sentence_named("shape_without_traction", curves=len(run_ids))
        verdicts.warnings.extend((str(run_id), sentence) for run_id in run_ids)
        verdicts.unjudged_ids.update(map(str, run_ids))
        return
    for shape in shapes:
        run_id = str(run_ids[shape.curve_index])
        if shape.is_odd:
            refusal = _refusal_of_shape(
                run_id, shape, points.iloc[shape.point_index], len(run_ids) - 1
            )
            # the deviation over its limits: odd above 1
            if shape.oddness > REFUSED_ODDNESS:
                verdicts.refusals.append(refusal)
            else:
                verdicts.warnings.append((run_id, f"unusual_shape: {refusal.reason}"))
        # `smallest_visible_change` is a change of ln mu at a typical point
        elif np.exp(shape.smallest_visible_change) > _LARGEST_UNSEEN_FACTOR:
            smallest_visible = np.expm1(shape.smallest_visible_change)
            sentence = sentence_named(
                "shape_not_judged", smallest_visible=smallest_visible, spread=shape.median_log_mu_sd
            )
            verdicts.warnings.append((run_id, sentence))
            verdicts.unjudged_ids.add(run_id)


def _refusal_of_shape(
    run_id: str, shape: CurveShape, point: pd.Series, other_curve_count: int
) -> Refusal:
    """The refusal of a run for its shape, with the point that is farthest off."""
    return refusal_by(
        "odd_shape",
        run_id=run_id,
        first=point["first_row"],
        last=point["last_row"],
        slip=point["slide_roll_ratio"],
        mu=point["traction_coefficient"],
        deviation=point["traction_coefficient"] / shape.expected_mu - 1,
        expected=shape.expected_mu,
        # at this point; `median_log_mu_sd` is its median over the curve
        spread=shape.log_mu_sd,
        others=other_curve_count,
        oddness=shape.oddness,
    )


def _warnings_without_others(run_id: str, points: pd.DataFrame) -> Iterator[tuple[str, str]]:
    """Warnings about a curve that no oil has, by limits that hold for any.

    Args:
        run_id: Id of the run.
        points: Its points, in ascending order of slip.
    """
    columns = ["slide_roll_ratio", "traction_coefficient", "traction_coefficient_se"]
    # where the error of a point is not known, a jump may be noise
    points_with_errors = points.dropna(subset=columns).drop_duplicates("slide_roll_ratio")
    slip, mu, mu_se = points_with_errors[columns].to_numpy(float).T
    # distance in mu that noise explains, shape (points,)
    noise_limit = _ERRORS_OF_NOISE * mu_se
    # name of a sentence -> mask of the points but the first, shape (points - 1,)
    mask_of_sentence = {
        "rises_too_fast": _rises_too_fast(slip, mu, noise_limit),
        "falls_too_fast": _falls_too_fast(slip, mu, noise_limit),
        "two_peaks": _is_in_valley(mu, noise_limit),
        "single_level": _is_odd_level(slip, mu, noise_limit),
    }
    for sentence_name, is_beyond in mask_of_sentence.items():
        indices_beyond = np.flatnonzero(is_beyond)
        if len(indices_beyond):
            index_before, point_index = indices_beyond[0], indices_beyond[0] + 1
            fields = {
                "slip": slip[point_index],
                "mu": mu[point_index],
                "slip_before": slip[index_before],
                "mu_before": mu[index_before],
            }
            yield run_id, sentence_named(sentence_name, **fields)
            return


def _rises_too_fast(slip: FloatArray, mu: FloatArray, noise_limit: FloatArray) -> BoolArray:
    """Whether mu rises to each point but the first faster than the slip, shape (points - 1,)."""
    largest_mu_before = np.maximum(mu[:-1], 0.0) + noise_limit[:-1] + _ZERO_ERROR
    return np.asarray(
        mu[1:] - noise_limit[1:] > _MARGIN_FACTOR * largest_mu_before * slip[1:] / slip[:-1]
    )


def _falls_too_fast(slip: FloatArray, mu: FloatArray, noise_limit: FloatArray) -> BoolArray:
    """Whether mu falls to each point but the first faster than by heat, shape (points - 1,)."""
    smallest_allowed_mu = (
        (mu[:-1] - noise_limit[:-1]) * (slip[:-1] / slip[1:]) ** _STEEPEST_FALL / _MARGIN_FACTOR
    )
    return np.asarray(mu[1:] + noise_limit[1:] + _ZERO_ERROR < smallest_allowed_mu)


def _is_in_valley(mu: FloatArray, noise_limit: FloatArray) -> BoolArray:
    """Whether each point but the first is in a valley between two peaks, shape (points - 1,)."""
    highest_before = np.maximum.accumulate(mu - noise_limit)
    highest_after = np.maximum.accumulate((mu - noise_limit)[::-1])[::-1]
    lower_edge = np.minimum(highest_before, highest_after)
    return np.asarray((lower_edge > _DEEPEST_VALLEY * (mu + noise_limit))[1:])


def _is_odd_level(slip: FloatArray, mu: FloatArray, noise_limit: FloatArray) -> BoolArray:
    """Whether a point is the one that leaves a curve which is smooth without it.

    The curve is a polynomial of ln mu over the scaled slip through two neighbours on either side.
    Only the point that is farthest off can be named. The ends have no neighbours on one side.

    Returns:
        One value per point but the first, shape (points - 1,).
    """
    is_off = np.zeros(len(mu), dtype=bool)
    # levels are the points whose mu the zero does not shape
    point_indices_of_levels = np.flatnonzero(mu > _LEAST_TRACTION)
    if len(point_indices_of_levels) < _FEWEST_LEVELS:
        return is_off[1:]
    # asinh(S/0.003)
    scaled_slips = scaled_slip(slip[point_indices_of_levels])
    log_mu = np.log(mu[point_indices_of_levels])
    deviation = _deviation_from_neighbours(scaled_slips, log_mu)
    excess_ratio = np.zeros(len(point_indices_of_levels))
    for level_index in range(1, len(point_indices_of_levels) - 1):
        other_indices = np.delete(np.arange(len(point_indices_of_levels)), level_index)
        roughness = np.abs(
            _deviation_from_neighbours(scaled_slips[other_indices], log_mu[other_indices])
        ).max()
        excess_ratio[level_index] = abs(deviation[level_index]) / max(roughness, _LEAST_ROUGHNESS)
    worst_level_index = int(first_largest(excess_ratio))
    worst_point_index = point_indices_of_levels[worst_level_index]
    deviation_size = (
        abs(deviation[worst_level_index]) - noise_limit[worst_point_index] / mu[worst_point_index]
    )
    is_off[worst_point_index] = (
        excess_ratio[worst_level_index] > _LEAST_EXCESS_RATIO
        and deviation_size > _LEAST_LOG_DEVIATION
    )
    return is_off[1:]


def _deviation_from_neighbours(scaled_slips: FloatArray, log_mu: FloatArray) -> FloatArray:
    """ln mu less that of the curve through the neighbours of each point; 0 at the ends."""
    deviation = np.zeros(len(scaled_slips))
    for level_index in range(1, len(scaled_slips) - 1):
        window_indices = np.arange(
            max(0, level_index - _NEIGHBOURS_PER_SIDE),
            min(len(scaled_slips), level_index + _NEIGHBOURS_PER_SIDE + 1),
        )
        neighbour_indices = window_indices[window_indices != level_index]
        curve = np.polynomial.Polynomial.fit(
            scaled_slips[neighbour_indices], log_mu[neighbour_indices], len(neighbour_indices) - 1
        )
        deviation[level_index] = log_mu[level_index] - curve(scaled_slips[level_index])
    return deviation
