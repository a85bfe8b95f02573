"""Runs that repeat each other: copies, names given twice, conditions run twice, wrong labels.

A rule compares the accepted runs of a campaign in the order of their names. Where two of them can
both be right, the earlier is kept. Where only one can be right, none is.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.curation.gate import Finding
from oilfilm.curation.refusals import refusal
from oilfilm.curation.rig_kind import RigKind
from oilfilm.readers.base import Refusal
from oilfilm.settings.resolved import Settings
from oilfilm.units import FloatArray

# A run and what was found.
Case = tuple[str, Finding]

# Copies of one log in other formats differ by the rounding of their numbers, two runs by more.
_ROUNDING = 1e-4
# Fewer plateaus may agree by chance.
_PLATEAUS = 3


def repeated(
    points: pd.DataFrame, runs: pd.DataFrame, rule: str, kind: RigKind, settings: Settings
) -> list[Refusal]:
    """Refusals of accepted runs by one of the rules that compare runs.

    Args:
        points: Table of plateaus.
        runs: Table of runs.
        rule: One of `RULES`.
        kind: The kind of rig.
        settings: Settings of the run.
    """
    candidates = runs[runs["verdict"] == "accepted"].sort_values(["file", "run_id"])
    cases = RULES[rule](points, candidates, kind, settings)
    first = {run_id: finding for run_id, finding in reversed(list(cases))}
    return [refusal(rule, finding, kind, run_id) for run_id, finding in first.items()]


def _copies(
    points: pd.DataFrame, runs: pd.DataFrame, kind: RigKind, settings: Settings
) -> Iterator[Case]:
    """Copies of an earlier log, as a file or in another format."""
    for first, later in _same(runs, ["content_sha256"]):
        if first.file != later.file:
            yield (
                later.run_id,
                Finding(f"the log has the same content as {first.run_id}, which is kept"),
            )
    for first, later in _same_samples(points, runs, kind):
        if first.oil == later.oil:
            yield (
                later.run_id,
                Finding(f"the log has the same readings as {first.run_id}, which is kept"),
            )


def _conflicting_labels(
    points: pd.DataFrame, runs: pd.DataFrame, kind: RigKind, settings: Settings
) -> Iterator[Case]:
    """The same readings under the names of two oils."""
    for first, later in _same_samples(points, runs, kind):
        if first.oil != later.oil:
            for run, other in ((first, later), (later, first)):
                sentence = f"{other.run_id} has the same readings under the oil {other.oil!r}"
                yield run.run_id, Finding(f"{sentence}; one label is wrong")


def _repeated_labels(
    points: pd.DataFrame, runs: pd.DataFrame, kind: RigKind, settings: Settings
) -> Iterator[Case]:
    """The name of an earlier run."""
    for first, later in _same(runs, ["label"]):
        yield (
            later.run_id,
            Finding(f"the header gives the run the name that {first.run_id} has, which is kept"),
        )


def _conflicting_conditions(
    points: pd.DataFrame, runs: pd.DataFrame, kind: RigKind, settings: Settings
) -> Iterator[Case]:
    """The condition of another run and a curve that is not its."""
    allowed = settings.gates.repeat_difference_max
    for first, later in _same_condition(runs, settings):
        difference = _difference(points, first.run_id, later.run_id, settings)
        if difference > allowed:
            for run, other in ((first, later), (later, first)):
                sentence = (
                    f"{other.run_id} has the same oil and set points, but its traction differs by "
                    f"{difference:.0%} in the median; allowed {allowed:.0%}"
                )
                yield run.run_id, Finding(sentence)


def _conditions(
    points: pd.DataFrame, runs: pd.DataFrame, kind: RigKind, settings: Settings
) -> Iterator[Case]:
    """The condition of an earlier run."""
    for first, later in _same_condition(runs, settings):
        yield (
            later.run_id,
            Finding(f"the run has the oil and the set points of {first.run_id}, which is kept"),
        )


Rule = Callable[[pd.DataFrame, pd.DataFrame, RigKind, Settings], Iterator[Case]]
RULES: dict[str, Rule] = {
    "duplicate_log": _copies,
    "conflicting_labels": _conflicting_labels,
    "repeated_label": _repeated_labels,
    "conflicting_condition": _conflicting_conditions,
    "duplicate_condition": _conditions,
}


def _same(runs: pd.DataFrame, key: list[str]) -> Iterator[tuple[Any, Any]]:
    """The first run with some values of some columns and each later one with the same.

    Empty values are not compared.
    """
    known = runs[key].notna().all(axis=1) & (runs[key] != "").all(axis=1)
    for _, group in runs[known].groupby(key, sort=False):
        first, *others = group.itertuples()
        yield from ((first, later) for later in others)


def _same_samples(
    points: pd.DataFrame, runs: pd.DataFrame, kind: RigKind
) -> Iterator[tuple[Any, Any]]:
    """Pairs of runs whose plateaus lie in the same rows and agree in every mean."""
    named = {run.run_id: run for run in runs.itertuples()}
    alike: dict[tuple[int, ...], list[tuple[Any, FloatArray]]] = {}
    for run_id, plateaus in points[points["run_id"].isin(named)].groupby("run_id"):
        if len(plateaus) >= _PLATEAUS:
            rows = tuple(plateaus["first_row"])
            means = plateaus[list(kind.averaging.means)].to_numpy(float)
            alike.setdefault(rows, []).append((named[run_id], means))
    for group in alike.values():
        values = np.array([means for _, means in group])
        allowed = _ROUNDING * np.abs(values).max(axis=(0, 1))
        for index, (first, means) in enumerate(group):
            same = np.all(np.abs(values[index + 1 :] - means) <= allowed, axis=(1, 2))
            yield from ((first, group[index + 1 + later][0]) for later in np.flatnonzero(same))


def _same_condition(runs: pd.DataFrame, settings: Settings) -> Iterator[tuple[Any, Any]]:
    """Pairs of runs with the same oil, rig and set points, to within their rounding."""
    same = settings.same_set_point
    levels = {
        "load": _levels(np.log(runs["nominal_load_n"].to_numpy(float)), same.relative),
        "speed": _levels(
            np.log(runs["nominal_entrainment_speed_m_s"].to_numpy(float)), same.relative
        ),
        "temperature": _levels(
            runs["nominal_inlet_temperature_c"].to_numpy(float), same.temperature_c
        ),
    }
    yield from _same(runs.assign(**levels), ["oil", "rig", *levels])


def _levels(values: FloatArray, tolerance: float) -> FloatArray:
    """A number for each level: sorted values closer than the tolerance are one; NaN stays."""
    order = np.argsort(values)
    apart = np.diff(values[order], prepend=values[order[:1]]) > tolerance
    levels = np.empty(len(values))
    levels[order] = np.cumsum(apart)
    return np.where(np.isnan(values), np.nan, levels)


def _difference(points: pd.DataFrame, first: str, later: str, settings: Settings) -> float:
    """Median relative difference of two curves of traction over the slips that both have."""
    a, b = (
        points[(points["run_id"] == run_id) & points["accepted"]].sort_values("slide_roll_ratio")
        for run_id in (first, later)
    )
    slip, mu = (b[name].to_numpy(float) for name in ("slide_roll_ratio", "traction_coefficient"))
    other_slip, other = (
        a[name].to_numpy(float) for name in ("slide_roll_ratio", "traction_coefficient")
    )
    shared = (slip >= max(other_slip.min(), settings.gates.sign_slip_min)) & (
        slip <= other_slip.max()
    )
    if not shared.any():
        return 0.0
    expected = np.interp(slip[shared], other_slip, other)
    return float(np.median(np.abs(mu[shared] - expected) / np.abs(expected)))
