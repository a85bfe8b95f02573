"""Torque logs to steady plateaus: tare removed, means with standard errors, the gates' verdicts.

A log is one run of one oil at one axial load: the bearing stands still, runs at one speed after
another, and stands still again. Standing still is the tare of the torque sensor.
"""

import hashlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from oilfilm import tables
from oilfilm.curation import statistics
from oilfilm.curation.plateaus import find_steps, settled_parts
from oilfilm.curation.signals import sampling_interval
from oilfilm.readers.base import LoggedRun, Refusal
from oilfilm.readers.ingest import content_digest, read_log
from oilfilm.readers.log_kind import IndexArray
from oilfilm.readers.torque_log import TORQUE
from oilfilm.tables import failed_gates
from oilfilm.units import FloatArray


@dataclass(frozen=True)
class TorqueGate:
    """A check of plateaus: which fail, and what to do about it."""

    name: str
    advice: str
    fails: Callable[[pd.DataFrame, Mapping[str, Any]], "pd.Series[bool]"]


GATES = (
    TorqueGate(
        "too_short",
        "Hold each speed longer.",
        lambda points, limits: points["duration_s"] < limits["min_duration_s"],
    ),
    TorqueGate(
        "torque_drifts",
        "Wait until the bearing has warmed through.",
        lambda points, limits: (
            points["torque_change_n_m"].abs()
            > limits["torque_change_max"] * points["torque_n_m"].abs()
        ),
    ),
    TorqueGate(
        "temperature_drifts",
        "Wait until the oil's temperature is steady.",
        lambda points, limits: (
            points["oil_temperature_change_c"].abs() > limits["temperature_change_max_c"]
        ),
    ),
    TorqueGate(
        "torque_not_positive",
        "Check the sign and the tare of the torque sensor.",
        lambda points, limits: ~(points["torque_n_m"] > 0),
    ),
    TorqueGate(
        "turns_backwards",
        "Log the speed of the inner ring as positive: its torque is what resists it.",
        lambda points, limits: points["inner_speed_rpm"] < 0,
    ),
    TorqueGate(
        "unloaded",
        "Check the load cell: a ball bearing of this kind must be pushed together.",
        lambda points, limits: ~(points["axial_load_n"] > 0),
    ),
)


def measure_torque(
    logs: Iterable[tuple[str, bytes]], config: Mapping[str, Any]
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Steady plateaus of torque logs, and what had to be refused.

    Args:
        logs: Path of each log in its folder, and its bytes, in any format of `oilfilm.readers`.
        config: The resolved configuration.

    Returns:
        The tables `torque_runs` and `quarantine`.
    """
    points: list[pd.DataFrame] = []
    refused: list[dict[str, Any]] = []
    earlier: dict[str, str] = {}
    for file, content in logs:
        reader, reading = read_log(content, file, config, TORQUE)
        about = {"campaign": config["campaign"]["name"], "file": file}
        refused += [about | {"stage": "ingest"} | asdict(found) for found in reading.refusals]
        digest = hashlib.sha256(content).hexdigest()
        first = earlier.setdefault(content_digest(content, digest), file)
        for run in reading.runs:
            found, troubles = _measured(run, config) if first == file else _copied(run, first)
            refused += [about | {"stage": "curate"} | asdict(trouble) for trouble in troubles]
            if found is not None:
                points.append(found.assign(sha256=digest, reader=reader))
    whole = pd.concat(points, ignore_index=True) if points else tables.empty("torque_runs")
    return (
        tables.conform(whole[tables.columns("torque_runs")], "torque_runs", "torque logs"),
        tables.from_rows(refused, "quarantine"),
    )


# Plateaus of a run, if it has any, and what had to be refused of it.
_Found = tuple[pd.DataFrame | None, list[Refusal]]


def _measured(run: LoggedRun, config: Mapping[str, Any]) -> _Found:
    """The plateaus of a run with the gates' verdicts, or why it has none."""
    settings, curation = config["torque_logs"], config["curation"]
    trouble = _trouble(run)
    if trouble is not None:
        return None, [trouble]
    tare = _tare(run, settings, curation["spikes"]["threshold"])
    if isinstance(tare, str):
        advice = "Let the bearing stand still, loaded, before and after the run."
        return None, [_refused_run(run, "tare", tare, advice)]
    stuck = _stuck(run, tare.between, curation["stuck"])
    if stuck is not None:
        return None, [stuck]
    starts, stops, brief = _levels(run, tare, settings["plateaus"])
    if not len(starts):
        reason = "no steady speed was found between the two tares"
        return None, [_refused_run(run, "no_plateau", reason, "Hold each speed longer.")]
    measured = _plateaus(run, tare, starts, stops, curation["spikes"]["threshold"])
    about = measured.assign(run_id=run.run_id, oil=run.oil, bearing=run.rig)
    return _judged(about, settings), brief


def _refused_run(run: LoggedRun, rule: str, reason: str, advice: str) -> Refusal:
    rows = run.samples["row"]
    first, last = (int(rows[0]), int(rows[-1])) if len(rows) else (0, 0)
    return Refusal(rule, reason, advice, run.run_id, first, last, len(rows))


def _copied(run: LoggedRun, first: str) -> _Found:
    reason = f"the same bytes, one by one, as {first}, which is kept"
    return None, [_refused_run(run, "duplicate_log", reason, "Take one of the files out.")]


def _trouble(run: LoggedRun) -> Refusal | None:
    """Why nothing can be measured on a run, tare or not."""
    if run.flaw:
        rule, _, reason = run.flaw.partition(": ")
        return _refused_run(run, rule, reason, "Repeat the run: its closing tare is missing.")
    rows, time = run.samples["row"], run.samples["time_s"]
    if not len(rows):
        reason = "the log has no readable row of data"
        return _refused_run(run, "no_rows", reason, "Take it out, or export it again.")
    back = np.diff(time) <= 0
    if back.any():
        reason = f"time does not go on after row {rows[np.argmax(back)]}"
        advice = "Check the logger's clock, and whether two logs were joined."
        return _refused_run(run, "time_disorder", reason, advice)
    return None


def _stuck(run: LoggedRun, turning: slice, limits: Mapping[str, Any]) -> Refusal | None:
    """A torque sensor that says the same again and again while the bearing turns."""
    torque, rows = run.samples["torque_n_m"][turning], run.samples["row"][turning]
    start, stop = statistics.longest_hold(torque)
    held_s = (stop - start) * sampling_interval(run.samples["time_s"])
    if held_s < limits["duration_s"] or stop - start < limits["samples"]:
        return None
    reason = (
        f"the torque stays at exactly {torque[start]:g} N m from row {rows[start]} to row "
        f"{rows[stop - 1]}; expected noise within {limits['duration_s']:g} s"
    )
    advice = "Check the torque sensor, its cable and amplifier, and repeat the run."
    return _refused_run(run, "stuck_sensor", reason, advice)


@dataclass(frozen=True)
class _Tare:
    """The torque sensor's output at rest, before and after; samples between the two."""

    time_s: FloatArray
    torque_n_m: FloatArray
    torque_se_n_m: FloatArray
    between: slice


def _tare(run: LoggedRun, settings: Mapping[str, Any], spike: float) -> _Tare | str:
    time, torque = run.samples["time_s"], run.samples["torque_n_m"]
    resting = np.abs(run.samples["inner_speed_rpm"]) <= settings["tare"]["max_speed_rpm"]
    if resting.all():
        return "the bearing never turns"
    first = int(np.argmin(resting))
    last = len(resting) - int(np.argmin(resting[::-1]))
    phases = {"opening": (0, first), "closing": (last, len(resting))}
    interval = sampling_interval(time)
    for name, (start, stop) in phases.items():
        # of a single row no error can be told
        if stop - start < 2 or (stop - start) * interval < settings["tare"]["min_duration_s"]:
            return (
                f"{(stop - start) * interval:.2f} s of the {name} phase are at rest; expected "
                f"{settings['tare']['min_duration_s']:g} s or more, and two rows, below "
                f"{settings['tare']['max_speed_rpm']:g} rpm"
            )
    starts, stops = np.array(list(phases.values()), dtype=np.int64).T
    signals, inside = statistics.cut(np.stack([time, torque]), starts, stops)
    steady = inside & ~statistics.spikes(signals[1], inside, spike)
    mean = statistics.means(signals[1], steady)
    drift, allowed = float(mean[1] - mean[0]), settings["tare"]["max_drift_n_m"]
    if abs(drift) > allowed:
        return f"the tare moves by {drift:.3g} N m during the run; allowed {allowed:g} N m"
    return _Tare(
        statistics.means(signals[0], steady),
        mean,
        statistics.standard_errors(signals[1], steady),
        slice(first, last),
    )


def _levels(
    run: LoggedRun, tare: _Tare, settings: Mapping[str, Any]
) -> tuple[IndexArray, IndexArray, list[Refusal]]:
    """Starts and stops of settled levels of speed between the tares, and those too brief."""
    speed, rows = (run.samples[name][tare.between] for name in ("inner_speed_rpm", "row"))
    interval = sampling_interval(run.samples["time_s"])
    steps = find_steps(speed, interval, {**settings, "min_step": settings["min_step_rpm"]})
    starts, stops = settled_parts(len(speed), steps, interval, settings)
    # the first level has had a step to settle from: that out of rest; the last ends in one
    starts[0] += round(settings["settle_s"] / interval)
    stops[-1] -= round(settings["guard_s"] / interval)
    for place, (start, stop) in enumerate(zip(starts, stops, strict=True)):
        if stop > start:
            # a slow ramp goes on beyond what is cut off
            near = _near_middle(speed[start:stop], settings)
            starts[place] += np.argmax(near)
            stops[place] -= np.argmax(near[::-1])
    # of a single row no error can be told
    settled = stops - starts > 1
    needed = settings["settle_s"] + settings["guard_s"] + settings["min_duration_s"]
    edges = [0, *steps, len(speed)]
    brief = [
        Refusal(
            "too_short",
            f"the speed of about {np.median(speed[first:last]):.0f} rpm was held for "
            f"{(last - first) * interval:.1f} s; expected {needed:g} s or more",
            "Hold each speed longer.",
            run.run_id,
            int(rows[first]),
            int(rows[last - 1]),
        )
        for first, last, fine in zip(edges[:-1], edges[1:], settled, strict=True)
        # on a ramp hardly any row is near the middle one
        if not fine and last > first and _near_middle(speed[first:last], settings).mean() > 1 / 3
    ]
    return starts[settled], stops[settled], brief


def _near_middle(speed: FloatArray, settings: Mapping[str, Any]) -> npt.NDArray[np.bool_]:
    return np.asarray(np.abs(speed - np.median(speed)) <= settings["min_step_rpm"])


def _plateaus(
    run: LoggedRun, tare: _Tare, starts: IndexArray, stops: IndexArray, spike: float
) -> pd.DataFrame:
    values = {name: column[tare.between] for name, column in run.samples.items()}
    rows = values.pop("row")
    interval = sampling_interval(run.samples["time_s"])
    stretches, inside = statistics.cut(np.stack(list(values.values())), starts, stops)
    of_name = dict(zip(values, stretches, strict=True))
    wild = statistics.spikes(of_name["torque_n_m"], inside, spike)
    steady = inside & ~wild
    early = statistics.first_part(steady, 1 / 2)
    late = steady & ~early
    mean = dict(zip(values, statistics.means(stretches, steady), strict=True))
    error = dict(zip(values, statistics.standard_errors(stretches, steady), strict=True))

    def change(name: str) -> FloatArray:
        return statistics.means(of_name[name], late) - statistics.means(of_name[name], early)

    place = (mean["time_s"] - tare.time_s[0]) / np.diff(tare.time_s)
    weights = np.stack([1 - place, place], axis=1)
    return pd.DataFrame(
        {
            "first_row": rows[starts],
            "last_row": rows[stops - 1],
            "n_samples": steady.sum(axis=1),
            "n_spikes": wild.sum(axis=1),
            "time_s": mean["time_s"],
            "duration_s": (stops - starts) * interval,
            "inner_speed_rpm": mean["inner_speed_rpm"],
            "axial_load_n": mean["axial_load_n"],
            "oil_temperature_c": mean["oil_temperature_c"],
            "outer_ring_temperature_c": mean["outer_ring_temperature_c"],
            "tare_n_m": weights @ tare.torque_n_m,
            "torque_n_m": mean["torque_n_m"] - weights @ tare.torque_n_m,
            "torque_n_m_se": np.sqrt(error["torque_n_m"] ** 2 + weights**2 @ tare.torque_se_n_m**2),
            "torque_change_n_m": change("torque_n_m"),
            "oil_temperature_change_c": change("oil_temperature_c"),
        }
    )


def _judged(points: pd.DataFrame, settings: Mapping[str, Any]) -> pd.DataFrame:
    """Points with the names of the gates that refuse them."""
    limits = settings["gates"] | {"min_duration_s": settings["plateaus"]["min_duration_s"]}
    failed = pd.DataFrame({gate.name: gate.fails(points, limits) for gate in GATES})
    return points.assign(failed_gates=failed_gates.as_text(failed), accepted=~failed.any(axis=1))
