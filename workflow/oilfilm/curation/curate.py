"""Samples to plateaus with verdicts: one engine for every kind of rig.

samples -> signals -> zero -> plateaus -> derived quantities -> gates -> verdicts. A `RigKind` has
everything in which the rigs differ.

Runs that repeat each other are copies, conditions run twice, or wrong labels. A rule compares the
accepted runs of a campaign with each other. If several of them can be right, the first by name is
kept. If two contradict each other, both are refused. Of more, those that most others contradict are
refused. Then the shape of each curve is judged beside the others (`curve_shapes`).

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
from oilfilm.curation.curve_shapes import SHAPE_COLUMNS, judged_shapes
from oilfilm.curation.gate import fault
from oilfilm.curation.hypotheses import DOUBTFUL, Hypothesis
from oilfilm.curation.measure import measure
from oilfilm.curation.plateau_gates import (
    controlled_speeds,
    held_speed,
    judge_plateaus,
    quarantine_rows,
    runs_not_usable,
)
from oilfilm.curation.rig_kind import TRACTION_KIND, RigKind, Run
from oilfilm.curation.rig_spin import spin_warnings
from oilfilm.curation.run_gates import first_fault, warnings_about
from oilfilm.curation.statistics import Stretches
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.logs.base import Columns, Refusal
from oilfilm.logs.ingest import Ingested, ingest_logs, sample_files
from oilfilm.logs.raw_files import RawLogs
from oilfilm.logs.run_sheet import NO_SHEET, RunSheet
from oilfilm.settings.config import CopySettings, GateSettings
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.set_points import NOMINAL_COLUMNS, with_levels

# ---------------------------------------------------------------- repeats

# Last plateaus by whose load, speed and temperature copies are looked up among all runs.
_PLATEAUS_LOOKED_UP = 3
# Campaigns without copies in which a run is taken for one: at most this share of them.
_CHANCE_OF_A_COPY = 1e-3
# Column of plateaus and its key of a rig's `full_scale`.
_FULL_SCALE_KEYS = {
    "load_n": "load_n",
    "traction_force_n": "traction_force_n",
    "entrainment_speed_m_s": "surface_speed_m_s",
    "inlet_temperature_c": "temperature_c",
}
# Columns of points of which copies have the same noise at the same conditions.
_MEAN_COLUMNS = ["slide_roll_ratio", "traction_coefficient"]
_ERROR_COLUMNS = [f"{name}_se" for name in _MEAN_COLUMNS]
_CONDITION_COLUMNS = ["load_n", "entrainment_speed_m_s", "inlet_temperature_c"]


def repeated(
    shares: CampaignTables, runs: pd.DataFrame, kind: type[RigKind], settings: Settings
) -> list[Refusal]:
    """Refusals of accepted runs that repeat or contradict others, those of copies first.

    A torque rig may measure a condition again, and so may a campaign that declares repeats.

    Args:
        shares: The table `points`, of which each rule reads the columns that it compares.
        runs: Table of runs.
        kind: The kind of rig.
        settings: Settings of the run.
    """
    remaining = runs[runs["verdict"] == "accepted"].sort_values(["file", "run_id"])
    refused: dict[str, Refusal] = {}
    for refusal in _refusals_of_same_readings(shares, remaining, kind, settings):
        refused.setdefault(refusal.run_id, refusal)
    if kind.name == TRACTION_KIND and settings.campaign.repeated_conditions != "accept":
        remaining = remaining[~remaining["run_id"].isin(refused)]
        refused |= {
            refusal.run_id: refusal
            for refusal in _refusals_of_same_conditions(shares, remaining, settings)
        }
    return list(refused.values())


def _refusals_of_same_readings(
    shares: CampaignTables, runs: pd.DataFrame, kind: type[RigKind], settings: Settings
) -> Iterator[Refusal]:
    """Copies of an earlier log, and the same readings under the names of two oils."""
    pairs = list(_pairs_with_same_readings(shares, runs, kind, settings))
    for first, later in pairs:
        if first.oil == later.oil:
            yield fault("duplicate_log", run_id=later.run_id, kept=first.run_id)
    for pair in pairs:
        for run, other in (pair, pair[::-1]):
            if run.oil != other.oil:
                yield fault("conflicting_labels", run_id=run.run_id, other=other)


def _refusals_of_same_conditions(
    shares: CampaignTables, runs: pd.DataFrame, settings: Settings
) -> Iterator[Refusal]:
    """Runs of one condition: curves that contradict each other, and all but one of the others.

    Two runs contradict each other beyond `repeat_difference_max`. Of three or more, one that is off
    by less is odd where the others agree far better with each other than with it.
    """
    gates = settings.gates
    allowed, odd_from = gates.repeat_difference_max, gates.repeat_odd_min
    for run_ids, differences in _compared_conditions(shares, runs, settings):
        kept = []
        largest_among_others = _largest_without_each(differences)
        for index, run_id in enumerate(run_ids):
            others = np.delete(np.arange(len(run_ids)), index)
            to_others = differences[index, others]
            difference_of_others = largest_among_others[index]
            limit = allowed
            if len(others) > 1:
                limit = max(odd_from, gates.repeat_odd_factor * difference_of_others)
            contradicting = others[to_others > allowed]
            if len(contradicting) <= len(others) / 2:
                contradicting = others[to_others > limit]
                if len(contradicting) < len(others):
                    kept.append(index)
                    continue
            more = f" (and {len(contradicting) - 1} more)" if len(contradicting) > 1 else ""
            agree = ""
            if len(others) > 1:
                agree = f"; the others agree within {difference_of_others:.1%}"
            numbers = dict(
                other=run_ids[contradicting[0]],
                apart=differences[index, contradicting[0]],
                more=more,
                agree=agree,
                allowed=min(limit, allowed),
            )
            yield fault("conflicting_condition", run_id=run_id, **numbers)
        for later in kept[1:]:
            numbers = dict(kept=run_ids[kept[0]], apart=differences[kept[0], later])
            yield fault("duplicate_condition", run_id=run_ids[later], **numbers)


def _largest_without_each(differences: FloatArray) -> FloatArray:
    """The largest difference between two runs without a third one, for each of these.

    Args:
        differences: Differences of n runs, shape (n, n), symmetric.
    """
    count = len(differences)
    largest = np.full(count, differences.max())
    # only the two runs that are farthest apart have another largest difference
    for farthest in np.unravel_index(np.argmax(differences), differences.shape):
        others = np.delete(np.arange(count), farthest)
        largest[farthest] = differences[np.ix_(others, others)].max()
    return largest


def _compared_conditions(
    shares: CampaignTables, runs: pd.DataFrame, settings: Settings
) -> Iterator[tuple[list[str], FloatArray]]:
    """Runs of the same oil, rig and set points, and how far the curves of each two are apart.

    A load counts by the pressure that it makes, where the rig's contact is known: a pressure that
    is rounded by 0.5 % is a load that is off by 1.5 %.
    """
    pressure, load = NOMINAL_COLUMNS[:2]
    noted = with_levels(runs, settings)
    noted = noted[noted[[pressure, load]].notna().any(axis=1)]
    # one of the two is unknown, and unknown values would not be compared
    noted = noted.fillna({pressure: -1, load: -1})
    groups = list(_groups_with_same_values(noted, ["oil", "rig", *NOMINAL_COLUMNS]))
    if not groups:
        return
    columns = ["run_id", "accepted", *_MEAN_COLUMNS, "traction_coefficient_se"]
    points = shares.table("points", columns)
    has_repeats = points["run_id"].isin({run.run_id for group in groups for run in group})
    accepted = points[points["accepted"] & has_repeats]
    rows_by_run = accepted.groupby("run_id").indices
    for group in groups:
        run_ids = [run.run_id for run in group]
        curves = [_curve(accepted.iloc[rows_by_run[run_id]]) for run_id in run_ids]
        yield run_ids, _curve_differences(curves, settings.gates.sign_slip_min)


def _groups_with_same_values(runs: pd.DataFrame, key: list[str]) -> Iterator[list[Any]]:
    """Runs with the same values of some columns, two or more; empty values are not compared."""
    with_values = runs[runs[key].notna().all(axis=1) & (runs[key] != "").all(axis=1)]
    # a group takes its time, and hardly any run has a second one in its own
    for _, group in with_values[with_values.duplicated(key, keep=False)].groupby(key, sort=False):
        yield list(group.itertuples())


def _pairs_with_same_readings(
    shares: CampaignTables, runs: pd.DataFrame, kind: type[RigKind], settings: Settings
) -> Iterator[tuple[Any, Any]]:
    """Pairs of runs out of files of one content, or with plateaus of the same noise."""
    run_by_id: dict[str, Any] = {str(run.run_id): run for run in runs.itertuples()}
    # a file may hold several runs
    places_in_files = [f"in {run_id.removeprefix(run.file)}" for run_id, run in run_by_id.items()]
    runs_with_places = runs.assign(place=places_in_files)
    for first, *others in _groups_with_same_values(runs_with_places, ["content_sha256", "place"]):
        yield from ((first, later) for later in others)
    if kind.name == TRACTION_KIND:
        copies = settings.gates.copies
        ids_of_runs = pd.Index(runs["run_id"])
        columns = ["run_id", *_MEAN_COLUMNS, *_ERROR_COLUMNS, *_CONDITION_COLUMNS]
        last_points = []
        for part in shares.parts("points", columns):
            has_errors = (part[_ERROR_COLUMNS] > 0).all(axis=1)
            compared = part[_is_of_runs(part, ids_of_runs) & has_errors]
            last_points.append(compared.groupby("run_id").tail(copies.plateaus + 1))
        remaining = pd.concat(last_points, ignore_index=True)
        for first_id, later_id in _pairs_with_same_noise(remaining, copies):
            yield run_by_id[first_id], run_by_id[later_id]


def _is_of_runs(points: pd.DataFrame, run_ids: pd.Index) -> BoolArray:
    """Which points are of some runs, shape (points,); many parts share one look-up of the runs."""
    return np.asarray(run_ids.get_indexer(pd.Index(points["run_id"])) >= 0)


def _pairs_with_same_noise(points: pd.DataFrame, copies: CopySettings) -> Iterator[tuple[str, str]]:
    """Pairs of runs whose plateaus differ by far less than their own errors, whatever the rows.

    The same readings, cut off elsewhere or rounded, keep the errors of their means; other readings
    of the same condition have other ones. The last plateaus of both are compared, but for the very
    last: it ends where the log does, or in a step that is found to within a few rows.
    """
    points_by_run = points.groupby("run_id")
    counts = points_by_run.size()
    run_ids = counts.index[counts > copies.plateaus]
    last_points = points_by_run.tail(copies.plateaus + 1)
    last_points = last_points.drop(points_by_run.tail(1).index)
    last_points = last_points[last_points["run_id"].isin(run_ids)]
    if len(run_ids) < 2:
        return

    def of_plateaus(columns: list[str]) -> FloatArray:
        """Values of the last plateaus of each run, shape (runs, plateaus, columns)."""
        return last_points[columns].to_numpy(float).reshape(len(run_ids), copies.plateaus, -1)

    values = of_plateaus(_MEAN_COLUMNS)
    se = of_plateaus(_ERROR_COLUMNS)
    conditions = of_plateaus(_CONDITION_COLUMNS)
    conditions = np.nan_to_num(conditions[:, -_PLATEAUS_LOOKED_UP:].reshape(len(run_ids), -1))
    # two conditions are near where they differ by less than 1 once they are scaled
    condition_reach = copies.condition * np.abs(conditions).max(axis=0)
    scaled_conditions = conditions / np.where(condition_reach > 0, condition_reach, 1.0)
    tree = scipy.spatial.cKDTree(scaled_conditions)
    pair_count = (int(tree.count_neighbors(tree, 1.0, p=np.inf)) - len(run_ids)) // 2
    allowed = np.array([copies.slip_errors, _allowed_traction_errors(copies, pair_count)])
    # between neighbouring plateaus no zero counts: these differences of mu find the pairs that may
    # be copies. Two plateaus have the sum of squares of all at most
    contrasts = np.diff(values[..., 1], axis=1)
    contrast_reach = 2 * allowed[1] * np.sqrt(copies.plateaus) * se[..., 1].max()
    scaled = np.concatenate([scaled_conditions, contrasts / contrast_reach], axis=1)
    tree = scipy.spatial.cKDTree(scaled)
    for first, second in sorted(tree.query_pairs(1.0, p=np.inf)):
        difference = values[first] - values[second]
        # the zero of the force may be that of other rows, and rounding moves the speeds
        difference -= np.median(difference, axis=0)
        relative = difference / np.hypot(se[first], se[second])
        rms = np.sqrt(np.mean(relative**2, axis=0))
        if (rms < allowed).all():
            yield run_ids[first], run_ids[second]


def _allowed_traction_errors(copies: CopySettings, pair_count: int) -> float:
    """Largest rms difference of mu over its standard errors at which a pair is a copy.

    The more pairs are compared, the smaller the differences that occur by chance. So small ones as
    this occur in one of a thousand campaigns without copies. The sum of squares of m differences,
    less their mean, has the chi-squared distribution of m - 1 degrees of freedom.
    """
    chance = _CHANCE_OF_A_COPY / max(pair_count, 1)
    squares = scipy.stats.chi2.ppf(chance, copies.plateaus - 1)
    return min(copies.traction_errors, float(np.sqrt(squares / copies.plateaus)))


class _Curve(NamedTuple):
    """Rising slips of a run, its traction coefficients and their standard errors, shape (n,)."""

    slip: FloatArray
    mu: FloatArray
    mu_se: FloatArray


def _curve_differences(curves: Sequence[_Curve], smallest_slip: float) -> FloatArray:
    """Median relative difference of each two curves over the slips that both have.

    Twice the standard error of each difference is subtracted where it is known.

    Args:
        curves: The curves, n of them.
        smallest_slip: Smaller slips are not compared.

    Returns:
        Shape (n, n), symmetric; 0 where two curves have no slips in common.
    """
    differences = np.zeros((len(curves), len(curves)))
    lengths = np.array([len(curve.slip) for curve in curves])
    all_slip = np.concatenate([curve.slip for curve in curves])
    all_mu = np.concatenate([curve.mu for curve in curves])
    all_se = np.concatenate([curve.mu_se for curve in curves])
    for index, (slip, mu, mu_se) in enumerate(curves[:-1]):
        # the curves behind it, one after the other
        later = slice(lengths[: index + 1].sum(), None)
        later_slip = all_slip[later]
        is_shared = (later_slip >= max(slip.min(), smallest_slip)) & (later_slip <= slip.max())
        later_slip = later_slip[is_shared]
        later_mu = all_mu[later][is_shared]
        expected_mu = np.interp(later_slip, slip, mu)
        expected_se = np.interp(later_slip, slip, mu_se)
        error = np.nan_to_num(2 * np.hypot(all_se[later][is_shared], expected_se))
        excess = np.maximum(np.abs(later_mu - expected_mu) - error, 0.0)
        mean_size = (np.abs(later_mu) + np.abs(expected_mu)) / 2
        curve_of_point = np.repeat(np.arange(index + 1, len(curves)), lengths[index + 1 :])
        curve_of_point = curve_of_point[is_shared]
        compared_curves, starts = np.unique(curve_of_point, return_index=True)
        stretches = Stretches(starts, np.append(starts[1:], len(curve_of_point)))
        medians = stretches.medians(excess / mean_size) if len(compared_curves) else 0.0
        differences[index, compared_curves] = differences[compared_curves, index] = medians
    return differences


def _curve(points: pd.DataFrame) -> _Curve:
    """The curve of a run."""
    ordered = points.sort_values("slide_roll_ratio", kind="stable")
    return _Curve(
        slip=ordered["slide_roll_ratio"].to_numpy(float),
        mu=ordered["traction_coefficient"].to_numpy(float),
        mu_se=ordered["traction_coefficient_se"].to_numpy(float),
    )


# Id of a run, and a sentence about it.
RunWarning = tuple[str, str]


def with_campaign_warnings(
    runs: pd.DataFrame,
    shares: CampaignTables,
    kind: type[RigKind],
    settings: Settings,
    shape_warnings: Iterable[RunWarning],
) -> pd.DataFrame:
    """Runs with warnings that only the other runs of their rig, or its file, can give.

    Args:
        runs: Table of runs.
        shares: The table `points`, of which each rule reads the columns that it compares.
        kind: The kind of rig.
        settings: Settings of the run.
        shape_warnings: Warnings about the shapes of curves: id of the run and a sentence.
    """
    if kind.name != TRACTION_KIND:
        return runs
    accepted = runs[runs["verdict"] == "accepted"].set_index("run_id")
    sentences_by_run = {
        run_id: list(own_sentences) for run_id, own_sentences in accepted["warning"].items()
    }

    def parts(*columns: str) -> Iterator[pd.DataFrame]:
        """Some columns of the points of accepted runs, some rows at a time."""
        for part in shares.parts("points", ["run_id", *columns]):
            yield part[_is_of_runs(part, accepted.index)]

    for run_id, sentence in chain(
        shape_warnings,
        _channel_warnings(parts("load_n", "inlet_temperature_c"), accepted, settings.gates),
        _rig_warnings(parts(*_FULL_SCALE_KEYS), accepted["rig"], settings),
        spin_warnings(parts("accepted", *_MEAN_COLUMNS, "load_n"), accepted["rig"], settings),
        _oil_warnings(accepted["oil"], settings),
        _speed_warnings(
            lambda: parts("accepted", "entrainment_speed_m_s", "slide_roll_ratio"),
            accepted,
            settings.gates,
        ),
    ):
        sentences_by_run[run_id].append(sentence)
    warnings = [tuple(sentences_by_run.get(run_id, ())) for run_id in runs["run_id"]]
    return runs.assign(warning=tables.list_column(warnings, runs.index))


def _rig_warnings(
    parts: Iterable[pd.DataFrame], rigs: "pd.Series[str]", settings: Settings
) -> Iterator[RunWarning]:
    """Warnings from the rig's file: readings beyond the full scale, impossible materials."""
    columns = list(_FULL_SCALE_KEYS)
    largest_of_parts = [part[columns].abs().groupby(part["run_id"]).max() for part in parts]
    # the rows of a run may be in two parts
    largest_readings = pd.concat(largest_of_parts).groupby(level=0).max()
    by_rig = largest_readings.groupby(rigs.reindex(largest_readings.index))
    for rig_name, readings_of_rig in by_rig:
        rig = settings.rigs.get(str(rig_name))
        if rig is None:
            continue
        advice = f"correct {rig_name}.yaml"
        for doubt in rig.doubts():
            for run_id in readings_of_rig.index:
                yield str(run_id), f"unusual_rig: {doubt}; {advice}"
        if rig.full_scale is None:
            continue
        for column, key in _FULL_SCALE_KEYS.items():
            full_scale = getattr(rig.full_scale, key)
            readings = readings_of_rig[column]
            for run_id, largest in readings[exceeds(readings, full_scale)].items():
                numbers = dict(column=column, of=largest, full=full_scale, key=key)
                yield str(run_id), f"{fault('full_scale', **numbers).reason}; {advice}"


def _oil_warnings(oils: "pd.Series[str]", settings: Settings) -> Iterator[RunWarning]:
    """Warnings from the files of the oils."""
    for oil_name, runs in oils.groupby(oils):
        oil = settings.oils[str(oil_name)]
        for doubt in oil.doubts() if oil else ():
            for run_id in runs.index:
                yield str(run_id), f"unusual_oil: {doubt}; correct {oil_name}.yaml"


def _speed_warnings(
    parts: Callable[[], Iterable[pd.DataFrame]], runs: pd.DataFrame, gates: GateSettings
) -> Iterator[RunWarning]:
    """Warnings about runs in which a rig holds the speed of one body."""
    set_speeds = runs["nominal_entrainment_speed_m_s"]
    runs_off: set[str] = set()
    for part in parts():
        points = part[part["accepted"]]
        set_speed_of_points = set_speeds.reindex(points["run_id"]).to_numpy()
        deviation = (points["entrainment_speed_m_s"] - set_speed_of_points).abs()
        is_off = exceeds(deviation, gates.speed_tolerance * set_speed_of_points)
        runs_off |= set(points.loc[is_off, "run_id"])
    if not runs_off:
        return
    points_off = pd.concat([part[part["run_id"].isin(runs_off)] for part in parts()])
    for run_id, points_of_run in points_off[points_off["accepted"]].groupby("run_id"):
        mean_speeds = points_of_run["entrainment_speed_m_s"]
        held_speeds = held_speed(points_of_run)
        speed_by_name = controlled_speeds(points_of_run).items()
        control = next(name for name, speed in speed_by_name if speed.equals(held_speeds))
        numbers = dict(
            control=control, set=set_speeds[run_id], least=mean_speeds.min(), most=mean_speeds.max()
        )
        yield str(run_id), fault("body_at_set_speed", **numbers).reason


def _channel_warnings(
    parts: Iterable[pd.DataFrame], runs: pd.DataFrame, gates: GateSettings
) -> Iterator[RunWarning]:
    """Warnings about a channel that is one number in all plateaus, and moves in most other runs."""
    channels = {"load_n": "load", "inlet_temperature_c": "inlet temperature"}
    ranges_of_parts = pd.concat(
        [part.groupby("run_id")[list(channels)].agg(["min", "max", "size"]) for part in parts]
    )
    for column, name in channels.items():
        # the rows of a run may be in two parts
        by_run = pd.DataFrame(ranges_of_parts[column]).groupby(level=0)
        ranges = pd.DataFrame(
            {"min": by_run["min"].min(), "max": by_run["max"].max(), "size": by_run["size"].sum()}
        )
        judged_ranges = ranges[ranges["size"] >= gates.constant_channel_plateaus]
        is_constant = pd.Series(
            reaches(judged_ranges["min"], judged_ranges["max"]), judged_ranges.index
        )
        rigs = runs["rig"].reindex(judged_ranges.index)
        for _, is_constant_of_rig in is_constant.groupby(rigs):
            run_count = len(is_constant_of_rig)
            moving_count = (~is_constant_of_rig).sum()
            if run_count < gates.constant_channel_runs or is_constant_of_rig.mean() >= 1 / 2:
                continue
            numbers = dict(name=name, others=moving_count, runs=run_count)
            for run_id in is_constant_of_rig.index[is_constant_of_rig]:
                value = ranges["min"].loc[run_id]
                yield str(run_id), fault("constant_channel", value=value, **numbers).reason


# ---------------------------------------------------------------- the engine


@dataclass(frozen=True)
class Curated:
    """Tables of a campaign or a share of it: plateaus, runs with verdicts, quarantine."""

    points: pd.DataFrame
    runs: pd.DataFrame
    quarantine: pd.DataFrame


def check_logs(
    logs: Iterable[tuple[str, bytes]],
    settings: Settings,
    kind: type[RigKind] = TractionRig,
    sheet: RunSheet = NO_SHEET,
) -> Curated:
    """Ingest and curate logs.

    Args:
        logs: Name and bytes of each log.
        settings: Settings of the run.
        kind: The kind of rig.
        sheet: The run sheet.

    Raises:
        OilfilmError: As by `ingest_logs`, or a table is not as it is declared.
    """
    return curate_ingested(ingest_logs(logs, settings, kind.logs, sheet), kind(settings))


def curate_ingested(ingested: Ingested, rig: RigKind) -> Curated:
    """Curate all logs of a campaign.

    Raises:
        OilfilmError: A table is not as it is declared.
    """
    samples = ingested.all_samples()
    curated = collect(curate_parts([samples], ingested, rig), rig.settings, type(rig))
    # tables that the workflow could not write must not pass here
    if rig.name == TractionRig.name:
        tables.conform(samples, "samples", "samples of these logs")
    tables.conform(curated.points, rig.table, "plateaus of these logs")
    return curated


def curate_share(
    logs: RawLogs,
    settings: Settings,
    sheet: RunSheet,
    samples: Mapping[str, Path],
    provenance: Mapping[str, Any],
) -> Curated:
    """Read a share of the logs, write its samples and curate them.

    The memory needed does not grow with the size of the share.

    Args:
        logs: The logs.
        settings: Settings of the run.
        sheet: The run sheet.
        samples: File of each oil's samples.
        provenance: As for `tables.writing`.
    """
    with sample_files(samples, provenance) as keep:
        ingested = ingest_logs(logs, settings, sheet=sheet, keep=keep, verified=logs.digests)
    parts = tables.read_parts("samples", *samples.values())
    return curate_parts(parts, ingested, TractionRig(settings))


def curate_parts(samples: Iterable[pd.DataFrame], ingested: Ingested, rig: RigKind) -> Curated:
    """Curate samples that come in parts, of which one at a time is in memory.

    Args:
        samples: Parts of the table of samples, each with complete runs.
        ingested: The logs of the samples.
        rig: The rig.

    Returns:
        The quarantine has the refusals of ingest too.
    """
    runs = ingested.runs
    without_rows = runs["run_id"]
    parts: list[Curated] = []
    for samples_of_part in samples:
        run_ids = samples_of_part["run_id"].unique()
        without_rows = without_rows[~without_rows.isin(run_ids)]
        parts.append(curate(samples_of_part, runs[runs["run_id"].isin(run_ids)], rig))
    parts.append(curate(tables.empty("samples"), runs.loc[without_rows.index], rig))
    quarantine = [ingested.quarantine, *(part.quarantine for part in parts)]
    return Curated(
        points=pd.concat([part.points for part in parts], ignore_index=True),
        runs=pd.concat([part.runs for part in parts], ignore_index=True),
        quarantine=pd.concat(quarantine, ignore_index=True),
    )


def curate(samples: pd.DataFrame, runs: pd.DataFrame, rig: RigKind) -> Curated:
    """Plateaus of every run, judged by every gate of the rig.

    Args:
        samples: Table of samples, the rows of a run together.
        runs: Table of runs as ingested.
        rig: The rig.
    """
    samples_of_run = _samples_by_run(samples)
    measured = _measure_runs(samples_of_run, runs, rig)
    judged = _judge(measured)
    explanations: dict[str, Refusal] = {}
    for row in tables.rows(judged.runs[judged.runs["rule"].isin(DOUBTFUL)]):
        run_id = row["run_id"]
        if run_id in samples_of_run:
            explanation = _explanation(samples_of_run[run_id], row, rig)
            if explanation is not None:
                explanations[run_id] = explanation
    if not explanations:
        return judged
    return _judge(replace(measured, refused=measured.refused | explanations))


@dataclass(frozen=True)
class _MeasuredRuns:
    """Plateaus of runs, and the findings of the gates of runs.

    Attributes:
        points: Table of plateaus.
        runs: Table of runs, with their warnings.
        refused: Id of a run -> its refusal.
        too_short: Refusals of levels that give no plateau.
        rig: The rig.
    """

    points: pd.DataFrame
    runs: pd.DataFrame
    refused: dict[str, Refusal]
    too_short: list[Refusal]
    rig: RigKind


def _measure_runs(
    samples_of_run: Mapping[str, Columns], runs: pd.DataFrame, rig: RigKind
) -> _MeasuredRuns:
    """Measure runs and judge each by the gates of runs.

    Args:
        samples_of_run: Id of a run -> its samples.
        runs: Table of runs as ingested.
        rig: The rig.
    """
    refused: dict[str, Refusal] = {}
    too_short: list[Refusal] = []
    plateaus_of_run: dict[str, Columns] = {}
    warnings: list[tuple[str, ...]] = []
    for row in tables.rows(runs):
        run_id = row["run_id"]
        # the signals of one run at a time are in memory
        run = None
        if run_id in samples_of_run:
            run = _measured(samples_of_run[run_id], row, rig)
            plateaus_of_run[run_id] = run.plateaus
        refusal = _refusal_before_plateaus(row, run)
        if refusal is not None:
            refused[run_id] = refusal
        if run is None or refusal is not None:
            warnings.append(())
        else:
            warnings.append(warnings_about(run))
            too_short += [replace(level, run_id=run_id) for level in run.too_short]
    runs = runs.assign(warning=tables.list_column(warnings, runs.index))
    points = _table_of_plateaus(plateaus_of_run, runs.set_index("run_id"), rig)
    return _MeasuredRuns(points, runs, refused, too_short, rig)


def _measured(samples: Columns, row: Mapping[str, Any], rig: RigKind) -> Run:
    """The plateaus of a run.

    Args:
        samples: Samples of the run.
        row: Its row of the table of runs.
        rig: The rig.
    """
    signals = rig.signals(samples, row["rig"], rig.settings)
    return measure(signals, rig, row["rig"], is_settled=row["log_kind"] == "steps")


def _refusal_before_plateaus(row: Mapping[str, Any], run: Run | None) -> Refusal | None:
    """The refusal of a run by ingest or by a gate of runs; None where it passes.

    Args:
        row: Its row of the table of runs as ingested.
        run: The run as measured; None where it has no rows.
    """
    run_id = row["run_id"]
    if row["rule"]:
        return Refusal(row["rule"], row["reason"], "", run_id)
    if run is None:
        return fault("no_rows", run_id=run_id)
    refusal = first_fault(run)
    return None if refusal is None else replace(refusal, run_id=run_id)


def _explanation(samples: Columns, run_row: Mapping[str, Any], rig: RigKind) -> Refusal | None:
    """The simple mistake without which most plateaus of a refused run would pass.

    Args:
        samples: Samples of the run.
        run_row: Its row of the table of runs.
        rig: The rig.

    Returns:
        A refusal that names the mistake; None where no mistake explains the refusal.
    """
    if run_row["log_kind"] == "steps":
        # the rig's program has settled and converted these readings
        return None
    hypotheses = [
        hypothesis
        for hypothesis in rig.hypotheses(run_row["rig"])
        if run_row["rule"] in hypothesis.explains
    ]
    mistakes_of_log = [hypothesis for hypothesis in hypotheses if not hypothesis.changes]
    passing = _passing(mistakes_of_log, samples, run_row, rig)
    for hypothesis in hypotheses:
        # the plausibility of settings does not need the levels, and to try them takes time
        if hypothesis.changes and hypothesis.plausible(samples, 0):
            changed_rig = type(rig)(rig.settings.with_changes(hypothesis.changes))
            passing += _passing([hypothesis], samples, run_row, changed_rig)
    if not passing:
        return None
    best = max(passing, key=lambda candidate: candidate.accepted_points).hypothesis
    # several units may be possible: the data do not show which one it is
    sentences = [
        candidate.hypothesis.sentence
        for candidate in passing
        if candidate.hypothesis.rule == best.rule
    ]
    reason = f"the run would pass with {'; or '.join(sentences)}; as it is, {run_row['reason']}"
    return Refusal(best.rule, reason, "", run_row["run_id"])


@dataclass(frozen=True)
class _Corrected(Mapping[str, Columns]):
    """Sentence of a hypothesis -> samples without its mistake, made when they are asked for.

    All at once would be as many logs in memory.
    """

    hypotheses: Mapping[str, Hypothesis]
    samples: Columns

    def __getitem__(self, sentence: str) -> Columns:
        return self.hypotheses[sentence].undo(self.samples)

    def __iter__(self) -> Iterator[str]:
        return iter(self.hypotheses)

    def __len__(self) -> int:
        return len(self.hypotheses)

    def __contains__(self, sentence: object) -> bool:
        return sentence in self.hypotheses


class _Passing(NamedTuple):
    """A hypothesis with which a run passes, and the number of its accepted plateaus then."""

    accepted_points: int
    hypothesis: Hypothesis


def _passing(
    hypotheses: Iterable[Hypothesis], samples: Columns, run_row: Mapping[str, Any], rig: RigKind
) -> list[_Passing]:
    """The plausible hypotheses with which most plateaus pass.

    Args:
        hypotheses: The hypotheses, all with the settings of the rig.
        samples: Samples of the run.
        run_row: Its row of the table of runs.
        rig: The rig.
    """
    # each is tried as a run of its own, with its sentence as id
    by_sentence = {hypothesis.sentence: hypothesis for hypothesis in hypotheses}
    if not by_sentence:
        return []
    runs = pd.DataFrame([{**run_row, "run_id": sentence, "rule": ""} for sentence in by_sentence])
    judged_runs = _judge(_measure_runs(_Corrected(by_sentence, samples), runs, rig)).runs
    passing: list[_Passing] = []
    most_pass = judged_runs["accepted_points"] > judged_runs["plateaus"] / 2
    for row in tables.rows(judged_runs[most_pass]):
        hypothesis = by_sentence[row["run_id"]]
        if hypothesis.plausible(samples, row["plateaus"]):
            passing.append(_Passing(row["accepted_points"], hypothesis))
    return passing


def collect(curated: Curated, settings: Settings, kind: type[RigKind] = TractionRig) -> Curated:
    """Judge all shares of a campaign by the rules that compare runs with each other.

    Args:
        curated: Tables of all shares, as `curate_parts` gives them.
        settings: Settings of the run.
        kind: The kind of rig.
    """
    shares = CampaignTables.in_memory(
        points=curated.points, runs=curated.runs, quarantine=curated.quarantine
    )
    compared = compare_runs(shares, settings, kind)
    points = compared.judged(curated.points)
    return Curated(
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
        refused: Refusals of runs by this comparison.
        kind: The kind of rig.
    """

    runs: pd.DataFrame
    quarantine: pd.DataFrame
    refused: list[Refusal]
    kind: type[RigKind]

    def judged(self, points: pd.DataFrame) -> pd.DataFrame:
        """Some rows of the table of points, with the verdicts on their runs."""
        return _refuse_plateaus(points, self.refused, self.kind) if self.refused else points


def compare_runs(
    shares: CampaignTables, settings: Settings, kind: type[RigKind] = TractionRig
) -> ComparedRuns:
    """Judge the runs of a campaign by the rules that compare them with each other.

    A rule reads only the columns of points that it needs, and the shapes of one oil at a time: the
    table of points of a large campaign does not fit into memory.

    Args:
        shares: Tables `points`, `runs` and `quarantine` of all shares.
        settings: Settings of the run.
        kind: The kind of rig.
    """
    runs, quarantine = shares.runs, shares.quarantine
    refused = repeated(shares, runs, kind, settings)
    runs, quarantine = _without(runs, quarantine, refused, kind)
    warnings: list[tuple[str, str]] = []
    if kind.name == TRACTION_KIND:
        odd: list[Refusal] = []
        for oil in sorted(set(runs.loc[runs["verdict"] == "accepted", "oil"])):
            shapes = judged_shapes(shares.table("points", SHAPE_COLUMNS, oil=oil), runs)
            odd += shapes.refused
            warnings += shapes.warnings
        runs, quarantine = _without(runs, quarantine, odd, kind)
        refused += odd
    runs = with_campaign_warnings(runs, shares, kind, settings, warnings)
    order = ["file", "run_id", "first_row", "rule"]
    return ComparedRuns(
        runs.sort_values("run_id", ignore_index=True),
        quarantine.sort_values(order, ignore_index=True),
        refused,
        kind,
    )


def _without(
    runs: pd.DataFrame, quarantine: pd.DataFrame, refused: list[Refusal], kind: type[RigKind]
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The tables of runs and of quarantine with some more runs refused."""
    if not refused:
        return runs, quarantine
    counts = runs.set_index("run_id")[["plateaus", "accepted_points"]]
    names = [refusal.run_id for refusal in refused]
    counts.loc[names, "accepted_points"] = 0
    if not kind.keeps_refused_runs:
        counts.loc[names, "plateaus"] = 0
    runs = _with_verdicts(runs, counts, refused)
    return runs, pd.concat([quarantine, quarantine_rows(refused, runs, kind)])


def arrays_of(samples: pd.DataFrame) -> Columns:
    """The columns of samples without the id of the run."""
    return {str(name): samples[name].to_numpy() for name in samples if name != "run_id"}


def _samples_by_run(samples: pd.DataFrame) -> dict[str, Columns]:
    """Id of a run -> its samples; the rows of a run must be together."""
    arrays = arrays_of(samples)
    samples_of_run: dict[str, Columns] = {}
    for run_id, rows in samples.groupby("run_id").indices.items():
        start, stop = rows[0], rows[-1] + 1
        samples_of_run[str(run_id)] = {name: array[start:stop] for name, array in arrays.items()}
    return samples_of_run


def _table_of_plateaus(
    plateaus_of_run: Mapping[str, Columns], runs: pd.DataFrame, rig: RigKind
) -> pd.DataFrame:
    """All plateaus, with columns of their run and those that follow from rig and oil.

    Args:
        plateaus_of_run: Id of a run -> columns over its plateaus.
        runs: Table of runs, indexed by id.
        rig: The rig.
    """
    if not plateaus_of_run:
        return tables.empty(rig.table)
    all_plateaus = list(plateaus_of_run.values())
    counts = [len(plateaus["time_s"]) for plateaus in all_plateaus]
    carried = runs.loc[list(plateaus_of_run), list(rig.carried)].reset_index()
    points = carried.take(np.repeat(np.arange(len(counts)), counts)).reset_index(drop=True)
    measured = {
        name: np.concatenate([plateaus[name] for plateaus in all_plateaus])
        for name in all_plateaus[0]
    }
    points = rig.complete(points.assign(**measured))
    # without any load mu is larger than a table may hold
    numbers = points.select_dtypes("float")
    return points.assign(**numbers.mask(numbers.abs() >= tables.LARGEST_NUMBER))


def _judge(measured: _MeasuredRuns) -> Curated:
    """Judge plateaus by the gates of plateaus, and runs by their plateaus."""
    points, runs, rig = measured.points, measured.runs, measured.rig
    refused = dict(measured.refused)
    failed_by_gate = judge_plateaus(points, rig)
    unrefused = ~points["run_id"].isin(list(refused))
    refused_by_plateaus = list(runs_not_usable(points[unrefused], failed_by_gate[unrefused], rig))
    points = points.assign(
        failed_gates=failed_gates.gate_name_lists(failed_by_gate),
        accepted=~failed_by_gate.any(axis=1),
    )
    points = _refuse_plateaus(points, list(refused.values()), type(rig))
    # plateaus of runs that are refused by their plateaus stay in the table of every rig. Accepted
    # ones get the rule of their run
    runs_with_accepted_points = set(points.loc[points["accepted"], "run_id"])
    rule_of_run = {
        refusal.run_id: refusal.rule
        for refusal in refused_by_plateaus
        if refusal.run_id in runs_with_accepted_points
    }
    points = failed_gates.with_gate_of_run(points, rule_of_run)
    refused |= {refusal.run_id: refusal for refusal in refused_by_plateaus}
    in_order_of_runs = [refused[run_id] for run_id in runs["run_id"] if run_id in refused]
    runs = _with_verdicts(runs, _counts_of_plateaus(points), in_order_of_runs)
    quarantine = quarantine_rows([*in_order_of_runs, *measured.too_short], runs, type(rig))
    return Curated(points[tables.columns(rig.table)], runs, quarantine)


def _refuse_plateaus(
    points: pd.DataFrame, refused: list[Refusal], kind: type[RigKind]
) -> pd.DataFrame:
    """Plateaus without those of refused runs, or with these refused, by the kind of rig."""
    gate_of_run = {refusal.run_id: refusal.rule for refusal in refused}
    if kind.keeps_refused_runs:
        return failed_gates.with_gate_of_run(points, gate_of_run)
    return points[~points["run_id"].isin(list(gate_of_run))]


def _counts_of_plateaus(points: pd.DataFrame) -> pd.DataFrame:
    """Numbers of plateaus and of accepted ones, by run."""
    by_run = points.groupby("run_id")["accepted"]
    return pd.DataFrame({"plateaus": by_run.size(), "accepted_points": by_run.sum()})


def _with_verdicts(
    runs: pd.DataFrame, counts: pd.DataFrame, refused: list[Refusal]
) -> pd.DataFrame:
    """Runs with rule and sentence of their refusal, counts of their plateaus, and verdict.

    Args:
        runs: Table of runs.
        counts: Numbers of plateaus and of accepted ones, by run.
        refused: Refusals of runs.
    """
    refusal_of_run = {refusal.run_id: (refusal.rule, refusal.reason) for refusal in refused}
    rules_and_reasons = [
        refusal_of_run.get(run_id, (rule, reason))
        for run_id, rule, reason in zip(runs["run_id"], runs["rule"], runs["reason"], strict=True)
    ]
    counts = counts.reindex(runs["run_id"], fill_value=0).astype(np.int64)
    plateaus = counts["plateaus"].to_numpy()
    accepted = counts["accepted_points"].to_numpy()
    # a run that is not used needs no warning
    warnings = [
        texts if count else () for texts, count in zip(runs["warning"], accepted, strict=True)
    ]
    return runs.assign(
        **pd.DataFrame(rules_and_reasons, runs.index, ["rule", "reason"], dtype="str"),
        plateaus=plateaus,
        accepted_points=accepted,
        warning=tables.list_column(warnings, runs.index),
        verdict=np.where(accepted > 0, "accepted", "refused"),
    ).reset_index(drop=True)
