"""Samples to points: the story of one share of a campaign's runs, and of all shares together."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.curation.calibration import with_calibration
from oilfilm.curation.film_state import with_film
from oilfilm.curation.gates import (
    POINT_GATES,
    Columns,
    Trouble,
    advice_for,
    judge_points,
    judge_run,
)
from oilfilm.curation.points import Measured, measure_continuous, measure_readings
from oilfilm.curation.signals import SIGNALS, Signals
from oilfilm.settings.semantics import Semantics, semantics_of
from oilfilm.tables import failed_gates

_NOMINAL = (
    "nominal_load_n",
    "nominal_entrainment_speed_m_s",
    "nominal_inlet_temperature_c",
)


@dataclass(frozen=True)
class Curated:
    """Points of a campaign or a share of it, its runs with their verdicts, what was refused."""

    points: pd.DataFrame
    runs: pd.DataFrame
    quarantine: pd.DataFrame


def curate(samples: pd.DataFrame, runs: pd.DataFrame, config: Mapping[str, Any]) -> Curated:
    """Plateaus of every run, judged by every gate.

    Args:
        samples: Table of samples, the rows of a run together.
        runs: Table of runs as ingested.
        config: The resolved configuration.
    """
    limits = gate_limits(config)
    troubles: dict[str, Trouble | None] = {}
    measured_of: dict[str, Columns] = {}
    rows_of = _rows_by_run(samples)
    arrays = {name: samples[name].to_numpy() for name in SIGNALS}
    for run in runs.to_dict("records"):
        run_id = run["run_id"]
        known = Trouble(run["rule"], run["reason"]) if run["rule"] else None
        if run_id not in rows_of:
            troubles[run_id] = known or Trouble("no_rows", "the log has no readable row of data")
            continue
        log = semantics_of(config["campaign"], run["rig"])
        rows = rows_of[run_id]
        signals = Signals.of({name: array[rows] for name, array in arrays.items()}, log)
        measured = _measure(signals, run["log_kind"], config["curation"], log)
        troubles[run_id] = known or judge_run(signals, measured.points, limits) or measured.flaw
        if troubles[run_id] is None and len(measured.points["time_s"]) == 0:
            troubles[run_id] = Trouble("no_plateau", "no steady part was found")
        measured_of[run_id] = measured.points
    points = _derive(measured_of, runs, config)
    return _judge(points, runs, troubles, limits)


def collect(
    shares: list[Curated], unread: list[pd.DataFrame], config: Mapping[str, Any]
) -> Curated:
    """All shares of a campaign as one, judged by the gates that compare runs with each other.

    Args:
        shares: What `curate` made of each share.
        unread: What ingest put into quarantine.
        config: The resolved configuration.
    """
    points = pd.concat([share.points for share in shares], ignore_index=True)
    runs = pd.concat([share.runs for share in shares], ignore_index=True)
    refused = [*unread, *(share.quarantine for share in shares)]
    for find_repeated in _repeats(config["campaign"]):
        repeated = find_repeated(runs)
        if repeated:
            points, runs = _refuse_runs(points, runs, repeated)
            refused.append(_quarantine(runs, repeated))
    quarantine = pd.concat(refused, ignore_index=True)
    return Curated(
        points.sort_values(["run_id", "first_row"], ignore_index=True),
        runs.sort_values("run_id", ignore_index=True),
        quarantine.sort_values(["file", "run_id", "first_row", "rule"], ignore_index=True),
    )


def gate_limits(config: Mapping[str, Any]) -> dict[str, Any]:
    """The limits of every gate, in one flat mapping."""
    unjudged = config["campaign"].get("film_unjudged", {"accept": False})
    return {
        **config["gates"],
        "stuck_duration_s": config["curation"]["stuck"]["duration_s"],
        "stuck_samples": config["curation"]["stuck"]["samples"],
        "min_duration_s": config["curation"]["plateaus"]["min_duration_s"],
        "transient_share": config["curation"]["plateaus"]["transient_share"],
        "accept_unjudged_film": unjudged["accept"],
        "planned_slips": config["campaign"].get("set_points", {}).get("slide_roll_ratio", []),
    }


def _rows_by_run(samples: pd.DataFrame) -> dict[str, slice]:
    """Where the rows of each run stand, which lie together."""
    run_ids = samples["run_id"].astype("category").cat
    codes, names = run_ids.codes.to_numpy(), run_ids.categories
    edges = np.concatenate([[0], np.flatnonzero(np.diff(codes)) + 1, [len(codes)]])
    return {
        str(names[codes[start]]): slice(int(start), int(stop))
        for start, stop in pairwise(edges)
        if stop > start
    }


def _measure(signals: Signals, kind: str, settings: Mapping[str, Any], log: Semantics) -> Measured:
    if kind == "steps":
        return measure_readings(signals)
    return measure_continuous(signals, settings, log.zero)


def _derive(
    measured_of: Mapping[str, Columns], runs: pd.DataFrame, config: Mapping[str, Any]
) -> pd.DataFrame:
    """All points with their run's oil and set points, contact pressure and film."""
    if not measured_of:
        return tables.empty("points").assign(**dict.fromkeys(_NOMINAL, np.nan))
    all_measured = list(measured_of.values())
    counts = [len(measured["time_s"]) for measured in all_measured]
    about = runs.set_index("run_id").loc[list(measured_of), ["oil", "rig", *_NOMINAL]]
    of_points = about.reset_index().take(np.repeat(np.arange(len(counts)), counts))
    points = of_points.reset_index(drop=True).assign(
        **{name: np.concatenate([run[name] for run in all_measured]) for name in all_measured[0]}
    )
    return _without_absurd(with_calibration(with_film(points, config), config["rigs"]))


def _without_absurd(points: pd.DataFrame) -> pd.DataFrame:
    """Points with null for numbers that no table may hold, as mu has under no load at all."""
    numbers = points.select_dtypes("float")
    absurd = numbers.abs() >= tables.LARGEST
    return points.assign(**numbers.mask(absurd)) if absurd.any(axis=None) else points


def _judge(
    points: pd.DataFrame,
    runs: pd.DataFrame,
    troubles: Mapping[str, Trouble | None],
    limits: Mapping[str, Any],
) -> Curated:
    """Points and runs with their verdicts, and the runs refused."""
    failed = judge_points(points, limits)
    found = dict(troubles)
    none_left = failed.any(axis=1).groupby(points["run_id"]).all()
    for run_id in none_left.index[none_left]:
        of_run = points[points["run_id"] == run_id]
        found[run_id] = found[run_id] or _why_all_fail(of_run, failed.loc[of_run.index], limits)
    refused = {run_id: trouble for run_id, trouble in found.items() if trouble is not None}
    of_runs = {run_id: trouble for run_id, trouble in troubles.items() if trouble is not None}
    points = failed_gates.with_gate_of_run(
        points.assign(failed_gates=failed_gates.as_text(failed)),
        {run_id: trouble.gate for run_id, trouble in of_runs.items()},
    )
    runs = _count(points, _with_run_reasons(runs, refused))
    return Curated(points[tables.columns("points")], runs, _quarantine(runs, refused))


def _with_run_reasons(runs: pd.DataFrame, refused: Mapping[str, Trouble]) -> pd.DataFrame:
    runs = runs.astype({"rule": object, "reason": object})
    rows = runs["run_id"].isin(list(refused))
    runs.loc[rows, "rule"] = [refused[run].gate for run in runs.loc[rows, "run_id"]]
    runs.loc[rows, "reason"] = [refused[run].reason for run in runs.loc[rows, "run_id"]]
    return runs.astype({"rule": str, "reason": str})


def _why_all_fail(points: pd.DataFrame, failed: pd.DataFrame, limits: Mapping[str, Any]) -> Trouble:
    """Why no point of a run is left."""
    for gate in POINT_GATES:
        if failed[gate.name].all():
            return Trouble(gate.name, gate.describe(points, limits))
    counts = ", ".join(f"{name} {count}" for name, count in failed.sum().items() if count)
    return Trouble("no_point_left", f"every one of {len(points)} points fails some gate ({counts})")


def _count(points: pd.DataFrame, runs: pd.DataFrame) -> pd.DataFrame:
    per_run = points.groupby("run_id")["accepted"].agg(["size", "sum"])
    accepted = runs["run_id"].map(per_run["sum"]).fillna(0).astype(np.int64)
    return runs.assign(
        plateaus=runs["run_id"].map(per_run["size"]).fillna(0).astype(np.int64),
        accepted_points=accepted,
        verdict=np.where(accepted > 0, "accepted", "refused"),
    )


def _quarantine(runs: pd.DataFrame, troubles: Mapping[str, Trouble]) -> pd.DataFrame:
    """One row a run refused as a whole."""
    about = runs.set_index("run_id")
    rows = [
        {
            "campaign": about.at[run_id, "campaign"],
            "file": about.at[run_id, "file"],
            "run_id": run_id,
            "stage": "curate",
            "rule": trouble.gate,
            "first_row": trouble.first_row,
            "last_row": trouble.last_row,
            "refused_rows": 0,
            "reason": trouble.reason,
            "advice": advice_for(trouble.gate),
        }
        for run_id, trouble in troubles.items()
    ]
    return tables.from_rows(rows, "quarantine")


def _repeats(campaign: Mapping[str, Any]) -> list[Callable[[pd.DataFrame], dict[str, Trouble]]]:
    """The checks for runs that an earlier one has already, in the order in which they act."""
    copies = partial(_repeated, key=["content_sha256"], among_files=True, gate="duplicate_log")
    labels = partial(_repeated, key=["label"], gate="repeated_label")
    conditions = partial(_repeated, key=["oil", "rig", *_NOMINAL], gate="duplicate_condition")
    accepted = campaign.get("repeated_conditions", "refuse") == "accept"
    return [copies, labels] if accepted else [copies, labels, conditions]


_WORDS = {
    "duplicate_log": "the same bytes, one by one, as {earlier}, which is kept",
    "repeated_label": "its header has the run's name of {earlier}, which is kept",
    "duplicate_condition": "same oil and set points as {earlier}, which is kept",
}


def _repeated(
    runs: pd.DataFrame, key: list[str], gate: str, among_files: bool = False
) -> dict[str, Trouble]:
    """Later accepted runs that an earlier accepted one equals in `key`, nulls aside.

    With `among_files` the runs of one file are not compared with each other.
    """
    known = runs[key].notna().all(axis=1) & (runs[key] != "").all(axis=1)
    candidates = runs[known & (runs["verdict"] == "accepted")].sort_values(["file", "run_id"])
    first = candidates.groupby(key)[["run_id", "file"]].transform("first")
    later = candidates["file"] != first["file"]
    if not among_files:
        later |= candidates["run_id"] != first["run_id"]
    words = _WORDS[gate]
    return {
        run_id: Trouble(gate, words.format(earlier=earlier))
        for run_id, earlier in zip(candidates["run_id"][later], first["run_id"][later], strict=True)
    }


def _refuse_runs(
    points: pd.DataFrame, runs: pd.DataFrame, troubles: Mapping[str, Trouble]
) -> tuple[pd.DataFrame, pd.DataFrame]:
    gate_of_run = {run_id: trouble.gate for run_id, trouble in troubles.items()}
    points = failed_gates.with_gate_of_run(points, gate_of_run)
    return points, _count(points, _with_run_reasons(runs, troubles))
