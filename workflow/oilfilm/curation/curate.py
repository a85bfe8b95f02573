"""Samples to plateaus with verdicts: one engine for every kind of rig.

samples -> signals -> zero -> plateaus -> derived quantities -> gates -> verdicts. A `RigKind`
says what differs between the rigs.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.curation.gate import fault
from oilfilm.curation.hypotheses import DOUBTFUL, Hypothesis
from oilfilm.curation.measure import measure
from oilfilm.curation.plateau_gates import judge_plateaus, quarantine_rows, runs_not_usable
from oilfilm.curation.repeats import repeated, with_campaign_warnings
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.run_gates import first_fault, warning
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.logs.base import Columns, Refusal
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
