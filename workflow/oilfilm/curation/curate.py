"""Samples to plateaus with verdicts: one engine for every kind of rig.

samples -> signals -> zero -> plateaus -> derived quantities -> gates -> verdicts. A `RigKind` has
everything in which the rigs differ.

Runs that repeat each other are copies, conditions run twice, or wrong labels. A rule compares the
accepted runs of a campaign with each other. If several runs of a condition can be right, the first
by name is kept. Two runs that contradict each other are both refused. Of three or more, a run is
refused if most of the others contradict it. Then the shape of each curve is judged beside the
others (`curve_shapes`). If this refuses a run that was kept, the next one that repeats it is kept.

Decides: when a run repeats an earlier one, and which of them is kept; warnings about a run beside
the others of its rig.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import scipy

from oilfilm import tables
from oilfilm.base.ties import exceeds, reaches
from oilfilm.base.units import BoolArray, FloatArray
from oilfilm.curation.curve_shapes import SHAPE_COLUMNS, ShapeVerdicts, judge_shapes
from oilfilm.curation.gate import refusal_by, sentence_named
from oilfilm.curation.hypotheses import RULES_WITH_HIDDEN_CAUSE, Hypothesis
from oilfilm.curation.measure import measure_run
from oilfilm.curation.plateau_gates import (
    controlled_speeds,
    judge_plateaus,
    quarantine_rows,
    refusals_of_unusable_runs,
)
from oilfilm.curation.rig_kind import TRACTION_KIND, MeasuredRun, RigKind
from oilfilm.curation.rig_spin import spin_warnings
from oilfilm.curation.run_gates import first_refusal, warnings_about
from oilfilm.curation.statistics import Stretches
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.logs.base import SETTLED_LOG_KIND, ColumnArrays, Refusal
from oilfilm.logs.ingest import IngestedLogs, ingest_logs, open_sample_files
from oilfilm.logs.raw_files import RawLogs
from oilfilm.logs.run_sheet import NO_SHEET, RunSheet
from oilfilm.settings.config import CopySettings, GateSettings
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.set_points import NOMINAL_COLUMNS, with_matched_set_points

# ---------------------------------------------------------------- repeats

# Number of last plateaus by whose load, speed and temperature copies are looked up among all runs.
_LAST_PLATEAUS_LOOKED_UP = 3
# Probability that some run is taken for a copy in a campaign without copies.
_CHANCE_OF_A_FALSE_COPY = 1e-3
# Reading of a sensor -> key of `full_scale` in the rig's file.
_FULL_SCALE_KEY_OF_READING = {
    "load_n": "load_n",
    "traction_force_n": "traction_force_n",
    "surface_speed_m_s": "surface_speed_m_s",
    "inlet_temperature_c": "temperature_c",
}
# Columns of the points that have these readings.
_SENSOR_COLUMNS = (
    "load_n",
    "traction_force_n",
    "inlet_temperature_c",
    "entrainment_speed_m_s",
    "slide_roll_ratio",
)
# Two measured slips of one set slip differ by less than this ratio.
_SAME_SLIP_RATIO = 1.02
# Columns of the points in which a copy repeats the noise of its original.
_SLIP_AND_MU = ["slide_roll_ratio", "traction_coefficient"]
_SLIP_AND_MU_ERRORS = [f"{name}_se" for name in _SLIP_AND_MU]
# Columns in which a copy has the same conditions.
_COPY_CONDITIONS = ["load_n", "entrainment_speed_m_s", "inlet_temperature_c"]


class _RepeatRefusal(NamedTuple):
    """The refusal of a run that repeats or contradicts others.

    Attributes:
        refusal: The refusal of that run.
        kept_id: Id of the run that is kept in its place; empty where none is.
    """

    refusal: Refusal
    kept_id: str = ""


def _repeat_refusals(
    campaign_tables: CampaignTables,
    runs: pd.DataFrame,
    rig_class: type[RigKind],
    settings: Settings,
) -> dict[str, _RepeatRefusal]:
    """Id of a run -> its refusal, of accepted runs that repeat or contradict others.

    Copies are found first. Repeated conditions are allowed on a torque rig, and in a campaign that
    accepts them.

    Args:
        campaign_tables: The table `points`, of which each rule reads the columns that it compares.
        runs: Table of runs.
        rig_class: The class of the kind of rig.
        settings: Settings of the campaign.
    """
    remaining_runs = runs[runs["verdict"] == "accepted"].sort_values(
        ["file", "run_id"], ignore_index=True
    )
    repeat_refusal_of_run: dict[str, _RepeatRefusal] = {}
    for repeat_refusal in _refusals_of_same_readings(
        campaign_tables, remaining_runs, rig_class, settings
    ):
        repeat_refusal_of_run.setdefault(repeat_refusal.refusal.run_id, repeat_refusal)
    if rig_class.name == TRACTION_KIND and settings.campaign.repeated_conditions != "accept":
        remaining_runs = remaining_runs[~remaining_runs["run_id"].isin(repeat_refusal_of_run)]
        repeat_refusal_of_run |= {
            repeat_refusal.refusal.run_id: repeat_refusal
            for repeat_refusal in _refusals_of_same_conditions(
                campaign_tables, remaining_runs, settings
            )
        }
    return repeat_refusal_of_run


def _refusals_of_same_readings(
    campaign_tables: CampaignTables,
    runs: pd.DataFrame,
    rig_class: type[RigKind],
    settings: Settings,
) -> Iterator[_RepeatRefusal]:
    """Refusals of copies of an earlier log, and of the same readings under two names of oils."""
    pairs = list(_pairs_with_same_readings(campaign_tables, runs, rig_class, settings))
    # the verdicts on all earlier runs are known when a later one is judged
    pairs.sort(key=lambda pair: (pair[1].Index, pair[0].Index))
    refused_ids: set[str] = set()
    for first_run, later_run in pairs:
        is_first_refused = first_run.run_id in refused_ids
        if first_run.oil == later_run.oil and not is_first_refused:
            refused_ids.add(later_run.run_id)
            kept_id = first_run.run_id
            refusal = refusal_by("duplicate_log", run_id=later_run.run_id, kept=kept_id)
            yield _RepeatRefusal(refusal, kept_id)
    for pair in pairs:
        for refused_run, other_run in (pair, pair[::-1]):
            if refused_run.oil != other_run.oil:
                fields = dict(other_id=other_run.run_id, other_oil=other_run.oil)
                yield _RepeatRefusal(
                    refusal_by("conflicting_labels", run_id=refused_run.run_id, **fields)
                )


def _refusals_of_same_conditions(
    campaign_tables: CampaignTables, runs: pd.DataFrame, settings: Settings
) -> Iterator[_RepeatRefusal]:
    """Refusals of runs that contradict others of their condition, and of runs that repeat it.

    Of the runs without a contradiction the first one is kept. Two runs contradict each other if
    they differ by more than `repeat_difference_max`. Of three or more runs, one may be odd at a
    smaller difference. It is odd if the others agree far better with each other than with it. Runs
    without a common slip are not compared, and all of them are kept.
    """
    gate_limits = settings.gates
    allowed_difference = gate_limits.repeat_difference_max
    for run_ids, differences in _differences_by_condition(campaign_tables, runs, settings):
        kept_indices: list[int] = []
        largest_of_others_by_run = _largest_difference_of_others(differences)
        for run_index, run_id in enumerate(run_ids):
            is_compared = np.isfinite(differences[run_index])
            is_compared[run_index] = False
            other_indices = np.flatnonzero(is_compared)
            if len(other_indices) == 0:
                kept_indices.append(run_index)
                continue
            differences_to_others = differences[run_index, other_indices]
            largest_difference_of_others = largest_of_others_by_run[run_index]
            has_several_others = len(other_indices) > 1 and np.isfinite(
                largest_difference_of_others
            )
            odd_limit = allowed_difference
            if has_several_others:
                odd_limit = max(
                    gate_limits.repeat_odd_min,
                    gate_limits.repeat_odd_factor * largest_difference_of_others,
                )
            contradicting_indices = other_indices[differences_to_others > allowed_difference]
            if len(contradicting_indices) <= len(other_indices) / 2:
                contradicting_indices = other_indices[differences_to_others > odd_limit]
                if len(contradicting_indices) < len(other_indices):
                    kept_indices.append(run_index)
                    continue
            more_in_words = (
                f" (and {len(contradicting_indices) - 1} more)"
                if len(contradicting_indices) > 1
                else ""
            )
            agreement_in_words = ""
            if has_several_others:
                agreement_in_words = f"; the others agree within {largest_difference_of_others:.1%}"
            fields = dict(
                other_id=run_ids[contradicting_indices[0]],
                difference=differences[run_index, contradicting_indices[0]],
                more=more_in_words,
                agree=agreement_in_words,
                allowed=min(odd_limit, allowed_difference),
            )
            yield _RepeatRefusal(refusal_by("conflicting_condition", run_id=run_id, **fields))
        yield from _refusals_of_later_runs(run_ids, differences, kept_indices)


def _refusals_of_later_runs(
    run_ids: list[str], differences: FloatArray, indices_without_conflict: list[int]
) -> Iterator[_RepeatRefusal]:
    """Refusals of runs that repeat an earlier one of their condition, which is kept.

    Args:
        run_ids: Ids of the runs of a condition, in the order of names.
        differences: Differences of the runs, as `_curve_differences` gives them.
        indices_without_conflict: Indices of the runs that the others do not contradict, ascending.
    """
    kept_indices: list[int] = []
    for run_index in indices_without_conflict:
        for earlier_index in kept_indices:
            difference = differences[earlier_index, run_index]
            if np.isfinite(difference):
                kept_id = run_ids[earlier_index]
                fields = dict(kept=kept_id, difference=difference)
                refusal = refusal_by("duplicate_condition", run_id=run_ids[run_index], **fields)
                yield _RepeatRefusal(refusal, kept_id)
                break
        else:
            kept_indices.append(run_index)


def _largest_difference_of_others(differences: FloatArray) -> FloatArray:
    """For each run, the largest difference between two of the other runs, shape (n,).

    It is -inf where no two of them are compared.

    Args:
        differences: Differences of n runs, shape (n, n), symmetric; NaN where they are unknown.
    """
    run_count = len(differences)
    known_differences = np.where(np.isnan(differences), -np.inf, differences)
    # no run is compared with itself
    np.fill_diagonal(known_differences, -np.inf)
    largest_of_others = np.full(run_count, known_differences.max())
    # only the two runs that are farthest apart have another largest difference
    for run_index in np.unravel_index(np.argmax(known_differences), differences.shape):
        other_indices = np.delete(np.arange(run_count), run_index)
        largest_of_others[run_index] = known_differences[np.ix_(other_indices, other_indices)].max(
            initial=-np.inf
        )
    return largest_of_others


def _differences_by_condition(
    campaign_tables: CampaignTables, runs: pd.DataFrame, settings: Settings
) -> Iterator[tuple[list[str], FloatArray]]:
    """For each condition of several runs: their ids, and the differences of their curves.

    A condition is an oil, a rig and set points. The differences are those of `_curve_differences`.

    Loads are compared as the pressures that they make, where the rig's contact is known: a pressure
    that is rounded by 0.5 % stands for a load that is off by 1.5 %.
    """
    pressure_column, load_column = NOMINAL_COLUMNS[:2]
    runs_with_set_points = with_matched_set_points(runs, settings)
    runs_with_set_points = runs_with_set_points[
        runs_with_set_points[[pressure_column, load_column]].notna().any(axis=1)
    ]
    # one of the two is unknown, and unknown values would not be compared
    runs_with_set_points = runs_with_set_points.fillna({pressure_column: -1, load_column: -1})
    runs_by_condition = list(
        _runs_with_same_values(runs_with_set_points, ["oil", "rig", *NOMINAL_COLUMNS])
    )
    if not runs_by_condition:
        return
    columns = ["run_id", "accepted", *_SLIP_AND_MU, "traction_coefficient_se"]
    points = campaign_tables.table("points", columns)
    is_of_condition = points["run_id"].isin(
        {run.run_id for runs_of_condition in runs_by_condition for run in runs_of_condition}
    )
    accepted_points = points[points["accepted"] & is_of_condition]
    point_indices_of_run = accepted_points.groupby("run_id").indices
    for runs_of_condition in runs_by_condition:
        run_ids = [run.run_id for run in runs_of_condition]
        curves = [
            _curve_of_run(accepted_points.iloc[point_indices_of_run[run_id]]) for run_id in run_ids
        ]
        yield run_ids, _curve_differences(curves, settings.gates.sign_slip_min)


def _runs_with_same_values(runs: pd.DataFrame, columns: list[str]) -> Iterator[list[Any]]:
    """Groups of two or more runs with the same values of some columns.

    Runs with an empty value are left out.
    """
    with_values = runs[runs[columns].notna().all(axis=1) & (runs[columns] != "").all(axis=1)]
    # most runs have values of their own: to make a group for each would take long
    for _, runs_of_group in with_values[with_values.duplicated(columns, keep=False)].groupby(
        columns, sort=False
    ):
        yield list(runs_of_group.itertuples())


def _pairs_with_same_readings(
    campaign_tables: CampaignTables,
    runs: pd.DataFrame,
    rig_class: type[RigKind],
    settings: Settings,
) -> Iterator[tuple[Any, Any]]:
    """Pairs of runs: from files of the same content, or with plateaus of the same noise."""
    run_of_id: dict[str, Any] = {str(run.run_id): run for run in runs.itertuples()}
    # a file may hold several runs. "in " keeps the name of the only run of a file from being empty:
    # `_runs_with_same_values` leaves out runs with an empty value
    names_in_files = [f"in {run_id.removeprefix(run.file)}" for run_id, run in run_of_id.items()]
    runs_with_names = runs.assign(name_in_file=names_in_files)
    for same_runs in _runs_with_same_values(runs_with_names, ["content_sha256", "name_in_file"]):
        for later_run in same_runs[1:]:
            yield same_runs[0], later_run
    if rig_class.name == TRACTION_KIND:
        copy_settings = settings.gates.copies
        run_ids = pd.Index(runs["run_id"])
        columns = ["run_id", *_SLIP_AND_MU, *_SLIP_AND_MU_ERRORS, *_COPY_CONDITIONS]
        last_points_of_blocks = []
        for points in campaign_tables.blocks("points", columns):
            has_errors = (points[_SLIP_AND_MU_ERRORS] > 0).all(axis=1)
            compared_points = points[_is_point_of_runs(points, run_ids) & has_errors]
            last_points_of_blocks.append(
                compared_points.groupby("run_id").tail(copy_settings.plateaus + 1)
            )
        last_points = pd.concat(last_points_of_blocks, ignore_index=True)
        for pair_ids in _pairs_with_same_noise(last_points, copy_settings):
            first_run, later_run = sorted(
                (run_of_id[run_id] for run_id in pair_ids), key=lambda run: run.Index
            )
            yield first_run, later_run


def _is_point_of_runs(points: pd.DataFrame, run_ids: pd.Index) -> BoolArray:
    """Whether each point is of one of some runs, shape (points,).

    An index of the ids is faster than `isin`, because many parts of the points share it.
    """
    return np.asarray(run_ids.get_indexer(pd.Index(points["run_id"])) >= 0)


def _pairs_with_same_noise(
    points: pd.DataFrame, copy_settings: CopySettings
) -> Iterator[tuple[str, str]]:
    """Ids of pairs of runs whose plateaus differ by far less than their own standard errors.

    Two tests of the same condition differ by about their errors. The same readings do not, even if
    they are rounded or cut off at other rows. The last plateaus of both runs are compared, without
    the very last one: it ends with the log, or with a step that is found to within a few rows.
    """
    # the rows of each run in the order of the ids that `groupby` gives
    points = points.sort_values("run_id", kind="stable", ignore_index=True)
    points_by_run = points.groupby("run_id")
    point_counts = points_by_run.size()
    run_ids = point_counts.index[point_counts > copy_settings.plateaus]
    last_points = points_by_run.tail(copy_settings.plateaus + 1)
    last_points = last_points.drop(points_by_run.tail(1).index)
    last_points = last_points[last_points["run_id"].isin(run_ids)]
    if len(run_ids) < 2:
        return

    def last_values(columns: list[str]) -> FloatArray:
        """Values of the last plateaus of each run, shape (runs, plateaus, columns)."""
        return (
            last_points[columns].to_numpy(float).reshape(len(run_ids), copy_settings.plateaus, -1)
        )

    means = last_values(_SLIP_AND_MU)
    standard_errors = last_values(_SLIP_AND_MU_ERRORS)
    conditions = last_values(_COPY_CONDITIONS)
    conditions = np.nan_to_num(conditions[:, -_LAST_PLATEAUS_LOOKED_UP:].reshape(len(run_ids), -1))
    # two conditions are near where they differ by less than 1 once they are scaled
    condition_tolerance = copy_settings.condition * np.abs(conditions).max(axis=0)
    scaled_conditions = conditions / np.where(condition_tolerance > 0, condition_tolerance, 1.0)
    tree = scipy.spatial.cKDTree(scaled_conditions)
    pair_count = (int(tree.count_neighbors(tree, 1.0, p=np.inf)) - len(run_ids)) // 2
    # of slip and of mu
    rms_limits = np.array(
        [copy_settings.slip_errors, _allowed_traction_errors(copy_settings, pair_count)]
    )
    # Steps of mu between neighbouring plateaus do not depend on the zero: pairs with similar steps
    # may be copies. A step may differ by no more than this: the whole sum of squares that a copy
    # may have, as if it were in one step. This only preselects pairs.
    mu_steps = np.diff(means[..., 1], axis=1)
    mu_step_tolerance = (
        2 * rms_limits[1] * np.sqrt(copy_settings.plateaus) * standard_errors[..., 1].max()
    )
    coordinates = np.concatenate([scaled_conditions, mu_steps / mu_step_tolerance], axis=1)
    tree = scipy.spatial.cKDTree(coordinates)
    for run_index, other_index in sorted(tree.query_pairs(1.0, p=np.inf)):
        difference = means[run_index] - means[other_index]
        # the zero of the force may be that of other rows, and rounding moves the speeds
        difference -= np.median(difference, axis=0)
        difference_in_errors = difference / np.hypot(
            standard_errors[run_index], standard_errors[other_index]
        )
        rms = np.sqrt(np.mean(difference_in_errors**2, axis=0))
        if (rms < rms_limits).all():
            yield run_ids[run_index], run_ids[other_index]


def _allowed_traction_errors(copy_settings: CopySettings, pair_count: int) -> float:
    """Largest rms difference of mu over its standard errors at which a pair is a copy.

    The more pairs are compared, the smaller are the differences that occur by chance. A difference
    below this limit occurs by chance in one of a thousand campaigns. The sum of squares of m
    differences, less their mean, has the chi-squared distribution of m - 1 degrees of freedom.
    """
    chance_per_pair = _CHANCE_OF_A_FALSE_COPY / max(pair_count, 1)
    degrees_of_freedom = copy_settings.plateaus - 1
    sum_of_squares = 2 * scipy.special.gammaincinv(degrees_of_freedom / 2, chance_per_pair)
    return min(
        copy_settings.traction_errors, float(np.sqrt(sum_of_squares / copy_settings.plateaus))
    )


class _Curve(NamedTuple):
    """Rising slips of a run, its traction coefficients and their standard errors, shape (n,)."""

    slip: FloatArray
    mu: FloatArray
    mu_se: FloatArray


def _curve_differences(curves: Sequence[_Curve], smallest_slip: float) -> FloatArray:
    """Median relative difference of each two curves over the slips that both have.

    One curve is interpolated at the slips of the other, and the smaller of both differences counts.
    Twice the standard error of each difference is subtracted where it is known.

    Args:
        curves: The curves, n of them.
        smallest_slip: Smaller slips are not compared.

    Returns:
        Shape (n, n), symmetric; NaN where no slip of one curve is among those of the other.
    """
    slip_of_curves = np.concatenate([curve.slip for curve in curves])
    mu_of_curves = np.concatenate([curve.mu for curve in curves])
    mu_se_of_curves = np.concatenate([curve.mu_se for curve in curves])
    curve_of_all_points = np.repeat(np.arange(len(curves)), [len(curve.slip) for curve in curves])
    # from the row's curve, interpolated, to the points of the column's
    differences = np.full((len(curves), len(curves)), np.nan)
    for curve_index, (slip, mu, mu_se) in enumerate(curves):
        is_shared = slip_of_curves >= max(slip.min() / _SAME_SLIP_RATIO, smallest_slip)
        is_shared &= slip_of_curves <= slip.max() * _SAME_SLIP_RATIO
        shared_slip = slip_of_curves[is_shared]
        shared_mu = mu_of_curves[is_shared]
        expected_mu = np.interp(shared_slip, slip, mu)
        expected_se = np.interp(shared_slip, slip, mu_se)
        error = np.nan_to_num(2 * np.hypot(mu_se_of_curves[is_shared], expected_se))
        excess = np.maximum(np.abs(shared_mu - expected_mu) - error, 0.0)
        mean_size = (np.abs(shared_mu) + np.abs(expected_mu)) / 2
        curve_of_point = curve_of_all_points[is_shared]
        compared_curves, start_indices = np.unique(curve_of_point, return_index=True)
        if len(compared_curves):
            stretches = Stretches(start_indices, np.append(start_indices[1:], len(curve_of_point)))
            differences[curve_index, compared_curves] = stretches.medians(excess / mean_size)
    # a curve of few slips is no curve between them: the other one is interpolated
    smaller_differences: FloatArray = np.minimum(differences, differences.T)
    return smaller_differences


def _curve_of_run(points: pd.DataFrame) -> _Curve:
    """The curve of a run."""
    ordered = points.sort_values("slide_roll_ratio", kind="stable")
    return _Curve(
        slip=ordered["slide_roll_ratio"].to_numpy(float),
        mu=ordered["traction_coefficient"].to_numpy(float),
        mu_se=ordered["traction_coefficient_se"].to_numpy(float),
    )


# Id of a run, and the sentence of a warning about it.
RunWarning = tuple[str, str]


def with_campaign_warnings(
    runs: pd.DataFrame,
    campaign_tables: CampaignTables,
    rig_class: type[RigKind],
    settings: Settings,
    shape_warnings: Iterable[RunWarning],
) -> pd.DataFrame:
    """The table of runs with the warnings that need more than the run itself.

    They follow from the other runs of a rig, and from the files of rigs and oils.

    Args:
        runs: Table of runs.
        campaign_tables: The table `points`, of which each rule reads the columns that it compares.
        rig_class: The class of the kind of rig.
        settings: Settings of the campaign.
        shape_warnings: Warnings about the shapes of curves: id of the run and a sentence.
    """
    if rig_class.name != TRACTION_KIND:
        return runs
    accepted_runs = runs[runs["verdict"] == "accepted"].set_index("run_id")
    warnings_of_run = {
        run_id: list(own_warnings) for run_id, own_warnings in accepted_runs["warning"].items()
    }

    def points_of_accepted_runs(*columns: str) -> Iterator[pd.DataFrame]:
        """Some columns of the points of accepted runs, some rows at a time."""
        for points in campaign_tables.blocks("points", ["run_id", *columns]):
            yield points[_is_point_of_runs(points, accepted_runs.index)]

    for run_id, sentence in chain(
        shape_warnings,
        _channel_warnings(
            points_of_accepted_runs("load_n", "inlet_temperature_c"), accepted_runs, settings.gates
        ),
        _rig_warnings(points_of_accepted_runs(*_SENSOR_COLUMNS), accepted_runs["rig"], settings),
        spin_warnings(
            points_of_accepted_runs("accepted", *_SLIP_AND_MU, "load_n"),
            accepted_runs["rig"],
            settings,
        ),
        _oil_warnings(accepted_runs["oil"], settings),
        _speed_warnings(
            lambda: points_of_accepted_runs(
                "accepted", "entrainment_speed_m_s", "slide_roll_ratio"
            ),
            accepted_runs,
            settings.gates,
        ),
    ):
        warnings_of_run[run_id].append(sentence)
    warnings = [tuple(warnings_of_run.get(run_id, ())) for run_id in runs["run_id"]]
    return runs.assign(warning=tables.list_column(warnings, runs.index))


def _rig_warnings(
    points_in_parts: Iterable[pd.DataFrame], rig_name_of_run: "pd.Series[str]", settings: Settings
) -> Iterator[RunWarning]:
    """Warnings from the files of rigs: readings beyond the full scale, impossible materials.

    Args:
        points_in_parts: Points of accepted runs, some of them at a time.
        rig_name_of_run: Name of the rig of each run, by the id of the run.
        settings: The rigs.
    """
    largest_in_parts = [
        _sensor_readings(points).abs().groupby(points["run_id"]).max() for points in points_in_parts
    ]
    # the rows of a run may be in two parts
    largest_readings = pd.concat(largest_in_parts).groupby(level=0).max()
    readings_by_rig = largest_readings.groupby(rig_name_of_run.reindex(largest_readings.index))
    for rig_name, readings_of_rig in readings_by_rig:
        rig = settings.rigs.get(str(rig_name))
        if rig is None:
            continue
        advice = f"correct {rig_name}.yaml"
        for doubt in rig.doubts():
            for run_id in readings_of_rig.index:
                yield str(run_id), f"unusual_rig: {doubt}; {advice}"
        if rig.full_scale is None:
            continue
        for column, key in _FULL_SCALE_KEY_OF_READING.items():
            full_scale = getattr(rig.full_scale, key)
            largest_readings_of_column = readings_of_rig[column]
            for run_id, largest_reading in largest_readings_of_column[
                exceeds(largest_readings_of_column, full_scale)
            ].items():
                fields = dict(
                    column=column, largest=largest_reading, full_scale=full_scale, key=key
                )
                yield str(run_id), f"{sentence_named('full_scale', **fields)}; {advice}"


def _sensor_readings(points: pd.DataFrame) -> pd.DataFrame:
    """Readings of the sensors of a rig, one row per point; of both bodies the faster one."""
    faster_m_s = controlled_speeds(points)["speed of the faster body"]
    return points.assign(surface_speed_m_s=faster_m_s)[list(_FULL_SCALE_KEY_OF_READING)]


def _oil_warnings(oil_name_of_run: "pd.Series[str]", settings: Settings) -> Iterator[RunWarning]:
    """Warnings from the files of oils.

    Args:
        oil_name_of_run: Name of the oil of each run, by the id of the run.
        settings: The oils.
    """
    for oil_name, runs_of_oil in oil_name_of_run.groupby(oil_name_of_run):
        oil_file = settings.oils[str(oil_name)]
        if oil_file is None:
            continue
        for doubt in oil_file.doubts():
            for run_id in runs_of_oil.index:
                yield str(run_id), f"unusual_oil: {doubt}; correct {oil_name}.yaml"


def _speed_warnings(
    read_points: Callable[[], Iterable[pd.DataFrame]], runs: pd.DataFrame, gate_limits: GateSettings
) -> Iterator[RunWarning]:
    """Warnings about runs in which a rig holds the speed of one body.

    Args:
        read_points: Gives the points of accepted runs, some of them at a time. It is called twice.
        runs: Accepted runs, by their ids.
        gate_limits: `speed_tolerance`.
    """
    set_speed_of_run = runs["nominal_entrainment_speed_m_s"]
    ids_of_runs_off_speed: set[str] = set()
    for points_of_part in read_points():
        points = points_of_part[points_of_part["accepted"]]
        set_speed_of_points = set_speed_of_run.reindex(points["run_id"]).to_numpy()
        deviation = (points["entrainment_speed_m_s"] - set_speed_of_points).abs()
        is_off = exceeds(deviation, gate_limits.speed_tolerance * set_speed_of_points)
        ids_of_runs_off_speed |= set(points.loc[is_off, "run_id"])
    if not ids_of_runs_off_speed:
        return
    points_off_speed = pd.concat(
        [part[part["run_id"].isin(ids_of_runs_off_speed)] for part in read_points()]
    )
    for run_id, points_of_run in points_off_speed[points_off_speed["accepted"]].groupby("run_id"):
        entrainment_speed_m_s = points_of_run["entrainment_speed_m_s"]
        set_speed_m_s = set_speed_of_run[run_id]
        # the gate `speed_off_nominal` has accepted the points: one of the speeds is the set one
        largest_deviation_by_name = {
            name: float((speed - set_speed_m_s).abs().max())
            for name, speed in controlled_speeds(points_of_run).items()
        }
        speed_name = min(largest_deviation_by_name, key=largest_deviation_by_name.__getitem__)
        if exceeds(
            largest_deviation_by_name[speed_name], gate_limits.speed_tolerance * set_speed_m_s
        ):
            # which body is faster changes with the direction of slip, which points do not have
            speed_name = "speed of one body, in both directions of slip,"
        fields = dict(
            control=speed_name,
            set=set_speed_m_s,
            least=entrainment_speed_m_s.min(),
            most=entrainment_speed_m_s.max(),
        )
        yield str(run_id), sentence_named("body_at_set_speed", **fields)


def _channel_warnings(
    points_in_parts: Iterable[pd.DataFrame], runs: pd.DataFrame, gate_limits: GateSettings
) -> Iterator[RunWarning]:
    """Warnings about a channel that is one number in all plateaus, and moves in most other runs.

    Args:
        points_in_parts: Points of accepted runs, some of them at a time.
        runs: Accepted runs, by their ids.
        gate_limits: `constant_channel_plateaus` and `constant_channel_runs`.
    """
    channel_name_of_column = {"load_n": "load", "inlet_temperature_c": "inlet temperature"}
    ranges_of_parts = pd.concat(
        [
            points.groupby("run_id")[list(channel_name_of_column)].agg(["min", "max", "size"])
            for points in points_in_parts
        ]
    )
    for column, channel_name in channel_name_of_column.items():
        # the rows of a run may be in two parts
        ranges_by_run = pd.DataFrame(ranges_of_parts[column]).groupby(level=0)
        ranges = pd.DataFrame(
            {
                "min": ranges_by_run["min"].min(),
                "max": ranges_by_run["max"].max(),
                "size": ranges_by_run["size"].sum(),
            }
        )
        # a run without this channel has no range
        judged_ranges = ranges[
            (ranges["size"] >= gate_limits.constant_channel_plateaus) & ranges["min"].notna()
        ]
        is_constant = pd.Series(
            reaches(judged_ranges["min"], judged_ranges["max"]), judged_ranges.index
        )
        rig_name_of_run = runs["rig"].reindex(judged_ranges.index)
        for _, is_constant_of_rig in is_constant.groupby(rig_name_of_run):
            run_count = len(is_constant_of_rig)
            moving_count = (~is_constant_of_rig).sum()
            if run_count < gate_limits.constant_channel_runs or is_constant_of_rig.mean() >= 1 / 2:
                continue
            fields = dict(name=channel_name, others=moving_count, runs=run_count)
            for run_id in is_constant_of_rig.index[is_constant_of_rig]:
                value = ranges["min"].loc[run_id]
                yield str(run_id), sentence_named("constant_channel", value=value, **fields)


# ---------------------------------------------------------------- the engine


@dataclass(frozen=True)
class CuratedTables:
    """Tables of a campaign or of a share of its logs.

    Attributes:
        points: Table of plateaus, `RigKind.table_name`.
        runs: Table of runs with their verdicts.
        quarantine: Table of quarantine.
    """

    points: pd.DataFrame
    runs: pd.DataFrame
    quarantine: pd.DataFrame


def curate_logs(
    logs: Iterable[tuple[str, bytes]],
    settings: Settings,
    rig_class: type[RigKind] = TractionRig,
    sheet: RunSheet = NO_SHEET,
) -> CuratedTables:
    """Read logs into samples and curate these.

    Args:
        logs: Name and bytes of each log.
        settings: Settings of the campaign.
        rig_class: The class of the kind of rig.
        sheet: The run sheet.

    Raises:
        OilfilmError: As in `ingest_logs`, or a table is not as it is declared.
    """
    return curate_ingested(
        ingest_logs(logs, settings, rig_class.log_schema, sheet), rig_class(settings)
    )


def curate_ingested(ingested: IngestedLogs, rig_kind: RigKind) -> CuratedTables:
    """Curate all logs of a campaign.

    Raises:
        OilfilmError: A table is not as it is declared.
    """
    samples = ingested.all_samples()
    curated = collect(
        curate_parts([samples], ingested, rig_kind), rig_kind.settings, type(rig_kind)
    )
    # tables that the workflow could not write must not pass here
    if rig_kind.name == TractionRig.name:
        tables.conform(samples, "samples", "samples of these logs")
    tables.conform(curated.points, rig_kind.table_name, "plateaus of these logs")
    return curated


def curate_share(
    logs: RawLogs,
    settings: Settings,
    sheet: RunSheet,
    sample_file_of_oil: Mapping[str, Path],
    provenance: Mapping[str, Any],
) -> CuratedTables:
    """Read a share of the logs, write its samples and curate them.

    The memory needed does not grow with the size of the share.

    Args:
        logs: The logs.
        settings: Settings of the campaign.
        sheet: The run sheet.
        sample_file_of_oil: File of each oil's samples.
        provenance: As for `tables.writing`.
    """
    with open_sample_files(sample_file_of_oil, provenance) as keep_run:
        ingested = ingest_logs(
            logs, settings, sheet=sheet, keep_run=keep_run, digest_of_log=logs.digest_of_log
        )
    parts = tables.read_blocks("samples", *sample_file_of_oil.values())
    return curate_parts(parts, ingested, TractionRig(settings))


def curate_parts(
    samples_in_parts: Iterable[pd.DataFrame], ingested: IngestedLogs, rig_kind: RigKind
) -> CuratedTables:
    """Curate samples that come in parts, of which one at a time is in memory.

    Args:
        samples_in_parts: Parts of the table of samples, each with complete runs.
        ingested: The logs of the samples.
        rig_kind: The kind of rig, with its settings.

    Returns:
        The quarantine has the refusals of ingest too.
    """
    runs = ingested.runs
    ids_without_rows = runs["run_id"]
    curated_parts: list[CuratedTables] = []
    for samples_of_runs in samples_in_parts:
        run_ids = samples_of_runs["run_id"].unique()
        ids_without_rows = ids_without_rows[~ids_without_rows.isin(run_ids)]
        curated_parts.append(
            curate_samples(samples_of_runs, runs[runs["run_id"].isin(run_ids)], rig_kind)
        )
    curated_parts.append(
        curate_samples(tables.empty_table("samples"), runs.loc[ids_without_rows.index], rig_kind)
    )
    quarantine = [ingested.quarantine, *(curated_part.quarantine for curated_part in curated_parts)]
    return CuratedTables(
        points=pd.concat(
            [curated_part.points for curated_part in curated_parts], ignore_index=True
        ),
        runs=pd.concat([curated_part.runs for curated_part in curated_parts], ignore_index=True),
        quarantine=pd.concat(quarantine, ignore_index=True),
    )


def curate_samples(samples: pd.DataFrame, runs: pd.DataFrame, rig_kind: RigKind) -> CuratedTables:
    """Plateaus of every run, judged by every gate of the rig.

    No run is compared with another: `compare_runs` does this for a whole campaign.

    Args:
        samples: Table of samples, the rows of a run together.
        runs: Table of runs as ingested.
        rig_kind: The kind of rig, with its settings.
    """
    samples_of_run = _samples_by_run(samples)
    measured = _measure_runs(samples_of_run, runs, rig_kind)
    judged = _judge_plateaus_and_runs(measured)
    explained_refusals: dict[str, Refusal] = {}
    for run_row in tables.rows(judged.runs[judged.runs["rule"].isin(RULES_WITH_HIDDEN_CAUSE)]):
        run_id = run_row["run_id"]
        if run_id in samples_of_run:
            explained_refusal = _explained_refusal(samples_of_run[run_id], run_row, rig_kind)
            if explained_refusal is not None:
                explained_refusals[run_id] = explained_refusal
    if not explained_refusals:
        return judged
    return _judge_plateaus_and_runs(
        replace(measured, refusal_of_run=measured.refusal_of_run | explained_refusals)
    )


@dataclass(frozen=True)
class _MeasuredRuns:
    """Runs with their plateaus, judged by the gates of runs; their plateaus are not judged yet.

    Attributes:
        points: Table of plateaus.
        runs: Table of runs, with their warnings.
        refusal_of_run: Id of a run -> its refusal.
        short_level_refusals: Refusals of levels that give no plateau.
        rig_kind: The kind of rig, with its settings.
    """

    points: pd.DataFrame
    runs: pd.DataFrame
    refusal_of_run: dict[str, Refusal]
    short_level_refusals: list[Refusal]
    rig_kind: RigKind


def _measure_runs(
    samples_of_run: Mapping[str, ColumnArrays], runs: pd.DataFrame, rig_kind: RigKind
) -> _MeasuredRuns:
    """Measure runs and judge each by the gates of runs.

    Args:
        samples_of_run: Id of a run -> its samples.
        runs: Table of runs as ingested.
        rig_kind: The kind of rig, with its settings.
    """
    refusal_of_run: dict[str, Refusal] = {}
    short_level_refusals: list[Refusal] = []
    plateaus_of_run: dict[str, ColumnArrays] = {}
    warnings_of_runs: list[tuple[str, ...]] = []
    for run_row in tables.rows(runs):
        run_id = run_row["run_id"]
        # the signals of one run at a time are in memory
        run = None
        if run_id in samples_of_run:
            run = _measure_samples(samples_of_run[run_id], run_row, rig_kind)
            plateaus_of_run[run_id] = run.plateaus
        refusal = _refusal_before_plateaus(run_row, run)
        if refusal is not None:
            refusal_of_run[run_id] = refusal
        if run is None or refusal is not None:
            warnings_of_runs.append(())
        else:
            warnings_of_runs.append(warnings_about(run))
            short_level_refusals += [
                replace(refusal, run_id=run_id) for refusal in run.short_level_refusals
            ]
    runs = runs.assign(warning=tables.list_column(warnings_of_runs, runs.index))
    points = _table_of_plateaus(plateaus_of_run, runs.set_index("run_id"), rig_kind)
    return _MeasuredRuns(points, runs, refusal_of_run, short_level_refusals, rig_kind)


def _measure_samples(
    samples: ColumnArrays, run_row: Mapping[str, Any], rig_kind: RigKind
) -> MeasuredRun:
    """A run with its plateaus.

    Args:
        samples: Samples of the run.
        run_row: Its row of the table of runs.
        rig_kind: The kind of rig, with its settings.
    """
    signals = rig_kind.make_signals(samples, run_row["rig"], rig_kind.settings)
    return measure_run(
        signals, rig_kind, run_row["rig"], is_settled=run_row["log_kind"] == SETTLED_LOG_KIND
    )


def _refusal_before_plateaus(run_row: Mapping[str, Any], run: MeasuredRun | None) -> Refusal | None:
    """The refusal of a run while its log was read, or by a gate of runs. None without one.

    Args:
        run_row: Its row of the table of runs as ingested.
        run: The run as measured; None where it has no rows.
    """
    run_id = run_row["run_id"]
    if run_row["rule"]:
        return Refusal(run_row["rule"], run_row["reason"], advice="", run_id=run_id)
    if run is None:
        return refusal_by("no_rows", run_id=run_id)
    refusal = first_refusal(run)
    return None if refusal is None else replace(refusal, run_id=run_id)


def _explained_refusal(
    samples: ColumnArrays, run_row: Mapping[str, Any], rig_kind: RigKind
) -> Refusal | None:
    """The refusal of a run by the simple mistake without which most of its plateaus would pass.

    Args:
        samples: Samples of the run.
        run_row: Its row of the table of runs.
        rig_kind: The kind of rig, with its settings.

    Returns:
        A refusal that names the mistake; None where no mistake explains the refusal.
    """
    if run_row["log_kind"] == SETTLED_LOG_KIND:
        # the rig's program has settled and converted these readings
        return None
    hypotheses = [
        hypothesis
        for hypothesis in rig_kind.hypotheses(run_row["rig"])
        if run_row["rule"] in hypothesis.explained_rules
    ]
    mistakes_of_log = [hypothesis for hypothesis in hypotheses if not hypothesis.changed_settings]
    passing_hypotheses = _passing_hypotheses(mistakes_of_log, samples, run_row, rig_kind)
    for hypothesis in hypotheses:
        # whether settings are plausible does not depend on the number of levels. To count them
        # takes time, because they must be found with the changed settings
        if hypothesis.changed_settings and hypothesis.is_plausible(samples, level_count=0):
            changed_rig_kind = type(rig_kind)(
                rig_kind.settings.with_changes(hypothesis.changed_settings)
            )
            passing_hypotheses += _passing_hypotheses(
                [hypothesis], samples, run_row, changed_rig_kind
            )
    if not passing_hypotheses:
        return None
    best_hypothesis = max(
        passing_hypotheses, key=lambda candidate: candidate.accepted_count
    ).hypothesis
    # several units may be possible: the data do not show which one it is
    sentences = [
        candidate.hypothesis.sentence
        for candidate in passing_hypotheses
        if candidate.hypothesis.rule == best_hypothesis.rule
    ]
    reason = f"the run would pass with {'; or '.join(sentences)}; as it is, {run_row['reason']}"
    return Refusal(best_hypothesis.rule, reason, advice="", run_id=run_row["run_id"])


@dataclass(frozen=True)
class _CorrectedSamples(Mapping[str, ColumnArrays]):
    """Sentence of a hypothesis -> samples without its mistake, made on access.

    All at once would be as many logs in memory.
    """

    hypothesis_of_sentence: Mapping[str, Hypothesis]
    samples: ColumnArrays

    def __getitem__(self, sentence: str) -> ColumnArrays:
        return self.hypothesis_of_sentence[sentence].undo(self.samples)

    def __iter__(self) -> Iterator[str]:
        return iter(self.hypothesis_of_sentence)

    def __len__(self) -> int:
        return len(self.hypothesis_of_sentence)

    def __contains__(self, sentence: object) -> bool:
        return sentence in self.hypothesis_of_sentence


class _PassingHypothesis(NamedTuple):
    """A hypothesis with which a run passes, and the number of its accepted plateaus then."""

    accepted_count: int
    hypothesis: Hypothesis


def _passing_hypotheses(
    hypotheses: Iterable[Hypothesis],
    samples: ColumnArrays,
    run_row: Mapping[str, Any],
    rig_kind: RigKind,
) -> list[_PassingHypothesis]:
    """The plausible hypotheses with which most plateaus pass.

    Args:
        hypotheses: The hypotheses, all with the settings of the rig.
        samples: Samples of the run.
        run_row: Its row of the table of runs.
        rig_kind: The kind of rig, with its settings.
    """
    # each is tried as a run of its own, with its sentence as id
    hypothesis_of_sentence = {hypothesis.sentence: hypothesis for hypothesis in hypotheses}
    if not hypothesis_of_sentence:
        return []
    runs = pd.DataFrame(
        [{**run_row, "run_id": sentence, "rule": ""} for sentence in hypothesis_of_sentence]
    )
    judged_runs = _judge_plateaus_and_runs(
        _measure_runs(_CorrectedSamples(hypothesis_of_sentence, samples), runs, rig_kind)
    ).runs
    passing_hypotheses: list[_PassingHypothesis] = []
    do_most_pass = judged_runs["accepted_points"] > judged_runs["plateaus"] / 2
    for judged_row in tables.rows(judged_runs[do_most_pass]):
        hypothesis = hypothesis_of_sentence[judged_row["run_id"]]
        if hypothesis.is_plausible(samples, level_count=judged_row["plateaus"]):
            passing_hypotheses.append(_PassingHypothesis(judged_row["accepted_points"], hypothesis))
    return passing_hypotheses


def collect(
    curated: CuratedTables, settings: Settings, rig_class: type[RigKind] = TractionRig
) -> CuratedTables:
    """The tables of a campaign, after its runs have been compared with each other.

    Args:
        curated: Tables of all shares, as `curate_parts` gives them.
        settings: Settings of the campaign.
        rig_class: The class of the kind of rig.
    """
    campaign_tables = CampaignTables.from_frames(
        points=curated.points, runs=curated.runs, quarantine=curated.quarantine
    )
    compared = compare_runs(campaign_tables, settings, rig_class)
    points = compared.apply_refusals(curated.points)
    return CuratedTables(
        points.sort_values(["run_id", "first_row"], ignore_index=True),
        compared.runs,
        compared.quarantine,
    )


@dataclass(frozen=True)
class ComparedRuns:
    """The runs of a campaign after they have been compared with each other.

    Attributes:
        runs: Table of runs, in order.
        quarantine: Table of quarantine, in order.
        refusals: Refusals of runs by this comparison.
        rig_class: The class of the kind of rig.
    """

    runs: pd.DataFrame
    quarantine: pd.DataFrame
    refusals: list[Refusal]
    rig_class: type[RigKind]

    def apply_refusals(self, points: pd.DataFrame) -> pd.DataFrame:
        """Points, of which those of the runs that are refused here are refused or left out."""
        return _refuse_plateaus(points, self.refusals, self.rig_class) if self.refusals else points


def compare_runs(
    campaign_tables: CampaignTables, settings: Settings, rig_class: type[RigKind] = TractionRig
) -> ComparedRuns:
    """Compare the runs of a campaign with each other, without a change to the table of points.

    `ComparedRuns.apply_refusals` changes the points. A rule reads only the columns that it needs,
    and the shapes of one oil at a time: the table of points of a large campaign does not fit into
    memory.

    Args:
        campaign_tables: Tables `points`, `runs` and `quarantine` of all shares.
        settings: Settings of the campaign.
        rig_class: The class of the kind of rig.
    """
    refusals, shape_warnings = _refusals_by_comparison(campaign_tables, settings, rig_class)
    runs, quarantine = _with_refused_runs(
        campaign_tables.runs, campaign_tables.quarantine, refusals, rig_class
    )
    runs = with_campaign_warnings(runs, campaign_tables, rig_class, settings, shape_warnings)
    order_columns = ["file", "run_id", "first_row", "rule"]
    return ComparedRuns(
        runs.sort_values("run_id", ignore_index=True),
        quarantine.sort_values(order_columns, ignore_index=True),
        refusals,
        rig_class,
    )


def _refusals_by_comparison(
    campaign_tables: CampaignTables, settings: Settings, rig_class: type[RigKind]
) -> tuple[list[Refusal], list[RunWarning]]:
    """Refusals of runs that repeat others or contradict them, and warnings about shapes.

    Repeats are left out before the shapes are judged. If the shape of a kept run is then refused,
    the runs that repeat it are restored: they are compared and judged in its place.

    Args:
        campaign_tables: As for `compare_runs`.
        settings: Settings of the campaign.
        rig_class: The class of the kind of rig.
    """
    runs = campaign_tables.runs
    repeat_refusal_of_run = _repeat_refusals(campaign_tables, runs, rig_class, settings)
    refusal_of_run = {
        run_id: repeat_refusal.refusal for run_id, repeat_refusal in repeat_refusal_of_run.items()
    }
    shape_warnings: list[RunWarning] = []
    ids_to_judge: set[str] = set()
    if rig_class.name == TRACTION_KIND:
        ids_to_judge = set(runs.loc[runs["verdict"] == "accepted", "run_id"]) - set(refusal_of_run)
    while ids_to_judge:
        remaining_runs = runs[~runs["run_id"].isin(refusal_of_run)]
        shape_verdicts = _shape_verdicts_of_runs(campaign_tables, remaining_runs, ids_to_judge)
        shape_warnings += shape_verdicts.warnings
        odd_ids = {refusal.run_id for refusal in shape_verdicts.refusals}
        refusal_of_run |= {refusal.run_id: refusal for refusal in shape_verdicts.refusals}
        restored_ids = {
            run_id
            for run_id, repeat_refusal in repeat_refusal_of_run.items()
            if repeat_refusal.kept_id in odd_ids
        }
        if not restored_ids:
            break
        for run_id in restored_ids:
            del refusal_of_run[run_id], repeat_refusal_of_run[run_id]
        # restored runs may repeat each other
        remaining_runs = runs[~runs["run_id"].isin(refusal_of_run)]
        new_repeat_refusals = _repeat_refusals(campaign_tables, remaining_runs, rig_class, settings)
        repeat_refusal_of_run |= new_repeat_refusals
        refusal_of_run |= {
            run_id: repeat_refusal.refusal for run_id, repeat_refusal in new_repeat_refusals.items()
        }
        ids_to_judge = restored_ids - set(refusal_of_run)
    warnings_of_kept_runs = [
        (run_id, sentence) for run_id, sentence in shape_warnings if run_id not in refusal_of_run
    ]
    return list(refusal_of_run.values()), warnings_of_kept_runs


def _shape_verdicts_of_runs(
    campaign_tables: CampaignTables, runs: pd.DataFrame, run_ids: set[str]
) -> ShapeVerdicts:
    """The verdicts on the shapes of some runs, each beside all other accepted ones of its oil.

    Args:
        campaign_tables: The table `points`.
        runs: Table of runs that no comparison has refused.
        run_ids: Ids of the runs that are judged.
    """
    verdicts = ShapeVerdicts()
    for oil_name in sorted(set(runs.loc[runs["run_id"].isin(run_ids), "oil"])):
        verdicts_of_oil = judge_shapes(
            campaign_tables.table("points", SHAPE_COLUMNS, oil=oil_name), runs
        )
        verdicts.refusals.extend(
            refusal for refusal in verdicts_of_oil.refusals if refusal.run_id in run_ids
        )
        verdicts.warnings.extend(
            (run_id, sentence) for run_id, sentence in verdicts_of_oil.warnings if run_id in run_ids
        )
    return verdicts


def _with_refused_runs(
    runs: pd.DataFrame, quarantine: pd.DataFrame, refusals: list[Refusal], rig_class: type[RigKind]
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The tables of runs and of quarantine with some more runs refused."""
    if not refusals:
        return runs, quarantine
    plateau_counts = runs.set_index("run_id")[["plateaus", "accepted_points"]]
    refused_ids = [refusal.run_id for refusal in refusals]
    plateau_counts.loc[refused_ids, "accepted_points"] = 0
    if not rig_class.keeps_refused_runs:
        plateau_counts.loc[refused_ids, "plateaus"] = 0
    runs = _with_verdicts(runs, plateau_counts, refusals)
    return runs, pd.concat([quarantine, quarantine_rows(refusals, runs, rig_class)])


def arrays_of_samples(samples: pd.DataFrame) -> ColumnArrays:
    """The columns of samples without the id of the run."""
    return {str(name): samples[name].to_numpy() for name in samples if name != "run_id"}


def _samples_by_run(samples: pd.DataFrame) -> dict[str, ColumnArrays]:
    """Id of a run -> its samples; the rows of a run must be together."""
    arrays = arrays_of_samples(samples)
    samples_of_run: dict[str, ColumnArrays] = {}
    for run_id, sample_indices in samples.groupby("run_id").indices.items():
        start, stop = sample_indices[0], sample_indices[-1] + 1
        samples_of_run[str(run_id)] = {name: array[start:stop] for name, array in arrays.items()}
    return samples_of_run


def _table_of_plateaus(
    plateaus_of_run: Mapping[str, ColumnArrays], runs: pd.DataFrame, rig_kind: RigKind
) -> pd.DataFrame:
    """All plateaus, with columns of their run and those that follow from rig and oil.

    Args:
        plateaus_of_run: Id of a run -> columns over its plateaus.
        runs: Table of runs, indexed by id.
        rig_kind: The kind of rig, with its settings.
    """
    if not plateaus_of_run:
        return tables.empty_table(rig_kind.table_name)
    all_plateaus = list(plateaus_of_run.values())
    plateau_counts = [len(plateaus["time_s"]) for plateaus in all_plateaus]
    columns_of_runs = runs.loc[list(plateaus_of_run), list(rig_kind.run_columns)].reset_index()
    points = columns_of_runs.take(
        np.repeat(np.arange(len(plateau_counts)), plateau_counts)
    ).reset_index(drop=True)
    measured_columns = {
        column: np.concatenate([plateaus[column] for plateaus in all_plateaus])
        for column in all_plateaus[0]
    }
    points = rig_kind.with_rig_and_oil_columns(points.assign(**measured_columns))
    # without any load mu is larger than a table may hold
    float_columns = points.select_dtypes("float")
    return points.assign(**float_columns.mask(float_columns.abs() >= tables.LARGEST_NUMBER))


def _judge_plateaus_and_runs(measured: _MeasuredRuns) -> CuratedTables:
    """Judge plateaus by the gates of plateaus, and runs by their plateaus."""
    points, runs, rig_kind = measured.points, measured.runs, measured.rig_kind
    refusal_of_run = dict(measured.refusal_of_run)
    failed_by_gate = judge_plateaus(points, rig_kind)
    is_unrefused = ~points["run_id"].isin(list(refusal_of_run))
    refusals_by_plateaus = list(
        refusals_of_unusable_runs(points[is_unrefused], failed_by_gate[is_unrefused], rig_kind)
    )
    points = points.assign(
        failed_gates=failed_gates.gate_name_lists(failed_by_gate),
        accepted=~failed_by_gate.any(axis=1),
    )
    points = _refuse_plateaus(points, list(refusal_of_run.values()), type(rig_kind))
    # If a run is refused because of its plateaus, they all stay in the table, whatever the kind of
    # rig. Those that pass their own gates get the rule of the run.
    runs_with_accepted_points = set(points.loc[points["accepted"], "run_id"])
    rule_of_run = {
        refusal.run_id: refusal.rule
        for refusal in refusals_by_plateaus
        if refusal.run_id in runs_with_accepted_points
    }
    points = failed_gates.with_gate_of_run(points, rule_of_run)
    refusal_of_run |= {refusal.run_id: refusal for refusal in refusals_by_plateaus}
    refusals_in_order = [
        refusal_of_run[run_id] for run_id in runs["run_id"] if run_id in refusal_of_run
    ]
    runs = _with_verdicts(runs, _plateau_counts(points), refusals_in_order)
    quarantine = quarantine_rows(
        [*refusals_in_order, *measured.short_level_refusals], runs, type(rig_kind)
    )
    return CuratedTables(points[tables.columns(rig_kind.table_name)], runs, quarantine)


def _refuse_plateaus(
    points: pd.DataFrame, refusals: list[Refusal], rig_class: type[RigKind]
) -> pd.DataFrame:
    """Plateaus, of which those of refused runs are refused, or left out for some kinds of rig."""
    gate_of_run = {refusal.run_id: refusal.rule for refusal in refusals}
    if rig_class.keeps_refused_runs:
        return failed_gates.with_gate_of_run(points, gate_of_run)
    return points[~points["run_id"].isin(list(gate_of_run))]


def _plateau_counts(points: pd.DataFrame) -> pd.DataFrame:
    """Numbers of plateaus and of accepted ones, by run."""
    is_accepted_by_run = points.groupby("run_id")["accepted"]
    return pd.DataFrame(
        {"plateaus": is_accepted_by_run.size(), "accepted_points": is_accepted_by_run.sum()}
    )


def _with_verdicts(
    runs: pd.DataFrame, plateau_counts: pd.DataFrame, refusals: list[Refusal]
) -> pd.DataFrame:
    """Runs with rule and sentence of their refusal, counts of their plateaus, and verdict.

    Args:
        runs: Table of runs.
        plateau_counts: Numbers of plateaus and of accepted ones, by run.
        refusals: Refusals of runs.
    """
    refusal_of_run = {refusal.run_id: (refusal.rule, refusal.reason) for refusal in refusals}
    rules_and_reasons = [
        refusal_of_run.get(run_id, (rule, reason))
        for run_id, rule, reason in zip(runs["run_id"], runs["rule"], runs["reason"], strict=True)
    ]
    plateau_counts = plateau_counts.reindex(runs["run_id"], fill_value=0).astype(np.int64)
    plateau_count = plateau_counts["plateaus"].to_numpy()
    accepted_count = plateau_counts["accepted_points"].to_numpy()
    # a run that is not used needs no warning
    warnings = [
        sentences if count else ()
        for sentences, count in zip(runs["warning"], accepted_count, strict=True)
    ]
    return runs.assign(
        **pd.DataFrame(rules_and_reasons, runs.index, ["rule", "reason"], dtype="str"),
        plateaus=plateau_count,
        accepted_points=accepted_count,
        warning=tables.list_column(warnings, runs.index),
        verdict=np.where(accepted_count > 0, "accepted", "refused"),
    ).reset_index(drop=True)
