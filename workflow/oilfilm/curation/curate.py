"""Samples to plateaus with verdicts: one engine for every kind of rig.

samples -> signals -> zero -> plateaus -> derived quantities -> gates -> verdicts. A `RigKind`
says what differs between the rigs.

Runs that repeat each other are copies, conditions run twice, or wrong labels. A rule compares the
accepted runs of a campaign with each other. Where several of them can be right, the first by name
is kept. Where two contradict each other, none is; of more, those that most of the others contradict
are refused.

Decides: when a run repeats an earlier one, and which of them is kept; warnings about a run beside
the others of its rig.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import chain, combinations
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import scipy

from oilfilm import tables
from oilfilm.curation.gate import fault
from oilfilm.curation.hypotheses import DOUBTFUL, Hypothesis
from oilfilm.curation.measure import measure
from oilfilm.curation.plateau_gates import judge_plateaus, quarantine_rows, runs_not_usable
from oilfilm.curation.rig_kind import TRACTION, RigKind
from oilfilm.curation.run_gates import first_fault, warning
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.logs.base import Columns, Refusal
from oilfilm.logs.ingest import Ingested, ingest_logs, sample_files
from oilfilm.logs.raw_files import RawLogs
from oilfilm.logs.run_sheet import NO_SHEET, RunSheet
from oilfilm.settings.config import CopySettings, GateSettings
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from oilfilm.tables.set_points import SET_POINTS, with_levels
from oilfilm.ties import exceeds, reaches

# ---------------------------------------------------------------- repeats

# Last plateaus by whose load, speed and temperature copies are looked up among all runs.
_LOOKED_UP = 3
# Column of plateaus and its key of a rig's `full_scale`.
_SCALES = {
    "load_n": "load_n",
    "traction_force_n": "traction_force_n",
    "entrainment_speed_m_s": "surface_speed_m_s",
    "inlet_temperature_c": "temperature_c",
}


def repeated(
    points: pd.DataFrame, runs: pd.DataFrame, kind: type[RigKind], settings: Settings
) -> list[Refusal]:
    """Refusals of accepted runs that repeat or contradict others, those of copies first.

    A torque rig may measure a condition again, and so may a campaign that declares repeats.

    Args:
        points: Table of plateaus.
        runs: Table of runs.
        kind: The kind of rig.
        settings: Settings of the run.
    """
    left = runs[runs["verdict"] == "accepted"].sort_values(["file", "run_id"])
    refused: dict[str, Refusal] = {}
    for case in _readings(points, left, kind, settings):
        refused.setdefault(case.run_id, case)
    if kind.name == TRACTION and settings.campaign.repeated_conditions != "accept":
        left = left[~left["run_id"].isin(refused)]
        refused |= {case.run_id: case for case in _conditions(points, left, settings)}
    return list(refused.values())


def _readings(
    points: pd.DataFrame, runs: pd.DataFrame, kind: type[RigKind], settings: Settings
) -> Iterator[Refusal]:
    """Copies of an earlier log, and the same readings under the names of two oils."""
    pairs = list(_same_readings(points, runs, kind, settings))
    for first, later in pairs:
        if first.oil == later.oil:
            yield fault("duplicate_log", run_id=later.run_id, kept=first.run_id)
    for pair in pairs:
        for run, other in (pair, pair[::-1]):
            if run.oil != other.oil:
                yield fault("conflicting_labels", run_id=run.run_id, other=other)


def _conditions(points: pd.DataFrame, runs: pd.DataFrame, settings: Settings) -> Iterator[Refusal]:
    """Runs of one condition: curves that contradict each other, and all but one of the others.

    Two runs contradict each other beyond `repeat_difference_max`. Of three or more, one that is off
    by less is odd where the others agree far better with each other than with it.
    """
    gates = settings.gates
    allowed, odd = gates.repeat_difference_max, gates.repeat_odd_min
    for names, apart in _compared_conditions(points, runs, settings):
        kept = []
        for run_id in names:
            others = [name for name in names if name != run_id]
            to_others = {name: apart[frozenset((run_id, name))] for name in others}
            mutual = [apart[frozenset(pair)] for pair in combinations(others, 2)]
            limit = max(odd, gates.repeat_odd_factor * max(mutual)) if mutual else allowed
            against = [name for name, difference in to_others.items() if difference > allowed]
            if len(against) <= len(others) / 2:
                against = [name for name, difference in to_others.items() if difference > limit]
                if len(against) < len(others):
                    kept.append(run_id)
                    continue
            more = f" (and {len(against) - 1} more)" if len(against) > 1 else ""
            agree = f"; the others agree within {max(mutual):.1%}" if mutual else ""
            about = dict(other=against[0], more=more, apart=to_others[against[0]], agree=agree)
            about["allowed"] = min(limit, allowed)
            yield fault("conflicting_condition", run_id=run_id, **about)
        for later in kept[1:]:
            about = dict(kept=kept[0], apart=apart[frozenset((kept[0], later))])
            yield fault("duplicate_condition", run_id=later, **about)


def _compared_conditions(
    points: pd.DataFrame, runs: pd.DataFrame, settings: Settings
) -> Iterator[tuple[list[str], dict[frozenset[str], float]]]:
    """Runs of the same oil, rig and set points, and how far the curves of each two are apart.

    A load counts by the pressure that it makes, where the rig's contact is known: a pressure that
    is rounded by 0.5 % is a load that is off by 1.5 %.
    """
    accepted = points[points["accepted"]]
    rows = accepted.groupby("run_id").indices
    noted, (pressure, load, *_) = with_levels(runs, settings), SET_POINTS
    # one of the two is unknown
    noted = noted[noted[[pressure, load]].notna().any(axis=1)].fillna({pressure: -1, load: -1})
    for group in _same(noted, ["oil", "rig", *SET_POINTS]):
        curves = {run.run_id: accepted.iloc[rows[run.run_id]] for run in group}
        apart = {
            frozenset((one, other)): _difference(curves[one], curves[other], settings)
            for one, other in combinations(curves, 2)
        }
        yield list(curves), apart


def _same(runs: pd.DataFrame, key: list[str]) -> Iterator[list[Any]]:
    """Runs with the same values of some columns, two or more; empty values are not compared."""
    known = runs[runs[key].notna().all(axis=1) & (runs[key] != "").all(axis=1)]
    # a group takes its time, and hardly any run has a second one in its own
    for _, group in known[known.duplicated(key, keep=False)].groupby(key, sort=False):
        yield list(group.itertuples())


def _same_readings(
    points: pd.DataFrame, runs: pd.DataFrame, kind: type[RigKind], settings: Settings
) -> Iterator[tuple[Any, Any]]:
    """Pairs of runs out of files of one content, or with plateaus of the same noise."""
    named: dict[str, Any] = {str(run.run_id): run for run in runs.itertuples()}
    # a file may hold several runs
    places = [f"in {run_id.removeprefix(run.file)}" for run_id, run in named.items()]
    for first, *others in _same(runs.assign(place=places), ["content_sha256", "place"]):
        yield from ((first, later) for later in others)
    if kind.name == TRACTION:
        left = points[points["run_id"].isin(named)]
        for name, other in _same_noise(left, settings.gates.copies):
            yield named[name], named[other]


def _same_noise(points: pd.DataFrame, copies: CopySettings) -> Iterator[tuple[str, str]]:
    """Pairs of runs whose plateaus differ by far less than their own errors, whatever the rows.

    The same readings, cut off elsewhere or rounded, keep the errors of their means; other readings
    of the same condition have other ones. The last plateaus of both are compared, but for the very
    last: it ends where the log does, or in a step that is found to within a few rows.
    """
    means = ["slide_roll_ratio", "traction_coefficient"]
    errors = [f"{name}_se" for name in means]
    of_runs = points[(points[errors] > 0).all(axis=1)].groupby("run_id")
    counts = of_runs.size()
    names = counts.index[counts > copies.plateaus]
    last = of_runs.tail(copies.plateaus + 1)
    last = last.drop(of_runs.tail(1).index)
    last = last[last["run_id"].isin(names)]
    if len(names) < 2:
        return
    values, se, at = (
        last[columns].to_numpy(float).reshape(len(names), copies.plateaus, -1)
        for columns in (means, errors, ["load_n", "entrainment_speed_m_s", "inlet_temperature_c"])
    )
    near = np.nan_to_num(at[:, -_LOOKED_UP:].reshape(len(names), -1))
    reach = copies.condition * np.abs(near).max(axis=0)
    scaled = near / np.where(reach > 0, reach, 1.0)
    for one, other in sorted(scipy.spatial.cKDTree(scaled).query_pairs(1.0, p=np.inf)):
        apart = values[one] - values[other]
        # the zero of the force may be that of other rows, and rounding moves the speeds
        apart -= np.median(apart, axis=0)
        relative = apart / np.hypot(se[one], se[other])
        rms = np.sqrt(np.mean(relative**2, axis=0))
        if (rms < (copies.slip_errors, copies.traction_errors)).all():
            yield names[one], names[other]


def _difference(first: pd.DataFrame, later: pd.DataFrame, settings: Settings) -> float:
    """Median relative difference of two curves of traction over the slips that both have.

    Less twice the standard error of each difference, where it is known.
    """
    columns = ["slide_roll_ratio", "traction_coefficient", "traction_coefficient_se"]
    (slip, mu, se), (other_slip, other, other_se) = (
        curve.sort_values("slide_roll_ratio", kind="stable")[columns].to_numpy(float).T
        for curve in (later, first)
    )
    least = max(other_slip.min(), settings.gates.sign_slip_min)
    shared = (slip >= least) & (slip <= other_slip.max())
    if not shared.any():
        return 0.0
    slip, mu, se = slip[shared], mu[shared], se[shared]
    expected, expected_se = (np.interp(slip, other_slip, each) for each in (other, other_se))
    beyond = np.abs(mu - expected) - np.nan_to_num(2 * np.hypot(se, expected_se))
    return float(np.median(np.maximum(beyond, 0.0) / ((np.abs(mu) + np.abs(expected)) / 2)))


def with_campaign_warnings(
    runs: pd.DataFrame, points: pd.DataFrame, kind: type[RigKind], settings: Settings
) -> pd.DataFrame:
    """Runs with warnings that only the other runs of their rig, or its file, can give."""
    if kind.name != TRACTION:
        return runs
    accepted = runs[runs["verdict"] == "accepted"].set_index("run_id")
    texts = {run_id: [text] for run_id, text in accepted["warning"].items() if text}
    points = points[points["run_id"].isin(accepted.index)]
    constant = _constant_channels(points, accepted, settings.gates)
    constant = _constant_channels(points, accepted, settings.gates)
    for run_id, text in chain(constant, _of_rig(points, accepted["rig"], settings)):
        texts.setdefault(run_id, []).append(text)
    warnings = ["; ".join(texts.get(run_id, ())) for run_id in runs["run_id"]]
    return runs.assign(warning=pd.Series(warnings, runs.index, dtype="str"))


def _of_rig(
    points: pd.DataFrame, rigs: "pd.Series[str]", settings: Settings
) -> Iterator[tuple[str, str]]:
    """Readings beyond the full scale of the rig's file, and materials that no rig has."""
    for run_id, of_run in points.groupby("run_id"):
        rig = settings.rigs.get(name := rigs.loc[run_id])
        doubts = [f"unusual_rig: {each}" for each in rig.doubts()] if rig else []
        scale = rig.full_scale if rig else None
        for column, key in _SCALES.items() if scale else ():
            largest, full = of_run[column].abs().max(), getattr(scale, key)
            if exceeds(largest, full):
                about = dict(column=column, of=largest, full=full, key=key)
                doubts.append(fault("full_scale", **about).reason)
        yield from ((str(run_id), f"{each}; correct {name}.yaml") for each in doubts)


def _constant_channels(
    points: pd.DataFrame, runs: pd.DataFrame, gates: GateSettings
) -> Iterator[tuple[str, str]]:
    """A channel that is one number in all plateaus of a run, and moves in most other runs."""
    for column, name in (("load_n", "load"), ("inlet_temperature_c", "inlet temperature")):
        of_runs = points.groupby("run_id")[column].agg(["min", "max", "size"])
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
    """Plateaus of a campaign or a share of it, its runs with their verdicts, what was refused."""

    points: pd.DataFrame
    runs: pd.DataFrame
    quarantine: pd.DataFrame


def check_logs(
    logs: Iterable[tuple[str, bytes]],
    settings: Settings,
    kind: type[RigKind] = TractionRig,
    sheet: RunSheet = NO_SHEET,
) -> Curated:
    """What ingest and curation make of logs, given by name and content, and their run sheet."""
    return curate_ingested(ingest_logs(logs, settings, kind.logs, sheet), kind(settings))


def curate_ingested(ingested: Ingested, rig: RigKind) -> Curated:
    """What curation makes of logs that are all of a campaign."""
    samples = ingested.all_samples()
    curated = collect(curate_parts([samples], ingested, rig), rig.settings, type(rig))
    # what the workflow could not write must not pass here
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
    """Read a share of the logs, write its samples and curate them; memory does not grow with it.

    Args:
        logs: The logs.
        settings: Settings of the run.
        sheet: The run sheet.
        samples: File of each oil's samples.
        provenance: As `tables.writing`.

    Returns:
        Plateaus, runs, and what was refused at any stage.
    """
    with sample_files(samples, provenance) as keep:
        ingested = ingest_logs(logs, settings, sheet=sheet, keep=keep, verified=logs.digests)
    parts = tables.read_parts("samples", *samples.values())
    return curate_parts(parts, ingested, TractionRig(settings))


def curate_parts(samples: Iterable[pd.DataFrame], ingested: Ingested, rig: RigKind) -> Curated:
    """Plateaus, runs and all that was refused, of samples that come in parts, one held at a time.

    Args:
        samples: Parts of the table of samples, each with whole runs.
        ingested: The logs that they are of.
        rig: The rig.
    """
    runs, parts = ingested.runs, []
    without_rows = runs["run_id"]
    for part in samples:
        run_ids = part["run_id"].unique()
        without_rows = without_rows[~without_rows.isin(run_ids)]
        parts.append(curate(part, runs[runs["run_id"].isin(run_ids)], rig))
    parts.append(curate(tables.empty("samples"), runs.loc[without_rows.index], rig))
    points, of_runs, quarantine = (
        pd.concat([getattr(part, name) for part in parts], ignore_index=True)
        for name in ("points", "runs", "quarantine")
    )
    return Curated(points, of_runs, pd.concat([ingested.quarantine, quarantine], ignore_index=True))


def curate(samples: pd.DataFrame, runs: pd.DataFrame, rig: RigKind) -> Curated:
    """Plateaus of every run, judged by every gate of the rig.

    Args:
        samples: Table of samples, the rows of a run together.
        runs: Table of runs as ingested.
        rig: The rig.
    """
    samples_of = _by_run(samples)
    measured = _measured(samples_of, runs, rig)
    judged = _judge(measured)
    explained = {
        row["run_id"]: cause
        for row in tables.rows(judged.runs[judged.runs["rule"].isin(DOUBTFUL)])
        if row["run_id"] in samples_of
        and (cause := _explanation(samples_of[row["run_id"]], row, rig))
    }
    measured.refused.update(explained)
    return _judge(measured) if explained else judged


@dataclass(frozen=True)
class _Measured:
    """Plateaus of runs, and what their own run refuses or warns of."""

    points: pd.DataFrame
    runs: pd.DataFrame
    refused: dict[str, Refusal]
    partly: list[Refusal]
    rig: RigKind


def _measured(samples_of: Mapping[str, Columns], runs: pd.DataFrame, rig: RigKind) -> _Measured:
    """Plateaus of each run, and what the gates of runs find."""
    refused: dict[str, Refusal] = {}
    partly: list[Refusal] = []
    plateaus, warnings = {}, []
    for row in tables.rows(runs):
        run_id, doubt = row["run_id"], ""
        if run_id in samples_of:
            signals = rig.signals(samples_of[run_id], row["rig"], rig.settings)
            run = measure(signals, rig, row["rig"], settled=row["log_kind"] == "steps")
            plateaus[run_id] = run.plateaus
        if row["rule"]:
            refused[run_id] = Refusal(row["rule"], row["reason"], "", run_id)
        elif run_id not in samples_of:
            refused[run_id] = fault("no_rows", run_id=run_id)
        elif why := first_fault(run):
            refused[run_id] = replace(why, run_id=run_id)
        else:
            doubt = warning(run)
            partly += [replace(each, run_id=run_id) for each in run.too_short]
        warnings.append(doubt)
    runs = runs.assign(warning=pd.Series(warnings, runs.index, dtype="str"))
    points = _table_of_plateaus(plateaus, runs.set_index("run_id"), rig)
    return _Measured(points, runs, refused, partly, rig)


def _explanation(samples: Columns, run: Mapping[str, Any], rig: RigKind) -> Refusal | None:
    """The simple mistake without which most plateaus of a refused run would pass, if there is one.

    Args:
        samples: Those of the run.
        run: Its row of the table of runs.
        rig: The rig.
    """
    if run["log_kind"] == "steps":
        return None  # readings that the rig's program has settled and converted
    causes = [each for each in rig.hypotheses(run["rig"]) if run["rule"] in each.explains]
    # of settings one at a time, and before it takes time
    tried = [[each for each in causes if not each.changes]]
    tried += [[each] for each in causes if each.changes and each.plausible(samples, 0)]
    passing: list[tuple[int, Hypothesis]] = []
    for several in filter(None, tried):
        # each as a run of its own
        by_name = {each.sentence: each for each in several}
        as_runs = pd.DataFrame([{**run, "run_id": name, "rule": ""} for name in by_name])
        changes = several[0].changes
        changed = type(rig)(rig.settings.with_changes(changes)) if changes else rig
        undone = {name: each.undo(samples) for name, each in by_name.items()}
        judged = _judge(_measured(undone, as_runs, changed)).runs
        for each in tables.rows(judged[judged["accepted_points"] > judged["plateaus"] / 2]):
            if by_name[each["run_id"]].plausible(samples, each["plateaus"]):
                passing.append((each["accepted_points"], by_name[each["run_id"]]))
    if not passing:
        return None
    _, best = max(passing, key=lambda each: each[0])
    # where several units would do, the data do not tell which one it is
    names = "; or ".join(each.sentence for _, each in passing if each.rule == best.rule)
    sentence = f"the run would pass with {names}; as it is, {run['reason']}"
    return Refusal(best.rule, sentence, "", run["run_id"])


def collect(curated: Curated, settings: Settings, kind: type[RigKind] = TractionRig) -> Curated:
    """All shares of a campaign, judged by the rules that compare runs with each other.

    Args:
        curated: What `curate_parts` made of all shares.
        settings: Settings of the run.
        kind: The kind of rig.
    """
    points, runs, quarantine = curated.points, curated.runs, curated.quarantine
    if again := repeated(points, runs, kind, settings):
        points = _refuse_plateaus(points, again, kind)
        runs = _with_verdicts(runs, points, again)
        quarantine = pd.concat([quarantine, quarantine_rows(again, runs, kind)])
    runs = with_campaign_warnings(runs, points, kind, settings)
    order = ["file", "run_id", "first_row", "rule"]
    return Curated(
        points.sort_values(["run_id", "first_row"], ignore_index=True),
        runs.sort_values("run_id", ignore_index=True),
        quarantine.sort_values(order, ignore_index=True),
    )


def arrays_of(samples: pd.DataFrame) -> Columns:
    """The columns of samples but for the run they belong to."""
    return {str(name): samples[name].to_numpy() for name in samples if name != "run_id"}


def _by_run(samples: pd.DataFrame) -> dict[str, Columns]:
    """The columns of each run, whose rows are next to each other."""
    arrays, rows_of = arrays_of(samples), samples.groupby("run_id").indices
    return {
        str(run_id): {name: array[rows[0] : rows[-1] + 1] for name, array in arrays.items()}
        for run_id, rows in rows_of.items()
    }


def _table_of_plateaus(
    plateaus_of: Mapping[str, Columns], runs: pd.DataFrame, rig: RigKind
) -> pd.DataFrame:
    """All plateaus with what they carry of their run and what needs rig and oil."""
    if not plateaus_of:
        return tables.empty(rig.table)
    measured = list(plateaus_of.values())
    counts = [len(plateaus["time_s"]) for plateaus in measured]
    about = runs.loc[list(plateaus_of), list(rig.carried)]
    carried = about.reset_index().take(np.repeat(np.arange(len(counts)), counts))
    points = carried.reset_index(drop=True).assign(
        **{name: np.concatenate([run[name] for run in measured]) for name in measured[0]}
    )
    points = rig.complete(points)
    # no table may hold such numbers, as mu has under no load at all
    numbers = points.select_dtypes("float")
    return points.assign(**numbers.mask(numbers.abs() >= tables.LARGEST))


def _judge(measured: _Measured) -> Curated:
    """Plateaus and runs with their verdicts, and the runs that were refused."""
    points, runs, rig = measured.points, measured.runs, measured.rig
    refused = measured.refused
    failed = judge_plateaus(points, rig)
    unrefused = ~points["run_id"].isin(list(refused))
    by_plateaus = list(runs_not_usable(points[unrefused], failed[unrefused], rig))
    points = points.assign(failed_gates=failed_gates.as_text(failed), accepted=~failed.any(axis=1))
    points = _refuse_plateaus(points, list(refused.values()), type(rig))
    some_pass = set(points.loc[points["accepted"], "run_id"])
    # the plateaus stay, whatever the rig, with the gate of their run beside their own
    points = failed_gates.with_gate_of_run(
        points, {each.run_id: each.rule for each in by_plateaus if each.run_id in some_pass}
    )
    # in the order of the runs
    of_runs = {each.run_id: each for each in (*refused.values(), *by_plateaus)}
    ordered = [of_runs[run_id] for run_id in runs["run_id"] if run_id in of_runs]
    runs = _with_verdicts(runs, points, ordered)
    quarantine = quarantine_rows([*ordered, *measured.partly], runs, type(rig))
    return Curated(points[tables.columns(rig.table)], runs, quarantine)


def _refuse_plateaus(
    points: pd.DataFrame, refused: list[Refusal], kind: type[RigKind]
) -> pd.DataFrame:
    """Plateaus of which those of refused runs are refused too, or left out, as the rig has it."""
    gate_of_run = {each.run_id: each.rule for each in refused}
    if kind.keeps_refused_runs:
        return failed_gates.with_gate_of_run(points, gate_of_run)
    return points[~points["run_id"].isin(list(gate_of_run))]


def _with_verdicts(
    runs: pd.DataFrame, points: pd.DataFrame, refused: list[Refusal]
) -> pd.DataFrame:
    """Runs with rule and sentence of their refusal, counts of their plateaus, and verdict."""
    of_run = {each.run_id: (each.rule, each.reason) for each in refused}
    as_they_are = zip(runs["run_id"], runs["rule"], runs["reason"], strict=True)
    texts = [of_run.get(run_id, (rule, reason)) for run_id, rule, reason in as_they_are]
    per_run = points.groupby("run_id")["accepted"].agg(["size", "sum"])
    plateaus, accepted = per_run.reindex(runs["run_id"], fill_value=0).to_numpy(np.int64).T
    return runs.assign(
        **pd.DataFrame(texts, runs.index, ["rule", "reason"], dtype="str"),
        plateaus=plateaus,
        accepted_points=accepted,
        warning=runs["warning"].where(accepted > 0, ""),
        verdict=np.where(accepted > 0, "accepted", "refused"),
    ).reset_index(drop=True)
