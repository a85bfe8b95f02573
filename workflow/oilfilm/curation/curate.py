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
from typing import Any

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
from oilfilm.curation.rig_kind import TRACTION, RigKind, Run
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
from oilfilm.tables.set_points import SET_POINTS, with_levels

# ---------------------------------------------------------------- repeats

# Last plateaus by whose load, speed and temperature copies are looked up among all runs.
_LOOKED_UP = 3
# Campaigns without copies in which a run is taken for one: at most this share of them.
_CHANCE_OF_A_COPY = 1e-3
# Column of plateaus and its key of a rig's `full_scale`.
_SCALES = {
    "load_n": "load_n",
    "traction_force_n": "traction_force_n",
    "entrainment_speed_m_s": "surface_speed_m_s",
    "inlet_temperature_c": "temperature_c",
}
# Columns of points of which copies have the same noise at the same conditions.
_MEANS = ["slide_roll_ratio", "traction_coefficient"]
_ERRORS = [f"{name}_se" for name in _MEANS]
_AT = ["load_n", "entrainment_speed_m_s", "inlet_temperature_c"]


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
    left = runs[runs["verdict"] == "accepted"].sort_values(["file", "run_id"])
    refused: dict[str, Refusal] = {}
    for case in _readings(shares, left, kind, settings):
        refused.setdefault(case.run_id, case)
    if kind.name == TRACTION and settings.campaign.repeated_conditions != "accept":
        left = left[~left["run_id"].isin(refused)]
        refused |= {case.run_id: case for case in _conditions(shares, left, settings)}
    return list(refused.values())


def _readings(
    shares: CampaignTables, runs: pd.DataFrame, kind: type[RigKind], settings: Settings
) -> Iterator[Refusal]:
    """Copies of an earlier log, and the same readings under the names of two oils."""
    pairs = list(_same_readings(shares, runs, kind, settings))
    for first, later in pairs:
        if first.oil == later.oil:
            yield fault("duplicate_log", run_id=later.run_id, kept=first.run_id)
    for pair in pairs:
        for run, other in (pair, pair[::-1]):
            if run.oil != other.oil:
                yield fault("conflicting_labels", run_id=run.run_id, other=other)


def _conditions(
    shares: CampaignTables, runs: pd.DataFrame, settings: Settings
) -> Iterator[Refusal]:
    """Runs of one condition: curves that contradict each other, and all but one of the others.

    Two runs contradict each other beyond `repeat_difference_max`. Of three or more, one that is off
    by less is odd where the others agree far better with each other than with it.
    """
    gates = settings.gates
    allowed, odd = gates.repeat_difference_max, gates.repeat_odd_min
    for names, apart in _compared_conditions(shares, runs, settings):
        kept = []
        largest_mutual = _largest_without_each(apart)
        for index, run_id in enumerate(names):
            others = np.delete(np.arange(len(names)), index)
            to_others = apart[index, others]
            mutual = largest_mutual[index]
            limit = max(odd, gates.repeat_odd_factor * mutual) if len(others) > 1 else allowed
            against = others[to_others > allowed]
            if len(against) <= len(others) / 2:
                against = others[to_others > limit]
                if len(against) < len(others):
                    kept.append(index)
                    continue
            more = f" (and {len(against) - 1} more)" if len(against) > 1 else ""
            agree = f"; the others agree within {mutual:.1%}" if len(others) > 1 else ""
            about = dict(other=names[against[0]], apart=apart[index, against[0]], more=more)
            about |= dict(agree=agree, allowed=min(limit, allowed))
            yield fault("conflicting_condition", run_id=run_id, **about)
        for later in kept[1:]:
            about = dict(kept=names[kept[0]], apart=apart[kept[0], later])
            yield fault("duplicate_condition", run_id=names[later], **about)


def _largest_without_each(apart: FloatArray) -> FloatArray:
    """The largest difference between two runs without a third one, for each of these.

    Args:
        apart: Differences of n runs, shape (n, n), symmetric.
    """
    count = len(apart)
    largest = np.full(count, apart.max())
    # only the two runs that are farthest apart have another largest difference
    for farthest in np.unravel_index(np.argmax(apart), apart.shape):
        others = np.delete(np.arange(count), farthest)
        largest[farthest] = apart[np.ix_(others, others)].max()
    return largest


def _compared_conditions(
    shares: CampaignTables, runs: pd.DataFrame, settings: Settings
) -> Iterator[tuple[list[str], FloatArray]]:
    """Runs of the same oil, rig and set points, and how far the curves of each two are apart.

    A load counts by the pressure that it makes, where the rig's contact is known: a pressure that
    is rounded by 0.5 % is a load that is off by 1.5 %.
    """
    noted, (pressure, load, *_) = with_levels(runs, settings), SET_POINTS
    # one of the two is unknown
    noted = noted[noted[[pressure, load]].notna().any(axis=1)].fillna({pressure: -1, load: -1})
    groups = list(_same(noted, ["oil", "rig", *SET_POINTS]))
    if not groups:
        return
    points = shares.table("points", ["run_id", "accepted", *_MEANS, _ERRORS[1]])
    has_repeats = points["run_id"].isin({run.run_id for group in groups for run in group})
    accepted = points[points["accepted"] & has_repeats]
    rows = accepted.groupby("run_id").indices
    for group in groups:
        names = [run.run_id for run in group]
        curves = [_curve(accepted.iloc[rows[name]]) for name in names]
        yield names, _differences(curves, settings.gates.sign_slip_min)


def _same(runs: pd.DataFrame, key: list[str]) -> Iterator[list[Any]]:
    """Runs with the same values of some columns, two or more; empty values are not compared."""
    known = runs[runs[key].notna().all(axis=1) & (runs[key] != "").all(axis=1)]
    # a group takes its time, and hardly any run has a second one in its own
    for _, group in known[known.duplicated(key, keep=False)].groupby(key, sort=False):
        yield list(group.itertuples())


def _same_readings(
    shares: CampaignTables, runs: pd.DataFrame, kind: type[RigKind], settings: Settings
) -> Iterator[tuple[Any, Any]]:
    """Pairs of runs out of files of one content, or with plateaus of the same noise."""
    named: dict[str, Any] = {str(run.run_id): run for run in runs.itertuples()}
    # a file may hold several runs
    places = [f"in {run_id.removeprefix(run.file)}" for run_id, run in named.items()]
    for first, *others in _same(runs.assign(place=places), ["content_sha256", "place"]):
        yield from ((first, later) for later in others)
    if kind.name == TRACTION:
        copies = settings.gates.copies
        run_ids = pd.Index(runs["run_id"])
        last_points = []
        for part in shares.parts("points", ["run_id", *_MEANS, *_ERRORS, *_AT]):
            is_compared = _is_of_runs(part, run_ids) & (part[_ERRORS] > 0).all(axis=1)
            compared = part[is_compared]
            last_points.append(compared.groupby("run_id").tail(copies.plateaus + 1))
        for name, other in _same_noise(pd.concat(last_points, ignore_index=True), copies):
            yield named[name], named[other]


def _is_of_runs(points: pd.DataFrame, run_ids: pd.Index) -> BoolArray:
    """Which points are of some runs, shape (points,); many parts share one look-up of the runs."""
    return np.asarray(run_ids.get_indexer(pd.Index(points["run_id"])) >= 0)


def _same_noise(points: pd.DataFrame, copies: CopySettings) -> Iterator[tuple[str, str]]:
    """Pairs of runs whose plateaus differ by far less than their own errors, whatever the rows.

    The same readings, cut off elsewhere or rounded, keep the errors of their means; other readings
    of the same condition have other ones. The last plateaus of both are compared, but for the very
    last: it ends where the log does, or in a step that is found to within a few rows.
    """
    of_runs = points.groupby("run_id")
    counts = of_runs.size()
    names = counts.index[counts > copies.plateaus]
    last = of_runs.tail(copies.plateaus + 1)
    last = last.drop(of_runs.tail(1).index)
    last = last[last["run_id"].isin(names)]
    if len(names) < 2:
        return
    values, se, at = (
        last[columns].to_numpy(float).reshape(len(names), copies.plateaus, -1)
        for columns in (_MEANS, _ERRORS, _AT)
    )
    near = np.nan_to_num(at[:, -_LOOKED_UP:].reshape(len(names), -1))
    reach = copies.condition * np.abs(near).max(axis=0)
    near = near / np.where(reach > 0, reach, 1.0)
    tree = scipy.spatial.cKDTree(near)
    pairs = (int(tree.count_neighbors(tree, 1.0, p=np.inf)) - len(names)) // 2
    allowed = np.array([copies.slip_errors, _traction_errors(copies, pairs)])
    # between neighbouring plateaus no zero counts: these differences of mu find the pairs that may
    # be copies. Two plateaus have the sum of squares of all at most
    contrasts = np.diff(values[..., 1], axis=1)
    reach = 2 * allowed[1] * np.sqrt(copies.plateaus) * se[..., 1].max()
    tree = scipy.spatial.cKDTree(np.concatenate([near, contrasts / reach], axis=1))
    for one, other in sorted(tree.query_pairs(1.0, p=np.inf)):
        apart = values[one] - values[other]
        # the zero of the force may be that of other rows, and rounding moves the speeds
        apart -= np.median(apart, axis=0)
        relative = apart / np.hypot(se[one], se[other])
        rms = np.sqrt(np.mean(relative**2, axis=0))
        if (rms < allowed).all():
            yield names[one], names[other]


def _traction_errors(copies: CopySettings, pairs: int) -> float:
    """Largest rms difference of mu over its standard errors at which a pair is a copy.

    The more pairs are compared, the smaller the differences that occur by chance. So small ones as
    this occur in one of a thousand campaigns without copies. The sum of squares of m differences,
    less their mean, has the chi-squared distribution of m - 1 degrees of freedom.
    """
    chance = _CHANCE_OF_A_COPY / max(pairs, 1)
    squares = scipy.stats.chi2.ppf(chance, copies.plateaus - 1)
    return min(copies.traction_errors, float(np.sqrt(squares / copies.plateaus)))


# Rising slips of a run, its traction coefficients and their standard errors, each of shape (n,).
_Curve = tuple[FloatArray, FloatArray, FloatArray]


def _differences(curves: Sequence[_Curve], smallest_slip: float) -> FloatArray:
    """Median relative difference of each two curves over the slips that both have.

    Twice the standard error of each difference is subtracted where it is known.

    Args:
        curves: The curves, n of them.
        smallest_slip: Smaller slips are not compared.

    Returns:
        Shape (n, n), symmetric; 0 where two curves have no slips in common.
    """
    apart = np.zeros((len(curves), len(curves)))
    lengths = np.array([len(slip) for slip, _, _ in curves])
    all_slip, all_mu, all_se = (np.concatenate(columns) for columns in zip(*curves, strict=True))
    for index, (slip, mu, se) in enumerate(curves[:-1]):
        # the curves behind it, one after the other
        later = slice(lengths[: index + 1].sum(), None)
        later_slip = all_slip[later]
        shared = (later_slip >= max(slip.min(), smallest_slip)) & (later_slip <= slip.max())
        later_slip = later_slip[shared]
        later_mu = all_mu[later][shared]
        expected_mu = np.interp(later_slip, slip, mu)
        expected_se = np.interp(later_slip, slip, se)
        error = np.nan_to_num(2 * np.hypot(all_se[later][shared], expected_se))
        excess = np.maximum(np.abs(later_mu - expected_mu) - error, 0.0)
        mean_size = (np.abs(later_mu) + np.abs(expected_mu)) / 2
        curve_of_point = np.repeat(np.arange(index + 1, len(curves)), lengths[index + 1 :])[shared]
        compared, starts = np.unique(curve_of_point, return_index=True)
        stretches = Stretches(starts, np.append(starts[1:], len(curve_of_point)))
        medians = stretches.medians(excess / mean_size) if len(compared) else 0.0
        apart[index, compared] = apart[compared, index] = medians
    return apart


def _curve(points: pd.DataFrame) -> _Curve:
    """Rising slips of a run, its traction coefficients and their standard errors, shape (n,)."""
    ordered = points.sort_values("slide_roll_ratio", kind="stable")
    return (
        ordered["slide_roll_ratio"].to_numpy(float),
        ordered["traction_coefficient"].to_numpy(float),
        ordered["traction_coefficient_se"].to_numpy(float),
    )


def with_campaign_warnings(
    runs: pd.DataFrame,
    shares: CampaignTables,
    kind: type[RigKind],
    settings: Settings,
    of_shapes: Iterable[tuple[str, str]],
) -> pd.DataFrame:
    """Runs with warnings that only the other runs of their rig, or its file, can give.

    Args:
        runs: Table of runs.
        shares: The table `points`, of which each rule reads the columns that it compares.
        kind: The kind of rig.
        settings: Settings of the run.
        of_shapes: Warnings about the shapes of curves: id of the run and a sentence.
    """
    if kind.name != TRACTION:
        return runs
    accepted = runs[runs["verdict"] == "accepted"].set_index("run_id")
    texts = {run_id: list(own_texts) for run_id, own_texts in accepted["warning"].items()}

    def parts(*columns: str) -> Iterator[pd.DataFrame]:
        """Some columns of the points of accepted runs, some rows at a time."""
        for part in shares.parts("points", ["run_id", *columns]):
            yield part[_is_of_runs(part, accepted.index)]

    constant = _constant_channels(parts("load_n", "inlet_temperature_c"), accepted, settings.gates)
    of_rig = _of_rig(parts(*_SCALES), accepted["rig"], settings)
    of_spin = spin_warnings(parts("accepted", *_MEANS, "load_n"), accepted["rig"], settings)
    of_oil = _of_oil(accepted["oil"], settings)
    speeds = _speed_controls(
        lambda: parts("accepted", "entrainment_speed_m_s", "slide_roll_ratio"),
        accepted,
        settings.gates,
    )
    for run_id, text in chain(of_shapes, constant, of_rig, of_spin, of_oil, speeds):
        texts[run_id].append(text)
    warnings = [tuple(texts.get(run_id, ())) for run_id in runs["run_id"]]
    return runs.assign(warning=tables.lists(warnings, runs.index))


def _of_rig(
    parts: Iterable[pd.DataFrame], rigs: "pd.Series[str]", settings: Settings
) -> Iterator[tuple[str, str]]:
    """Warnings from the rig's file: readings beyond the full scale, impossible materials.

    Each is the id of the run and a sentence.
    """
    largest = [part[list(_SCALES)].abs().groupby(part["run_id"]).max() for part in parts]
    # the rows of a run may be in two parts
    largest_of_run = pd.concat(largest).groupby(level=0).max()
    for rig_name, of_rig in largest_of_run.groupby(rigs.reindex(largest_of_run.index)):
        rig = settings.rigs.get(str(rig_name))
        if rig is None:
            continue
        advice = f"correct {rig_name}.yaml"
        for doubt in rig.doubts():
            for run_id in of_rig.index:
                yield str(run_id), f"unusual_rig: {doubt}; {advice}"
        if rig.full_scale is None:
            continue
        for column, key in _SCALES.items():
            full_scale = getattr(rig.full_scale, key)
            beyond = of_rig.loc[exceeds(of_rig[column], full_scale), column]
            for run_id, reading in beyond.items():
                about = dict(column=column, of=reading, full=full_scale, key=key)
                yield str(run_id), f"{fault('full_scale', **about).reason}; {advice}"


def _of_oil(oils: "pd.Series[str]", settings: Settings) -> Iterator[tuple[str, str]]:
    """Warnings from the files of the oils, each as the id of a run and a sentence."""
    for oil_name, runs in oils.groupby(oils):
        oil = settings.oils[str(oil_name)]
        for doubt in oil.doubts() if oil else ():
            for run_id in runs.index:
                yield str(run_id), f"unusual_oil: {doubt}; correct {oil_name}.yaml"


def _speed_controls(
    parts: Callable[[], Iterable[pd.DataFrame]], runs: pd.DataFrame, gates: GateSettings
) -> Iterator[tuple[str, str]]:
    """Runs in which a rig holds the speed of one body: id and a sentence."""
    set_speeds = runs["nominal_entrainment_speed_m_s"]
    off_runs: set[str] = set()
    for part in parts():
        points = part[part["accepted"]]
        nominal_of_point = set_speeds.reindex(points["run_id"]).to_numpy()
        off = (points["entrainment_speed_m_s"] - nominal_of_point).abs()
        is_off = exceeds(off, gates.speed_tolerance * nominal_of_point)
        off_runs |= set(points.loc[is_off, "run_id"])
    if not off_runs:
        return
    of_off_runs = pd.concat([part[part["run_id"].isin(off_runs)] for part in parts()])
    for run_id, of_run in of_off_runs[of_off_runs["accepted"]].groupby("run_id"):
        nominal = set_speeds[run_id]
        mean = of_run["entrainment_speed_m_s"]
        held = held_speed(of_run)
        speeds = controlled_speeds(of_run).items()
        control = next(name for name, speed in speeds if speed.equals(held))
        about = dict(control=control, set=nominal, least=mean.min(), most=mean.max())
        yield str(run_id), fault("body_at_set_speed", **about).reason


def _constant_channels(
    parts: Iterable[pd.DataFrame], runs: pd.DataFrame, gates: GateSettings
) -> Iterator[tuple[str, str]]:
    """A channel that is one number in all plateaus of a run, and moves in most other runs."""
    names = {"load_n": "load", "inlet_temperature_c": "inlet temperature"}
    of_parts = [part.groupby("run_id")[list(names)].agg(["min", "max", "size"]) for part in parts]
    joined = pd.concat(of_parts)
    for column, name in names.items():
        # the rows of a run may be in two parts
        by_run = pd.DataFrame(joined[column]).groupby(level=0)
        of_runs = pd.DataFrame(
            {"min": by_run["min"].min(), "max": by_run["max"].max(), "size": by_run["size"].sum()}
        )
        judged = of_runs[of_runs["size"] >= gates.constant_channel_plateaus]
        constant = pd.Series(reaches(judged["min"], judged["max"]), judged.index)
        for _, of_rig in constant.groupby(runs["rig"].reindex(judged.index)):
            if len(of_rig) >= gates.constant_channel_runs and of_rig.mean() < 1 / 2:
                moving = dict(name=name, others=(~of_rig).sum(), runs=len(of_rig))
                for run_id in of_rig.index[of_rig]:
                    value = of_runs["min"].loc[run_id]
                    yield str(run_id), fault("constant_channel", value=value, **moving).reason


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
    samples_of_run = _by_run(samples)
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
        run = None
        if run_id in samples_of_run:
            signals = rig.signals(samples_of_run[run_id], row["rig"], rig.settings)
            run = measure(signals, rig, row["rig"], settled=row["log_kind"] == "steps")
            plateaus_of_run[run_id] = run.plateaus
        refusal = _refusal_before_plateaus(row, run)
        if refusal is not None:
            refused[run_id] = refusal
        if run is None or refusal is not None:
            warnings.append(())
        else:
            warnings.append(warnings_about(run))
            too_short += [replace(level, run_id=run_id) for level in run.too_short]
    runs = runs.assign(warning=tables.lists(warnings, runs.index))
    points = _table_of_plateaus(plateaus_of_run, runs.set_index("run_id"), rig)
    return _MeasuredRuns(points, runs, refused, too_short, rig)


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


def _explanation(samples: Columns, run: Mapping[str, Any], rig: RigKind) -> Refusal | None:
    """The simple mistake without which most plateaus of a refused run would pass.

    Args:
        samples: Samples of the run.
        run: Its row of the table of runs.
        rig: The rig.

    Returns:
        A refusal that names the mistake; None where no mistake explains the refusal.
    """
    if run["log_kind"] == "steps":
        # the rig's program has settled and converted these readings
        return None
    hypotheses = [
        hypothesis
        for hypothesis in rig.hypotheses(run["rig"])
        if run["rule"] in hypothesis.explains
    ]
    of_logs = [hypothesis for hypothesis in hypotheses if not hypothesis.changes]
    passing = _passing(of_logs, samples, run, rig)
    for hypothesis in hypotheses:
        # the plausibility of settings does not need the levels, and to try them takes time
        if hypothesis.changes and hypothesis.plausible(samples, 0):
            changed_rig = type(rig)(rig.settings.with_changes(hypothesis.changes))
            passing += _passing([hypothesis], samples, run, changed_rig)
    if not passing:
        return None
    _, best = max(passing, key=lambda counted: counted[0])
    # several units may be possible: the data do not show which one it is
    sentences = [hypothesis.sentence for _, hypothesis in passing if hypothesis.rule == best.rule]
    reason = f"the run would pass with {'; or '.join(sentences)}; as it is, {run['reason']}"
    return Refusal(best.rule, reason, "", run["run_id"])


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


def _passing(
    hypotheses: Iterable[Hypothesis], samples: Columns, run: Mapping[str, Any], rig: RigKind
) -> list[tuple[int, Hypothesis]]:
    """The plausible hypotheses with which most plateaus pass, each with their number.

    Args:
        hypotheses: The hypotheses, all with the settings of the rig.
        samples: Samples of the run.
        run: Its row of the table of runs.
        rig: The rig.
    """
    # each is tried as a run of its own, with its sentence as id
    by_sentence = {hypothesis.sentence: hypothesis for hypothesis in hypotheses}
    if not by_sentence:
        return []
    runs = pd.DataFrame([{**run, "run_id": sentence, "rule": ""} for sentence in by_sentence])
    judged = _judge(_measure_runs(_Corrected(by_sentence, samples), runs, rig)).runs
    passing: list[tuple[int, Hypothesis]] = []
    for row in tables.rows(judged[judged["accepted_points"] > judged["plateaus"] / 2]):
        hypothesis = by_sentence[row["run_id"]]
        if hypothesis.plausible(samples, row["plateaus"]):
            passing.append((row["accepted_points"], hypothesis))
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
    if kind.name == TRACTION:
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


def _by_run(samples: pd.DataFrame) -> dict[str, Columns]:
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
    return points.assign(**numbers.mask(numbers.abs() >= tables.LARGEST))


def _judge(measured: _MeasuredRuns) -> Curated:
    """Judge plateaus by the gates of plateaus, and runs by their plateaus."""
    points, runs, rig = measured.points, measured.runs, measured.rig
    refused = dict(measured.refused)
    failed = judge_plateaus(points, rig)
    unrefused = ~points["run_id"].isin(list(refused))
    refused_by_plateaus = list(runs_not_usable(points[unrefused], failed[unrefused], rig))
    points = points.assign(failed_gates=failed_gates.names_of(failed), accepted=~failed.any(axis=1))
    points = _refuse_plateaus(points, list(refused.values()), type(rig))
    # plateaus of runs that are refused by their plateaus stay in the table of every rig. Accepted
    # ones get the rule of their run
    with_accepted = set(points.loc[points["accepted"], "run_id"])
    rule_of_run = {
        refusal.run_id: refusal.rule
        for refusal in refused_by_plateaus
        if refusal.run_id in with_accepted
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
        warning=tables.lists(warnings, runs.index),
        verdict=np.where(accepted > 0, "accepted", "refused"),
    ).reset_index(drop=True)
