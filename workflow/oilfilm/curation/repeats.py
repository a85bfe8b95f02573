"""Runs that repeat each other: copies, conditions run twice, wrong labels.

What one log cannot show, the others of its rig may: a channel that never moves.

A rule compares the accepted runs of a campaign with each other. Where several of them can be right,
the first by name is kept. Where two contradict each other, none is; of more, those that most of the
others contradict are refused.

Decides: when a run repeats an earlier one, and which of them is kept; warnings about a run beside
the others of its rig.
"""

from collections.abc import Iterator
from itertools import chain, combinations
from typing import Any

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from oilfilm.curation.coverage import SET_POINTS, with_levels
from oilfilm.curation.gate import fault
from oilfilm.curation.rig_kind import TRACTION, RigKind
from oilfilm.logs.base import Refusal
from oilfilm.settings.resolved import Settings

# Fewer plateaus may agree by chance.
_PLATEAUS = 3
# So many plateaus, apart by this share of their errors in the mean square, of slip and of mu: with
# load, speed and temperature as near as below, chances of 1e-6. Rounding moves the slip by more.
_PLATEAUS_OF_COPY, _NO_NOISE = 8, (0.6, 0.3)
# Copies are so near each other in load, speed and temperature, relative to the largest.
_NEAR = 5e-4
# An odd repeat is so many times as far from the others as these are from each other.
_ODD = 3
# So many runs of a rig tell what its channels do.
_FEWEST_RUNS = 4
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
    for case in _readings(points, left, kind):
        refused.setdefault(case.run_id, case)
    if kind.name == TRACTION and settings.campaign.repeated_conditions != "accept":
        left = left[~left["run_id"].isin(refused)]
        refused |= {case.run_id: case for case in _conditions(points, left, settings)}
    return list(refused.values())


def _readings(points: pd.DataFrame, runs: pd.DataFrame, kind: type[RigKind]) -> Iterator[Refusal]:
    """Copies of an earlier log, and the same readings under the names of two oils."""
    pairs = list(_same_readings(points, runs, kind))
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
    allowed, odd = settings.gates.repeat_difference_max, settings.gates.repeat_odd_min
    for names, apart in _compared_conditions(points, runs, settings):
        kept = []
        for run_id in names:
            others = [name for name in names if name != run_id]
            to_others = {name: apart[frozenset((run_id, name))] for name in others}
            mutual = [apart[frozenset(pair)] for pair in combinations(others, 2)]
            limit = max(odd, _ODD * max(mutual)) if mutual else allowed
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
    points: pd.DataFrame, runs: pd.DataFrame, kind: type[RigKind]
) -> Iterator[tuple[Any, Any]]:
    """Pairs of runs out of files of one content, or with plateaus of the same noise."""
    named: dict[str, Any] = {str(run.run_id): run for run in runs.itertuples()}
    # a file may hold several runs
    places = [f"in {run_id.removeprefix(run.file)}" for run_id, run in named.items()]
    for first, *others in _same(runs.assign(place=places), ["content_sha256", "place"]):
        yield from ((first, later) for later in others)
    if kind.name == TRACTION:
        for name, other in _same_noise(points[points["run_id"].isin(named)]):
            yield named[name], named[other]


def _same_noise(points: pd.DataFrame) -> Iterator[tuple[str, str]]:
    """Pairs of runs whose plateaus differ by far less than their own errors, whatever the rows.

    The same readings, cut off elsewhere or rounded, keep the errors of their means; other readings
    of the same condition have other ones. The last plateaus of both are compared, but for the very
    last: it ends where the log does, or in a step that is found to within a few rows.
    """
    means = ["slide_roll_ratio", "traction_coefficient"]
    errors = [f"{name}_se" for name in means]
    of_runs = points[(points[errors] > 0).all(axis=1)].groupby("run_id")
    counts = of_runs.size()
    names = counts.index[counts > _PLATEAUS_OF_COPY]
    last = of_runs.tail(_PLATEAUS_OF_COPY + 1)
    last = last.drop(of_runs.tail(1).index)
    last = last[last["run_id"].isin(names)]
    if len(names) < 2:
        return
    values, se, at = (
        last[columns].to_numpy(float).reshape(len(names), _PLATEAUS_OF_COPY, -1)
        for columns in (means, errors, ["load_n", "entrainment_speed_m_s", "inlet_temperature_c"])
    )
    near = np.nan_to_num(at[:, -_PLATEAUS:].reshape(len(names), -1))
    reach = _NEAR * np.abs(near).max(axis=0)
    scaled = near / np.where(reach > 0, reach, 1.0)
    for one, other in sorted(cKDTree(scaled).query_pairs(1.0, p=np.inf)):
        apart = values[one] - values[other]
        # the zero of the force may be that of other rows, and rounding moves the speeds
        apart -= np.median(apart, axis=0)
        relative = apart / np.hypot(se[one], se[other])
        if (np.sqrt(np.mean(relative**2, axis=0)) < _NO_NOISE).all():
            yield names[one], names[other]


def _difference(first: pd.DataFrame, later: pd.DataFrame, settings: Settings) -> float:
    """Median relative difference of two curves of traction over the slips that both have.

    Less twice the standard error of each difference, where it is known.
    """
    columns = ["slide_roll_ratio", "traction_coefficient", "traction_coefficient_se"]
    (slip, mu, se), (other_slip, other, other_se) = (
        curve.sort_values("slide_roll_ratio")[columns].to_numpy(float).T for curve in (later, first)
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
    for run_id, text in chain(
        _constant_channels(points, accepted), _of_rig(points, accepted["rig"], settings)
    ):
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
            if largest > full:
                about = dict(column=column, of=largest, full=full, key=key)
                doubts.append(fault("full_scale", **about).reason)
        yield from ((str(run_id), f"{each}; correct {name}.yaml") for each in doubts)


def _constant_channels(points: pd.DataFrame, runs: pd.DataFrame) -> Iterator[tuple[str, str]]:
    """A channel that is one number in all plateaus of a run, and moves in most other runs."""
    for column, name in (("load_n", "load"), ("inlet_temperature_c", "inlet temperature")):
        of_runs = points.groupby("run_id")[column].agg(["min", "max", "size"])
        judged = of_runs[of_runs["size"] >= _PLATEAUS]
        constant = judged["max"] - judged["min"] <= 1e-9 * judged["max"].abs()
        for _, of_rig in constant.groupby(runs["rig"].reindex(judged.index)):
            if len(of_rig) >= _FEWEST_RUNS and of_rig.mean() < 1 / 2:
                moving = dict(name=name, others=(~of_rig).sum(), runs=len(of_rig))
                for run_id in of_rig.index[of_rig]:
                    value = of_runs["min"].loc[run_id]
                    yield str(run_id), fault("constant_channel", value=value, **moving).reason
