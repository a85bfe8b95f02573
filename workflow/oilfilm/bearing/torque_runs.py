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
from oilfilm.ingest import unpack
from oilfilm.readers.base import Reading, Refusal, refused_file
from oilfilm.readers.columns import Vocabulary
from oilfilm.readers.csv import TextRows, read_rows
from oilfilm.units import FloatArray

BoolArray = npt.NDArray[np.bool_]

VOCABULARY = Vocabulary(
    name="torque",
    quantities={
        "time": ("s",),
        "axial_load": ("N",),
        "inner_speed": ("rpm",),
        "oil_temperature": ("degC",),
        "outer_ring_temperature": ("degC",),
        "torque": ("N m",),
    },
    own_names={
        "time_s": ("time", "s"),
        "axial_load_n": ("axial_load", "N"),
        "inner_speed_rpm": ("inner_speed", "rpm"),
        "oil_temperature_c": ("oil_temperature", "degC"),
        "outer_ring_temperature_c": ("outer_ring_temperature", "degC"),
        "torque_n_m": ("torque", "N m"),
    },
    always=(
        "time",
        "axial_load",
        "inner_speed",
        "oil_temperature",
        "outer_ring_temperature",
        "torque",
    ),
    either=((),),
)
_HEADER_ADVICE = "data/raw/README.md describes torque logs."


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
        logs: Path of each log in its folder, and its bytes.
        config: The resolved configuration.

    Returns:
        The tables `torque_runs` and `quarantine`.
    """
    points: list[pd.DataFrame] = []
    refused: list[dict[str, Any]] = []
    for file, content in logs:
        found, refusals = _measure_log(file, content, config)
        points += [found] if found is not None else []
        about = {"campaign": config["campaign"]["name"], "file": file, "stage": "ingest"}
        refused += [about | asdict(refusal) for refusal in refusals]
    whole = pd.concat(points, ignore_index=True) if points else tables.empty("torque_runs")
    return (
        tables.conform(whole, "torque_runs", "torque logs"),
        tables.from_rows(refused, "quarantine"),
    )


def _measure_log(
    file: str, content: bytes, config: Mapping[str, Any]
) -> tuple[pd.DataFrame | None, list[Refusal]]:
    try:
        plain = unpack(content)
    except OSError as error:
        reason = f"the compressed file cannot be unpacked: {error}"
        return None, refused_file(0, "damaged_archive", reason, "Copy it again.").refusals
    log = read_rows(plain, file, config["campaign"]["torque"].get("columns", {}), VOCABULARY)
    if isinstance(log, Reading):
        return None, log.refusals
    problem = _header_problem(log.layout.keys, config) or _trouble(log)
    if problem is not None:
        return None, [*log.refusals, _refused_run(file, log, *problem)]
    tare = _tare(log, config["torque_logs"], config["curation"]["spikes"]["threshold"])
    if isinstance(tare, str):
        advice = "Let the bearing stand still, loaded, before and after the run."
        return None, [*log.refusals, _refused_run(file, log, "tare", tare, advice)]
    measured = _plateaus(log, tare, config)
    if measured.empty:
        reason = "no steady speed was found between the two tares"
        return None, [
            *log.refusals,
            _refused_run(file, log, "no_plateau", reason, "Hold each speed longer."),
        ]
    about = {
        "run_id": file,
        "oil": log.layout.keys["oil"],
        "bearing": config["campaign"]["torque"]["bearing"],
        "sha256": hashlib.sha256(content).hexdigest(),
    }
    return _judged(measured.assign(**about), config["torque_logs"]), log.refusals


def _refused_run(file: str, log: TextRows, rule: str, reason: str, advice: str) -> Refusal:
    rows = len(log.numbers)
    first, last = (int(log.numbers[0]), int(log.numbers[-1])) if rows else (0, 0)
    return Refusal(rule, reason, advice, file, first, last, rows)


def _header_problem(
    keys: Mapping[str, str], config: Mapping[str, Any]
) -> tuple[str, str, str] | None:
    oil, bearing = keys.get("oil"), config["campaign"]["torque"]["bearing"]
    if oil is None:
        return "header", "the header has no line `# oil: ...`", f"Add it. {_HEADER_ADVICE}"
    if oil not in config["oils"]:
        known = ", ".join(config["oils"])
        return (
            "unknown_oil",
            f"the header says oil {oil[:60]!r}; the campaign knows {known}",
            "Correct the header, or add the oil to the campaign file.",
        )
    if keys.get("bearing", bearing) != bearing:
        return (
            "other_bearing",
            f"the header says bearing {keys['bearing'][:60]!r}; the campaign's is {bearing!r}",
            "Correct the header, or put the log into a campaign of its own.",
        )
    if keys.get("simulated", "no") != "no" and config["campaign"]["data"] == "measured":
        return (
            "simulated_log",
            "the header says that the log is simulated; the campaign file says data: measured",
            "Take the log out, or say data: simulated in the campaign file.",
        )
    return None


def _trouble(log: TextRows) -> tuple[str, str, str] | None:
    if log.flaw:
        rule, _, reason = log.flaw.partition(": ")
        return rule, reason, "Repeat the run: its closing tare is missing."
    if not len(log.numbers):
        return "no_rows", "the log has no readable row of data", "Take it out, or export it again."
    if np.any(np.diff(log.values["time"]) <= 0):
        place = int(np.argmax(np.diff(log.values["time"]) <= 0))
        reason = f"time does not go on after row {log.numbers[place]}"
        return (
            "time_disorder",
            reason,
            "Check the logger's clock, and whether two logs were joined.",
        )
    return None


@dataclass(frozen=True)
class _Tare:
    """The torque sensor's output at rest, before and after; samples between the two."""

    time_s: FloatArray
    torque_n_m: FloatArray
    torque_se_n_m: FloatArray
    between: slice


def _tare(log: TextRows, settings: Mapping[str, Any], spike: float) -> _Tare | str:
    time, torque = log.values["time"], log.values["torque"]
    resting = np.abs(log.values["inner_speed"]) <= settings["tare"]["max_speed_rpm"]
    if resting.all():
        return "the bearing never turns"
    first = int(np.argmin(resting))
    last = len(resting) - int(np.argmin(resting[::-1]))
    phases = {"opening": (0, first), "closing": (last, len(resting))}
    interval = float(np.median(np.diff(time)))
    for name, (start, stop) in phases.items():
        if (stop - start) * interval < settings["tare"]["min_duration_s"]:
            return (
                f"{(stop - start) * interval:.2f} s of the {name} phase are at rest; expected "
                f"{settings['tare']['min_duration_s']:g} s or more below "
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


def _plateaus(log: TextRows, tare: _Tare, config: Mapping[str, Any]) -> pd.DataFrame:
    settings = config["torque_logs"]["plateaus"]
    values = {name: column[tare.between] for name, column in log.values.items()}
    rows, time = log.numbers[tare.between], values["time"]
    interval = float(np.median(np.diff(log.values["time"])))
    steps = find_steps(
        values["inner_speed"], interval, settings | {"min_step": settings["min_step_rpm"]}
    )
    starts, stops = settled_parts(len(time), steps, interval, settings)
    # the first level has had a step to settle from: that out of rest; the last ends in one
    starts[0] += round(settings["settle_s"] / interval)
    stops[-1] -= round(settings["guard_s"] / interval)
    kept = stops > starts
    starts, stops = starts[kept], stops[kept]
    if not len(starts):
        return pd.DataFrame()
    stretches, inside = statistics.cut(np.stack(list(values.values())), starts, stops)
    of_name = dict(zip(values, stretches, strict=True))
    wild = statistics.spikes(of_name["torque"], inside, config["curation"]["spikes"]["threshold"])
    steady = inside & ~wild
    early = statistics.first_part(steady, 1 / 2)
    late = steady & ~early
    mean = dict(zip(values, statistics.means(stretches, steady), strict=True))
    error = dict(zip(values, statistics.standard_errors(stretches, steady), strict=True))

    def change(name: str) -> FloatArray:
        return statistics.means(of_name[name], late) - statistics.means(of_name[name], early)

    place = (mean["time"] - tare.time_s[0]) / np.diff(tare.time_s)
    weights = np.stack([1 - place, place], axis=1)
    return pd.DataFrame(
        {
            "first_row": rows[starts],
            "last_row": rows[stops - 1],
            "n_samples": steady.sum(axis=1),
            "n_spikes": wild.sum(axis=1),
            "time_s": mean["time"],
            "duration_s": (stops - starts) * interval,
            "inner_speed_rpm": mean["inner_speed"],
            "axial_load_n": mean["axial_load"],
            "oil_temperature_c": mean["oil_temperature"],
            "outer_ring_temperature_c": mean["outer_ring_temperature"],
            "tare_n_m": weights @ tare.torque_n_m,
            "torque_n_m": mean["torque"] - weights @ tare.torque_n_m,
            "torque_n_m_se": np.sqrt(error["torque"] ** 2 + weights**2 @ tare.torque_se_n_m**2),
            "torque_change_n_m": change("torque"),
            "oil_temperature_change_c": change("oil_temperature"),
        }
    )


def _judged(points: pd.DataFrame, settings: Mapping[str, Any]) -> pd.DataFrame:
    """Points with the names of the gates that refuse them."""
    limits = settings["gates"] | {"min_duration_s": settings["plateaus"]["min_duration_s"]}
    failed = pd.DataFrame({gate.name: gate.fails(points, limits) for gate in GATES})
    names = np.array(failed.columns)
    reasons = pd.Series([";".join(names[row]) for row in failed.to_numpy()], dtype=str)
    return points.assign(reasons=reasons, accepted=reasons == "")[tables.columns("torque_runs")]
