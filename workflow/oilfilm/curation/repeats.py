"""Runs that repeat each other: copies, names given twice, conditions run twice, wrong labels.

What one log cannot show, the others of its rig may: a channel that never moves.

A rule compares the accepted runs of a campaign with each other. Where several of them can be right,
the first by name is kept. Where two contradict each other, none is; of more, those that most of the
others contradict are refused.

Decides: when a run repeats an earlier one, and which of them is kept; warnings about a run beside
the others of its rig.
"""

from collections.abc import Callable, Iterator
from itertools import chain, combinations, pairwise
from typing import Any

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from oilfilm.curation.coverage import SET_POINTS, with_levels
from oilfilm.curation.gate import TRACTION, Finding
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.verdicts import refusal
from oilfilm.logs.base import Refusal
from oilfilm.settings.resolved import Settings
from oilfilm.units import FloatArray

# A run and what was found.
Case = tuple[str, Finding]

# Copies of one log in other formats differ by the rounding of their numbers, two runs by more.
_ROUNDING = 1e-4
# Fewer plateaus may agree by chance.
_PLATEAUS = 3
# So many plateaus, apart by this share of their errors in the mean square: chances of 1e-6 in two
# quantities.
_PLATEAUS_OF_COPY, _NO_NOISE = 8, 0.3
# Copies are so near each other in load, speed and temperature, relative to the largest.
_NEAR = 5e-4
# An odd repeat is so many times as far from the others as these are from each other.
_ODD = 3
# So many runs of a rig tell what its channels do.
_FEWEST_RUNS = 4


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
    accepted = runs["verdict"] == "accepted"
    if accepted.sum() < 2:
        return []  # a repeat needs two accepted runs
    candidates = runs[accepted].sort_values(["file", "run_id"])
    cases = RULES[rule](points, candidates, kind, settings)
    first = {run_id: finding for run_id, finding in reversed(list(cases))}
    return [refusal(rule, finding, kind, run_id) for run_id, finding in first.items()]


def _copies(
    points: pd.DataFrame, runs: pd.DataFrame, kind: RigKind, settings: Settings
) -> Iterator[Case]:
    """Copies of an earlier log, as a file or in another format."""
    for first, later in _same_readings(points, runs, kind):
        if first.oil == later.oil:
            sentence = f"the log has the same readings as {first.run_id}, which is kept"
            yield later.run_id, Finding(sentence)


def _conflicting_labels(
    points: pd.DataFrame, runs: pd.DataFrame, kind: RigKind, settings: Settings
) -> Iterator[Case]:
    """The same readings under the names of two oils."""
    for first, later in _same_readings(points, runs, kind):
        if first.oil != later.oil:
            for run, other in ((first, later), (later, first)):
                sentence = f"{other.run_id} has the same readings under the oil {other.oil!r}"
                yield run.run_id, Finding(f"{sentence}; one label is wrong")


def _repeated_labels(
    points: pd.DataFrame, runs: pd.DataFrame, kind: RigKind, settings: Settings
) -> Iterator[Case]:
    """The name of an earlier run."""
    for first, *others in _same(runs, ["label"]):
        sentence = f"the header gives the run the name that {first.run_id} has, which is kept"
        yield from ((later.run_id, Finding(sentence)) for later in others)


def _conflicting_conditions(
    points: pd.DataFrame, runs: pd.DataFrame, kind: RigKind, settings: Settings
) -> Iterator[Case]:
    """The condition of another run and a curve that is not its.

    Two runs contradict each other beyond `repeat_difference_max`. Of three or more, one that is off
    by less is odd where the others agree far better with each other than with it.
    """
    allowed, odd = settings.gates.repeat_difference_max, settings.gates.repeat_odd_min
    for names, apart in _compared_conditions(points, runs, settings):
        for run_id in names:
            others = [name for name in names if name != run_id]
            to_others = {name: apart[frozenset((run_id, name))] for name in others}
            mutual = [apart[frozenset(pair)] for pair in combinations(others, 2)]
            limit = max(odd, _ODD * max(mutual)) if mutual else allowed
            against = [name for name, difference in to_others.items() if difference > allowed]
            if len(against) <= len(others) / 2:
                against = [name for name, difference in to_others.items() if difference > limit]
                if len(against) < len(others):
                    continue
            of_others = f" (and {len(against) - 1} more)" if len(against) > 1 else ""
            agree = f"; the others agree within {max(mutual):.1%}" if mutual else ""
            sentence = (
                f"{against[0]}{of_others} has the same oil and set points, but its traction "
                f"differs by {to_others[against[0]]:.1%} in the median, beyond the errors; "
                f"allowed {min(limit, allowed):.0%}{agree}"
            )
            yield run_id, Finding(sentence)


def _conditions(
    points: pd.DataFrame, runs: pd.DataFrame, kind: RigKind, settings: Settings
) -> Iterator[Case]:
    """The condition of an earlier run."""
    for (first, *others), apart in _compared_conditions(points, runs, settings):
        for later in others:
            sentence = (
                f"the run has the oil and the set points of {first}, which is kept; their traction "
                f"differs by {apart[frozenset((first, later))]:.1%} in the median beyond its errors"
            )
            yield later, Finding(sentence)


def _compared_conditions(
    points: pd.DataFrame, runs: pd.DataFrame, settings: Settings
) -> Iterator[tuple[list[str], dict[frozenset[str], float]]]:
    """Runs of one condition, and how far the curves of each two of them are apart."""
    groups = [[run.run_id for run in group] for group in _same_condition(runs, settings)]
    compared = points[points["accepted"] & points["run_id"].isin(list(chain.from_iterable(groups)))]
    curves = dict(list(compared.groupby("run_id")))
    for names in groups:
        yield (
            names,
            {
                frozenset((one, other)): _difference(curves[one], curves[other], settings)
                for one, other in combinations(names, 2)
            },
        )


Rule = Callable[[pd.DataFrame, pd.DataFrame, RigKind, Settings], Iterator[Case]]
RULES: dict[str, Rule] = {
    "duplicate_log": _copies,
    "conflicting_labels": _conflicting_labels,
    "repeated_label": _repeated_labels,
    "conflicting_condition": _conflicting_conditions,
    "duplicate_condition": _conditions,
}


def _same(runs: pd.DataFrame, key: list[str]) -> Iterator[list[Any]]:
    """Runs with the same values of some columns, two or more; empty values are not compared."""
    known = runs[runs[key].notna().all(axis=1) & (runs[key] != "").all(axis=1)]
    # a group takes its time, and hardly any run has a second one in its own
    for _, group in known[known.duplicated(key, keep=False)].groupby(key, sort=False):
        yield list(group.itertuples())


def _same_readings(
    points: pd.DataFrame, runs: pd.DataFrame, kind: RigKind
) -> Iterator[tuple[Any, Any]]:
    """Pairs of runs out of files of one content, or with plateaus that agree in rows and means."""
    places = [_place(run) for run in runs.itertuples()]
    for first, *others in _same(runs.assign(place=places), ["content_sha256", "place"]):
        yield from ((first, later) for later in others)
    named = {run.run_id: run for run in runs.itertuples()}
    alike: dict[tuple[int, ...], list[tuple[Any, FloatArray]]] = {}
    for run_id, rows, means in _plateaus_by_run(points, kind):
        if run_id in named and len(rows) >= _PLATEAUS:
            alike.setdefault(rows, []).append((named[run_id], means))
    for group in alike.values():
        for first, later in _equal_pairs(np.array([means for _, means in group])):
            yield group[first][0], group[later][0]
    if kind.name == TRACTION:
        for first_id, later_id in _same_noise(points[points["run_id"].isin(named)]):
            yield named[first_id], named[later_id]


def _same_noise(points: pd.DataFrame) -> Iterator[tuple[str, str]]:
    """Pairs of runs whose plateaus differ by far less than their own errors, whatever the rows.

    The same readings, cut off elsewhere or rounded, keep the errors of their means; other readings
    of the same condition have other ones. The last plateaus of both are compared.
    """
    means = ["slide_roll_ratio", "traction_coefficient"]
    known = points[(points[[f"{name}_se" for name in means]] > 0).all(axis=1)]
    counts = known.groupby("run_id").size()
    names = counts.index[counts >= _PLATEAUS_OF_COPY]
    last = known[known["run_id"].isin(names)].groupby("run_id").tail(_PLATEAUS_OF_COPY)
    if len(names) < 2:
        return

    def of_runs(columns: list[str]) -> FloatArray:
        return last[columns].to_numpy(float).reshape(len(names), _PLATEAUS_OF_COPY, len(columns))

    conditions = of_runs(["load_n", "entrainment_speed_m_s", "inlet_temperature_c"])
    near = conditions[:, -_PLATEAUS:].reshape(len(names), -1)
    reach = np.maximum(_NEAR * np.nanmax(np.abs(near), axis=0), 1e-30)
    pairs = cKDTree(np.nan_to_num(near) / reach).query_pairs(1.0, p=np.inf, output_type="ndarray")
    values, se = of_runs(means), of_runs([f"{name}_se" for name in means])
    for one, other in pairs[np.lexsort(pairs.T[::-1])]:
        apart = values[one] - values[other]
        # the zero of the force may be that of other rows
        apart[:, 1] -= np.median(apart[:, 1])
        if (
            np.sqrt(np.mean((apart / np.hypot(se[one], se[other])) ** 2, axis=0)) < _NO_NOISE
        ).all():
            yield str(names[one]), str(names[other])


def _equal_pairs(values: FloatArray) -> list[tuple[int, int]]:
    """Pairs of runs whose means agree to within rounding, in the order of the runs.

    Args:
        values: Means of each run, shape (runs, plateaus, means).
    """
    unknown = np.isnan(values)
    values = np.where(unknown, 0.0, values)
    largest = np.abs(values).max(axis=1)
    reach = _ROUNDING * largest.max(axis=0)
    scaled = (values / np.where(reach > 0, reach, 1.0)).reshape(len(values), -1)
    # a little more than the reach, which rounding must not cut
    near = cKDTree(scaled).query_pairs(1.01, p=np.inf, output_type="ndarray")
    one, other = near[np.lexsort(near.T[::-1])].T
    allowed = _ROUNDING * np.maximum(largest[one], largest[other])[:, np.newaxis]
    same = (np.abs(values[one] - values[other]) <= allowed) & (unknown[one] == unknown[other])
    equal = same.all(axis=(1, 2))
    return list(zip(one[equal].tolist(), other[equal].tolist(), strict=True))


def _plateaus_by_run(
    points: pd.DataFrame, kind: RigKind
) -> Iterator[tuple[str, tuple[int, ...], FloatArray]]:
    """Each run with the first rows and the means of its plateaus, sorted by name.

    Arrays are cut, because a table per run takes far longer.
    """
    codes, names = pd.factorize(points["run_id"], sort=True)
    order = np.argsort(codes, kind="stable")
    first_rows = points["first_row"].to_numpy()[order].tolist()
    means = points[list(kind.averaging.means)].to_numpy(float)[order]
    edges = np.searchsorted(codes[order], np.arange(len(names) + 1)).tolist()
    for name, (start, stop) in zip(names, pairwise(edges), strict=True):
        yield str(name), tuple(first_rows[start:stop]), means[start:stop]


def _place(run: Any) -> str:
    """Where a run is in its file, which may hold several."""
    return f"in {run.run_id.removeprefix(run.file)}"


def _same_condition(runs: pd.DataFrame, settings: Settings) -> Iterator[list[Any]]:
    """Runs with the same oil, rig and set points, to within their rounding.

    A load counts by the pressure that it makes, where the rig's contact is known: a pressure that
    is rounded by 0.5 % is a load that is off by 1.5 %.
    """
    noted = with_levels(runs, settings)
    pressure, load, *_ = SET_POINTS
    noted = noted[noted[[pressure, load]].notna().any(axis=1)]
    # one of the two is unknown
    yield from _same(noted.fillna({pressure: -1, load: -1}), ["oil", "rig", *SET_POINTS])


def _difference(first: pd.DataFrame, later: pd.DataFrame, settings: Settings) -> float:
    """Median relative difference of two curves of traction over the slips that both have.

    Less twice the standard error of each difference, where it is known.
    """
    a, b = (curve.sort_values("slide_roll_ratio") for curve in (first, later))
    columns = ("slide_roll_ratio", "traction_coefficient", "traction_coefficient_se")
    slip, mu, error = (b[name].to_numpy(float) for name in columns)
    other_slip, other, other_error = (a[name].to_numpy(float) for name in columns)
    shared = (slip >= max(other_slip.min(), settings.gates.sign_slip_min)) & (
        slip <= other_slip.max()
    )
    if not shared.any():
        return 0.0
    expected = np.interp(slip[shared], other_slip, other)
    noise = 2 * np.hypot(error[shared], np.interp(slip[shared], other_slip, other_error))
    beyond = np.abs(mu[shared] - expected) - np.nan_to_num(noise)
    size = (np.abs(mu[shared]) + np.abs(expected)) / 2
    return float(np.median(np.maximum(beyond, 0.0) / size))


def with_campaign_warnings(runs: pd.DataFrame, points: pd.DataFrame, kind: RigKind) -> pd.DataFrame:
    """Runs with warnings that only the other runs of their rig can give."""
    if kind.name != TRACTION:
        return runs
    accepted = runs[runs["verdict"] == "accepted"].set_index("run_id")
    own = points[points["run_id"].isin(accepted.index)]
    found = {run_id: [text] for run_id, text in accepted["warning"].items() if text}
    for run_id, text in _constant_channels(own, accepted):
        found.setdefault(run_id, []).append(text)
    texts = {run_id: "; ".join(each) for run_id, each in found.items()}
    warnings = [texts.get(run_id, "") for run_id in runs["run_id"]]
    return runs.assign(warning=pd.Series(warnings, runs.index, dtype="str"))


def _constant_channels(points: pd.DataFrame, runs: pd.DataFrame) -> Iterator[tuple[str, str]]:
    """A channel that is one number in all plateaus of a run, and moves in most other runs."""
    for column, name in (("load_n", "load"), ("inlet_temperature_c", "inlet temperature")):
        of_runs = points.groupby("run_id")[column].agg(["min", "max", "size"])
        judged = of_runs[of_runs["size"] >= _PLATEAUS]
        constant = judged["max"] - judged["min"] <= 1e-9 * judged["max"].abs()
        for _, of_rig in constant.groupby(runs["rig"].reindex(judged.index)):
            if len(of_rig) >= _FEWEST_RUNS and of_rig.mean() < 1 / 2:
                for run_id in of_rig.index[of_rig]:
                    moving, value = (~of_rig).sum(), of_runs["min"].loc[run_id]
                    yield (
                        str(run_id),
                        f"constant_channel: the {name} is {value:g} in the whole run, but moves in "
                        f"{moving} of {len(of_rig)} runs of its rig; it may copy its set point",
                    )
