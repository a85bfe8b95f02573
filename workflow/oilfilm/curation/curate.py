"""Samples to plateaus with verdicts: one engine for every kind of rig.

samples -> signals -> zero -> plateaus -> derived quantities -> gates -> verdicts. A `RigKind`
says what differs between the rigs.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.curation.doubts import warning
from oilfilm.curation.gate import Columns, Finding, Limits, Run
from oilfilm.curation.hypotheses import DOUBTFUL, Hypothesis
from oilfilm.curation.measure import Measured, measure
from oilfilm.curation.refusals import quarantine_rows, refusal, run_gates
from oilfilm.curation.repeats import repeated
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.signals import Signals
from oilfilm.curation.traction_rig import TRACTION_RIG
from oilfilm.curation.verdicts import not_usable, why_not_used, with_gates
from oilfilm.errors import OilfilmError
from oilfilm.logs.base import Refusal
from oilfilm.logs.ingest import Ingested, ingest_logs, sample_files
from oilfilm.logs.raw_files import RawLogs
from oilfilm.logs.run_sheet import NO_SHEET, RunSheet
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates


@dataclass(frozen=True)
class Curated:
    """Plateaus of a campaign or a share of it, its runs with their verdicts, what was refused."""

    points: pd.DataFrame
    runs: pd.DataFrame
    quarantine: pd.DataFrame


def check_logs(
    logs: Iterable[tuple[str, bytes]],
    settings: Settings,
    kind: RigKind = TRACTION_RIG,
    sheet: RunSheet = NO_SHEET,
) -> Curated:
    """What ingest and curation make of logs, given by name and content, and their run sheet."""
    return curate_ingested(ingest_logs(logs, settings, kind.logs, sheet), settings, kind)


def curate_ingested(
    ingested: Ingested, settings: Settings, kind: RigKind = TRACTION_RIG
) -> Curated:
    """What curation makes of logs that are one share."""
    samples = ingested.all_samples()
    share = curate(samples, ingested.runs, settings, kind)
    curated = collect([share], [ingested.quarantine], settings, kind)
    # what the workflow could not write must not pass here
    if kind.name == TRACTION_RIG.name:
        tables.conform(samples, "samples", "samples of these logs")
    tables.conform(curated.points, kind.table, "plateaus of these logs")
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
    parts = partial(tables.read_parts, "samples", *samples.values())
    curated = curate_parts(parts, ingested.runs, settings)
    refused = pd.concat([ingested.quarantine, curated.quarantine], ignore_index=True)
    return replace(curated, quarantine=refused)


def curate(
    samples: pd.DataFrame,
    runs: pd.DataFrame,
    settings: Settings,
    kind: RigKind = TRACTION_RIG,
) -> Curated:
    """Plateaus of every run, judged by every gate of the rig.

    Args:
        samples: Table of samples, the rows of a run together.
        runs: Table of runs as ingested.
        settings: Settings of the run.
        kind: The kind of rig.
    """
    return curate_parts(lambda: [samples], runs, settings, kind)


def curate_parts(
    samples: Callable[[], Iterable[pd.DataFrame]],
    runs: pd.DataFrame,
    settings: Settings,
    kind: RigKind = TRACTION_RIG,
) -> Curated:
    """The same of samples that come in parts, each with whole runs, of which one is held at a time.

    Args:
        samples: Gives the parts, from the first one, at each call: refused runs are read twice.
        runs: Table of runs as ingested.
        settings: Settings of the run.
        kind: The kind of rig.

    Raises:
        OilfilmError: Two parts have rows of one run.
    """
    limits = kind.limits(settings)
    labels = {run["run_id"]: run for run in tables.rows(runs)}
    looks = {
        run_id: _look(of_run, labels[run_id], settings, kind, limits)
        for run_id, of_run in _by_run(samples())
        if run_id in labels
    }
    refused: dict[str, Refusal] = {}
    partly: list[Refusal] = []
    for run_id, run in labels.items():
        look = looks.get(run_id)
        if run["rule"]:
            refused[run_id] = refusal(run["rule"], Finding(run["reason"]), kind, run_id)
        elif look is None:
            finding = Finding("the log has no readable row of data")
            refused[run_id] = refusal("no_rows", finding, kind, run_id)
        elif look.fault is not None:
            refused[run_id] = refusal(*look.fault, kind, run_id)
        else:
            partly += [refusal("too_short", each, kind, run_id) for each in look.too_short]
    warnings = {run_id: look.warning for run_id, look in looks.items()}
    runs = runs.assign(warning=[warnings.get(run_id, "") for run_id in labels])
    by_run = runs.set_index("run_id")
    plateaus_of = {run_id: looks[run_id].plateaus for run_id in labels if run_id in looks}
    points = _table_of_plateaus(plateaus_of, by_run, settings, kind)
    judged = _judge(points, runs, refused, partly, kind, limits)
    doubtful = judged.runs[judged.runs["rule"].isin(DOUBTFUL)]
    doubted = {run["run_id"]: run for run in tables.rows(doubtful)}
    explained = {
        run_id: cause
        for run_id, of_run in _by_run(samples() if doubted else ())
        if run_id in doubted
        and (cause := _explanation(of_run, doubted[run_id], by_run, settings, kind)) is not None
    }
    if not explained:
        return judged
    return _judge(points, runs, {**refused, **explained}, partly, kind, limits)


@dataclass(frozen=True)
class _Look:
    """What the samples of one run give: its plateaus, and the fault or the warning about it."""

    plateaus: Columns
    fault: tuple[str, Finding] | None = None
    warning: str = ""
    too_short: Sequence[Finding] = ()


def _look(
    samples: Columns, run: Mapping[str, Any], settings: Settings, kind: RigKind, limits: Limits
) -> _Look:
    signals = kind.signals(samples, run["rig"], settings)
    measured = measure(signals, kind, run["rig"], settings, settled=run["log_kind"] == "steps")
    if run["rule"]:
        return _Look(measured.plateaus)
    fault = first_fault(signals, measured, kind, limits)
    if fault is not None:
        return _Look(measured.plateaus, fault)
    doubts = warning(_run(signals, measured, kind), limits)
    return _Look(measured.plateaus, None, doubts, measured.too_short)


def _explanation(
    samples: Columns,
    run: Mapping[str, Any],
    runs: pd.DataFrame,
    settings: Settings,
    kind: RigKind,
) -> Refusal | None:
    """The simple mistake without which most plateaus of a refused run would pass, if there is one.

    Args:
        samples: Those of the run.
        run: Its row of the table of runs.
        runs: All of them, by `run_id`.
        settings: Settings of the run.
        kind: The kind of rig.
    """
    run_id, rig, limits = run["run_id"], run["rig"], kind.limits(settings)
    passing: list[tuple[int, Hypothesis]] = []
    if run["log_kind"] == "steps":
        return None  # readings that the rig's program has settled and converted
    for hypothesis in kind.hypotheses(rig, settings):
        if run["rule"] not in hypothesis.explains:
            continue
        signals = kind.signals(hypothesis.undo(samples), rig, settings)
        measured = measure(signals, kind, rig, settings)
        levels = len(measured.plateaus["time_s"])
        if not hypothesis.plausible(samples, levels) or first_fault(
            signals, measured, kind, limits
        ):
            continue
        points = _table_of_plateaus({run_id: measured.plateaus}, runs, settings, kind)
        points, failed = with_gates(points, kind, limits)
        accepted = int(points["accepted"].sum())
        if accepted > levels / 2 and not not_usable(points, failed, kind, limits):
            passing.append((accepted, hypothesis))
    if not passing:
        return None
    _, best = max(passing, key=lambda each: each[0])
    # where several units would do, the data do not tell which one it is
    sentence = "; or ".join(each.sentence for _, each in passing if each.rule == best.rule)
    return refusal(best.rule, Finding(f"{sentence}; as it is, {run['reason']}"), kind, run_id)


def collect(
    shares: list[Curated],
    unread: list[pd.DataFrame],
    settings: Settings,
    kind: RigKind = TRACTION_RIG,
) -> Curated:
    """All shares of a campaign as one, judged by the rules that compare runs with each other.

    Args:
        shares: What `curate` made of each share.
        unread: What ingest put into quarantine.
        settings: Settings of the run.
        kind: The kind of rig.
    """
    points = pd.concat([share.points for share in shares], ignore_index=True)
    runs = pd.concat([share.runs for share in shares], ignore_index=True)
    quarantine = [*unread, *(share.quarantine for share in shares)]
    for rule in kind.repeats(settings):
        again = repeated(points, runs, rule, kind, settings)
        if again:
            points = _refuse_plateaus(points, again, kind)
            runs = _count(points, _with_rules(runs, again))
            quarantine.append(quarantine_rows(again, runs))
    return Curated(
        points.sort_values(["run_id", "first_row"], ignore_index=True),
        runs.sort_values("run_id", ignore_index=True),
        pd.concat(quarantine, ignore_index=True).sort_values(
            ["file", "run_id", "first_row", "rule"], ignore_index=True
        ),
    )


def arrays_of(samples: pd.DataFrame) -> Columns:
    """The columns of samples but for the run they belong to."""
    return {str(name): samples[name].to_numpy() for name in samples if name != "run_id"}


def _by_run(parts: Iterable[pd.DataFrame]) -> Iterator[tuple[str, Columns]]:
    """Each run of some parts of the samples with its columns."""
    seen: set[str] = set()
    for samples in parts:
        arrays = arrays_of(samples)
        for run_id, rows in _rows_by_run(samples).items():
            if run_id in seen:
                raise OilfilmError(
                    f"the rows of run {run_id} are in two parts of the samples; expected them "
                    "together. Delete the samples and run snakemake again."
                )
            seen.add(run_id)
            yield run_id, {name: array[rows] for name, array in arrays.items()}


def _rows_by_run(samples: pd.DataFrame) -> dict[str, slice]:
    """The rows of each run, which are next to each other."""
    run_ids = samples["run_id"].astype("category").cat
    codes, names = run_ids.codes.to_numpy(), run_ids.categories
    edges = np.concatenate([[0], np.flatnonzero(np.diff(codes)) + 1, [len(codes)]])
    return {
        str(names[codes[start]]): slice(int(start), int(stop))
        for start, stop in pairwise(edges)
        if stop > start
    }


def _run(signals: Signals, measured: Measured, kind: RigKind) -> Run:
    return Run(signals, measured.working, measured.plateaus, kind.sensor, kind.load, kind.channels)


def first_fault(
    signals: Signals, measured: Measured, kind: RigKind, limits: Limits
) -> tuple[str, Finding] | None:
    """Rule and finding of the first gate that refuses a run, if one does."""
    run = _run(signals, measured, kind)
    for gate in run_gates(kind):
        finding = gate.judge(run, limits)
        if finding is not None:
            return gate.name, finding
    if measured.flaw is not None:
        return measured.flaw
    if len(measured.plateaus["time_s"]) == 0:
        return "no_plateau", Finding("no steady part was found")
    return None


def _table_of_plateaus(
    plateaus_of: Mapping[str, Columns],
    runs: pd.DataFrame,
    settings: Settings,
    kind: RigKind,
) -> pd.DataFrame:
    """All plateaus with what they carry of their run and what needs rig and oil."""
    if not plateaus_of:
        nothing = tables.empty(kind.table)
        return nothing.assign(**{name: np.nan for name in kind.carried if name not in nothing})
    measured = list(plateaus_of.values())
    counts = [len(plateaus["time_s"]) for plateaus in measured]
    about = runs.loc[list(plateaus_of), list(kind.carried)]
    carried = about.reset_index().take(np.repeat(np.arange(len(counts)), counts))
    points = carried.reset_index(drop=True).assign(
        **{name: np.concatenate([run[name] for run in measured]) for name in measured[0]}
    )
    return _without_absurd(kind.complete(points, settings))


def _without_absurd(points: pd.DataFrame) -> pd.DataFrame:
    """Plateaus with null for numbers that no table may hold, as mu has under no load at all."""
    numbers = points.select_dtypes("float")
    absurd = numbers.abs() >= tables.LARGEST
    return points.assign(**numbers.mask(absurd)) if absurd.any(axis=None) else points


def _judge(
    points: pd.DataFrame,
    runs: pd.DataFrame,
    refused: Mapping[str, Refusal],
    partly: list[Refusal],
    kind: RigKind,
    limits: Limits,
) -> Curated:
    """Plateaus and runs with their verdicts, and the runs that were refused."""
    points, failed = with_gates(points, kind, limits)
    points = _refuse_plateaus(points, list(refused.values()), kind)
    by_plateaus = [
        why_not_used(points[points["run_id"] == run_id], failed, kind, limits)
        for run_id in not_usable(points, failed, kind, limits)
        if run_id not in refused
    ]
    some_pass = set(points.loc[points["accepted"], "run_id"])
    # the plateaus stay, whatever the rig, with the gate of their run beside their own
    points = failed_gates.with_gate_of_run(
        points,
        {each.run_id: each.rule for each in by_plateaus if each.run_id in some_pass},
    )
    # in the order of the runs
    of_runs = {each.run_id: each for each in (*refused.values(), *by_plateaus)}
    ordered = [of_runs[run_id] for run_id in runs["run_id"] if run_id in of_runs]
    runs = _count(points, _with_rules(runs, ordered))
    columns = tables.columns(kind.table)
    return Curated(points[columns], runs, quarantine_rows([*ordered, *partly], runs))


def _refuse_plateaus(points: pd.DataFrame, refused: list[Refusal], kind: RigKind) -> pd.DataFrame:
    """Plateaus of which those of refused runs are refused too, or left out, as the rig has it."""
    gate_of_run = {each.run_id: each.rule for each in refused}
    if kind.keeps_refused_runs:
        return failed_gates.with_gate_of_run(points, gate_of_run)
    return points[~points["run_id"].isin(list(gate_of_run))]


def _with_rules(runs: pd.DataFrame, refused: list[Refusal]) -> pd.DataFrame:
    """Runs with the rule and the sentence of their refusal."""
    of_run = {each.run_id: (each.rule, each.reason) for each in refused}
    as_they_are = zip(runs["run_id"], runs["rule"], runs["reason"], strict=True)
    texts = [of_run.get(run_id, (rule, reason)) for run_id, rule, reason in as_they_are]
    columns = pd.DataFrame(texts, runs.index, ["rule", "reason"], dtype="str")
    return runs.assign(**columns).reset_index(drop=True)


def _count(points: pd.DataFrame, runs: pd.DataFrame) -> pd.DataFrame:
    per_run = points.groupby("run_id")["accepted"].agg(["size", "sum"])
    accepted = runs["run_id"].map(per_run["sum"]).fillna(0).astype(np.int64)
    return runs.assign(
        plateaus=runs["run_id"].map(per_run["size"]).fillna(0).astype(np.int64),
        accepted_points=accepted,
        warning=runs["warning"].where(accepted > 0, ""),
        verdict=np.where(accepted > 0, "accepted", "refused"),
    )
