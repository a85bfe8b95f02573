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
from oilfilm.curation.gate import fault
from oilfilm.logs.base import Refusal
from oilfilm.surface.measurements import Measurements, scaled_slip
from oilfilm.surface.shape import FEWEST_CURVES, REFUSED_SIZE, CurveShape, curve_shapes
from oilfilm.traction import PAPER_LAW

_CONDITIONS = ["max_hertz_pressure_gpa", "entrainment_speed_m_s", "inlet_temperature_c"]
# Columns of points that are judged: a campaign's table has three times as many.
SHAPE_COLUMNS = [
    *("run_id", "oil", "accepted", "first_row", "last_row", *_CONDITIONS),
    *("slide_roll_ratio", "traction_coefficient", "traction_coefficient_se"),
]
# Below this slip the rig rolls: the error of the slip decides the traction.
_LEAST_SLIP = 0.002
# Points whose mu is less certain than this, relative, do not show the shape.
_LARGEST_ERROR = 0.01
# Where a smaller change than this factor on mu would not be seen, the others cannot judge a curve.
_LARGEST_UNSEEN = 2.0

# What holds for any oil at one condition, with a wide margin: traction rises no faster than the
# slip, falls by heat more slowly than by the square of the slip, and has one peak.
_STEEPEST_FALL = 2.0
_MARGIN = 1.25
_DEEPEST_VALLEY = 1.15
# Error of the zero that must not matter, as a traction coefficient, and error of a point over its
# standard deviation.
_ZERO_ERROR = 0.002
_NOISE_ERRORS = 5.0
# A single level is off if it leaves the curve of its neighbours by this change of ln mu, and by so
# many times what any level does once it is taken out. Of 2 940 clean curves of fourteen oils 5 are
# named so, all of an oil with kinks. A step of +15 % is found in 76 to 96 % of curves with 12 or 15
# levels, and in 42 to 65 % with 7 or 8. Six levels show too little.
_OFF_THE_CURVE = 0.08
_TIMES_THE_REST = 3.0
_FEWEST_LEVELS = 7
# Changes of ln mu that any smooth curve has between its levels.
_ROUGHNESS = 0.01
# From here on the error of the zero does not shape ln mu.
_CARRIES_TRACTION = 5 * _ZERO_ERROR
# Neighbours on either side through which a curve is laid.
_NEIGHBOURS = 2


@dataclass(frozen=True)
class ShapeVerdicts:
    """Runs with a shape that is odd or cannot be judged.

    Attributes:
        refused: Refusals of runs whose curve contradicts the others.
        warnings: Id of a run, and a sentence about it.
        not_judged: Ids of runs whose curve the others cannot judge.
    """

    refused: list[Refusal] = field(default_factory=list)
    warnings: list[tuple[str, str]] = field(default_factory=list)
    not_judged: set[str] = field(default_factory=set)


def judged_shapes(points: pd.DataFrame, runs: pd.DataFrame) -> ShapeVerdicts:
    """The verdicts on the shapes of all accepted runs of a traction rig.

    Args:
        points: Table of points; those of accepted runs are judged.
        runs: Table of runs.
    """
    verdicts = ShapeVerdicts()
    accepted = runs[runs["verdict"] == "accepted"]
    rig_of_run = accepted.set_index("run_id")["rig"]
    is_sliding = points["slide_roll_ratio"] >= _LEAST_SLIP
    is_sliding &= points["traction_coefficient"].notna()
    judged = points[points["accepted"] & is_sliding & points["run_id"].isin(rig_of_run.index)]
    judged = judged.sort_values(["run_id", "slide_roll_ratio"], kind="stable")
    rigs = judged["run_id"].map(rig_of_run)
    for _, points_of_oil_and_rig in judged.groupby(["oil", rigs], sort=True):
        certain = points_of_oil_and_rig[_is_certain(points_of_oil_and_rig)]
        run_ids = _curves_with_conditions(certain)
        judged_alone = set(points_of_oil_and_rig["run_id"])
        if len(run_ids) >= FEWEST_CURVES:
            _judge_beside_others(certain[certain["run_id"].isin(run_ids)], verdicts)
            judged_alone -= set(run_ids) - verdicts.not_judged
        is_judged_alone = points_of_oil_and_rig["run_id"].isin(judged_alone)
        for run_id, curve in points_of_oil_and_rig[is_judged_alone].groupby("run_id"):
            verdicts.warnings.extend(_warnings_without_others(str(run_id), curve))
    return verdicts


def _is_certain(points: pd.DataFrame) -> "pd.Series[bool]":
    """Points whose mu is certain enough, or has no known error."""
    mu, error = points["traction_coefficient"], points["traction_coefficient_se"]
    return ~(error > _LARGEST_ERROR * mu.abs())


def _curves_with_conditions(points: pd.DataFrame) -> list[str]:
    """Runs whose condition is known and has a logarithm."""
    means = points.groupby("run_id")[_CONDITIONS].mean()
    return list(means.index[(means > 0).all(axis=1)])


def _judge_beside_others(points: pd.DataFrame, verdicts: ShapeVerdicts) -> None:
    """Add the verdicts on curves of one oil and rig, each beside the others.

    Args:
        points: Points of five curves or more, sorted by run and slip.
        verdicts: Verdicts, to which those of these curves are added.
    """
    curve, run_ids = pd.factorize(points["run_id"], sort=True)
    conditions = points.groupby("run_id")[_CONDITIONS].mean().loc[run_ids]
    measurements = Measurements(
        conditions=conditions.to_numpy(float),
        curve_of_point=curve,
        slip=points["slide_roll_ratio"].to_numpy(float),
        mu=points["traction_coefficient"].to_numpy(float),
    )
    for shape in curve_shapes(measurements, PAPER_LAW):
        run_id = str(run_ids[shape.curve_index])
        if shape.is_odd:
            refusal = _refusal_of_shape(
                run_id, shape, points.iloc[shape.point_index], len(run_ids) - 1
            )
            if shape.size > REFUSED_SIZE:
                verdicts.refused.append(refusal)
            else:
                verdicts.warnings.append((run_id, f"unusual_shape: {refusal.reason}"))
        elif np.exp(shape.smallest_seen) > _LARGEST_UNSEEN:
            seen = np.expm1(shape.smallest_seen)
            reason = fault("shape_not_judged", seen=seen, spread=shape.usual_spread).reason
            verdicts.warnings.append((run_id, reason))
            verdicts.not_judged.add(run_id)


def _refusal_of_shape(run_id: str, shape: CurveShape, point: pd.Series, others: int) -> Refusal:
    """The refusal of a run for its shape, with the point that is farthest off."""
    return fault(
        "odd_shape",
        run_id=run_id,
        first=point["first_row"],
        last=point["last_row"],
        slip=point["slide_roll_ratio"],
        mu=point["traction_coefficient"],
        deviation=point["traction_coefficient"] / shape.expected_mu - 1,
        expected=shape.expected_mu,
        spread=shape.spread,
        others=others,
        size=shape.size,
    )


def _warnings_without_others(run_id: str, points: pd.DataFrame) -> Iterator[tuple[str, str]]:
    """Warnings about a curve that no oil has, by limits that hold for any.

    Args:
        run_id: Id of the run.
        points: Its points, in ascending order of slip.
    """
    columns = ["slide_roll_ratio", "traction_coefficient", "traction_coefficient_se"]
    # where the error of a point is not known, a jump may be noise
    with_errors = points.dropna(subset=columns).drop_duplicates("slide_roll_ratio")
    slip, mu, error = with_errors[columns].to_numpy(float).T
    noise = _NOISE_ERRORS * error
    limits = {
        "rises_too_fast": _too_fast_rise(slip, mu, noise),
        "falls_too_fast": _too_fast_fall(slip, mu, noise),
        "two_peaks": _valley(mu, noise),
        "single_level": _single_level(slip, mu, noise),
    }
    for name, is_beyond in limits.items():
        rows = np.flatnonzero(is_beyond)
        if len(rows):
            before, row = rows[0], rows[0] + 1
            numbers = {"slip": slip[row], "mu": mu[row], "at": slip[before], "before": mu[before]}
            yield run_id, fault("odd_alone", name, **numbers).reason
            return


def _too_fast_rise(slip: FloatArray, mu: FloatArray, noise: FloatArray) -> BoolArray:
    """Whether mu rises to each point but the first faster than the slip, shape (points - 1,)."""
    largest_start = np.maximum(mu[:-1], 0.0) + noise[:-1] + _ZERO_ERROR
    return np.asarray(mu[1:] - noise[1:] > _MARGIN * largest_start * slip[1:] / slip[:-1])


def _too_fast_fall(slip: FloatArray, mu: FloatArray, noise: FloatArray) -> BoolArray:
    """Whether mu falls to each point but the first faster than by heat, shape (points - 1,)."""
    smallest_mu = (mu[:-1] - noise[:-1]) * (slip[:-1] / slip[1:]) ** _STEEPEST_FALL / _MARGIN
    return np.asarray(mu[1:] + noise[1:] + _ZERO_ERROR < smallest_mu)


def _valley(mu: FloatArray, noise: FloatArray) -> BoolArray:
    """Whether each point but the first is in a valley between two peaks, shape (points - 1,)."""
    before = np.maximum.accumulate(mu - noise)
    after = np.maximum.accumulate((mu - noise)[::-1])[::-1]
    edge = np.minimum(before, after)
    return np.asarray((edge > _DEEPEST_VALLEY * (mu + noise))[1:])


def _single_level(slip: FloatArray, mu: FloatArray, noise: FloatArray) -> BoolArray:
    """Whether each point but the first leaves a curve that is smooth without it, (points - 1,).

    The curve is a polynomial of ln mu over the scaled slip through two neighbours on either side.
    Only the point that is farthest off can be named. The ends have no neighbours on one side.
    """
    is_off = np.zeros(len(mu), dtype=bool)
    levels_with_traction = np.flatnonzero(mu > _CARRIES_TRACTION)
    if len(levels_with_traction) < _FEWEST_LEVELS:
        return is_off[1:]
    scaled, log_mu = scaled_slip(slip[levels_with_traction]), np.log(mu[levels_with_traction])
    deviation = _off_neighbours(scaled, log_mu)
    excess = np.zeros(len(levels_with_traction))
    for row in range(1, len(levels_with_traction) - 1):
        other_levels = np.delete(np.arange(len(levels_with_traction)), row)
        roughness = np.abs(_off_neighbours(scaled[other_levels], log_mu[other_levels])).max()
        excess[row] = abs(deviation[row]) / max(roughness, _ROUGHNESS)
    worst = int(first_largest(excess))
    worst_point = levels_with_traction[worst]
    size = abs(deviation[worst]) - noise[worst_point] / mu[worst_point]
    is_off[worst_point] = excess[worst] > _TIMES_THE_REST and size > _OFF_THE_CURVE
    return is_off[1:]


def _off_neighbours(scaled: FloatArray, log_mu: FloatArray) -> FloatArray:
    """ln mu less that of the curve through the neighbours of each point; 0 at the ends."""
    deviation = np.zeros(len(scaled))
    for row in range(1, len(scaled) - 1):
        window = np.arange(max(0, row - _NEIGHBOURS), min(len(scaled), row + _NEIGHBOURS + 1))
        neighbours = window[window != row]
        curve = np.polynomial.Polynomial.fit(
            scaled[neighbours], log_mu[neighbours], len(neighbours) - 1
        )
        deviation[row] = log_mu[row] - curve(scaled[row])
    return deviation
