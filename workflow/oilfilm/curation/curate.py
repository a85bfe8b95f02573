"""Samples to points: the story of one share of a campaign's runs, and of all shares together."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.curation.film_state import with_film
from oilfilm.curation.gates import POINT_GATES, advice_for, judge_points, judge_run
from oilfilm.curation.points import Measured, measure_continuous, measure_readings
from oilfilm.curation.signals import Signals

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
    flaws: dict[str, str] = {}
    frames: list[pd.DataFrame] = []
    by_run = {run: rows for run, rows in samples.groupby("run_id", observed=True, sort=False)}
    for run in runs.to_dict("records"):
        run_id = run["run_id"]
        signals = Signals.of(by_run[run_id]) if run_id in by_run else None
        if signals is None:
            flaws[run_id] = run["reason"] or "no_plateau: the run has no readable row"
            continue
        measured = _measure(signals, run["kind"], config["curation"])
        flaws[run_id] = (
            run["reason"]
            or judge_run(signals, measured.points, limits)
            or measured.flaw
            or ("" if len(measured.points) else "no_plateau: no steady part was found")
        )
        frames.append(measured.points.assign(run_id=run_id))
    points = _derive(frames, runs, config)
    points, verdicts = _judge(points, runs, flaws, limits)
    return Curated(points, verdicts, _quarantine(verdicts))


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
    quarantine = pd.concat(refused, ignore_index=True)
    if config["campaign"].get("repeated_conditions", "refuse") == "refuse":
        repeated = _repeated_conditions(runs)
        points, runs = _refuse_runs(points, runs, repeated)
        late = _quarantine(runs[runs["run_id"].isin(repeated)])
        quarantine = pd.concat([quarantine, late], ignore_index=True)
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
        "accept_unjudged_film": unjudged["accept"],
    }


def _measure(signals: Signals, kind: str, settings: Mapping[str, Any]) -> Measured:
    return measure_readings(signals) if kind == "steps" else measure_continuous(signals, settings)


def _derive(
    frames: list[pd.DataFrame], runs: pd.DataFrame, config: Mapping[str, Any]
) -> pd.DataFrame:
    """All points with their run's oil and set points, contact pressure and film."""
    if not frames:
        return tables.empty("points").assign(**dict.fromkeys(_NOMINAL, np.nan))
    points = pd.concat(frames, ignore_index=True)
    about = runs[["run_id", "oil", "rig", *_NOMINAL]]
    points = points.merge(about, on="run_id", how="left", validate="many_to_one")
    return with_film(points, config)


def _judge(
    points: pd.DataFrame, runs: pd.DataFrame, flaws: Mapping[str, str], limits: Mapping[str, Any]
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Points with accepted and reasons, runs with verdict and reason."""
    failed = judge_points(points, limits)
    reasons = dict(flaws)
    for key, of_run in points.groupby("run_id"):
        run_id = str(key)
        if not reasons[run_id]:
            reasons[run_id] = _why_all_fail(of_run, failed.loc[of_run.index], limits)
    names = np.array(failed.columns)
    of_gates = [";".join(names[row]) for row in failed.to_numpy()]
    points = _with_reasons(points, flaws, of_gates)
    judged = runs.assign(reason=[reasons[run] for run in runs["run_id"]])
    return points[tables.columns("points")], _count(points, judged)


def _with_reasons(
    points: pd.DataFrame, of_runs: Mapping[str, str], of_gates: Iterable[str]
) -> pd.DataFrame:
    """Points with the gate of their run, if one refused it, before their own gates."""
    reasons = [
        ";".join(filter(None, [of_runs.get(run, "").partition(":")[0], own]))
        for run, own in zip(points["run_id"], of_gates, strict=True)
    ]
    whole = pd.Series(reasons, points.index, dtype=str)
    return points.assign(reasons=whole, accepted=whole == "")


def _why_all_fail(points: pd.DataFrame, failed: pd.DataFrame, limits: Mapping[str, Any]) -> str:
    """Why no point of a run is left, as `name: sentence`; empty where one is."""
    if not failed.any(axis=1).all():
        return ""
    for gate in POINT_GATES:
        if failed[gate.name].all():
            return f"{gate.name}: {gate.describe(points, limits)}"
    counts = ", ".join(f"{name} {count}" for name, count in failed.sum().items() if count)
    return f"no_point_left: every one of {len(points)} points fails some gate ({counts})"


def _count(points: pd.DataFrame, runs: pd.DataFrame) -> pd.DataFrame:
    per_run = points.groupby("run_id")["accepted"].agg(["size", "sum"])
    accepted = runs["run_id"].map(per_run["sum"]).fillna(0).astype(np.int64)
    return runs.assign(
        plateaus=runs["run_id"].map(per_run["size"]).fillna(0).astype(np.int64),
        accepted_points=accepted,
        verdict=np.where(accepted > 0, "accepted", "refused"),
    )


def _quarantine(runs: pd.DataFrame) -> pd.DataFrame:
    """One row a run refused as a whole."""
    refused = runs[runs["reason"] != ""]
    rule = refused["reason"].map(lambda text: text.partition(": ")[0]).astype(str)
    reason = refused["reason"].map(lambda text: text.partition(": ")[2]).astype(str)
    frame = refused[["campaign", "file", "run_id"]].assign(
        stage="curate",
        rule=rule,
        first_row=0,
        last_row=0,
        refused_rows=0,
        reason=reason,
        advice=rule.map(advice_for),
    )
    return tables.conform(frame, "quarantine", "refused runs")


def _repeated_conditions(runs: pd.DataFrame) -> dict[str, str]:
    """Later accepted runs of an oil and condition that an earlier run has already, with why."""
    condition = ["oil", "rig", *_NOMINAL]
    candidates = runs[runs["verdict"] == "accepted"].dropna(subset=condition)
    candidates = candidates.sort_values("file")
    first = candidates.groupby(condition)["run_id"].transform("first")
    return {
        run_id: f"duplicate_condition: same oil and set points as {earlier}, which is kept"
        for run_id, earlier in zip(candidates["run_id"], first, strict=True)
        if run_id != earlier
    }


def _refuse_runs(
    points: pd.DataFrame, runs: pd.DataFrame, reasons: Mapping[str, str]
) -> tuple[pd.DataFrame, pd.DataFrame]:
    points = _with_reasons(points, reasons, points["reasons"])
    runs = runs.assign(
        reason=[
            reasons.get(run, reason)
            for run, reason in zip(runs["run_id"], runs["reason"], strict=True)
        ]
    )
    return points, _count(points, runs)
